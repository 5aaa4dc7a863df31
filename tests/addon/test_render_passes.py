"""Render passes as Blender delivers them: in the multilayer EXR and in the compositor, against the core's own sums."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon import compat, view_layer_panels
from dichromatic_addon.operators import render_layers
from dichromatic_addon.presets import PRESETS, apply_preset
from dichromatic_addon.render_passes import passes_of_layer
from tests.addon.building import add_camera, add_light, add_plane, combined, small_picture
from tests.addon.fake_layout import FakeLayout
from tests.addon.multilayer import compositor, rendered_passes, single_layer
from tests.tolerances import FLOAT32_ROUNDING

pytestmark = pytest.mark.bpy


def preset(name: str) -> Any:
    material = bpy.data.materials.new(name)
    apply_preset(material, next(item for item in PRESETS if item.name == name))
    return material


@pytest.fixture
def table(scene: Any) -> Any:
    """A red plastic floor and a metal sheet under two lamps of different colours, below a bluish sky."""
    plastic = next(item.name for item in PRESETS if item.body)
    metal = next(item.name for item in PRESETS if not item.body)
    add_plane(scene, preset(plastic), name="Floor")
    add_plane(scene, preset(metal), size=1.5, height=0.5, name="Sheet")
    add_light(scene, "POINT", 800.0, (2, -3, 4), shadow_soft_size=0.0)
    warm = add_light(scene, "SPOT", 900.0, (-2, 0, 5), shadow_soft_size=0.0, spot_size=2.0)
    warm.data.color = (1.0, 0.5, 0.2)
    world = bpy.data.worlds.new("Sky")
    if world.node_tree is None:
        world.use_nodes = True
    background = next((n for n in world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground"), None)
    if background is None:
        background = world.node_tree.nodes.new("ShaderNodeBackground")
        output = world.node_tree.nodes.new("ShaderNodeOutputWorld")
        world.node_tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Color"].default_value = (0.2, 0.4, 0.8, 1.0)
    background.inputs["Strength"].default_value = 0.5
    scene.world = world
    add_camera(scene, (0, -6, 3), (math.radians(72), 0, 0))
    small_picture(scene, 40, 24)
    scene.dichromatic.samples = 2
    return scene


def all_light_passes(scene: Any) -> Any:
    layer = scene.view_layers[0]
    layer.dichromatic.use_pass_body = layer.dichromatic.use_pass_interface = True
    layer.use_pass_emit = layer.use_pass_environment = True
    return layer


def test_reflections_emission_and_environment_add_up_to_combined(table: Any, tmp_path: Path) -> None:
    all_light_passes(table)
    found = rendered_passes(table, tmp_path / "passes.exr")
    names = ["Body", "Interface", compat.EMISSION_PASS, compat.ENVIRONMENT_PASS]
    parts = [found[name] for name in names]
    assert [part.shape for part in parts] == [(24, 40, 3)] * 4
    whole = found["Combined"][..., :3]
    np.testing.assert_allclose(sum(parts), whole, atol=4 * FLOAT32_ROUNDING * whole.max())
    body, interface, emission, environment = parts
    assert body.max() > 0.1
    assert interface.max() > 0.03
    assert emission.max() == 0.0
    assert environment[0].min() > 0.0  # above the horizon
    assert environment[-1].max() == body[0].max() == interface[0].max() == 0.0


def test_light_groups_and_the_rest_add_up_to_combined(table: Any, tmp_path: Path) -> None:
    layer = table.view_layers[0]
    for name in ("Key", "Sky", "Empty"):
        layer.lightgroups.add(name=name)
    bpy.data.objects["Point"].lightgroup = "Key"
    table.world.lightgroup = "Sky"
    found = rendered_passes(table, tmp_path / "groups.exr")
    assert {name for name in found if "_" in name} == {"Combined_Key", "Combined_Sky", "Combined_Empty"}
    whole = found["Combined"][..., :3]
    assert found["Combined_Empty"].max() == 0.0
    assert found["Combined_Sky"][0].min() > 0.0
    # The spot is in no group: what is missing is what it gives alone.
    rest = whole - found["Combined_Key"] - found["Combined_Sky"]
    bpy.data.objects["Point"].hide_render = True
    table.world = None
    single_layer(table)
    alone = combined(table, str(tmp_path / "spot.exr"))[..., :3]
    assert alone.max() > 0.05
    np.testing.assert_allclose(rest, alone, atol=4 * FLOAT32_ROUNDING * whole.max())


def test_a_group_named_on_an_object_but_not_in_the_layer_has_no_pass(table: Any) -> None:
    bpy.data.objects["Point"].lightgroup = "Key"
    assert render_layers(table)[0].exported.passes.passes == ()


def test_each_view_layer_has_its_own_passes(table: Any, tmp_path: Path) -> None:
    second = table.view_layers.new("Second")
    table.view_layers[0].use_pass_z = True
    second.dichromatic.use_pass_body = True
    assert [[p.name for p in passes_of_layer(layer)] for layer in table.view_layers] == [["Depth"], ["Body"]]
    found = rendered_passes(table, tmp_path / "layers.exr")
    assert {"Depth", "Body"} <= set(found)


@pytest.mark.parametrize("name", ["Body", "Combined_Key"])
def test_a_pass_reaches_the_compositor(table: Any, tmp_path: Path, name: str) -> None:
    layer = all_light_passes(table)
    layer.lightgroups.add(name="Key")
    bpy.data.objects["Point"].lightgroup = "Key"
    expected = rendered_passes(table, tmp_path / "passes.exr")[name]
    tree, layers, final = compositor(table)
    tree.links.new(layers.outputs[name], final)
    single_layer(table)
    composited = combined(table, str(tmp_path / "composited.exr"))
    assert expected.max() > 0.1
    np.testing.assert_allclose(composited[..., :3], expected, atol=4 * FLOAT32_ROUNDING * expected.max())


def test_previews_and_empty_layers_ask_for_nothing(scene: Any) -> None:
    assert passes_of_layer(scene.view_layers[0]) == ()


def test_one_group_per_light(table: Any) -> None:
    bpy.data.objects["Point"].lightgroup = "Key"
    bpy.data.objects["Spot"].name = "Spot.001"
    assert bpy.ops.dichromatic.light_group_each() == {"FINISHED"}
    assert [group.name for group in table.view_layers[0].lightgroups] == ["Spot_001"]
    assert bpy.data.objects["Point"].lightgroup == "Key"
    assert bpy.data.objects["Spot.001"].lightgroup == "Spot_001"


@pytest.mark.parametrize(
    "panel", [cls for cls in view_layer_panels.CLASSES if "_PT_" in cls.__name__], ids=lambda cls: cls.__name__
)
def test_panels_in_every_state(table: Any, panel: Any) -> None:
    for groups in ((), ("Key",)):
        for name in groups:
            table.view_layers[0].lightgroups.add(name=name)
        for obj in (bpy.data.objects["Floor"], bpy.data.objects["Point"], None):
            context = SimpleNamespace(
                engine="DICHROMATIC",
                scene=table,
                view_layer=table.view_layers[0],
                world=table.world,
                object=obj,
                preferences=bpy.context.preferences,
                region=SimpleNamespace(width=400),
            )
            assert panel.poll(context) or panel.bl_context == "object"
            if panel.poll(context):
                panel.draw(SimpleNamespace(layout=FakeLayout()), context)
            context.engine = "CYCLES"
            assert not panel.poll(context)
