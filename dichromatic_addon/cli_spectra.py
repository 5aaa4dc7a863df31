"""Spectra on the command line: a name of the library, a colour temperature such as 3200K, or a file."""

from __future__ import annotations

import re
from pathlib import Path

from ._core import core

__all__ = ["HELP", "assignment", "lamp", "reflectance"]

HELP = "a name of the library (D65, FL11), a temperature (3200K a blackbody, 6500D a daylight), or a spectrum file"
_TEMPERATURE = re.compile(r"(\d+(?:\.\d+)?)([KD])", re.IGNORECASE)


def lamp(text: str) -> core.Spectrum:
    """Return the illuminant that a word of the command line means, or raise a DichromaticError."""
    found = _TEMPERATURE.fullmatch(text)
    if text in core.illuminant_names():
        return core.illuminant(text)
    if found:
        kelvin = float(found[1])
        return core.blackbody(kelvin, name=text) if found[2].upper() == "K" else core.daylight(kelvin)
    return _from_file(text, "illuminant")


def reflectance(text: str) -> core.Spectrum:
    """Return the reflectance that a word of the command line means, or raise a DichromaticError."""
    if text in core.reflectance_names():
        return core.reflectance(text)
    if text in core.metal_names():
        return core.TypeIII.from_optical_constants(core.optical_constants(text), 0.1).reflectances[0]
    return _from_file(text, "reflectance")


def assignment(text: str) -> tuple[str, str]:
    """Split NAME=VALUE at the last equals sign, since names may contain others."""
    name, found, value = text.rpartition("=")
    if not found or not name or not value:
        raise core.InvalidParameterError(f"must be NAME=VALUE, but is {text!r}")
    return name, value


def _from_file(text: str, what: str) -> core.Spectrum:
    if not Path(text).is_file():
        raise core.InvalidParameterError(f"the library has no {what} {text!r}, and there is no such file")
    return core.read_spectrum(text)
