# mypy: disable-error-code="valid-type"
"""What the add-on keeps on scenes, lights and worlds, and how it becomes spectra and settings of the core."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import compat
from ._core import core
from .callbacks import get_callback, search_callback, set_callback, update_callback
from .light_colours import chosen_illuminant, read_light_colour
from .quality import apply_quality, quality_index, quality_items
from .spectrum_sources import (
    illuminant_by_name,
    luminance,
    radiator,
    radiator_items,
    search_illuminants,
    tinted_daylight,
)
from .spectrum_store import load_file, stored_problem

__all__ = [
    "CLASSES",
    "MONITOR",
    "DisplaySettings",
    "illuminant_problem",
    "light_luminance",
    "read_display",
    "read_illuminant",
    "read_settings",
    "register",
    "unregister",
    "world_illuminant",
]

source_items = (
    ("COLOR", "Own Color", "Daylight (D65) tinted by the color; white is D65 itself", "COLOR", 0),
    ("LIBRARY", "Library", "A standard or measured lamp of the library", "ASSET_MANAGER", 1),
    ("TEMPERATURE", "Temperature", "A blackbody or daylight of some color temperature", "LIGHT", 2),
    ("FILE", "File", "A spectrum file (CSV, SPD and others); its samples are kept in the .blend as well", "FILE", 3),
)

observer_items = (
    ("cie_1931_2", "CIE 1931 2°", "The standard observer for small fields; what sRGB is defined with", 0),
    ("cie_1964_10", "CIE 1964 10°", "The standard observer for large fields, over 4 degrees", 1),
)

grid_items = (
    ("exact", "Exact, 1 nm", "360 to 830 nm at 1 nm, 471 samples; costs nothing more for direct light", 0),
    ("reference", "Reference, 81", "380 to 780 nm at 5 nm", 1),
    ("paper", "Paper, 61", "400 to 700 nm at 5 nm, the samples of Tominaga's paper", 2),
    ("high", "High, 31", "400 to 700 nm at 10 nm", 3),
    ("standard", "Standard, 16", "16 chosen wavelengths; color errors stay below the visible for most lamps", 4),
    ("draft", "Draft, 8", "8 chosen wavelengths, for a quick look", 5),
)

bounce_items = (
    ("auto", "Automatic", "As products of spectra while they are few, at nodes where they would be too many", 0),
    ("terms", "Products", "As products of spectra: exact, whatever their number", 1),
    ("nodes", "Nodes", "At chosen wavelengths: fast, with a small color error", 2),
)

precision_items = (
    ("float32", "Single", "32-bit geometry, for pictures", 0),
    ("float64", "Double", "64-bit geometry throughout, for reference renders; about twice as slow", 1),
)

filter_items = (
    ("box", "Box", "Every point of the pixel counts alike", 0),
    ("triangle", "Triangle", "The middle of the pixel counts most", 1),
    ("gaussian", "Gaussian", "A soft bell", 2),
    ("blackman_harris", "Blackman-Harris", "A soft bell, as in Cycles", 3),
)

adaptation_items = (
    ("none", "None", "Show the colors as they are: tungsten light looks orange", 0),
    ("bradford", "Bradford", "Adapt the adopted white to the display's white, as in ICC profiles", 1),
    ("cat16", "CAT16", "Adapt the adopted white to the display's white, as in CIECAM16", 2),
)

MONITOR = "monitor"

display_items = (
    ("srgb", "sRGB", "Ordinary screens; the image stays linear light, and Blender's view shows it", 0),
    ("display_p3", "Display P3", "Screens with a wide gamut, as in recent phones and laptops", 1),
    ("rec2020", "Rec.2020", "Television of ultra high definition", 2),
    (MONITOR, "Measured Monitor", "A monitor whose primaries and channels were measured, from a CSV file", 3),
)

gamut_items = (
    ("clip", "Clip", "Cut each channel where the display ends", 0),
    ("compress", "Compress", "Desaturate and darken until the display can show the color, keeping its hue", 1),
)

white_items = (
    ("LIBRARY", "Library", "A lamp of the library", 0),
    ("TEMPERATURE", "Temperature", "A blackbody or daylight of some color temperature", 1),
    ("LIGHT", "Light", "The illuminant of one of the file's lights", 2),
)


@dataclass(frozen=True, slots=True)
class DisplaySettings:
    """How the colours of a render are shown.

    Attributes
    ----------
    white : Spectrum
        The adopted white: the light that the eye or camera has adapted to.
    adaptation : str
        "none", "bradford" or "cat16".
    """

    white: core.Spectrum
    adaptation: str


def _tag(settings: Any, context: Any) -> None:
    settings.id_data.update_tag()


def _file_changed(settings: Any, context: Any) -> None:
    load_file(settings.id_data, settings.filepath)
    settings.id_data.update_tag()


class _Illuminant:
    """The properties that choose an illuminant, for lights and worlds alike."""

    source: EnumProperty(
        name="Illuminant",
        description="Where the spectrum of the light comes from",
        items=source_items,
        default="COLOR",
        update=update_callback(_tag),
    )
    illuminant: StringProperty(
        name="Lamp",
        description="Name of the lamp in the library: A, D50, D65, FL2, HP1, LED-B3, projector-halogen and others",
        default="D65",
        search=search_callback(search_illuminants),
        update=update_callback(_tag),
    )
    radiator: EnumProperty(
        name="Radiator",
        description="Which family of lights the temperature selects from",
        items=radiator_items,
        update=update_callback(_tag),
    )
    temperature: FloatProperty(
        name="Temperature",
        description="Color temperature in kelvin: 1900 for a candle, 2856 for a light bulb, 6500 for daylight. "
        "Daylight is defined from 4000 K on",
        default=2856.0,
        min=800.0,
        max=25000.0,
        step=10000,
        precision=0,
        update=update_callback(_tag),
    )
    filepath: StringProperty(
        name="File",
        description="Spectrum file: wavelength in nm and power, column by column. Its samples are kept in the .blend",
        subtype="FILE_PATH",
        options=compat.FILE_PATH_OPTIONS,
        update=update_callback(_file_changed),
    )


class DichromaticLightSettings(_Illuminant, bpy.types.PropertyGroup):
    """The illuminant of a light."""


class DichromaticWorldSettings(_Illuminant, bpy.types.PropertyGroup):
    """The illuminant of the world, and what it lights."""

    lights_surfaces: BoolProperty(
        name="Light Surfaces",
        description="Let surfaces receive the world's light, as in Cycles. Off: the world is only a background",
        default=True,
        update=update_callback(_tag),
    )


class DichromaticSceneSettings(bpy.types.PropertyGroup):
    """How a scene is rendered and shown."""

    quality: EnumProperty(
        name="Quality",
        description="Sets rays a pixel, bounces, precision and the wavelengths of mirrored light together; "
        "direct light is exact in all of them",
        items=quality_items,
        get=get_callback(quality_index),
        set=set_callback(apply_quality),
    )
    samples: IntProperty(
        name="Samples",
        description="Rays a pixel: smooths edges. Colors are exact with a single one",
        default=4,
        min=1,
        soft_max=64,
        max=65536,
    )
    use_adaptive: BoolProperty(
        name="Adaptive Sampling",
        description="Take the further samples only where the first ones differ: at edges, in soft shadows and out of "
        "focus. Flat parts of the picture cost a fraction",
        default=False,
    )
    adaptive_threshold: FloatProperty(
        name="Color Difference",
        description="The difference of the two halves of a pixel's first samples (CIE 1976 Lab) above which it takes "
        "all of them. 1 can just be seen",
        default=1.0,
        min=0.001,
        soft_max=10.0,
        max=100.0,
        precision=2,
    )
    adaptive_min_samples: IntProperty(
        name="Min Samples",
        description="Samples that every pixel takes before it is decided whether it needs the others",
        default=4,
        min=2,
        soft_max=64,
        max=65536,
    )
    seed: IntProperty(name="Seed", description="Equal seeds give equal pictures, bit by bit", default=0, min=0)
    pixel_filter: EnumProperty(
        name="Pixel Filter",
        description="How the rays of a pixel are weighted",
        items=filter_items,
        default="blackman_harris",
    )
    filter_width: FloatProperty(
        name="Width",
        description="Width of the filter in pixels: sharper below, softer above",
        default=1.5,
        min=0.01,
        soft_max=4.0,
        max=16.0,
        subtype="PIXEL",
        precision=2,
    )
    precision: EnumProperty(
        name="Precision",
        description="Precision of the geometry; colors are always integrated in 64 bits",
        items=precision_items,
        default="float32",
    )
    observer: EnumProperty(
        name="Observer",
        description="The eye that sees the spectra: the CIE's color-matching functions",
        items=observer_items,
        default="cie_1931_2",
        update=update_callback(_tag),
    )
    grid: EnumProperty(
        name="Wavelengths",
        description="The wavelengths that spectra are integrated on",
        items=grid_items,
        default="exact",
        update=update_callback(_tag),
    )
    max_bounces: IntProperty(
        name="Max Bounces",
        description="How often light may be mirrored on its way to the camera; only materials with a Mirror do so",
        default=4,
        min=0,
        soft_max=16,
        max=1024,
    )
    bounce_spectra: EnumProperty(
        name="Mirrored Light",
        description="How the spectra of mirrored light are carried",
        items=bounce_items,
        default="auto",
    )
    term_limit: IntProperty(
        name="Product Limit",
        description="The longest list of products of spectra that a pixel may have; mirrored light beyond it is "
        "carried at nodes, and such a render cannot be relit",
        default=128,
        min=1,
        soft_max=1024,
        max=65536,
    )
    bounce_grid: EnumProperty(
        name="Nodes",
        description="The wavelengths that mirrored light is carried at, where it is carried at nodes",
        items=grid_items,
        default="standard",
    )
    adaptation: EnumProperty(
        name="Adaptation",
        description="How the colors of the adopted white are brought to the display's white (D65)",
        items=adaptation_items,
        default="bradford",
        update=update_callback(_tag),
    )
    display: EnumProperty(
        name="Display",
        description="What Render to Image and the command line make pictures for. Images for other displays than sRGB "
        "hold the values that the display is driven with",
        items=display_items,
        default="srgb",
        update=update_callback(_tag),
    )
    monitor_file: StringProperty(
        name="File",
        description="CSV file of a measured monitor: X, Y, Z of the primaries and the white, "
        "and the light of each channel at several drive values",
        subtype="FILE_PATH",
        options=compat.FILE_PATH_OPTIONS,
        update=update_callback(_tag),
    )
    gamut: EnumProperty(
        name="Gamut",
        description="What is done with colors that the display cannot show",
        items=gamut_items,
        default="clip",
        update=update_callback(_tag),
    )
    white_source: EnumProperty(
        name="Adopted White",
        description="The light that the eye or camera has adapted to; it will look white",
        items=white_items,
        default="LIBRARY",
        update=update_callback(_tag),
    )
    white_illuminant: StringProperty(
        name="Lamp",
        description="Name of the lamp in the library whose light is to look white",
        default="D65",
        search=search_callback(search_illuminants),
        update=update_callback(_tag),
    )
    white_radiator: EnumProperty(
        name="Radiator",
        description="Which family of lights the temperature selects from",
        items=radiator_items,
        update=update_callback(_tag),
    )
    white_temperature: FloatProperty(
        name="Temperature",
        description="Color temperature in kelvin of the light that is to look white",
        default=2856.0,
        min=800.0,
        max=25000.0,
        step=10000,
        precision=0,
        update=update_callback(_tag),
    )
    white_light: PointerProperty(
        name="Light",
        description="The light whose illuminant is to look white",
        type=bpy.types.Light,
        update=update_callback(_tag),
    )


def read_illuminant(light: Any) -> core.Spectrum:
    """Return the illuminant of a light.

    Parameters
    ----------
    light : bpy.types.Light
        Original or evaluated.

    Returns
    -------
    Spectrum
        Relative spectral power; its scale means nothing.

    Raises
    ------
    SceneError
        If it cannot be had; the message names the light and the reason.
    """
    return read_light_colour(light, []).illuminant


def light_luminance(light: Any) -> float:
    """Return the factor that a light's colour and nodes put on its power; colours that are not used count for 1."""
    return read_light_colour(light, []).factor


