"""The spectra that nodes, lights and the world can choose from, made from what their properties say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mathutils
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import core

__all__ = [
    "illuminant_by_name",
    "luminance",
    "radiator",
    "radiator_items",
    "rec709_to_working",
    "reflectance_by_name",
    "search_illuminants",
    "search_metals",
    "search_spectra",
    "tinted_daylight",
    "uplifted",
    "working_luminance",
    "working_to_rec709",
]

REC709_LUMINANCE = (0.2126, 0.7152, 0.0722)  # ITU-R BT.709-6, item 3.2

radiator_items = (
    ("BLACKBODY", "Blackbody", "Planckian radiator: candles, incandescent lamps", 0),
    ("DAYLIGHT", "Daylight", "CIE daylight phase, 4000 to 25000 K: sun and sky", 1),
)


# Callbacks for ``search`` of a StringProperty. They give all names: Blender lists them all when a field is clicked, and
# looks for what is typed by itself, from then on.


def search_illuminants(owner: Any, context: Any, edit_text: str) -> list[str]:
    """Offer the illuminants of the library."""
    return [*core.illuminant_names()]


def search_spectra(owner: Any, context: Any, edit_text: str) -> list[str]:
    """Offer the reflectances of the library, then its illuminants."""
    return [*core.reflectance_names(), *core.illuminant_names()]


def search_metals(owner: Any, context: Any, edit_text: str) -> list[str]:
    """Offer the metals of the library."""
    return [*core.metal_names()]


def illuminant_by_name(name: str) -> core.Spectrum:
    """Return an illuminant of the library, or raise naming the one that is missing."""
    if name not in core.illuminant_names():
        raise core.InvalidParameterError(f"the library has no illuminant {name!r}")
    return core.illuminant(name)


def reflectance_by_name(name: str) -> core.Spectrum:
    """Return a reflectance (or an illuminant, as a filter) of the library, or raise naming the one that is missing."""
    if name in core.reflectance_names():
        return core.reflectance(name)
    if name in core.illuminant_names():
        return core.illuminant(name)
    raise core.InvalidParameterError(f"the library has no spectrum {name!r}")


def radiator(kind: str, temperature_k: float) -> core.Spectrum:
    """Return the blackbody or daylight spectrum of a temperature in K."""
    return core.daylight(temperature_k) if kind == "DAYLIGHT" else core.blackbody(temperature_k)


def working_to_rec709(colour: Sequence[float]) -> tuple[float, float, float]:
    """Convert a colour of Blender's working space (Rec.2020 or ACEScg in some files) to linear Rec.709."""
    red, green, blue = (float(part) for part in tuple(colour)[:3])
    if red == green == blue:  # a grey is the same grey in every working space; keep it exactly so
        return red, green, blue
    converted = mathutils.Color(tuple(colour)[:3]).from_scene_linear_to_rec709_linear()
    return converted.r, converted.g, converted.b


def uplifted(colour: Sequence[float], name: str = "") -> core.Spectrum:
    """Return a smooth reflectance whose colour under D65 is a scene linear RGB; parts outside Rec.709 are cut off.

    Colours brighter than 1 (a strong interface) give the spectrum of the same colour at 1, times their brightness.
    """
    rgb = [max(part, 0.0) for part in working_to_rec709(colour)]
    brightest = max(1.0, *rgb)
    return core.uplift([part / brightest for part in rgb]).scaled(brightest, name=name or "uplifted color")


def rec709_to_working(colour: Sequence[float]) -> tuple[float, float, float]:
    """Convert a linear Rec.709 colour to Blender's working space."""
    red, green, blue = (float(part) for part in tuple(colour)[:3])
    if red == green == blue:
        return red, green, blue
    converted = mathutils.Color((red, green, blue)).from_rec709_linear_to_scene_linear()
    return converted.r, converted.g, converted.b


def working_luminance(colour: ArrayLike) -> NDArray[np.float64]:
    """Return the luminance (...) of scene linear colours (..., 3); white has 1."""
    primaries = [working_to_rec709(primary) for primary in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    return np.asarray(colour, np.float64) @ (np.array(primaries) @ REC709_LUMINANCE)


def luminance(colour: Sequence[float]) -> float:
    """Return the luminance of one scene linear colour, not negative."""
    rgb = working_to_rec709(colour)
    return rgb[0] if len(set(rgb)) == 1 and rgb[0] > 0.0 else max(0.0, float(np.dot(rgb, REC709_LUMINANCE)))


def tinted_daylight(colour: Sequence[float]) -> core.Spectrum:
    """Daylight whose linear RGB is `colour` up to its brightness: D65 times the reflectance of that colour."""
    tint = uplifted(colour)
    daylight = core.illuminant("D65")
    if tint.is_constant:  # white, or black, whose power is zero whatever its spectrum
        return daylight
    wavelengths = core.REFERENCE_WAVELENGTHS_NM
    return core.Spectrum(wavelengths, tint.at(wavelengths) * daylight.at(wavelengths), name="tinted D65")
