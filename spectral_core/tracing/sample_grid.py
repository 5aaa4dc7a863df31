"""Points on a light's screen, sorted into the cells of a grid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SampleGrid"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_BLOCK_BITS = 3
"""Cells are grouped in blocks of 2**3 by 2**3 for culling."""

_CROWDING = 30.0
"""How many times more often than on an even screen points must share cells before these are made smaller: cells cost
time too, most are empty."""

_LARGEST_COORDINATE = 2048.0
"""Screen coordinates stay below this; the last bit of one is the most that a position in cells can be off."""


@dataclass(frozen=True, slots=True, eq=False)
class SampleGrid:
    """Samples in the order of the cells they lie in, row by row.

    The samples of neighbouring cells of one row are neighbours in memory: a triangle's span on a row of cells is one
    range of samples.

    Parameters
    ----------
    origin : tuple of float
        Screen position of the grid's corner.
    scale : float
        Cells per screen unit.
    columns, rows : int
        Number of cells.
    pad : float
        How many cells off a position may be by rounding.
    start : (rows * columns + 1,) ndarray of int
        First sample of each cell.
    x, y : (N,) ndarray
        Positions on the screen.
    nearness : (N,) ndarray
        What a triangle must exceed to hide the sample.
    order : (N,) ndarray of int64
        Number of each sample in the caller's arrays.
    farthest : (block rows, block columns) ndarray
        Least nearness of the samples in each block of cells and its neighbours to the right and below; infinite where
        there are none.

    References
    ----------
    Irregular z-buffer: Johnson, Lee, Burns and Mark, ACM Trans. Graphics 24(4), 1462-1482 (2005).
    """

    origin: tuple[float, float]
    scale: float
    columns: int
    rows: int
    pad: float
    start: NDArray[np.signedinteger[Any]]
    x: Array
    y: Array
    nearness: Array
    order: Integers
    farthest: Array

    @classmethod
    def of(cls, x: Array, y: Array, nearness: Array) -> SampleGrid:
        """Sort samples into a grid with about one cell for each, more where they crowd.

        Parameters
        ----------
        x, y, nearness : (N,) ndarray
            Screen positions and nearness, at least one.

        Returns
        -------
        SampleGrid
            A grid over the samples' bounding rectangle.

        Raises
        ------
        ValueError
            By numpy, if there are no samples.

        References
        ----------
        Own design.
        """
        dtype = x.dtype
        origin = x.min(), y.min()
        extent = max(float(x.max() - origin[0]), float(y.max() - origin[1]))
        cells = _fineness(x - origin[0], y - origin[1], extent)
        scale = dtype.type(0.9999 * cells / extent if extent > 0.0 else 1.0)
        across, down = (x - origin[0]) * scale, (y - origin[1]) * scale
        # Whole blocks in every row: the cells of a block's row are neighbours.
        columns, rows = ((int(side.max()) >> _BLOCK_BITS) + 1 << _BLOCK_BITS for side in (across, down))
        pad = 0.01 + 8.0 * float(np.finfo(dtype).eps * scale) * _LARGEST_COORDINATE
        cell = _cells(across, down, columns)
        order = _sorted_order(cell)
        cell, x, y, nearness = (np.take(values, order) for values in (cell, x, y, nearness))
        start, farthest = _index(cell, nearness, columns, rows)
        corner = float(origin[0]), float(origin[1])
        return cls(corner, float(scale), columns, rows, pad, start, x, y, nearness, order, farthest)

    def without(self, removed: NDArray[np.bool_]) -> SampleGrid:
        """Leave samples out.

        Parameters
        ----------
        removed : (N,) ndarray of bool
            True for those to leave out, in the grid's own order.

        Returns
        -------
        SampleGrid
            The others in the same cells.

        Raises
        ------
        ValueError
            By numpy, if all samples are left out.

        References
        ----------
        Own design.
        """
        left = np.flatnonzero(~removed)
        x, y, nearness = np.take(self.x, left), np.take(self.y, left), np.take(self.nearness, left)
        start, farthest = _index(_cells(*self.cells(x, y), self.columns), nearness, self.columns, self.rows)
        order = np.take(self.order, left)
        return replace(self, start=start, x=x, y=y, nearness=nearness, order=order, farthest=farthest)

    def cells(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Bring screen positions to the grid, rounded as its samples were.

        Parameters
        ----------
        x, y : (V,) ndarray
            Screen positions.

        Returns
        -------
        x, y : (V,) ndarray
            In cells.

        Raises
        ------
        ValueError
            By numpy, if the shapes differ.

        References
        ----------
        Own design.
        """
        scale = x.dtype.type(self.scale)
        return (x - x.dtype.type(self.origin[0])) * scale, (y - y.dtype.type(self.origin[1])) * scale

    def may_hide(self, left: Array, top: Array, right: Array, bottom: Array, nearest: Array) -> NDArray[np.bool_]:
        """Tell which boxes may hide a sample: those before the farthest sample around their corner.

        Parameters
        ----------
        left, top, right, bottom : (S,) ndarray
            Boxes in cells; they may leave the grid.
        nearest : (S,) ndarray
            Greatest nearness in each box.

        Returns
        -------
        (S,) ndarray of bool
            False only where no sample can be hidden.

        Raises
        ------
        ValueError
            By numpy, if the shapes differ.

        References
        ----------
        Own design.
        """
        pad = self.pad
        within = (right >= -pad) & (bottom >= -pad) & (left < self.columns + pad) & (top < self.rows + pad)
        column = np.clip(left - pad, 0.0, self.columns - 1.0).astype(np.int64)
        row = np.clip(top - pad, 0.0, self.rows - 1.0).astype(np.int64)
        block = (row >> _BLOCK_BITS) * self.farthest.shape[1] + (column >> _BLOCK_BITS)
        edge = float(1 << _BLOCK_BITS) - 2.0 * pad
        large = (right - left >= edge) | (bottom - top >= edge)
        return within & (large | (nearest > np.take(self.farthest.ravel(), block)))


