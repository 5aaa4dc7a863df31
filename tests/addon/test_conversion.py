"""Converting foreign materials for good: the same picture here, the same shaders for Cycles and EEVEE, and undo."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon import cli
from dichromatic_addon.conversion import REPORT_NAME, convert_all
from dichromatic_addon.names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE, SURFACE_NODES
from dichromatic_addon.nodes.converting import convert, is_convertible
from dichromatic_addon.nodes.editing import set_surface_node, surface_node_of
from dichromatic_addon.nodes.reading import read_material
from tests.addon.building import add_light, add_mesh, add_plane, combined, look_down, small_picture
from tests.addon.test_foreign_materials import grey, mixed, new_tree, shader
from tests.tolerances import BLENDER_FLOAT, REC709_ROUND_TRIP

pytestmark = pytest.mark.bpy

AT = np.array([420.0, 500.0, 560.0, 610.0, 680.0])


def principled(tree: Any, target: Any) -> None:
    shader(tree, "ShaderNodeBsdfPrincipled", target, Base_Color=(0.6, 0.2, 0.1, 1.0), Roughness=0.1)


def tinted(tree: Any, target: Any) -> None:
    shader(tree, "ShaderNodeBsdfPrincipled", target, Base_Color=(0.6, 0.2, 0.1, 1.0), Specular_Tint=(1.0, 0.5, 0.2, 1))


def metal(tree: Any, target: Any) -> None:
    shader(tree, "ShaderNodeBsdfPrincipled", target, Base_Color=(0.9, 0.6, 0.2, 1.0), Metallic=1.0, Roughness=0.25)


def glowing(tree: Any, target: Any) -> None:
    shader(tree, "ShaderNodeBsdfPrincipled", target, Emission_Color=(1.0, 0.5, 0.2, 1.0), Emission_Strength=3.0)


def spectral_glow(tree: Any, target: Any) -> None:
    both = shader(tree, "ShaderNodeAddShader", target)
    shader(tree, "ShaderNodeBsdfDiffuse", both.inputs[0], Color=grey(0.3))
    emission = shader(tree, "ShaderNodeEmission", both.inputs[1], Strength=2.0)
    lamp = shader(tree, SPECTRUM_NODE, emission.inputs["Color"])
    lamp.source, lamp.library_name = "LIBRARY", "FL2"


def three_mixed(tree: Any, target: Any) -> None:
    mix = mixed(tree, target, 0.3)
    inner = mixed(tree, mix.inputs[1], 0.6)
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=(0.1, 0.5, 0.3, 1.0))
    shader(tree, "ShaderNodeBsdfDiffuse", inner.inputs[1], Color=(0.8, 0.5, 0.3, 1.0))
    shader(tree, "ShaderNodeBsdfAnisotropic", inner.inputs[2], Color=(0.8, 0.8, 0.3, 1.0), Roughness=0.4)


def measured_body(tree: Any, target: Any) -> None:
    diffuse = shader(tree, "ShaderNodeBsdfDiffuse", target)
    shader(tree, SPECTRUM_NODE, diffuse.inputs["Color"]).library_name = "plastic blue"


def measured_mixture(tree: Any, target: Any) -> None:
    mix = mixed(tree, target, 0.5)
    measured_body(tree, mix.inputs[1])
    shader(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=(0.1, 0.5, 0.3, 1.0))


MATERIALS = {
    "plastic": (principled, PLASTIC_NODE),
    "tinted highlight": (tinted, CLOTH_NODE),
    "metal": (metal, METAL_NODE),
    "glowing": (glowing, PLASTIC_NODE),
    "spectral glow": (spectral_glow, PLASTIC_NODE),
    "three mixed": (three_mixed, CLOTH_NODE),
    "measured body": (measured_body, PLASTIC_NODE),
    "measured mixture": (measured_mixture, PLASTIC_NODE),
}


def made(name: str) -> Any:
    material, tree, target = new_tree(name)
    MATERIALS[name][0](tree, target)
    return material


@pytest.mark.parametrize("name", MATERIALS)
def test_conversion_changes_nothing_that_is_rendered(scene: Any, name: str) -> None:
    material = made(name)
    before = read_material(material)
    assert is_convertible(material)
    assert convert(material) == before.notes
    assert surface_node_of(material).bl_idname == MATERIALS[name][1]
    after = read_material(material)
    assert after.notes == ()
    assert type(after.material) is type(before.material)
    for old, new in zip(before.material.reflectances, after.material.reflectances, strict=True):
        np.testing.assert_allclose(new.at(AT), old.at(AT), rtol=REC709_ROUND_TRIP)
    for attribute in ("n", "beta", "mirror", "attenuation", "energy_conserving"):
        expected = getattr(before.material, attribute, None)
        found = getattr(after.material, attribute, None)
        assert found == (expected if isinstance(expected, str | None) else pytest.approx(expected, rel=BLENDER_FLOAT))
    if before.glow is None:
        assert after.glow is None
    else:
        assert after.glow.strength == pytest.approx(before.glow.strength, rel=REC709_ROUND_TRIP)
        old, new = (glow.illuminant.at(AT) / glow.illuminant.at(AT).mean() for glow in (before.glow, after.glow))
        np.testing.assert_allclose(new, old, rtol=REC709_ROUND_TRIP)
    assert not is_convertible(material)


def test_cycles_renders_the_old_shaders(scene: Any, tmp_path: Path) -> None:
    material = made("metal")
    add_plane(scene, material, size=4.0)
    add_light(scene, "SUN", math.pi, angle=0.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    before = combined(scene, str(tmp_path / "before.exr"))
    convert(material)
    assert {node.target for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"} == {
        "ALL",
        "CYCLES",
        "EEVEE",
    }
    for target in ("CYCLES", "EEVEE"):
        source = material.node_tree.get_output_node(target).inputs["Surface"].links[0].from_node
        assert source.bl_idname == "ShaderNodeBsdfPrincipled"
    np.testing.assert_array_equal(combined(scene, str(tmp_path / "after.exr")), before)


def test_a_linked_spectrum_stays_linked(scene: Any) -> None:
    material = made("measured body")
    convert(material)
    assert surface_node_of(material).inputs["Body Reflectance"].links[0].from_node.library_name == "plastic blue"


def test_another_type_keeps_the_light(scene: Any) -> None:
    material = made("glowing")
    convert(material)
    set_surface_node(material, METAL_NODE)
    reading = read_material(material)
    assert isinstance(reading.material, core.TypeIII)
    assert reading.glow is not None


def test_a_material_without_nodes_gets_its_viewport_colour(scene: Any) -> None:
    material = bpy.data.materials.new("Plain")
    if material.node_tree is not None:
        pytest.skip("materials always have nodes in this Blender")
    material.diffuse_color = grey(0.25)
    convert(material)
    read = read_material(material).material
    assert read.body_reflectance == core.Spectrum.constant(0.25)


def test_all_materials_and_the_report(scene: Any) -> None:
    for name in ("plastic", "metal"):
        made(name)
    ours = bpy.data.materials.new("Ours")
    set_surface_node(ours, CLOTH_NODE)
    lamp, tree, target = new_tree("Lamp")
    shader(tree, "ShaderNodeEmission", target)
    assert bpy.ops.dichromatic.convert_materials(scope="ALL") == {"FINISHED"}
    for name in ("plastic", "metal"):
        assert surface_node_of(bpy.data.materials[name]).bl_idname in SURFACE_NODES
    assert surface_node_of(lamp).bl_idname == "ShaderNodeEmission"
    report = bpy.data.texts[REPORT_NAME].as_string()
    assert "material 'metal': the colors of 'Principled BSDF'" in report
    assert "material 'Lamp' has no surface to convert" in report
    assert "Ours" not in report


def test_a_material_that_cannot_be_read_is_named_and_left_alone(scene: Any) -> None:
    material, tree, target = new_tree("Broken")
    mix = mixed(tree, target, 0.5)
    node = shader(tree, PLASTIC_NODE, mix.inputs[1])
    spectrum = shader(tree, SPECTRUM_NODE, node.inputs["Body Reflectance"])
    spectrum.library_name = "unobtainium"
    count = len(tree.nodes)
    converted, lines = convert_all([material])
    assert converted == 0
    assert "material 'Broken' was not converted: " in lines[0]
    assert "unobtainium" in lines[0]
    assert len(tree.nodes) == count


def test_the_operators_for_one_material_and_for_the_selection(scene: Any) -> None:
    plane = add_plane(scene, made("plastic"))
    other = add_mesh(scene, "Other", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], made("metal"))
    bpy.context.view_layer.objects.active = plane
    assert bpy.ops.dichromatic.convert_material() == {"FINISHED"}
    assert not bpy.ops.dichromatic.convert_material.poll()
    assert is_convertible(bpy.data.materials["metal"])
    other.select_set(True)
    bpy.ops.dichromatic.convert_materials(scope="SELECTED")
    assert not is_convertible(bpy.data.materials["metal"])


def test_undo_brings_the_old_material_back(scene: Any) -> None:
    plane = add_plane(scene, made("plastic"))
    bpy.context.view_layer.objects.active = plane
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.dichromatic.convert_material()
    bpy.ops.ed.undo_push(message="after")
    assert surface_node_of(bpy.data.materials["plastic"]).bl_idname == PLASTIC_NODE
    bpy.ops.ed.undo()
    assert surface_node_of(bpy.data.materials["plastic"]).bl_idname == "ShaderNodeBsdfPrincipled"


def test_the_list_of_approximations(scene: Any) -> None:
    material, tree, target = new_tree("Window")
    shader(tree, "ShaderNodeBsdfGlass", target)
    add_plane(scene, material)
    look_down(scene)
    assert bpy.ops.dichromatic.list_approximations() == {"FINISHED"}
    assert "material 'Window': 'Glass BSDF' lets no light through" in bpy.data.texts[REPORT_NAME].as_string()


def test_the_command_line(scene: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    add_plane(scene, made("plastic"))
    scene.render.engine = "CYCLES"
    source, target = tmp_path / "in.blend", tmp_path / "out.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(source))
    assert cli.main(["convert", str(source), "-o", str(target)]) == 0
    assert "1 materials were converted" in capsys.readouterr().out
    bpy.ops.wm.open_mainfile(filepath=str(target))
    assert bpy.context.scene.render.engine == "DICHROMATIC"
    assert surface_node_of(bpy.data.materials["plastic"]).bl_idname == PLASTIC_NODE
    bpy.ops.wm.open_mainfile(filepath=str(source))
    assert surface_node_of(bpy.data.materials["plastic"]).bl_idname == "ShaderNodeBsdfPrincipled"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["nowhere.blend", "-o", "out.blend"], "no file"), (["nowhere.blend", "-o", "out.png"], "must end in .blend")],
)
def test_the_command_line_refuses(addon: Any, arguments: list[str], words: str, capsys: Any) -> None:
    assert cli.main(["convert", *arguments]) != 0
    assert words in capsys.readouterr().err
