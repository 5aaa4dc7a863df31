"""The Image Editor's view: a picture shown whole, where neither sidebar nor tools lie over the window."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy

__all__ = ["free_span", "show_whole", "whole_view"]

_MARGIN = 8  # pixels of the window around a picture that is made smaller


def free_span(window: Any, regions: Iterable[Any]) -> tuple[int, int]:
    """Return the part of a window's width that no sidebar or toolbar lies over.

    Parameters
    ----------
    window : bpy.types.Region
        The region of the type WINDOW.
    regions : iterable of bpy.types.Region
        All regions of its area.

    Returns
    -------
    tuple of (int, int)
        First pixel, and the one after the last, counted from the window's left.
    """
    left, right = 0, window.width
    for region in regions:
        if region.type not in ("UI", "TOOLS") or region.width <= 1:  # one that is hidden is 1 wide
            continue
        first = region.x - window.x
        if first <= 0:
            left = max(left, first + region.width)
        else:
            right = min(right, first)
    return (left, right) if right - left > 2 * _MARGIN else (0, window.width)


def whole_view(
    size: tuple[int, int], height: int, width: int, span: tuple[int, int]
) -> tuple[float, tuple[float, float]]:
    """Return the zoom and the pan that show a picture whole in the free part of a window.

    Parameters
    ----------
    size : tuple of (int, int)
        Of the picture, in its own pixels.
    height, width : int
        Of the window.
    span : tuple of (int, int)
        What is free of its width.

    Returns
    -------
    tuple of (float, tuple of (float, float))
        Window pixels a picture pixel, at most 1, and how far the view moves from the picture's middle, in its pixels.
    """
    room = span[1] - span[0] - 2 * _MARGIN, height - 2 * _MARGIN
    zoom = min(1.0, *(max(free, 1) / max(length, 1) for free, length in zip(room, size, strict=True)))
    return zoom, (0.5 * (width - span[0] - span[1]) / zoom, 0.0)


def show_whole(area: Any, image: Any) -> None:
    """Show the whole of the image that an Image Editor has, where nothing lies over it."""
    window = next(region for region in area.regions if region.type == "WINDOW")
    zoom, pan = whole_view(tuple(image.size), window.height, window.width, free_span(window, area.regions))
    with bpy.context.temp_override(area=area, region=window):
        bpy.ops.image.view_all()  # to the picture's middle
        bpy.ops.image.view_zoom_ratio(ratio=zoom)
        bpy.ops.image.view_pan(offset=pan)