def _fineness(x: Array, y: Array, extent: float) -> int:
    """Cells along the longer side: 1.5 per root of the samples if they are spread evenly, more where they crowd."""
    even = 1.5 * np.sqrt(len(x))
    if extent > 0.0:
        # In a grid too coarse for most of them, how many of some samples share a cell with a given one?
        some = slice(None, None, max(len(x) // 65536, 1))
        coarse = 0.2 * even
        x, y = x[some] * (0.9999 * coarse / extent), y[some] * (0.9999 * coarse / extent)
        population = np.bincount(_cells(x, y, int(coarse) + 1))
        sharing = float(np.mean(population[population > 0] * (population[population > 0] - 1.0)))
        sharing *= np.count_nonzero(population) / len(x)
        expected = len(x) / coarse**2
        even *= np.sqrt(max(sharing / (_CROWDING * expected), 1.0))
    return int(np.clip(even, 16, 4096))


def _cells(x: Array, y: Array, columns: int) -> Integers:
    """Cell numbers of positions in cells."""
    cell = y.astype(np.int64)
    cell *= columns
    cell += x.astype(np.int64)
    return cell


def _sorted_order(cell: Integers) -> Integers:
    """Order of rising cells; numpy's stable sort of 16 bits counts instead of comparing."""
    order: Integers = np.argsort((cell & 0xFFFF).astype(np.uint16), kind="stable")
    high = cell >> 16
    if high.any():
        order = np.take(order, np.argsort(np.take(high, order).astype(np.uint16), kind="stable"))
    return order


def _index(cell: Integers, nearness: Array, columns: int, rows: int) -> tuple[NDArray[np.signedinteger[Any]], Array]:
    """First sample of each cell, and the least nearness per block spread to the blocks on the left and above."""
    dtype = np.int32 if len(cell) < 2**31 else np.int64
    start: NDArray[np.signedinteger[Any]] = np.zeros(columns * rows + 1, dtype)
    np.cumsum(np.bincount(cell, minlength=columns * rows), out=start[1:])
    segment = cell >> _BLOCK_BITS  # a row of cells of a block
    first = np.flatnonzero(np.diff(segment, prepend=-1))
    segments = np.full(rows * columns >> _BLOCK_BITS, np.inf, nearness.dtype)
    segments[segment[first]] = np.minimum.reduceat(nearness, first)
    blocks = segments.reshape(rows >> _BLOCK_BITS, 1 << _BLOCK_BITS, columns >> _BLOCK_BITS).min(axis=1)
    blocks[:, :-1] = np.minimum(blocks[:, :-1], blocks[:, 1:])
    blocks[:-1] = np.minimum(blocks[:-1], blocks[1:])
    return start, blocks
