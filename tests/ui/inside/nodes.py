"""Our nodes in the Shader Editor: added as its menu does, linked, drawn in every state, undone, saved, opened."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
from stage import ENGINE, PACKAGE, Stage, Step, act, choices_of_node, until

SPECTRUM = "DichromaticNodeSpectrum"
PLASTIC = "DichromaticNodePlastic"
LENT_CURVE = ".Dichromatic Curve"  # while Edit Curve is open


def tree_of(name: str = "Material") -> Any:
    return bpy.data.materials[name].node_tree


def own_classes(stage: Stage) -> list[Any]:
    """The node classes of the add-on."""
    modules = [module for name, module in sys.modules.items() if name.startswith(f"{PACKAGE}.dichromatic_addon.nodes.")]
    found = {cls for module in modules for cls in getattr(module, "CLASSES", ()) if issubclass(cls, bpy.types.Node)}
    assert found, "the add-on has no nodes"
    return sorted(found, key=lambda cls: cls.bl_idname)


def add_node(stage: Stage, kind: str) -> Any:
    """What an entry of the Add menu does."""
    with stage.override(stage.area("NODE_EDITOR")):
        bpy.ops.node.add_node(type=kind, use_transform=False)
    return tree_of().nodes.active


def drawn_node(stage: Stage, state: str) -> Step:
    """Have the Shader Editor drawn; what a node's drawing raises stands in the console."""
    area = stage.area("NODE_EDITOR")
    before = stage.drawn["node"]
    area.tag_redraw()
    stage.report.setdefault("states", []).append(state)
    yield until(lambda: stage.drawn["node"] > before, f"a node was drawn in the state: {state}", limit=20.0)


def count_drawing(stage: Stage, cls: Any) -> None:
    draw = cls.draw_buttons

    def counted(node: Any, context: Any, layout: Any) -> None:
        draw(node, context, layout)
        stage.drawn["node"] += 1

    cls.draw_buttons = counted


def frame_nodes(stage: Stage) -> None:
    area = stage.area("NODE_EDITOR")
    with stage.override(area):
        bpy.ops.node.select_all(action="SELECT")
        bpy.ops.node.view_selected()
        bpy.ops.node.select_all(action="DESELECT")


def each_node_alone(stage: Stage) -> Step:
    """Every node of ours in every state, close enough to be read on its picture."""
    for cls in own_classes(stage):
        tree_of().nodes.clear()
        node = add_node(stage, cls.bl_idname)
        assert node.bl_idname == cls.bl_idname, f"the Add menu made a {node.bl_idname} of {cls.bl_idname}"
        short = cls.bl_idname.removeprefix("DichromaticNode").lower()
        yield from drawn_node(stage, short)
        frame_nodes(stage)
        for state in choices_of_node(node):
            yield from drawn_node(stage, f"{short}: {state}")
            stage.shot(f"{short}_{state.replace(' ', '_').lower()}", stage.area("NODE_EDITOR"))
        if not list(stage.folder.glob(f"{short}_*.png")):
            yield from drawn_node(stage, short)
            stage.shot(short, stage.area("NODE_EDITOR"))


