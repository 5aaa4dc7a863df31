"""Spectra in columns: CSV, TSV, SPD and whatever else puts a wavelength and its values on a line.

Comments start with ``#``, ``//`` or ``!``. The delimiter (tab, semicolon, comma or blanks) and the decimal mark (point,
or comma where it is not the delimiter) are found from the first line that holds numbers; the line before it, if it
is no comment, is the header. Wavelengths are in nm unless the header says um or angstrom; values are as they stand,
unless the header says percent.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ._text import Sample, fail, number, read_text, wavelength_factor

__all__ = ["Columns", "read_columns"]

_COMMENT = re.compile(r"\s*(#|//|!)")
_LAYOUTS = (("\t", False), ("\t", True), (";", False), (";", True), (",", False), (None, False), (None, True))
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?$")


@dataclass(frozen=True, slots=True)
class Columns:
    """The content of a file in columns.

    Parameters
    ----------
    samples : list of Sample
        Lines in file order, wavelengths in nm, percent already divided.
    names : tuple of str
        Names of the value columns; empty strings where the header is absent.
    remarks : dict of str to str
        ``key: value`` pairs found in comments, keys in lower case.
    """

    samples: list[Sample]
    names: tuple[str, ...]
    remarks: dict[str, str]


def _split(line: str, delimiter: str | None) -> list[str]:
    fields = [field.strip() for field in line.strip().split(delimiter)]
    while len(fields) > 1 and not fields[-1]:
        fields.pop()  # a trailing delimiter opens no column
    return fields


def _layout(line: str) -> tuple[str | None, bool] | None:
    """Find delimiter and decimal comma of a line of numbers, or None if it is no such line."""
    for delimiter, comma in _LAYOUTS:
        fields = _split(line, delimiter)
        plain = [field.strip('"').replace(",", ".") if comma else field.strip('"') for field in fields]
        if len(plain) >= 2 and all(_NUMBER.match(field) for field in plain):
            return delimiter, comma
    return None


def read_columns(path: Path, *, wavelength_unit: str | None = None, percent: bool | None = None) -> Columns:
    """Read a file in columns.

    Parameters
    ----------
    path : Path
        The file.
    wavelength_unit : str, optional
        "nm", "um" or "angstrom"; None asks the header, and takes nm where it is silent.
    percent : bool, optional
        Whether values are percent; None asks the header of each column, and takes them as they stand where it is
        silent.

    Returns
    -------
    Columns
        Samples, names and remarks.

    Raises
    ------
    SpectrumFileError
        If the file is no text, has no line of numbers, or a line is broken; with the line's number.

    References
    ----------
    Own design.
    """
    remarks: dict[str, str] = {}
    header: list[str] = []
    header_text = ""
    rows: list[tuple[int, list[str]]] = []
    layout: tuple[str | None, bool] | None = None
    first_line = 0
    for line_number, line in enumerate(read_text(path).splitlines(), start=1):
        if not line.strip():
            continue
        if _COMMENT.match(line):
            key, colon, value = line.strip().lstrip("#/! ").partition(":")
            if colon:
                remarks.setdefault(key.strip().lower(), value.strip())
            continue
        if layout is None:
            layout = _layout(line)
            if layout is None:
                header_text = line
                continue
            first_line = line_number
            header = [field.strip('"') for field in _split(header_text, layout[0])] if header_text else []
        fields = _split(line, layout[0])
        if rows and len(fields) != len(rows[0][1]):
            raise fail(path, line_number, _uneven(len(fields), len(rows[0][1]), first_line))
        rows.append((line_number, fields))
    if layout is None:
        raise fail(
            path,
            None,
            "holds no line with a wavelength and a value; each line must hold a wavelength and what was measured there",
        )

    width = len(rows[0][1])
    titles = header if len(header) == width else [""] * width
    factor = _unit_factor(path, wavelength_unit, titles[0] or header_text)
    shares = ["0.01" if (_says_percent(title) if percent is None else percent) else "1" for title in titles[1:]]
    samples = [
        Sample(
            number(path, line, fields[0], "wavelength", comma=layout[1], factor=factor),
            tuple(
                number(path, line, field, "value", comma=layout[1], factor=share)
                for field, share in zip(fields[1:], shares, strict=True)
            ),
            line,
        )
        for line, fields in rows
    ]
    longest = max(samples, key=lambda sample: sample.wavelength_nm)
    if 0.0 < longest.wavelength_nm < 20.0 and wavelength_unit is None:
        raise fail(
            path,
            longest.line,
            f"the longest wavelength is {longest.wavelength_nm:g} nm; if it is meant in micrometres, "
            "the header or the wavelength unit must say um",
        )
    return Columns(samples, tuple(_column_name(title) for title in titles[1:]), remarks)


def _uneven(count: int, expected: int, first_line: int) -> str:
    """Tell what is wrong with a line whose columns are not as many as the first one's."""
    columns = f"{count} column" if count == 1 else f"{count} columns"
    reason = f"has {columns}, but line {first_line} has {expected}"
    return f"{reason}; a value is missing: give it, or leave the line out" if count < expected else reason


def _unit_factor(path: Path, unit: str | None, title: str) -> str:
    if unit is not None:
        factor = wavelength_factor(unit)
        if factor is None:
            raise fail(path, None, f"the wavelength unit must be nm, um or angstrom, but is {unit!r}")
        return factor
    for word in re.split(r"[\s,;()\[\]/_]+", title):
        factor = wavelength_factor(word)
        if factor is not None:
            return factor
    return "1"


def _says_percent(title: str) -> bool:
    return "%" in title or "percent" in title.lower()


def _column_name(title: str) -> str:
    """Strip the unit from a column's title: ``R (%)`` is called R."""
    title = title[:200]
    bare = re.sub(r"\(\s*(%|percent)\s*\)|\[\s*(%|percent)\s*\]|[_\s]*(%|percent)\s*$", "", title, flags=re.IGNORECASE)
    return bare.strip()
