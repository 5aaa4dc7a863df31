"""The panels of the studies: in Render properties, and in the sidebar of the Image Editor."""

from typing import Any

import bpy

from . import last_render
from .live_relight import image_name
from .names import ENGINE_ID
from .panel_base import PropertiesPanel
from .relighting import settings_differences
from .study_settings import STANDARD_LAMPS
from .wrapped import draw_wrapped, panel_line

__all__ = ["CLASSES", "draw_map_button", "draw_sheet_button", "register", "unregister"]


class _InRenderProperties(PropertiesPanel):
    bl_context = "render"


class _StudyInRenderProperties(_InRenderProperties):
    """A study of the last render: there must be one."""

    bl_parent_id = "DICHROMATIC_PT_studies"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return super().poll(context) and last_render.kept_render(context.scene) is not None


class _InImageEditor:
    """Shown with our engine, and with any other while a render of ours is kept."""

    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Dichromatic"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine == ENGINE_ID or last_render.kept_render(context.scene) is not None


class _StudyInImageEditor(_InImageEditor):
    """A study of the last render: there must be one."""

    @classmethod
    def poll(cls, context: Any) -> bool:
        return last_render.kept_render(context.scene) is not None


class _Kept:
    """The last render: what it is, whether it can be relit, and what to do with it."""

    bl_label = "Last Render"

    def draw(self: Any, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        kept = last_render.kept_render(context.scene)
        if kept is None:
            draw_wrapped(layout, "Render this scene, or open a render, to study it here", "INFO", panel_line(context))
            layout.operator("dichromatic.open_render", text="Open", icon="FILE_FOLDER")
            return
        _draw_facts(layout, context, kept)
        column = layout.column()
        column.prop(context.scene.dichromatic_studies, "live_relight")
        row = layout.row(align=True)
        row.operator("dichromatic.relight", icon="LIGHT")
        row.operator("dichromatic.free_render", text="", icon="TRASH")
        space = getattr(context, "space_data", None)
        if self.bl_space_type == "IMAGE_EDITOR" and space is not None:
            name = image_name(kept, kept.layer(context.view_layer.name).exported.layer)
            show = layout.row()
            show.enabled = space.image is None or space.image.name != name
            show.operator("dichromatic.show_render", icon="IMAGE_DATA")
        _draw_state(layout, context, kept)
        row = layout.row(align=True)
        row.operator("dichromatic.open_render", text="Open", icon="FILE_FOLDER")
        row.operator("dichromatic.save_render", text="Save", icon="FILE_TICK")
        layout.operator("dichromatic.write_spectral_exr", icon="EXPORT")


def _draw_facts(layout: Any, context: Any, kept: last_render.KeptRender) -> None:
    render = kept.layer(context.view_layer.name).render
    film = render.film
    facts = [
        ("File" if kept.source else "Scene", kept.source or context.scene.name),
        ("Size", f"{film.width} \N{MULTIPLICATION SIGN} {film.height} px"),
        ("Terms", str(len(film.terms))),
        ("Memory", f"{kept.nbytes / 2**20:.1f} MiB"),
        ("Relightable", "Yes" if film.is_relightable else "No"),
    ]
    column = layout.column(align=True)
    for name, value in facts:
        split = column.split(factor=0.4)
        heading = split.row()
        heading.alignment = "RIGHT"
        heading.label(text=name)
        split.label(text=value)


def _draw_state(layout: Any, context: Any, kept: last_render.KeptRender) -> None:
    """Say where the picture is no longer what a new render would be."""
    width = panel_line(context)
    finished = kept.layer(context.view_layer.name)
    if not finished.render.film.is_relightable:
        draw_wrapped(
            layout,
            "Mirrored light was carried at nodes, or the film reached its memory limit: only the adaptation can change",
            "INFO",
            width,
        )
    draw_wrapped(layout, kept.problem, "ERROR", width)
    reasons = [*kept.outdated, *kept.differences]
    changed = [] if kept.source else settings_differences(context.scene, finished)
    if changed:
        reasons.append(f"render settings were changed ({', '.join(changed)})")
    if reasons:
        more = f", and {len(reasons) - 2} more" if len(reasons) > 2 else ""
        draw_wrapped(layout, f"Out of date: {'; '.join(reasons[:2])}{more}. Render again to see it", "INFO", width)


def _report(context: Any, name: str) -> str:
    kept = last_render.kept_render(context.scene)
    return str(getattr(kept, name)) if kept is not None else ""


def draw_map_button(layout: Any, settings: Any) -> None:
    """Draw the operator of the metamerism map with the settings of the scene."""
    made = layout.operator("dichromatic.metamerism_map", icon="COLOR")
    made.first, made.second, made.largest = settings.first_lamp, settings.second_lamp, settings.largest


def draw_sheet_button(layout: Any, settings: Any) -> None:
    """Draw the operator of the contact sheet with the settings of the scene."""
    made = layout.operator("dichromatic.contact_sheet", icon="IMGDISPLAY")
    made.adapt, made.columns = settings.adapt, settings.columns


class _Map:
    bl_label = "Metamerism Map"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self: Any, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.dichromatic_studies
        column = layout.column(align=True)
        column.prop(settings, "first_lamp", text="Lamps")
        column.prop(settings, "second_lamp", text=" ")
        layout.prop(settings, "largest")
        draw_map_button(layout, settings)
        draw_wrapped(layout, _report(context, "map_report"), "INFO", panel_line(context))


class _Sheet:
    bl_label = "Contact Sheet"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self: Any, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.dichromatic_studies
        if settings.lamps:
            row = layout.row()
            row.template_list("DICHROMATIC_UL_lamps", "", settings, "lamps", settings, "active_lamp", rows=3)
            column = row.column(align=True)
            column.operator("dichromatic.study_lamps", text="", icon="ADD").action = "ADD"
            column.operator("dichromatic.study_lamps", text="", icon="REMOVE").action = "REMOVE"
        else:
            draw_wrapped(layout, f"Lamps: {', '.join(STANDARD_LAMPS)}", "LIGHT", panel_line(context))
            layout.operator("dichromatic.study_lamps", text="Choose Lamps", icon="ADD").action = "STANDARD"
        layout.prop(settings, "columns")
        layout.prop(settings, "adapt")
        draw_sheet_button(layout, settings)


def _draw_part(layout: Any, line: str, width: int) -> None:
    """Draw the share of one part of a pixel's light, and beside it, in as many lines as it needs, what it is."""
    share, _, name = line.strip().partition(" %  ")
    split = layout.split(factor=0.25)
    left = split.row()
    left.alignment = "RIGHT"
    left.label(text=f"{share} %")
    draw_wrapped(split, name, "NONE", int(0.75 * width))


class _Probe:
    bl_label = "Pixel Probe"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self: Any, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.dichromatic_studies
        column = layout.column(align=True)
        column.prop(settings, "probe_x", text="Pixel X")
        column.prop(settings, "probe_y", text="Y")
        row = layout.row(align=True)
        made = row.operator("dichromatic.probe_pixel", icon="VIEWZOOM")
        made.x, made.y = settings.probe_x, settings.probe_y
        if self.bl_space_type == "IMAGE_EDITOR":
            row.operator("dichromatic.pick_pixel", text="", icon="EYEDROPPER")
        total, *parts = _report(context, "probe_report").splitlines() or [""]
        draw_wrapped(layout, total[:1].upper() + total[1:], "INFO", panel_line(context))
        column = layout.column(align=True)
        for line in parts:
            _draw_part(column, line, panel_line(context))


class DICHROMATIC_UL_lamps(bpy.types.UIList):
    """Lamps of a contact sheet, each chosen by its name in the library."""

    def draw_item(
        self,
        context: Any,
        layout: Any,
        data: Any,
        item: Any,
        icon: int,
        active_data: Any,
        active_property: str,
        index: int = 0,
        flag: int = 0,
    ) -> None:
        layout.prop(item, "lamp", text="", icon="LIGHT", emboss=False)


class DICHROMATIC_PT_studies(_Kept, _InRenderProperties, bpy.types.Panel):
    bl_label = "Studies"
    bl_options = {"DEFAULT_CLOSED"}


class DICHROMATIC_PT_studies_map(_Map, _StudyInRenderProperties, bpy.types.Panel):
    pass


class DICHROMATIC_PT_studies_sheet(_Sheet, _StudyInRenderProperties, bpy.types.Panel):
    pass


class DICHROMATIC_PT_studies_probe(_Probe, _StudyInRenderProperties, bpy.types.Panel):
    pass


class DICHROMATIC_PT_image(_Kept, _InImageEditor, bpy.types.Panel):
    pass


class DICHROMATIC_PT_image_map(_Map, _StudyInImageEditor, bpy.types.Panel):
    pass


class DICHROMATIC_PT_image_sheet(_Sheet, _StudyInImageEditor, bpy.types.Panel):
    pass


class DICHROMATIC_PT_image_probe(_Probe, _StudyInImageEditor, bpy.types.Panel):
    pass


CLASSES = (
    DICHROMATIC_UL_lamps,
    DICHROMATIC_PT_studies,
    DICHROMATIC_PT_studies_map,
    DICHROMATIC_PT_studies_sheet,
    DICHROMATIC_PT_studies_probe,
    DICHROMATIC_PT_image,
    DICHROMATIC_PT_image_map,
    DICHROMATIC_PT_image_sheet,
    DICHROMATIC_PT_image_probe,
)


def register() -> None:
    """Register the panels."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take them out again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
