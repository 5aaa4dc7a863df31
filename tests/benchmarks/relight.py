"""Relighting against rendering, and the film's memory: ``python -m tests.benchmarks.relight``.

1920x1080, three lamps, ten materials. Wall-clock time; the film is asked for new colours as the command line and the
panel ask for them.
"""

import resource
import sys
import time

import numpy as np

from spectral_core.library import illuminant
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings
from tests.benchmarks.cost_scene import seconds_of, ten_balls

WIDTH, HEIGHT = 1920, 1080


def main():
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    settings = RenderSettings(WIDTH, HEIGHT, samples=samples)
    start = time.perf_counter()
    made = render(ten_balls(), settings)
    rendered = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    spectra = made.spectra.with_light("lamp 1", illuminant=illuminant("HP1"))
    relit = made.relit(spectra)
    seconds = seconds_of(relit.tristimulus, time.perf_counter, 7)
    fresh = render(ten_balls(("HP1", "FL11", "A")), settings).tristimulus()
    difference = np.abs(relit.tristimulus() - fresh).max() / fresh.max()
    print(f"{WIDTH} x {HEIGHT}, {samples} samples, 3 lamps, 10 materials")
    print(f"  render                  {rendered:8.2f} s")
    print(f"  relight                 {seconds:8.3f} s   1/{rendered / seconds:.0f} of the render")
    print(f"  relit against fresh     {difference:8.1e}   of the brightest pixel")
    print(f"  film                    {made.film.nbytes / 2**20:8.1f} MiB, {len(made.film.terms)} terms")
    print(f"  peak memory of the run  {peak:8.0f} MiB")


if __name__ == "__main__":
    main()
