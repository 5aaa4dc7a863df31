# mypy: disable-error-code="valid-type"
"""The Spectrum node: one spectrum from the library, a file, a temperature, a band, a constant or a colour."""

from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from .._core import core
from ..callbacks import search_callback, update_callback
from ..compat import FILE_PATH_OPTIONS
from ..names import SPECTRUM_NODE
from ..spectrum_sources import radiator_items, search_spectra
from ..spectrum_store import load_file
from .approximation import build_spectrum, scene_linear_rgb
from .base import DichromaticNode, draw_link_problems, set_input
from .curve import FIRST_CURVE, curve_problem, draw_curve, keep_curve
from .evaluation import spectrum_of_node
from .groups import GroupRecipe, SocketRecipe
from .imported import kept_spectrum, spectrum_problem
from .plot import draw_plot

__all__ = ["CLASSES", "DichromaticNodeSpectrum"]

source_items = (
    ("LIBRARY", "Library", "A measured spectrum that comes with the add-on", "ASSET_MANAGER", 0),
    ("FILE", "File", "A spectrum file (CSV, SPD and others); its samples are kept in the .blend as well", "FILE", 1),
    (
        "TEMPERATURE",
        "Temperature",
        "The light of a blackbody or daylight of some temperature, largest value 1",
        "LIGHT",
        2,
    ),
    ("GAUSSIAN", "Band", "A Gaussian band on a constant base", "SMOOTHCURVE", 3),
    ("CONSTANT", "Constant", "The same value at every wavelength: a neutral grey", "REMOVE", 4),
    ("COLOR", "RGB Uplift", "The smooth spectrum whose color under daylight (D65) is the one chosen", "COLOR", 5),
    ("STORED", "Imported", "The samples of an imported material, kept in the .blend alone", "IMPORT", 6),
    ("CURVE", "Curve", "A curve from 380 to 780 nm that is drawn by hand", "FCURVE", 7),
)


def _changed(node: Any, context: Any) -> None:
    node.refresh()
    node.id_data.update_tag()


def _source_changed(node: Any, context: Any) -> None:
    if node.source == "CURVE" and curve_problem(node):
        keep_curve(node, FIRST_CURVE)
    _changed(node, context)


def _file_changed(node: Any, context: Any) -> None:
    load_file(node, node.filepath)
    _changed(node, context)


