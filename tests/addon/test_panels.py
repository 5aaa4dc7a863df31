"""Panels, menus and presets: drawn on a layout that checks all they ask for, and taken out without a trace."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import pytest

import spectral_core as core
from dichromatic_addon import light_linking_panels, menus, panels, presets, properties, view_layer_panels
from dichromatic_addon.names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes import dielectric, editing, menu, metal, mix
from dichromatic_addon.nodes import spectrum as spectrum_node
from dichromatic_addon.nodes.editing import link_spectrum_node, set_surface_node, surface_node_of
from dichromatic_addon.nodes.image_panel import link_image_node
from dichromatic_addon.nodes.reading import read_material
from dichromatic_addon.properties import source_items, white_items

from .building import add_light, add_plane
from .fake_layout import FakeLayout

pytestmark = pytest.mark.bpy


def draw(panel, scene, **extra):
    """Draw a panel on a fake layout and return what it asked for."""
    layout = FakeLayout()
    context = SimpleNamespace(
        scene=scene,
        engine=scene.render.engine,
        view_layer=scene.view_layers[0],
        preferences=bpy.context.preferences,
        region=SimpleNamespace(width=400),
        **{"material": None, "light": None, "world": None, **extra},
    )
    assert panel.poll(context)
    panel.draw(SimpleNamespace(layout=layout), context)
    return layout


@pytest.mark.parametrize("panel", [cls for cls in panels.CLASSES if cls.bl_context in ("render", "view_layer")])
def test_scene_panels_in_every_state(scene, panel):
    for white in white_items:
        scene.dichromatic.white_source = white[0]
        for transform in ("Standard", "AgX"):
            scene.view_settings.view_transform = transform
            draw(panel, scene)


@pytest.mark.parametrize("kind", ["POINT", "SUN", "SPOT", "AREA"])
@pytest.mark.parametrize("source", [item[0] for item in source_items])
def test_light_panels_in_every_state(scene, kind, source):
    light = bpy.data.lights.new("Lamp", kind)
    light.dichromatic.source = source
    draw(panels.DICHROMATIC_PT_light, scene, light=light)
    layout = draw(panels.DICHROMATIC_PT_light_illuminant, scene, light=light)
    assert "source" in layout.names("prop")
    assert ("no spectrum file is chosen" in layout.names("label")) == (source == "FILE")


@pytest.mark.parametrize("source", [item[0] for item in source_items])
def test_the_world_panel_in_every_state(scene, source):
    world = bpy.data.worlds.new("Sky")
    world.dichromatic.source = source
    draw(panels.DICHROMATIC_PT_world, scene, world=world)


@pytest.mark.parametrize("node_type", [PLASTIC_NODE, CLOTH_NODE, METAL_NODE])
def test_the_material_panel_shows_the_nodes_themselves(scene, node_type):
    material = bpy.data.materials.new("Paint")
    node = set_surface_node(material, node_type)
    layout = draw(panels.DICHROMATIC_PT_material, scene, material=material)
    visible = [socket for socket in node.inputs if not socket.hide]
    assert layout.names("prop").count("default_value") == len(visible)
    assert "energy_conserving" in layout.names("prop")


@pytest.mark.parametrize("source", [item[0] for item in spectrum_node.source_items])
def test_a_linked_spectrum_is_drawn_in_the_panel_and_in_the_node(scene, source):
    material = bpy.data.materials.new("Paint")
    node = set_surface_node(material, PLASTIC_NODE)
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source = source
    layout = draw(panels.DICHROMATIC_PT_material, scene, material=material)
    assert "source" in layout.names("prop")
    assert "dichromatic.unlink_spectrum" in layout.names("operator")
    in_node = FakeLayout()
    spectrum.draw_compact(in_node)
    assert "source" in in_node.names("prop")
    assert spectrum.draw_label()


def test_a_linked_image_is_chosen_and_placed_in_the_panel(scene):
    plane = add_plane(scene)
    material = bpy.data.materials.new("Print")
    node = set_surface_node(material, PLASTIC_NODE)
    texture = link_image_node(material.node_tree, node, "Body Reflectance")
    layout = draw(panels.DICHROMATIC_PT_material, scene, material=material, object=plane)
    assert layout.names("template_ID") == ["image"]
    assert "no image yet" in " ".join(layout.names("label"))
    texture.image = bpy.data.images.new("print", 4, 4)
    mapping = material.node_tree.nodes.new("ShaderNodeMapping")
    uv = material.node_tree.nodes.new("ShaderNodeUVMap")
    material.node_tree.links.new(uv.outputs[0], mapping.inputs["Vector"])
    material.node_tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    layout = draw(panels.DICHROMATIC_PT_material, scene, material=material, object=plane)
    drawn = layout.names("prop")
    assert {"interpolation", "extension", "name", "alpha_mode", "vector_type", "uv_map"} <= set(drawn)
    without = draw(panels.DICHROMATIC_PT_material, scene, material=material, object=None)
    assert "uv_map" in without.names("prop")
    assert "no image" not in " ".join(layout.names("label"))


def test_the_panel_tells_why_a_link_cannot_be_read(scene):
    material = bpy.data.materials.new("Paint")
    node = set_surface_node(material, PLASTIC_NODE)
    noise = material.node_tree.nodes.new("ShaderNodeTexNoise")
    material.node_tree.links.new(noise.outputs["Color"], node.inputs["Body Reflectance"])
    text = " ".join(draw(panels.DICHROMATIC_PT_material, scene, material=material).names("label"))
    assert "gives no spectrum" in text
    in_node = FakeLayout()
    node.draw_compact(in_node)
    assert "Noise" in " ".join(in_node.names("label"))


@pytest.mark.parametrize("use_nodes", [False, True])
def test_a_foreign_material_is_offered_a_type(scene, use_nodes):
    material = bpy.data.materials.new("Foreign")
    if use_nodes and material.node_tree is None:
        material.use_nodes = True
    layout = draw(panels.DICHROMATIC_PT_material, scene, material=material)
    assert "dichromatic.set_surface" in layout.names("operator")
    assert "Rendered from" in " ".join(layout.names("label"))


def test_panels_are_for_our_engine_only(scene):
    scene.render.engine = "BLENDER_WORKBENCH"
    for panel in panels.CLASSES:
        context = SimpleNamespace(
            engine=scene.render.engine, material=object(), light=object(), world=object(), scene=scene
        )
        assert not panel.poll(context)


def test_every_panel_and_property_has_a_tooltip(addon):
    for cls in properties.CLASSES:
        for known in cls.bl_rna.properties:
            assert known.identifier in ("rna_type", "name") or known.description, known.identifier
    for cls in (*dielectric.CLASSES, *metal.CLASSES, *spectrum_node.CLASSES, *mix.CLASSES):
        own = set(cls.__annotations__) | {name for base in cls.__mro__ for name in getattr(base, "__annotations__", {})}
        for name in own:
            assert cls.bl_rna.properties[name].description, name
        for socket in cls.recipe.inputs:
            assert socket.hidden or socket.description, socket.name


@pytest.mark.parametrize("kind", ["POINT", "SUN", "SPOT", "AREA"])
def test_what_the_engine_takes_of_a_lamp_can_be_set(scene, kind):
    light = bpy.data.lights.new("Lamp", kind)
    shown = draw(panels.DICHROMATIC_PT_light, scene, light=light).names("prop")
    if kind == "SPOT":
        shown += draw(panels.DICHROMATIC_PT_light_beam, scene, light=light).names("prop")
    known = {
        "energy",
        "spot_size",
        "spot_blend",
        "exposure",
        "normalize",
        "use_shadow",
        "angle",
        "shape",
        "size",
        "spread",
    }
    known |= {"shadow_soft_size", "use_soft_falloff"} if kind in ("POINT", "SPOT") else set()
    assert {name for name in known if hasattr(light, name)} <= set(shown)


@pytest.mark.parametrize("name", ["DATA_PT_lens", "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture"])
def test_what_the_engine_takes_of_a_camera_can_be_set(addon, name):
    context = SimpleNamespace(engine="DICHROMATIC", camera=object())
    assert getattr(bpy.types, name).poll(context)


def test_blenders_panels_are_joined_and_left_again(addon):
    def ours():
        return {
            panel.__name__
            for panel in bpy.types.Panel.__subclasses__()
            if "DICHROMATIC" in getattr(panel, "COMPAT_ENGINES", ()) and not panel.__name__.startswith("DICHROMATIC")
        }

    joined = ours()
    by_name = {panel.__name__: panel for panel in bpy.types.Panel.__subclasses__()}
    for name in joined:  # a panel whose parent is not shown is not shown either
        parent = by_name.get(getattr(by_name[name], "bl_parent_id", ""))
        assert parent is None or "DICHROMATIC" in getattr(parent, "COMPAT_ENGINES", {"DICHROMATIC"}), name
    assert {"EEVEE_MATERIAL_PT_context_material", "MATERIAL_PT_preview", "DATA_PT_lens"} <= joined
    assert not {name for name in joined if "freestyle" in name}
    addon.unregister()
    try:
        assert ours() == set()
        assert not [cls for cls in panels.CLASSES if getattr(bpy.types, cls.__name__, None)]
        assert not hasattr(bpy.types.Scene, "dichromatic")
        assert not hasattr(bpy.types, PLASTIC_NODE)
    finally:
        addon.register()
    assert ours() == joined


@pytest.mark.parametrize("name", ["light", "shadow"])
def test_linking_can_be_edited_in_every_version(scene, name):
    """Blender's own panel where it has one for all engines; ours in 4.2, where Cycles alone has one."""
    lamp = add_light(scene, "POINT", 10.0)
    theirs = getattr(bpy.types, f"OBJECT_PT_{name}_linking", None)
    ours = getattr(light_linking_panels, f"DICHROMATIC_PT_object_{name}_linking")
    assert ours.is_registered == (theirs is None)
    if theirs is not None:
        assert "DICHROMATIC" in bpy.types.OBJECT_PT_shading.COMPAT_ENGINES  # the parent of both
    collection = {"light": "receiver", "shadow": "blocker"}[name] + "_collection"
    layout = draw(ours, scene, object=lamp)
    assert layout.names("template_ID") == [collection]
    assert layout.names("operator") == []
    setattr(lamp.light_linking, collection, bpy.data.collections.new("Linked"))
    layout = draw(ours, scene, object=lamp)
    assert layout.names("template_light_linking_collection") == [collection]
    assert len(layout.names("operator")) == 3


