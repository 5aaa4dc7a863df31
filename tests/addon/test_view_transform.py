"""Blender's colour management: what each view makes of our colours, and what the panel says about it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon.view_transform import is_colorimetric, view_notes
from tests.addon.building import add_light, add_plane, combined, look_down, small_picture

pytestmark = pytest.mark.bpy

# Blender stores the encoded value as round(255 x); a value that lies on a half may go to either side by rounding of
# the encoding's own float32 table.
ONE_STEP = 1


def encoded(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, in 8 bits."""
    linear = np.clip(linear.astype(np.float64), 0.0, 1.0)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255.0 * curve).astype(int)


def bytes_of(path: Path) -> np.ndarray:
    """The stored bytes of a PNG, (H, W, 3), row 0 at the top."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return np.round(pixels.reshape(height, width, 4)[::-1, :, :3] * 255.0).astype(int)


def transforms() -> list[str]:
    """Every view of this Blender; the list is dynamic, and told to those who ask for what is not there."""
    try:
        bpy.context.scene.view_settings.view_transform = "no such view"
    except TypeError as error:
        return [part.strip(" '()") for part in str(error).split("not found in")[1].split(",")]
    raise AssertionError("a view of that name was found")


@pytest.fixture
def patches(scene: Any) -> tuple[Any, np.ndarray]:
    """An image of linear colours from 0.002 to 1, and a scene that saves 8-bit PNGs without dither."""
    ramp = np.geomspace(0.002, 1.0, 24)
    linear = np.stack(np.broadcast_arrays(ramp[:, None], ramp[None, ::-1], 0.3), axis=-1).astype(np.float32)
    image = bpy.data.images.new("Patches", 24, 24, alpha=False, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    pixels = np.ones((24, 24, 4), np.float32)
    pixels[..., :3] = linear
    image.pixels.foreach_set(pixels[::-1].ravel())
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "8"
    scene.render.dither_intensity = 0.0
    return image, linear


def saved(scene: Any, image: Any, path: Path) -> np.ndarray:
    image.save_render(str(path), scene=scene)
    return bytes_of(path)


def test_only_the_view_that_is_called_colorimetric_is(scene: Any, patches: Any, tmp_path: Path) -> None:
    image, linear = patches
    names = transforms()
    assert {"Standard", "AgX", "Filmic", "Khronos PBR Neutral", "Raw"} <= set(names)
    for name in names:
        scene.view_settings.view_transform = name
        scene.view_settings.look = "None"
        difference = np.abs(saved(scene, image, tmp_path / f"{name}.png") - encoded(linear)).max()
        assert is_colorimetric(scene) == (difference <= ONE_STEP) == (name == "Standard"), (name, difference)
        assert is_colorimetric(scene) or name in " ".join(view_notes(scene))


def tampered(view: Any, what: str) -> None:
    if what == "gamma":
        view.gamma = 1.2
    elif what == "curves":
        view.use_curve_mapping = True
        curve = view.curve_mapping.curves[3]
        curve.points.new(0.5, 0.7)
        view.curve_mapping.update()
    elif what == "white balance":
        if not hasattr(view, "use_white_balance"):
            pytest.skip("this Blender has no white balance")
        view.use_white_balance = True
        view.white_balance_temperature = 4000.0


@pytest.mark.parametrize("what", ["gamma", "curves", "white balance"])
def test_what_else_restyles_is_named(scene: Any, patches: Any, tmp_path: Path, what: str) -> None:
    image, linear = patches
    view = scene.view_settings
    view.view_transform = "Standard"
    assert view_notes(scene) == []
    tampered(view, what)
    assert np.abs(saved(scene, image, tmp_path / "view.png") - encoded(linear)).max() > ONE_STEP
    (note,) = view_notes(scene)
    assert what in note


def test_exposure_keeps_colours_up_to_their_scale(scene: Any, patches: Any, tmp_path: Path) -> None:
    image, linear = patches
    scene.view_settings.view_transform, scene.view_settings.exposure = "Standard", -1.0
    assert is_colorimetric(scene)
    assert np.abs(saved(scene, image, tmp_path / "view.png") - encoded(linear / 2)).max() <= ONE_STEP


@pytest.fixture
def orange(scene: Any) -> Any:
    """An orange table under a lamp, which falls off towards the corners."""
    material = bpy.data.materials.new("Orange")
    material.diffuse_color = (0.6, 0.2, 0.05, 1.0)
    if material.node_tree is not None:
        material.node_tree.nodes.clear()
    add_plane(scene, material, size=20.0)
    add_light(scene, "POINT", 300.0, (1, 1, 1.5), shadow_soft_size=0.0)
    look_down(scene, 4.0)
    small_picture(scene, 32, 32)
    return scene


def saved_in_standard(scene: Any, path: Path) -> np.ndarray:
    scene.view_settings.view_transform = "Standard"
    scene.render.dither_intensity = 0.0
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "8"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return bytes_of(path)


def test_a_render_saved_in_the_standard_view_holds_exact_srgb(orange: Any, tmp_path: Path) -> None:
    linear = combined(orange, str(tmp_path / "linear.exr"))[..., :3]
    assert linear.max() > 0.5 > 0.1 > linear.min()
    stored = saved_in_standard(orange, tmp_path / "standard.png")
    exact = encoded(linear)
    assert np.abs(stored - exact).max() <= ONE_STEP
    assert (stored != exact).mean() < 0.01


def test_a_file_with_a_wider_working_space_shows_the_same_colours(orange: Any, tmp_path: Path) -> None:
    if not hasattr(bpy.ops.wm, "set_working_color_space") or not hasattr(bpy.data, "colorspace"):
        pytest.skip("this Blender works in Rec.709 only")
    narrow = saved_in_standard(orange, tmp_path / "narrow.png")
    bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=True)
    assert bpy.data.colorspace.working_space == "ACEScg"
    wide = saved_in_standard(orange, tmp_path / "wide.png")
    assert np.ptp(narrow) > 100
    assert np.abs(wide - narrow).max() <= ONE_STEP