class DichromaticNodeSpectrum(DichromaticNode, bpy.types.ShaderNodeCustomGroup):
    """Gives a spectrum to the dichromatic surface nodes."""

    bl_idname = SPECTRUM_NODE
    bl_label = "Spectrum"
    bl_description = "A spectral reflectance or other spectrum over wavelength, for the Dichromatic nodes"
    bl_icon = "COLOR"

    recipe = GroupRecipe(
        tag=SPECTRUM_NODE,
        version=2,
        name=".Dichromatic Spectrum",
        inputs=(
            SocketRecipe(
                "Color",
                "COLOR",
                (0.8, 0.1, 0.05, 1.0),
                description="The color under daylight (D65) that the spectrum is to have",
            ),
            SocketRecipe(
                "Scale", "FLOAT", 1.0, low=0.0, high=1.0e6, description="Factor on the whole spectrum (no unit)"
            ),
            SocketRecipe("RGB", "COLOR", (0.8, 0.8, 0.8, 1.0), hidden=True),
            SocketRecipe("Use Color", "FLOAT", 0.0, hidden=True),
        ),
        output=SocketRecipe(
            "Spectrum", "COLOR", (0.8, 0.8, 0.8, 1.0), description="To a spectrum input of a Dichromatic node"
        ),
        build=build_spectrum,
    )

    source: EnumProperty(
        name="Source",
        description="Where the spectrum comes from",
        items=source_items,
        default="LIBRARY",
        update=update_callback(_source_changed),
    )
    library_name: StringProperty(
        name="Name",
        description="Name of the spectrum in the library: paints, plastics, cloth, ColorChecker patches, or a lamp",
        default="white 9.5",
        search=search_callback(search_spectra),
        update=update_callback(_changed),
    )
    filepath: StringProperty(
        name="File",
        description="Spectrum file: wavelength in nm and value, column by column. Its samples are kept in the .blend",
        subtype="FILE_PATH",
        options=FILE_PATH_OPTIONS,
        update=update_callback(_file_changed),
    )
    radiator: EnumProperty(
        name="Radiator",
        description="Which family of lights the temperature selects from",
        items=radiator_items,
        update=update_callback(_changed),
    )
    temperature: FloatProperty(
        name="Temperature",
        description="Color temperature in kelvin: 2856 for a light bulb, 6500 for daylight",
        default=6500.0,
        min=800.0,
        max=25000.0,
        step=10000,
        precision=0,
        update=update_callback(_changed),
    )
    centre_nm: FloatProperty(
        name="Center (nm)",
        description="Wavelength of the band's peak in nm",
        default=550.0,
        min=360.0,
        max=830.0,
        step=500,
        precision=1,
        update=update_callback(_changed),
    )
    width_nm: FloatProperty(
        name="Width (nm)",
        description="Full width of the band at half its height in nm",
        default=60.0,
        min=0.1,
        max=1000.0,
        step=500,
        precision=1,
        update=update_callback(_changed),
    )
    peak: FloatProperty(
        name="Peak",
        description="Value at the center of the band (a reflectance, 0 to 1)",
        default=0.8,
        min=0.0,
        soft_max=1.0,
        update=update_callback(_changed),
    )
    base: FloatProperty(
        name="Base",
        description="Value far from the band; above the peak it makes an absorption band",
        default=0.05,
        min=0.0,
        soft_max=1.0,
        update=update_callback(_changed),
    )
    value: FloatProperty(
        name="Value",
        description="The value at every wavelength (a reflectance, 0 to 1)",
        default=0.5,
        min=0.0,
        soft_max=1.0,
        update=update_callback(_changed),
    )

    def set_curve(self: Any, points: Any) -> None:
        """Draw the curve of the source "Curve" through (wavelength in nm, value) pairs, 380 to 780 nm and 0 to 1.

        Raises
        ------
        InvalidParameterError
            If there are fewer than two points, or one is out of range.
        """
        keep_curve(self, points)
        _changed(self, None)

    def refresh(self: Any) -> None:
        """Show the inputs that the source needs, and bring the approximate colour up to date."""
        if "Color" not in self.inputs:  # the hidden group is gone; reading the node tells so
            return
        of_colour = self.source == "COLOR"
        self.inputs["Color"].hide = not of_colour
        set_input(self, "Use Color", 1.0 if of_colour else 0.0)
        try:
            colour = scene_linear_rgb(spectrum_of_node(self))
        except core.DichromaticError:
            colour = (0.0, 0.0, 0.0, 1.0)  # the node's own label and the render tell the reason
        set_input(self, "RGB", colour)

    def draw_label(self: Any) -> str:
        """Name the node after what it gives."""
        if self.source == "LIBRARY":
            return str(self.library_name).capitalize()
        if self.source == "FILE":
            return bpy.path.basename(self.filepath) or "Spectrum"
        if self.source == "TEMPERATURE":
            return f"{'Daylight' if self.radiator == 'DAYLIGHT' else 'Blackbody'} {self.temperature:.0f} K"
        if self.source == "GAUSSIAN":
            return f"Band at {self.centre_nm:.0f} nm"
        if self.source == "CURVE":
            return "Drawn Curve"
        if self.source == "STORED":
            return ("" if spectrum_problem(self) else kept_spectrum(self).name) or "Imported Spectrum"
        return "Spectrum"

    def draw_compact(self: Any, layout: Any) -> None:
        """Draw without labels, inside the node."""
        layout.prop(self, "source", text="")
        if self.source == "LIBRARY":
            layout.prop(self, "library_name", text="")
        elif self.source == "FILE":
            self._draw_file(layout, text="")
        elif self.source == "TEMPERATURE":
            layout.prop(self, "radiator", text="")
            layout.prop(self, "temperature", text="Kelvin")
        elif self.source == "GAUSSIAN":
            self._draw_band(layout)
        elif self.source == "CONSTANT":
            layout.prop(self, "value")
        elif self.source == "CURVE":
            draw_curve(layout, self)
        self._draw_look(layout)
        draw_link_problems(self, layout)

    def draw_labelled(self: Any, layout: Any) -> None:
        """Draw the same with labels, for sidebar and panel."""
        layout.prop(self, "source")
        if self.source == "LIBRARY":
            layout.prop(self, "library_name")
        elif self.source == "FILE":
            self._draw_file(layout, text="File")
        elif self.source == "TEMPERATURE":
            layout.prop(self, "radiator")
            layout.prop(self, "temperature", text="Kelvin")
        elif self.source == "GAUSSIAN":
            self._draw_band(layout)
        elif self.source == "CONSTANT":
            layout.prop(self, "value")
        elif self.source == "CURVE":
            draw_curve(layout, self)
        self._draw_look(layout)

    def _draw_file(self: Any, layout: Any, text: str) -> None:
        row = layout.row(align=True)
        row.prop(self, "filepath", text=text)
        row.context_pointer_set("dichromatic_file_owner", self)
        row.operator("dichromatic.reload_spectrum", text="", icon="FILE_REFRESH")

    def _draw_band(self: Any, layout: Any) -> None:
        for names in (("centre_nm", "width_nm"), ("peak", "base")):
            column = layout.column(align=True)
            for name in names:
                column.prop(self, name)

    def _draw_look(self: Any, layout: Any) -> None:
        try:
            spectrum = spectrum_of_node(self)
        except core.DichromaticError:
            return  # the node's own label and the render tell the reason
        draw_plot(layout, spectrum)
        if self.source != "COLOR" and "RGB" in self.inputs:
            swatch = layout.row()
            swatch.enabled = False
            swatch.prop(self.inputs["RGB"], "default_value", text="Under D65")


CLASSES = (DichromaticNodeSpectrum,)
