"""Reading materials: what the nodes say, through every kind of link, and what is made of other shaders."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon.names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_MIX_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes import handlers
from dichromatic_addon.nodes.editing import link_spectrum_node, set_surface_node
from dichromatic_addon.nodes.reading import link_problems, read_material
from tests.tolerances import BLENDER_FLOAT, FLOAT64_ROUNDING

pytestmark = pytest.mark.bpy


@pytest.fixture
def plastic(scene):
    """A plastic material, its tree and its surface node."""
    material = bpy.data.materials.new("Cup")
    node = set_surface_node(material, PLASTIC_NODE)
    return material, material.node_tree, node


def new_spectrum(tree, value=0.25):
    node = tree.nodes.new(SPECTRUM_NODE)
    node.source, node.value = "CONSTANT", value
    return node


def body(material):
    return read_material(material).material.body_reflectance


def test_plastic(plastic):
    material, _, node = plastic
    node.inputs["Body Reflectance"].default_value = (0.5, 0.5, 0.5, 1.0)
    node.inputs["Interface Reflectance"].default_value = 5.0
    node.inputs["n"].default_value = 11.0
    node.inputs["Mirror"].default_value = 0.25
    node.attenuation = "exponential"
    node.energy_conserving = True
    reading = read_material(material)
    assert reading.notes == ()
    assert reading.material == core.TypeI(core.Spectrum.constant(0.5), 5.0, "exponential", 11.0, True, 0.25)


def test_cloth(scene):
    material = bpy.data.materials.new("Satin")
    node = set_surface_node(material, CLOTH_NODE)
    link_spectrum_node(material.node_tree, node, "Body Reflectance").source = "LIBRARY"
    node.inputs["Body Reflectance"].links[0].from_node.library_name = "satin green body"
    interface = link_spectrum_node(material.node_tree, node, "Interface Reflectance")
    interface.source, interface.library_name = "LIBRARY", "satin green interface"
    interface.inputs["Scale"].default_value = 2.0
    read = read_material(material).material
    assert isinstance(read, core.TypeII)
    assert read.body_reflectance == core.reflectance("satin green body")
    assert read.interface_reflectance == core.reflectance("satin green interface").scaled(2.0)


def test_metal(scene):
    material = bpy.data.materials.new("Ball")
    node = set_surface_node(material, METAL_NODE)
    node.metal = "gold"
    node.inputs["beta"].default_value = math.radians(8.0)
    read = read_material(material).material
    assert isinstance(read, core.TypeIII)
    assert read.beta == pytest.approx(math.radians(8.0), rel=BLENDER_FLOAT)
    assert read.beta_across is None
    expected = core.TypeIII.from_optical_constants(core.optical_constants("gold"), beta=0.1)
    assert read.normal_reflectance == expected.normal_reflectance
    node.anisotropic = True
    node.inputs["beta across"].default_value = math.radians(20.0)
    assert read_material(material).material.beta_across == pytest.approx(math.radians(20.0), rel=BLENDER_FLOAT)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"source": "LIBRARY", "library_name": "plastic blue"}, lambda: core.reflectance("plastic blue")),
        ({"source": "LIBRARY", "library_name": "D65"}, lambda: core.illuminant("D65")),
        ({"source": "TEMPERATURE", "radiator": "BLACKBODY", "temperature": 3200.0}, lambda: core.blackbody(3200.0)),
        ({"source": "TEMPERATURE", "radiator": "DAYLIGHT", "temperature": 5000.0}, lambda: core.daylight(5000.0)),
        (
            {"source": "GAUSSIAN", "centre_nm": 500.0, "width_nm": 50.0, "peak": 0.75, "base": 0.125},
            lambda: core.gaussian(500.0, 50.0, 0.75, 0.125),
        ),
        ({"source": "CONSTANT", "value": 0.375}, lambda: core.Spectrum.constant(0.375)),
    ],
)
def test_each_source_of_a_spectrum(plastic, settings, expected):
    material, tree, node = plastic
    spectrum = link_spectrum_node(tree, node, "Body Reflectance")
    for name, value in settings.items():
        setattr(spectrum, name, value)
    assert body(material) == expected()
    assert link_problems(spectrum) == []


def test_an_unlinked_colour_is_uplifted_to_that_colour(plastic):
    material, _, node = plastic
    colour = (0.05, 0.3, 0.7)
    node.inputs["Body Reflectance"].default_value = (*colour, 1.0)
    values = body(material).at(core.REFERENCE_WAVELENGTHS_NM)
    weights = core.tristimulus_weights(
        core.illuminant("D65"), core.observer("cie_1931_2"), core.wavelength_grid("exact")
    )
    seen = core.display("srgb").linear(values @ weights)
    assert tuple(seen) == pytest.approx(colour, abs=2e-4)  # sRGB's four-digit white against the tabled D65


def test_a_strong_interface_colour_keeps_its_strength(scene):
    material = bpy.data.materials.new("Satin")
    node = set_surface_node(material, CLOTH_NODE)
    node.inputs["Interface Reflectance"].default_value = (5.0, 5.0, 5.0, 1.0)
    assert read_material(material).material.interface_reflectance == core.Spectrum.constant(5.0)


@pytest.mark.parametrize("node_type", ["ShaderNodeRGB", "ShaderNodeValue"])
def test_plain_constants_are_spectra(plastic, node_type):
    material, tree, node = plastic
    source = tree.nodes.new(node_type)
    source.outputs[0].default_value = (0.5, 0.5, 0.5, 1.0) if node_type == "ShaderNodeRGB" else 0.5
    tree.links.new(source.outputs[0], node.inputs["Body Reflectance"])
    assert body(material) == core.Spectrum.constant(0.5)


def test_a_value_node_drives_a_number(plastic):
    material, tree, node = plastic
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = 42.0
    tree.links.new(value.outputs[0], node.inputs["n"])
    assert read_material(material).material.n == 42.0


def test_reroutes_are_followed(plastic):
    material, tree, node = plastic
    previous = new_spectrum(tree).outputs[0]
    for _ in range(3):
        reroute = tree.nodes.new("NodeReroute")
        tree.links.new(previous, reroute.inputs[0])
        previous = reroute.outputs[0]
    tree.links.new(previous, node.inputs["Body Reflectance"])
    assert body(material) == core.Spectrum.constant(0.25)


def test_a_muted_link_is_no_link(plastic):
    material, tree, node = plastic
    node.inputs["Body Reflectance"].default_value = (0.5, 0.5, 0.5, 1.0)
    link = tree.links.new(new_spectrum(tree).outputs[0], node.inputs["Body Reflectance"])
    link.is_muted = True
    assert body(material) == core.Spectrum.constant(0.5)


def test_a_muted_node_passes_its_input_on(plastic):
    material, tree, node = plastic
    gamma = tree.nodes.new("ShaderNodeGamma")
    tree.links.new(new_spectrum(tree).outputs[0], gamma.inputs["Color"])
    tree.links.new(gamma.outputs[0], node.inputs["Body Reflectance"])
    with pytest.raises(core.SceneError, match="'Gamma', behind which 'Spectrum' gives neither"):
        read_material(material)
    gamma.mute = True
    assert body(material) == core.Spectrum.constant(0.25)


def user_group(name, inputs=(), outputs=()):
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for socket, kind in inputs:
        tree.interface.new_socket(socket, in_out="INPUT", socket_type=kind)
    for socket, kind in outputs:
        tree.interface.new_socket(socket, in_out="OUTPUT", socket_type=kind)
    return tree, tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")


def test_a_surface_node_inside_a_user_group_reads_inputs_from_outside(scene):
    inner, source, target = user_group(
        "Paint Kit", [("Color", "NodeSocketColor"), ("Gloss", "NodeSocketFloat")], [("Shader", "NodeSocketShader")]
    )
    node = inner.nodes.new(PLASTIC_NODE)
    inner.links.new(source.outputs["Color"], node.inputs["Body Reflectance"])
    inner.links.new(source.outputs["Gloss"], node.inputs["n"])
    inner.links.new(node.outputs["Surface"], target.inputs["Shader"])
    outer, outer_source, outer_target = user_group(
        "Wrapper", [("Color", "NodeSocketColor")], [("Shader", "NodeSocketShader")]
    )
    nested = outer.nodes.new("ShaderNodeGroup")
    nested.node_tree = inner
    nested.inputs["Gloss"].default_value = 23.0
    outer.links.new(outer_source.outputs["Color"], nested.inputs["Color"])
    outer.links.new(nested.outputs["Shader"], outer_target.inputs["Shader"])

    readings = {}
    for value in (0.25, 0.75):
        material = bpy.data.materials.new(f"Uses {value}")
        set_surface_node(material, PLASTIC_NODE)
        tree = material.node_tree
        group = tree.nodes.new("ShaderNodeGroup")
        group.node_tree = outer
        tree.links.new(group.outputs["Shader"], tree.get_output_node("ALL").inputs["Surface"])
        tree.links.new(new_spectrum(tree, value).outputs[0], group.inputs["Color"])
        readings[value] = read_material(material).material
    assert {value: read.body_reflectance for value, read in readings.items()} == {
        value: core.Spectrum.constant(value) for value in readings
    }
    assert readings[0.25].n == 23.0


def test_a_spectrum_inside_a_user_group_reaches_the_surface(plastic):
    material, tree, node = plastic
    inner, _, target = user_group("Pigments", outputs=[("Blue", "NodeSocketColor")])
    inner.links.new(new_spectrum(inner).outputs[0], target.inputs["Blue"])
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    tree.links.new(group.outputs["Blue"], node.inputs["Body Reflectance"])
    assert body(material) == core.Spectrum.constant(0.25)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda tree: tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], "which gives no spectrum"),
        (lambda tree: tree.nodes.new("ShaderNodeBsdfDiffuse").outputs["BSDF"], "which gives no spectrum"),
    ],
)
def test_what_cannot_be_a_spectrum_is_named(plastic, make, message):
    material, tree, node = plastic
    tree.links.new(make(tree), node.inputs["Body Reflectance"])
    with pytest.raises(
        core.SceneError, match="Body Reflectance of node 'Dichromatic Plastic' in material 'Cup': .*" + message
    ):
        read_material(material)
    assert message in "".join(link_problems(node))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"source": "LIBRARY", "library_name": "unobtainium"}, "no spectrum 'unobtainium'"),
        ({"source": "FILE"}, "no spectrum file is chosen"),
        ({"source": "FILE", "filepath": "/nowhere/gone.csv"}, "gone.csv"),
        ({"source": "TEMPERATURE", "radiator": "DAYLIGHT", "temperature": 2000.0}, "4000"),
    ],
)
def test_a_spectrum_that_cannot_be_had_is_named(plastic, settings, message):
    material, tree, node = plastic
    spectrum = link_spectrum_node(tree, node, "Body Reflectance")
    for name, value in settings.items():
        setattr(spectrum, name, value)
    with pytest.raises(core.SceneError, match="Spectrum of node 'Spectrum' in material 'Cup'") as caught:
        read_material(material)
    assert message in str(caught.value)
    assert message in "".join(link_problems(spectrum))


def test_a_number_from_a_texture_is_named(plastic):
    material, tree, node = plastic
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], node.inputs["n"])
    with pytest.raises(core.SceneError, match="n of node 'Dichromatic Plastic' in material 'Cup'"):
        read_material(material)


def test_an_unknown_metal_is_named(scene):
    material = bpy.data.materials.new("Ball")
    node = set_surface_node(material, METAL_NODE)
    node.metal = "mithril"
    with pytest.raises(core.SceneError, match=r"node 'Dichromatic Metal' in material 'Ball': .*mithril"):
        read_material(material)
    assert "mithril" in "".join(link_problems(node))


def test_a_lost_hidden_group_is_told_and_mended_at_the_next_load(plastic):
    material, _, node = plastic
    bpy.data.node_groups.remove(node.node_tree)
    assert "hidden node group is missing" in "".join(link_problems(node))
    handlers._after_load()
    assert link_problems(node) == []
    assert [socket.name for socket in node.inputs] == [recipe.name for recipe in node.recipe.inputs]
    material.node_tree.links.new(node.outputs[0], material.node_tree.get_output_node("ALL").inputs["Surface"])
    assert isinstance(read_material(material).material, core.TypeI)


def test_a_cycle_of_links_is_reported_and_does_not_hang(plastic):
    material, tree, node = plastic
    first, second = tree.nodes.new("NodeReroute"), tree.nodes.new("NodeReroute")
    tree.links.new(first.outputs[0], second.inputs[0])
    tree.links.new(second.outputs[0], first.inputs[0])
    tree.links.new(second.outputs[0], node.inputs["Body Reflectance"])
    with pytest.raises(core.SceneError, match="form a cycle"):
        read_material(material)


# ---- mixtures


def new_mix(tree, first, second, factor, operation="MIX"):
    mix = tree.nodes.new(SPECTRUM_MIX_NODE)
    mix.operation = operation
    mix.inputs["Factor"].default_value = factor
    tree.links.new(first.outputs[0], mix.inputs["A"])
    tree.links.new(second.outputs[0], mix.inputs["B"])
    return mix


@pytest.mark.parametrize(
    ("operation", "factor", "expected"),
    [("MIX", 0.25, 0.75 * 0.5 + 0.25 * 0.25), ("MULTIPLY", 1.0, 0.5 * 0.25), ("MULTIPLY", 0.0, 0.5)],
)
def test_two_constants_mix_to_a_constant(plastic, operation, factor, expected):
    material, tree, node = plastic
    mix = new_mix(tree, new_spectrum(tree, 0.5), new_spectrum(tree, 0.25), factor, operation)
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    assert body(material) == core.Spectrum.constant(expected)


def test_spectra_mix_wavelength_by_wavelength(plastic):
    material, tree, node = plastic
    first, second = new_spectrum(tree), new_spectrum(tree)
    first.source, first.library_name = "LIBRARY", "plastic blue"
    second.source, second.centre_nm, second.width_nm = "GAUSSIAN", 589.3, 0.5  # a line between whole nanometres
    mix = new_mix(tree, first, second, 0.5)
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    read = body(material)
    line = core.gaussian(second.centre_nm, second.width_nm, second.peak, second.base)
    at = read.wavelengths_nm
    assert np.abs(at - line.wavelengths_nm[96]).min() == 0.0  # the peak is among the samples
    expected = 0.5 * core.reflectance("plastic blue").at(at) + 0.5 * line.at(at)
    np.testing.assert_allclose(read.values, expected, rtol=FLOAT64_ROUNDING)


def test_mixtures_of_mixtures_and_their_removal(plastic):
    material, tree, node = plastic
    inner = new_mix(tree, new_spectrum(tree, 0.5), new_spectrum(tree, 0.25), 0.5)
    outer = new_mix(tree, inner, new_spectrum(tree, 0.5), 1.0, "MULTIPLY")
    tree.links.new(outer.outputs[0], node.inputs["Body Reflectance"])
    assert body(material) == core.Spectrum.constant(0.1875)
    assert link_problems(outer) == link_problems(node) == []
    set_surface_node(material, METAL_NODE)
    assert {item.bl_idname for item in tree.nodes} == {METAL_NODE, "ShaderNodeOutputMaterial"}


def test_a_cycle_of_mixtures_is_reported(plastic):
    material, tree, node = plastic
    mix = new_mix(tree, new_spectrum(tree), new_spectrum(tree), 0.5)
    tree.links.new(mix.outputs[0], mix.inputs["A"])
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    with pytest.raises(core.SceneError, match="cycle"):
        read_material(material)


# ---- materials without our nodes


def foreign(node_type, **values):
    material = bpy.data.materials.new("Foreign")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new(node_type)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    for name, value in values.items():
        shader.inputs[name.replace("_", " ")].default_value = value
    return material, shader


def test_principled_is_uplifted_and_noted(scene):
    material, _ = foreign("ShaderNodeBsdfPrincipled", Base_Color=(0.5, 0.5, 0.5, 1.0), Roughness=0.5)
    reading = read_material(material)
    assert reading.material.body_reflectance == core.Spectrum.constant(0.5)
    assert "uplifted" in reading.notes[0]
    # Roughness 0.5 is a lobe of width a = 0.25: n = 1 / (2 a^2) = 8 and, with F = 0.04, a peak of F / (4 a^2) = 0.16.
    assert reading.material.n == pytest.approx(8.0, rel=BLENDER_FLOAT)
    assert reading.material.interface_reflectance == pytest.approx(0.16, rel=BLENDER_FLOAT)


def test_metallic_principled_becomes_a_metal(scene):
    material, _ = foreign("ShaderNodeBsdfPrincipled", Base_Color=(0.5, 0.5, 0.5, 1.0), Metallic=1.0, Roughness=0.3)
    read = read_material(material).material
    assert isinstance(read, core.TypeIII)
    assert read.normal_reflectance == core.Spectrum.constant(0.5)
    assert read.beta == pytest.approx(0.09 * math.sqrt(math.log(2.0)), rel=BLENDER_FLOAT)


def test_diffuse_is_matte(scene):
    material, _ = foreign("ShaderNodeBsdfDiffuse", Color=(0.25, 0.25, 0.25, 1.0))
    read = read_material(material).material
    assert read.body_reflectance == core.Spectrum.constant(0.25)
    assert read.interface_reflectance == 0.0


def test_no_shader_falls_back_on_the_viewport_colour(scene):
    material, shader = foreign("ShaderNodeBsdfDiffuse")
    material.node_tree.nodes.remove(shader)
    material.diffuse_color = (0.5, 0.5, 0.5, 1.0)
    reading = read_material(material)
    assert reading.material.body_reflectance == core.Spectrum.constant(0.5)
    assert "viewport colour" in reading.notes[0]


def test_an_empty_slot_is_blenders_grey(scene):
    reading = read_material(None)
    assert reading.material.interface_reflectance == 0.0
    assert reading.material.body_reflectance.values[0] == 0.8
