"""What part of which frame is rendered, through which camera: borders, scale, markers and animations, on pixels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from tests.addon.building import add_camera, add_light, add_plane, combined, small_picture, white_material
from tests.addon.multilayer import single_layer

pytestmark = pytest.mark.bpy

# A still and a frame of an animation go through the same arithmetic, except for matrices that Blender evaluates from
# f-curves in float32: an offset of 1e-7 of a pixel moves a shade by a few parts in a million.
FRAME_AGAINST_STILL = 1e-5


@pytest.fixture
def studio(scene: Any) -> Any:
    """A white floor and a small dark sheet over it, under a lamp; seen from above with the sky around it."""
    add_plane(scene, white_material(), size=6.0, name="Floor")
    dark = bpy.data.materials.new("Dark")
    dark.diffuse_color = (0.1, 0.1, 0.3, 1.0)
    if dark.node_tree is not None:
        dark.node_tree.nodes.clear()
    add_plane(scene, dark, size=1.2, height=0.4, name="Sheet")
    add_light(scene, "POINT", 900.0, (1.5, -2, 4), shadow_soft_size=0.0)
    add_camera(scene, (0, -6, 5), (math.radians(48), 0, 0))
    small_picture(scene, 48, 32)
    scene.dichromatic.samples = 1
    return scene


def pixels_of(path: Path) -> np.ndarray:
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[::-1]


def animation(scene: Any, folder: Path) -> dict[int, np.ndarray]:
    """Render the scene's frames as Blender does, and return them by number."""
    single_layer(scene)
    scene.render.filepath = str(folder / "frame_")
    bpy.ops.render.render(animation=True)
    return {int(path.stem.split("_")[1]): pixels_of(path) for path in sorted(folder.glob("frame_*.exr"))}


def differing(one: np.ndarray, other: np.ndarray, tolerance: float) -> float:
    """Part of the pixels that differ by more than the tolerance."""
    return float((np.abs(one - other).max(axis=-1) > tolerance).mean())


def test_a_border_leaves_the_rest_of_the_picture_empty(studio: Any, tmp_path: Path) -> None:
    whole = combined(studio, str(tmp_path / "whole.exr"))
    render = studio.render
    render.use_border, render.use_crop_to_border = True, False
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.25, 0.5
    part = combined(studio, str(tmp_path / "part.exr"))
    assert part.shape == whole.shape
    inside = np.zeros((32, 48), bool)
    inside[16:24, 12:36] = True
    assert whole[inside].max() > 0.1
    assert differing(part[16:24, 12:36], whole[16:24, 12:36], 1e-4) < 0.02  # rays that round across an edge
    assert np.abs(part[~inside]).max() == 0.0
    render.use_crop_to_border = True
    cropped = combined(studio, str(tmp_path / "cropped.exr"))
    assert np.array_equal(cropped, part[16:24, 12:36])