def test_the_add_menu_lists_the_nodes_for_our_engine_only(scene):
    layout = FakeLayout()
    menu.DICHROMATIC_MT_node_add.draw(SimpleNamespace(layout=layout), None)
    assert layout.names("operator") == ["node.add_node"] * 5
    for engine, expected in (("DICHROMATIC", ["DICHROMATIC_MT_node_add"]), ("BLENDER_WORKBENCH", [])):
        layout = FakeLayout()
        context = SimpleNamespace(engine=engine, space_data=SimpleNamespace(shader_type="OBJECT"))
        menu._draw_entry(SimpleNamespace(layout=layout), context)
        assert layout.names("menu") == expected


def test_menus_offer_what_the_search_is_to_find(scene):
    """F3 searches menus: an operator that stands in none is found only with Blender's developer extras."""
    scene.render.engine = "DICHROMATIC"
    layout = FakeLayout()
    context = SimpleNamespace(scene=scene, engine=scene.render.engine)
    for _, draw_entry in menus.MENUS:
        draw_entry(SimpleNamespace(layout=layout), context)
    assert layout.names("menu") == ["DICHROMATIC_MT_studies"]
    menus.DICHROMATIC_MT_studies.draw(SimpleNamespace(layout=layout), context)
    assert {
        "dichromatic.render_image",
        "dichromatic.list_approximations",
        "dichromatic.convert_materials",
        "dichromatic.metamerism_map",
        "dichromatic.contact_sheet",
        "dichromatic.pick_pixel",
    } <= set(layout.names("operator"))
    context.engine = "BLENDER_WORKBENCH"
    layout = FakeLayout()
    for _, draw_entry in menus.MENUS:
        draw_entry(SimpleNamespace(layout=layout), context)
    assert layout.drawn == []


