"""The rendered 3D view apart from its drawing: its camera, its passes, and the session that restarts and recovers.

Drawing needs a window; the tests of the user interface look at that.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon._core import core
from dichromatic_addon.operators import render_layers
from dichromatic_addon.viewport import Pass, View, ViewSession, passes_of
from tests.addon.building import add_camera, add_light, add_plane, small_picture, white_material
from tests.tolerances import FLOAT32_ROUNDING, PROJECTION_IN_PIXELS

pytestmark = pytest.mark.bpy


@pytest.fixture
def stage(scene: Any) -> Any:
    add_plane(scene, white_material(), size=3.0)
    add_light(scene, "POINT", 300.0, (2, -1, 3), shadow_soft_size=0.0)
    add_camera(scene, (0, -4, 3), (0.9, 0, 0.1))
    small_picture(scene, 37, 23)
    scene.dichromatic.samples = 3
    return scene


def view_through_camera(scene: Any, pixel_size: str = "AUTO") -> View:
    """What Blender would tell of a 3D view that looks exactly through the scene's camera."""
    width, height = scene.render.resolution_x, scene.render.resolution_y
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera.evaluated_get(depsgraph)
    region_data = SimpleNamespace(
        view_matrix=camera.matrix_world.normalized().inverted(),
        window_matrix=camera.calc_matrix_camera(depsgraph, x=width, y=height),
    )
    return View.of(SimpleNamespace(width=width, height=height), region_data, pixel_size)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_view_is_that_of_its_matrices(stage: Any, kind: str) -> None:
    data = stage.camera.data
    data.type, data.shift_x, data.clip_start, data.clip_end = kind, 0.2, 0.5, 30.0
    camera = view_through_camera(stage).camera
    exported = render_layers(stage)[0].exported.scene.camera
    assert camera.kind == exported.kind
    assert camera.clip_start == pytest.approx(0.5, rel=1e-4)  # read back from a float32 matrix
    assert camera.clip_end == pytest.approx(30.0, rel=1e-3)
    x, y = np.array([0.0, 37.0, 5.0]), np.array([0.0, 23.0, 11.0])
    for ours, theirs in zip(camera.rays(x, y, 37, 23), exported.rays(x, y, 37, 23), strict=True):
        # Origins start at the near plane, which the matrix gives in float32 as well.
        np.testing.assert_allclose(ours, theirs, atol=PROJECTION_IN_PIXELS / 37)


def test_passes_go_from_coarse_to_fine() -> None:
    drafts = tuple(Pass(step, 1, is_draft=True) for step in (16, 8, 4, 2))
    assert passes_of(1, 1) == (*drafts, Pass(1, 1))
    assert passes_of(1, 4) == (*drafts, Pass(1, 4))
    assert passes_of(4, 1) == (*drafts[:2], Pass(4, 1))
    assert passes_of(8, 2) == (drafts[0], Pass(8, 2))


def session_of(scene: Any) -> ViewSession:
    session = ViewSession()
    session.update(bpy.context.evaluated_depsgraph_get())
    return session


def picture_of(session: ViewSession) -> Any:
    assert session._picture is not None
    return session._picture


def test_finished_view_is_the_picture_of_f12(stage: Any) -> None:
    session, view = session_of(stage), view_through_camera(stage)
    assert session.advance(view, seconds=1e-9)
    steps = 1
    while session.advance(view, seconds=1e-9):
        steps += 1
    assert steps >= len(passes_of(1, 3))
    assert session.status == "Done"
    finished = render_layers(stage)[0]
    settings = replace(finished.exported.settings, width=37, height=23)
    whole = core.render(replace(finished.exported.scene, camera=view.camera), settings)
    expected = finished.exported.colour.rgba(whole.tristimulus(), None)
    np.testing.assert_allclose(picture_of(session).pixels, expected, atol=10 * FLOAT32_ROUNDING * expected.max())


def test_first_slice_covers_the_view(stage: Any) -> None:
    session, view = session_of(stage), view_through_camera(stage)
    session.advance(view, seconds=1e-9)
    picture = picture_of(session)
    assert (picture.pixels[..., 3] == 1.0).all()
    # Blocks of 16 pixels, cut off at the right and at the bottom.
    assert np.ptp(picture.pixels[:16, :16], axis=(0, 1)).max() == 0.0
    coarse = picture.pixels[::16, ::16, 1]
    assert coarse.shape == (2, 3)
    assert np.ptp(coarse) > 0.1
    assert 0.0 < picture.done < 0.5


def test_coarse_pixels_lie_where_the_fine_ones_do(stage: Any) -> None:
    """A pass of 4 x 4 blocks takes its rays through the blocks' centres, for widths that 4 does not divide as well."""
    stage.render.preview_pixel_size = "4"
    stage.dichromatic.samples = 1
    session, view = session_of(stage), view_through_camera(stage, "4")
    while session.advance(view, seconds=10.0):
        continue
    coarse = picture_of(session).pixels[::4, ::4, 1]
    finished = render_layers(stage)[0]
    settings = replace(finished.exported.settings, width=37 * 2, height=23 * 2, pixel_filter="box", filter_width=1.0)
    fine = core.render(replace(finished.exported.scene, camera=view.camera), settings).tristimulus()[..., 1]
    rows, columns = np.meshgrid(np.arange(2, 22, 4), np.arange(2, 36, 4), indexing="ij")
    # At twice the size a block's centre is a corner of four pixels: their mean is the value there.
    around = sum(fine[2 * rows - i, 2 * columns - j] for i in (0, 1) for j in (0, 1)) / 4
    difference = np.abs(coarse[: rows.shape[0], : rows.shape[1]] - around)
    assert np.quantile(difference, 0.8) < 0.02 * fine.max()


