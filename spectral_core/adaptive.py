"""Where more samples are worth it: where those taken so far do not agree."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import lab
from .display import SRGB_WHITE

__all__ = ["colour_distance", "pixels_that_differ"]

_BRIGHTEST = 8.0  # display whites; beyond, a difference is not seen


def colour_distance(one: NDArray[np.floating[Any]], other: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    """How different two estimates of the same colours look.

    Parameters
    ----------
    one, other : ndarray, shape (N, 3)
        X, Y, Z.

    Returns
    -------
    ndarray of float32, shape (N,)
        CIE 1976 colour difference against a D65 white of Y = 1, colours brighter than 8 whites counting as that.

    Raises
    ------
    ValueError
        From numpy if the shapes differ.

    References
    ----------
    CIE 15:2018, 8.2.1.
    """
    first, second = (lab(np.clip(colour, 0.0, _BRIGHTEST), SRGB_WHITE) for colour in (one, other))
    return np.asarray(np.linalg.norm(first - second, axis=-1), np.float32)


def pixels_that_differ(distance: NDArray[np.float32], height: int, width: int, threshold: float) -> NDArray[np.bool_]:
    """Choose the pixels that take more samples.

    Parameters
    ----------
    distance : ndarray of float32, shape (H * W,)
        Colour distance between the two halves of each pixel's samples.
    height, width : int
        Size of the picture.
    threshold : float
        The largest distance that is left alone.

    Returns
    -------
    ndarray of bool, shape (H * W,)
        True where the pixel or one of its eight neighbours is above it: an edge that crosses a corner may have missed
        all samples of a pixel.

    Raises
    ------
    ValueError
        From numpy if there are not H * W distances.

    References
    ----------
    Two halves as an estimate of the error: Dammertz et al., "A hierarchical automatic stopping condition for Monte
    Carlo global illumination", WSCG 2010.
    """
    far = distance.reshape(height, width) > threshold
    padded = np.pad(far, 1)
    near = np.zeros_like(far)
    for dy in range(3):
        for dx in range(3):
            near |= padded[dy : dy + height, dx : dx + width]
    return near.ravel()
