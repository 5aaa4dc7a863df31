"""Reading spectra: the format by the file's suffix, the checks that are the same for all."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import SpectrumFileError
from ..spectra import Spectrum
from ..validation import require_choice
from ._text import Sample, fail, ordered
from .delimited import read_columns
from .jcamp import read_jcamp
from .spdx import read_spdx

__all__ = ["NEGATIVE_VALUES", "SPECTRUM_SUFFIXES", "read_spectra", "read_spectrum"]

SPECTRUM_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".spd", ".jdx", ".dx", ".jcm", ".jcamp", ".spdx", ".xml")
"""Suffixes that :func:`read_spectrum` knows; optical constants (.yml) are read by ``read_optical_constants``."""

NEGATIVE_VALUES = ("refuse", "zero", "keep")
"""What can be done with negative values: refuse the file, set them to 0, or keep them in a signed spectrum."""

_UNITS = ("auto", "fraction", "percent")


def read_spectra(
    path: str | Path,
    *,
    unit: str = "auto",
    wavelength_unit: str | None = None,
    negative: str = "refuse",
    interpolation: str | None = None,
) -> tuple[Spectrum, ...]:
    """Read all spectra of a file.

    Parameters
    ----------
    path : str or Path
        A file with one of :data:`SPECTRUM_SUFFIXES`. Any step, uniform or not; wavelengths may also fall throughout.
    unit : {"auto", "fraction", "percent"}
        "percent" divides values by 100; "auto" does so where the file says percent.
    wavelength_unit : {"nm", "um", "angstrom"}, optional
        Unit of the wavelengths in files in columns; None follows their header, and means nm where it is silent.
    negative : {"refuse", "zero", "keep"}
        What is done with negative values (the noise of a dark reading): an error, 0, or a signed spectrum.
    interpolation : {"linear", "lagrange"}, optional
        How the spectra are read between samples; None follows the file's remark, and means linear without one.

    Returns
    -------
    tuple of Spectrum
        One a value column, named by header or file.

    Raises
    ------
    SpectrumFileError
        If the file is missing or broken; the message tells file, line and reason.
    InvalidParameterError
        If an option is none of its choices.

    References
    ----------
    McDonald and Wilks 1988 (JCAMP-DX 4.24); ANSI/IES TM-27-20 (SPDX); own design for the rest.
    """
    require_choice("unit", unit, _UNITS)
    require_choice("negative", negative, NEGATIVE_VALUES)
    file = Path(path)
    suffix = file.suffix.lower()
    percent = {"auto": None, "fraction": False, "percent": True}[unit]
    remarks: dict[str, str] = {}
    if suffix in (".jdx", ".dx", ".jcm", ".jcamp"):
        samples, title, says_percent = read_jcamp(file)
        names: tuple[str, ...] = (title,)
        if percent or (percent is None and says_percent):
            samples = [Sample(s.wavelength_nm, (s.values[0] / 100.0,), s.line) for s in samples]
    elif suffix in (".spdx", ".xml"):
        samples, header = read_spdx(file)
        names = (header.get("Description", ""),)
        if percent:
            samples = [Sample(s.wavelength_nm, (s.values[0] / 100.0,), s.line) for s in samples]
    elif suffix in SPECTRUM_SUFFIXES:
        columns = read_columns(file, wavelength_unit=wavelength_unit, percent=percent)
        samples, names, remarks = columns.samples, columns.names, columns.remarks
        if len(names) == 1 and names[0].lower() in ("", "value", "values", "power", "spd", "reflectance", "intensity"):
            names = (remarks.get("name", ""),)
    elif suffix in (".yml", ".yaml"):
        raise fail(file, None, "holds optical constants (n and k) and not a spectrum; use it for a metal")
    else:
        raise fail(file, None, f"the suffix {suffix!r} is none of {', '.join(SPECTRUM_SUFFIXES)}")

    samples = ordered(file, samples)
    wavelengths = np.array([sample.wavelength_nm for sample in samples])
    values = np.array([sample.values for sample in samples]).T
    if negative == "refuse" and values.min() < 0.0:
        worst = next(sample for sample in samples if min(sample.values) < 0.0)
        raise fail(
            file,
            worst.line,
            f"values must not be negative, but at {worst.wavelength_nm:g} nm one is {min(worst.values):g} "
            "(the option negative can set them to zero)",
        )
    if negative == "zero":
        values = np.maximum(values, 0.0)
    remark = remarks.get("interpolation", "linear")
    chosen = interpolation or (remark if remark in ("linear", "lagrange") else "linear")
    return tuple(
        Spectrum(wavelengths, column, name or file.stem, chosen, signed=bool(column.min() < 0.0))
        for name, column in zip(names, values, strict=True)
    )


def read_spectrum(
    path: str | Path,
    column: int | str = 0,
    *,
    unit: str = "auto",
    wavelength_unit: str | None = None,
    negative: str = "refuse",
    interpolation: str | None = None,
) -> Spectrum:
    """Read one spectrum from a file.

    Parameters
    ----------
    path : str or Path
        A file with one of :data:`SPECTRUM_SUFFIXES`.
    column : int or str
        Which value column, by its place from 0 or by its name.
    unit, wavelength_unit, negative, interpolation
        As in :func:`read_spectra`.

    Returns
    -------
    Spectrum
        The spectrum, named by the column's header or by the file.

    Raises
    ------
    SpectrumFileError
        If the file is missing or broken, or has no such column; the message tells file, line and reason.
    InvalidParameterError
        If an option is none of its choices.

    References
    ----------
    As :func:`read_spectra`.
    """
    spectra = read_spectra(
        path, unit=unit, wavelength_unit=wavelength_unit, negative=negative, interpolation=interpolation
    )
    if isinstance(column, str):
        for spectrum in spectra:
            if spectrum.name == column:
                return spectrum
        known = ", ".join(spectrum.name for spectrum in spectra)
        raise SpectrumFileError(f"{Path(path).name}: has no column {column!r}; its columns are {known}")
    if not 0 <= column < len(spectra):
        raise SpectrumFileError(
            f"{Path(path).name}: has {len(spectra)} value columns, but number {column} was asked for"
        )
    return spectra[column]
