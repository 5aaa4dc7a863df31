"""Whole renders beside Cycles: ``python -m tests.benchmarks.cycles [FILE.blend ...] [--repeats 5]``.

Both engines render the same .blend with the same lamps at 1280x720 through ``bpy.ops.render.render``: one sample and
four, without bounces, denoising or adaptive sampling, on the processor. Cycles shows the RGB look-alikes that the
materials' nodes carry for other engines. Every render has a process of its own, so that neither engine finds anything
warm; its time runs from the call to its return: evaluation and export of the scene, building, rendering, and the
picture in Blender's hands. Starting Blender and opening the file are left out. The engines take turns.

The two do not do the same work for a sample: Cycles lights it with one lamp, drawn at random, and its picture is
speckled; here each sample is lit by all lamps.

The first figure is the time that passed, the second what all threads of the process spent; medians.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
WIDTH, HEIGHT = 1280, 720
ENGINES = ("DICHROMATIC", "CYCLES")
BOUNCES = ("max", "diffuse", "glossy", "transmission", "volume")
RESULT = "seconds of one render: "


def prepare(scene, engine, samples, threads):
    """Ask both engines for the same; False where Cycles is not there."""
    render = scene.render
    try:
        render.engine = engine
    except TypeError:
        return False
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    render.threads_mode, render.threads = "FIXED", threads
    scene.dichromatic.samples, scene.dichromatic.max_bounces = samples, 0
    if engine == "CYCLES":
        cycles = scene.cycles
        cycles.device = "CPU"
        cycles.samples = samples
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        for kind in BOUNCES:
            setattr(cycles, f"{kind}_bounces", 0)
    return True


def render_once(file, engine, samples, threads):
    """Render in this process, and print the times as the last line."""
    import bpy

    import dichromatic_addon

    dichromatic_addon.register()
    try:
        bpy.ops.wm.open_mainfile(filepath=str(file))
        if not prepare(bpy.context.scene, engine, samples, threads):
            print(RESULT + json.dumps(None))
            return
        passed, spent = time.perf_counter(), time.process_time()
        bpy.ops.render.render()
        print(RESULT + json.dumps([time.perf_counter() - passed, time.process_time() - spent]))
    finally:
        dichromatic_addon.unregister()  # an engine that is still registered at the end hangs some versions of Blender


def measured(file, engine, samples, threads):
    """Times of one render in a new process, (passed, spent), or None where the engine is not there."""
    # numpy's own threads would come on top of those that were asked for.
    environment = dict(os.environ, OPENBLAS_NUM_THREADS="1")
    command = [sys.executable, "-m", "tests.benchmarks.cycles", "--once", engine, str(samples), str(threads), str(file)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith(RESULT)]
    if done.returncode or not lines:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return json.loads(lines[-1].removeprefix(RESULT))


def row(file, samples, threads, repeats):
    """Median times of both engines, or None where Cycles is not there."""
    taken = {engine: [] for engine in ENGINES}
    for _ in range(repeats):
        for engine in ENGINES:
            times = measured(file, engine, samples, threads)
            if times is None:
                return None
            taken[engine].append(times)
    return [tuple(statistics.median(column) for column in zip(*taken[engine], strict=True)) for engine in ENGINES]


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.cycles")
    parser.add_argument("files", nargs="*", type=Path, default=sorted((ROOT / "sample_blends").glob("*.blend")))
    parser.add_argument("--samples", nargs="+", type=int, default=[1, 4])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--once", nargs=3, metavar=("ENGINE", "SAMPLES", "THREADS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.once:
        engine, samples, threads = options.once
        render_once(options.files[0].resolve(), engine, int(samples), int(threads))
        return
    print(
        f"one render through bpy.ops.render.render, {WIDTH} x {HEIGHT}, no bounces; seconds passed (spent by all "
        f"threads), medians of {options.repeats}"
    )
    print("| file | samples | threads | Dichromatic | Cycles | ratio |")
    print("| --- | --- | --- | --- | --- | --- |")
    for file in options.files:
        for threads in options.threads:
            for samples in options.samples:
                medians = row(file, samples, threads, options.repeats)
                if medians is None:
                    print("this bpy has no Cycles: skipped")
                    return
                (ours, our_work), (theirs, their_work) = medians
                print(
                    f"| {file.stem} | {samples} | {threads} | {ours:.2f} ({our_work:.2f}) | {theirs:.2f} "
                    f"({their_work:.2f}) | {ours / theirs:.2f} ({our_work / their_work:.2f}) |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
