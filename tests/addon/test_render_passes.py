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


# Positions and distances of about 10 m through Blender's float32 camera matrices and the core's float32 rays.
DATA_PASS = 5e-6


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


def test_data_passes_hold_what_the_first_ray_met(table: Any, tmp_path: Path) -> None:
    """Through one ray in each pixel's centre, from the camera's matrices and the planes' equations alone."""
    layer = table.view_layers[0]
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_normal = True
    layer.use_pass_object_index = layer.use_pass_material_index = True
    table.dichromatic.samples, table.dichromatic.pixel_filter, table.dichromatic.filter_width = 1, "box", 0.001
    for number, name in enumerate(("Floor", "Sheet"), start=3):
        bpy.data.objects[name].pass_index = number
        bpy.data.objects[name].data.materials[0].pass_index = 10 * number
    found = rendered_passes(table, tmp_path / "data.exr")
    origin, directions = central_rays(table, 40, 24)
    numbers = np.zeros((24, 40), int)
    nearest = np.full((24, 40), np.inf)
    for number, half, height in ((3, 5.0, 0.0), (4, 0.75, 0.5)):
        along = (height - origin[2]) / directions[..., 2]
        met = origin + along[..., None] * directions
        hit = (along > 0) & (np.abs(met[..., :2]) < half).all(axis=-1) & (along < nearest)
        numbers[hit], nearest[hit] = number, along[hit]
    hit = numbers > 0
    assert set(numbers.ravel()) == {0, 3, 4}
    agree = found[compat.OBJECT_INDEX_PASS][..., 0] == numbers
    assert (~agree).mean() < 0.005  # rays on an edge
    assert np.array_equal(found[compat.MATERIAL_INDEX_PASS], 10 * found[compat.OBJECT_INDEX_PASS])
    # Directions are scaled to 1 along the view axis, so that `nearest` is the depth.
    both = hit & agree
    np.testing.assert_allclose(found["Depth"][both, 0], nearest[both], rtol=DATA_PASS)
    position = origin + nearest[both][:, None] * directions[both]
    np.testing.assert_allclose(found["Position"][both], position, atol=20 * DATA_PASS)
    np.testing.assert_allclose(found["Normal"][both], np.broadcast_to([0.0, 0.0, 1.0], position.shape), atol=DATA_PASS)
    empty = ~hit & agree
    assert empty.any()
    assert (found["Depth"][empty] >= 1e9).all()
    assert np.abs(found["Normal"][empty]).max() == np.abs(found["Position"][empty]).max() == 0.0