def world_illuminant(scene: Any, colour: Sequence[float]) -> tuple[core.Spectrum, float]:
    """Return the illuminant of a scene's world, and the luminance of the background's colour.

    Parameters
    ----------
    scene : bpy.types.Scene
        A scene with a world.
    colour : sequence of float
        Scene linear RGB of the background; its luminance counts for every source, its hue for "own colour".

    Returns
    -------
    tuple of (Spectrum, float)
        Relative spectral power, and the factor on the background's strength.

    Raises
    ------
    SceneError
        If the illuminant cannot be had; the message names the world and the reason.
    """
    try:
        return chosen_illuminant(scene.world) or tinted_daylight(colour), luminance(colour)
    except core.DichromaticError as error:
        raise core.SceneError(f"Illuminant of world '{scene.world.name}': {error}") from error


def illuminant_problem(owner: Any) -> str:
    """Say why the illuminant of a light or world cannot be had, for its panel; an empty string when it can."""
    settings = owner.dichromatic
    if settings.source == "LIBRARY" and settings.illuminant not in core.illuminant_names():
        return f"the library has no illuminant '{settings.illuminant}'"
    if settings.source == "TEMPERATURE" and settings.radiator == "DAYLIGHT" and settings.temperature < 4000.0:
        return "daylight is defined from 4000 K on"
    if settings.source == "FILE":
        return stored_problem(owner, settings.filepath)
    return ""


