# mypy: disable-error-code="valid-type"
"""The node of metals (Type III)."""

import math
from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty

from .._core import core
from ..callbacks import search_callback, update_callback
from ..names import METAL_NODE
from ..spectrum_sources import search_metals
from .approximation import build_metal, scene_linear_rgb
from .base import MIRROR_INPUT, SURFACE_OUTPUT, DichromaticNode, draw_link_problems, set_input
from .groups import GroupRecipe, SocketRecipe

__all__ = ["CLASSES", "DichromaticNodeMetal"]


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
            constants = core.optical_constants(self.metal)
            colour = scene_linear_rgb(core.TypeIII.from_optical_constants(constants, beta=0.1).normal_reflectance)
        except core.DichromaticError:
            colour = (0.0, 0.0, 0.0, 1.0)  # the node's own label and the render tell the reason
        set_input(self, "RGB", colour)

    def draw_compact(self: Any, layout: Any) -> None:
        """Draw without labels, inside the node."""
        layout.prop(self, "metal", text="")
        layout.prop(self, "anisotropic")
        layout.prop(self, "energy_conserving")
        draw_link_problems(self, layout)

    def draw_labelled(self: Any, layout: Any) -> None:
        """Draw the same with labels, for sidebar and panel."""
        layout.prop(self, "metal")
        column = layout.column()
        column.prop(self, "anisotropic")
        column.prop(self, "energy_conserving")


CLASSES = (DichromaticNodeMetal,)
