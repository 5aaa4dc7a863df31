"""A binary tree over boxes by the surface area heuristic, built level by level in whole arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["BinaryTree", "binary_tree", "half_area"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_BINS = 16


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


def binary_tree(lower: Array, upper: Array, leaf_size: int) -> BinaryTree:
    """Split boxes until at most `leaf_size` share a node.

    Every level is split at once: the items of all its large nodes are put into 16 bins along the longest axis of
    their node's centroids, and each node is cut where area times count is least. Nodes whose centroids coincide are
    halved.

    Parameters
    ----------
    lower, upper : (I, 3) ndarray
        Boxes of the items, at least one.
    leaf_size : int
        Largest number of items in a leaf, at least 1.

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
    centroids = 0.5 * (lower + upper)
    order = np.arange(len(lower))
    levels = [(np.zeros(1, np.int64), np.array([len(lower)]))]
    lefts: list[Integers] = []
    nodes = 1
    while True:
        first, count = levels[-1]
        left = np.full(len(first), -1)
        lefts.append(left)
        large = np.flatnonzero(count > leaf_size)
        if not len(large):
            break
        first, count = first[large], count[large]
        in_left = _split(order, first, count, lower, upper, centroids)
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
    node_lower, node_upper = _enclose(order, first, left, lower, upper, [len(level[0]) for level in levels])
    return BinaryTree(order, first, count, left, node_lower, node_upper)


def _split(order: Integers, first: Integers, count: Integers, lower: Array, upper: Array, centroids: Array) -> Integers:
    """Sort the items of each node by its bins, in place; return how many go to the left child."""
    nodes = len(first)
    start = np.cumsum(count) - count
    owner = np.repeat(np.arange(nodes), count)
    place = np.arange(len(owner)) + np.repeat(first - start, count)
    items = order[place]
    centre = np.take(centroids, items, axis=0)
    least = np.minimum.reduceat(centre, start, axis=0)
    extent = np.maximum.reduceat(centre, start, axis=0) - least
    axis = extent.argmax(axis=1)
    rows = np.arange(nodes)
    span = extent[rows, axis]
    scale = np.where(span > 0.0, (_BINS * 0.9999) / np.where(span > 0.0, span, 1.0), 0.0)
    along = centre.ravel()[3 * np.arange(len(owner)) + np.take(axis, owner)]
    along -= np.take(least[rows, axis], owner)
    bins = np.minimum((along * np.take(scale, owner)).astype(np.int64), _BINS - 1)

    # Key and position share one integer, so that a plain sort is stable and gives the permutation.
    bits = len(owner).bit_length()
    packed = np.sort((owner * _BINS + bins) << bits | np.arange(len(owner)))
    key = packed >> bits
    items = np.take(items, packed & ((1 << bits) - 1))
    order[place] = items

    population = np.bincount(key, minlength=nodes * _BINS).reshape(nodes, _BINS)
    begin = np.flatnonzero(np.diff(key, prepend=-1))
    bin_lower = np.full((nodes * _BINS, 3), np.inf, lower.dtype)
    bin_upper = np.full((nodes * _BINS, 3), -np.inf, lower.dtype)
    bin_lower[key[begin]] = np.minimum.reduceat(np.take(lower, items, axis=0), begin, axis=0)
    bin_upper[key[begin]] = np.maximum.reduceat(np.take(upper, items, axis=0), begin, axis=0)
    cost = _cut_costs(bin_lower.reshape(nodes, _BINS, 3), bin_upper.reshape(nodes, _BINS, 3), population)
    cut = cost.argmin(axis=1)
    in_left = np.take_along_axis(population.cumsum(axis=1), cut[:, None], axis=1)[:, 0]
    return np.where(np.isfinite(cost[rows, cut]), in_left, count // 2)


def _cut_costs(lower: Array, upper: Array, population: Integers) -> Array:
    """Area times count of both sides for every cut behind a bin, infinite where a side is empty."""

    def sweep(low: Array, high: Array, number: Integers) -> tuple[Array, Integers]:
        area = half_area(np.minimum.accumulate(low, axis=1), np.maximum.accumulate(high, axis=1))
        return area[:, :-1], number.cumsum(axis=1)[:, :-1]

    with np.errstate(invalid="ignore", over="ignore"):
        area_left, left = sweep(lower, upper, population)
        area_right, right = sweep(lower[:, ::-1], upper[:, ::-1], population[:, ::-1])
        area_right, right = area_right[:, ::-1], right[:, ::-1]
        return np.where((left > 0) & (right > 0), area_left * left + area_right * right, np.inf)


def _enclose(
    order: Integers, first: Integers, left: Integers, lower: Array, upper: Array, level_sizes: list[int]
) -> tuple[Array, Array]:
    """Boxes of all nodes: leaves from their items, then parents from their children, deepest level first."""
    node_lower = np.empty((len(first), 3), lower.dtype)
    node_upper = np.empty_like(node_lower)
    leaves = np.flatnonzero(left < 0)
    leaves = leaves[np.argsort(first[leaves], kind="stable")]
    node_lower[leaves] = np.minimum.reduceat(np.take(lower, order, axis=0), first[leaves], axis=0)
    node_upper[leaves] = np.maximum.reduceat(np.take(upper, order, axis=0), first[leaves], axis=0)
    ends = np.cumsum(level_sizes)
    for level in range(len(level_sizes) - 2, -1, -1):
        nodes = np.arange(ends[level] - level_sizes[level], ends[level])
        nodes = nodes[left[nodes] >= 0]
        child = left[nodes]
        node_lower[nodes] = np.minimum(node_lower[child], node_lower[child + 1])
        node_upper[nodes] = np.maximum(node_upper[child], node_upper[child + 1])
    return node_lower, node_upper
