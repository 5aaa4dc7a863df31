"""Plots of spectra as arrays of pixels, drawn with numpy alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bitmap_font import draw_text, text_width

__all__ = ["PLOT_SIZE", "plot_spectra"]

PLOT_SIZE = (960, 540)  # width, height
_PAPER = (0.97, 0.97, 0.97)
_INK = (0.1, 0.1, 0.1)
_LINE = (0.84, 0.84, 0.84)
_MOST_CURVES = 7
_COLOURS = (
    (0.84, 0.15, 0.16),
    (0.12, 0.47, 0.71),
    (0.17, 0.63, 0.17),
    (1.00, 0.50, 0.05),
    (0.58, 0.40, 0.74),
    (0.55, 0.34, 0.29),
    (0.09, 0.75, 0.81),
)
_LEFT, _RIGHT, _TOP, _BOTTOM = 96, 24, 48, 64  # margins


def plot_spectra(
    wavelengths_nm: NDArray[np.floating[Any]],
    parts: NDArray[np.floating[Any]],
    labels: tuple[str, ...],
    title: str,
) -> NDArray[np.float64]:
    """Draw spectra and their sum against the wavelength.

    Parameters
    ----------
    wavelengths_nm : ndarray, shape (W,)
        Increasing, at least two (nm).
    parts : ndarray, shape (K, W)
        The spectra; the strongest seven get a curve and a line in the legend, the rest share one.
    labels : tuple of str, length K
        Their names.
    title : str
        Written above.

    Returns
    -------
    ndarray of float64, shape (H, W, 3)
        Display values, row 0 at the top; the size is PLOT_SIZE.
    """
    width, height = PLOT_SIZE
    picture = np.empty((height, width, 3))
    picture[:] = _PAPER
    total = parts.sum(axis=0)
    curves = _curves(parts, labels)
    low = min(0.0, *(float(values.min()) for values, _ in [*curves, (total, "")]))
    high = max(0.0, *(float(values.max()) for values, _ in [*curves, (total, "")]))
    step = _step(high - low)
    low, high = step * math.floor(low / step), step * max(1, math.ceil(high / step))
    span = float(wavelengths_nm[0]), float(wavelengths_nm[-1])

    def column(wavelength: float) -> int:
        return _LEFT + round((wavelength - span[0]) / (span[1] - span[0]) * (width - _LEFT - _RIGHT - 1))

    def row(value: Any) -> Any:
        return _TOP + np.rint((high - value) / (high - low) * (height - _TOP - _BOTTOM - 1)).astype(int)

    for number in range(round((high - low) / step) + 1):
        value = low + number * step
        at = int(row(np.float64(value)))
        picture[at, _LEFT : width - _RIGHT] = _LINE
        text = f"{value:.4g}"
        draw_text(picture, text, _LEFT - 10 - text_width(text), at - 7, _INK)
    for wavelength in range(50 * math.ceil(span[0] / 50.0), math.floor(span[1]) + 1, 50):
        at = column(wavelength)
        picture[_TOP : height - _BOTTOM, at] = _LINE
        text = str(wavelength)
        draw_text(picture, text, at - text_width(text) // 2, height - _BOTTOM + 10, _INK)
    picture[int(row(np.float64(0.0))), _LEFT : width - _RIGHT] = _INK
    picture[_TOP : height - _BOTTOM, _LEFT] = _INK
    draw_text(picture, title, _LEFT, 18, _INK)
    axis = "wavelength (nm)"
    draw_text(picture, axis, (_LEFT + width - _RIGHT - text_width(axis)) // 2, height - 26, _INK)

    columns = np.arange(_LEFT, width - _RIGHT)
    sampled = np.interp(columns, [_LEFT, width - _RIGHT - 1], span)
    for index, (values, _) in enumerate(curves):
        _draw_curve(picture, columns, row(np.interp(sampled, wavelengths_nm, values)), _COLOURS[index % len(_COLOURS)])
    _draw_curve(picture, columns, row(np.interp(sampled, wavelengths_nm, total)), _INK)
    _draw_legend(picture, [(_INK, "total"), *zip(_COLOURS, (label for _, label in curves), strict=False)])
    return picture


def _curves(parts: NDArray[np.floating[Any]], labels: tuple[str, ...]) -> list[tuple[NDArray[np.floating[Any]], str]]:
    order = np.argsort(-np.abs(parts).sum(axis=1), kind="stable")
    if len(order) <= _MOST_CURVES:
        return [(parts[k], labels[k]) for k in order]
    first, rest = order[: _MOST_CURVES - 1], order[_MOST_CURVES - 1 :]
    return [*((parts[k], labels[k]) for k in first), (parts[rest].sum(axis=0), f"{len(rest)} others")]


def _step(extent: float) -> float:
    """Return a round distance (1, 2 or 5 times a power of ten) that divides an extent into four to ten parts."""
    if not extent > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(extent / 4.0))
    return next(factor * power for factor in (5.0, 2.0, 1.0) if factor * power <= extent / 4.0 or factor == 1.0)


def _draw_curve(
    picture: NDArray[np.float64], columns: NDArray[np.int64], rows: NDArray[np.int64], colour: tuple[float, ...]
) -> None:
    """Join the points by vertical runs of pixels, two pixels thick."""
    for at, first, last in zip(columns[1:], rows[:-1], rows[1:], strict=True):
        top, bottom = (first, last) if first < last else (last, first)
        picture[top : bottom + 2, at] = colour


def _draw_legend(picture: NDArray[np.float64], entries: list[tuple[tuple[float, ...], str]]) -> None:
    longest = (picture.shape[1] - _LEFT - _RIGHT) // 2 // 12 - 4
    texts = [(colour, text if len(text) <= longest else f"{text[: longest - 2]}..") for colour, text in entries]
    width = max(text_width(text) for _, text in texts) + 44
    left, top = picture.shape[1] - _RIGHT - width - 8, _TOP + 8
    box = picture[top : top + 22 * len(texts) + 8, left : left + width]
    box[:] = 0.25 * box + 0.75 * np.array(_PAPER)  # what lies below stays to be seen
    for number, (colour, text) in enumerate(texts):
        line = top + 8 + 22 * number
        picture[line + 5 : line + 9, left + 8 : left + 28] = colour
        draw_text(picture, text, left + 36, line, _INK)
