"""Panels of the View Layer tab, and what objects and worlds have to say about passes: light groups and masks."""

from typing import Any

import bpy

from .menu_entries import append_entries, remove_entries
from .names import ENGINE_ID
from .panel_base import PropertiesPanel, columns
from .wrapped import draw_wrapped, panel_line

__all__ = ["CLASSES", "register", "unregister"]

_WITH_SURFACES = frozenset({"MESH", "CURVE", "SURFACE", "FONT", "META"})
_VISIBILITY = "OBJECT_PT_visibility"  # Blender's own panel


class DICHROMATIC_PT_override(PropertiesPanel, bpy.types.Panel):
    bl_label = "Override"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        view_layer = context.view_layer
        layout.prop(view_layer, "material_override")
        layout.prop(view_layer, "world_override")
        layout.prop(view_layer, "samples")


class DICHROMATIC_PT_passes(PropertiesPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: Any) -> None:
        pass


class DICHROMATIC_PT_passes_data(PropertiesPanel, bpy.types.Panel):
    bl_label = "Data"
    bl_context = "view_layer"
    bl_parent_id = "DICHROMATIC_PT_passes"

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        view_layer = context.view_layer
        column = layout.column(heading="Include", align=True)
        column.prop(view_layer, "use_pass_z", text="Depth")
        column.prop(view_layer, "use_pass_position", text="Position")
        column.prop(view_layer, "use_pass_normal", text="Normal")
        column = layout.column(heading="Indexes", align=True)
        column.prop(view_layer, "use_pass_object_index", text="Object Index")
        column.prop(view_layer, "use_pass_material_index", text="Material Index")


class DICHROMATIC_PT_passes_light(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "view_layer"
    bl_parent_id = "DICHROMATIC_PT_passes"

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        view_layer = context.view_layer
        column = layout.column(heading="Reflection", align=True)
        column.prop(view_layer.dichromatic, "use_pass_body")
        column.prop(view_layer.dichromatic, "use_pass_interface")
        column = layout.column(heading="Other", align=True)
        column.prop(view_layer, "use_pass_emit", text="Emission")
        column.prop(view_layer, "use_pass_environment", text="Environment")
        column.prop(view_layer, "use_pass_shadow", text="Shadow")


class DICHROMATIC_PT_passes_lightgroups(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_parent_id = "DICHROMATIC_PT_passes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        view_layer = context.view_layer
        row = layout.row()
        row.column().template_list(
            "UI_UL_list", "lightgroups", view_layer, "lightgroups", view_layer, "active_lightgroup_index", rows=3
        )
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        column.separator()
        column.menu("VIEWLAYER_MT_lightgroup_sync", icon="DOWNARROW_HLT", text="")
        layout.operator("dichromatic.light_group_each", icon="LIGHT")
        if not view_layer.lightgroups:
            text = "Each group gives a pass with the light of its lamps; all groups and the rest add up to Combined"
            draw_wrapped(layout, text, "INFO", panel_line(context))


def _draw_light_group(layout: Any, owner: Any, view_layer: Any) -> None:
    row = layout.row(align=True)
    sub = row.column(align=True)
    sub.prop_search(owner, "lightgroup", view_layer, "lightgroups", text="Light Group", results_are_suggestions=True)
    sub = row.column(align=True)
    sub.enabled = bool(owner.lightgroup) and owner.lightgroup not in view_layer.lightgroups
    sub.operator("scene.view_layer_add_lightgroup", icon="ADD", text="").name = owner.lightgroup


class DICHROMATIC_PT_object_light_group(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light Group"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        obj = context.object
        return bool(obj) and obj.type in {"LIGHT", "EMPTY", *_WITH_SURFACES} and super().poll(context)

    def draw(self, context: Any) -> None:
        _draw_light_group(columns(self.layout), context.object, context.view_layer)


class DICHROMATIC_PT_world_light_group(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light Group"
    bl_context = "world"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.world) and super().poll(context)

    def draw(self, context: Any) -> None:
        _draw_light_group(columns(self.layout), context.world, context.view_layer)


class DICHROMATIC_PT_object_ray_visibility(PropertiesPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = _VISIBILITY

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.object) and context.object.type in _WITH_SURFACES and super().poll(context)

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        obj = context.object
        column = layout.column()
        column.prop(obj, "visible_camera", text="Camera")
        column.prop(obj, "visible_shadow", text="Shadow")


def _draw_shadow_catcher(self: Any, context: Any) -> None:
    """Draw below Blender's own mask, Holdout, where Cycles has it."""
    if context.engine == ENGINE_ID and context.object.type in _WITH_SURFACES:
        columns(self.layout).prop(context.object, "is_shadow_catcher")


class DICHROMATIC_OT_light_group_each(bpy.types.Operator):
    """Give every light a group of its own."""

    bl_idname = "dichromatic.light_group_each"
    bl_label = "One Group per Light"
    bl_description = (
        "Give every light of this view layer that has no light group yet one of its own, named after it, and so a "
        "pass of its own"
    )
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: Any) -> set[str]:
        view_layer = context.view_layer
        lights = [obj for obj in view_layer.objects if obj.type == "LIGHT" and not obj.lightgroup]
        for obj in lights:
            # Dots end a channel's name in EXR files.
            obj.lightgroup = obj.name.replace(".", "_")
            if obj.lightgroup not in view_layer.lightgroups:
                view_layer.lightgroups.add(name=obj.lightgroup)
        self.report({"INFO"}, f"{len(lights)} lights were given a light group")
        return {"FINISHED"}


CLASSES = (
    DICHROMATIC_PT_override,
    DICHROMATIC_PT_passes,
    DICHROMATIC_PT_passes_data,
    DICHROMATIC_PT_passes_light,
    DICHROMATIC_PT_passes_lightgroups,
    DICHROMATIC_PT_object_light_group,
    DICHROMATIC_PT_world_light_group,
    DICHROMATIC_PT_object_ray_visibility,
    DICHROMATIC_OT_light_group_each,
)
PANELS = ((_VISIBILITY, _draw_shadow_catcher),)


def register() -> None:
    """Register the panels and the operator, and add to Blender's panel of an object's visibility."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    append_entries(PANELS)


def unregister() -> None:
    """Take them out again."""
    remove_entries(PANELS)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