def central_rays(scene: Any, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Origin and directions (H, W, 3) of the rays through the pixels' centres, of length 1 along the view axis."""
    camera = scene.camera
    matrix = np.array(camera.matrix_world)
    half = 0.5 * camera.data.sensor_width / camera.data.lens
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * half
    y = -((np.arange(height) + 0.5) / height * 2 - 1) * half * height / width
    local = np.stack([*np.meshgrid(x, y), -np.ones((height, width))], axis=-1)
    return matrix[:3, 3], local @ matrix[:3, :3].T


def test_the_shadow_pass_holds_the_part_of_the_light_that_arrives(table: Any, tmp_path: Path) -> None:
    table.world.dichromatic.lights_surfaces = False  # lamps alone, whose shadows are total
    table.view_layers[0].use_pass_shadow = True
    bpy.data.objects["Spot"].hide_render = True
    shadow = rendered_passes(table, tmp_path / "shadow.exr")["Shadow"]
    assert shadow.shape == (24, 40, 3)
    assert (shadow[0] == 1.0).all()  # the sky
    assert np.array_equal(shadow[..., 0], shadow[..., 1])
    occluded = render_layers(table)[0].render.film.planes["occluded"]
    assert occluded.max() == 1.0
    np.testing.assert_allclose(shadow[..., 0], 1.0 - occluded, atol=FLOAT32_ROUNDING)
    bpy.data.objects["Sheet"].visible_shadow = False
    assert (rendered_passes(table, tmp_path / "without.exr")["Shadow"] == 1.0).all()


def test_a_holdout_is_a_hole_in_any_film(table: Any, tmp_path: Path) -> None:
    plain = combined(table, str(tmp_path / "plain.exr"))
    bpy.data.objects["Sheet"].is_holdout = True
    held = combined(table, str(tmp_path / "held.exr"))
    assert (plain[..., 3] == 1.0).all()
    hole = held[..., 3] == 0.0
    assert 0.01 < hole.mean() < 0.3
    assert np.abs(held[hole]).max() == 0.0
    kept = held[..., 3] == 1.0
    np.testing.assert_allclose(held[kept], plain[kept], atol=FLOAT32_ROUNDING)
    table.render.film_transparent = True
    transparent = combined(table, str(tmp_path / "transparent.exr"))
    assert np.array_equal(transparent[..., 3] == 0.0, hole | (transparent[..., 3] == 0.0))
    assert (transparent[0, :, 3] == 0.0).all()
    assert (transparent[hole, 3] == 0.0).all()


def test_a_shadow_catcher_is_the_shadow_alone(table: Any, tmp_path: Path) -> None:
    table.render.film_transparent = True
    table.world.dichromatic.lights_surfaces = False
    bpy.data.objects["Floor"].is_shadow_catcher = True
    bpy.data.objects["Sheet"].visible_camera = False
    bpy.data.objects["Spot"].hide_render = True
    caught = combined(table, str(tmp_path / "caught.exr"))
    assert caught[..., :3].max() == 0.0
    assert caught[..., 3].max() == 1.0
    assert caught[..., 3].mean() < 0.2
    bpy.data.objects["Floor"].is_shadow_catcher = False
    lit = combined(table, str(tmp_path / "lit.exr"))[..., 1]
    # Black where the shadow is, and nowhere else on the floor.
    floor = lit[12:] > 0.0
    assert (caught[12:, :, 3][~floor] == 1.0).all()
    assert (caught[12:, :, 3] == 0.0)[floor].mean() > 0.95  # but for pixels on the shadow's edge


def test_glowing_surfaces_have_their_pass_and_their_group(table: Any, tmp_path: Path) -> None:
    layer = all_light_passes(table)
    glow = bpy.data.materials.new("Glow")
    if glow.node_tree is None:
        glow.use_nodes = True
    tree = glow.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 3.0
    tree.links.new(emission.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    lamp = add_plane(table, glow, size=0.8, height=1.5, name="Lamp")
    lamp.lightgroup = "Glow"
    layer.lightgroups.add(name="Glow")
    found = rendered_passes(table, tmp_path / "glow.exr")
    whole = found["Combined"][..., :3]
    parts = [found[name] for name in ("Body", "Interface", compat.EMISSION_PASS, compat.ENVIRONMENT_PASS)]
    np.testing.assert_allclose(sum(parts), whole, atol=4 * FLOAT32_ROUNDING * whole.max())
    seen = found[compat.EMISSION_PASS]
    assert seen.max() == pytest.approx(3.0, rel=2e-3)
    assert (seen.max(axis=-1) > 0.0).mean() < 0.2
    # The group holds what is seen of the lamp and what it lights: the floor as well.
    group = found["Combined_Glow"]
    assert (group >= seen * (1.0 - 10 * FLOAT32_ROUNDING)).all()
    assert 0.0 < group[-1].max() < 1.0


def test_a_view_layer_overrides_the_world(table: Any) -> None:
    second = table.view_layers.new("Second")
    dark = bpy.data.worlds.new("Dark")
    if dark.node_tree is None:
        dark.use_nodes = True
    dark.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    dark.lightgroup = "Night"
    second.world_override = dark
    first, other = (finished.exported for finished in render_layers(table))
    assert first.scene.world.strength > 0.0 == other.scene.world.strength
    assert (first.passes.emitter_groups[-1], other.passes.emitter_groups[-1]) == ("", "Night")


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


def test_mirrored_light_that_is_carried_at_wavelengths_is_in_the_passes_too(table: Any, tmp_path: Path) -> None:
    layer = all_light_passes(table)
    layer.lightgroups.add(name="Key")
    bpy.data.objects["Point"].lightgroup = "Key"
    for name in ("Floor", "Sheet"):
        for node in bpy.data.objects[name].data.materials[0].node_tree.nodes:
            if "Mirror" in node.inputs:
                node.inputs["Mirror"].default_value = 0.8
    bpy.data.objects["Sheet"].rotation_euler.x = 1.2
    table.dichromatic.bounce_spectra, table.dichromatic.bounce_grid = "nodes", "draft"
    found = rendered_passes(table, tmp_path / "nodes.exr")
    assert not render_layers(table)[0].render.film.is_relightable
    whole = found["Combined"][..., :3]
    parts = [found[name] for name in ("Body", "Interface", compat.EMISSION_PASS, compat.ENVIRONMENT_PASS)]
    np.testing.assert_allclose(sum(parts), whole, atol=4 * FLOAT32_ROUNDING * whole.max())
    assert 0.0 < found["Combined_Key"].sum() < whole.sum()


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
