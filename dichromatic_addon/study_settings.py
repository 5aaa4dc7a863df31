# mypy: disable-error-code="valid-type"
"""What the studies of a scene's last render remember: lamps to compare, a pixel to probe, and whether to relight."""

from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .callbacks import search_callback, update_callback
from .spectrum_sources import search_illuminants

__all__ = ["CLASSES", "STANDARD_LAMPS", "register", "sheet_lamps", "unregister"]

STANDARD_LAMPS = ("D65", "A", "FL2", "FL11")
"""What a contact sheet shows where no lamps are listed: daylight, a light bulb, two kinds of fluorescent tube."""


def _tag(settings: Any, context: Any) -> None:
    settings.id_data.update_tag()


class DichromaticStudyLamp(bpy.types.PropertyGroup):
    """One lamp of a contact sheet."""

    lamp: StringProperty(
        name="Lamp",
        description="Name of the lamp in the library",
        default="D65",
        search=search_callback(search_illuminants),
    )


class DichromaticStudySettings(bpy.types.PropertyGroup):
    """Settings of the studies; none of them changes a render."""

    live_relight: BoolProperty(
        name="Live Relight",
        description="Re-color the last render at once when a lamp, a spectrum, a metal, the observer or the "
        "adaptation is edited; no ray is traced",
        default=True,
        update=update_callback(_tag),
    )
    first_lamp: StringProperty(
        name="First Lamp",
        description="Lamp of the library that all lights of the picture get",
        default="D65",
        search=search_callback(search_illuminants),
    )
    second_lamp: StringProperty(
        name="Second Lamp",
        description="Lamp of the library that it is compared with",
        default="A",
        search=search_callback(search_illuminants),
    )
    largest: FloatProperty(
        name="White at",
        description="Color difference (Delta E 2000) that the map draws white; black is none",
        default=10.0,
        min=0.01,
        soft_max=50.0,
        max=1000.0,
    )
    lamps: CollectionProperty(
        name="Lamps", description="Lamps of the contact sheet, one picture each", type=DichromaticStudyLamp
    )
    active_lamp: IntProperty(name="Active Lamp", description="The lamp that is selected in the list", min=0)
    adapt: BoolProperty(
        name="Adapt to Each Lamp",
        description="Show each picture as an eye sees it that has adapted to its lamp. "
        "Off: all alike, so that the colors of the lamps show",
    )
    columns: IntProperty(
        name="Columns", description="Pictures in a row; 0 chooses about as many as rows", default=0, min=0, soft_max=8
    )
    probe_x: IntProperty(
        name="X", description="Column of the probed pixel, counted from the left, from 0", min=0, subtype="PIXEL"
    )
    probe_y: IntProperty(
        name="Y",
        description="Row of the probed pixel, counted from the bottom as the Image Editor does, from 0",
        min=0,
        subtype="PIXEL",
    )


def sheet_lamps(settings: Any) -> list[str]:
    """Return the names of the lamps that a contact sheet of these settings shows."""
    return [item.lamp for item in settings.lamps if item.lamp] or list(STANDARD_LAMPS)


CLASSES = (DichromaticStudyLamp, DichromaticStudySettings)


def register() -> None:
    """Register the settings and hang them on scenes."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.dichromatic_studies = PointerProperty(name="Dichromatic Studies", type=DichromaticStudySettings)


def unregister() -> None:
    """Take the settings off again."""
    del bpy.types.Scene.dichromatic_studies
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
