# mypy: disable-error-code="valid-type"
"""Converting foreign materials for good, and the list of what is approximated: operators and their menus."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
from bpy.props import EnumProperty

from ._core import core
from .menu_entries import append_entries, remove_entries
from .names import ENGINE_ID
from .nodes.converting import convert, is_convertible

__all__ = ["CLASSES", "REPORT_NAME", "convert_all", "register", "unregister", "write_report"]

REPORT_NAME = "Dichromatic Report"
MOST_LINES = 15  # of a report in its popup; the text has them all


def convert_all(materials: Iterable[Any]) -> tuple[int, list[str]]:
    """Convert every material of a collection that can be.

    Parameters
    ----------
    materials : iterable of bpy.types.Material
        Any materials; those that are ours already are passed over.

    Returns
    -------
    tuple of (int, list of str)
        How many were converted, and what was approximated or could not be converted, a line each.

    Raises
    ------
    None.
    """
    count, lines = 0, []
    for material in materials:
        if not is_convertible(material):
            continue
        try:
            notes = convert(material)
        except core.DichromaticError as error:
            lines.append(f"material '{material.name}' was not converted: {error}")
            continue
        if notes is None:
            lines.append(f"material '{material.name}' has no surface to convert: it is rendered as it is")
        else:
            count += 1
            lines.extend(notes)
    return count, lines


def write_report(title: str, lines: list[str]) -> Any:
    """Put a report into the file's texts, replacing the last one, and return the text."""
    text = bpy.data.texts.get(REPORT_NAME) or bpy.data.texts.new(REPORT_NAME)
    text.clear()
    text.write("\n".join([title, "", *(f"* {line}" for line in lines or ["nothing"])]) + "\n")
    return text


def _show(context: Any, title: str, lines: list[str]) -> None:
    """Write the report, and show its beginning where there is a window."""
    write_report(title, lines)
    if bpy.app.background:
        return

    def draw(self: Any, _: Any) -> None:
        for line in lines[:MOST_LINES]:
            self.layout.label(text=line)
        self.layout.label(text=f"The whole list: text '{REPORT_NAME}' in the Text Editor", icon="TEXT")

    context.window_manager.popup_menu(draw, title=title, icon="INFO")


class DICHROMATIC_OT_convert_material(bpy.types.Operator):
    bl_idname = "dichromatic.convert_material"
    bl_label = "Convert to Dichromatic"
    bl_description = (
        "Give the material dichromatic nodes that render as its shaders do now. "
        "Cycles and EEVEE keep the old shaders, on outputs of their own"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return is_convertible(_shown_material(context))

    def execute(self, context: Any) -> set[str]:
        material = _shown_material(context)
        count, lines = convert_all([material])
        if not count:
            self.report({"WARNING"}, lines[0])
            return {"CANCELLED"}
        _show(context, f"Conversion of material '{material.name}'", lines)
        self.report({"INFO"}, f"Material '{material.name}' was converted; see text '{REPORT_NAME}'")
        return {"FINISHED"}


class DICHROMATIC_OT_convert_materials(bpy.types.Operator):
    bl_idname = "dichromatic.convert_materials"
    bl_label = "Convert Materials to Dichromatic"
    bl_description = (
        "Give materials dichromatic nodes that render as their shaders do now, and list what was approximated. "
        "Cycles and EEVEE keep the old shaders, on outputs of their own"
    )
    bl_options = {"REGISTER", "UNDO"}

    scope: EnumProperty(
        name="Materials",
        description="Which materials to convert",
        items=(
            ("SELECTED", "Of Selected Objects", "Materials of the selected objects"),
            ("ALL", "All", "Every material of the file"),
        ),
        default="ALL",
    )

    def execute(self, context: Any) -> set[str]:
        if self.scope == "ALL":
            found = list(bpy.data.materials)
        else:
            slots = [slot for item in context.selected_objects for slot in item.material_slots]
            found = list(dict.fromkeys(slot.material for slot in slots if slot.material is not None))
        count, lines = convert_all(found)
        _show(context, f"{count} materials were converted", lines)
        self.report({"INFO"}, f"{count} of {len(found)} materials were converted; see text '{REPORT_NAME}'")
        return {"FINISHED"}


class DICHROMATIC_OT_list_approximations(bpy.types.Operator):
    bl_idname = "dichromatic.list_approximations"
    bl_label = "List Approximations"
    bl_description = "Read the scene without rendering it, and list what would be approximated or left out"

    def execute(self, context: Any) -> set[str]:
        from .scene_export import export_scene  # late: it needs the registered properties

        try:
            exported = export_scene(context.evaluated_depsgraph_get())
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        title = f"What is approximated in scene '{context.scene.name}'"
        _show(context, title, list(exported.notes))
        self.report({"INFO"}, f"{len(exported.notes)} approximations; see text '{REPORT_NAME}'")
        return {"FINISHED"}


def _shown_material(context: Any) -> Any:
    """Return the material that a panel shows or the active object has."""
    return getattr(context, "material", None) or getattr(context.object, "active_material", None)


def _draw_material_entry(self: Any, context: Any) -> None:
    if context.engine == ENGINE_ID:
        self.layout.separator()
        self.layout.operator(DICHROMATIC_OT_convert_material.bl_idname)
        self.layout.operator(
            DICHROMATIC_OT_convert_materials.bl_idname, text="Convert All to Dichromatic"
        ).scope = "ALL"


def _draw_object_entry(self: Any, context: Any) -> None:
    if context.engine == ENGINE_ID:
        self.layout.separator()
        self.layout.operator(DICHROMATIC_OT_convert_materials.bl_idname).scope = "SELECTED"


CLASSES = (DICHROMATIC_OT_convert_material, DICHROMATIC_OT_convert_materials, DICHROMATIC_OT_list_approximations)
MENUS = (("MATERIAL_MT_context_menu", _draw_material_entry), ("VIEW3D_MT_object", _draw_object_entry))


def register() -> None:
    """Register the operators, and append them to Blender's menus."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    append_entries(MENUS)


def unregister() -> None:
    """Take everything out again."""
    remove_entries(MENUS)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
