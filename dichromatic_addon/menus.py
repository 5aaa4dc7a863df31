"""Entries in Blender's menus, where its Menu Search (F3) finds them too: rendering, and studies of the last render."""

from typing import Any

import bpy

from . import last_render
from .conversion import DICHROMATIC_OT_convert_materials, DICHROMATIC_OT_list_approximations
from .menu_entries import append_entries, remove_entries
from .names import ENGINE_ID
from .study_panels import draw_map_button, draw_sheet_button

__all__ = ["CLASSES", "MENUS", "register", "unregister"]


class DICHROMATIC_MT_studies(bpy.types.Menu):
    bl_idname = "DICHROMATIC_MT_studies"
    bl_label = "Dichromatic"
    bl_description = "Studies of the last render; their settings are in the sidebar"

    def draw(self, context: Any) -> None:
        layout = self.layout
        settings = context.scene.dichromatic_studies
        layout.operator("dichromatic.relight", icon="LIGHT")
        layout.operator("dichromatic.show_render", icon="IMAGE_DATA")
        layout.separator()
        draw_map_button(layout, settings)
        draw_sheet_button(layout, settings)
        layout.operator("dichromatic.pick_pixel", icon="EYEDROPPER")
        layout.separator()
        layout.operator("dichromatic.open_render", icon="FILE_FOLDER")
        layout.operator("dichromatic.save_render", icon="FILE_TICK")
        layout.operator("dichromatic.write_spectral_exr", icon="EXPORT")
        layout.operator("dichromatic.free_render", icon="TRASH")


def _draw_image_entry(self: Any, context: Any) -> None:
    if context.engine == ENGINE_ID or last_render.kept_render(context.scene) is not None:
        self.layout.separator()
        self.layout.menu(DICHROMATIC_MT_studies.bl_idname)


def _draw_render_entry(self: Any, context: Any) -> None:
    if context.engine == ENGINE_ID:
        self.layout.separator()
        self.layout.operator("dichromatic.render_image", icon="IMAGE_DATA")
        self.layout.operator(DICHROMATIC_OT_list_approximations.bl_idname)
        self.layout.operator(
            DICHROMATIC_OT_convert_materials.bl_idname, text="Convert All Materials to Dichromatic"
        ).scope = "ALL"


CLASSES = (DICHROMATIC_MT_studies,)
MENUS = (("IMAGE_MT_image", _draw_image_entry), ("TOPBAR_MT_render", _draw_render_entry))


def register() -> None:
    """Register the menu, and append our entries to Blender's."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    append_entries(MENUS)


def unregister() -> None:
    """Take everything out again."""
    remove_entries(MENUS)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