def test_moving_the_view_starts_anew_and_standing_still_does_not(stage: Any) -> None:
    session, view = session_of(stage), view_through_camera(stage)
    session.advance(view, seconds=1e-9)
    first = picture_of(session)
    session.advance(view_through_camera(stage), seconds=1e-9)
    assert picture_of(session) is first
    stage.camera.location.x += 1.0
    bpy.context.view_layer.update()
    session.advance(view_through_camera(stage), seconds=1e-9)
    assert picture_of(session) is not first


@pytest.mark.parametrize("slices", [1, 3, 1000])
def test_change_of_colours_is_shown_at_once_and_without_a_ray(stage: Any, slices: int) -> None:
    session, view = session_of(stage), view_through_camera(stage)
    for _ in range(slices):
        session.advance(view, seconds=1e-9)
    picture, before = picture_of(session), picture_of(session).pixels.copy()
    done = picture.done
    bpy.data.lights["Point"].energy *= 2.0
    session.update(bpy.context.evaluated_depsgraph_get())
    assert picture_of(session) is picture
    assert picture.done == done
    np.testing.assert_allclose(picture.pixels[..., :3], 2.0 * before[..., :3], rtol=20 * FLOAT32_ROUNDING)
    stage.dichromatic.white_illuminant = "A"
    session.update(bpy.context.evaluated_depsgraph_get())
    assert picture_of(session) is picture
    lit = before[..., 1] > 0.1
    assert (picture.pixels[lit][:, 2] > 2.5 * before[lit][:, 2]).all()  # adapted to A, daylight is bluish


def test_a_picture_of_the_world_is_neither_read_nor_worked_out_again(stage: Any) -> None:
    """Moving the view and changing a colour take the same array, of which what is known is kept."""
    stage.world = bpy.data.worlds.new("World")
    if stage.world.node_tree is None:
        stage.world.use_nodes = True
    tree = stage.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.new("Sky", 16, 8, float_buffer=True)
    background = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBackground")
    tree.links.new(texture.outputs[0], background.inputs["Color"])
    session, view = session_of(stage), view_through_camera(stage)
    session.advance(view, seconds=10.0)
    picture, before = picture_of(session), picture_of(session)._exported.scene.world.image
    bpy.data.lights["Point"].energy *= 2.0
    session.update(bpy.context.evaluated_depsgraph_get())
    assert picture_of(session) is picture  # only its colours are new
    assert picture_of(session)._exported.scene.world.image.pixels is before.pixels


@pytest.mark.parametrize("what", ["location", "radius", "kind", "object"])
def test_change_of_shapes_is_rendered(stage: Any, what: str) -> None:
    session, view = session_of(stage), view_through_camera(stage)
    while session.advance(view, seconds=1.0):
        continue
    before = picture_of(session)
    light = bpy.data.objects["Point"]
    if what == "location":
        light.location.x += 0.5
    elif what == "radius":
        light.data.shadow_soft_size = 0.5
    elif what == "kind":
        light.data.type = "SUN"
    else:
        bpy.data.objects["Plane"].location.z -= 0.5
    bpy.context.view_layer.update()
    session.update(bpy.context.evaluated_depsgraph_get())
    session.advance(view, seconds=1e-9)
    assert picture_of(session) is not before


def test_triangles_are_kept_while_they_are_the_same(stage: Any) -> None:
    session = session_of(stage)
    known = session._acceleration
    bpy.data.objects["Point"].location.x += 0.5
    bpy.context.view_layer.update()
    session.update(bpy.context.evaluated_depsgraph_get())
    assert session._acceleration is known
    bpy.data.objects["Plane"].location.x += 0.5
    bpy.context.view_layer.update()
    session.update(bpy.context.evaluated_depsgraph_get())
    assert session._acceleration is not known


def test_problem_is_shown_and_forgotten_when_mended(stage: Any) -> None:
    mesh = bpy.data.meshes["Plane"]
    x = mesh.vertices[0].co.x
    mesh.vertices[0].co.x = math.nan
    mesh.update()
    session, view = session_of(stage), view_through_camera(stage)
    assert "vertex 0 must be finite" in session.status
    assert not session.advance(view)
    mesh.vertices[0].co.x = x
    mesh.update()
    session.update(bpy.context.evaluated_depsgraph_get())
    assert session.status == ""
    assert session.advance(view, seconds=1e-9)


def test_no_camera_is_needed(stage: Any) -> None:
    view = view_through_camera(stage)
    stage.camera = None
    assert session_of(stage).advance(view, seconds=1e-9)
