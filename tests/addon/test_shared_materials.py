"""Materials that are linked, overridden, grouped, driven or keyframed, on pixels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon.names import PLASTIC_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes.converting import is_convertible
from dichromatic_addon.nodes.editing import link_spectrum_node, set_surface_node
from tests.addon.building import add_light, add_plane, combined, look_down, small_picture

pytestmark = pytest.mark.bpy

SUN_ON_A_CARD = 2e-3  # float32 pixels, and the uplift of a grey, which is exact


def matte_paint(value: float) -> tuple[Any, Any, Any]:
    """A material of ours with a constant spectrum: itself, its surface node and its Spectrum node."""
    material = bpy.data.materials.new("Paint")
    node = set_surface_node(material, PLASTIC_NODE)
    node.inputs["Interface Reflectance"].default_value = 0.0
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source, spectrum.value = "CONSTANT", value
    return material, node, spectrum


def card(scene: Any, material: Any) -> Any:
    plane = add_plane(scene, material, size=4.0)
    add_light(scene, "SUN", math.pi, angle=0.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    return plane


def seen(scene: Any, path: Path) -> float:
    pixels = combined(scene, str(path / "card.exr"))[..., :3]
    assert np.ptp(pixels) < SUN_ON_A_CARD
    return float(pixels.mean())


def library_file(path: Path, value: float = 0.3) -> str:
    """A file with a material and an object that uses it; the open file is empty again afterwards."""
    material, _, _ = matte_paint(value)
    plane = add_plane(bpy.context.scene, material, size=4.0, name="Card")
    assert plane.users_scene
    file = str(path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.engine = "DICHROMATIC"
    return file


def test_a_linked_material(scene: Any, tmp_path: Path) -> None:
    file = library_file(tmp_path)
    with bpy.data.libraries.load(file, link=True) as (source, target):
        target.materials = source.materials
    card(bpy.context.scene, bpy.data.materials["Paint"])
    assert seen(bpy.context.scene, tmp_path) == pytest.approx(0.3, abs=SUN_ON_A_CARD)
    assert not is_convertible(bpy.data.materials["Paint"])


@pytest.mark.parametrize("what", ["object", "material"])
def test_a_library_override(scene: Any, tmp_path: Path, what: str) -> None:
    """Of an object, which uses the linked material; and of the material itself."""
    file = library_file(tmp_path)
    with bpy.data.libraries.load(file, link=True) as (_, target):
        target.objects = ["Card"]
    linked = bpy.data.objects["Card"]
    override = linked.override_create()
    scene = bpy.context.scene
    scene.collection.objects.link(override)
    override.location.z = 0.5
    if what == "material":
        material = bpy.data.materials["Paint"].override_create()
        assert not is_convertible(material)
        override.material_slots[0].link = "OBJECT"
        override.material_slots[0].material = material
    add_light(scene, "SUN", math.pi, angle=0.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    assert seen(scene, tmp_path) == pytest.approx(0.3, abs=SUN_ON_A_CARD)


@pytest.mark.parametrize("what", ["socket", "property"])
def test_keyframes_reach_the_picture(scene: Any, tmp_path: Path, what: str) -> None:
    material, _, spectrum = matte_paint(0.2)
    card(scene, material)
    owner, name, first, last = (
        (spectrum, "value", 0.2, 0.6) if what == "property" else (spectrum.inputs["Scale"], "default_value", 0.5, 2.0)
    )
    for frame, value in ((1, first), (10, last)):
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)
    for frame, expected in ((1, first), (10, last)):
        scene.frame_set(frame)
        expected = expected if what == "property" else 0.2 * expected
        assert seen(scene, tmp_path) == pytest.approx(expected, abs=SUN_ON_A_CARD)


def test_drivers_reach_the_picture(scene: Any, tmp_path: Path) -> None:
    material, _, spectrum = matte_paint(0.2)
    plane = card(scene, material)
    driver = spectrum.driver_add("value").driver
    variable = driver.variables.new()
    variable.name, variable.targets[0].id = "height", plane
    variable.targets[0].data_path = "location.z"
    driver.expression = "0.1 + height"
    for height in (0.0, 0.5):
        plane.location.z = height
        bpy.context.view_layer.update()
        assert seen(scene, tmp_path) == pytest.approx(0.1 + height, abs=SUN_ON_A_CARD)


def test_a_surface_in_a_group_that_two_materials_share(scene: Any, tmp_path: Path) -> None:
    group = bpy.data.node_groups.new("Kit", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    node, reroute = group.nodes.new(PLASTIC_NODE), group.nodes.new("NodeReroute")
    node.inputs["Interface Reflectance"].default_value = 0.0
    group.links.new(start.outputs["Color"], reroute.inputs[0])
    group.links.new(reroute.outputs[0], node.inputs["Body Reflectance"])
    group.links.new(node.outputs[0], end.inputs[0])
    pictures = []
    materials = []
    for value in (0.25, 0.75):
        material, _, _ = matte_paint(0.5)
        tree = material.node_tree
        outer = tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        spectrum = tree.nodes.new(SPECTRUM_NODE)
        spectrum.source, spectrum.value = "CONSTANT", value
        tree.links.new(spectrum.outputs[0], outer.inputs["Color"])
        tree.links.new(outer.outputs[0], tree.get_output_node("ALL").inputs["Surface"])
        materials.append(material)
    plane = card(scene, materials[0])
    for material in materials:
        plane.material_slots[0].material = material
        pictures.append(seen(scene, tmp_path))
    np.testing.assert_allclose(pictures, (0.25, 0.75), atol=SUN_ON_A_CARD)


def test_a_muted_spectrum_leaves_nothing_to_read(scene: Any, tmp_path: Path) -> None:
    """A muted Spectrum passes its Color input on, as Blender draws it."""
    material, _, spectrum = matte_paint(0.2)
    spectrum.inputs["Color"].default_value = (0.4, 0.4, 0.4, 1.0)
    spectrum.mute = True
    card(scene, material)
    assert seen(scene, tmp_path) == pytest.approx(0.4, abs=SUN_ON_A_CARD)
