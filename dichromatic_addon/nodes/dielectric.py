# mypy: disable-error-code="valid-type"
"""The nodes of the two dielectric types: Plastic (Type I) and Cloth/Paper (Type II)."""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty

from ..callbacks import update_callback
from ..names import CLOTH_NODE, PLASTIC_NODE
from .approximation import build_dielectric
from .base import (
    ATTENUATION_INPUT,
    BODY_INPUT,
    MIRROR_INPUT,
    N_INPUT,
    SURFACE_OUTPUT,
    DichromaticNode,
    attenuation_items,
    draw_link_problems,
    set_input,
)
from .groups import GroupRecipe, SocketRecipe

__all__ = ["CLASSES", "DichromaticNodeCloth", "DichromaticNodePlastic"]


def _changed(node: Any, context: Any) -> None:
    node.refresh()
    node.id_data.update_tag()


class _Dielectric(DichromaticNode):
    """The properties and the drawing that both types share."""

    attenuation: EnumProperty(
        name="Attenuation",
        description="f(rho): how the highlight falls off with the angle rho between the mirrored light and the viewer",
        items=attenuation_items,
        default="cosine",
        update=update_callback(_changed),
    )
    energy_conserving: BoolProperty(
        name="Conserve Energy",
        description="Scale the interface so that no light reflects more than it brings. "
        "Off: the published model as it stands, which creates light at small n and grazing angles",
        default=False,
        update=update_callback(_changed),
    )

    def refresh(self: Any) -> None:
        index = next(item[3] for item in attenuation_items if item[0] == self.attenuation)
        set_input(self, "Attenuation", float(index))

    def draw_compact(self: Any, layout: Any) -> None:
        """Draw without labels, inside the node."""
        layout.prop(self, "attenuation", text="")
        layout.prop(self, "energy_conserving")
        draw_link_problems(self, layout)

    def draw_labelled(self: Any, layout: Any) -> None:
        """Draw the same with labels, for sidebar and panel."""
        layout.prop(self, "attenuation")
        layout.prop(self, "energy_conserving")


class DichromaticNodePlastic(_Dielectric, bpy.types.ShaderNodeCustomGroup):
    """Type I: plastic and paint, whose highlight has the colour of the lamp."""

    bl_idname = PLASTIC_NODE
    bl_label = "Dichromatic Plastic"
    new_width = 340  # so that the names of its spectra are not cut off
    bl_description = (
        "Plastics and paints (Tominaga 1996, Type I): a colored body below an interface that reflects "
        "all wavelengths alike"
    )
    bl_icon = "MATERIAL"

    recipe = GroupRecipe(
        tag=PLASTIC_NODE,
        version=3,
        name=".Dichromatic Plastic",
        inputs=(
            BODY_INPUT,
            SocketRecipe(
                "Interface Reflectance",
                "FLOAT",
                1.0,
                low=0.0,
                high=1.0e6,
                description="S_I, the strength of the highlight at its center, relative to matte white (no unit). "
                "The paper's cups have 5",
            ),
            N_INPUT,
            MIRROR_INPUT,
            ATTENUATION_INPUT,
        ),
        output=SURFACE_OUTPUT,
        build=build_dielectric,
    )


class DichromaticNodeCloth(_Dielectric, bpy.types.ShaderNodeCustomGroup):
    """Type II: cloth and paper, whose highlight has a colour of its own."""

    bl_idname = CLOTH_NODE
    bl_label = "Dichromatic Cloth/Paper"
    new_width = 340  # so that the names of its spectra are not cut off
    bl_description = (
        "Cloth and paper (Tominaga 1996, Type II): a colored body and an interface with a "
        "spectral reflectance of its own"
    )
    bl_icon = "MATERIAL"

    recipe = GroupRecipe(
        tag=CLOTH_NODE,
        version=2,
        name=".Dichromatic Cloth",
        inputs=(
            BODY_INPUT,
            SocketRecipe(
                "Interface Reflectance",
                "COLOR",
                (0.9, 0.9, 0.9, 1.0),
                description="S_I, the spectral reflectance of the highlight at its center, relative to matte white. "
                "Link a Spectrum or Image Texture node, or choose a color, which is uplifted to a smooth spectrum",
            ),
            N_INPUT,
            MIRROR_INPUT,
            ATTENUATION_INPUT,
        ),
        output=SURFACE_OUTPUT,
        build=build_dielectric,
    )


CLASSES = (DichromaticNodePlastic, DichromaticNodeCloth)
