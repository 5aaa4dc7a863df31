# mypy: disable-error-code="valid-type"
"""The node that makes one spectrum of two: a mixture of paints side by side, or a filter in front of one."""

from typing import Any

import bpy
from bpy.props import EnumProperty

from ..names import SPECTRUM_MIX_NODE
from .approximation import build_mix
from .base import DichromaticNode, draw_link_problems, set_input
from .groups import GroupRecipe, SocketRecipe

__all__ = ["CLASSES", "DichromaticNodeSpectrumMix"]

operation_items = (
    ("MIX", "Mix", "The average of both, weighted by the factor: dots or threads too small to be seen", 0),
    ("MULTIPLY", "Multiply", "The product of both at every wavelength: a filter over a surface", 1),
)


def _changed(node: Any, context: Any) -> None:
    node.refresh()
    node.id_data.update_tag()


class DichromaticNodeSpectrumMix(DichromaticNode, bpy.types.ShaderNodeCustomGroup):
    """Makes one spectrum of two."""

    bl_idname = SPECTRUM_MIX_NODE
    bl_label = "Mix Spectra"
    bl_description = "Average two spectra, or multiply one by the other as a filter does"
    bl_icon = "COLOR"

    recipe = GroupRecipe(
        tag=SPECTRUM_MIX_NODE,
        version=1,
        name=".Dichromatic Mix Spectra",
        inputs=(
            SocketRecipe(
                "Factor",
                "FLOAT",
                0.5,
                description="Share of B, 0 to 1. When multiplying, how strongly the filter B acts",
            ),
            SocketRecipe("A", "COLOR", (0.8, 0.8, 0.8, 1.0), description="The first spectrum, or a color to uplift"),
            SocketRecipe("B", "COLOR", (0.2, 0.2, 0.2, 1.0), description="The second spectrum, or a color to uplift"),
            SocketRecipe("Multiply", "FLOAT", 0.0, hidden=True),
        ),
        output=SocketRecipe(
            "Spectrum", "COLOR", (0.8, 0.8, 0.8, 1.0), description="To a spectrum input of a Dichromatic node"
        ),
        build=build_mix,
    )

    operation: EnumProperty(
        name="Operation", description="How the two spectra become one", items=operation_items, update=_changed
    )

    def refresh(self: Any) -> None:
        """Bring the hidden input in line with the operation."""
        set_input(self, "Multiply", 1.0 if self.operation == "MULTIPLY" else 0.0)

    def draw_label(self: Any) -> str:
        """Name the node after what it does."""
        return "Multiply Spectra" if self.operation == "MULTIPLY" else "Mix Spectra"

    def draw_compact(self: Any, layout: Any) -> None:
        """Draw without labels, inside the node."""
        layout.prop(self, "operation", text="")
        draw_link_problems(self, layout)

    def draw_labelled(self: Any, layout: Any) -> None:
        """Draw the same with labels, for sidebar and panel."""
        layout.prop(self, "operation")


CLASSES = (DichromaticNodeSpectrumMix,)
