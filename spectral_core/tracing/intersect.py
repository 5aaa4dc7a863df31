"""Casting rays through a :class:`~.bvh.Bvh` in whole arrays.

Rays are grouped by the signs of their direction and its largest component. Within a group the near and far planes of
every box and the axis of projection are known, so that no choice is made per ray. Neighbouring rays go in packets
(packets.py) as long as they stay together. For the others a queue of (ray, node) pairs is worked off in blocks; pairs
that reach a leaf are collected, sorted by ray and entry distance, and tested in rounds: in round k every ray that may
still find something nearer tests its k-th leaf.

Triangles are tested in a frame in which the ray is the z axis. Edge functions are exactly antisymmetric there, so
that no ray slips between two triangles that share an edge, and no epsilon is needed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .hits import Hits
from .packets import trace_packets
from .ray_triangles import by_ray_and_entry, edge_functions, keep_inside
from .rays import Frame, Nearest, Rays

if TYPE_CHECKING:
    from .bvh import Bvh

__all__ = ["closest", "occluded"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_CHUNK = 16384
"""Rays worked on one by one together: small enough that their tables stay in the second-level cache."""

_BLOCK = 8192
"""(ray, node) pairs, or (ray, leaf) pairs, tested in one go."""


def closest(bvh: Bvh, origins: Array, directions: Array, t_max: Array | float | None, own: Integers | None) -> Hits:
    """Find the nearest triangle of each ray; see :meth:`Bvh.closest`.

    Parameters
    ----------
    bvh : Bvh
        The tree.
    origins, directions : (N, 3) array_like
        Rays in recentred coordinates.
    t_max : (N,) array_like or float or None
        End of each ray.
    own : (N,) ndarray of int64 or None
        A triangle each ray does not see.

    Returns
    -------
    Hits
        The hits.

    Raises
    ------
    ValueError
        If the arrays' shapes do not fit together.

    References
    ----------
    Triangles: Woop, Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2(1), 65-82 (2013). Boxes: Ize,
    "Robust BVH ray traversal", JCGT 2(2), 12-27 (2013).
    """
    rays = Rays.prepare(bvh, origins, directions, t_max, own)
    count = len(rays)
    hits = Hits(
        np.full(count, np.inf, bvh.dtype), np.full(count, -1), np.zeros(count, bvh.dtype), np.zeros(count, bvh.dtype)
    )
    for number, frame in rays.chunks(bvh):
        nearest = _trace(bvh, frame, stop_at_first=False)
        found = np.flatnonzero(nearest.triangle >= 0)
        target = number[found]
        distance = np.take(nearest.distance, found)
        hits.distance[target] = distance if rays.start is None else distance + rays.start[target]
        hits.triangle[target] = nearest.triangle[found]
        hits.u[target] = nearest.u[found]
        hits.v[target] = nearest.v[found]
    return hits


def occluded(
    bvh: Bvh, origins: Array, directions: Array, t_max: Array | float | None, own: Integers | None
) -> NDArray[np.bool_]:
    """Find out whether anything lies on each ray; see :meth:`Bvh.occluded`.

    Parameters
    ----------
    bvh : Bvh
        The tree.
    origins, directions : (N, 3) array_like
        Rays in recentred coordinates.
    t_max : (N,) array_like or float or None
        End of each ray.
    own : (N,) ndarray of int64 or None
        A triangle each ray does not see.

    Returns
    -------
    (N,) ndarray of bool
        True where something lies on the ray.

    Raises
    ------
    ValueError
        If the arrays' shapes do not fit together.

    References
    ----------
    As for :func:`closest`.
    """
    rays = Rays.prepare(bvh, origins, directions, t_max, own)
    result = np.zeros(len(rays), bool)
    for number, frame in rays.chunks(bvh):
        nearest = _trace(bvh, frame, stop_at_first=True)
        result[number] = nearest.triangle >= 0
    return result


def _trace(bvh: Bvh, frame: Frame, *, stop_at_first: bool) -> Nearest:
    """Nearest hits of a chunk, or any."""
    nearest = Nearest.before(frame.t_max)
    with np.errstate(all="ignore"):
        apart = trace_packets(bvh, frame, nearest, stop_at_first=stop_at_first)
        for k in range(0, len(apart), _CHUNK):
            some = apart[k : k + _CHUNK]
            part = frame.take(some)
            found = Nearest.before(part.t_max)
            _test_leaves(bvh, part, found, *_find_leaves(bvh, part), stop_at_first=stop_at_first)
            for name in ("distance", "triangle", "u", "v"):
                getattr(nearest, name)[some] = getattr(found, name)
    return nearest


def _find_leaves(bvh: Bvh, frame: Frame) -> tuple[Integers, Integers, Array]:
    """Walk the tree with all rays of a frame; return (ray, leaf, entry distance) of every leaf box entered."""
    # Rows of eight equal numbers: a row is fetched with one copy and meets a node's eight planes without a broadcast.
    origin = [_rows(o, 8) for o in frame.origin]
    reciprocal = [_rows(r, 8) for r in frame.reciprocal]
    limit = _rows(frame.t_max, 8)
    rays: list[Integers] = []
    leaves: list[Integers] = []
    entries: list[Array] = []
    level = [(np.arange(len(frame.t_max)), np.zeros(len(frame.t_max), np.int64))]
    while level:
        below: list[tuple[Integers, Integers]] = []
        for ray, node in level:
            crossed, entry = _enter_children(frame, origin, reciprocal, limit, ray, node)
            pair = crossed >> 3
            child = np.take(bvh.children, (np.take(node, pair) << 3) | (crossed & 7))
            ray = np.take(ray, pair)
            at_leaf, inside = np.flatnonzero(child < 0), np.flatnonzero(child >= 0)
            rays.append(np.take(ray, at_leaf))
            leaves.append(-1 - np.take(child, at_leaf))
            entries.append(np.take(entry, np.take(crossed, at_leaf)))
            below.append((np.take(ray, inside), np.take(child, inside)))
        ray, node = np.concatenate([r for r, _ in below]), np.concatenate([n for _, n in below])
        level = [(ray[k : k + _BLOCK], node[k : k + _BLOCK]) for k in range(0, len(ray), _BLOCK)]
    return np.concatenate(rays), np.concatenate(leaves), np.concatenate(entries)


def _rows(values: Array, width: int) -> Array:
    """Each value `width` times in a row of its own."""
    return np.repeat(values, width).reshape(-1, width)


def _enter_children(
    frame: Frame, origin: list[Array], reciprocal: list[Array], limit: Array, ray: Integers, node: Integers
) -> tuple[Integers, Array]:
    """Test rays against the eight boxes of their nodes.

    Returns the numbers 8 * pair + child of the boxes entered, and the entry distances of all boxes.
    """
    dtype = limit.dtype
    # Two roundings a plane; the exit distance is lengthened so that a box is never missed for them.
    slack = dtype.type(1.0 + 6.0 * np.finfo(dtype).eps)
    enter = np.zeros((len(ray), 8), dtype)
    leave = np.full((len(ray), 8), np.inf, dtype)
    for axis in range(3):
        o, r = np.take(origin[axis], ray, axis=0), np.take(reciprocal[axis], ray, axis=0)
        plane = np.take(frame.near[axis], node, axis=0)
        plane -= o
        plane *= r
        np.maximum(enter, plane, out=enter)
        plane = np.take(frame.far[axis], node, axis=0)
        plane -= o
        plane *= r
        np.minimum(leave, plane, out=leave)
    leave *= slack
    np.minimum(leave, np.take(limit, ray, axis=0), out=leave)
    return np.flatnonzero(enter <= leave), enter.ravel()


def _test_leaves(
    bvh: Bvh, frame: Frame, nearest: Nearest, ray: Integers, leaf: Integers, entry: Array, *, stop_at_first: bool
) -> None:
    """Test rays against the leaves they enter, nearest first, until none can hold anything nearer."""
    if not len(ray):
        return
    order, entry = by_ray_and_entry(ray, entry)
    ray, leaf = np.take(ray, order), np.take(leaf, order)
    # Rows of four equal numbers meet a leaf's four triangles.
    axes = (frame.across_x, frame.across_y, frame.along)
    tables = [_rows(v, 4) for v in (*(frame.origin[axis] for axis in axes), frame.shear_x, frame.shear_y)]
    turn = np.flatnonzero(np.diff(ray, prepend=-1))
    end = np.append(turn[1:], len(ray))
    while len(turn):
        for k in range(0, len(turn), _BLOCK):
            block = turn[k : k + _BLOCK]
            _test_triangles(bvh, frame, tables, nearest, np.take(ray, block), np.take(leaf, block))
        turn = turn + 1
        left = np.flatnonzero(turn < end)
        turn, end = np.take(turn, left), np.take(end, left)
        owner = np.take(ray, turn)
        if stop_at_first:
            left = np.flatnonzero(np.take(nearest.triangle, owner) < 0)
        else:
            left = np.flatnonzero(np.take(entry, turn) <= np.take(nearest.distance, owner))
        turn, end = np.take(turn, left), np.take(end, left)


def _test_triangles(
    bvh: Bvh, frame: Frame, tables: list[Array], nearest: Nearest, ray: Integers, leaf: Integers
) -> None:
    """Test each ray against the four triangles of its leaf and keep what is nearer; a ray occurs once."""
    of_ray = [np.take(table, ray, axis=0) for table in tables]
    axes = (frame.across_x, frame.across_y, frame.along)
    corners = [np.take(bvh.leaf_corners[corner + axis], leaf, axis=0) for corner in (0, 3, 6) for axis in axes]
    inside, weights, heights = edge_functions(corners, of_ray)
    if len(inside):
        pair = inside >> 2
        triangle = np.take(bvh.leaf_triangles.ravel(), (np.take(leaf, pair) << 2) | (inside & 3))
        keep_inside(frame, nearest, np.take(ray, pair), triangle, weights, heights)
