"""How long ESC takes: ``python -m tests.benchmarks.cancel [--triangles 500000] [--mirror 0.3]``.

Blender calls the engine's ``test_break`` and expects an end soon after it says yes. Here a stand-in for the engine says
yes after a while, in every phase of a large render (1920 x 1080, 64 samples, six lamps): the export, the gathering and
sorting of triangles, and the picture. Printed is the wall-clock time from then to the return of the call.
"""

import argparse
import os
import sys
import time

import bpy
import numpy as np

import dichromatic_addon
from dichromatic_addon._core import core
from dichromatic_addon.engine import _LayerJob

DELAYS = (0.01, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0)


class StoppedEngine:
    """What the engine's job needs of Blender's render engine; it wants an end after `delay` seconds."""

    is_preview = False
    camera_override = None

    def __init__(self, delay: float) -> None:
        self._end = time.perf_counter() + delay
        self.message = ""

    def test_break(self) -> bool:
        return time.perf_counter() >= self._end

    @property
    def overdue(self) -> float:
        return time.perf_counter() - self._end

    def update_stats(self, layer: str, message: str) -> None:
        self.message = message.split(" |")[0]

    def update_progress(self, fraction: float) -> None:
        pass

    def add_pass(self, *arguments: object, **keywords: object) -> None:
        pass

    def begin_result(self, *arguments: object, **keywords: object) -> "StoppedEngine":
        return self

    def end_result(self, result: object) -> None:
        pass

    @property
    def layers(self) -> list["StoppedEngine"]:
        return [self]

    passes: tuple[object, ...] = ()

    def report(self, *arguments: object) -> None:
        pass


def large_scene(triangles: int, mirror: float) -> None:
    """A rough terrain with balls under six lamps."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "DICHROMATIC"
    scene.render.resolution_x, scene.render.resolution_y, scene.dichromatic.samples = 1920, 1080, 64
    side = int(np.sqrt(triangles / 2))
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side, y_subdivisions=side, size=20.0)
    terrain = bpy.context.object
    count = len(terrain.data.vertices)
    points = np.empty(3 * count, np.float32)
    terrain.data.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    points[:, 2] = 0.2 * np.sin(3 * points[:, 0]) * np.cos(2 * points[:, 1])
    points += np.random.default_rng(0).normal(0, 0.003, points.shape).astype(np.float32)
    terrain.data.vertices.foreach_set("co", points.ravel())
    terrain.data.update()
    for k in range(5):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, location=(3.0 * (k - 2), 0.0, 1.2))
        material = bpy.data.materials.new(f"Ball {k}")
        bpy.context.object.data.materials.append(material)
        bpy.ops.dichromatic.material_preset(name="Gold")
        for node in material.node_tree.nodes:
            if "Mirror" in node.inputs:
                node.inputs["Mirror"].default_value = mirror
    for k, kind in enumerate(("POINT", "SUN", "SPOT", "AREA", "AREA", "POINT")):
        bpy.ops.object.light_add(type=kind, location=(4.0 * (k - 2.5), -4.0, 6.0), rotation=(0.4, 0.2 * (k - 2.5), 0.0))
        bpy.context.object.data.energy = 3.0 if kind == "SUN" else 800.0
    bpy.ops.object.camera_add(location=(0.0, -14.0, 6.0), rotation=(1.2, 0.0, 0.0))
    scene.camera = bpy.context.object


def measure(delay: float) -> tuple[float, str]:
    """Seconds from the wish to end until the end, and what was being done."""
    engine = StoppedEngine(delay)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    try:
        _LayerJob(engine, None).run(depsgraph)
    except core.RenderCancelledError:
        return engine.overdue, engine.message
    raise SystemExit(f"the render ended by itself in less than {delay} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=500_000)
    parser.add_argument("--mirror", type=float, default=0.3)
    options = parser.parse_args()
    dichromatic_addon.register()
    try:
        large_scene(options.triangles, options.mirror)
        print(f"{'ESC after':>9}  {'ended in':>8}  during")
        worst = 0.0
        for delay in DELAYS:
            latency, message = measure(delay)
            worst = max(worst, latency)
            print(f"{delay:7.2f} s  {latency:6.3f} s  {message}", flush=True)
        load = f", with a load of {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
        print(f"longest: {worst:.3f} s on {os.cpu_count()} processors{load}")
    finally:
        dichromatic_addon.unregister()


if __name__ == "__main__":
    sys.exit(main())
