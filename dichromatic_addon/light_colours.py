"""The spectra of lights: what their settings choose, or their colour and their shader nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from . import compat
from ._core import core
from .emission_reading import read_emission, surface_of
from .spectrum_sources import illuminant_by_name, luminance, radiator, tinted_daylight
from .spectrum_store import stored_spectrum

__all__ = ["LightColour", "chosen_illuminant", "read_light_colour"]


@dataclass(frozen=True, slots=True)
class LightColour:
    """What spectrum a light has, and how much its colour and its nodes change its power.

    Attributes
    ----------
    illuminant : Spectrum
        Relative spectral power; its scale means nothing.
    factor : float
        On the light's power.
    """

    illuminant: core.Spectrum
    factor: float


def read_light_colour(light: Any, notes: list[str]) -> LightColour:
    """Read the spectrum of a light, from its settings, its colour and its nodes.

    Parameters
    ----------
    light : bpy.types.Light
        Original or evaluated.
    notes : list of str
        What is approximated is added.

    Returns
    -------
    LightColour
        Where another illuminant than its own colour is chosen, colours count for nothing, and a strength in the nodes
        for what it is.

    Raises
    ------
    SceneError
        If the illuminant cannot be had; the message names the light and the reason.
    """
    own = compat.light_colour_factor(light)
    try:
        chosen = chosen_illuminant(light)
    except core.DichromaticError as error:
        raise core.SceneError(f"Illuminant of light '{light.name}': {error}") from error
    tree = compat.node_tree_of(light)
    glow = (
        None
        if tree is None
        else read_emission(surface_of(tree, "ShaderNodeOutputLight"), f"light '{light.name}'", notes)
    )
    if tree is not None and glow is None:
        return LightColour(chosen or core.illuminant("D65"), 0.0)  # nothing is linked to its output
    if chosen is not None:
        return LightColour(chosen, 1.0 if glow is None else glow.plain_strength)
    if glow is None:
        return LightColour(tinted_daylight(own), luminance(own))
    if glow.colour is not None:
        red, green, blue = (a * b for a, b in zip(own, glow.colour, strict=True))
        tint = (red, green, blue)
        return LightColour(tinted_daylight(tint), luminance(tint))
    if len(set(own)) > 1:
        notes.append(f"the color of light '{light.name}' does not tint the spectrum that its nodes give")
    return LightColour(glow.illuminant, luminance(own) * glow.strength)


def chosen_illuminant(owner: Any) -> core.Spectrum | None:
    """Return the illuminant that a light's or world's settings choose; None where that is its own colour.

    Parameters
    ----------
    owner : bpy.types.Light or bpy.types.World
        Original or evaluated.

    Returns
    -------
    Spectrum or None
        Relative spectral power; its scale means nothing.

    Raises
    ------
    DichromaticError
        If it cannot be had.
    """
    settings = owner.dichromatic
    if settings.source == "LIBRARY":
        return illuminant_by_name(settings.illuminant)
    if settings.source == "TEMPERATURE":
        return radiator(settings.radiator, settings.temperature)
    return stored_spectrum(owner, settings.filepath) if settings.source == "FILE" else None
