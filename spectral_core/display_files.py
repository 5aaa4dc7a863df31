"""A calibrated monitor from a CSV of measurements: primaries, white, and the light of each channel at drive values.

The file has two parts, in this order; comments start with ``#``:

    channel, X, Y, Z
    red,    41.2, 21.3,  1.9
    green,  35.8, 71.5, 11.9
    blue,   18.0,  7.2, 95.0
    white,  95.0, 100., 108.9
    drive,  red,  green, blue
    0,      0.12, 0.12,  0.12
    ...
    255,    21.5, 71.6,  7.3

X, Y, Z and the light of the channels may have any unit (cd/m2, or relative); the light at drive 0 is the black level
and is subtracted.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .display import Display
from .spectrum_files._text import fail, number, read_text

__all__ = ["read_display"]

_CHANNELS = ("red", "green", "blue", "white")
_ADDITIVITY = 0.25  # a monitor whose white is further than this from the sum of its primaries was measured wrongly


def read_display(path: str | Path, name: str = "") -> Display:
    """Read a calibrated monitor.

    Parameters
    ----------
    path : str or Path
        A CSV as described at the head of this module; at least two drive values, the first of them 0.
    name : str, optional
        Name of the display; by default the file's.

    Returns
    -------
    Display
        Its primaries scaled so that they add up to the measured white (a real monitor's miss it by a few percent),
        Y of the white at 1, and the measured light of each channel as a table from 0 to 1.

    Raises
    ------
    SpectrumFileError
        If the file cannot be read, a channel is missing, the light does not rise with the drive, or the primaries do
        not add up to the white within 25 %; with the line's number.

    References
    ----------
    Tominaga 1996, Applications; Berns, Methods for characterizing CRT displays, Displays 16, 1996.
    """
    file = Path(path)
    colours: dict[str, NDArray[np.float64]] = {}
    rows: list[tuple[int, list[float]]] = []
    in_drive = False
    for line, text in enumerate(read_text(file).splitlines(), start=1):
        fields = [field.strip().strip('"') for field in text.partition("#")[0].split(",")]
        head = fields[0].lower()
        if not any(fields):
            continue
        if head == "channel" and not in_drive:
            continue
        if head == "drive":
            if [field.lower() for field in fields[1:]] != ["red", "green", "blue"]:
                raise fail(file, line, "the columns after drive must be red, green, blue")
            in_drive = True
            continue
        if len(fields) != 4:
            raise fail(file, line, f"must have 4 columns, but has {len(fields)}")
        if in_drive:
            rows.append((line, [number(file, line, field, "value") for field in fields]))
        elif head not in _CHANNELS:
            raise fail(file, line, f"the channel must be red, green, blue or white, but is {fields[0]!r}")
        elif head in colours:
            raise fail(file, line, f"the channel {head} stands here a second time")
        else:
            xyz = np.array([number(file, line, field, f"{head} of XYZ") for field in fields[1:]])
            if np.any(xyz < 0.0) or xyz[1] <= 0.0:
                raise fail(file, line, f"XYZ of {head} must not be negative, and Y positive, but are {xyz.tolist()}")
            colours[head] = xyz
    missing = [channel for channel in _CHANNELS if channel not in colours]
    if missing:
        raise fail(file, None, f"has no row for {', '.join(missing)}")
    if len(rows) < 2:
        raise fail(file, None, "has no table of at least two drive values after a row 'drive, red, green, blue'")
    if rows[0][1][0] != 0.0:
        raise fail(file, rows[0][0], f"the first drive value must be 0, but is {rows[0][1][0]:g}")
    for (_, before), (line, after) in pairwise(rows):
        for label, low, high in zip(("drive", "red", "green", "blue"), before, after, strict=True):
            if not high > low:
                raise fail(file, line, f"{label} must increase strictly: {high:g} follows {low:g}")

    primaries = np.stack([colours[channel] for channel in _CHANNELS[:3]], axis=1)
    white = colours["white"]
    if not np.linalg.cond(primaries / primaries.sum(axis=0)) < 1.0e4:
        raise fail(file, None, "the three primaries do not span a triangle")
    shares = np.linalg.solve(primaries, white)
    if np.any(np.abs(shares - 1.0) > _ADDITIVITY):
        raise fail(
            file,
            None,
            f"the primaries must add up to the white within 25 %, but need the factors {np.round(shares, 3).tolist()}",
        )
    table = np.array([row for _, row in rows])
    light = table[:, 1:] - table[0, 1:]
    return Display(
        name or file.stem,
        primaries * shares / white[1],
        "table",
        table[:, 0] / table[-1, 0],
        light / light[-1],
    )
