"""Where within a pixel, a lens or a lamp the samples lie."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..validation import require_choice, require_in_range, require_integer

__all__ = ["PIXEL_FILTERS", "disk_points", "pixel_offsets", "polygon_points", "sobol_points", "square_points"]

PIXEL_FILTERS = ("box", "triangle", "gaussian", "blackman_harris")
"""Names of the pixel filters."""

Floats = NDArray[np.float64]

# Coefficients of the four-term window; F. J. Harris, Proc. IEEE 66(1), 51-83 (1978), table 1 (-92 dB).
_BLACKMAN_HARRIS = (0.35875, 0.48829, 0.14128, 0.01168)
# The gaussian's standard deviation in filter widths; it is cut where the width ends, at 3 of them.
_GAUSSIAN_SIGMA = 1.0 / 6.0


def square_points(samples: int, seed: int = 0) -> Floats:
    """Points spread evenly over the unit square.

    A rank-1 lattice with the golden ratio: every one of `samples` columns and, very nearly, rows holds one point. One
    sample is the centre, whatever the seed; the lattice of more is shifted by the seed.

    Parameters
    ----------
    samples : int
        How many, at least 1.
    seed : int, optional
        At least 0; equal seeds give equal points.

    Returns
    -------
    (S, 2) ndarray of float64
        Points in [0, 1).

    Raises
    ------
    InvalidParameterError
        If `samples` is below 1 or `seed` below 0.

    References
    ----------
    Lattice: Sloan and Joe, Lattice Methods for Multiple Integration (1994); shift: Cranley and Patterson, SIAM J.
    Numer. Anal. 13, 904 (1976).
    """
    samples, seed = require_integer("samples", samples, 1), require_integer("seed", seed, 0)
    if samples == 1:
        return np.full((1, 2), 0.5)
    index = np.arange(samples)
    points = np.stack([index / samples, index * (0.5 * (np.sqrt(5.0) - 1.0)) % 1.0], axis=1)
    return (points + np.random.default_rng(seed).random(2)) % 1.0


def _directions() -> NDArray[np.uint32]:
    """Direction numbers (3, 32) of Sobol's first three dimensions, from the recurrences of their polynomials."""
    numbers = np.zeros((3, 32), np.uint32)
    second, third = [1], [1, 3]  # of x + 1 and of x^2 + x + 1
    for k in range(32):
        if k >= 1:
            second.append(2 * second[k - 1] ^ second[k - 1])
        if k >= 2:
            third.append(2 * third[k - 1] ^ 4 * third[k - 2] ^ third[k - 2])
        shift = 31 - k
        numbers[:, k] = [1 << shift, second[k] << shift, third[k] << shift]
    return numbers


_SOBOL = _directions()


def sobol_points(index: NDArray[np.integer[Any]], scramble: NDArray[np.uint32]) -> Floats:
    """Points of Sobol's sequence in the unit cube.

    Any 2^m points whose indices agree above their lowest m bits lie one in each of 2^m boxes of equal size and of any
    shape that powers of two allow (in the first two coordinates): so do a pixel's few points, and those of a block
    of pixels together.

    Parameters
    ----------
    index : (...) ndarray of int
        Numbers of the points, from 0 to 2^32 - 1.
    scramble : (3,) ndarray of uint32
        Bits that are turned in each coordinate: another set of points that is as even.

    Returns
    -------
    (..., 3) ndarray of float64
        Points in [0, 1).

    Raises
    ------
    None.

    References
    ----------
    Sobol, USSR Comput. Math. Math. Phys. 7(4), 86-112 (1967); direction numbers of Joe and Kuo, SIAM J. Sci. Comput.
    30, 2635 (2008).
    """
    index = np.asarray(index, np.uint64)
    bits = np.broadcast_to(np.asarray(scramble, np.uint32), (*index.shape, 3)).copy()
    for k in range(32):
        chosen = (index >> np.uint64(k) & np.uint64(1)).astype(bool)
        bits[chosen] ^= _SOBOL[:, k]
    return bits / 2.0**32