def menus(stage: Stage) -> Step:
    """The Add menu has ours; a menu stays open, so it is looked at and closed."""
    area = stage.area("NODE_EDITOR")
    opened: list[bool] = []
    menu = bpy.types.DICHROMATIC_MT_node_add
    draw = menu.draw

    def counted(self: Any, context: Any) -> None:
        draw(self, context)
        opened.append(True)

    menu.draw = counted
    stage.window.event_simulate("MOUSEMOVE", "NOTHING", x=area.x + area.width // 2, y=area.y + area.height // 2)
    yield until(lambda: True, "the mouse was over the editor")
    with stage.override(area):
        bpy.ops.wm.call_menu(name=menu.bl_idname)
    yield until(lambda: opened, "the Add menu was drawn", limit=20.0)
    stage.redraw()
    stage.shot("add_menu", area)
    stage.press("ESC", area)
    menu.draw = draw


def a_material(stage: Stage) -> Step:
    """Nodes added and linked with operators, a change undone and redone, saved and opened."""
    area = stage.area("NODE_EDITOR")
    tree_of().nodes.clear()
    for kind in (SPECTRUM, PLASTIC, "ShaderNodeOutputMaterial"):
        add_node(stage, kind)
    tree = tree_of()
    for number, node in enumerate(tree.nodes):
        node.location = (400 * number, 0)
    with stage.override(area):
        for giver, taker in ((SPECTRUM, PLASTIC), (PLASTIC, "ShaderNodeOutputMaterial")):
            for node in tree.nodes:
                node.select = node.bl_idname in (giver, taker)
            tree.nodes.active = next(node for node in tree.nodes if node.bl_idname == taker)
            bpy.ops.node.link_make()
    links = [(link.from_node.bl_idname, link.to_node.bl_idname, link.to_socket.name) for link in tree.links]
    assert links == [(SPECTRUM, PLASTIC, "Body Reflectance"), (PLASTIC, "ShaderNodeOutputMaterial", "Surface")], links
    yield from drawn_node(stage, "a material of linked nodes")
    frame_nodes(stage)  # which knows their sizes once they were drawn
    yield from drawn_node(stage, "a material of linked nodes, framed")
    stage.shot("linked", area)

    def spectrum() -> Any:
        return next(node for node in tree_of().nodes if node.bl_idname == SPECTRUM)

    with stage.override(area):
        bpy.ops.ed.undo_push(message="before the change")
    spectrum().source = "GAUSSIAN"
    spectrum().centre_nm = 480.0
    with stage.override(area):
        bpy.ops.ed.undo_push(message="the change")
        bpy.ops.ed.undo()
    assert spectrum().source == "LIBRARY", f"undo left the source {spectrum().source}"
    yield from drawn_node(stage, "undone")
    with stage.override(area):
        bpy.ops.ed.redo()
    assert (spectrum().source, round(spectrum().centre_nm)) == ("GAUSSIAN", 480)
    yield from drawn_node(stage, "redone")
    with stage.override(area):
        for node in tree_of().nodes:
            node.select = node.bl_idname == PLASTIC
        bpy.ops.node.duplicate()
    copies = [node for node in tree_of().nodes if node.bl_idname == PLASTIC]
    assert len(copies) == 2
    assert copies[0].node_tree == copies[1].node_tree, "copies share the hidden group"
    yield from drawn_node(stage, "a node copied")
    tree_of().nodes.remove(copies[1])


def curve_dialog(stage: Stage) -> Step:
    """Edit Curve by its button's way: OK keeps what was drawn, and the lent curve is given back."""
    area = stage.area("NODE_EDITOR")
    node = next(node for node in tree_of().nodes if node.bl_idname == SPECTRUM)
    node.source = "CURVE"
    before = str(node["dichromatic_curve"])
    yield from drawn_node(stage, "a drawn curve")
    centre = {"x": area.x + area.width // 2, "y": area.y + area.height // 2}
    stage.window.event_simulate("MOUSEMOVE", "NOTHING", **centre)
    with stage.override(area), bpy.context.temp_override(dichromatic_curve_owner=node):
        bpy.ops.dichromatic.edit_curve("INVOKE_DEFAULT")
    mapping = bpy.data.node_groups[LENT_CURVE].nodes[0].mapping
    mapping.curves[0].points[1].location = (0.35, 0.9)
    mapping.update()
    stage.redraw()
    stage.shot("edit_curve", area)

    def is_over() -> bool:
        if LENT_CURVE in bpy.data.node_groups:
            stage.press("RET", area)  # out of the field that a dialog starts in, then OK
        return LENT_CURVE not in bpy.data.node_groups

    yield until(is_over, "OK gave the lent curve back", limit=20.0)
    assert str(node["dichromatic_curve"]) != before, "OK did not keep the curve"
    yield from drawn_node(stage, "another curve was drawn")


def described() -> list[Any]:
    """What of the material must survive a file: nodes, choices, values and links."""
    nodes = []
    for node in tree_of().nodes:
        values = [(socket.name, round_of(socket)) for socket in node.inputs if hasattr(socket, "default_value")]
        nodes.append([node.bl_idname, getattr(node, "source", ""), getattr(node, "centre_nm", 0.0), values])
    links = [[link.from_node.name, link.to_node.name, link.to_socket.name] for link in tree_of().links]
    return [sorted(nodes, key=str), sorted(links)]


def round_of(socket: Any) -> Any:
    value = socket.default_value
    return round(value, 5) if isinstance(value, float) else str(value) if isinstance(value, str) else list(value)[:3]


def saved_and_opened(stage: Stage) -> Step:
    path = str(stage.folder / "nodes.blend")
    before = described()
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    yield until(lambda: "Material" not in bpy.data.materials, "another file was open")
    bpy.ops.wm.open_mainfile(filepath=path)
    yield until(lambda: bpy.data.filepath == path, "the file was open again")
    assert described() == before, f"{described()} is not what was saved, {before}"
    assert stage.scene.render.engine == ENGINE
    yield until(lambda: stage.window.screen, "there was a window again")
    yield from drawn_node(stage, "opened again")
    stage.shot("opened_again", stage.area("NODE_EDITOR"))


def script(stage: Stage) -> Step:
    yield until(lambda: stage.window.screen, "there was a window")
    stage.scene.render.engine = ENGINE
    area = stage.area("VIEW_3D")
    area.ui_type = "ShaderNodeTree"
    stage.window.view_layer.objects.active = bpy.data.objects["Cube"]
    material = bpy.data.materials["Material"]
    if material.node_tree is None:
        material.use_nodes = True
    yield until(
        lambda: area.tag_redraw() or area.spaces.active.edit_tree == material.node_tree, "the editor had a tree"
    )
    for cls in own_classes(stage):
        count_drawing(stage, cls)
    yield from menus(stage)
    yield from each_node_alone(stage)
    yield from a_material(stage)
    yield from curve_dialog(stage)
    yield from saved_and_opened(stage)
    stage.report["nodes"] = [cls.bl_idname for cls in own_classes(stage)]


act(script)
