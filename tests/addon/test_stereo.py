"""Stereoscopy: each eye's picture is that of a plain camera which stands where the eye is."""

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

# The eye's place and shift are Blender's float32 numbers, ours the closed form's: 1e-7 of a few metres move a shade by
# some parts in a million.
EYE = 1e-5


@pytest.fixture
def studio(scene: Any) -> Any:
    add_plane(scene, white_material(), size=6.0, name="Floor")
    dark = bpy.data.materials.new("Dark")
    dark.diffuse_color = (0.1, 0.1, 0.3, 1.0)
    if dark.node_tree is not None:
        dark.node_tree.nodes.clear()
    add_plane(scene, dark, size=1.2, height=0.4, name="Sheet")
    add_light(scene, "POINT", 900.0, (1.5, -2, 4), shadow_soft_size=0.0)
    camera = add_camera(scene, (0, -6, 5), (math.radians(48), 0, 0))
    camera.data.stereo.interocular_distance = 0.4
    camera.data.stereo.convergence_distance = 7.0
    small_picture(scene, 48, 32)
    scene.dichromatic.samples = 1
    return scene


def eyes(scene: Any, folder: Path, views_format: str = "STEREO_3D") -> dict[str, np.ndarray]:
    """Render both views to files of their own, and read them as they are."""
    openimageio = pytest.importorskip("OpenImageIO")
    single_layer(scene)
    scene.render.use_multiview = True
    scene.render.views_format = views_format
    scene.render.image_settings.views_format = "INDIVIDUAL"
    scene.render.filepath = str(folder / "eye.exr")
    bpy.ops.render.render(write_still=True)
    scene.render.use_multiview = False
    return {name: openimageio.ImageBuf(str(folder / f"eye_{name}.exr")).get_pixels() for name in ("L", "R")}


def assert_same_picture(one: np.ndarray, other: np.ndarray) -> None:
    differs = np.abs(one - other).max(axis=-1) > EYE * other.max()
    assert differs.mean() < 3e-3  # rays on an edge


@pytest.mark.parametrize("fit", ["AUTO", "VERTICAL"])
@pytest.mark.parametrize("mode", ["OFFAXIS", "PARALLEL"])
def test_eyes_stand_apart_and_meet_at_the_convergence_plane(studio: Any, tmp_path: Path, mode: str, fit: str) -> None:
    camera = studio.camera
    camera.data.sensor_fit, camera.data.shift_x = fit, 0.03
    camera.data.stereo.convergence_mode, camera.data.stereo.pivot = mode, "CENTER"
    seen = eyes(studio, tmp_path)
    assert np.abs(seen["L"] - seen["R"]).max() > 0.1
    # Blender counts the shift that lets the eyes meet in widths of the sensor, whatever its fit.
    converging = 0.5 * 0.4 / 7.0 * camera.data.lens / camera.data.sensor_width if mode == "OFFAXIS" else 0.0
    for name, side in (("L", -1.0), ("R", 1.0)):
        camera.location.x = side * 0.2
        camera.data.shift_x = 0.03 - side * converging
        assert_same_picture(seen[name], combined(studio, str(tmp_path / "plain.exr")))


def test_views_may_have_cameras_of_their_own(studio: Any, tmp_path: Path) -> None:
    left = studio.camera
    right = add_camera(studio, (1.0, -5, 5), (math.radians(45), 0, 0.2))
    left.name, right.name = "Camera_L", "Camera_R"
    studio.camera = left
    seen = eyes(studio, tmp_path, "MULTIVIEW")
    for name, camera in (("L", left), ("R", right)):
        studio.camera = camera
        assert_same_picture(seen[name], combined(studio, str(tmp_path / "plain.exr")))


def test_passes_are_each_eyes_own(studio: Any, tmp_path: Path) -> None:
    openimageio = pytest.importorskip("OpenImageIO")
    from dichromatic_addon import compat

    studio.view_layers[0].use_pass_z = True
    compat.set_multilayer_exr(studio.render.image_settings)
    studio.render.use_multiview = True
    studio.render.image_settings.views_format = "INDIVIDUAL"
    studio.render.filepath = str(tmp_path / "eye.exr")
    bpy.ops.render.render(write_still=True)
    depths = {}
    for path in sorted(tmp_path.glob("eye*.exr")):
        source, part = openimageio.ImageInput.open(str(path)), 0
        while source.seek_subimage(part, 0):
            for channel, name in enumerate(source.spec().channelnames):
                if "Depth" in name:
                    depths[path.name, name] = np.array(source.read_image(part, 0, channel, channel + 1, "float"))
            part += 1
        source.close()
    one, other = depths.values()
    assert (one < 1e9).mean() > 0.2
    assert (other < 1e9).mean() > 0.2
    assert np.abs(one - other).max() > 0.01
