"""From screen triangles to the screen rows they cross, and from ranges to their members."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Edges", "batches", "expand", "ordered_edges", "top_to_bottom"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

# Which corner is top, middle and bottom, by the bits (y0 > y1) + 2 (y1 > y2) + 4 (y0 > y2); contradictory codes cannot
# occur.
_TOP_TO_BOTTOM = np.array(
    [(0, 1, 2), (1, 0, 2), (0, 2, 1), (0, 1, 2), (0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)], dtype=np.int64
)


def expand(counts: Integers) -> tuple[Integers, Integers]:
    """Number the members of ranges.

    Parameters
    ----------
    counts : (R,) ndarray of int64
        How many members each range has, at least 0.

    Returns
    -------
    owner, rank : (sum of counts,) ndarray of int64
        Which range each member belongs to, and its number within it.

    Raises
    ------
    ValueError
        By numpy, if a count is negative.

    References
    ----------
    Own design.
    """
    owner = np.repeat(np.arange(len(counts)), counts)
    start = np.cumsum(counts) - counts
    return owner, np.arange(len(owner)) - np.take(start, owner)


def batches(counts: Integers, size: int) -> Iterator[tuple[int, int]]:
    """Divide ranges into runs with about `size` members, at least one range each.

    Parameters
    ----------
    counts : (R,) ndarray of int64
        How many members each range has.
    size : int
        Members wanted in a run.

    Yields
    ------
    begin, end : int
        First range of each run and the one behind its last.

    Returns
    -------
    iterator of tuple of int
        The runs.

    Raises
    ------
    ZeroDivisionError
        Never; sizes below 1 give runs of one range.

    References
    ----------
    Own design.
    """
    total = np.cumsum(counts)
    begin = 0
    while begin < len(counts):
        before = int(total[begin - 1]) if begin else 0
        end = max(int(np.searchsorted(total, before + size, side="right")), begin + 1)
        yield begin, end
        begin = end


def top_to_bottom(y: Array, corners: Integers) -> tuple[Integers, Integers, Integers]:
    """Order the corners of triangles by height.

    Parameters
    ----------
    y : (V,) ndarray
        Heights of the vertices, growing downward.
    corners : (S, 3) ndarray of int64
        Vertex numbers.

    Returns
    -------
    top, middle, bottom : (S,) ndarray of int64
        Vertex numbers.

    Raises
    ------
    IndexError
        By numpy, if a vertex number is out of range.

    References
    ----------
    Own design.
    """
    y0, y1, y2 = (np.take(y, corners[:, k]) for k in range(3))
    code = (y0 > y1) + 2 * (y1 > y2).astype(np.int64) + 4 * (y0 > y2)
    order = np.take(_TOP_TO_BOTTOM, code, axis=0)
    order += 3 * np.arange(len(corners))[:, None]
    flat = corners.ravel()
    top, middle, bottom = (np.take(flat, order[:, k]) for k in range(3))
    return top, middle, bottom


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Three edges of each of S triangles, every one from its upper to its lower end.

    The first S are the long edges (top to bottom), then come the upper short ones (top to middle), then the lower
    (middle to bottom). Two triangles that share an edge hold bitwise equal values for it: where a row crosses it comes
    out the same for both.

    Parameters
    ----------
    y : (3 S,) ndarray
        Upper end.
    x, nearness : (3 S,) ndarray
        Values at the upper end.
    x_slope, nearness_slope : (3 S,) ndarray
        Change per unit of y; anything for horizontal edges, which no row crosses.
    middle, bottom : (S,) ndarray
        Height of the middle and the bottom corner; the top one's is ``y[:S]``.

    References
    ----------
    Own design.
    """

    y: Array
    x: Array
    nearness: Array
    x_slope: Array
    nearness_slope: Array
    middle: Array
    bottom: Array

    def crossing(self, edge: Integers, row: Array) -> tuple[Array, Array]:
        """Where rows cross edges.

        Parameters
        ----------
        edge : (R,) ndarray of int64
            Edge numbers.
        row : (R,) ndarray
            Heights between the edges' ends.

        Returns
        -------
        x, nearness : (R,) ndarray
            Values at the crossing.

        Raises
        ------
        IndexError
            By numpy, if an edge number is out of range.

        References
        ----------
        Own design.
        """
        down = row - np.take(self.y, edge)
        x = np.take(self.x_slope, edge)
        x *= down
        x += np.take(self.x, edge)
        nearness = np.take(self.nearness_slope, edge)
        nearness *= down
        nearness += np.take(self.nearness, edge)
        return x, nearness


def ordered_edges(x: Array, y: Array, nearness: Array, corners: Integers) -> Edges:
    """Order the corners of triangles by height and set up their edges.

    Parameters
    ----------
    x, y, nearness : (V,) ndarray
        Screen vertices.
    corners : (S, 3) ndarray of int64
        Vertex numbers.

    Returns
    -------
    Edges
        The edges.

    Raises
    ------
    IndexError
        By numpy, if a vertex number is out of range.

    References
    ----------
    Own design.
    """
    count = len(corners)
    a, b, c = top_to_bottom(y, corners)
    upper, lower = np.concatenate([a, a, b]), np.concatenate([c, b, c])
    top, bottom = np.take(y, upper), np.take(y, lower)
    x_top, near_top = np.take(x, upper), np.take(nearness, upper)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        height = bottom - top
        x_slope = (np.take(x, lower) - x_top) / height
        nearness_slope = (np.take(nearness, lower) - near_top) / height
    return Edges(top, x_top, near_top, x_slope, nearness_slope, bottom[count : 2 * count], bottom[:count])