def disk_points(square: Floats) -> Floats:
    """Carry points of the unit square to the unit disk, areas to areas.

    Parameters
    ----------
    square : (S, 2) ndarray of float64
        Points in [0, 1].

    Returns
    -------
    (S, 2) ndarray of float64
        Points with norm at most 1; the square's centre becomes the disk's.

    Raises
    ------
    IndexError
        By numpy, if the last axis is shorter than 2.

    References
    ----------
    Shirley and Chiu, "A low distortion map between disk and square", J. Graphics Tools 2(3), 45-52 (1997).
    """
    a, b = 2.0 * square[..., 0] - 1.0, 2.0 * square[..., 1] - 1.0
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.where(wide, 0.25 * np.pi * (b / a), 0.5 * np.pi - 0.25 * np.pi * (a / b))
    angle = np.where(radius == 0.0, 0.0, angle)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def polygon_points(square: Floats, corners: int) -> Floats:
    """Carry points of the unit square to a regular polygon, areas to areas.

    Parameters
    ----------
    square : (S, 2) ndarray of float64
        Points in [0, 1).
    corners : int
        At least 3; the first lies on the x axis.

    Returns
    -------
    (S, 2) ndarray of float64
        Points within the polygon whose corners have norm 1.

    Raises
    ------
    InvalidParameterError
        If there are fewer than 3 corners.

    References
    ----------
    Uniform points of a triangle: Turk, "Generating random points in triangles", Graphics Gems (1990).
    """
    require_integer("corners", corners, 3)
    sector = np.floor(square[..., 0] * corners)
    within = square[..., 0] * corners - sector
    root = np.sqrt(within)
    first, second = root * (1.0 - square[..., 1]), root * square[..., 1]
    turn = 2.0 * np.pi / corners
    angle = sector * turn
    x = first * np.cos(angle) + second * np.cos(angle + turn)
    y = first * np.sin(angle) + second * np.sin(angle + turn)
    return np.stack([x, y], axis=-1)


def pixel_offsets(samples: int, pixel_filter: str = "box", width: float = 1.0, seed: int = 0) -> Floats:
    """Sub-pixel positions, the same for every pixel, to be weighed equally.

    They are drawn by the filter's own density, so that the plain mean of the samples is the filtered pixel.

    Parameters
    ----------
    samples : int
        How many, at least 1.
    pixel_filter : {"box", "triangle", "gaussian", "blackman_harris"}
        The filter's shape.
    width : float, optional
        Full width of the filter in pixels, above 0 and at most 16.
    seed : int, optional
        At least 0; equal seeds give equal offsets.

    Returns
    -------
    (S, 2) ndarray of float64
        Offsets (x, y) from the pixel's upper left corner; the filter's centre is (0.5, 0.5), and offsets leave [0, 1]
        where the filter is wider than the pixel.

    Raises
    ------
    InvalidParameterError
        If a parameter breaks its rule.

    References
    ----------
    Filter importance sampling: Ernst, Stamminger and Greiner, IEEE Symp. Interactive Ray Tracing (2006).
    """
    require_choice("pixel_filter", pixel_filter, PIXEL_FILTERS)
    require_in_range("width", width, 1e-3, 16.0, unit="pixels")
    points = square_points(samples, seed)
    if pixel_filter == "box":
        centred = points - 0.5
    elif pixel_filter == "triangle":
        low = points < 0.5
        centred = np.where(low, np.sqrt(0.5 * np.minimum(points, 0.5)), 1.0 - np.sqrt(0.5 * (1.0 - points))) - 0.5
    else:
        centred = _inverse_cumulative(pixel_filter, points)
    return 0.5 + width * centred


def _inverse_cumulative(pixel_filter: str, points: Floats) -> Floats:
    """Quantiles of a filter on [-1/2, 1/2], from its density tabulated finely enough for linear interpolation."""
    x = np.linspace(-0.5, 0.5, 4097)
    if pixel_filter == "gaussian":
        density = np.exp(-0.5 * (x / _GAUSSIAN_SIGMA) ** 2)
    else:
        density = sum((a * np.cos(2.0 * np.pi * k * x) for k, a in enumerate(_BLACKMAN_HARRIS)), start=np.zeros_like(x))
    cumulative = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp(points, cumulative / cumulative[-1], x)
