"""Changing a material's nodes: another surface type, a Spectrum node for an input; operators of panels and menus."""

from typing import Any

import bpy
from bpy.props import EnumProperty, StringProperty

from ..compat import ensure_node_tree
from ..names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE, SPECTRUM_NODES, SURFACE_NODES

__all__ = [
    "CLASSES",
    "InputOperator",
    "editable_material",
    "link_spectrum_node",
    "material_output",
    "remove_unused_spectra",
    "set_surface_node",
    "surface_items",
    "surface_node_of",
    "unlink_spectrum_node",
]

surface_items = (
    (PLASTIC_NODE, "Plastic or Paint", "Type I: a colored body, and a highlight of the lamp's color", "MATERIAL", 0),
    (CLOTH_NODE, "Cloth or Paper", "Type II: a colored body, and a highlight with a color of its own", "MATERIAL", 1),
    (METAL_NODE, "Metal", "Type III: no body; a reflection that turns white towards grazing angles", "MATERIAL", 2),
)

GAP = 60  # between a surface node and the output


def material_output(tree: Any) -> Any:
    """Return the Material Output that our engine reads, made where there is none."""
    output = tree.get_output_node("ALL")
    if output is None:
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        output.location = (300, 300)
    return output


def surface_node_of(material: Any) -> Any:
    """Return the node that is linked to the Surface output directly (reroutes skipped), or None.

    Where light is added to one of our nodes by Add Shader, ours is meant.
    """
    tree = material.node_tree
    output = tree.get_output_node("ALL") if tree else None
    node = _linked_node(output.inputs["Surface"]) if output else None
    if node is not None and node.bl_idname == "ShaderNodeAddShader":
        added = [_linked_node(socket) for socket in node.inputs]
        return next((item for item in added if item is not None and item.bl_idname in SURFACE_NODES), node)
    return node


def _linked_node(socket: Any) -> Any:
    while socket is not None and socket.is_linked:
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def set_surface_node(material: Any, node_type: str) -> Any:
    """Give a material a surface node of a type, keeping what the old one had under the same names.

    The old node is removed when it was ours, or had nothing linked to it, and nobody else uses it.

    Parameters
    ----------
    material : bpy.types.Material
        An editable material.
    node_type : str
        One of the surface nodes' identifiers.

    Returns
    -------
    bpy.types.Node
        The surface node; the present one when it has the type already.
    """
    tree = ensure_node_tree(material)
    output = material_output(tree)
    old = surface_node_of(material)
    if old is not None and old.bl_idname == node_type:
        return old
    node = tree.nodes.new(node_type)
    if old is None:
        node.location = (output.location.x - node.width - GAP, output.location.y)
    else:
        node.location = old.location
        _keep_inputs(tree, old, node)
    ours = old is not None and old.bl_idname in SURFACE_NODES
    targets = [link.to_socket for socket in old.outputs for link in socket.links] if ours else []
    for target in targets or [output.inputs["Surface"]]:
        tree.links.new(node.outputs["Surface"], target)
    if old is not None:
        used = any(socket.is_linked for socket in old.outputs)
        if not used and (ours or not any(socket.is_linked for socket in old.inputs)):
            tree.nodes.remove(old)
        else:
            old.location.y -= 400
        remove_unused_spectra(tree)
    _make_room(node, output)
    tree.update_tag()
    return node


def _make_room(node: Any, output: Any) -> None:
    """Keep a surface node from covering the output: ours are wider than the nodes that they replace."""
    covered = node.location.x + node.width + GAP - output.location.x
    is_left_of_it = node.location.x < output.location.x
    if covered <= 0.0 or not is_left_of_it or node.parent != output.parent:
        return
    if any(socket.is_linked for socket in node.inputs):
        output.location.x += covered  # what is linked stands to the left
    else:
        node.location.x -= covered


def _keep_inputs(tree: Any, old: Any, new: Any) -> None:
    for target in new.inputs:
        source = old.inputs.get(target.name)
        if source is None and target.name == "Body Reflectance":
            source = old.inputs.get("Base Color") or old.inputs.get("Color")
        if target.hide or source is None or source.type not in ("RGBA", "VALUE"):
            continue
        if source.is_linked and source.type == target.type:
            tree.links.new(source.links[0].from_socket, target)
        if source.type == target.type:
            target.default_value = source.default_value
        elif target.type == "RGBA":
            target.default_value = (*(3 * [min(source.default_value, 1.0)]), 1.0)
        else:
            target.default_value = max(source.default_value[:3])
    for name in ("attenuation", "energy_conserving"):
        if hasattr(old, name) and hasattr(new, name):
            setattr(new, name, getattr(old, name))


def remove_unused_spectra(tree: Any) -> None:
    """Remove spectra that fed only the node that has gone, and what fed only them."""
    while unused := [
        node
        for node in tree.nodes
        if node.bl_idname in SPECTRUM_NODES and not any(socket.is_linked for socket in node.outputs)
    ]:
        for node in unused:
            tree.nodes.remove(node)