@pytest.mark.parametrize("percentage", [25, 50, 150])
def test_the_percentage_scales_the_picture(studio: Any, tmp_path: Path, percentage: int) -> None:
    studio.render.resolution_percentage = percentage
    scaled = combined(studio, str(tmp_path / "scaled.exr"))
    studio.render.resolution_x, studio.render.resolution_y = 48 * percentage // 100, 32 * percentage // 100
    studio.render.resolution_percentage = 100
    assert np.array_equal(scaled, combined(studio, str(tmp_path / "as_large.exr")))
    assert scaled.shape[:2] == (32 * percentage // 100, 48 * percentage // 100)


def test_a_transparent_film_is_premultiplied(studio: Any, tmp_path: Path) -> None:
    studio.dichromatic.samples = 16
    opaque = combined(studio, str(tmp_path / "opaque.exr"))
    studio.render.film_transparent = True
    transparent = combined(studio, str(tmp_path / "transparent.exr"))
    alpha = transparent[..., 3]
    assert (opaque[..., 3] == 1.0).all()
    assert alpha.min() == 0.0
    assert alpha.max() == 1.0
    assert ((alpha > 0.2) & (alpha < 0.8)).any()  # the edge of the floor
    # Before a black world, premultiplied light is the light itself.
    assert np.array_equal(transparent[..., :3], opaque[..., :3])


def test_markers_change_the_camera(studio: Any, tmp_path: Path) -> None:
    first = studio.camera
    second = add_camera(studio, (0, 0, 12))
    studio.camera = first
    for frame, camera in ((1, first), (2, second)):
        studio.timeline_markers.new(f"Shot {frame}", frame=frame).camera = camera
    studio.frame_start, studio.frame_end = 1, 2
    frames = animation(studio, tmp_path)
    studio.timeline_markers.clear()
    for frame, camera in ((1, first), (2, second)):
        studio.camera = camera
        assert np.array_equal(frames[frame], combined(studio, str(tmp_path / "still.exr")))
    assert differing(frames[1], frames[2], 0.01) > 0.3


def test_frame_step_leaves_frames_out(studio: Any, tmp_path: Path) -> None:
    studio.frame_start, studio.frame_end, studio.frame_step = 1, 5, 2
    assert sorted(animation(studio, tmp_path)) == [1, 3, 5]


def move_object(studio: Any, value: float) -> Any:
    bpy.data.objects["Sheet"].location.x = value
    return bpy.data.objects["Sheet"], "location"


def dim_light(studio: Any, value: float) -> Any:
    bpy.data.lights["Point"].energy = 700.0 + 300.0 * value
    return bpy.data.lights["Point"], "energy"


def move_camera(studio: Any, value: float) -> Any:
    studio.camera.location.x = value
    return studio.camera, "location"


def zoom_camera(studio: Any, value: float) -> Any:
    studio.camera.data.lens = 50.0 + 10.0 * value
    return studio.camera.data, "lens"


def colour_material(studio: Any, value: float) -> Any:
    shader = bpy.data.materials["White"].node_tree.nodes["Diffuse BSDF"]
    shader.inputs["Color"].default_value = (0.5, 0.5 + 0.2 * value, 0.5, 1.0)
    return bpy.data.materials["White"].node_tree, 'nodes["Diffuse BSDF"].inputs[0].default_value'


def bend_mesh(studio: Any, value: float) -> Any:
    sheet = bpy.data.objects["Sheet"]
    if sheet.data.shape_keys is None:
        sheet.shape_key_add(name="Basis")
        key = sheet.shape_key_add(name="Tall")
        key.data[0].co.z += 0.6
    sheet.data.shape_keys.key_blocks["Tall"].value = 0.5 + 0.5 * value
    return sheet.data.shape_keys.key_blocks["Tall"], "value"


def dim_world(studio: Any, value: float) -> Any:
    if studio.world is None:
        studio.world = bpy.data.worlds.new("Sky")
        if studio.world.node_tree is None:
            studio.world.use_nodes = True
        tree = studio.world.node_tree
        if "Background" not in tree.nodes:
            background = tree.nodes.new("ShaderNodeBackground")
            output = tree.nodes.new("ShaderNodeOutputWorld")
            tree.links.new(background.outputs[0], output.inputs["Surface"])
    tree = studio.world.node_tree
    tree.nodes["Background"].inputs["Color"].default_value = (0.4, 0.4, 0.8, 1.0)
    tree.nodes["Background"].inputs["Strength"].default_value = 0.6 + 0.4 * value
    return tree, 'nodes["Background"].inputs[1].default_value'


def change_white(studio: Any, value: float) -> Any:
    """A setting of the scene itself: the colour temperature that is to look white."""
    settings = studio.dichromatic
    settings.adaptation, settings.white_source = "bradford", "TEMPERATURE"
    settings.white_temperature = 6000.0 + 1500.0 * value
    return studio, "dichromatic.white_temperature"


CHANGES = [dim_world, change_white, move_object, dim_light, move_camera, zoom_camera, colour_material, bend_mesh]


@pytest.mark.parametrize("persistent", [False, True], ids=["afresh", "persistent"])
@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_what_moves_is_in_each_frame(studio: Any, tmp_path: Path, change: Any, persistent: bool) -> None:
    """Every frame is the still that is rendered of the scene as it then is."""
    values = {1: -0.8, 2: 0.1, 3: 0.9}
    stills = {}
    for frame, value in values.items():
        change(studio, value)
        stills[frame] = combined(studio, str(tmp_path / f"still_{frame}.exr"))
    for frame, value in values.items():
        owner, path = change(studio, value)
        owner.keyframe_insert(path, frame=frame)
    studio.frame_start, studio.frame_end = 1, 3
    studio.render.use_persistent_data = persistent
    frames = animation(studio, tmp_path)
    assert sorted(frames) == [1, 2, 3]
    for frame in values:
        # A ray in a thousand may round across an edge.
        assert differing(frames[frame], stills[frame], FRAME_AGAINST_STILL) < 2e-3
    assert differing(frames[1], frames[3], 0.01) > 0.02
