"""Light and shadow linking of an object, where Blender shows them with Cycles alone (4.2)."""

from __future__ import annotations

from typing import Any

import bpy

from . import compat
from .panel_base import PropertiesPanel, columns

__all__ = ["CLASSES", "register", "unregister"]


class _LinkingPanel(PropertiesPanel):
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.object) and context.object.type == "LIGHT" and super().poll(context)


def _draw_collection(layout: Any, linking: Any, name: str, kind: str) -> None:
    """Draw a collection of light linking and its members, as Blender's own panels do."""
    layout.column().template_ID(linking, f"{name}_collection", new=f"object.light_linking_{name}_collection_new")
    if getattr(linking, f"{name}_collection") is None:
        return
    row = layout.row()
    row.column().template_light_linking_collection(row, linking, f"{name}_collection")
    column = row.column()
    buttons = column.column(align=True)
    buttons.operator(f"object.light_linking_{kind}_link", icon="ADD", text="").link_state = "INCLUDE"
    buttons.operator("object.light_linking_unlink_from_collection", icon="REMOVE", text="")
    column.operator(f"object.light_linking_{kind}_select", icon="RESTRICT_SELECT_OFF", text="")


class DICHROMATIC_PT_object_light_linking(_LinkingPanel, bpy.types.Panel):
    bl_label = "Light Linking"

    def draw(self, context: Any) -> None:
        _draw_collection(columns(self.layout), context.object.light_linking, "receiver", "receivers")


class DICHROMATIC_PT_object_shadow_linking(_LinkingPanel, bpy.types.Panel):
    bl_label = "Shadow Linking"

    def draw(self, context: Any) -> None:
        _draw_collection(columns(self.layout), context.object.light_linking, "blocker", "blockers")


CLASSES = (DICHROMATIC_PT_object_light_linking, DICHROMATIC_PT_object_shadow_linking)


def register() -> None:
    """Register the panels where Blender has none for every engine."""
    if not compat.has_light_linking_panels():
        for cls in CLASSES:
            bpy.utils.register_class(cls)


def unregister() -> None:
    """Take the panels out again."""
    for cls in reversed(CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
