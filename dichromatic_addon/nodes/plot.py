"""A small picture of a spectrum, for nodes and panels: its curve from 380 to 780 nm over the colours of the light."""

from __future__ import annotations

from typing import Any

import bpy.utils.previews
import numpy as np
from numpy.typing import NDArray

from .._core import core

__all__ = ["draw_plot", "plot_pixels", "register", "unregister"]

SIZE = 128  # pixels; plots that are not square are letterboxed by Blender
MOST_PLOTS = 256  # kept at a time; a plot is 64 kB
SHORTEST_NM, LONGEST_NM = 380.0, 780.0
BACKGROUND = (0.03, 0.03, 0.03)
GRID = (0.12, 0.12, 0.12)
LINE = (0.9, 0.9, 0.9)

_plots: Any = None  # the preview collection, while the add-on is registered


def plot_pixels(spectrum: core.Spectrum) -> NDArray[np.float32]:
    """Draw a spectrum.

    Parameters
    ----------
    spectrum : Spectrum
        Values from 0 to 1 fill the height; where they go beyond, the largest one does.

    Returns
    -------
    ndarray of float32, shape (128, 128, 4)
        RGBA, the lowest row first, as Blender has it.
    """
    wavelengths = np.linspace(SHORTEST_NM, LONGEST_NM, SIZE)
    values = np.maximum(spectrum.at(wavelengths), 0.0)
    top = max(1.0, float(values.max()))
    height = values / top * (SIZE - 2)
    pixels = np.empty((SIZE, SIZE, 4), np.float32)
    pixels[:] = (*BACKGROUND, 1.0)
    for nanometres in (400.0, 500.0, 600.0, 700.0):
        pixels[:, int((nanometres - SHORTEST_NM) / (LONGEST_NM - SHORTEST_NM) * (SIZE - 1)), :3] = GRID
    rows = np.arange(SIZE)[:, None]
    below = rows <= height
    pixels[..., :3] = np.where(below[..., None], 0.75 * _light_colours(wavelengths), pixels[..., :3])
    before = np.concatenate([height[:1], height[:-1]])
    low, high = np.minimum(before, height), np.maximum(before, height)
    on_curve = (rows >= np.floor(low)) & (rows <= np.ceil(high) + 1.0)
    pixels[on_curve, :3] = LINE
    return pixels


def _light_colours(wavelengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Approximate display colours (W, 3) of monochromatic light, brought into the gamut and dimmed at the ends."""
    seen = core.observer("cie_1931_2")
    xyz = np.stack([np.interp(wavelengths, seen.wavelengths_nm, curve) for curve in seen.matching_functions.T], axis=-1)
    rgb = np.maximum(core.display("srgb").linear(xyz), 0.0)
    brightest = rgb.max(axis=-1, keepdims=True)
    bright = rgb / np.maximum(brightest, 1e-12) * np.minimum(1.0, np.sqrt(np.maximum(brightest, 0.0) * 4.0))
    return np.asarray(core.display("srgb").encode(bright))


def draw_plot(layout: Any, spectrum: core.Spectrum) -> None:
    """Put the picture of a spectrum into a layout; each is drawn once and kept."""
    key = spectrum.key.hex()
    if key not in _plots:
        if len(_plots) >= MOST_PLOTS:
            _plots.clear()
        preview = _plots.new(key)
        preview.image_size = (SIZE, SIZE)
        preview.image_pixels_float.foreach_set(plot_pixels(spectrum).ravel())
    layout.template_icon(_plots[key].icon_id, scale=5.0)


def register() -> None:
    """Make room for the pictures."""
    global _plots
    _plots = bpy.utils.previews.new()


def unregister() -> None:
    """Give the pictures back."""
    global _plots
    bpy.utils.previews.remove(_plots)
    _plots = None
