"""Rays as they are cast: checked, started near the scene, and sorted into chunks that go the same way from close by."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .clusters import spread_bits
from .columns import dot_rows

if TYPE_CHECKING:
    from .bvh import Bvh

__all__ = ["Frame", "Nearest", "Rays"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_CHUNK = 65536
"""Rays handed on together; a 16-bit number tells them apart."""

_CELL_BITS = 8
"""Rays are sorted by the cell of their origin, of 2**8 along each axis."""

_LARGEST_RECIPROCAL = 1e18
"""Stands for 1/0 in slab tests; keeps products finite in float32 at every scale the scene may have."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A chunk of rays of one direction class.

    Planes entered and left, and the axes: two across and the one along which the direction is largest.

    References
    ----------
    Own design.
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
    backwards: list[bool]  # per axis

    def __len__(self) -> int:
        return len(self.t_max)

    def take(self, index: Integers) -> Frame:
        """Give some of the rays.

        Parameters
        ----------
        index : (m,) ndarray of int64
            Their numbers within the chunk.

        Returns
        -------
        Frame
            A smaller chunk.

        Raises
        ------
        IndexError
            By numpy, if a number is out of range.

        References
        ----------
        Own design.
        """
        return replace(
            self,
            origin=[np.take(o, index) for o in self.origin],
            shear_x=np.take(self.shear_x, index),
            shear_y=np.take(self.shear_y, index),
            reciprocal=[np.take(r, index) for r in self.reciprocal],
            t_max=np.take(self.t_max, index),
            own=None if self.own is None else np.take(self.own, index),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """The nearest hits of a chunk so far.

    References
    ----------
    Own design.
    """

    distance: Array
    triangle: Integers
    u: Array
    v: Array

    @classmethod
    def before(cls, t_max: Array) -> Nearest:
        """Start with no hits.

        Parameters
        ----------
        t_max : (n,) ndarray
            Distances from which on nothing counts.

        Returns
        -------
        Nearest
            Triangle -1 throughout.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return cls(t_max.copy(), np.full(len(t_max), -1), np.zeros_like(t_max), np.zeros_like(t_max))

    def keep(self, ray: Integers, triangle: Integers, distance: Array, u: Array, v: Array) -> None:
        """Write hits that are nearer, or as near with a lower number; several of one ray may compete.

        Parameters
        ----------
        ray : (h,) ndarray of int64
            Numbers of the rays within the chunk.
        triangle : (h,) ndarray of int64
            What they meet.
        distance, u, v : (h,) ndarray
            Where.

        Raises
        ------
        IndexError
            By numpy, if a ray's number is out of range.

        References
        ----------
        Own design.
        """
        while len(ray):
            held, holder = np.take(self.distance, ray), np.take(self.triangle, ray)
            better = (distance < held) | ((distance == held) & ((triangle < holder) | (holder < 0)))
            wins = np.flatnonzero(better)
            ray, triangle, distance = np.take(ray, wins), np.take(triangle, wins), np.take(distance, wins)
            u, v = np.take(u, wins), np.take(v, wins)
            # Of equal rays the last one writes; the others look again at what it left.
            self.distance[ray], self.triangle[ray] = distance, triangle
            self.u[ray], self.v[ray] = u, v
            again = np.flatnonzero(np.take(self.triangle, ray) != triangle)
            ray, triangle, distance = np.take(ray, again), np.take(triangle, again), np.take(distance, again)
            u, v = np.take(u, again), np.take(v, again)


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """Rays checked, cast and started near the scene; coordinates are (3, N).

    References
    ----------
    Own design.
    """

    origins: Array
    directions: Array
    start: Array | None  # distance along the ray at which `origins` lie, None for 0 throughout
    t_max: Array | None
    own: Integers | None

    @classmethod
    def prepare(
        cls, bvh: Bvh, origins: Array, directions: Array, t_max: Array | float | None, own: Integers | None
    ) -> Rays:
        """Check rays and bring them near the scene.

        Parameters
        ----------
        bvh : Bvh
            The tree they are for.
        origins, directions : (N, 3) array_like
            Rays in recentred coordinates.
        t_max : (N,) array_like or float or None
            End of each ray.
        own : (N,) ndarray of int64 or None
            A triangle each ray does not see.

        Returns
        -------
        Rays
            In the tree's dtype.

        Raises
        ------
        ValueError
            If the arrays' shapes do not fit together.

        References
        ----------
        Own design.
        """
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
            squared = dot_rows(d, d)
            middle = -dot_rows(o, d) / squared
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

    def chunks(self, bvh: Bvh) -> Iterator[tuple[Integers, Frame]]:
        """Sort the rays by direction class, then by where they start.

        Parameters
        ----------
        bvh : Bvh
            The tree.

        Yields
        ------
        number : (n,) ndarray of int64
            Numbers of some rays.
        frame : Frame
            Those rays. Rays that start close together follow each other.

        Returns
        -------
        iterator of tuple
            The chunks.

        Raises
        ------
        None.

        References
        ----------
        Curve: Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM (1966).
        """
        if not len(bvh.leaf_triangles):
            return
        dx, dy, dz = self.directions
        ax, ay, az = np.abs(dx), np.abs(dy), np.abs(dz)
        group = (dx < 0.0).astype(np.uint8)
        for bit, condition in enumerate((dy < 0.0, dz < 0.0, ay > ax), start=1):
            group |= condition.astype(np.uint8) << np.uint8(bit)
        group[az > np.maximum(ax, ay)] &= np.uint8(7)
        group[az > np.maximum(ax, ay)] |= np.uint8(16)
        # By cell, then by class: numpy's stable sort of 16 bits counts instead of comparing.
        cell = self._cells()
        order = np.argsort(cell.astype(np.uint16), kind="stable")
        high = (cell >> 16).astype(np.uint16)
        high |= group.astype(np.uint16) << np.uint16(3 * _CELL_BITS - 16)
        order = np.take(order, np.argsort(np.take(high, order), kind="stable"))
        boundary = np.concatenate([[0], np.cumsum(np.bincount(group, minlength=24))])
        for code in range(24):
            for begin in range(boundary[code], boundary[code + 1], _CHUNK):
                number = order[begin : min(begin + _CHUNK, boundary[code + 1])]
                yield number, self._frame(bvh, number, code)

    def _cells(self) -> Integers:
        """Where on a space-filling curve the rays start."""
        spread = spread_bits(np.arange(1 << _CELL_BITS))
        least = self.origins.min(axis=1, initial=np.inf)
        extent = float((self.origins.max(axis=1, initial=-np.inf) - least).max())
        scale = ((1 << _CELL_BITS) - 0.01) / extent if extent > 0.0 else 0.0
        cell = np.zeros(len(self), np.int64)
        for axis in range(3):
            place = ((self.origins[axis] - least[axis]) * self.origins.dtype.type(scale)).astype(np.int64)
            cell |= np.take(spread, place, mode="clip") << (2 - axis)
        return cell

    def _frame(self, bvh: Bvh, number: Integers, code: int) -> Frame:
        along = code >> 3
        across_x, across_y = (along + 1) % 3, (along + 2) % 3
        backwards = [bool(code >> axis & 1) for axis in range(3)]
        direction = [np.take(d, number) for d in self.directions]
        origin = [np.take(o, number) for o in self.origins]
        with np.errstate(divide="ignore", over="ignore"):
            reciprocal = [np.clip(1.0 / d, -_LARGEST_RECIPROCAL, _LARGEST_RECIPROCAL) for d in direction]
            shear_x, shear_y = direction[across_x] / direction[along], direction[across_y] / direction[along]
        return Frame(
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
            backwards=backwards,
        )
