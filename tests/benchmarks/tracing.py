"""Rays a second of every kind, beside Embree's on the same rays: ``python -m tests.benchmarks.tracing``.

One thread; medians of five, of processor time, which other programs disturb least. Embree (package embreex, an extra)
is optional: without it the ratios are left out. Rates are of whole calls: for primary rays that is from a camera to
triangle, barycentric coordinates and distance of every pixel, projection included; for shadows from a light and points
to verdicts, projection and sorting included. Trees, Embree's too, and the closed parts of the meshes are made before:
their times are told beside them. Shadows are those of the points that face the light, as the renderer asks;
"sub-picture" is a light looked from once for every fourth pixel of every fourth row, as lamps with a size are;
"shadow ray" is light 1 through the tree; "mirror, shuffled" has its rays in random order. The sample blends are read if
there is a bpy.
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

from spectral_core.tracing import Acceleration, Bvh, Solids, offset_origins
from tests.benchmarks.scenes import SCENES, BenchmarkScene, sample_blends, scene

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

    def occluded(self, origins: np.ndarray, directions: np.ndarray, end: float = 1.0) -> np.ndarray:
        ends = np.full(len(origins), end, np.float32)
        return self._scene.run(origins, directions, dists=ends, query="OCCLUDED") == 0


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
    acceleration = Acceleration(geometry)
    bvh, _ = acceleration.tree(), acceleration.solids
    embree = embree_or_none(geometry.corners)
    rows = []

    def row(kind, rays, ours, theirs, differ):
        different, seconds, peer = None, [], []
        if embree is not None:
            different = float(np.mean(differ(ours(), theirs())))
        for _ in range(repeats):  # by turns, so that what else goes on meets both
            seconds.append(median_seconds(ours, 1))
            if embree is not None:
                peer.append(median_seconds(theirs, 1))
        rows.append((kind, rays, statistics.median(seconds), statistics.median(peer) if peer else None, different))

    x, y = np.tile(np.arange(WIDTH) + 0.5, HEIGHT), np.repeat(np.arange(HEIGHT) + 0.5, WIDTH)
    origins, directions = camera.rays(x, y, WIDTH, HEIGHT)
    origins, directions = geometry.recentred(origins), directions.astype(np.float32)
    row(
        "primary",
        len(x),
        lambda: acceleration.primary_view(camera, WIDTH, HEIGHT).hits(),
        lambda: embree.closest(origins, directions),
        lambda mine, other: mine.triangle != other,
    )
    hits = acceleration.primary_view(camera, WIDTH, HEIGHT).hits()
    seen = np.flatnonzero(hits.hit)
    own, u, v = hits.triangle[seen], hits.u[seen], hits.v[seen]
    points, (_, flat, _) = geometry.points(own, u, v), geometry.shading(own, u, v)
    flat = flat * -np.sign(np.einsum("ij,ij->i", flat, directions[seen]))[:, None]
    ways = [(place, None) for place in geometry.recentred(case.lights)] + [(None, sun) for sun in case.suns]
    for number, (position, to_light) in enumerate(ways):
        away = np.broadcast_to(to_light, points.shape) if position is None else position - points
        away = away.astype(np.float32)
        facing = np.flatnonzero(np.einsum("ij,ij->i", flat, away) > 0.0)
        apart = seen[facing]
        every_fourth = np.flatnonzero((apart % WIDTH % 4 == 1) & (apart // WIDTH % 4 == 2))
        lifted = offset_origins(points, flat, away, geometry.radius)[facing]
        for kind, some in ((f"shadow {number + 1}", slice(None)), ("  sub-picture", every_fourth)):
            start, to, mine = lifted[some], np.ascontiguousarray(away[facing][some]), own[facing][some]
            end = 1.0 if to_light is None else np.inf
            row(
                kind,
                len(mine),
                lambda p=position, d=to_light, s=start, o=mine: acceleration.light_view(p, d, camera).occluded(s, o),
                lambda s=start, t=to, e=end: embree.occluded(s, t, e),
                lambda mine, other: mine != other,
            )
            if kind == "shadow 1":
                row(
                    "shadow ray",
                    len(mine),
                    lambda s=start, t=to, o=mine, e=end: bvh.occluded(s, t, e, o),
                    lambda s=start, t=to, e=end: embree.occluded(s, t, e),
                    lambda mine, other: mine != other,
                )
    start, out = mirrored(geometry, own, u, v, directions[seen])
    shuffled = np.random.default_rng(0).permutation(len(own))
    for kind, order in (("mirror", slice(None)), ("mirror, shuffled", shuffled)):
        row(
            kind,
            len(own),
            lambda s=start[order], d=out[order], o=own[order]: bvh.closest(s, d, own=o),
            lambda s=start[order], d=out[order]: embree.closest(s, d),
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
    closed = median_seconds(lambda: Solids.of(geometry), min(repeats, 3))
    before = peak_megabytes()
    acceleration = Acceleration(geometry)
    hits = acceleration.primary_view(case.camera, WIDTH, HEIGHT).hits()
    seen = np.flatnonzero(hits.hit)
    points = geometry.points(hits.triangle[seen], hits.u[seen], hits.v[seen])
    for light in geometry.recentred(case.lights):
        acceleration.light_view(light, keep=True).occluded(points, hits.triangle[seen])
    print(
        f"\n{name}: {geometry.triangle_count} triangles, {WIDTH}x{HEIGHT}; modelled and brought to the world in"
        f" {geometry_seconds:.2f} s, tree in {build:.2f} s, closed parts in {closed:.3f} s;\n"
        f"  peak memory {before:.0f} MB before, {peak_megabytes():.0f} MB after one picture, {len(case.lights)} lamps"
    )
    print(f"  {'rays':18}{'number':>9}{'million/s':>11}{'Embree':>9}{'ratio':>8}{'other verdict':>15}")
    for kind, rays, ours, theirs, differ in measure(case, repeats):
        peer = f"{rays / theirs / 1e6:9.2f}{theirs / ours:8.2f}{differ:15.1e}" if theirs is not None else ""
        print(f"  {kind:18}{rays:9d}{rays / ours / 1e6:11.2f}{peer}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    every = [*SCENES, *sample_blends()]
    parser.add_argument("scenes", nargs="*", default=every, help="any of: " + ", ".join(every))
    parser.add_argument("--repeats", type=int, default=REPEATS)
    parser.add_argument("--here", action="store_true", help="do not give each scene a process of its own")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.scenes) - set(every))
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
        lines = output.splitlines(keepends=True)
        begin = next(k for k, line in enumerate(lines) if line.startswith(f"{name}:"))
        print("".join(line for line in lines[begin:] if line.startswith((name, " "))), end="", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
