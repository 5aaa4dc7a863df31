"""What cannot be rendered ends with its reason, without a file, and leaves the scene as it was."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import pytest

from dichromatic_addon import engine as engine_module
from dichromatic_addon._core import core
from dichromatic_addon.engine import _LayerJob
from dichromatic_addon.operators import render_layers
from tests.addon.building import add_camera, add_light, add_plane, small_picture, white_material

pytestmark = pytest.mark.bpy


def sound(scene: Any) -> None:
    add_plane(scene, white_material())
    add_light(scene, "SUN", 3.0)
    add_camera(scene)
    small_picture(scene, 8, 8)


def no_camera(scene: Any, folder: Path) -> None:
    scene.camera = None


def camera_is_no_camera(scene: Any, folder: Path) -> None:
    scene.camera = bpy.data.objects["Sun"]


def panoramic_camera(scene: Any, folder: Path) -> None:
    scene.camera.data.type = "PANO"


def vertex_is_nan(scene: Any, folder: Path) -> None:
    bpy.data.meshes["Plane"].vertices[2].co.x = math.nan


def spectrum_file_is_gone(scene: Any, folder: Path) -> None:
    settings = bpy.data.lights["Sun"].dichromatic
    settings.source = "FILE"
    settings.filepath = str(folder / "gone.csv")


def lamp_is_unknown(scene: Any, folder: Path) -> None:
    settings = bpy.data.lights["Sun"].dichromatic
    settings.source, settings.illuminant = "LIBRARY", "no such lamp"


def empty_border(scene: Any, folder: Path) -> None:
    render = scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.5, 0.51, 0.5, 0.51


FAILURES = [
    (no_camera, "no camera"),
    (camera_is_no_camera, "'Sun' is not"),
    (panoramic_camera, "perspective or orthographic"),
    (vertex_is_nan, "vertex 2 must be finite"),
    (spectrum_file_is_gone, "gone.csv"),
    (lamp_is_unknown, "no such lamp"),
    (empty_border, "at least one pixel"),
]


@pytest.mark.parametrize(("spoil", "words"), FAILURES, ids=[spoil.__name__ for spoil, _ in FAILURES])
def test_render_fails_with_its_reason(scene: Any, tmp_path: Path, spoil: Any, words: str) -> None:
    sound(scene)
    spoil(scene, tmp_path)
    scene.render.filepath = str(tmp_path / "picture.exr")
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.render.render(write_still=True)
    if spoil not in (no_camera, empty_border):  # these Blender itself refuses, in its own words
        assert words in str(caught.value)
    assert list(tmp_path.iterdir()) == []

    scene.render.engine = "CYCLES"
    with pytest.raises(core.DichromaticError):
        render_layers(scene)
    assert scene.render.engine == "CYCLES"
    with pytest.raises(RuntimeError):
        bpy.ops.dichromatic.render_image()
    assert scene.render.engine == "CYCLES"
    assert "Dichromatic Render" not in bpy.data.images
    assert engine_module._captures == []


def test_failed_render_can_be_mended(scene: Any, tmp_path: Path) -> None:
    """Nothing of the failure stays behind in Blender."""
    sound(scene)
    scene.camera.data.type = "PANO"
    with pytest.raises(core.SceneError, match="perspective or orthographic"):
        render_layers(scene)
    scene.camera.data.type = "PERSP"
    assert render_layers(scene)[0].render.tristimulus().max() > 0.0


def test_unexpected_errors_are_reported_too(scene: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sound(scene)

    def broken(*arguments: Any, **named: Any) -> None:
        raise ZeroDivisionError("a fault in the program")

    monkeypatch.setattr(core, "render", broken)
    scene.render.filepath = str(tmp_path / "picture.exr")
    with pytest.raises(RuntimeError, match="ZeroDivisionError: a fault in the program"):
        bpy.ops.render.render(write_still=True)


def test_cancel_stops_between_bands(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sound(scene)
    small_picture(scene, 1024, 256)
    asked = 0
    messages = []

    def break_at_the_third_band(self: Any) -> bool:
        nonlocal asked
        asked += 1
        return sum("rows" in message for message in messages) >= 3

    monkeypatch.setattr(_LayerJob, "_is_cancelled", break_at_the_third_band)
    with pytest.raises(core.RenderCancelledError):
        render_layers(scene, progress=lambda fraction, message: messages.append(message))
    assert asked >= 3
    assert sum("rows" in message for message in messages) == 3
    assert "done" not in messages


def test_cancel_is_asked_before_each_object(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sound(scene)
    for number in range(5):
        add_plane(scene, name=f"Sheet {number}", height=-1.0 - number)
    asked = 0

    def at_the_fourth_time(self: Any) -> bool:
        nonlocal asked
        asked += 1
        return asked == 4

    messages: list[str] = []
    monkeypatch.setattr(_LayerJob, "_is_cancelled", at_the_fourth_time)
    with pytest.raises(core.RenderCancelledError):
        render_layers(scene, progress=lambda fraction, message: messages.append(message))
    assert messages == ["reading the scene"]


def test_cancelled_operator_stores_nothing(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sound(scene)
    monkeypatch.setattr(_LayerJob, "_is_cancelled", lambda self: True)
    assert bpy.ops.dichromatic.render_image() == {"CANCELLED"}
    assert "Dichromatic Render" not in bpy.data.images


def test_no_view_layer_to_render(scene: Any) -> None:
    sound(scene)
    scene.view_layers[0].use = False
    with pytest.raises(core.DichromaticError):
        render_layers(scene)
