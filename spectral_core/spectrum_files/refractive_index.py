"""Optical constants in the YAML layout of the refractiveindex.info database.

Exactly that layout is read, without a YAML library: top-level keys, block texts, and under DATA a list of tables.
Wavelengths there are in micrometres.
"""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np

from ..optical_constants import OpticalConstants
from ._text import Sample, fail, number, ordered, read_text
from .delimited import read_columns

__all__ = ["read_optical_constants"]

_KEY = re.compile(r"([A-Za-z_]+):\s*(.*)$")
_TYPE = re.compile(r"\s*-\s*type:\s*(.+?)\s*$")
_COLUMNS = {"tabulated nk": ("n", "k"), "tabulated n": ("n",), "tabulated k": ("k",)}


def read_optical_constants(path: str | Path, name: str = "") -> OpticalConstants:
    """Read n and k from a refractiveindex.info YAML file or from a table with the columns wavelength, n, k.

    Parameters
    ----------
    path : str or Path
        ``.yml`` or ``.yaml`` in the database's layout; anything else is read as columns (wavelengths in nm unless the
        header says um).
    name : str, optional
        Name of the material; by default the file's.

    Returns
    -------
    OpticalConstants
        Wavelengths in nm, n, k (0 where the file tabulates n only), source and comment. Where the database repeats a
        wavelength (rounded to the same digits), the rows are averaged.

    Raises
    ------
    SpectrumFileError
        If the file cannot be read, holds formulas instead of tables, or a line is broken; with the line's number.

    References
    ----------
    Polyanskiy, Refractiveindex.info database of optical constants, Sci. Data 11, 2024.
    """
    file = Path(path)
    label = name or file.stem
    if file.suffix.lower() not in (".yml", ".yaml"):
        columns = read_columns(file)
        rows = ordered(file, columns.samples)
        if len(rows[0].values) != 2:
            raise fail(file, rows[0].line, f"must have the columns wavelength, n, k, but has {1 + len(rows[0].values)}")
        _refuse_bad_index(file, rows, 0, "n")
        _refuse_bad_index(file, rows, 1, "k")
        n, k = (np.array([row.values[i] for row in rows]) for i in (0, 1))
        return OpticalConstants(
            np.array([row.wavelength_nm for row in rows]), n, k, label, columns.remarks.get("source", "")
        )

    texts, tables = _parse(file)
    if not tables:
        raise fail(file, None, "holds no tabulated n or k under DATA")
    curves: dict[str, list[Sample]] = {}
    for kinds, raw in tables:
        rows = ordered(file, _merged(raw))
        for column, kind in enumerate(kinds):
            if kind in curves:
                raise fail(file, raw[0].line, f"tabulates {kind} a second time")
            _refuse_bad_index(file, rows, column, kind)
            curves[kind] = [Sample(row.wavelength_nm, (row.values[column],), row.line) for row in rows]
    if "n" not in curves:
        raise fail(file, None, "tabulates k but not n")
    wavelengths = np.array([row.wavelength_nm for row in curves["n"]])
    n = np.array([row.values[0] for row in curves["n"]])
    k = np.zeros_like(n)
    if "k" in curves:
        k_wavelengths = np.array([row.wavelength_nm for row in curves["k"]])
        k_values = np.array([row.values[0] for row in curves["k"]])
        if k_wavelengths[0] > wavelengths[-1] or k_wavelengths[-1] < wavelengths[0]:
            raise fail(file, None, "tabulates n and k over ranges that do not meet")
        k = np.interp(wavelengths, k_wavelengths, k_values)
    return OpticalConstants(wavelengths, n, k, label, texts.get("REFERENCES", ""), texts.get("COMMENTS", ""))


def _merged(rows: list[Sample]) -> list[Sample]:
    """Average neighbouring rows of one wavelength, as the database has where wavelengths were rounded."""
    merged: list[Sample] = []
    for _, group in itertools.groupby(rows, key=lambda row: row.wavelength_nm):
        same = list(group)
        means = tuple(sum(column) / len(same) for column in zip(*(row.values for row in same), strict=True))
        merged.append(Sample(same[0].wavelength_nm, means, same[0].line))
    return merged


def _refuse_bad_index(path: Path, rows: list[Sample], column: int, kind: str) -> None:
    for row in rows:
        value = row.values[column]
        if value < 0.0 or (kind == "n" and value == 0.0):
            rule = "positive" if kind == "n" else "0 or more"
            raise fail(path, row.line, f"{kind} must be {rule}, but is {value:g}")


def _parse(path: Path) -> tuple[dict[str, str], list[tuple[tuple[str, ...], list[Sample]]]]:
    """Top-level texts, and the tables under DATA with the kinds of their columns."""
    texts: dict[str, str] = {}
    tables: list[tuple[tuple[str, ...], list[Sample]]] = []
    key = ""
    kinds: tuple[str, ...] | None = None
    in_rows = False
    for line_number, line in enumerate(read_text(path).splitlines(), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        top = _KEY.match(line)
        if top is not None:
            key, in_rows, kinds = top[1], False, None
            texts[key] = "" if top[2] in ("|", ">", "") else top[2]
            continue
        if key != "DATA":
            texts[key] = f"{texts.get(key, '')} {line.strip()}".strip()
            continue
        opened = _TYPE.match(line)
        if opened is not None:
            kind = opened[1].strip("\"'")
            if kind not in _COLUMNS:
                raise fail(path, line_number, f"data of the type {kind!r} are not read, only tabulated n, k and nk")
            kinds, in_rows = _COLUMNS[kind], False
            tables.append((kinds, []))
        elif kinds is not None and line.strip() in ("data: |", "data: >", "data: |-"):
            in_rows = True
        elif in_rows and kinds is not None:
            fields = line.split()
            if len(fields) != 1 + len(kinds):
                raise fail(path, line_number, f"has {len(fields)} numbers, but the table has {1 + len(kinds)} columns")
            values = tuple(
                number(path, line_number, field, what) for field, what in zip(fields[1:], kinds, strict=True)
            )
            wavelength = number(path, line_number, fields[0], "wavelength", factor="1000")
            tables[-1][1].append(Sample(wavelength, values, line_number))
        elif kinds is None:
            raise fail(path, line_number, "DATA must hold a list of tables, each beginning with '- type:'")
    empty = next((kinds for kinds, rows in tables if not rows), None)
    if empty is not None:
        raise fail(path, None, f"has an empty table of {' and '.join(empty)}")
    return texts, tables
