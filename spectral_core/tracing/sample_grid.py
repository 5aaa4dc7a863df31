"""Points on a light's screen, sorted into the cells of a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SampleGrid"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_BLOCK_BITS = 3
"""Cells are grouped in blocks of 2**3 by 2**3 for culling."""


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
    start : (rows * columns + 1,) ndarray of int64
        First sample of each cell.
    x, y : (N,) ndarray
        Positions in cells, from the grid's corner.
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
    start: Integers
    x: Array
    y: Array
    nearness: Array
    order: Integers
    farthest: Array

    @classmethod
    def of(cls, x: Array, y: Array, nearness: Array, cells: int) -> SampleGrid:
        """Sort samples.

        Parameters
        ----------
        x, y, nearness : (N,) ndarray
            Screen positions and nearness, at least one.
        cells : int
            Number of cells along the longer side.

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
        scale = dtype.type(0.9999 * cells / extent if extent > 0.0 else 1.0)
        x, y = (x - origin[0]) * scale, (y - origin[1]) * scale
        columns, rows = int(x.max()) + 1, int(y.max()) + 1
        cell = y.astype(np.int64)
        cell *= columns
        cell += x.astype(np.int64)
        start = np.zeros(columns * rows + 1, np.int64)
        np.cumsum(np.bincount(cell, minlength=columns * rows), out=start[1:])
        bits = len(x).bit_length()
        cell <<= bits
        cell |= np.arange(len(x))
        cell.sort()
        order = cell & ((1 << bits) - 1)
        cell >>= bits
        x, y, nearness = np.take(x, order), np.take(y, order), np.take(nearness, order)
        farthest = _farthest(cell, nearness, columns, rows)
        return cls(
            (float(origin[0]), float(origin[1])), float(scale), columns, rows, start, x, y, nearness, order, farthest
        )

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
        within = (right >= 0.0) & (bottom >= 0.0) & (left < self.columns) & (top < self.rows)
        column = np.clip(left, 0.0, self.columns - 1.0).astype(np.int64)
        row = np.clip(top, 0.0, self.rows - 1.0).astype(np.int64)
        block = (row >> _BLOCK_BITS) * self.farthest.shape[1] + (column >> _BLOCK_BITS)
        edge = float(1 << _BLOCK_BITS)
        large = (right - left >= edge) | (bottom - top >= edge)
        return within & (large | (nearest > np.take(self.farthest.ravel(), block)))


def _farthest(cell: Integers, nearness: Array, columns: int, rows: int) -> Array:
    """Least nearness per block of cells, spread to the blocks on the left and above."""
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    shape = ((rows - 1 >> _BLOCK_BITS) + 1, (columns - 1 >> _BLOCK_BITS) + 1)
    padded = np.full((shape[0] << _BLOCK_BITS, shape[1] << _BLOCK_BITS), np.inf, nearness.dtype)
    used = cell[starts]
    padded[used // columns, used % columns] = np.minimum.reduceat(nearness, starts)
    edge = 1 << _BLOCK_BITS
    blocks = padded.reshape(shape[0], edge, shape[1], edge).min(axis=3).min(axis=1)
    blocks[:, :-1] = np.minimum(blocks[:, :-1], blocks[:, 1:])
    blocks[:-1] = np.minimum(blocks[:-1], blocks[1:])
    return blocks
