"""What nodes keep of an imported material: its whole record, and the samples of its spectra.

Both are ID properties that hold text. JSON with Python's shortest decimals gives every float64 back to the last bit,
and text survives copy, undo, save, append and link in every version.
"""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Any

import numpy as np

from .._core import core

__all__ = [
    "forget_record",
    "imported_metal",
    "keep_record",
    "keep_spectrum",
    "kept_spectrum",
    "record_of",
    "record_problem",
    "spectrum_problem",
]

RECORD_KEY = "dichromatic_material_record"
SPECTRUM_KEY = "dichromatic_imported_spectrum"


def keep_record(node: Any, record: core.fitting.MaterialRecord) -> None:
    """Keep a material with its provenance on a surface node."""
    node[RECORD_KEY] = core.fitting.format_material_json(record.material, record.name, record.provenance)


def forget_record(node: Any) -> None:
    """Remove what was imported, when the node becomes another material."""
    if RECORD_KEY in node:
        del node[RECORD_KEY]


@lru_cache(maxsize=64)
def _parsed_record(text: str) -> core.fitting.MaterialRecord:
    return core.fitting.parse_material_json(text, "imported material")


def record_of(node: Any) -> core.fitting.MaterialRecord | None:
    """Return what was imported into a surface node, or None.

    Raises
    ------
    SpectrumFileError
        If what is kept was damaged by hand, or a newer version of the add-on wrote it.
    """
    text = node.get(RECORD_KEY)
    return None if text is None else _parsed_record(str(text))


def imported_metal(node: Any) -> core.TypeIII:
    """Return the imported metal of a node; its roughness and incidence are those of the file, not of the node.

    Raises
    ------
    DichromaticError
        If none was imported.
    """
    record = record_of(node)
    if record is None:
        raise core.SpectrumFileError("no metal has been imported; use Import Fitted Material, or choose the library")
    if not isinstance(record.material, core.TypeIII):
        raise core.SpectrumFileError(f"the imported material '{record.name}' is no metal")
    return record.material


def record_problem(node: Any) -> str:
    """Say why the imported metal of a node cannot be had; an empty string when it can."""
    try:
        imported_metal(node)
    except core.DichromaticError as error:
        return str(error)
    return ""


def keep_spectrum(node: Any, spectrum: core.Spectrum) -> None:
    """Keep the samples of a spectrum on a Spectrum node."""
    content = {
        "name": spectrum.name,
        "interpolation": spectrum.interpolation,
        "wavelengths_nm": spectrum.wavelengths_nm.tolist(),
        "values": spectrum.values.tolist(),
    }
    node[SPECTRUM_KEY] = json.dumps(content, allow_nan=False, ensure_ascii=False)


@lru_cache(maxsize=256)
def _parsed_spectrum(text: str) -> core.Spectrum:
    try:
        content = json.loads(text)
        wavelengths, values = np.array(content["wavelengths_nm"]), np.array(content["values"])
        return core.Spectrum(wavelengths, values, content["name"], content["interpolation"])
    except (ValueError, TypeError, KeyError) as error:
        raise core.SpectrumFileError(f"the imported samples are damaged: {error!r}") from error


def kept_spectrum(node: Any) -> core.Spectrum:
    """Return the imported samples of a Spectrum node.

    Raises
    ------
    DichromaticError
        If there are none, or they were damaged by hand.
    """
    text = node.get(SPECTRUM_KEY)
    if text is None:
        raise core.SpectrumFileError("no samples have been imported; choose another source, such as a file")
    return _parsed_spectrum(str(text))


def spectrum_problem(node: Any) -> str:
    """Say why the imported samples of a Spectrum node cannot be had; an empty string when they can."""
    try:
        kept_spectrum(node)
    except core.DichromaticError as error:
        return str(error)
    return ""
