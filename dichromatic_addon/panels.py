"""The panels of our engine in the Properties editor, and Blender's own panels that it shares."""

from typing import Any

import bpy

from . import material_notes
from .compat import node_tree_of
from .estimation import estimate_lines
from .material_notes import draw_approximations, draw_energy_warnings, draw_provenance
from .names import ENGINE_ID, SPECTRUM_NODES, SURFACE_NODES
from .nodes.base import draw_link_problems
from .nodes.editing import surface_items, surface_node_of
from .nodes.image_panel import draw_image_node
from .nodes.images import IMAGE_NODE
from .output_display import monitor_problem
from .panel_base import PropertiesPanel, columns
from .presets import DICHROMATIC_MT_material_presets
from .properties import MONITOR, illuminant_problem
from .view_transform import is_colorimetric, view_notes
from .wrapped import draw_wrapped, panel_line

__all__ = ["CLASSES", "register", "unregister"]

SHARED_PANELS = {  # of other engines, and useful for ours as they stand
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "MATERIAL_PT_preview",
    "MATERIAL_PT_viewport",
    "WORLD_PT_context_world",
    "VIEWLAYER_PT_layer",
}
NOT_SHARED_PREFIXES = (  # features that our engine does not render
    "DATA_PT_volume",
    "EEVEE_MATERIAL_PT_viewport_settings",
    "MATERIAL_PT_freestyle",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_grease_pencil",
    "RENDER_PT_simplify",  # ours has the same, below the panels that matter more
    "VIEWLAYER_PT_freestyle",
)
NOT_SHARED = {
    *("DATA_PT_light", "NODE_DATA_PT_light"),  # our light panel has the type of the light itself
    *("DATA_PT_spot", "NODE_DATA_PT_spot"),  # they stand in EEVEE's light panel
}


def _draw_file(layout: Any, settings: Any) -> None:
    row = layout.row(align=True)
    row.prop(settings, "filepath")
    row.context_pointer_set("dichromatic_file_owner", settings)
    row.operator("dichromatic.reload_spectrum", text="", icon="FILE_REFRESH")


def _draw_illuminant(layout: Any, context: Any, owner: Any) -> None:
    """Draw the choice of an illuminant, for lights and worlds alike."""
    settings = owner.dichromatic
    column = layout.column()
    column.prop(settings, "source")
    if settings.source == "LIBRARY":
        column.prop(settings, "illuminant")
    elif settings.source == "TEMPERATURE":
        column.prop(settings, "radiator")
        column.prop(settings, "temperature", text="Kelvin")
    elif settings.source == "FILE":
        _draw_file(column, settings)
    draw_wrapped(layout, illuminant_problem(owner), "ERROR", panel_line(context))


class DICHROMATIC_PT_material(PropertiesPanel, bpy.types.Panel):
    bl_label = "Surface"
    bl_context = "material"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.material) and super().poll(context)

    def draw_header_preset(self, context: Any) -> None:
        self.layout.menu(DICHROMATIC_MT_material_presets.bl_idname, text="", icon="PRESET")

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        material = context.material
        node = surface_node_of(material) if node_tree_of(material) else None
        known = {item[0]: item[1] for item in surface_items}
        label = known.get(node.bl_idname, node.name) if node else "None"
        split = layout.split(factor=0.4)
        heading = split.row()
        heading.alignment = "RIGHT"
        heading.label(text="Type")
        split.operator_menu_enum("dichromatic.set_surface", "node_type", text=label, icon="NODE_MATERIAL")
        layout.operator("dichromatic.import_material", icon="IMPORT")
        if node is not None and node.bl_idname in SURFACE_NODES:
            _draw_surface_node(layout, context, node)
            draw_energy_warnings(layout, material, panel_line(context))
            draw_provenance(layout, node, panel_line(context))
            return
        what = "its viewport color" if node is None else "these shaders"
        draw_wrapped(
            layout, f"Rendered from {what}. Choose a type for a spectral material", "INFO", panel_line(context)
        )
        layout.operator("dichromatic.convert_material", icon="FILE_REFRESH")
        draw_approximations(layout, material, panel_line(context))
        if node is not None:
            output = material.node_tree.get_output_node("ALL")
            layout.template_node_view(material.node_tree, output, output.inputs["Surface"])


def _draw_surface_node(layout: Any, context: Any, node: Any) -> None:
    """Draw a node of ours with labels, and the Spectrum nodes that are linked to it below their inputs."""
    node.draw_labelled(layout)
    for socket in node.inputs:
        if socket.hide:
            continue
        if not socket.is_linked:
            row = layout.row(align=True)
            row.prop(socket, "default_value", text=socket.name.removesuffix(" Reflectance"))
            if socket.type == "RGBA":
                row.operator("dichromatic.link_spectrum", text="", icon="ADD").input_name = socket.name
                row.operator("dichromatic.link_image", text="", icon="IMAGE_DATA").input_name = socket.name
            continue
        header, body = layout.panel(f"dichromatic_{socket.name}")
        header.label(text=socket.name)
        header.operator("dichromatic.unlink_spectrum", text="", icon="X", emboss=False).input_name = socket.name
        if body is not None:
            _draw_linked(columns(body), context, socket.links[0].from_node)
    draw_link_problems(node, layout, panel_line(context))


