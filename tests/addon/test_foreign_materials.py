"""Shaders of an existing scene: what is made of each, and of their mixtures; by closed forms and beside Cycles."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon.names import METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes.editing import set_surface_node
from dichromatic_addon.nodes.reading import read_material
from dichromatic_addon.operators import render_layers
from tests.addon.building import add_light, add_plane, combined, look_down, small_picture
from tests.tolerances import BLENDER_FLOAT, EXPOSURE_AGAINST_CYCLES, REC709_ROUND_TRIP

pytestmark = pytest.mark.bpy


def grey(value: float) -> tuple[float, float, float, float]:
    return (value, value, value, 1.0)


def new_tree(name: str = "Foreign") -> tuple[Any, Any, Any]:
    """A material with nothing but an output: itself, its tree and the Surface input."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes.clear()
    output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    return material, material.node_tree, output.inputs["Surface"]


def shader(tree: Any, kind: str, target: Any = None, **values: Any) -> Any:
    made = tree.nodes.new(kind)
    for name, value in values.items():
        made.inputs[name.replace("_", " ")].default_value = value
    if target is not None:
        tree.links.new(made.outputs[0], target)
    return made


def mixed(tree: Any, target: Any, factor: float) -> Any:
    made = shader(tree, "ShaderNodeMixShader", target)
    made.inputs[0].default_value = factor
    return made


def near(value: float) -> Any:
    return pytest.approx(value, rel=10 * BLENDER_FLOAT)


def test_two_matte_shaders_are_averaged(scene: Any) -> None:
    material, tree, target = new_tree()
    mix = mixed(tree, target, 0.25)
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[1], Color=grey(0.8))
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=grey(0.4))
    read = read_material(material).material
    assert isinstance(read, core.TypeI)
    assert read.body_reflectance.is_constant
    assert read.body_reflectance.values[0] == near(0.7)
    assert read.interface_reflectance == 0.0


def test_diffuse_and_white_gloss_are_plastic(scene: Any) -> None:
    """A lobe of width a = roughness^2 has the peak F / (4 a^2); cos(rho)^n has its width at n = 1 / (2 a^2)."""
    material, tree, target = new_tree()
    mix = mixed(tree, target, 0.04)
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[1], Color=(0.7, 0.1, 0.1, 1.0))
    shader(tree, "ShaderNodeBsdfAnisotropic", mix.inputs[2], Color=grey(1.0), Roughness=0.5)
    read = read_material(material).material
    assert isinstance(read, core.TypeI)
    assert read.n == near(1.0 / (2.0 * 0.25**2))
    assert read.interface_reflectance == near(0.04 / (4.0 * 0.25**2))
    assert read.mirror == 0.0


def test_diffuse_and_coloured_gloss_are_cloth(scene: Any) -> None:
    material, tree, target = new_tree()
    both = shader(tree, "ShaderNodeAddShader", target)
    shader(tree, "ShaderNodeBsdfDiffuse", both.inputs[0], Color=grey(0.3))
    shader(tree, "ShaderNodeBsdfAnisotropic", both.inputs[1], Color=(0.4, 0.2, 0.1, 1.0), Roughness=0.5)
    read = read_material(material).material
    assert isinstance(read, core.TypeII)
    expected = core.uplift([0.4, 0.2, 0.1]).at([450.0, 550.0, 650.0]) / (4.0 * 0.25**2)
    np.testing.assert_allclose(read.interface_reflectance.at([450.0, 550.0, 650.0]), expected, rtol=REC709_ROUND_TRIP)


def test_metals_of_one_roughness_stay_a_metal(scene: Any) -> None:
    material, tree, target = new_tree()
    mix = mixed(tree, target, 0.5)
    for index, value in ((1, 0.9), (2, 0.5)):
        shader(tree, "ShaderNodeBsdfAnisotropic", mix.inputs[index], Color=grey(value), Roughness=0.3)
    read = read_material(material).material
    assert isinstance(read, core.TypeIII)
    assert read.normal_reflectance.values[0] == near(0.7)
    assert read.beta == near(0.09 * math.sqrt(math.log(2.0)))
    assert read.mirror == near(1.0)


@pytest.mark.parametrize(("roughness", "share"), [(0.0, 1.0), (0.3, 1.0), (0.4, 0.5), (0.5, 0.0), (1.0, 0.0)])
def test_smooth_metals_mirror_the_scene(scene: Any, roughness: float, share: float) -> None:
    material, tree, target = new_tree()
    shader(tree, "ShaderNodeBsdfAnisotropic", target, Color=grey(0.6), Roughness=roughness)
    assert read_material(material).material.mirror == pytest.approx(share, abs=1e-6)


def test_smooth_plastic_mirrors_what_its_index_says(scene: Any) -> None:
    material, tree, target = new_tree()
    shader(tree, "ShaderNodeBsdfPrincipled", target, Roughness=0.1, IOR=1.5)
    assert read_material(material).material.mirror == near(0.04)


