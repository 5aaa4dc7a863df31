"""The nodes themselves: made, shared, copied, saved, appended, undone, animated, and seen by other engines."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon.names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE, SURFACE_NODES
from dichromatic_addon.nodes import groups, handlers
from dichromatic_addon.nodes.approximation import linear_rgb
from dichromatic_addon.nodes.editing import link_spectrum_node, set_surface_node, surface_node_of
from dichromatic_addon.nodes.reading import read_material
from tests.tolerances import BLENDER_FLOAT

pytestmark = pytest.mark.bpy


def new_material(node_type=PLASTIC_NODE, name="Paint"):
    material = bpy.data.materials.new(name)
    return material, set_surface_node(material, node_type)


@pytest.mark.parametrize("node_type", SURFACE_NODES)
def test_each_surface_node_reaches_the_output_and_shows_no_hidden_input(scene, node_type):
    material, node = new_material(node_type)
    assert surface_node_of(material) == node
    assert node.outputs["Surface"].links[0].to_node == material.node_tree.get_output_node("ALL")
    hidden = {recipe.name for recipe in node.recipe.inputs if recipe.hidden}
    assert {socket.name for socket in node.inputs if socket.hide} >= hidden


def test_nodes_of_a_type_share_one_hidden_group(scene):
    nodes = [new_material(PLASTIC_NODE, name)[1] for name in "ABC"]
    assert len({node.node_tree.name for node in nodes}) == 1
    assert nodes[0].node_tree.name.startswith(".")
    assert len([tree for tree in bpy.data.node_groups if groups.is_hidden_group(tree)]) == 1


def test_a_renamed_group_is_found_by_its_tag(scene):
    _, first = new_material()
    first.node_tree.name = "something else"
    _, second = new_material()
    assert second.node_tree == first.node_tree


def test_a_group_of_an_older_version_is_built_anew_and_keeps_the_links(scene):
    material, node = new_material()
    link_spectrum_node(material.node_tree, node, "Body Reflectance")
    before = len(node.node_tree.nodes)
    node.node_tree.nodes.clear()
    node.node_tree[groups.VERSION_KEY] = 0
    handlers._after_load()
    assert len(node.node_tree.nodes) == before
    assert node.inputs["Body Reflectance"].is_linked
    assert [socket.name for socket in node.inputs] == [recipe.name for recipe in node.recipe.inputs]


def test_a_socket_that_an_older_version_lacked_appears_with_its_value(scene):
    _, node = new_material(METAL_NODE)
    node.anisotropic = True
    interface = node.node_tree.interface
    for name in ("Use Across", "Mirror"):
        interface.remove(next(item for item in interface.items_tree if item.name == name))
    node.node_tree[groups.VERSION_KEY] = 0
    assert "Use Across" not in node.inputs
    handlers._after_load()
    assert node.inputs["Use Across"].hide
    assert node.inputs["Use Across"].default_value == 1.0
    assert not node.inputs["Mirror"].hide


def test_the_attenuation_reaches_the_hidden_input(scene):
    _, node = new_material()
    for index, kind in enumerate(core.ATTENUATIONS):
        node.attenuation = kind
        assert node.inputs["Attenuation"].default_value == index


def test_the_spectrum_node_shows_the_colour_of_its_spectrum(scene):
    material, node = new_material()
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source = "LIBRARY"
    spectrum.library_name = "plastic red"
    red, green, blue, _ = spectrum.inputs["RGB"].default_value
    assert red > 2.0 * green
    assert red > 2.0 * blue
    spectrum.source = "CONSTANT"
    spectrum.value = 0.25
    assert tuple(spectrum.inputs["RGB"].default_value)[:3] == pytest.approx((0.25,) * 3, rel=2e-3)


def test_a_white_diffuser_is_white_under_the_white_that_rgb_engines_assume(scene):
    # D65 as tabled and the four digits of sRGB's white differ by 1e-4 in x, y: a few 1e-4 in linear RGB.
    assert linear_rgb(core.Spectrum.constant(1.0)) == pytest.approx((1.0, 1.0, 1.0), abs=1e-3)


def test_changing_the_type_keeps_inputs_of_the_same_name(scene):
    material, plastic = new_material()
    plastic.attenuation = "gaussian"
    plastic.energy_conserving = True
    plastic.inputs["n"].default_value = 33.0
    spectrum = link_spectrum_node(material.node_tree, plastic, "Body Reflectance")
    cloth = set_surface_node(material, CLOTH_NODE)
    assert cloth.attenuation == "gaussian"
    assert cloth.energy_conserving
    assert cloth.inputs["n"].default_value == 33.0
    assert cloth.inputs["Body Reflectance"].links[0].from_node == spectrum
    assert not [node for node in material.node_tree.nodes if node.bl_idname == PLASTIC_NODE]


def test_changing_to_metal_removes_spectra_that_feed_nothing(scene):
    material, plastic = new_material()
    link_spectrum_node(material.node_tree, plastic, "Body Reflectance")
    set_surface_node(material, METAL_NODE)
    assert not [node for node in material.node_tree.nodes if node.bl_idname == SPECTRUM_NODE]


def test_the_first_type_takes_over_the_principled_base_colour(scene):
    material = bpy.data.materials.new("From Cycles")
    if material.node_tree is None:
        material.use_nodes = True
    principled = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    principled.inputs["Base Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    node = set_surface_node(material, PLASTIC_NODE)
    assert tuple(node.inputs["Body Reflectance"].default_value) == pytest.approx((0.1, 0.2, 0.3, 1.0))


@pytest.mark.parametrize("has_link", [False, True])
def test_a_new_type_does_not_cover_the_output(scene, has_link):
    """Blender's default leaves 50 between a Principled of 240 and the output; ours is 340 wide."""
    material = bpy.data.materials.new("From Cycles")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    principled = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    output = tree.get_output_node("ALL")
    output.location, principled.location = (300.0, 300.0), (10.0, 300.0)
    if has_link:
        colour = tree.nodes.new("ShaderNodeRGB")
        colour.location = (-200.0, 300.0)
        tree.links.new(colour.outputs[0], principled.inputs["Base Color"])
    node = set_surface_node(material, PLASTIC_NODE)
    assert node.location.x + node.width < output.location.x
    if has_link:
        assert colour.location.x + colour.width < node.location.x


