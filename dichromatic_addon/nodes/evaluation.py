"""The spectrum that a Spectrum node stands for, from its properties and its unlinked colour."""

from __future__ import annotations

from typing import Any

from .._core import core
from ..spectrum_sources import radiator, reflectance_by_name, uplifted
from ..spectrum_store import stored_spectrum
from .curve import drawn_spectrum
from .imported import kept_spectrum

__all__ = ["spectrum_of_node"]


def spectrum_of_node(node: Any, scale: float = 1.0) -> core.Spectrum:
    """Return the spectrum of a Spectrum node.

    Parameters
    ----------
    node : bpy.types.Node
        A Spectrum node; an evaluated copy will do.
    scale : float, optional
        Value of its Scale input.

    Returns
    -------
    Spectrum
        Named after the node's source.

    Raises
    ------
    DichromaticError
        If the library lacks the name, the file was not read, or a number lies outside its range.
    """
    source = node.source
    if source == "LIBRARY":
        spectrum = reflectance_by_name(node.library_name)
    elif source == "FILE":
        spectrum = stored_spectrum(node, node.filepath)
    elif source == "STORED":
        spectrum = kept_spectrum(node)
    elif source == "CURVE":
        spectrum = drawn_spectrum(node)
    elif source == "TEMPERATURE":
        spectrum = radiator(node.radiator, node.temperature)
    elif source == "GAUSSIAN":
        spectrum = core.gaussian(node.centre_nm, node.width_nm, node.peak, node.base)
    elif source == "CONSTANT":
        spectrum = core.Spectrum.constant(node.value, name="constant")
    else:
        spectrum = uplifted(node.inputs["Color"].default_value)
    return spectrum if scale == 1.0 else spectrum.scaled(scale)
