"""A binary tree over boxes by the surface area heuristic, built level by level in whole arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["BinaryTree", "binary_tree", "half_area"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_BINS = ((8, 4), (24, 8))
"""Pairs (items a node has on average at most, bins); 16 bins above."""


@dataclass(frozen=True, slots=True, eq=False)
class BinaryTree:
    """Nodes over a permutation of items; a node holds the items ``order[first : first + count]``.

    Parameters
    ----------
    order : (I,) ndarray of int64
        Item numbers.
    first, count : (B,) ndarray of int64
        Range of each node within `order`.
    left : (B,) ndarray of int64
        First child of each node (the second follows it), -1 for a leaf. Children come after their parents.
    lower, upper : (B, 3) ndarray
        Boxes of the nodes.

    References
    ----------
    Own design.
    """

    order: Integers
    first: Integers
    count: Integers
    left: Integers
    lower: Array
    upper: Array


def half_area(lower: Array, upper: Array) -> Array:
    """Half the surface area of boxes; 0 for empty (inverted) ones.

    Parameters
    ----------
    lower, upper : (..., 3) ndarray
        Opposite corners.

    Returns
    -------
    (...) ndarray
        Sum of the areas of three faces.

    Raises
    ------
    ValueError
        By numpy, if the shapes do not broadcast.

    References
    ----------
    Goldsmith and Salmon, "Automatic creation of object hierarchies for ray tracing", IEEE CG&A 7(5), 14-20 (1987).
    """
    edge = np.maximum(upper - lower, 0.0)
    x, y, z = edge[..., 0], edge[..., 1], edge[..., 2]
    return x * y + y * z + z * x


def binary_tree(
    lower: Array, upper: Array, leaf_size: int, stop_if_cancelled: Callable[[], None] = lambda: None
) -> BinaryTree:
    """Split boxes until at most `leaf_size` share a node.

    Every level is split at once: the items of all its large nodes are put into up to 16 bins along the longest axis of
    their node's centroids, and each node is cut where area times count is least. Nodes whose centroids coincide are
    halved.

    Parameters
    ----------
    lower, upper : (I, 3) ndarray
        Boxes of the items, at least one.
    leaf_size : int
        Largest number of items in a leaf, at least 1.
    stop_if_cancelled : callable, optional
        Asked before each level; raises when the caller wants an end.

    Returns
    -------
    BinaryTree
        The tree; node 0 is the root.

    Raises
    ------
    ValueError
        By numpy, if there are no items.

    References
    ----------
    Wald, "On fast construction of SAH-based bounding volume hierarchies", IEEE Symp. Interactive Ray Tracing (2007).
    """
    # One row a box, the upper corner negated: a minimum of rows encloses.
    boxes = np.concatenate([lower, -upper], axis=1)
    order = np.arange(len(boxes))
    rows, items = boxes, order  # those of nodes yet to be split, node by node
    levels = [(np.zeros(1, np.int64), np.array([len(boxes)]))]
    lefts: list[Integers] = []
    nodes = 1
    while True:
        stop_if_cancelled()
        first, count = levels[-1]
        left = np.full(len(first), -1)
        lefts.append(left)
        large = np.flatnonzero(count > leaf_size)
        if not len(large):
            break
        if len(large) < len(count):
            active = np.flatnonzero(np.repeat(count > leaf_size, count))
            rows, items = np.take(rows, active, axis=0), np.take(items, active)
        first, count = first[large], count[large]
        rows, items, in_left = _split(rows, items, count)
        order[np.arange(len(items)) + np.repeat(first - (np.cumsum(count) - count), count)] = items
        left[large] = nodes + 2 * np.arange(len(large))
        nodes += 2 * len(large)
        levels.append(
            (
                np.stack([first, first + in_left], axis=1).ravel(),
                np.stack([in_left, count - in_left], axis=1).ravel(),
            )
        )
    first = np.concatenate([level[0] for level in levels])
    count = np.concatenate([level[1] for level in levels])
    left = np.concatenate(lefts)
    bounds = _enclose(np.take(boxes, order, axis=0), first, left, [len(level[0]) for level in levels])
    return BinaryTree(order, first, count, left, bounds[:, :3], -bounds[:, 3:])


def _split(rows: Array, items: Integers, count: Integers) -> tuple[Array, Integers, Integers]:
    """Sort the boxes and items of each node by its bins; count also those that go to the left child."""
    nodes = len(count)
    bins = _bins(int(count.mean()))
    start = np.cumsum(count) - count
    owner = np.repeat(np.arange(nodes), count)
    centre = rows[:, :3] - rows[:, 3:]  # twice the centroid
    least = np.minimum.reduceat(centre, start, axis=0)
    extent = np.maximum.reduceat(centre, start, axis=0) - least
    axis = extent.argmax(axis=1)
    of = np.arange(nodes)
    span = extent[of, axis]
    scale = np.where(span > 0.0, (bins * 0.9999) / np.where(span > 0.0, span, 1.0), 0.0).astype(rows.dtype)
    along = np.take(centre.ravel(), 3 * np.arange(len(owner)) + np.take(axis, owner))
    along -= np.take(least[of, axis], owner)
    along *= np.take(scale, owner)
    chosen = np.minimum(along.astype(np.int64), bins - 1)

    # Key and position share one integer, so that a plain sort is stable and gives the permutation.
    bits = len(owner).bit_length()
    packed = np.sort((owner * bins + chosen) << bits | np.arange(len(owner)))
    key = packed >> bits
    packed &= (1 << bits) - 1
    rows, items = np.take(rows, packed, axis=0), np.take(items, packed)

    population = np.bincount(key, minlength=nodes * bins).reshape(nodes, bins)
    begin = np.flatnonzero(np.diff(key, prepend=-1))
    binned = np.full((6, nodes * bins), np.inf, rows.dtype)
    binned[:, key[begin]] = np.minimum.reduceat(rows, begin, axis=0).T
    cost = _cut_costs(binned.reshape(6, nodes, bins), population)
    cut = cost.argmin(axis=1)
    in_left = np.take_along_axis(population.cumsum(axis=1), cut[:, None], axis=1)[:, 0]
    return rows, items, np.where(np.isfinite(cost[of, cut]), in_left, count // 2)


def _bins(items: int) -> int:
    """Fewer bins where few items share a node: most would be empty."""
    return next((bins for limit, bins in _BINS if items <= limit), 16)


def _cut_costs(binned: Array, population: Integers) -> Array:
    """Area times count of both sides for every cut behind a bin, infinite where a side is empty."""

    def sweep(rows: Array, number: Integers) -> tuple[Array, Integers]:
        bounds = np.minimum.accumulate(rows, axis=2)
        # An empty side is inverted: infinite, and left out below for its count.
        x, y, z = (-bounds[k + 3] - bounds[k] for k in range(3))
        return (x * y + y * z + z * x)[:, :-1], number.cumsum(axis=1)[:, :-1]

    with np.errstate(invalid="ignore", over="ignore"):
        area_left, left = sweep(binned, population)
        area_right, right = sweep(binned[:, :, ::-1], population[:, ::-1])
        area_right, right = area_right[:, ::-1], right[:, ::-1]
        return np.where((left > 0) & (right > 0), area_left * left + area_right * right, np.inf)


def _enclose(boxes: Array, first: Integers, left: Integers, level_sizes: list[int]) -> Array:
    """Boxes of all nodes: leaves from their items, then parents from their children, deepest level first."""
    bounds = np.empty((len(first), 6), boxes.dtype)
    leaves = np.flatnonzero(left < 0)
    leaves = leaves[np.argsort(first[leaves], kind="stable")]
    bounds[leaves] = np.minimum.reduceat(boxes, first[leaves], axis=0)
    ends = np.cumsum(level_sizes)
    for level in range(len(level_sizes) - 2, -1, -1):
        nodes = np.arange(ends[level] - level_sizes[level], ends[level])
        nodes = nodes[left[nodes] >= 0]
        child = left[nodes]
        bounds[nodes] = np.minimum(bounds[child], bounds[child + 1])
    return bounds
