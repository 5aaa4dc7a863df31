"""Image Texture nodes in the material panel: the image's chooser, how it is read, and where it lies on the surface."""

from __future__ import annotations

from typing import Any

import bpy

from .editing import InputOperator
from .images import IMAGE_NODE

__all__ = ["CLASSES", "draw_image_node", "link_image_node"]


def link_image_node(tree: Any, node: Any, input_name: str) -> Any:
    """Link a new Image Texture node to an input and return it."""
    texture = tree.nodes.new(IMAGE_NODE)
    index = [item.name for item in node.inputs].index(input_name)
    texture.location = (node.location.x - 350, node.location.y - 300 * index)
    tree.links.new(texture.outputs["Color"], node.inputs[input_name])
    tree.update_tag()
    return texture


def draw_image_node(layout: Any, context: Any, node: Any) -> None:
    """Draw an Image Texture node with labels.

    Parameters
    ----------
    layout : bpy.types.UILayout
        Where to draw.
    context : bpy.types.Context
        Its object has the UV maps to choose from.
    node : bpy.types.Node
        The node.
    """
    layout.template_ID(node, "image", new="image.new", open="image.open")
    column = layout.column()
    column.prop(node, "interpolation")
    column.prop(node, "extension")
    if node.image is not None:
        column.prop(node.image.colorspace_settings, "name", text="Color Space")
        column.prop(node.image, "alpha_mode")
    _draw_placement(layout, context, node.inputs["Vector"])


def _draw_placement(layout: Any, context: Any, socket: Any) -> None:
    """Draw what is directly before a Vector input: Mapping nodes with constant values, and a UV Map node."""
    for _ in range(16):
        if not socket.is_linked:
            return
        source = socket.links[0].from_node
        if source.bl_idname == "ShaderNodeUVMap":
            mesh = getattr(context.object, "data", None)
            if hasattr(mesh, "uv_layers"):
                layout.prop_search(source, "uv_map", mesh, "uv_layers", text="UV Map")
            else:
                layout.prop(source, "uv_map", text="UV Map")
        if source.bl_idname != "ShaderNodeMapping":
            return
        column = layout.column()
        column.prop(source, "vector_type")
        for name in ("Location", "Rotation", "Scale"):
            part = source.inputs.get(name)
            if part is not None and not part.is_linked:
                column.prop(part, "default_value", text=name)
        socket = source.inputs["Vector"]


class DICHROMATIC_OT_link_image(InputOperator, bpy.types.Operator):
    bl_idname = "dichromatic.link_image"
    bl_label = "Use an Image"
    bl_description = (
        "Link an Image Texture node to this input: its colors are uplifted to spectra, pixel by pixel, and lie on the "
        "surface by its UV map"
    )

    def change(self, tree: Any, node: Any) -> None:
        link_image_node(tree, node, self.input_name)


CLASSES = (DICHROMATIC_OT_link_image,)
