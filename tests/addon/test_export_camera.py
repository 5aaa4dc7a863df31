"""The exported camera frames what Blender frames: every pixel's ray goes through the point that Blender puts there."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from dichromatic_addon.operators import render_layers
from tests.addon.building import add_camera, small_picture
from tests.tolerances import PROJECTION_IN_PIXELS

pytestmark = pytest.mark.bpy

FRAMINGS: dict[str, dict[str, Any]] = {
    "plain": {},
    "wide lens": {"lens": 12.0},
    "sensor fit horizontal, portrait": {"sensor_fit": "HORIZONTAL", "size": (40, 60)},
    "sensor fit vertical, landscape": {"sensor_fit": "VERTICAL", "size": (60, 40), "sensor_height": 20.0},
    "sensor fit automatic, portrait": {"size": (40, 60), "sensor_width": 30.0},
    "lens shift": {"shift_x": 0.3, "shift_y": -0.2},
    "lens shift, portrait, vertical fit": {"shift_x": -0.4, "shift_y": 0.1, "size": (40, 60), "sensor_fit": "VERTICAL"},
    "pixels twice as wide": {"aspect": (2.0, 1.0)},
    "pixels twice as high, portrait": {"aspect": (1.0, 1.5), "size": (40, 60)},
    "half the resolution": {"size": (80, 60), "percentage": 50},
    "orthographic": {"type": "ORTHO", "ortho_scale": 7.0},
    "orthographic, portrait, shifted": {"type": "ORTHO", "ortho_scale": 3.0, "size": (40, 60), "shift_x": 0.2},
    "border": {"border": (0.21, 0.83, 0.1, 0.55)},
    "border, shift, aspect": {"border": (0.0, 0.5, 0.5, 1.0), "shift_x": 0.1, "aspect": (1.0, 2.0), "size": (80, 44)},
    "scaled camera object": {"scale": (2.0, 0.5, 3.0)},
}


@pytest.mark.parametrize("framing", FRAMINGS.values(), ids=FRAMINGS)
def test_rays_meet_blenders_projection(scene: Any, framing: dict[str, Any]) -> None:
    camera = add_camera(scene, (3.0, -7.0, 4.0), (1.1, 0.2, 0.4))
    camera.scale = framing.get("scale", (1, 1, 1))
    for name in ("lens", "sensor_fit", "sensor_width", "sensor_height", "shift_x", "shift_y", "type", "ortho_scale"):
        if name in framing:
            setattr(camera.data, name, framing[name])
    small_picture(scene, *framing.get("size", (60, 40)))
    render = scene.render
    render.resolution_percentage = framing.get("percentage", 100)
    render.pixel_aspect_x, render.pixel_aspect_y = framing.get("aspect", (1, 1))
    full = np.array([render.resolution_x, render.resolution_y]) * render.resolution_percentage // 100
    left, right, bottom, top = 0, full[0], 0, full[1]
    if "border" in framing:
        render.use_border = True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = framing["border"]
        left, right, bottom, top = (
            int(np.float32(v) * np.float32(full[i // 2])) for i, v in enumerate(framing["border"])
        )

    exported = render_layers(scene)[0].exported

    assert (exported.settings.width, exported.settings.height) == (right - left, top - bottom)
    generator = np.random.default_rng(7)
    matrix = camera.matrix_world.normalized()
    for _ in range(40):
        x, y, depth = generator.uniform(-1, 1), generator.uniform(-1, 1), generator.uniform(1, 20)
        point = matrix @ Vector((x * depth * 0.5, y * depth * 0.5, -depth))
        seen = world_to_camera_view(scene, camera, point)
        column = seen.x * full[0] - left
        row = (top - bottom) - (seen.y * full[1] - bottom)
        origins, directions = exported.scene.camera.rays(
            np.array([column]), np.array([row]), exported.settings.width, exported.settings.height
        )
        # How far the ray passes the point, in units of a pixel's width there.
        offset = np.array(point) - origins[0]
        miss = np.linalg.norm(np.cross(offset, directions[0])) / np.linalg.norm(directions[0])
        pixel = pixel_width(camera.data, full, render, depth)
        assert miss / pixel < PROJECTION_IN_PIXELS


def pixel_width(camera: Any, full: np.ndarray, render: Any, depth: float) -> float:
    across = camera.ortho_scale if camera.type == "ORTHO" else 2 * depth * math.tan(camera.angle / 2)
    return across / max(full) / max(render.pixel_aspect_x, render.pixel_aspect_y)


def test_clipping_distances_are_exported(scene: Any) -> None:
    camera = add_camera(scene)
    camera.data.clip_start, camera.data.clip_end = 0.25, 40.0
    small_picture(scene)
    core_camera = render_layers(scene)[0].exported.scene.camera
    assert core_camera.clip_start == pytest.approx(0.25)
    assert core_camera.clip_end == pytest.approx(40.0)


def exported_camera(scene: Any) -> Any:
    return render_layers(scene)[0].exported.scene.camera


def test_the_lens_is_that_of_blender(scene: Any) -> None:
    """The aperture's diameter is focal length / f-number; the distance to an object counts along the view."""
    camera = add_camera(scene, (0.0, -6.0, 0.0), (0.5 * math.pi, 0.0, 0.0))
    small_picture(scene)
    assert not exported_camera(scene).has_lens
    data = camera.data
    data.lens, data.dof.use_dof = 50.0, True
    data.dof.aperture_fstop, data.dof.focus_distance = 2.0, 4.5
    data.dof.aperture_blades, data.dof.aperture_rotation, data.dof.aperture_ratio = 6, 0.3, 2.0
    lens = exported_camera(scene)
    assert lens.lens_radius == pytest.approx(0.0125)
    assert lens.focus_distance == pytest.approx(4.5)
    assert (lens.lens_blades, lens.lens_rotation, lens.lens_ratio) == (6, pytest.approx(0.3), pytest.approx(2.0))
    aside = bpy.data.objects.new("Aside", None)
    aside.location = (3.0, 1.0, 0.0)
    scene.collection.objects.link(aside)
    data.dof.focus_object = aside
    assert exported_camera(scene).focus_distance == pytest.approx(7.0, rel=1e-6)


def test_an_orthographic_camera_has_no_lens_and_says_so(scene: Any) -> None:
    camera = add_camera(scene)
    camera.data.type, camera.data.dof.use_dof = "ORTHO", True
    small_picture(scene)
    finished = render_layers(scene)[0]
    assert not finished.exported.scene.camera.has_lens
    assert any("it is orthographic" in note for note in finished.exported.notes)