def test_our_nodes_mix_with_blenders(scene: Any) -> None:
    material, tree, _ = new_tree()
    plastic = set_surface_node(material, PLASTIC_NODE)
    target = tree.get_output_node("ALL").inputs["Surface"]
    spectrum = shader(tree, SPECTRUM_NODE, plastic.inputs["Body Reflectance"])
    spectrum.library_name = "plastic blue"
    mix = mixed(tree, target, 0.5)
    tree.links.new(plastic.outputs[0], mix.inputs[1])
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=grey(0.4))
    reading = read_material(material)
    at = np.array([450.0, 550.0, 650.0])
    blue = core.reflectance("plastic blue").at(at)
    np.testing.assert_allclose(reading.material.body_reflectance.at(at), 0.5 * blue + 0.2, rtol=1e-6)
    assert reading.material.n == plastic.inputs["n"].default_value
    assert reading.material.interface_reflectance == near(0.5 * plastic.inputs["Interface Reflectance"].default_value)


def test_our_metal_over_a_body_is_a_coloured_highlight(scene: Any) -> None:
    material, tree, _ = new_tree()
    metal = set_surface_node(material, METAL_NODE)
    target = tree.get_output_node("ALL").inputs["Surface"]
    both = shader(tree, "ShaderNodeAddShader", target)
    tree.links.new(metal.outputs[0], both.inputs[0])
    shader(tree, "ShaderNodeBsdfDiffuse", both.inputs[1], Color=grey(0.1))
    reading = read_material(material)
    assert isinstance(reading.material, core.TypeII)
    width_squared = metal.inputs["beta"].default_value ** 2 / math.log(2.0)
    copper = core.TypeIII.from_optical_constants(core.optical_constants("copper"), beta=0.1).normal_reflectance
    peak = copper.at([600.0]) / (4.0 * width_squared)
    np.testing.assert_allclose(reading.material.interface_reflectance.at([600.0]), peak, rtol=1e-6)
    assert "metal is mixed with a body" in "".join(reading.notes)


