"""One tree for many instances of a mesh: its shape is found once, and its boxes are drawn anew around each of them.

The tree stays one of world-space boxes: a ray need not be brought into the space of an instance on its way down.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import Geometry
from .sah import BinaryTree, binary_tree

__all__ = ["instanced_tree"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_SAVED = 0.5
"""Part of the triangles that must be repetitions: above the instances the tree is coarser than it could be."""

_SMALLEST = 16
"""Triangles an instance has on average from which on a tree of its own is worth while."""


def instanced_tree(
    geometry: Geometry,
    lower: Array,
    upper: Array,
    leaf_size: int,
    stop_if_cancelled: Callable[[], None] = lambda: None,
) -> BinaryTree | None:
    """Build the tree of a geometry by the instances it is made of, if they repeat meshes.

    Instances whose triangles join their vertices alike share the shape of a tree, found on the first of them; so do
    copies of a mesh that are bent, for which the boxes are as tight and the tree a little less well cut.

    Parameters
    ----------
    geometry : Geometry
        The triangles.
    lower, upper : (T, 3) ndarray
        Their boxes.
    leaf_size : int
        Largest number of triangles in a leaf.
    stop_if_cancelled : callable, optional
        Asked between instances; raises when the caller wants an end.

    Returns
    -------
    BinaryTree or None
        The tree; None if too little repeats.

    Raises
    ------
    None.

    References
    ----------
    Own design; refitting: Wald, Boulos and Shirley, "Ray tracing deformable scenes using dynamic bounding volume
    hierarchies", ACM Trans. Graphics 26(1) (2007).
    """
    begin = np.flatnonzero(np.diff(geometry.instance_index, prepend=-1))
    size = np.diff(begin, append=geometry.triangle_count)
    if len(begin) < 2 or geometry.triangle_count < _SMALLEST * len(begin):
        return None
    groups = _alike(geometry, begin, size)
    distinct = sum(int(size[members[0]]) for members in groups)
    if distinct > (1.0 - _SAVED) * geometry.triangle_count:
        return None
    boxes = np.concatenate([lower, -upper], axis=1)
    trees: list[BinaryTree] = [None] * len(begin)  # type: ignore[list-item]
    for members in groups:
        part = slice(begin[members[0]], begin[members[0]] + size[members[0]])
        shape = binary_tree(lower[part], upper[part], leaf_size, stop_if_cancelled)
        for number in members:
            stop_if_cancelled()
            trees[number] = _refitted(shape, boxes[begin[number] : begin[number] + size[number]])
    return _joined(trees, begin)


def _alike(geometry: Geometry, begin: Integers, size: Integers) -> list[list[int]]:
    """Numbers of the instances, those with equal triangles together."""
    groups: dict[tuple[int, int], list[list[int]]] = {}
    for number, (first, count) in enumerate(zip(begin, size, strict=True)):
        part = geometry.triangles[first : first + count]
        part = part - part[0, 0]
        same = groups.setdefault((len(part), hash(part.tobytes())), [])
        for group in same:
            other = geometry.triangles[begin[group[0]] : begin[group[0]] + count]
            if np.array_equal(part, other - other[0, 0]):
                group.append(number)
                break
        else:
            same.append([number])
    return [group for same in groups.values() for group in same]


def _refitted(shape: BinaryTree, boxes: Array) -> BinaryTree:
    """The same tree over other boxes, (I, 6) with the upper corners negated."""
    bounds = np.empty((len(shape.left), 6), boxes.dtype)
    leaves = np.flatnonzero(shape.left < 0)
    leaves = leaves[np.argsort(shape.first[leaves], kind="stable")]
    bounds[leaves] = np.minimum.reduceat(np.take(boxes, shape.order, axis=0), shape.first[leaves], axis=0)
    for nodes in reversed(_levels(shape.left)):
        child = shape.left[nodes]
        bounds[nodes] = np.minimum(bounds[child], bounds[child + 1])
    return BinaryTree(shape.order, shape.first, shape.count, shape.left, bounds[:, :3], -bounds[:, 3:])


def _levels(left: Integers) -> list[Integers]:
    """Inner nodes, level by level from the root."""
    levels = []
    nodes = np.zeros(1, np.int64)
    while len(nodes := nodes[left[nodes] >= 0]):
        levels.append(nodes)
        nodes = np.stack([left[nodes], left[nodes] + 1], axis=1).ravel()
    return levels


def _joined(trees: list[BinaryTree], begin: Integers) -> BinaryTree:
    """One tree above many; `begin` is where the items of each are numbered from."""
    roots = [np.array([getattr(tree, end)[0] for tree in trees]) for end in ("lower", "upper")]
    top = binary_tree(roots[0], roots[1], 1)
    sequence = [trees[number] for number in top.order]
    items = np.cumsum([0, *(len(tree.order) for tree in sequence)])
    nodes = len(top.left) + np.cumsum([0, *(len(tree.left) - 1 for tree in sequence)])
    first, count = items[top.first], items[top.first + top.count] - items[top.first]
    left, lower, upper = top.left.copy(), top.lower.copy(), top.upper.copy()
    leaf_of = np.flatnonzero(top.left < 0)
    leaf_of = leaf_of[np.argsort(top.first[leaf_of])]
    columns: list[list[Array]] = [[first], [count], [left], [lower], [upper]]
    for place, tree in enumerate(sequence):
        # The root takes the place of the leaf; its descendants are put behind, all of them moved alike.
        moved = np.where(tree.left >= 0, tree.left + (nodes[place] - 1), -1)
        left[leaf_of[place]] = moved[0]
        for column, values in zip(
            columns, (tree.first + items[place], tree.count, moved, tree.lower, tree.upper), strict=True
        ):
            column.append(values[1:])
    order = np.concatenate([tree.order + begin[number] for tree, number in zip(sequence, top.order, strict=True)])
    return BinaryTree(order, *(np.concatenate(column) for column in columns))