@pytest.mark.parametrize(
    ("kind", "engine", "shown"),
    [("MESH", "DICHROMATIC", True), ("LIGHT", "DICHROMATIC", False), ("MESH", "CYCLES", False)],
)
def test_the_shadow_catcher_stands_in_blenders_visibility(scene, kind, engine, shown):
    made = bpy.data.objects.new(
        "Made", bpy.data.meshes.new("M") if kind == "MESH" else bpy.data.lights.new("L", "POINT")
    )
    layout = FakeLayout()
    context = SimpleNamespace(object=made, engine=engine)
    view_layer_panels._draw_shadow_catcher(SimpleNamespace(layout=layout), context)
    assert layout.names("prop") == ["is_shadow_catcher"][: int(shown)]


# ---- presets


def test_there_are_at_least_twenty_presets_of_all_types():
    assert len({preset.name for preset in presets.PRESETS}) == len(presets.PRESETS) >= 20
    assert {preset.node_type for preset in presets.PRESETS} == {PLASTIC_NODE, CLOTH_NODE, METAL_NODE}


@pytest.mark.parametrize("preset", presets.PRESETS, ids=lambda preset: preset.name)
def test_each_preset_gives_a_material_that_can_be_read(scene, preset):
    material = bpy.data.materials.new("Paint")
    presets.apply_preset(material, preset)
    reading = read_material(material)
    assert reading.notes == ()
    if preset.body:
        assert reading.material.body_reflectance == core.reflectance(preset.body)
        assert reading.material.n == pytest.approx(preset.n)
    else:
        assert (reading.material.beta_across is None) == (preset.across_degrees == 0.0)