def link_spectrum_node(tree: Any, node: Any, input_name: str) -> Any:
    """Link a new Spectrum node to an input, starting with the input's colour, and return it."""
    socket = node.inputs[input_name]
    spectrum = tree.nodes.new(SPECTRUM_NODE)
    index = [item.name for item in node.inputs].index(input_name)
    spectrum.location = (node.location.x - 300, node.location.y - 300 * index)
    spectrum.source = "COLOR"
    if socket.type == "RGBA":
        spectrum.inputs["Color"].default_value = socket.default_value
    tree.links.new(spectrum.outputs["Spectrum"], socket)
    return spectrum


def unlink_spectrum_node(tree: Any, node: Any, input_name: str) -> None:
    """Go back from a Spectrum node to a plain colour, its own; remove the node when it feeds nothing."""
    socket = node.inputs[input_name]
    for link in list(socket.links):
        source = link.from_node
        if source.bl_idname == SPECTRUM_NODE and socket.type == "RGBA":
            shown = source.inputs["Color" if source.source == "COLOR" else "RGB"].default_value
            scale = source.inputs["Scale"].default_value
            socket.default_value = (*(part * scale for part in shown[:3]), 1.0)
        tree.links.remove(link)
        if source.bl_idname == "ShaderNodeTexImage" and not any(output.is_linked for output in source.outputs):
            tree.nodes.remove(source)
    remove_unused_spectra(tree)


def editable_material(context: Any) -> Any:
    """Return the material that a panel shows or the active object has; None where it may not be edited."""
    material = getattr(context, "material", None) or getattr(context.object, "active_material", None)
    return material if material is not None and material.library is None else None


class DICHROMATIC_OT_set_surface(bpy.types.Operator):
    bl_idname = "dichromatic.set_surface"
    bl_label = "Set Surface Type"
    bl_description = "Give the material another dichromatic type, keeping its inputs of the same name"
    bl_options = {"REGISTER", "UNDO"}

    node_type: EnumProperty(name="Type", items=surface_items, options={"HIDDEN"})  # type: ignore[valid-type]

    @classmethod
    def poll(cls, context: Any) -> bool:
        return editable_material(context) is not None

    @classmethod
    def description(cls, context: Any, properties: Any) -> str:
        return next(item[2] for item in surface_items if item[0] == properties.node_type)

    def execute(self, context: Any) -> set[str]:
        set_surface_node(editable_material(context), self.node_type)
        return {"FINISHED"}


class InputOperator:
    """Changes what is linked to an input of the material's surface node."""

    bl_options = {"REGISTER", "UNDO"}

    input_name: StringProperty(name="Input", options={"HIDDEN"})  # type: ignore[valid-type]

    @classmethod
    def poll(cls, context: Any) -> bool:
        material = editable_material(context)
        return material is not None and surface_node_of(material) is not None

    def execute(self: Any, context: Any) -> set[str]:
        material = editable_material(context)
        node = surface_node_of(material)
        if self.input_name not in node.inputs:
            self.report({"ERROR"}, f"Node '{node.name}' has no input '{self.input_name}'")
            return {"CANCELLED"}
        self.change(material.node_tree, node)
        return {"FINISHED"}

    def change(self, tree: Any, node: Any) -> None:
        """Change the links of the input, which is there."""
        raise NotImplementedError


class DICHROMATIC_OT_link_spectrum(InputOperator, bpy.types.Operator):
    bl_idname = "dichromatic.link_spectrum"
    bl_label = "Use a Spectrum"
    bl_description = "Link a Spectrum node to this input, to choose from the library, a file, a temperature or a band"

    def change(self, tree: Any, node: Any) -> None:
        link_spectrum_node(tree, node, self.input_name).source = "LIBRARY"


class DICHROMATIC_OT_unlink_spectrum(InputOperator, bpy.types.Operator):
    bl_idname = "dichromatic.unlink_spectrum"
    bl_label = "Use a Color"
    bl_description = "Remove what is linked to this input and set a plain color, which is uplifted to a smooth spectrum"

    def change(self, tree: Any, node: Any) -> None:
        unlink_spectrum_node(tree, node, self.input_name)


class DICHROMATIC_OT_reload_spectrum(bpy.types.Operator):
    bl_idname = "dichromatic.reload_spectrum"
    bl_label = "Reload Spectrum"
    bl_description = "Read the spectrum file again and keep its samples in the .blend"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return getattr(context, "dichromatic_file_owner", None) is not None

    def execute(self, context: Any) -> set[str]:
        owner = context.dichromatic_file_owner
        owner.filepath = owner.filepath  # its update callback reads the file
        return {"FINISHED"}


CLASSES = (
    DICHROMATIC_OT_set_surface,
    DICHROMATIC_OT_link_spectrum,
    DICHROMATIC_OT_unlink_spectrum,
    DICHROMATIC_OT_reload_spectrum,
)
