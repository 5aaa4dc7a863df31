"""How the cost of visibility grows: ``python -m tests.benchmarks.growth [--plot growth.png]``.

One table each for pixels, lights, samples and triangles; one thread, medians of three, of processor time. A picture is
what one sample of every pixel costs: primary hits and the shadows of the lights, from closed parts to verdicts. Slopes
are those of log time over log size between the neighbouring rows: 1 is linear. With ``--plot``, a figure (matplotlib).
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys

import numpy as np

from spectral_core.tracing import Acceleration, Geometry, Mesh, offset_origins
from tests.benchmarks.scenes import looking, placed, scene, sheet, smoothed
from tests.benchmarks.tracing import median_seconds, peak_megabytes
from tests.render.tracing_meshes import icosphere


def picture(geometry, camera, lights, width, height, offsets=((0.5, 0.5),)):
    """See and light every pixel, in bands of rows of about a million pixels."""
    acceleration = Acceleration(geometry)
    places = geometry.recentred(lights)
    step = max(2**20 // width, 1)
    for offset in offsets:
        view = acceleration.primary_view(camera, width, height, offset)
        for row in range(0, height, step):
            hits = view.hits((row, min(row + step, height)))
            seen = np.flatnonzero(hits.hit)
            own, u, v = hits.triangle[seen], hits.u[seen], hits.v[seen]
            points, flat = geometry.points(own, u, v), geometry.geometric_normals[own]
            towards_eye = geometry.recentred(camera.position) - points
            for place in places:
                away = place - points
                lit_side = np.einsum("ij,ij->i", flat, away) * np.einsum("ij,ij->i", flat, towards_eye) > 0.0
                lifted = offset_origins(points, flat, away, geometry.radius)[lit_side]
                acceleration.light_view(place, camera=camera, keep=True).occluded(lifted, own[lit_side])


def balls(triangles):
    """Twelve spheres on a ground, about so many triangles in all."""
    subdivisions = round(np.log(triangles / 240) / np.log(4))
    ball = smoothed(*icosphere(subdivisions))
    count = max(round(triangles / len(ball.triangles)), 1)
    places = [(2.3 * (k % 4 - 1.5), 2.4 * (k // 4 % 3 - 1), 1.01 + 2.02 * (k // 12)) for k in range(count)]
    return Geometry.from_instances(
        [placed(ball, 0.3 * k, 1.0, place) for k, place in enumerate(places)] + [placed(Mesh(*sheet(8, 12.0)))]
    )


def tables():
    """Pairs (name of what grows, rows of (size, seconds)); seconds of a whole picture."""
    base = scene("terrain")
    geometry, camera = base.geometry, base.camera

    def timed(*arguments, **keywords):
        return median_seconds(lambda: picture(*arguments, **keywords), 3)

    sizes = [(320, 180), (640, 360), (1280, 720), (2560, 1440)]
    yield "pixels", [(w * h, timed(geometry, camera, base.lights[:1], w, h)) for w, h in sizes]
    lights = np.concatenate(
        [base.lights + shift for shift in np.array([(0, 0, 0), (0.5, 0.5, 1.0), (-1.0, 0.3, 2.0)])]
    )[:8]
    yield "lights", [(n, timed(geometry, camera, lights[:n], 640, 360)) for n in (1, 2, 4, 8)]
    offsets = [(0.1 + 0.1 * k, 0.9 - 0.1 * k) for k in range(8)]
    yield (
        "samples",
        [(n, timed(geometry, camera, base.lights[:1], 640, 360, offsets=offsets[:n])) for n in (1, 2, 4, 8)],
    )
    view = looking((2.0, -10.0, 5.5), (0.0, 0.0, 0.8))
    rows = []
    for wanted in (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000):
        many = balls(wanted)
        rows.append((many.triangle_count, timed(many, view, np.array([(6.0, -6.0, 9.0)]), 1280, 720)))
    yield "triangles", rows


def draw(results, path):
    """Time against size, one panel a table."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 6), layout="constrained")
    for axes, (name, rows) in zip(figure.subplots(2, 2).ravel(), results, strict=True):
        size, seconds = np.array(rows).T
        axes.loglog(size, seconds, "o-", label="measured")
        axes.loglog(size, seconds[-1] * size / size[-1], ":", color="grey", label="in proportion")
        axes.set_xticks(
            size, [f"{n / 1e6:.1f} M" if n > 9e5 else f"{n / 1e3:.0f} k" if n > 999 else f"{n:g}" for n in size]
        )
        axes.set_yticks([0.01, 0.03, 0.1, 0.3, 1.0, 3.0], ["0.01", "0.03", "0.1", "0.3", "1", "3"])
        axes.minorticks_off()
        axes.set(xlabel=name, ylabel="seconds", ylim=(0.008, 4.0))
        axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plot", help="file to draw the tables into")
    arguments = parser.parse_args()
    results = []
    case = scene("spheres")
    before = peak_megabytes()
    picture(case.geometry, case.camera, case.lights, 1920, 1080)
    print(
        f"peak memory of {case.geometry.triangle_count} triangles at 1920x1080 with three lights:"
        f" {peak_megabytes():.0f} MB, of which {before:.0f} MB to model them"
    )
    del case
    for name, rows in tables():
        results.append((name, rows))
        print(f"{name:>10}{'seconds':>10}{'slope':>8}")
        for k, (size, seconds) in enumerate(rows):
            slope = ""
            if k:
                slope = f"{np.log(seconds / rows[k - 1][1]) / np.log(size / rows[k - 1][0]):8.2f}"
            print(f"{size:10d}{seconds:10.3f}{slope}", flush=True)
    if arguments.plot:
        draw(results, arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
