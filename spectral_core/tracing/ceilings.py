"""How near the triangles over each part of a screen come, to tell the points that nothing can hide at one look."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .spans import expand

__all__ = ["Ceilings"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_FINEST, _COARSEST = 256, 16
"""Most and fewest blocks along a side."""

_SMALL = 0.9
"""Part of the triangles whose boxes two blocks are made at least as large as."""

_REACH = 6
"""Blocks along a side of a triangle's box up to which each is looked at; larger boxes get larger blocks."""

_COARSER = 2
"""How many times they are doubled then."""

_PAD = 0.05
"""Part of a block by which triangles are widened: positions are rounded, and so are planes."""


@dataclass(frozen=True, slots=True, eq=False)
class Ceilings:
    """Blocks over the part of a screen that has triangles, and the greatest nearness in each.

    Parameters
    ----------
    origin : tuple of float
        Screen position of the first block's corner.
    scale : float
        Blocks per screen unit.
    count : int
        Blocks along each side, without the empty ones around them.
    height : ((count + 2)**2,) ndarray
        Greatest nearness of a triangle in each block, row by row; minus infinity where there is none.

    References
    ----------
    Hierarchical z-buffer, here of what hides and not of what is hidden: Greene, Kass and Miller, SIGGRAPH (1993).
    """

    origin: tuple[float, float]
    scale: float
    count: int
    height: Array

    @classmethod
    def of(
        cls,
        x: Array,
        y: Array,
        nearness: Array,
        box: tuple[Array, Array, Array, Array],
        nearest: Array,
        size: float,
    ) -> Ceilings:
        """Bound the nearness of triangles.

        Parameters
        ----------
        x, y, nearness : (3, S) ndarray
            Corners on the screen.
        box : tuple of four (S,) ndarray
            Left, right, top and bottom of each triangle.
        nearest : (S,) ndarray
            Greatest nearness of each.
        size : float
            Width and height of the screen; only points on it are asked for.

        Returns
        -------
        Ceilings
            The bounds.

        Raises
        ------
        ValueError
            By numpy, if the lengths differ.

        References
        ----------
        Own design.
        """
        dtype = nearness.dtype
        left, right, top, bottom = box
        if not len(nearest):
            return cls((0.0, 0.0), 1.0, 1, np.full(9, -np.inf, dtype))
        low_x, high_x = (float(np.clip(end, 0.0, size)) for end in (left.min(), right.max()))
        low_y, high_y = (float(np.clip(end, 0.0, size)) for end in (top.min(), bottom.max()))
        extent = max(high_x - low_x, high_y - low_y, 1e-3 * size) * 1.0001
        typical = float(np.quantile(np.maximum(right - left, bottom - top)[:: max(len(left) // 4096, 1)], _SMALL))
        count = int(np.clip(2.0 * extent / max(typical, 1e-6 * size), _COARSEST, _FINEST))
        scale = count / extent
        height = np.full((count, count), -np.inf, dtype)
        first_x, last_x = _range(left, right, low_x, scale, count)
        first_y, last_y = _range(top, bottom, low_y, scale, count)
        wide = np.maximum(last_x - first_x, last_y - first_y)
        small, large = np.flatnonzero(wide <= 2), np.flatnonzero(wide > 2)
        table, value = height.ravel(), np.take(nearest, small)
        columns, rows = (
            [np.take(first, small), np.take(first + last >> 1, small), np.take(last, small)]
            for first, last in ((first_x, last_x), (first_y, last_y))
        )
        for row in rows:
            row *= count
            for column in columns:
                np.maximum.at(table, row + column, value)
        shift = 0
        while len(large):
            fits = np.take(wide, large) >> shift < _REACH
            some = large[fits]
            if len(some):
                ranges = [np.take(end, some) >> shift for end in (first_x, last_x, first_y, last_y)]
                step = float(1 << shift) / scale
                corners = [np.take(values, some, axis=1) for values in (x, y, nearness)]
                coarse = _above(ranges, corners, np.take(nearest, some), (low_x, low_y), step, (count - 1 >> shift) + 1)
                np.maximum(height, coarse.repeat(1 << shift, 0).repeat(1 << shift, 1)[:count, :count], out=height)
            large = large[~fits]
            shift += _COARSER
        bordered = np.full((count + 2, count + 2), -np.inf, dtype)
        bordered[1:-1, 1:-1] = height
        return cls((low_x, low_y), scale, count, bordered.ravel())

    def below(self, x: Array, y: Array, nearness: Array) -> Integers:
        """Find the points that a triangle may hide: those behind the nearest one over their block.

        Parameters
        ----------
        x, y, nearness : (N,) ndarray
            Points on the screen.

        Returns
        -------
        (M,) ndarray of int64
            Their numbers, increasing. No triangle hides any other.

        Raises
        ------
        ValueError
            By numpy, if the lengths differ.

        References
        ----------
        Own design.
        """
        dtype = self.height.dtype.type
        end = dtype(self.count + 1)
        column, row = (
            np.clip((values - dtype(low)) * dtype(self.scale) + dtype(1.0), dtype(0.0), end).astype(np.int64)
            for values, low in zip((x, y), self.origin, strict=True)
        )
        row *= self.count + 2
        row += column
        return np.flatnonzero(np.take(self.height, row) > nearness)


def _range(low: Array, high: Array, origin: float, scale: float, count: int) -> tuple[Integers, Integers]:
    """First and last block of intervals."""
    first, last = (
        np.clip((end - origin) * scale + pad, 0.0, count - 1.0).astype(np.int64)
        for end, pad in ((low, -_PAD), (high, _PAD))
    )
    return first, last


def _slopes(x: Array, y: Array, nearness: Array) -> tuple[Array, Array]:
    """Change of triangles' nearness along x and y; not finite for those seen edge on."""
    bx, cx, by, cy = x[1] - x[0], x[2] - x[0], y[1] - y[0], y[2] - y[0]
    bz, cz = nearness[1] - nearness[0], nearness[2] - nearness[0]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        scale = 1.0 / (bx * cy - by * cx)
        return (bz * cy - by * cz) * scale, (bx * cz - bz * cx) * scale


def _above(
    ranges: list[Integers],
    corners: list[Array],
    nearest: Array,
    origin: tuple[float, float],
    step: float,
    blocks: int,
) -> Array:
    """Greatest nearness of triangles in blocks of one size, by their planes and by their nearest corners."""
    first_x, last_x, first_y, last_y = ranges
    wide = last_x - first_x + 1
    owner, rank = expand(wide * (last_y - first_y + 1))
    wide = np.take(wide, owner)
    row = rank // wide
    column = rank - row * wide + np.take(first_x, owner)
    row += np.take(first_y, owner)
    planes = (*(values[0] for values in corners), *_slopes(*corners), nearest)
    x, y, height, slope_x, slope_y, highest = (np.take(values, owner) for values in planes)
    half = (0.5 + _PAD) * step
    with np.errstate(invalid="ignore", over="ignore"):
        height += slope_x * (((column + 0.5) * step + origin[0]).astype(x.dtype) - x) + np.abs(slope_x) * half
        height += slope_y * (((row + 0.5) * step + origin[1]).astype(y.dtype) - y) + np.abs(slope_y) * half
    result = np.full((blocks, blocks), -np.inf, x.dtype)
    np.maximum.at(result.ravel(), row * blocks + column, np.fmin(highest, height))
    return result