def test_a_foreign_shader_with_links_of_its_own_is_kept(scene):
    material = bpy.data.materials.new("Textured")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    principled = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], principled.inputs["Base Color"])
    name = principled.name
    set_surface_node(material, PLASTIC_NODE)
    assert name in tree.nodes


def test_copies_of_a_material_are_independent(scene):
    material, node = new_material()
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source, spectrum.value = "CONSTANT", 0.25
    copy = material.copy()
    spectrum.value = 0.75
    assert read_material(copy).material.body_reflectance.values[0] == 0.25
    assert surface_node_of(copy).node_tree == node.node_tree


def write_spectrum(path, values=(0.1, 0.2, 0.4)):
    rows = [f"{wavelength},{value}" for wavelength, value in zip((400, 500, 600), values, strict=True)]
    path.write_text("\n".join(["wavelength,value", *rows]) + "\n", encoding="utf-8")
    return str(path)


def test_samples_of_a_file_survive_save_and_the_loss_of_the_file(scene, tmp_path):
    file = tmp_path / "measured.csv"
    material, node = new_material()
    material.use_fake_user = True
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source = "FILE"
    spectrum.filepath = write_spectrum(file)
    file.unlink()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    body = read_material(bpy.data.materials["Paint"]).material.body_reflectance
    np.testing.assert_array_equal(body.wavelengths_nm, [400.0, 500.0, 600.0])
    np.testing.assert_array_equal(body.values, [0.1, 0.2, 0.4])


def test_a_shorter_file_replaces_the_samples_of_a_longer_one(scene, tmp_path):
    material, node = new_material()
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source = "FILE"
    spectrum.filepath = write_spectrum(tmp_path / "long.csv")
    short = tmp_path / "short.csv"
    short.write_text("wavelength,value\n450,0.5\n650,0.6\n", encoding="utf-8")
    spectrum.filepath = str(short)
    np.testing.assert_array_equal(read_material(material).material.body_reflectance.values, [0.5, 0.6])


@pytest.mark.parametrize("link", [False, True])
def test_append_and_link_bring_the_node_and_its_group(scene, tmp_path, link):
    material, node = new_material(METAL_NODE, "Brass")
    node.metal = "brass-70-30"
    material.use_fake_user = True
    library = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library)
    expected = read_material(material).material
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(library, link=link) as (_, wanted):
        wanted.materials = ["Brass"]
    assert read_material(bpy.data.materials["Brass"]).material.normal_reflectance == expected.normal_reflectance
    fresh = set_surface_node(bpy.data.materials.new("Own"), METAL_NODE)
    assert fresh.node_tree.library is None  # a new node never hangs on a linked file