def read_settings(scene: Any) -> core.RenderSettings:
    """Return how a scene is rendered; the size is the whole picture's, in percent of the resolution as Blender has it.

    Parameters
    ----------
    scene : bpy.types.Scene
        Original or evaluated.

    Returns
    -------
    RenderSettings
        Checked by the core.

    Raises
    ------
    DichromaticError
        If a value breaks its rule.
    """
    settings, render = scene.dichromatic, scene.render
    return core.RenderSettings(
        width=max(1, render.resolution_x * render.resolution_percentage // 100),
        height=max(1, render.resolution_y * render.resolution_percentage // 100),
        samples=settings.samples,
        pixel_filter=settings.pixel_filter,
        filter_width=settings.filter_width,
        seed=settings.seed,
        observer=settings.observer,
        grid=settings.grid,
        max_bounces=settings.max_bounces,
        bounce_spectra=settings.bounce_spectra,
        bounce_grid=settings.bounce_grid,
        term_limit=settings.term_limit,
        precision=settings.precision,
        adaptive_threshold=settings.adaptive_threshold if settings.use_adaptive else 0.0,
        min_samples=settings.adaptive_min_samples,
        threads=render.threads if render.threads_mode == "FIXED" else 0,
    )


def read_display(scene: Any) -> DisplaySettings:
    """Return how the colours of a scene are shown.

    Parameters
    ----------
    scene : bpy.types.Scene
        Original or evaluated.

    Returns
    -------
    DisplaySettings
        Adopted white and adaptation.

    Raises
    ------
    SceneError
        If the adopted white cannot be had; the message gives the reason.
    """
    settings = scene.dichromatic
    try:
        if settings.white_source == "TEMPERATURE":
            white = radiator(settings.white_radiator, settings.white_temperature)
        elif settings.white_source == "LIBRARY":
            white = illuminant_by_name(settings.white_illuminant)
        elif settings.white_light is None:
            raise core.SceneError("no light is chosen")
        else:
            white = read_illuminant(settings.white_light)
    except core.DichromaticError as error:
        raise core.SceneError(f"Adopted white of scene '{scene.name}': {error}") from error
    return DisplaySettings(white=white, adaptation=settings.adaptation)


CLASSES = (DichromaticLightSettings, DichromaticWorldSettings, DichromaticSceneSettings)

OWNERS = (
    (bpy.types.Light, DichromaticLightSettings),
    (bpy.types.World, DichromaticWorldSettings),
    (bpy.types.Scene, DichromaticSceneSettings),
)


def register() -> None:
    """Register the property groups and hang them on their owners."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for owner, group in OWNERS:
        owner.dichromatic = PointerProperty(name="Dichromatic", type=group)


def unregister() -> None:
    """Take the properties off again."""
    for owner, _ in reversed(OWNERS):
        del owner.dichromatic
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
