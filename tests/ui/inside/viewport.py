"""The rendered 3D view: drawn, moved, recoloured and edited, with the time that each took to be seen."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import numpy as np
from mathutils import Quaternion
from stage import ENGINE, Stage, Step, act, until

ROUNDS = 5


@dataclass
class Drawing:
    """One drawing of the view.

    Attributes
    ----------
    when : float
        Its end.
    took : float
        Seconds in the engine.
    busy : float
        Seconds of a processor that Blender's main thread has used so far.
    picture : Any
        The ProgressivePicture that was drawn.
    done : float
        Part of its work that was done.
    """

    when: float
    took: float
    busy: float
    picture: Any
    done: float


def watch_drawings(stage: Stage) -> list[Drawing]:
    engine = stage.module("engine").DichromaticRenderEngine
    draw = engine.view_draw
    drawings: list[Drawing] = []

    def watched(self: Any, context: Any, depsgraph: Any) -> None:
        begun = time.perf_counter()
        draw(self, context, depsgraph)
        picture = self._view_session()._picture
        if picture is not None:
            now = time.perf_counter()
            drawings.append(Drawing(now, now - begun, time.thread_time(), picture, picture.done))

    engine.view_draw = watched
    return drawings


def build(stage: Stage) -> int:
    """A ball of 100,000 triangles on a floor, under Blender's own lamp; return the number of triangles."""
    scene = stage.scene
    scene.render.engine = ENGINE
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    with stage.override():
        bpy.ops.mesh.primitive_uv_sphere_add(segments=320, ring_count=157)
        bpy.ops.object.shade_smooth()
        bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))
    ball, floor = bpy.data.objects["Sphere"], bpy.data.objects["Plane"]
    material = bpy.data.materials["Material"]
    editing = sys.modules[stage.module("engine").__name__.rpartition(".")[0] + ".nodes.editing"]
    editing.set_surface_node(material, "DichromaticNodePlastic")
    for thing in (ball, floor):
        thing.data.materials.append(material)
    for thing in (ball, floor):
        thing.data.calc_loop_triangles()
    return sum(len(thing.data.loop_triangles) for thing in (ball, floor))


def timed(
    stage: Stage,
    name: str,
    drawings: list[Drawing],
    change: Callable[[int], None],
    seen: Callable[[Any, Drawing], bool],
) -> Step:
    """Make a change some times, and note the seconds until a drawing shows it."""
    area = stage.area("VIEW_3D")
    found = []
    for number in range(ROUNDS):
        before = drawings[-1].picture
        count = len(drawings)
        begun, busy = time.perf_counter(), time.thread_time()
        change(number)
        area.tag_redraw()
        yield until(
            lambda count=count, before=before: any(seen(before, drawing) for drawing in drawings[count:]),
            f"the view showed: {name}",
            limit=30.0,
        )
        first = next(drawing for drawing in drawings[count:] if seen(before, drawing))
        found.append(round(first.when - begun, 4))
        stage.report.setdefault("busy_s", {}).setdefault(name, []).append(round(first.busy - busy, 4))
    stage.report.setdefault("seen_s", {})[name] = found


def is_another(before: Any, drawing: Drawing) -> bool:
    return drawing.picture is not before


def is_the_same(before: Any, drawing: Drawing) -> bool:
    return drawing.picture is before


def finished(drawings: list[Drawing], limit: float = 240.0) -> Step:
    yield until(lambda: drawings and drawings[-1].picture.is_finished, "the view was finished", limit=limit)