def test_without_the_add_on_nothing_is_lost(scene, addon, tmp_path):
    material, node = new_material()
    material.use_fake_user = True
    node.attenuation = "exponential"
    node.inputs["n"].default_value = 17.0
    path = str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    addon.unregister()
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        bpy.ops.wm.save_as_mainfile(filepath=path)
    finally:
        addon.register()
    bpy.ops.wm.open_mainfile(filepath=path)
    read = read_material(bpy.data.materials["Paint"]).material
    assert (read.attenuation, read.n) == ("exponential", 17.0)


def test_undo_brings_the_former_type_back(scene):
    bpy.context.preferences.edit.use_global_undo = True
    material, _ = new_material()
    material.use_fake_user = True
    bpy.ops.ed.undo_push(message="plastic")
    set_surface_node(material, METAL_NODE)
    bpy.ops.ed.undo_push(message="metal")
    if not bpy.ops.ed.undo.poll():
        pytest.skip("this Blender offers no undo without a window")
    bpy.ops.ed.undo()
    material = bpy.data.materials["Paint"]
    assert surface_node_of(material).bl_idname == PLASTIC_NODE
    assert read_material(material).notes == ()


def test_a_driven_temperature_refreshes_the_hidden_colour(scene):
    material, node = new_material()
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source = "TEMPERATURE"
    spectrum.keyframe_insert("temperature", frame=1)
    spectrum.temperature = 20000.0
    spectrum.keyframe_insert("temperature", frame=10)
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(material)
    scene.frame_set(1)
    before = tuple(spectrum.inputs["RGB"].default_value)
    scene.frame_set(10)
    after = tuple(spectrum.inputs["RGB"].default_value)
    assert after[2] > after[0]
    assert after != before


def test_the_evaluated_copy_follows_a_change_of_samples(scene, tmp_path):
    material, node = new_material()
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(material)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    spectrum.source = "FILE"
    spectrum.filepath = write_spectrum(tmp_path / "one.csv")
    depsgraph.update()
    spectrum.filepath = write_spectrum(tmp_path / "two.csv", (0.7, 0.8, 0.9))
    depsgraph.update()
    evaluated = material.evaluated_get(depsgraph)
    np.testing.assert_array_equal(read_material(evaluated).material.body_reflectance.values, [0.7, 0.8, 0.9])


def test_a_driven_number_is_read_from_the_evaluated_copy(scene):
    material, node = new_material()
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(material)
    driver = node.inputs["n"].driver_add("default_value").driver
    driver.type, driver.expression = "SCRIPTED", "frame * 2"
    for frame in (7, 9):
        scene.frame_set(frame)
        evaluated = material.evaluated_get(bpy.context.evaluated_depsgraph_get())
        assert read_material(evaluated).material.n == 2.0 * frame


def test_a_library_override_reads_like_its_original(scene, tmp_path):
    material, node = new_material()
    node.inputs["n"].default_value = 29.0
    link_spectrum_node(material.node_tree, node, "Body Reflectance").library_name = "plastic red"
    material.use_fake_user = True
    library = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library)
    expected = read_material(material).material
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.materials = ["Paint"]
    override = bpy.data.materials["Paint"].override_create()
    assert override.library is None
    assert read_material(override).material == expected


def test_cycles_renders_the_approximation(scene):
    """A lit plane in Cycles has the colour of the body; the interface adds next to nothing off the mirror angle."""
    if not hasattr(bpy.types.Scene, "cycles"):
        pytest.skip("this Blender has no Cycles")
    material, node = new_material()
    node.inputs["Body Reflectance"].default_value = (0.1, 0.5, 0.2, 1.0)
    node.inputs["Interface Reflectance"].default_value = 0.0
    bpy.ops.mesh.primitive_plane_add(size=100.0)
    bpy.context.object.data.materials.append(material)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy = math.pi  # a white diffuser facing it has the radiance 1
    scene.collection.objects.link(sun)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0.0, 0.0, 5.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    pixels = cycles_pixels(scene)
    np.testing.assert_allclose(pixels[2, 2, :3], (0.1, 0.5, 0.2), rtol=0.02)  # half floats and Cycles' sampling


def cycles_pixels(scene):
    import tempfile
    from pathlib import Path

    scene.render.engine = "CYCLES"
    scene.cycles.samples = 4
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.resolution_percentage = 100
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "cycles.exr")
        scene.render.image_settings.file_format = "OPEN_EXR"
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        return np.array(image.pixels[:], np.float32).reshape(4, 4, -1)


def test_beta_is_kept_in_radians_and_shown_in_degrees(scene):
    _, node = new_material(METAL_NODE)
    assert node.inputs["beta"].default_value == pytest.approx(math.radians(5.0), rel=BLENDER_FLOAT)
    item = next(item for item in node.node_tree.interface.items_tree if item.name == "beta")
    assert item.subtype == "ANGLE"
