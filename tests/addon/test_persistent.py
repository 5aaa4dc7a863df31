"""Persistent data: triangles are gathered once while they stay the same, and never when they do not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon import persistent
from dichromatic_addon._core import core
from dichromatic_addon.operators import render_layers
from tests.addon.building import add_camera, add_light, add_plane, combined, small_picture, white_material

pytestmark = pytest.mark.bpy


@pytest.fixture
def counted(scene: Any, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, list[int]]:
    """A scene with persistent data, and a list that grows whenever triangles are gathered."""
    add_plane(scene, white_material(), name="Floor")
    add_plane(scene, white_material("Other"), size=1.0, height=0.5, name="Sheet")
    add_light(scene, "POINT", 800.0, (1, -1, 4), shadow_soft_size=0.0)
    add_camera(scene)
    small_picture(scene, 16, 16)
    scene.render.use_persistent_data = True
    gathered: list[int] = []
    gather = core.Geometry.from_instances

    def counting(instances: Any, *arguments: Any, **named: Any) -> Any:
        gathered.append(len(instances))
        return gather(instances, *arguments, **named)

    monkeypatch.setattr(core.Geometry, "from_instances", counting)
    persistent.forget()
    return scene, gathered


def test_lamps_materials_and_the_camera_may_change(counted: Any) -> None:
    scene, gathered = counted
    first = render_layers(scene)[0].render.tristimulus()
    bpy.data.lights["Point"].energy = 400.0
    bpy.data.objects["Point"].location.x = 2.0
    bpy.data.materials["Other"].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.5, 0.1, 0.1, 1.0)
    scene.camera.location.x = 0.5
    second = render_layers(scene)[0].render.tristimulus()
    assert gathered == [2]
    assert np.abs(first - second).max() > 0.01
    scene.render.use_persistent_data = False
    assert np.array_equal(render_layers(scene)[0].render.tristimulus(), second)
    assert gathered == [2, 2]


def move(scene: Any) -> None:
    bpy.data.objects["Sheet"].location.x = 0.2


def edit(scene: Any) -> None:
    bpy.data.meshes["Sheet"].vertices[0].co.z = 0.4


def hide(scene: Any) -> None:
    bpy.data.objects["Sheet"].hide_render = True


def no_shadow(scene: Any) -> None:
    bpy.data.objects["Sheet"].visible_shadow = False


def other_precision(scene: Any) -> None:
    scene.dichromatic.precision = "float64"


@pytest.mark.parametrize("change", [move, edit, hide, no_shadow, other_precision], ids=lambda change: change.__name__)
def test_what_changes_triangles_gathers_them_again(counted: Any, tmp_path: Path, change: Any) -> None:
    scene, gathered = counted
    combined(scene, str(tmp_path / "before.exr"))
    change(scene)
    bpy.data.meshes["Sheet"].update()
    after = combined(scene, str(tmp_path / "after.exr"))
    assert len(gathered) == 2
    scene.render.use_persistent_data = False
    assert np.array_equal(combined(scene, str(tmp_path / "afresh.exr")), after)


def test_layers_are_kept_apart_and_files_let_go(counted: Any) -> None:
    scene, gathered = counted
    scene.view_layers.new("Second")
    for _ in range(2):
        render_layers(scene)
    assert gathered == [2, 2]
    assert len(persistent._caches) == 2
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert persistent._caches == {}