def script(stage: Stage) -> Step:
    yield until(lambda: stage.window.screen, "there was a window")
    stage.report["triangles"] = build(stage)
    drawings = watch_drawings(stage)
    area = stage.area("VIEW_3D")
    space = area.spaces.active
    space.overlay.show_overlays = False
    space.shading.type = "RENDERED"
    yield until(lambda: drawings, "the view was drawn", limit=30.0)
    stage.report["first_s"] = round(drawings[0].took, 3)
    stage.report["view"] = [area.width, area.height]
    rv3d = space.region_3d
    scene = stage.scene

    def turn(number: int) -> None:
        rv3d.view_rotation = Quaternion((0, 0, 1), math.radians(10)) @ rv3d.view_rotation

    yield from timed(stage, "camera move", drawings, turn, is_another)
    light = bpy.data.lights["Light"]
    scene.dichromatic.samples, light.shadow_soft_size = 1, 0.0  # soon finished
    yield from finished(drawings)
    longest = max(drawing.took for drawing in drawings[2:])
    stage.report["longest_slice_s"] = round(longest, 3)
    stage.shot("finished", area)
    picture = drawings[-1].picture
    assert np.isfinite(picture.pixels).all()
    assert np.ptp(picture.pixels[..., 1]) > 0.05, "the view shows one grey"

    def lamp(number: int) -> None:
        light.dichromatic.source = "TEMPERATURE"
        light.dichromatic.temperature = 2000.0 + 500.0 * number

    def power(number: int) -> None:
        light.energy = 500.0 + 100.0 * number

    def white(number: int) -> None:
        scene.dichromatic.white_illuminant = ("A", "D50", "D65", "FL2", "E")[number]

    def eye(number: int) -> None:
        scene.dichromatic.observer = ("cie_1964_10", "cie_1931_2")[number % 2]

    def paint(number: int) -> None:
        node = next(
            n for n in bpy.data.materials["Material"].node_tree.nodes if n.bl_idname == "DichromaticNodePlastic"
        )
        node.inputs["Body Reflectance"].default_value = (0.2 + 0.1 * number, 0.4, 0.3, 1.0)

    before = picture.pixels.copy()
    for name, change in (("lamp", lamp), ("power", power), ("white", white), ("observer", eye), ("paint", paint)):
        yield from timed(stage, f"recolour: {name}", drawings, change, is_the_same)
        assert drawings[-1].picture is picture, f"a change of {name} was traced"
        assert not np.array_equal(before, picture.pixels), f"a change of {name} was not seen"
        before = picture.pixels.copy()
    stage.shot("recoloured", area)

    def move(number: int) -> None:
        bpy.data.objects["Light"].location.x += 0.3

    def lift(number: int) -> None:
        bpy.data.objects["Sphere"].location.z += 0.05

    yield from timed(stage, "light moved", drawings, move, is_another)
    yield from timed(stage, "object moved", drawings, lift, is_another)
    yield from finished(drawings)
    stage.shot("edited", area)
    yield from previews(stage)


def previews(stage: Stage) -> Step:
    """The material's preview sphere, which Blender renders with our engine."""
    material = bpy.data.materials["Material"]
    rendered: list[bool] = []
    engine = stage.module("engine").DichromaticRenderEngine
    render = engine.render

    def watched(self: Any, depsgraph: Any) -> None:
        render(self, depsgraph)
        rendered.append(self.is_preview)

    engine.render = watched
    stage.area("VIEW_3D").spaces.active.shading.type = "SOLID"
    with stage.override(stage.area("PROPERTIES")), bpy.context.temp_override(id=material):
        bpy.ops.ed.lib_id_generate_preview()
    yield until(lambda: any(rendered), "a preview was rendered", limit=60.0)
    yield until(lambda: max(list(material.preview.image_pixels_float or [0.0])) > 0.0, "the preview shows something")
    size = tuple(material.preview.image_size)
    pixels = np.array(material.preview.image_pixels_float).reshape(size[1], size[0], 4)
    seen = pixels[pixels[..., 3] > 0.5][:, :3]
    stage.report["preview"] = {"size": size, "covered": round(len(seen) / (size[0] * size[1]), 3)}
    assert np.ptp(seen[:, 1]) > 0.1, "the preview is one grey"


act(script)