def _draw_linked(layout: Any, context: Any, source: Any) -> None:
    if source.bl_idname == IMAGE_NODE:
        draw_image_node(layout, context, source)
        return
    if source.bl_idname not in SPECTRUM_NODES:
        layout.label(text=source.label or source.name, icon="NODE")
        return
    source.draw_labelled(layout)
    for socket in source.inputs:
        if socket.hide:
            continue
        if socket.is_linked:
            box = layout.box()
            box.label(text=socket.name)
            _draw_linked(box, context, socket.links[0].from_node)
        else:
            layout.prop(socket, "default_value", text=socket.name)
    draw_link_problems(source, layout, panel_line(context))


class DICHROMATIC_PT_light(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.light) and super().poll(context)

    def draw(self, context: Any) -> None:
        layout = self.layout
        light = context.light
        layout.row().prop(light, "type", expand=True)
        columns(layout)
        column = layout.column()
        column.prop(light, "energy", text="Strength" if light.type == "SUN" else "Power")
        if hasattr(light, "exposure"):
            column.prop(light, "exposure")
        if hasattr(light, "normalize"):
            column.prop(light, "normalize")
        if light.type == "SUN":
            column.prop(light, "angle")
        elif light.type in ("POINT", "SPOT"):
            column.prop(light, "shadow_soft_size", text="Radius")
            column.prop(light, "use_soft_falloff")
        elif light.type == "AREA":
            column.prop(light, "shape")
            if light.shape in ("RECTANGLE", "ELLIPSE"):
                size = column.column(align=True)
                size.prop(light, "size", text="Size X")
                size.prop(light, "size_y", text="Y")
            else:
                column.prop(light, "size")
            column.prop(light, "spread")
        column.prop(light, "use_shadow", text="Cast Shadow")


class DICHROMATIC_PT_light_beam(PropertiesPanel, bpy.types.Panel):
    bl_label = "Beam Shape"
    bl_context = "data"
    bl_parent_id = "DICHROMATIC_PT_light"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return super().poll(context) and bool(context.light) and context.light.type == "SPOT"

    def draw(self, context: Any) -> None:
        column = columns(self.layout).column()
        column.prop(context.light, "spot_size", text="Angle")
        column.prop(context.light, "spot_blend", text="Blend", slider=True)
        column.prop(context.light, "show_cone")


class DICHROMATIC_PT_light_illuminant(PropertiesPanel, bpy.types.Panel):
    bl_label = "Illuminant"
    bl_context = "data"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.light) and super().poll(context)

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        light = context.light
        _draw_illuminant(layout, context, light)
        if light.dichromatic.source == "COLOR":
            column = layout.column()
            if getattr(light, "use_temperature", None) is not None:
                column.prop(light, "use_temperature")
                if light.use_temperature:
                    column.prop(light, "temperature")
            column.prop(light, "color")


