# mypy: disable-error-code="valid-type"
"""The node of metals (Type III)."""

import math
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from .._core import core
from ..callbacks import search_callback, update_callback
from ..names import METAL_NODE
from ..spectrum_sources import search_metals
from .approximation import build_metal, scene_linear_rgb
from .base import MIRROR_INPUT, SURFACE_OUTPUT, DichromaticNode, draw_link_problems, set_input
from .groups import GroupRecipe, SocketRecipe
from .imported import imported_metal, record_of, record_problem

__all__ = ["CLASSES", "DichromaticNodeMetal"]

source_items = (
    ("LIBRARY", "Library", "A metal of the library, by its measured optical constants", "ASSET_MANAGER", 0),
    ("IMPORTED", "Imported", "The metal of an imported material, kept in the .blend alone", "IMPORT", 1),
)

incidence_items = (
    ("facet", "On the Facet", "The angle between the light and the facet that mirrors it to the viewer", 0),
    ("surface", "On the Surface", "The angle between the light and the normal of the surface", 1),
)


def _changed(node: Any, context: Any) -> None:
    node.refresh()
    node.id_data.update_tag()


class DichromaticNodeMetal(DichromaticNode, bpy.types.ShaderNodeCustomGroup):
    """Type III: metals, with two interface terms and no body."""

    bl_idname = METAL_NODE
    bl_label = "Dichromatic Metal"
    bl_description = (
        "Metals (Tominaga 1996, Type III): Torrance-Sparrow facets whose reflectance turns from the metal's color "
        "to white towards grazing incidence"
    )
    bl_icon = "MATERIAL"

    recipe = GroupRecipe(
        tag=METAL_NODE,
        version=2,
        name=".Dichromatic Metal",
        inputs=(
            SocketRecipe(
                "beta",
                "FLOAT",
                math.radians(5.0),
                low=math.radians(0.01),
                high=math.radians(90.0),
                subtype="ANGLE",
                description="Roughness: the tilt of the facets at which their number has fallen to a half, in degrees. "
                "The paper's spun copper has 5; above 26 the published model creates light at grazing angles",
            ),
            SocketRecipe(
                "beta across",
                "FLOAT",
                math.radians(15.0),
                low=math.radians(0.01),
                high=math.radians(90.0),
                subtype="ANGLE",
                description="Roughness across the tangent, in degrees, while beta is that along it. "
                "Brushed and spun metals are rougher across their grooves",
            ),
            MIRROR_INPUT,
            SocketRecipe("Use Across", "FLOAT", 0.0, hidden=True),
            SocketRecipe("RGB", "COLOR", (0.9, 0.6, 0.45, 1.0), hidden=True),
        ),
        output=SURFACE_OUTPUT,
        build=build_metal,
    )

    source: EnumProperty(
        name="Source",
        description="Where the reflectance of the metal comes from",
        items=source_items,
        default="LIBRARY",
        update=update_callback(_changed),
    )
    metal: StringProperty(
        name="Metal",
        description="The metal, by its measured optical constants n and k",
        default="copper",
        search=search_callback(search_metals),
        update=update_callback(_changed),
    )
    anisotropic: BoolProperty(
        name="Anisotropic",
        description="Give the facets another roughness across the tangent (the U direction of the UVs) than along it",
        default=False,
        update=update_callback(_changed),
    )
    incidence: EnumProperty(
        name="Incidence",
        description="The angle at which the metal's reflectance is taken as it turns white towards grazing light",
        items=incidence_items,
        default="facet",
        update=update_callback(_changed),
    )
    energy_conserving: BoolProperty(
        name="Conserve Energy",
        description="Scale the facets so that no light reflects more than it brings. "
        "Off: the published model as it stands, which loses light at small beta and creates it at large",
        default=False,
        update=update_callback(_changed),
    )

    def refresh(self: Any) -> None:
        """Show the inputs that are needed, and bring the approximate colour up to date."""
        if "beta across" not in self.inputs:  # the hidden group is gone; reading the node tells so
            return
        self.inputs["beta across"].hide = not self.anisotropic
        set_input(self, "Use Across", 1.0 if self.anisotropic else 0.0)
        try:
            colour = scene_linear_rgb(self.normal_reflectance())
        except core.DichromaticError:
            colour = (0.0, 0.0, 0.0, 1.0)  # the node's own label and the render tell the reason
        set_input(self, "RGB", colour)

    def normal_reflectance(self: Any) -> core.Spectrum:
        """Return S_I, the reflectance at normal incidence.

        Raises
        ------
        DichromaticError
            If the library lacks the metal, or none was imported.
        """
        if self.source == "IMPORTED":
            return imported_metal(self).normal_reflectance
        constants = core.optical_constants(self.metal)
        return core.TypeIII.from_optical_constants(constants, beta=0.1).normal_reflectance

    def draw_compact(self: Any, layout: Any) -> None:
        """Draw without labels, inside the node."""
        layout.prop(self, "source", text="")
        record = None if record_problem(self) else record_of(self)
        if self.source == "LIBRARY":
            layout.prop(self, "metal", text="")
        elif record is not None:
            layout.label(text=record.name or "Imported metal")
        layout.prop(self, "anisotropic")
        layout.prop(self, "energy_conserving")
        draw_link_problems(self, layout)

    def draw_labelled(self: Any, layout: Any) -> None:
        """Draw the same with labels, for sidebar and panel."""
        layout.prop(self, "source")
        if self.source == "LIBRARY":
            layout.prop(self, "metal")
        layout.prop(self, "incidence")
        column = layout.column()
        column.prop(self, "anisotropic")
        column.prop(self, "energy_conserving")


CLASSES = (DichromaticNodeMetal,)
