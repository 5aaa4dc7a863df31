"""The 8-wide bounding volume hierarchy, laid out for gathers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import intersect
from .clusters import cluster
from .geometry import Geometry
from .hits import Hits
from .instancing import instanced_tree
from .sah import BinaryTree, binary_tree, half_area

__all__ = ["Bvh"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

WIDTH = 8
LEAF_SIZE = 4

_CLUSTERED_FROM = 100_000
"""Number of triangles above which the tree is built over small clusters of them: four times as fast, as good to trace
within a tenth."""


_SHARED_FROM = 20_000
"""Number of triangles above which instances that repeat a mesh share the shape of its tree: three times as fast."""


@dataclass(frozen=True, slots=True, eq=False)
class Bvh:
    """A tree of boxes with up to eight children a node and up to four triangles a leaf.

    Rays and results are in recentred coordinates (world minus the geometry's centre).

    Parameters
    ----------
    lower, upper : tuple of three (M, 8) ndarray
        Planes of the children's boxes along x, y and z, widened by a few units in the last place of the scene's
        size; NaN where a child is missing, so that every comparison fails.
    children : (M * 8,) ndarray of int64
        A node's number, or ``-1 - leaf``.
    leaf_triangles : (Q, 4) ndarray of int64
        Triangle numbers, -1 where a leaf is not full.
    leaf_corners : (9, Q, 4) ndarray
        Coordinates of the leaves' triangles: corner 0's x, y, z, then corner 1's and 2's; NaN where not full.
    radius : float
        The geometry's radius.

    References
    ----------
    Wide trees: Wald, Benthin and Boulos, "Getting rid of packets", IEEE Symp. Interactive Ray Tracing (2008).
    """

    lower: tuple[Array, Array, Array]
    upper: tuple[Array, Array, Array]
    children: Integers
    leaf_triangles: Integers
    leaf_corners: Array
    radius: float

    @classmethod
    def build(
        cls,
        geometry: Geometry,
        triangles: Integers | None = None,
        stop_if_cancelled: Callable[[], None] = lambda: None,
    ) -> Bvh:
        """Build the tree.

        Parameters
        ----------
        geometry : Geometry
            The triangles.
        triangles : (S,) ndarray of int64, optional
            Numbers of those to put in; None for all. Hits carry the geometry's numbers either way.
        stop_if_cancelled : callable, optional
            Asked between the steps; raises when the caller wants an end.

        Returns
        -------
        Bvh
            The tree, in the geometry's dtype.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        chosen = np.arange(geometry.triangle_count) if triangles is None else np.asarray(triangles, np.int64)
        corners = geometry.corners if triangles is None else np.take(geometry.corners, chosen, axis=0)
        if not len(corners):
            none = np.full((1, WIDTH), np.nan, geometry.dtype)
            empty = np.zeros((9, 0, LEAF_SIZE), geometry.dtype)
            return cls(
                (none,) * 3, (none,) * 3, np.zeros(WIDTH, np.int64), np.zeros((0, LEAF_SIZE), np.int64), empty, 0.0
            )
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        box_lower, box_upper = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        shared = None
        if triangles is None and len(corners) > _SHARED_FROM:
            shared = instanced_tree(geometry, box_lower, box_upper, LEAF_SIZE, stop_if_cancelled)
        if shared is not None:
            tree, order, first, count = shared, shared.order, shared.first, shared.count
        elif len(corners) > _CLUSTERED_FROM:
            stop_if_cancelled()
            order, begin = cluster(box_lower, box_upper, LEAF_SIZE)
            stop_if_cancelled()
            size = np.diff(begin, append=len(order))
            box_lower = np.minimum.reduceat(np.take(box_lower, order, axis=0), begin, axis=0)
            box_upper = np.maximum.reduceat(np.take(box_upper, order, axis=0), begin, axis=0)
            tree = binary_tree(box_lower, box_upper, 1, stop_if_cancelled)
            # A leaf is one cluster.
            number = np.take(tree.order, np.minimum(tree.first, len(begin) - 1))
            first, count = np.take(begin, number), np.take(size, number)
        else:
            tree = binary_tree(box_lower, box_upper, LEAF_SIZE, stop_if_cancelled)
            order, first, count = tree.order, tree.first, tree.count
        stop_if_cancelled()
        slots = _widen(tree)
        lower, upper, children, leaves = _planes(tree, slots, _margin(geometry))
        rank = np.arange(LEAF_SIZE)
        full = rank < count[leaves][:, None]
        item = order[np.minimum(first[leaves][:, None] + rank, len(corners) - 1)]
        leaf_corners = np.ascontiguousarray(np.moveaxis(corners.reshape(-1, 9)[item], 2, 0))
        leaf_corners[:, ~full] = np.nan
        return cls(lower, upper, children, np.where(full, chosen[item], -1), leaf_corners, geometry.radius)

    @property
    def dtype(self) -> np.dtype[Any]:
        """The working dtype, float32 or float64."""
        return self.leaf_corners.dtype

    def closest(
        self, origins: Array, directions: Array, t_max: Array | float | None = None, own: Integers | None = None
    ) -> Hits:
        """Find the nearest triangle of each ray.

        Parameters
        ----------
        origins, directions : (N, 3) array_like
            Rays in recentred coordinates; directions of any length but zero.
        t_max : (N,) array_like or float, optional
            Distance, in units of the direction, from which on nothing is seen.
        own : (N,) ndarray of int64, optional
            A triangle each ray does not see (the one it leaves); -1 for none.

        Returns
        -------
        Hits
            Of two triangles at the same distance the lower number is given.

        Raises
        ------
        ValueError
            If the arrays' shapes do not fit together.

        References
        ----------
        Own design.
        """
        return intersect.closest(self, origins, directions, t_max, own)

    def occluded(
        self, origins: Array, directions: Array, t_max: Array | float | None = None, own: Integers | None = None
    ) -> NDArray[np.bool_]:
        """Find out whether anything lies on each ray.

        Parameters
        ----------
        origins, directions : (N, 3) array_like
            Rays in recentred coordinates; directions of any length but zero.
        t_max : (N,) array_like or float, optional
            Distance, in units of the direction, from which on nothing counts.
        own : (N,) ndarray of int64, optional
            A triangle each ray does not see (the one it leaves); -1 for none.

        Returns
        -------
        (N,) ndarray of bool
            True where a triangle lies between the origin and `t_max`.

        Raises
        ------
        ValueError
            If the arrays' shapes do not fit together.

        References
        ----------
        Own design.
        """
        return intersect.occluded(self, origins, directions, t_max, own)


def _margin(geometry: Geometry) -> float:
    """How far boxes are widened: the ray test moves points by a few roundings of the scene's size."""
    return float(8.0 * np.finfo(geometry.dtype).eps * geometry.radius)


def _widen(tree: BinaryTree) -> Integers:
    """Choose up to eight descendants for each wide node, (M, 8) of binary nodes with -1 for none.

    Starting from a node's two children, the one with the largest box is replaced by its own two until all slots are
    taken or only leaves are left.
    """
    area = half_area(tree.lower, tree.upper)
    area[tree.left < 0] = -1.0
    front = np.zeros(1, np.int64)
    done: list[Integers] = []
    while len(front):
        slots = np.full((len(front), WIDTH), -1)
        if tree.left[front[0]] < 0:
            slots[:, 0] = front  # the root alone may be a leaf
        else:
            slots[:, 0], slots[:, 1] = tree.left[front], tree.left[front] + 1
        for slot in range(2, WIDTH):
            size = np.where(slots >= 0, area[slots], -1.0)
            widest = size.argmax(axis=1)
            rows = np.flatnonzero(np.take_along_axis(size, widest[:, None], axis=1)[:, 0] >= 0.0)
            opened = tree.left[slots[rows, widest[rows]]]
            slots[rows, widest[rows]] = opened
            slots[rows, slot] = opened + 1
        done.append(slots)
        front = slots[slots >= 0]
        front = front[tree.left[front] >= 0]
    return np.concatenate(done)


def _planes(
    tree: BinaryTree, slots: Integers, margin: float
) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array], Integers, Integers]:
    """Box planes per axis, child codes and the binary numbers of the leaves."""
    used = slots >= 0
    is_leaf = used & (tree.left[slots] < 0)
    inner = slots[used & ~is_leaf]
    wide = np.full(len(tree.left), -1)
    wide[inner] = np.arange(1, len(inner) + 1)  # breadth first, as _widen made them
    leaves = slots[is_leaf]
    wide[leaves] = -1 - np.arange(len(leaves))
    children = np.where(used, wide[slots], 0).ravel()
    nan = tree.lower.dtype.type(np.nan)
    step = tree.lower.dtype.type(margin)
    lower = [np.where(used, tree.lower[slots, axis] - step, nan) for axis in range(3)]
    upper = [np.where(used, tree.upper[slots, axis] + step, nan) for axis in range(3)]
    return (lower[0], lower[1], lower[2]), (upper[0], upper[1], upper[2]), children, leaves
