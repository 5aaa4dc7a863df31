"""Reading and writing measured data sets as text tables (CSV, TSV, semicolons).

Two layouts, told apart by the first line that is not a comment; ``docs/fitting.md`` shows both:

* **wide**: rows are wavelengths, columns are spectra; lines that begin with a key word (``incidence``, ``viewing``,
  ``azimuth``, ``rotation``, ``label``, ``reference``, ``unit``) stand before the first wavelength;
* **long**: a heading ``wavelength_nm, incidence_deg, viewing_deg, ..., value`` and one line a value.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..atomic_files import replacing
from ..errors import DichromaticError, SpectrumFileError
from .measurements import REFERENCES, MeasurementGeometry, Measurements

__all__ = ["read_measurements", "write_measurements"]

_ANGLES = ("incidence", "viewing", "azimuth", "rotation")
_TEXT_KEYS = ("label", "reference", "unit")
_UNITS = {"unit": 1.0, "percent": 0.01, "1": 1.0, "%": 0.01}


@dataclass(frozen=True, slots=True)
class _Line:
    number: int
    cells: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Source:
    """A file being read: its name for messages and its lines split into cells."""

    name: str
    lines: tuple[_Line, ...]
    decimal_comma: bool

    def fail(self, line: int, reason: str) -> SpectrumFileError:
        return SpectrumFileError(f"{self.name}, line {line}: {reason}")

    def number(self, line: _Line, column: int, what: str) -> float:
        text = line.cells[column]
        try:
            value = float(text.replace(",", ".") if self.decimal_comma else text)
        except ValueError:
            raise self.fail(line.number, f"{what} in column {column + 1} must be a number, but is {text!r}") from None
        if not np.isfinite(value):
            raise self.fail(line.number, f"{what} in column {column + 1} must be finite, but is {text!r}")
        return value


def _split(path: Path) -> _Source:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SpectrumFileError(f"{path}: there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SpectrumFileError(f"{path}: cannot be read as text ({error})") from error
    kept = [
        (number, line.strip())
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not kept:
        raise SpectrumFileError(f"{path}: holds no data")
    first = kept[0][1]
    separator = next((s for s in ("\t", ";", ",") if s in first), None)
    lines = tuple(_Line(number, tuple(c.strip() for c in line.split(separator))) for number, line in kept)
    return _Source(path.name, lines, decimal_comma=separator == ";")


def _key(cell: str) -> str:
    """``Incidence (deg)``, ``incidence_deg`` and ``incidence`` are one key."""
    word = cell.lower().replace("(", " ").replace("[", " ").split(maxsplit=1)[0] if cell else ""
    return word.removesuffix("_deg").removesuffix("_nm").rstrip(":")


def _geometry(columns: dict[str, NDArray[np.float64]]) -> MeasurementGeometry | None:
    if not columns:
        return None
    return MeasurementGeometry.from_degrees(
        columns["incidence"], columns["viewing"], columns.get("azimuth"), columns.get("rotation")
    )


def _setting(source: _Source, line: _Line, key: str) -> str:
    words = {cell for cell in line.cells[1:] if cell}
    if len(words) != 1:
        raise source.fail(line.number, f"{key} must be followed by one word, but by {len(words)}")
    return words.pop().lower()


def _reference(source: _Source, line: _Line) -> str:
    reference = _setting(source, line, "reference")
    if reference not in REFERENCES:
        raise source.fail(line.number, f"reference must be one of {', '.join(REFERENCES)}, but is {reference!r}")
    return reference


def _unit(source: _Source, line: _Line) -> float:
    unit = _setting(source, line, "unit")
    if unit not in _UNITS:
        raise source.fail(line.number, f"unit must be one of unit, percent, but is {unit!r}")
    return _UNITS[unit]


def _read_wide(source: _Source, reference: str | None, name: str) -> Measurements:
    angles: dict[str, NDArray[np.float64]] = {}
    labels: tuple[str, ...] = ()
    scale = 1.0
    rows: list[list[float]] = []
    count = 0
    for line in source.lines:
        key = _key(line.cells[0])
        if key in ("reference", "unit"):
            if key == "unit":
                scale = _unit(source, line)
            else:
                reference = reference or _reference(source, line)
            continue
        if rows and key in (*_ANGLES, *_TEXT_KEYS):
            raise source.fail(line.number, f"{key} must stand before the first wavelength")
        if len(line.cells) < 2:
            raise source.fail(line.number, "a line must hold a key or wavelength and at least one column")
        count = count or len(line.cells) - 1
        if len(line.cells) - 1 != count:
            raise source.fail(
                line.number, f"there must be {count} columns of data, but there are {len(line.cells) - 1}"
            )
        if key in _ANGLES:
            if key in angles:
                raise source.fail(line.number, f"{key} is stated twice")
            angles[key] = np.array([source.number(line, c + 1, key) for c in range(count)])
        elif key in ("label", "wavelength"):
            labels = line.cells[1:]
        else:
            wavelength = source.number(line, 0, "wavelength")
            if rows and wavelength <= rows[-1][0]:
                raise source.fail(
                    line.number, f"wavelengths must increase, but {wavelength:g} nm follows {rows[-1][0]:g} nm"
                )
            rows.append([wavelength, *(source.number(line, c + 1, "value") for c in range(count))])
    missing = [key for key in ("incidence", "viewing") if key not in angles]
    if angles and missing:
        raise SpectrumFileError(f"{source.name}: states {', '.join(angles)} but not {' and '.join(missing)}")
    if not rows:
        raise SpectrumFileError(f"{source.name}: holds no line that begins with a wavelength")
    table = np.array(rows)
    return Measurements(table[:, 0], table[:, 1:].T * scale, _geometry(angles), reference or "diffuser", name, labels)


def _read_long(source: _Source, reference: str | None, name: str) -> Measurements:
    scale = 1.0
    lines = list(source.lines)
    while _key(lines[0].cells[0]) in ("reference", "unit"):
        line = lines.pop(0)
        if _key(line.cells[0]) == "unit":
            scale = _unit(source, line)
        else:
            reference = reference or _reference(source, line)
    heading, *body = lines
    keys = [_key(cell) for cell in heading.cells]
    unknown = [
        cell for cell, key in zip(heading.cells, keys, strict=True) if key not in ("wavelength", "value", *_ANGLES)
    ]
    if unknown:
        raise source.fail(heading.number, f"the heading has an unknown column {unknown[0]!r}")
    for key in ("wavelength", "incidence", "viewing", "value"):
        if keys.count(key) != 1:
            raise source.fail(heading.number, f"the heading must name the column {key} once, but has {keys.count(key)}")
    named = [key for key in _ANGLES if key in keys]
    spectra: dict[tuple[float, ...], dict[float, float]] = {}
    for line in body:
        if len(line.cells) != len(keys):
            raise source.fail(line.number, f"there must be {len(keys)} cells, but there are {len(line.cells)}")
        cells = {key: source.number(line, column, key) for column, key in enumerate(keys)}
        spectrum = spectra.setdefault(tuple(cells[key] for key in named), {})
        if cells["wavelength"] in spectrum:
            raise source.fail(line.number, f"this geometry has two values at {cells['wavelength']:g} nm")
        spectrum[cells["wavelength"]] = cells["value"]
    if not spectra:
        raise SpectrumFileError(f"{source.name}: holds no line of data")
    wavelengths = sorted(next(iter(spectra.values())))
    for geometry, spectrum in spectra.items():
        if sorted(spectrum) != wavelengths:
            angles = ", ".join(f"{key} {value:g}" for key, value in zip(named, geometry, strict=True))
            raise SpectrumFileError(
                f"{source.name}: all spectra must share their wavelengths, but the one at {angles} has {len(spectrum)} "
                f"from {min(spectrum):g} nm and the first has {len(wavelengths)} from {wavelengths[0]:g} nm"
            )
    values = np.array([[spectrum[w] for w in wavelengths] for spectrum in spectra.values()]) * scale
    columns = {key: np.array([g[i] for g in spectra]) for i, key in enumerate(named)}
    return Measurements(np.array(wavelengths), values, _geometry(columns), reference or "diffuser", name)


def read_measurements(path: str | os.PathLike[str], reference: str | None = None) -> Measurements:
    """Read measured spectra at several geometries from a text table.

    Parameters
    ----------
    path : path-like
        A file in the wide or the long layout of this module: separated by tabs, semicolons (then with decimal commas
        or points), commas, or blanks; ``#`` begins a comment line; angles in degrees; wavelengths in nm.
    reference : {"diffuser", "beam"}, optional
        What the values are relative to; None takes the file's ``reference`` line, and "diffuser" when there is none.

    Returns
    -------
    Measurements
        The data set, named after the file, values as fractions of 1.

    Raises
    ------
    SpectrumFileError
        If the file cannot be read, a cell is not a finite number, a line has too few or too many cells, wavelengths
        do not increase or differ between spectra, or angles are incomplete; the message names file, line and reason.

    References
    ----------
    Own design; the layout is described in docs/fitting.md.
    """
    file = Path(path)
    source = _split(file)
    data = [line for line in source.lines if _key(line.cells[0]) not in ("reference", "unit")]
    is_long = bool(data) and "value" in [_key(cell) for cell in data[0].cells]
    reader: Callable[[_Source, str | None, str], Measurements] = _read_long if is_long else _read_wide
    try:
        return reader(source, reference, file.stem)
    except SpectrumFileError:
        raise
    except DichromaticError as error:
        raise SpectrumFileError(f"{source.name}: {error}") from error


def write_measurements(path: str | os.PathLike[str], measurements: Measurements, comment: str = "") -> None:
    """Write measured spectra in the wide layout.

    Parameters
    ----------
    path : path-like
        The file; it is replaced only when everything has been written.
    measurements : Measurements
        The data set.
    comment : str, optional
        Lines to stand first, each behind a ``#``.

    Raises
    ------
    DichromaticError
        If the file cannot be written.

    References
    ----------
    Own design; the layout is described in docs/fitting.md.
    """
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines.append(f"reference,{measurements.reference}")
    if measurements.geometry is not None:
        for key in _ANGLES:
            angles = np.degrees(getattr(measurements.geometry, key))
            lines.append(",".join([f"{key}_deg", *(f"{round(a, 9):.12g}" for a in angles)]))
    if measurements.labels:
        lines.append(",".join(["label", *(label.replace(",", " ") for label in measurements.labels)]))
    for wavelength, values in zip(measurements.wavelengths_nm, measurements.reflectances.T, strict=True):
        lines.append(",".join([f"{wavelength:.12g}", *(repr(float(value)) for value in values)]))
    write_text_atomically(path, "\n".join(lines) + "\n")


def write_text_atomically(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file beside its place and move it there, so that no half-written file is ever seen."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
