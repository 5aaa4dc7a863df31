"""Materials without our nodes: what can be made of the shaders of an existing scene, and said about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .._core import core
from ..spectrum_sources import uplifted
from .closures import Tint
from .foreign_shaders import ShaderReader
from .images import Coordinates
from .inputs import InputReader
from .joining import Joined, join
from .links import Origin

__all__ = ["ForeignReading", "read_foreign_surface", "read_viewport_colour"]


@dataclass(frozen=True, slots=True)
class ForeignReading:
    """What was made of a material without our nodes.

    Attributes
    ----------
    joined : Joined
        The material and its light.
    notes : tuple of str
        What was approximated, for the render statistics.
    is_invisible : bool
        Whether Cycles shows nothing of the surface: it is wholly transparent, or there is none around a volume.
    coordinates : Coordinates or None
        What its images are placed by; None without images.
    """

    joined: Joined
    notes: tuple[str, ...]
    is_invisible: bool = False
    coordinates: Coordinates | None = None


def read_viewport_colour(material: Any, reason: str, *, is_invisible: bool = False) -> ForeignReading:
    """Make a matte material of the colour that the solid viewport shows.

    Parameters
    ----------
    material : bpy.types.Material
        The material.
    reason : str
        Why nothing better can be read.
    is_invisible : bool, optional
        Whether there is no surface to be seen.

    Returns
    -------
    ForeignReading
        The material.

    Raises
    ------
    None.
    """
    red, green, blue = (float(part) for part in material.diffuse_color[:3])
    body = Tint(uplifted((red, green, blue), name=f"{material.name} (viewport colour)"), (red, green, blue))
    matte = core.TypeI(body_reflectance=body.spectrum, interface_reflectance=0.0, attenuation="cosine", n=1.0)
    told = reason if is_invisible else f"{reason}; its viewport colour was uplifted to a spectrum"
    return ForeignReading(
        Joined(matte, body, None, None), (f"material '{material.name}': {told}",), is_invisible=is_invisible
    )


def read_foreign_surface(material: Any, origin: Origin, reader: InputReader) -> ForeignReading:
    """Make a material of a tree of shaders, Blender's own or mixed with ours.

    Parameters
    ----------
    material : bpy.types.Material
        The material, for its name and its viewport colour.
    origin : Origin
        The output that is linked to Surface.
    reader : InputReader
        Reads what our own nodes give.

    Returns
    -------
    ForeignReading
        The material, its light, and what was approximated.

    Raises
    ------
    DichromaticError
        If one of our nodes among the shaders cannot be read, or the links form a cycle.
    """
    shaders = ShaderReader(reader)
    shaders.read(origin)
    parts = shaders.parts
    if not (parts.bodies or parts.lobes or parts.glows or parts.finished):
        why = "; ".join(parts.notes) or f"'{origin.node.name}' gives nothing"
        if parts.transparent > 0.0:
            return read_viewport_colour(material, "it is transparent: left out", is_invisible=True)
        return read_viewport_colour(material, why)
    joined = join(parts)
    notes = [*parts.notes, *reader.notes]
    tints = [body.tint for body in parts.bodies] + [lobe.tint for lobe in parts.lobes]
    if any(tint.colour is not None for tint in tints):
        notes.insert(0, f"the colors of '{origin.node.name}' were uplifted to spectra")
    told = tuple(f"material '{material.name}': {note}" for note in notes)
    return ForeignReading(joined, told, coordinates=reader.coordinates)
