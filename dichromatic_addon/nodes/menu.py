"""Our nodes in the Add menu of the Shader Editor, where type-to-search finds them too."""

from typing import Any

import bpy

from ..menu_entries import append_entries, remove_entries
from ..names import ENGINE_ID
from . import dielectric, metal, mix, spectrum

__all__ = ["CLASSES", "register", "unregister"]

ADD_MENU = "NODE_MT_shader_node_add_all"


class DICHROMATIC_MT_node_add(bpy.types.Menu):
    bl_idname = "DICHROMATIC_MT_node_add"
    bl_label = "Dichromatic"

    def draw(self, context: Any) -> None:
        for node in (*dielectric.CLASSES, *metal.CLASSES, *spectrum.CLASSES, *mix.CLASSES):
            operator = self.layout.operator("node.add_node", text=node.bl_label)
            operator.type = node.bl_idname
            operator.use_transform = True


def _draw_entry(self: Any, context: Any) -> None:
    space = context.space_data
    if context.engine == ENGINE_ID and getattr(space, "shader_type", "OBJECT") == "OBJECT":
        self.layout.separator()
        self.layout.menu(DICHROMATIC_MT_node_add.bl_idname)


CLASSES = (DICHROMATIC_MT_node_add,)
MENUS = ((ADD_MENU, _draw_entry),)


def register() -> None:
    """Append our entry to Blender's Add menu."""
    append_entries(MENUS)


def unregister() -> None:
    """Take our entry out again."""
    remove_entries(MENUS)
