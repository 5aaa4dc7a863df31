"""Draft, Standard, High, Reference: what they set, and which of them a scene's settings are."""

from __future__ import annotations

from typing import Any

from ._core import core

__all__ = ["apply_quality", "quality_index", "quality_items"]

_SET_BY_QUALITY = ("samples", "precision", "grid", "bounce_grid", "max_bounces")

quality_items = (
    ("draft", "Draft", "One ray a pixel, mirrored light once and at 8 wavelengths", 0),
    ("standard", "Standard", "4 rays a pixel, 4 bounces; where products grow too many, 16 wavelengths", 1),
    ("high", "High", "16 rays a pixel, 6 bounces; where products grow too many, 31 wavelengths", 2),
    ("reference", "Reference", "64 rays a pixel, 8 bounces, 81 wavelengths, 64-bit geometry: slow", 3),
    ("custom", "Custom", "The settings below are those of no preset; choosing this changes nothing", 4),
)


def quality_index(settings: Any) -> int:
    """Return the number of the quality that a scene's settings are, as they stand (a ``get`` callback).

    Parameters
    ----------
    settings : DichromaticSceneSettings
        A scene's settings.

    Returns
    -------
    int
        Number of an item; that of Custom where a setting was changed by hand.
    """
    for name, _, _, number in quality_items:
        if name in core.QUALITIES:
            wanted = core.quality_settings(name)
            if all(getattr(settings, part) == getattr(wanted, part) for part in _SET_BY_QUALITY):
                return number
    return quality_items[-1][3]


def apply_quality(settings: Any, number: int) -> None:
    """Set what a quality stands for (a ``set`` callback); Custom leaves everything as it is."""
    name = next(item[0] for item in quality_items if item[3] == number)
    if name in core.QUALITIES:
        wanted = core.quality_settings(name)
        for part in _SET_BY_QUALITY:
            setattr(settings, part, getattr(wanted, part))