def test_presets_in_a_row_leave_nothing_behind(scene):
    material = bpy.data.materials.new("Paint")
    for preset in presets.PRESETS:
        presets.apply_preset(material, preset)
    kinds = [node.bl_idname for node in material.node_tree.nodes]
    assert kinds.count(SPECTRUM_NODE) == 0  # the last preset is a metal
    presets.apply_preset(material, presets.PRESETS[0])
    kinds = [node.bl_idname for node in material.node_tree.nodes]
    assert kinds.count(PLASTIC_NODE) == kinds.count(SPECTRUM_NODE) == 1


def test_the_preset_menu_lists_all(scene):
    layout = FakeLayout()
    presets.DICHROMATIC_MT_material_presets.draw(SimpleNamespace(layout=layout), None)
    assert len(layout.names("operator")) == len(presets.PRESETS)


# ---- operators


@pytest.fixture
def cube(scene):
    """A cube with a material, the active object."""
    bpy.ops.mesh.primitive_cube_add()
    material = bpy.data.materials.new("Paint")
    bpy.context.object.data.materials.append(material)
    return material


def test_operators_change_the_active_material(cube):
    assert bpy.ops.dichromatic.set_surface(node_type=CLOTH_NODE) == {"FINISHED"}
    assert surface_node_of(cube).bl_idname == CLOTH_NODE
    assert bpy.ops.dichromatic.link_spectrum(input_name="Interface Reflectance") == {"FINISHED"}
    spectrum = surface_node_of(cube).inputs["Interface Reflectance"].links[0].from_node
    spectrum.source, spectrum.value = "CONSTANT", 0.5
    assert bpy.ops.dichromatic.unlink_spectrum(input_name="Interface Reflectance") == {"FINISHED"}
    socket = surface_node_of(cube).inputs["Interface Reflectance"]
    assert not socket.is_linked
    assert tuple(socket.default_value)[:3] == pytest.approx((0.5,) * 3, rel=2e-3)
    assert bpy.ops.dichromatic.link_image(input_name="Body Reflectance") == {"FINISHED"}
    assert surface_node_of(cube).inputs["Body Reflectance"].links[0].from_node.bl_idname == "ShaderNodeTexImage"
    assert bpy.ops.dichromatic.unlink_spectrum(input_name="Body Reflectance") == {"FINISHED"}
    assert not [node for node in cube.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    assert bpy.ops.dichromatic.material_preset(name="Gold") == {"FINISHED"}
    assert surface_node_of(cube).metal == "gold"


def test_operators_name_what_is_missing(cube):
    bpy.ops.dichromatic.set_surface(node_type=PLASTIC_NODE)
    with pytest.raises(RuntimeError, match="no input 'Body'"):
        bpy.ops.dichromatic.link_spectrum(input_name="Body")
    with pytest.raises(RuntimeError, match="no input 'Body'"):
        bpy.ops.dichromatic.link_image(input_name="Body")
    with pytest.raises(RuntimeError, match="no material preset 'Adamantium'"):
        bpy.ops.dichromatic.material_preset(name="Adamantium")


def test_a_spectrum_file_is_read_again_on_demand(cube, tmp_path):
    node = set_surface_node(cube, PLASTIC_NODE)
    spectrum = link_spectrum_node(cube.node_tree, node, "Body Reflectance")
    file = tmp_path / "measured.csv"
    file.write_text("wavelength,value\n400,0.1\n600,0.2\n", encoding="utf-8")
    spectrum.source, spectrum.filepath = "FILE", str(file)
    file.write_text("wavelength,value\n400,0.3\n600,0.4\n", encoding="utf-8")
    operator = SimpleNamespace()
    context = SimpleNamespace(dichromatic_file_owner=spectrum)
    assert editing.DICHROMATIC_OT_reload_spectrum.execute(operator, context) == {"FINISHED"}
    assert read_material(cube).material.body_reflectance.values.tolist() == [0.3, 0.4]
