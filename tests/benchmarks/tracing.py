"""Rays a second of every kind, beside Embree's on the same rays: ``python -m tests.benchmarks.tracing``.

One thread; medians of five, of processor time, which other programs disturb least. Embree (package embreex, an extra)
is optional: without it the ratios are left out. Rates are of whole calls: for primary rays that is from a camera to
triangle, barycentric coordinates and distance of every pixel, projection included; for shadows from a light and points
to verdicts, sorting included.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

from spectral_core.tracing import Bvh, LightView, offset_origins, primary_hits
from tests.benchmarks.scenes import SCENES, BenchmarkScene, scene

WIDTH, HEIGHT = 1280, 720
REPEATS = 5


def median_seconds(call: Callable[[], object], repeats: int) -> float:
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        taken.append(time.process_time() - start)
    return statistics.median(taken)


class Embree:
    """Embree 4 over the same triangles, in the same coordinates."""

    def __init__(self, corners: np.ndarray) -> None:
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh

        self._scene = rtcore_scene.EmbreeScene()
        TriangleMesh(self._scene, corners.astype(np.float32))
        self.closest(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # builds its tree

    def closest(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Triangle numbers and distances, with u and v, as ours gives them."""
        return self._scene.run(origins, directions, output=True)["primID"].astype(np.int64)

    def occluded(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return self._scene.run(origins, directions, dists=np.ones(len(origins), np.float32), query="OCCLUDED") == 0


def embree_or_none(corners: np.ndarray) -> Embree | None:
    try:
        return Embree(corners)
    except ImportError:
        return None


def mirrored(geometry, triangle, u, v, directions):
    """Origins and directions of the rays that hits reflect."""
    points = geometry.points(triangle, u, v)
    normal, flat, _ = geometry.shading(triangle, u, v)
    flat = -flat * np.sign(np.einsum("ij,ij->i", flat, directions))[:, None]
    normal = normal * np.sign(np.einsum("ij,ij->i", normal, flat))[:, None]

    def reflect(about):
        return directions - 2.0 * np.einsum("ij,ij->i", directions, about)[:, None] * about

    out = reflect(normal)
    into = np.einsum("ij,ij->i", out, flat) <= 0.01
    out[into] = reflect(flat)[into]
    return offset_origins(points, flat, out, geometry.radius), out


def measure(case: BenchmarkScene, repeats: int) -> list[tuple[str, int, float, float | None, float | None]]:
    """Rows of (kind, rays, our seconds, Embree's seconds, share of verdicts that differ)."""
    geometry, camera = case.geometry, case.camera
    embree = embree_or_none(geometry.corners)
    rows = []

    def row(kind, rays, ours, theirs, same):
        differ = None
        if embree is not None:
            differ = float(np.mean(same(ours(), theirs())))
        seconds = median_seconds(ours, repeats)
        rows.append((kind, rays, seconds, median_seconds(theirs, repeats) if embree is not None else None, differ))

    x, y = np.tile(np.arange(WIDTH) + 0.5, HEIGHT), np.repeat(np.arange(HEIGHT) + 0.5, WIDTH)
    origins, directions = camera.rays(x, y, WIDTH, HEIGHT)
    origins, directions = geometry.recentred(origins), directions.astype(np.float32)
    row(
        "primary",
        len(x),
        lambda: primary_hits(geometry, camera, WIDTH, HEIGHT),
        lambda: embree.closest(origins, directions),
        lambda mine, other: mine.triangle != other,
    )
    hits = primary_hits(geometry, camera, WIDTH, HEIGHT)
    seen = np.flatnonzero(hits.hit)
    own, u, v = hits.triangle[seen], hits.u[seen], hits.v[seen]
    points, (_, flat, _) = geometry.points(own, u, v), geometry.shading(own, u, v)
    for number, light in enumerate(geometry.recentred(case.lights)):
        lifted = offset_origins(points, flat, light - points, geometry.radius)
        row(
            f"shadow {number + 1}",
            len(own),
            lambda light=light, lifted=lifted: LightView(geometry, position=light).occluded(lifted, own),
            lambda light=light, lifted=lifted: embree.occluded(lifted, light - lifted),
            lambda mine, other: mine != other,
        )
    start, out = mirrored(geometry, own, u, v, directions[seen])
    bvh = Bvh.build(geometry)
    row(
        "mirror",
        len(own),
        lambda: bvh.closest(start, out, own=own),
        lambda: embree.closest(start, out),
        lambda mine, other: mine.triangle != other,
    )
    shuffled = np.random.default_rng(0).permutation(len(own))
    start, out, mixed = start[shuffled], out[shuffled], own[shuffled]
    row(
        "mirror, shuffled",
        len(own),
        lambda: bvh.closest(start, out, own=mixed),
        lambda: embree.closest(start, out),
        lambda mine, other: mine.triangle != other,
    )
    return rows


def peak_megabytes() -> float:
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


def report(name: str, repeats: int) -> None:
    """One scene, in this process."""
    case = scene(name)
    geometry = case.geometry
    geometry_seconds = median_seconds(lambda: scene(name), 1)
    build = median_seconds(lambda: Bvh.build(geometry), min(repeats, 3))
    lights = [LightView(geometry, position=light) for light in geometry.recentred(case.lights)]
    before = peak_megabytes()
    hits = primary_hits(geometry, case.camera, WIDTH, HEIGHT)
    seen = np.flatnonzero(hits.hit)
    points = geometry.points(hits.triangle[seen], hits.u[seen], hits.v[seen])
    for light in lights:
        light.occluded(points, hits.triangle[seen])
    print(
        f"{name}: {geometry.triangle_count} triangles, {WIDTH}x{HEIGHT}; modelled and brought to the world in"
        f" {geometry_seconds:.2f} s, tree in {build:.2f} s;\n  peak memory {before:.0f} MB before,"
        f" {peak_megabytes():.0f} MB after one picture with three lights"
    )
    print(f"  {'rays':18}{'number':>9}{'million/s':>11}{'Embree':>9}{'ratio':>8}{'other verdict':>15}")
    for kind, rays, ours, theirs, differ in measure(case, repeats):
        peer = f"{rays / theirs / 1e6:9.2f}{theirs / ours:8.2f}{differ:15.1e}" if theirs is not None else ""
        print(f"  {kind:18}{rays:9d}{rays / ours / 1e6:11.2f}{peer}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=list(SCENES), help="any of: " + ", ".join(SCENES))
    parser.add_argument("--repeats", type=int, default=REPEATS)
    parser.add_argument("--here", action="store_true", help="do not give each scene a process of its own")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.scenes) - set(SCENES))
    if unknown:
        parser.error(f"no such scene: {', '.join(unknown)}")
    print(f"numpy {np.__version__}, one thread, medians of {arguments.repeats}", flush=True)
    for name in arguments.scenes:
        if arguments.here:
            report(name, arguments.repeats)
            continue
        # A process each, so that the peak of memory is the scene's own.
        command = [
            sys.executable,
            "-m",
            "tests.benchmarks.tracing",
            "--here",
            "--repeats",
            str(arguments.repeats),
            name,
        ]
        output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        print(output.split("\n", 1)[1], end="", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
