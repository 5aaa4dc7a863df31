"""Small groups of neighbouring boxes, so that a tree over very many need not sort each of them at every level."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["along_curve", "cluster", "spread_bits"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_LARGE = 8.0
"""A box this many times longer than the median is kept alone: it would swell its neighbours' cluster."""

# Spread the low 21 bits of an integer so that two zeros stand between them: shift, then mask.
_SPREAD = (
    (32, 0x001F00000000FFFF),
    (16, 0x001F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)


def cluster(lower: Array, upper: Array, size: int) -> tuple[Integers, Integers]:
    """Group boxes that follow each other along a space-filling curve.

    A group does not reach across a cell of a grid that holds about `size` boxes a cell, so that jumps of the curve do
    not make long groups.

    Parameters
    ----------
    lower, upper : (I, 3) ndarray
        Boxes, at least one.
    size : int
        Largest number in a group.

    Returns
    -------
    order : (I,) ndarray of int64
        Box numbers, group by group.
    first : (G,) ndarray of int64
        Where each group begins in `order`.

    Raises
    ------
    ValueError
        By numpy, if there are no boxes.

    References
    ----------
    Curve: Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM (1966).
    Clusters below a surface-area-heuristic tree: Garanzha, Pantaleoni and McAllister, High Performance Graphics (2011).
    """
    length = (upper - lower).max(axis=1)
    large = np.flatnonzero(length > _LARGE * np.median(length))
    small = np.flatnonzero(length <= _LARGE * np.median(length))
    code, order = along_curve(np.take(lower, small, axis=0) + np.take(upper, small, axis=0))
    order = np.take(small, order)
    cell = code >> _cell_bits(code, size)
    new_cell = np.diff(cell, prepend=-1) != 0
    start = np.flatnonzero(new_cell)
    rank = np.arange(len(cell)) - np.take(start, np.cumsum(new_cell) - 1)
    first = np.flatnonzero(rank % size == 0)
    return np.concatenate([order, large]), np.concatenate([first, len(order) + np.arange(len(large))])


def spread_bits(values: Integers) -> Integers:
    """Put two zeros between the bits of integers.

    Parameters
    ----------
    values : (N,) ndarray of int64
        From 0 to 2**21 - 1.

    Returns
    -------
    (N,) ndarray of int64
        Three of them, shifted against each other, make a Morton code.

    Raises
    ------
    TypeError
        By numpy, if the values are not integers.

    References
    ----------
    Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM (1966).
    """
    spread = values.copy()
    for shift, mask in _SPREAD:
        spread |= spread << shift
        spread &= mask
    return spread


def along_curve(points: Array) -> tuple[Integers, Integers]:
    """Order points so that neighbours in the row are neighbours in space.

    Parameters
    ----------
    points : (N, 3) ndarray
        Points, at least one.

    Returns
    -------
    code : (N,) ndarray of int64
        Morton codes, rising.
    order : (N,) ndarray of int64
        Which point each belongs to.

    Raises
    ------
    ValueError
        By numpy, if there are no points.

    References
    ----------
    Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM (1966).
    """
    count = len(points)
    index_bits = count.bit_length()
    axis_bits = min((63 - index_bits) // 3, 20)
    least = points.min(axis=0)
    extent = float((points.max(axis=0) - least).max())
    scale = (2.0**axis_bits - 1.0) / extent if extent > 0.0 else 0.0
    code = np.zeros(count, np.int64)
    for axis in range(3):
        place = ((points[:, axis] - least[axis]).astype(np.float64) * scale).astype(np.int64)
        code |= spread_bits(place) << (2 - axis)
    packed = np.sort(code << index_bits | np.arange(count))
    return packed >> index_bits, packed & ((1 << index_bits) - 1)


def _cell_bits(code: Integers, size: int) -> int:
    """Low bits of the codes that vary within a cell, for about `size` codes in each occupied cell."""
    bits = 0
    while bits < 60 and np.count_nonzero(np.diff(code >> bits)) * size > len(code):
        bits += 1
    return bits
