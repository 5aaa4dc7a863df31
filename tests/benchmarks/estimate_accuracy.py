"""How good the estimate of error and time is: ``python -m tests.benchmarks.estimate_accuracy [FILE.blend ...]``.

Each scene is estimated, rendered as asked, and rendered as the reference. The scenes are the .blend files that are
named (those of sample_blends/ when none is, where Blender is a Python module), and three random ones. Processor time on
one thread, so that other programs of the machine do not count.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys
import time
from pathlib import Path

from spectral_core.development import Development
from spectral_core.estimate import colour_error, estimate, reference_settings
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings
from tests.benchmarks.cost_scene import random_scene

SAMPLES = Path(__file__).parents[2] / "sample_blends"


def scenes(files):
    for seed in (1, 2, 3):
        yield f"random {seed}", random_scene(seed), RenderSettings(960, 540, samples=4), Development()
    for file in files:
        from dichromatic_addon import cli_scene

        arguments = argparse.Namespace(blend=file, frame=None, size=None, samples=None, layer=None)
        with cli_scene.opened_scene(arguments) as (scene, settings, development):
            yield file.stem, scene, settings, development


def main():
    time.perf_counter = time.process_time  # what statistics and estimate read
    files = [Path(name) for name in sys.argv[1:]] or sorted(SAMPLES.glob("*.blend"))
    print("scene           true dE  estimate  ratio   true s  estimate  ratio   spent")
    for name, scene, settings, development in scenes(files):
        found = estimate(scene, settings, development)
        made = render(scene, settings)
        reference = render(scene, reference_settings(settings))
        true = colour_error(made.tristimulus(), reference.tristimulus(), settings.observer, development).mean
        seconds = made.statistics.seconds["total"]
        error = found.error.mean
        print(
            f"{name:<14} {true:8.4f} {error:9.4f} {error / true:6.2f} {seconds:8.2f} {found.seconds:9.2f} "
            f"{found.seconds / seconds:6.2f} {found.spent:7.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
