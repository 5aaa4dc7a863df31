"""Spectra in JCAMP-DX, the exchange format of laboratory spectrometers, with its compressed forms of numbers."""

from __future__ import annotations

import re
from pathlib import Path

from ._text import Sample, fail, number, read_text, wavelength_factor

__all__ = ["read_jcamp"]

# Characters that open a number and carry its sign and first digit (JCAMP-DX 4.24, section 5.9).
_SQUEEZED = {c: str(i) for i, c in enumerate("@ABCDEFGHI")} | {c: f"-{i}" for i, c in enumerate("abcdefghi", 1)}
_DIFFERENCE = {c: str(i) for i, c in enumerate("%JKLMNOPQR")} | {c: f"-{i}" for i, c in enumerate("jklmnopqr", 1)}
_DUPLICATE = {c: str(i) for i, c in enumerate("STUVWXYZs", 1)}
_TOKEN = re.compile(
    r"\s*([@A-Ia-i%J-Rj-rS-Zs]\d{0,18}(?:\.\d+)?|[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:E[-+]\d+)?|\?)[ ,]*", re.ASCII
)
_UNUSABLE = ("ABSORBANCE", "KUBELKA", "LOG")


def read_jcamp(path: Path) -> tuple[list[Sample], str, bool]:
    """Read the first spectrum of a JCAMP-DX file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    samples : list of Sample
        One value each, wavelengths in nm (wave numbers are converted), in file order.
    title : str
        The title of the block.
    percent : bool
        Whether the unit of the values says percent; the samples hold them as they stand.

    Raises
    ------
    SpectrumFileError
        If a required label is missing, a unit is not understood, numbers are broken, the abscissa check or the
        ordinate check of a line fails, or the number of points is not the one announced; with the line's number.

    References
    ----------
    McDonald and Wilks, JCAMP-DX: A Standard Form for Exchange of Infrared Spectra in Computer Readable Form,
    Appl. Spectrosc. 42, 1988 (version 4.24).
    """
    labels: dict[str, tuple[str, int]] = {}
    data: list[tuple[int, str]] = []
    form = ""
    for line_number, raw in enumerate(read_text(path).splitlines(), start=1):
        line = raw.partition("$$")[0].rstrip()
        if line.lstrip().startswith("##"):
            label, equals, value = line.lstrip()[2:].partition("=")
            if not equals:
                raise fail(path, line_number, f"the label {label!r} has no equals sign")
            label = re.sub(r"[\s\-/_]", "", label).upper()
            if form:
                break  # the label after the data ends the block
            if label in ("XYDATA", "XYPOINTS", "PEAKTABLE"):
                form = value.strip().upper().replace(" ", "")
            elif label in ("NTUPLES", "DATATABLE"):
                raise fail(path, line_number, "NTUPLES data are not supported; export a single spectrum")
            labels[label] = (value.strip(), line_number)
        elif form and line.strip():
            data.append((line_number, line))
    if "TITLE" not in labels:
        raise fail(path, 1, "a JCAMP-DX file must begin with ##TITLE=")
    if not form:
        raise fail(path, None, "holds no ##XYDATA= or ##XYPOINTS=")

    x_factor, y_factor = _label_number(path, labels, "XFACTOR", 1.0), _label_number(path, labels, "YFACTOR", 1.0)
    if form.startswith("(X++(Y..Y)"):
        pairs = _spaced(path, labels, data, x_factor, y_factor)
    elif form.startswith("(XY..XY)"):
        pairs = _listed(path, data, x_factor, y_factor)
    else:
        raise fail(path, None, f"the form of the data must be (X++(Y..Y)) or (XY..XY), but is {form}")
    announced = _label_number(path, labels, "NPOINTS", float(len(pairs)))
    if announced != len(pairs):
        raise fail(path, labels["NPOINTS"][1], f"announces {announced:g} points, but the data hold {len(pairs)}")

    unit, unit_line = labels.get("YUNITS", ("", 0))
    if any(word in unit.upper() for word in _UNUSABLE):
        raise fail(path, unit_line, f"values in {unit} are not linear in light; export reflectance or transmittance")
    percent = "%" in unit or "PERCENT" in unit.upper()
    return _in_nanometres(path, labels, pairs), labels["TITLE"][0], percent


def _label_number(path: Path, labels: dict[str, tuple[str, int]], label: str, default: float | None) -> float:
    if label not in labels:
        if default is None:
            raise fail(path, None, f"the label ##{label}= is missing")
        return default
    value, line = labels[label]
    return number(path, line, value, f"label {label}")