class DICHROMATIC_PT_world(PropertiesPanel, bpy.types.Panel):
    bl_label = "Background"
    bl_context = "world"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.world) and super().poll(context)

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        world = context.world
        layout.prop(world.dichromatic, "lights_surfaces")
        _draw_illuminant(layout, context, world)
        tree = node_tree_of(world)
        if tree is None:
            layout.prop(world, "color")
            return
        outputs = [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputWorld"]
        output = next((node for node in outputs if node.is_active_output), None)
        if output is None:
            layout.label(text="The world has no output node", icon="INFO")
            return
        layout.template_node_view(tree, output, output.inputs["Surface"])


class DICHROMATIC_PT_sampling(PropertiesPanel, bpy.types.Panel):
    bl_label = "Sampling"
    bl_context = "render"

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        settings = context.scene.dichromatic
        layout.prop(settings, "quality")
        layout.prop(settings, "samples")
        heading = layout.column(heading="Adaptive")
        row = heading.row(align=True)
        row.prop(settings, "use_adaptive", text="")
        threshold = row.row(align=True)
        threshold.active = settings.use_adaptive
        threshold.prop(settings, "adaptive_threshold", text="")
        column = layout.column()
        column.active = settings.use_adaptive
        column.prop(settings, "adaptive_min_samples")
        column = layout.column()
        column.prop(settings, "pixel_filter")
        column.prop(settings, "filter_width")
        layout.prop(settings, "seed")
        column = layout.column(align=True)
        column.operator("dichromatic.estimate", icon="TIME")
        for index, line in enumerate(estimate_lines(context.scene)):
            column.label(text=line, icon="BLANK1" if index else "INFO")


class DICHROMATIC_PT_spectrum(PropertiesPanel, bpy.types.Panel):
    bl_label = "Spectral"
    bl_context = "render"

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        settings = context.scene.dichromatic
        layout.prop(settings, "observer")
        layout.prop(settings, "grid")
        layout.prop(settings, "precision")


class DICHROMATIC_PT_mirrors(PropertiesPanel, bpy.types.Panel):
    bl_label = "Mirrored Light"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        settings = context.scene.dichromatic
        layout.prop(settings, "max_bounces")
        layout.prop(settings, "bounce_spectra", text="Spectra")
        column = layout.column()
        column.active = settings.bounce_spectra == "auto"
        column.prop(settings, "term_limit")
        column = layout.column()
        column.active = settings.bounce_spectra != "terms"
        column.prop(settings, "bounce_grid")


class DICHROMATIC_PT_adaptation(PropertiesPanel, bpy.types.Panel):
    bl_label = "White Adaptation"
    bl_context = "render"

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        settings = context.scene.dichromatic
        layout.prop(settings, "adaptation")
        column = layout.column()
        column.active = settings.adaptation != "none"
        column.prop(settings, "white_source", text="White")
        if settings.white_source == "LIBRARY":
            column.prop(settings, "white_illuminant")
        elif settings.white_source == "TEMPERATURE":
            column.prop(settings, "white_radiator")
            column.prop(settings, "white_temperature", text="Kelvin")
        else:
            column.prop(settings, "white_light")


class DICHROMATIC_PT_output(PropertiesPanel, bpy.types.Panel):
    bl_label = "Film and Output"
    bl_context = "render"

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        scene = context.scene
        layout.prop(scene.render, "film_transparent")
        view = scene.view_settings
        layout.prop(view, "view_transform", text="View")
        for note in view_notes(scene):
            draw_wrapped(layout, note, "INFO", panel_line(context))
        if is_colorimetric(scene):
            text = "Colors within the display's gamut are shown as computed"
            draw_wrapped(layout, text, "CHECKMARK", panel_line(context))
        settings = scene.dichromatic
        column = layout.column()
        column.prop(settings, "display")
        if settings.display == MONITOR:
            column.prop(settings, "monitor_file")
            draw_wrapped(column, monitor_problem(scene), "ERROR", panel_line(context))
        column.prop(settings, "gamut")
        if settings.display != "srgb":
            text = "For Render to Image and the command line; F12 and the 3D view go through the view above"
            draw_wrapped(column, text, "INFO", panel_line(context))
        layout.operator("dichromatic.render_image", icon="IMAGE_DATA")


class DICHROMATIC_PT_simplify(PropertiesPanel, bpy.types.Panel):
    bl_label = "Simplify"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Any) -> None:
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        render = context.scene.render
        layout.active = render.use_simplify
        layout.prop(render, "simplify_subdivision_render", text="Max Subdivision")
        layout.prop(render, "simplify_child_particles_render", text="Max Child Particles")


class DICHROMATIC_PT_performance(PropertiesPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        layout = columns(self.layout)
        render = context.scene.render
        column = layout.column()
        column.prop(render, "threads_mode")
        sub = column.column()
        sub.enabled = render.threads_mode == "FIXED"
        sub.prop(render, "threads")
        layout.prop(render, "use_persistent_data", text="Persistent Data")


CLASSES = (
    DICHROMATIC_PT_material,
    DICHROMATIC_PT_light,
    DICHROMATIC_PT_light_beam,
    DICHROMATIC_PT_light_illuminant,
    DICHROMATIC_PT_world,
    DICHROMATIC_PT_sampling,
    DICHROMATIC_PT_spectrum,
    DICHROMATIC_PT_mirrors,
    DICHROMATIC_PT_adaptation,
    DICHROMATIC_PT_output,
    DICHROMATIC_PT_simplify,
    DICHROMATIC_PT_performance,
)


def _shared_panels() -> list[Any]:
    """Blender's own panels that our engine shows too."""
    shared = []
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        name = panel.__name__
        if engines is None or name.startswith("DICHROMATIC_"):
            continue
        wanted = "BLENDER_RENDER" in engines and name not in NOT_SHARED and not name.startswith(NOT_SHARED_PREFIXES)
        if wanted or name in SHARED_PANELS:
            shared.append(panel)
    return shared


def register() -> None:
    """Register the panels, and join Blender's own."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE_ID)


def unregister() -> None:
    """Leave Blender's panels, and take ours out again."""
    material_notes.unregister()
    for panel in bpy.types.Panel.__subclasses__():
        if not panel.__name__.startswith("DICHROMATIC_"):
            getattr(panel, "COMPAT_ENGINES", set()).discard(ENGINE_ID)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
