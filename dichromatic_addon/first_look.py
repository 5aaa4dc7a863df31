"""A coarse picture of a large render, shown before the first part of the real one is there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import core
from .camera_reading import Region

__all__ = ["enlarged", "first_look", "is_worth_it"]

_STEP = 8  # pixels on a side of one pixel of the coarse picture
_LEAST_RAYS = 1 << 22  # camera rays of the whole render; fewer are a few seconds, and need no coarse picture


def is_worth_it(settings: Any) -> bool:
    """Whether a render is so large that somebody would wait for its first part."""
    return bool(settings.width * settings.height * settings.samples >= _LEAST_RAYS)


def first_look(exported: Any, settings: Any, acceleration: Any, cancel: Callable[[], bool]) -> NDArray[np.float32]:
    """Render one ray for every 8 x 8 pixels.

    Parameters
    ----------
    exported : ExportedScene
        The scene.
    settings : RenderSettings
        Those of the real render.
    acceleration : Acceleration
        Of the scene's triangles; what is made for the coarse picture serves the real one.
    cancel : callable
        Asked often; a true answer ends it.

    Returns
    -------
    ndarray of float32, shape (ceil(H / 8), ceil(W / 8), 4)
        Scene linear, premultiplied; for :func:`enlarged`. Mirrors show one bounce.

    Raises
    ------
    RenderCancelledError
        If `cancel` said so.

    References
    ----------
    Own design.
    """
    width, height = -(-settings.width // _STEP), -(-settings.height // _STEP)
    # The last column and row may reach beyond the picture.
    frame = Region(settings.width, settings.height, 0, settings.height - height * _STEP, width * _STEP, height * _STEP)
    camera = exported.scene.camera
    scene = replace(exported.scene, camera=replace(camera, window=frame.crop(camera.window)))
    coarse = replace(
        settings,
        width=width,
        height=height,
        samples=1,
        pixel_filter="box",
        filter_width=1.0,
        max_bounces=min(settings.max_bounces, 1),
        adaptive_threshold=0.0,
        buffers=(),
        shadow_share=False,
        split_light=False,
        film_bytes=None,
    )
    render = core.render(scene, coarse, cancel=cancel, acceleration=acceleration)
    return exported.colour.rgba(  # type: ignore[no-any-return]
        render.tristimulus(), render.alpha if exported.is_transparent else None
    )


def enlarged(look: NDArray[np.float32], width: int, first: int, end: int) -> NDArray[np.float32]:
    """Fill the squares of a first look.

    Parameters
    ----------
    look : ndarray of float32, shape (h, w, 4)
        From :func:`first_look`.
    width : int
        Of the picture.
    first, end : int
        Rows of the picture that are wanted: the first, and the one behind the last.

    Returns
    -------
    ndarray of float32, shape (end - first, width, 4)
        Each ray's colour in all of its square.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    above = first // _STEP
    large = np.repeat(np.repeat(look[above : -(-end // _STEP)], _STEP, axis=0), _STEP, axis=1)
    return large[first - above * _STEP : end - above * _STEP, :width]
