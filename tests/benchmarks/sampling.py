"""What samples buy where lamps have a size: ``python -m tests.benchmarks.sampling [--plot sampling.png]``.

One scene (three balls on a floor, a round lamp, a sun, an area light), rendered with more and more samples a pixel, in
every pixel and only where the first ones differ. Errors are CIE Delta E 2000 against a render of many samples; costs
are rays, which no load of the machine disturbs. The same with all pixels lit from the same points of the lamps shows
what it is for that neighbours have points of their own: pixel by pixel it changes little, but what a viewer sees from
afar, the mean of four by four pixels, is nearer.
"""

import argparse
import sys
from dataclasses import replace
from unittest import mock

import numpy as np

from spectral_core.estimate import colour_error
from spectral_core.library import illuminant
from spectral_core.lights import AreaLight
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings
from tests.render.render_scenes import still_life

WIDTH, HEIGHT = 192, 128
REFERENCE_SAMPLES = 400


def lit_softly():
    scene = still_life()
    key, sun, _ = scene.lights
    panel = AreaLight((-2.0, -3.0, 3.0), (0.7, 0.3, 0.2), (0.0, 0.4, -0.5), 150.0, illuminant("D65"), name="panel")
    return replace(scene, lights=(replace(key, radius=0.3), replace(sun, angle=0.05), panel))


def from_afar(image):
    """Means of four by four pixels."""
    return image.reshape(HEIGHT // 4, 4, WIDTH // 4, 4, 3).mean(axis=(1, 3))


def measure(scene, settings, reference):
    made = render(scene, settings)
    statistics = made.statistics
    rays = statistics.camera_rays + statistics.shadow_rays
    image = made.tristimulus()
    near = colour_error(image, reference, settings.observer)
    far = colour_error(from_afar(image), from_afar(reference), settings.observer)
    return rays / (WIDTH * HEIGHT), near.mean, near.percentile_95, far.mean


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plot", help="file to draw the table into")
    parser.add_argument("--most", type=int, default=64, help="samples of the last row")
    arguments = parser.parse_args()
    scene, base = lit_softly(), RenderSettings(WIDTH, HEIGHT)
    reference = render(scene, replace(base, samples=REFERENCE_SAMPLES, seed=1)).tristimulus()
    print(f"{WIDTH} x {HEIGHT}, against {REFERENCE_SAMPLES} samples")
    print("rays a pixel; Delta E 2000: mean, 95 %, and the mean of 4 x 4 pixels taken together")
    print(f"{'samples':>8}{'every pixel':>32}{'where the first differ':>32}{'the same points for all':>32}")
    curves = {"every pixel": [], "where the first differ": [], "the same points for all": []}
    samples = 1
    while samples <= arguments.most:
        settings = replace(base, samples=samples)
        rows = [measure(scene, settings, reference)]
        adaptive = replace(settings, adaptive_threshold=1.0, min_samples=max(4, samples // 8))
        rows.append(measure(scene, adaptive, reference) if samples > 4 else None)
        with mock.patch("spectral_core.job.interleaving", return_value=1):
            rows.append(measure(scene, settings, reference))
        line = f"{samples:8d}"
        for curve, row in zip(curves.values(), rows, strict=True):
            if row is None:
                line += f"{'':32}"
                continue
            rays, mean, high, far = row
            curve.append((rays, mean))
            line += f"{rays:11.0f}{mean:7.2f}{high:7.2f}{far:7.2f}"
        print(line, flush=True)
        samples *= 4
    if arguments.plot:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7, 4.5), layout="constrained")
        axes = figure.subplots()
        for name, curve in curves.items():
            rays, error = np.array(curve).T
            axes.loglog(rays, error, "o-", label=name)
        axes.set(xlabel="rays a pixel", ylabel="mean Delta E 2000")
        axes.legend()
        figure.savefig(arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