def test_the_same_node_inside_and_outside_a_group(scene: Any) -> None:
    group = bpy.data.node_groups.new("Kit", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    source, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    mix = mixed(group, end.inputs["Shader"], 0.5)
    for index in (1, 2):
        group.links.new(source.outputs["Color"], shader(group, "ShaderNodeBsdfDiffuse", mix.inputs[index]).inputs[0])
    material, tree, target = new_tree()
    outer = shader(tree, "ShaderNodeGroup")
    outer.node_tree = group
    outer.inputs["Color"].default_value = grey(0.35)
    tree.links.new(outer.outputs[0], target)
    assert read_material(material).material.body_reflectance.values[0] == near(0.35)


def test_emission_is_read_as_light(scene: Any) -> None:
    material, tree, target = new_tree()
    both = shader(tree, "ShaderNodeAddShader", target)
    shader(tree, "ShaderNodeEmission", both.inputs[0], Color=grey(0.5), Strength=4.0)
    shader(tree, "ShaderNodeBsdfDiffuse", both.inputs[1], Color=grey(0.2))
    reading = read_material(material)
    assert reading.glow.strength == near(2.0)
    assert reading.glow.illuminant == core.illuminant("D65")
    assert reading.material.body_reflectance.values[0] == near(0.2)


def test_emission_of_a_principled(scene: Any) -> None:
    material, tree, target = new_tree()
    shader(tree, "ShaderNodeBsdfPrincipled", target, Emission_Color=grey(1.0), Emission_Strength=3.0)
    assert read_material(material).glow.strength == near(3.0)


@pytest.mark.parametrize("kind", ["ShaderNodeBlackbody", SPECTRUM_NODE])
def test_emission_takes_the_spectrum_of_a_node(scene: Any, kind: str) -> None:
    material, tree, target = new_tree()
    emission = shader(tree, "ShaderNodeEmission", target, Strength=2.0)
    source = shader(tree, kind, emission.inputs["Color"])
    if kind == SPECTRUM_NODE:
        source.source, source.library_name = "LIBRARY", "FL2"
        expected = core.illuminant("FL2")
    else:
        source.inputs[0].default_value = 3000.0
        expected = core.blackbody(3000.0)
    reading = read_material(material)
    assert reading.glow.illuminant == expected
    assert reading.glow.strength == near(2.0)


@pytest.mark.parametrize(
    ("kind", "values", "words"),
    [
        ("ShaderNodeBsdfPrincipled", {"Alpha": 0.5}, "alpha"),
        ("ShaderNodeBsdfPrincipled", {"Transmission_Weight": 1.0}, "transmission"),
        ("ShaderNodeBsdfPrincipled", {"Subsurface_Weight": 1.0}, "light below the surface"),
        ("ShaderNodeBsdfPrincipled", {"Coat_Weight": 1.0}, "the coat"),
        ("ShaderNodeBsdfPrincipled", {"Sheen_Weight": 1.0}, "the sheen"),
        ("ShaderNodeBsdfPrincipled", {"Metallic": 1.0, "Anisotropic": 0.5}, "equally rough"),
        ("ShaderNodeBsdfGlass", {}, "lets no light through"),
        ("ShaderNodeBsdfRefraction", {}, "lets no light through"),
        ("ShaderNodeBsdfTranslucent", {}, "through the thin sheet"),
        ("ShaderNodeSubsurfaceScattering", {}, "below the surface"),
        ("ShaderNodeBsdfSheen", {}, "the sheen"),
        ("ShaderNodeBsdfToon", {}, "stepped light"),
        ("ShaderNodeBsdfHair", {}, "matte surface of its color"),
        ("ShaderNodeBsdfHairPrincipled", {}, "matte surface of its color"),
        ("ShaderNodeHoldout", {}, "no hole"),
    ],
)
def test_what_is_approximated_is_said_once(scene: Any, kind: str, values: dict[str, Any], words: str) -> None:
    material, tree, target = new_tree()
    mix = mixed(tree, target, 0.5)
    made = shader(tree, kind, mix.inputs[1], **values)
    tree.links.new(made.outputs[0], mix.inputs[2])  # met twice, told once
    reading = read_material(material)
    assert sum(words in note for note in reading.notes) == 1
    assert all(note.startswith("material 'Foreign': ") for note in reading.notes)
    assert reading.material.body_reflectance.values.min() >= 0.0 if hasattr(reading.material, "body_reflectance") else 1


@pytest.mark.parametrize("what", ["volume", "transparent"])
def test_what_cycles_does_not_show_is_left_out(scene: Any, what: str, tmp_path: Path) -> None:
    material, tree, target = new_tree()
    if what == "volume":
        scatter = tree.nodes.new("ShaderNodeVolumeScatter")
        tree.links.new(scatter.outputs[0], target.node.inputs["Volume"])
    else:
        shader(tree, "ShaderNodeBsdfTransparent", target)
    assert read_material(material).is_invisible
    add_plane(scene, material, size=4.0, height=1.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    exported = render_layers(scene)[0].exported
    assert len(exported.scene.instances) == 0
    assert any("left out" in note for note in exported.notes)


def test_displacement_and_volume_are_noted(scene: Any) -> None:
    material, tree, target = new_tree()
    shader(tree, "ShaderNodeBsdfDiffuse", target)
    shader(tree, "ShaderNodeDisplacement", target.node.inputs["Displacement"])
    shader(tree, "ShaderNodeVolumeScatter", target.node.inputs["Volume"])
    notes = read_material(material).notes
    assert "material 'Foreign': its displacement is not rendered" in notes
    assert "material 'Foreign': its volume is not rendered" in notes


def test_mixtures_with_transparency_are_opaque(scene: Any) -> None:
    material, tree, target = new_tree()
    mix = mixed(tree, target, 0.25)
    shader(tree, "ShaderNodeBsdfTransparent", mix.inputs[1])
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=grey(0.4))
    reading = read_material(material)
    assert reading.material.body_reflectance.values[0] == near(0.4)
    assert not reading.is_invisible
    assert "opaque" in "".join(reading.notes)


def test_a_cycle_of_shaders_is_reported(scene: Any) -> None:
    material, tree, target = new_tree()
    first, second = mixed(tree, target, 0.5), mixed(tree, None, 0.5)
    tree.links.new(second.outputs[0], first.inputs[1])
    tree.links.new(first.outputs[0], second.inputs[1])
    with pytest.raises(core.SceneError, match="cycle"):
        read_material(material)


MATERIALS: dict[str, Any] = {
    "mix of mattes": lambda tree, target: [
        mix := mixed(tree, target, 0.3),
        shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[1], Color=(0.8, 0.2, 0.1, 1.0)),
        shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=(0.1, 0.3, 0.6, 1.0)),
    ],
    "added mattes": lambda tree, target: [
        both := shader(tree, "ShaderNodeAddShader", target),
        shader(tree, "ShaderNodeBsdfDiffuse", both.inputs[0], Color=(0.3, 0.2, 0.1, 1.0)),
        shader(tree, "ShaderNodeBsdfDiffuse", both.inputs[1], Color=(0.1, 0.3, 0.5, 1.0)),
    ],
    "matte Principled": lambda tree, target: [
        shader(tree, "ShaderNodeBsdfPrincipled", target, Base_Color=(0.6, 0.3, 0.1, 1.0), Specular_IOR_Level=0.0)
    ],
}


@pytest.mark.parametrize("name", MATERIALS)
def test_matte_materials_have_cycles_colour(scene: Any, tmp_path: Path, name: str) -> None:
    """Under a sun that leaves the highlight outside the picture."""
    material, tree, target = new_tree()
    MATERIALS[name](tree, target)
    add_plane(scene, material, size=4.0)
    add_light(scene, "SUN", math.pi, angle=0.0).rotation_euler = (0.7, 0.0, 0.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    scene.cycles.samples, scene.cycles.use_denoising = 64, False
    pictures = []
    for engine in ("DICHROMATIC", "CYCLES"):
        scene.render.engine = engine
        pictures.append(combined(scene, str(tmp_path / f"{engine}.exr"))[..., :3].mean(axis=(0, 1)))
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=EXPOSURE_AGAINST_CYCLES)
