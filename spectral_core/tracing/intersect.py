"""Casting rays through a :class:`~.bvh.Bvh` in whole arrays.

Rays are grouped by the signs of their direction and its largest component. Within a group the near and far planes of
every box and the axis of projection are known, so that no choice is made per ray. A queue of (ray, node) pairs is
worked off in blocks; pairs that reach a leaf are collected, sorted by ray and entry distance, and tested in rounds: in
round k every ray that may still find something nearer tests its k-th leaf.

Triangles are tested in a frame in which the ray is the z axis. Edge functions are exactly antisymmetric there, so
that no ray slips between two triangles that share an edge, and no epsilon is needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .hits import Hits

if TYPE_CHECKING:
    from .bvh import Bvh

__all__ = ["closest", "occluded"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_CHUNK = 16384
"""Rays worked on together: small enough that their tables stay in the second-level cache."""

_BLOCK = 8192
"""(ray, node) pairs, or (ray, leaf) pairs, tested in one go."""

_LARGEST_RECIPROCAL = 1e18
"""Stands for 1/0 in slab tests; keeps products finite in float32 at every scale the scene may have."""


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
    rays = _Rays.prepare(bvh, origins, directions, t_max, own)
    count = len(rays)
    hits = Hits(
        np.full(count, np.inf, bvh.dtype), np.full(count, -1), np.zeros(count, bvh.dtype), np.zeros(count, bvh.dtype)
    )
    for number, frame in rays.chunks(bvh):
        nearest = _Nearest.before(frame.t_max)
        with np.errstate(all="ignore"):
            _test_leaves(bvh, frame, nearest, *_find_leaves(bvh, frame), stop_at_first=False)
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
    rays = _Rays.prepare(bvh, origins, directions, t_max, own)
    result = np.zeros(len(rays), bool)
    for number, frame in rays.chunks(bvh):
        nearest = _Nearest.before(frame.t_max)
        with np.errstate(all="ignore"):
            _test_leaves(bvh, frame, nearest, *_find_leaves(bvh, frame), stop_at_first=True)
        result[number] = nearest.triangle >= 0
    return result


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    """A chunk of rays of one direction class.

    Planes entered and left, and the axes: two across and the one along which the direction is largest.
    """

    near: list[Array]
    far: list[Array]
    across_x: int
    across_y: int
    along: int
    origin: list[Array]  # three (n,)
    shear_x: Array  # d[x] / d[along]
    shear_y: Array
    reciprocal: list[Array]  # three (n,)
    t_max: Array
    own: Integers | None


@dataclass(frozen=True, slots=True, eq=False)
class _Nearest:
    """The nearest hits of a chunk so far."""

    distance: Array
    triangle: Integers
    u: Array
    v: Array

    @classmethod
    def before(cls, t_max: Array) -> _Nearest:
        return cls(t_max.copy(), np.full(len(t_max), -1), np.zeros_like(t_max), np.zeros_like(t_max))


@dataclass(frozen=True, slots=True, eq=False)
class _Rays:
    """Rays checked, cast and started near the scene; coordinates are (3, N)."""

    origins: Array
    directions: Array
    start: Array | None  # distance along the ray at which `origins` lie, None for 0 throughout
    t_max: Array | None
    own: Integers | None

    @classmethod
    def prepare(
        cls, bvh: Bvh, origins: Array, directions: Array, t_max: Array | float | None, own: Integers | None
    ) -> _Rays:
        origins, directions = np.asarray(origins), np.asarray(directions)
        if origins.ndim != 2 or origins.shape[1:] != (3,) or directions.shape != origins.shape:
            raise ValueError(f"origins and directions must be (N, 3), but are {origins.shape} and {directions.shape}")
        count = len(origins)
        limit = None if t_max is None else np.broadcast_to(np.asarray(t_max, np.float64), (count,))
        if own is not None:
            own = np.broadcast_to(np.asarray(own, np.int64), (count,))
        columns = np.ascontiguousarray(origins.T)
        start = None
        reach = np.maximum(np.maximum(np.abs(columns[0]), np.abs(columns[1])), np.abs(columns[2]))
        distant = np.flatnonzero(reach > 4.0 * bvh.radius)
        if len(distant):
            # Far from the scene the roundings of the origin would dwarf the triangles: step up to it in float64.
            o, d = origins[distant].astype(np.float64), directions[distant].astype(np.float64)
            squared = np.einsum("ij,ij->i", d, d)
            middle = -np.einsum("ij,ij->i", o, d) / squared
            start = np.zeros(count)
            start[distant] = np.maximum(middle - 2.0 * bvh.radius / np.sqrt(squared), 0.0)
            columns = columns.astype(np.float64)
            columns[:, distant] = (o + start[distant][:, None] * d).T
            if limit is not None:
                limit = limit - start
        return cls(
            columns.astype(bvh.dtype, copy=False),
            np.add(directions.T, 0.0, dtype=bvh.dtype, order="C"),  # and no -0: the sign of a reciprocal must be known
            None if start is None else start.astype(bvh.dtype),
            None if limit is None else limit.astype(bvh.dtype),
            own,
        )

    def __len__(self) -> int:
        return self.origins.shape[1]

    def chunks(self, bvh: Bvh) -> Iterator[tuple[Integers, _Frame]]:
        """Rays by direction class, in chunks; with the numbers of the rays."""
        if not len(bvh.leaf_triangles):
            return
        dx, dy, dz = self.directions
        ax, ay, az = np.abs(dx), np.abs(dy), np.abs(dz)
        group = (dx < 0.0).astype(np.uint8)
        for bit, condition in enumerate((dy < 0.0, dz < 0.0, ay > ax), start=1):
            group |= condition.astype(np.uint8) << np.uint8(bit)
        group[az > np.maximum(ax, ay)] &= np.uint8(7)
        group[az > np.maximum(ax, ay)] |= np.uint8(16)
        order = np.argsort(group, kind="stable")
        boundary = np.concatenate([[0], np.cumsum(np.bincount(group, minlength=24))])
        for code in range(24):
            for begin in range(boundary[code], boundary[code + 1], _CHUNK):
                number = order[begin : min(begin + _CHUNK, boundary[code + 1])]
                yield number, self._frame(bvh, number, code)

    def _frame(self, bvh: Bvh, number: Integers, code: int) -> _Frame:
        along = code >> 3
        across_x, across_y = (along + 1) % 3, (along + 2) % 3
        backwards = [bool(code >> axis & 1) for axis in range(3)]
        direction = [np.take(d, number) for d in self.directions]
        origin = [np.take(o, number) for o in self.origins]
        with np.errstate(divide="ignore", over="ignore"):
            reciprocal = [np.clip(1.0 / d, -_LARGEST_RECIPROCAL, _LARGEST_RECIPROCAL) for d in direction]
            shear_x, shear_y = direction[across_x] / direction[along], direction[across_y] / direction[along]
        return _Frame(
            near=[(bvh.upper if backwards[axis] else bvh.lower)[axis] for axis in range(3)],
            far=[(bvh.lower if backwards[axis] else bvh.upper)[axis] for axis in range(3)],
            across_x=across_x,
            across_y=across_y,
            along=along,
            origin=origin,
            shear_x=shear_x,
            shear_y=shear_y,
            reciprocal=reciprocal,
            t_max=np.full(len(number), np.inf, bvh.dtype) if self.t_max is None else self.t_max[number],
            own=None if self.own is None else self.own[number],
        )


def _find_leaves(bvh: Bvh, frame: _Frame) -> tuple[Integers, Integers, Array]:
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
    frame: _Frame, origin: list[Array], reciprocal: list[Array], limit: Array, ray: Integers, node: Integers
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
    bvh: Bvh, frame: _Frame, nearest: _Nearest, ray: Integers, leaf: Integers, entry: Array, *, stop_at_first: bool
) -> None:
    """Test rays against the leaves they enter, nearest first, until none can hold anything nearer."""
    if not len(ray):
        return
    order = _by_ray_and_entry(ray, entry, len(nearest.triangle))
    ray, leaf, entry = np.take(ray, order), np.take(leaf, order), np.take(entry, order)
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


def _by_ray_and_entry(ray: Integers, entry: Array, rays: int) -> Integers:
    """Order pairs by ray, then by entry distance as exactly as one sorted integer allows."""
    pair_bits, ray_bits = len(ray).bit_length(), rays.bit_length()
    entry_bits = min(63 - pair_bits - ray_bits, 31)
    # The bits of non-negative floats grow with their value.
    grade = entry.astype(np.float32).view(np.int32).astype(np.int64) >> (31 - entry_bits)
    packed = np.sort(((ray << entry_bits | grade) << pair_bits) | np.arange(len(ray)))
    return packed & ((1 << pair_bits) - 1)


def _test_triangles(
    bvh: Bvh, frame: _Frame, tables: list[Array], nearest: _Nearest, ray: Integers, leaf: Integers
) -> None:
    """Test each ray against the four triangles of its leaf and keep what is nearer; a ray occurs once."""
    ox, oy, oz = (np.take(tables[k], ray, axis=0) for k in range(3))
    shear_x, shear_y = np.take(tables[3], ray, axis=0), np.take(tables[4], ray, axis=0)
    x, y, z = [], [], []
    for corner in (0, 3, 6):
        cx, cy, cz = (
            np.take(bvh.leaf_corners[corner + axis], leaf, axis=0)
            for axis in (frame.across_x, frame.across_y, frame.along)
        )
        cx -= ox
        cy -= oy
        cz -= oz
        cx -= shear_x * cz
        cy -= shear_y * cz
        x.append(cx)
        y.append(cy)
        z.append(cz)
    a = x[2] * y[1]
    a -= y[2] * x[1]
    b = x[0] * y[2]
    b -= y[0] * x[2]
    c = x[1] * y[0]
    c -= y[1] * x[0]
    least, most = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    inside = np.flatnonzero((least >= 0.0) | (most <= 0.0))
    if not len(inside):
        return
    pair = inside >> 2
    triangle = np.take(bvh.leaf_triangles.ravel(), (np.take(leaf, pair) << 2) | (inside & 3))
    ray = np.take(ray, pair)
    a, b, c = (np.take(weight.ravel(), inside) for weight in (a, b, c))
    za, zb, zc = (np.take(height.ravel(), inside) for height in z)
    total = a + b + c
    height = a * za + b * zb + c * zc
    along = frame.reciprocal[frame.along]
    distance = height / total * np.take(along, ray)
    # A triangle seen edge on has total 0 and no finite distance.
    good = (distance > 0.0) & (distance < np.inf) & (distance <= np.take(nearest.distance, ray))
    if frame.own is not None:
        good &= triangle != np.take(frame.own, ray)
    kept = np.flatnonzero(good)
    ray, triangle, distance = np.take(ray, kept), np.take(triangle, kept), np.take(distance, kept)
    scale = 1.0 / np.take(total, kept)
    _keep_nearest(nearest, ray, triangle, distance, np.take(b, kept) * scale, np.take(c, kept) * scale)


def _keep_nearest(nearest: _Nearest, ray: Integers, triangle: Integers, distance: Array, u: Array, v: Array) -> None:
    """Write hits that are nearer, or as near with a lower number; several of one ray may compete."""
    while len(ray):
        held, holder = np.take(nearest.distance, ray), np.take(nearest.triangle, ray)
        better = (distance < held) | ((distance == held) & ((triangle < holder) | (holder < 0)))
        wins = np.flatnonzero(better)
        ray, triangle, distance = np.take(ray, wins), np.take(triangle, wins), np.take(distance, wins)
        u, v = np.take(u, wins), np.take(v, wins)
        # Of equal rays the last one writes; the others look again at what it left.
        nearest.distance[ray], nearest.triangle[ray] = distance, triangle
        nearest.u[ray], nearest.v[ray] = u, v
        again = np.flatnonzero(np.take(nearest.triangle, ray) != triangle)
        ray, triangle, distance = np.take(ray, again), np.take(triangle, again), np.take(distance, again)
        u, v = np.take(u, again), np.take(v, again)