def _in_nanometres(
    path: Path, labels: dict[str, tuple[str, int]], pairs: list[tuple[float, float, int]]
) -> list[Sample]:
    if "XUNITS" not in labels:
        raise fail(path, None, "the label ##XUNITS= is missing")
    unit, unit_line = labels["XUNITS"]
    if unit.upper().replace(" ", "") in ("1/CM", "CM-1", "CM^-1"):
        for x, _, line in pairs:
            if x <= 0.0:
                raise fail(path, line, f"wave numbers must be positive, but this is {x:g}")
        return [Sample(1.0e7 / x, (y,), line) for x, y, line in pairs]
    factor = wavelength_factor(unit)
    if factor is None:
        raise fail(path, unit_line, f"XUNITS must be nanometers, micrometers or 1/cm, but is {unit!r}")
    return [Sample(x * float(factor), (y,), line) for x, y, line in pairs]


def _listed(
    path: Path, data: list[tuple[int, str]], x_factor: float, y_factor: float
) -> list[tuple[float, float, int]]:
    pairs = []
    for line, text in data:
        numbers = re.split(r"[\s,;]+", text.strip().rstrip(";"))
        if len(numbers) % 2:
            raise fail(path, line, f"must hold pairs x, y, but holds {len(numbers)} numbers")
        for x, y in zip(numbers[::2], numbers[1::2], strict=True):
            pairs.append(
                (number(path, line, x, "abscissa") * x_factor, number(path, line, y, "ordinate") * y_factor, line)
            )
    return pairs


def _tokens(path: Path, line: int, text: str) -> list[str]:
    found, position = [], 0
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if match is None:
            raise fail(path, line, f"{text[position:].strip()!r} is not a number of the compressed form")
        found.append(match[1])
        position = match.end()
    return found


def _decompressed(path: Path, line: int, tokens: list[str], room: int) -> tuple[list[float], bool]:
    """Ordinates of one line, at most `room` of them, and whether it ends in the difference form."""
    values: list[float] = []
    step: float | None = None
    for token in tokens:
        head = token[0]
        if token == "?":
            raise fail(path, line, "has an invalid point (?), for which there is no value")
        if head in _DUPLICATE:
            if not values:
                raise fail(path, line, f"the repetition {token!r} follows no value")
            if "." in token:
                raise fail(path, line, f"the repetition {token!r} must be whole")
            count = int(_DUPLICATE[head] + token[1:]) - 1
            if count > room - len(values):
                raise fail(path, line, f"the repetition {token!r} makes more points than the file announces")
            base = values[-1]
            values.extend([base + (step or 0.0) * i for i in range(1, count + 1)])
        elif head in _DIFFERENCE:
            step = float(_DIFFERENCE[head] + token[1:])
            if not values:
                raise fail(path, line, f"the difference {token!r} follows no value")
            values.append(values[-1] + step)
        else:
            step = None
            values.append(number(path, line, _SQUEEZED[head] + token[1:] if head in _SQUEEZED else token, "ordinate"))
    return values, step is not None


def _spaced(
    path: Path, labels: dict[str, tuple[str, int]], data: list[tuple[int, str]], x_factor: float, y_factor: float
) -> list[tuple[float, float, int]]:
    first = _label_number(path, labels, "FIRSTX", None)
    last = _label_number(path, labels, "LASTX", None)
    points = int(_label_number(path, labels, "NPOINTS", None))
    if points < 1:
        raise fail(path, labels["NPOINTS"][1], f"must announce at least one point, but announces {points}")
    step = (last - first) / (points - 1) if points > 1 else 0.0
    ordinates: list[tuple[float, int]] = []
    in_differences = False
    for line, text in data:
        tokens = _tokens(path, line, text)
        abscissa = number(path, line, tokens[0], "abscissa") * x_factor
        values, ends_in_differences = _decompressed(path, line, tokens[1:], points - len(ordinates) + 1)
        if in_differences and values:
            # In the difference form a line repeats the last ordinate of the line before, as a check.
            if abs(values[0] - ordinates[-1][0]) > 0.5:
                raise fail(path, line, f"the ordinate check {values[0]:g} differs from {ordinates[-1][0]:g} before it")
            values = values[1:]
            expected = first + step * (len(ordinates) - 1)
            alternative = first + step * len(ordinates)
        else:
            expected = alternative = first + step * len(ordinates)
        if values and min(abs(abscissa - expected), abs(abscissa - alternative)) > abs(step):
            raise fail(
                path, line, f"the abscissa check {abscissa:g} differs from {expected:g}, where the line should be"
            )
        ordinates.extend((value, line) for value in values)
        in_differences = ends_in_differences
    return [(first + step * i, y * y_factor, line) for i, (y, line) in enumerate(ordinates)]
