"""Every panel of the Properties editor, for every kind of object, light and source, in every state of its choices."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
from stage import ENGINE, PACKAGE, Stage, Step, act, choices_of_node, states_of, until

SURFACES = ("DichromaticNodePlastic", "DichromaticNodeCloth", "DichromaticNodeMetal")
SHOT_TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "MATERIAL", "DATA")


def make_active(stage: Stage, made: Any) -> None:
    for other in stage.scene.objects:
        other.select_set(other == made)
    stage.window.view_layer.objects.active = made


def add(stage: Stage, name: str, data: Any) -> Any:
    made = bpy.data.objects.new(name, data)
    stage.scene.collection.objects.link(made)
    return made


def every_tab(stage: Stage, made: Any, kind: str, shots: tuple[str, ...] = ()) -> Step:
    """Draw all tabs that Blender has for an object."""
    area = stage.area("PROPERTIES")
    make_active(stage, made)
    yield stage.tab("OBJECT")
    stage.redraw()
    for name in stage.tabs():
        yield stage.tab(name)
        yield from stage.show(area, f"{kind}, tab {name}")
        if name in shots:
            stage.shot(f"{kind}_{name.lower()}", area)


def scene_states(stage: Stage) -> Step:
    area = stage.area("PROPERTIES")
    yield stage.tab("RENDER")
    for state in states_of(stage.scene.dichromatic):
        yield from stage.show(area, f"render: {state}")
    for transform in ("Standard", "AgX", "Raw"):
        stage.scene.view_settings.view_transform = transform
        yield from stage.show(area, f"render: view transform {transform}")
    stage.scene.render.use_simplify = True
    yield from stage.show(area, "render: simplify")
    yield stage.tab("VIEW_LAYER")
    for state in states_of(stage.window.view_layer):
        if "pass" in state:
            yield from stage.show(area, f"view layer: {state}")


def light_states(stage: Stage) -> Step:
    area = stage.area("PROPERTIES")
    for kind in ("POINT", "SUN", "SPOT", "AREA"):
        lamp = add(stage, kind.title(), bpy.data.lights.new(kind.title(), kind))
        yield from every_tab(stage, lamp, kind.lower())
        yield stage.tab("DATA")
        for state in states_of(lamp.data.dichromatic):
            yield from stage.show(area, f"{kind} light: {state}")
            stage.shot(f"light_{kind.lower()}_{state.replace(' ', '_').lower()}", area)
        for shape in lamp.data.bl_rna.properties["shape"].enum_items.keys() if kind == "AREA" else ():
            lamp.data.shape = shape
            yield from stage.show(area, f"AREA light: {shape}")


def world_states(stage: Stage) -> Step:
    area = stage.area("PROPERTIES")
    yield stage.tab("WORLD")
    world = stage.scene.world
    for state in states_of(world.dichromatic):
        yield from stage.show(area, f"world: {state}")
        stage.shot(f"world_{state.replace(' ', '_').lower()}", area)
    world.node_tree.nodes.clear()
    yield from stage.show(area, "world without a node")
    stage.scene.world = None
    yield from stage.show(area, "no world")


def material_states(stage: Stage, cube: Any) -> Step:
    area = stage.area("PROPERTIES")
    editing = sys.modules[f"{PACKAGE}.dichromatic_addon.nodes.editing"]
    make_active(stage, cube)
    material = cube.active_material
    yield stage.tab("MATERIAL")
    yield from stage.show(area, "a material of another engine")
    stage.shot("material_foreign", area)
    for surface in SURFACES:
        short = surface.removeprefix("DichromaticNode").lower()
        node = editing.set_surface_node(material, surface)
        yield from stage.show(area, f"{short} as it is new")
        stage.shot(f"material_{short}", area)
        for state in choices_of_node(node):
            yield from stage.show(area, f"{short}: {state}")
        spectral = [socket.name for socket in node.inputs if socket.type == "RGBA" and not socket.hide]
        for name in spectral[:1]:
            spectrum = editing.link_spectrum_node(material.node_tree, node, name)
            for state in choices_of_node(spectrum):
                yield from stage.show(area, f"{short}, {name} linked: {state}")
                if surface == SURFACES[0]:
                    stage.shot(f"material_{short}_{state.replace(' ', '_').lower()}", area)
            editing.unlink_spectrum_node(material.node_tree, node, name)
    material.node_tree.nodes.clear()
    yield from stage.show(area, "a material without nodes")
    cube.material_slots[0].material = None
    yield from stage.show(area, "an empty slot")


def preferences(stage: Stage) -> Step:
    """The add-on's preferences, in the Preferences editor."""
    area = stage.area("TEXT_EDITOR")
    area.ui_type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    stage.window.view_layer.update()
    bpy.context.window_manager.addon_search = "Dichromatic"
    with stage.override(area):
        bpy.ops.preferences.addon_expand(module=PACKAGE)
    drawn = []
    chosen = bpy.context.preferences.addons[PACKAGE].preferences
    draw = type(chosen).draw

    def counted(self: Any, context: Any) -> None:
        draw(self, context)
        drawn.append(True)

    type(chosen).draw = counted
    area.tag_redraw()
    yield until(lambda: drawn or area.tag_redraw(), "the preferences were drawn", limit=20.0)
    for state in states_of(chosen):
        drawn.clear()
        area.tag_redraw()
        yield until(lambda: drawn, f"the preferences were drawn in the state {state}", limit=20.0)
    stage.shot("preferences", area)
    area.ui_type = "TEXT_EDITOR"


def script(stage: Stage) -> Step:
    yield until(lambda: stage.window.screen, "there was a window")
    stage.scene.render.engine = ENGINE
    stage.area("VIEW_3D").ui_type = "TEXT_EDITOR"  # little to draw again and again
    stage.watch_panels()
    cube = bpy.data.objects["Cube"]
    yield from every_tab(stage, cube, "mesh", SHOT_TABS)
    yield from scene_states(stage)
    yield from light_states(stage)
    camera = bpy.data.objects["Camera"]
    for kind in ("PERSP", "ORTHO", "PANO"):
        camera.data.type = kind
        yield from every_tab(stage, camera, f"camera_{kind.lower()}", ("DATA",))
    for name, data in (("Empty", None), ("Curve", bpy.data.curves.new("Curve", "CURVE"))):
        yield from every_tab(stage, add(stage, name, data), name.lower())
    yield from material_states(stage, cube)
    yield from world_states(stage)
    yield from preferences(stage)
    stage.report["drawn"] = dict(stage.drawn)


act(script)
