"""Spectra read from files, kept in the .blend as well, so that the file can move or vanish.

The samples are ID properties of their owner (a node, a light or a world): they survive copy, undo, save, append and
link in every version. They are assigned as lists, because an array of another length over an existing ID property
corrupts memory.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ._core import core
from .compat import root_package

__all__ = ["load_file", "stored_problem", "stored_spectrum"]

WAVELENGTHS_KEY = "dichromatic_wavelengths_nm"
VALUES_KEY = "dichromatic_values"
PATH_KEY = "dichromatic_spectrum_file"
PROBLEM_KEY = "dichromatic_spectrum_problem"


def _find(owner: Any, filepath: str) -> Path:
    """Return the file where it is said to be, or by its name in the folder of spectra of the preferences."""
    path = Path(bpy.path.abspath(filepath, library=getattr(owner.id_data, "library", None)))
    addon = bpy.context.preferences.addons.get(root_package())
    folder = addon.preferences.spectra_folder if addon else ""
    if folder and not path.is_file():
        other = Path(bpy.path.abspath(folder)) / path.name
        return other if other.is_file() else path
    return path


def _forget(owner: Any) -> None:
    for key in (WAVELENGTHS_KEY, VALUES_KEY, PATH_KEY, PROBLEM_KEY):
        if key in owner:
            del owner[key]


def load_file(owner: Any, filepath: str) -> None:
    """Read a spectrum file and keep its samples on `owner`; a file that cannot be read leaves its reason instead.

    Nothing is raised, since this runs in property callbacks where nobody could catch it; the reason is shown by the
    panels and raised by :func:`stored_spectrum` at render.
    """
    _forget(owner)
    if not filepath:
        return
    owner[PATH_KEY] = filepath
    try:
        spectrum = core.read_spectrum(_find(owner, filepath))
    except (core.DichromaticError, OSError) as error:
        owner[PROBLEM_KEY] = str(error)
        return
    owner[WAVELENGTHS_KEY] = spectrum.wavelengths_nm.tolist()
    owner[VALUES_KEY] = spectrum.values.tolist()


def stored_problem(owner: Any, filepath: str) -> str:
    """Return why `owner` has no samples of the file `filepath`, or an empty string when it has them."""
    if not filepath:
        return "no spectrum file is chosen"
    if owner.get(PATH_KEY) != filepath or (VALUES_KEY not in owner and PROBLEM_KEY not in owner):
        return f"spectrum file '{filepath}' has not been read; reload it"
    return str(owner.get(PROBLEM_KEY, ""))


def stored_spectrum(owner: Any, filepath: str) -> core.Spectrum:
    """Return the samples that `owner` keeps of the file `filepath`.

    Raises
    ------
    DichromaticError
        If the file is not chosen, could not be read or has not been.
    """
    problem = stored_problem(owner, filepath)
    if problem:
        raise core.SpectrumFileError(problem)
    return core.Spectrum(
        np.array(owner[WAVELENGTHS_KEY]), np.array(owner[VALUES_KEY]), name=bpy.path.basename(filepath)
    )
