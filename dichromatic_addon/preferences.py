# mypy: disable-error-code="valid-type"
"""The preferences of the add-on: where spectra are kept, and what a new file starts with."""

from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.props import EnumProperty, IntProperty, StringProperty

from ._core import core
from .callbacks import search_callback
from .compat import root_package
from .properties import observer_items
from .spectrum_sources import search_illuminants
from .wrapped import draw_wrapped, panel_line

__all__ = ["CLASSES", "preferences", "register", "unregister"]


class DichromaticPreferences(bpy.types.AddonPreferences):
    bl_idname = root_package()

    spectra_folder: StringProperty(
        name="Folder of Spectra",
        description="Spectrum files that are not found where they are said to be are looked for here, by their name",
        subtype="DIR_PATH",
    )
    observer: EnumProperty(
        name="Observer",
        description="The observer that a new file starts with",
        items=observer_items,
        default="cie_1931_2",
    )
    samples: IntProperty(
        name="Samples", description="The rays a pixel that a new file starts with", default=4, min=1, soft_max=64
    )

    lamp: StringProperty(
        name="Lamp",
        description="Lamp of the library that the lights of a new file start with; empty for their own color",
        search=search_callback(search_illuminants),
    )
    manual: StringProperty(
        name="Manual",
        description="Where the documents are, for Online Manual in the menu of a right click: the address of a "
        "website, or the folder that they were built into (make docs builds them into site)",
        subtype="DIR_PATH",
    )

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(self, "spectra_folder")
        column.prop(self, "manual")
        column = layout.column()
        column.label(text="New Files Start With")
        column.prop(self, "observer")
        column.prop(self, "samples")
        column.prop(self, "lamp")
        if self.lamp and self.lamp not in core.illuminant_names():
            draw_wrapped(layout, f"the library has no illuminant '{self.lamp}'", "ERROR", panel_line(context))


def preferences() -> Any:
    """Return the add-on's preferences, or None where it runs without being enabled as an add-on."""
    addon = bpy.context.preferences.addons.get(root_package())
    return addon.preferences if addon else None


@persistent
def _start_new_file(*_: Any) -> None:
    chosen = preferences()
    if chosen is None or bpy.data.filepath:
        return
    for scene in bpy.data.scenes:
        if not scene.dichromatic.is_property_set("observer"):
            scene.dichromatic.observer = chosen.observer
        if not scene.dichromatic.is_property_set("samples"):
            scene.dichromatic.samples = chosen.samples
    if chosen.lamp in core.illuminant_names():
        for light in bpy.data.lights:
            if not light.dichromatic.is_property_set("source"):
                light.dichromatic.source, light.dichromatic.illuminant = "LIBRARY", chosen.lamp


CLASSES = (DichromaticPreferences,)


def register() -> None:
    """Register the preferences, and let new files start with them."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_post.append(_start_new_file)


def unregister() -> None:
    """Take them out again."""
    if _start_new_file in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.remove(_start_new_file)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
