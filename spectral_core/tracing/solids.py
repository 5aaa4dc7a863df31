"""Which triangles an eye or a light need not look at, because others that it looks at hide the same.

A closed surface is left as often as it is entered. Whoever stands outside sees its front first, and a point outside
that it hides from a light outside is hidden by a side that faces away from the light too. So half of its triangles are
enough, and for lights it is the half that few points lie behind. A wall that has the whole scene before it hides
nothing from a light on the same side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .camera import Camera
from .geometry import Geometry

__all__ = ["AWAY", "BOTH", "TOWARDS", "Solids", "sight_box"]

Array = NDArray[Any]
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bytes = NDArray[np.uint8]

TOWARDS = 1
"""Bit of the triangles whose outside faces the eye."""

AWAY = 2
"""Bit of those whose inside does."""

BOTH = TOWARDS | AWAY

_PARTS = 0.05
"""Parts per triangle above which triangles are not taken to be apart for having vertices of their own."""

_EDGE_ON = 1e-5
"""Height of the eye over a triangle's plane, in sizes of the scene, up to which it counts as seen edge on."""

_WALLS = 512
"""How many of the largest triangles are tried as walls of the scene."""

_FEW = 1024
"""Vertices that most of them are refuted with."""

_MARGIN = 4.0
"""Roundings of the scene's size by which a vertex may lie behind a wall: points are lifted off surfaces by as many."""


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """The closed parts of a geometry and the walls around it.

    A part is a run of triangles that shares no vertex number with the others: an instance, or a piece of one whose
    vertices and triangles are numbered together, as joined meshes are. Where hardly any triangles share numbers, an
    instance is one part.

    Parameters
    ----------
    first : (P + 1,) ndarray of int64
        First triangle of each part, and the number of triangles.
    closed : (P,) ndarray of bool
        Whether every edge is run through as often one way as the other, after vertices at one place are taken for one.
    outward : (P,) ndarray of bool
        Whether the triangles' outsides are those of the solid, by the sign of its volume.
    lower, upper : (P, 3) ndarray
        Boxes around the parts.
    offsets : (T,) ndarray
        Height of each triangle's plane over the centre, along its normal.
    walls : (T,) ndarray of uint8
        The bits `TOWARDS` and `AWAY` that a light has to look at, wherever it is: one is missing if the whole scene
        lies on that side of the triangle's plane.

    References
    ----------
    Own design.
    """

    first: Integers
    closed: NDArray[np.bool_]
    outward: NDArray[np.bool_]
    lower: Array
    upper: Array
    offsets: Array
    walls: Bytes

    @classmethod
    def of(cls, geometry: Geometry) -> Solids:
        """Find the closed parts of a geometry, in time linear in its triangles.

        Parameters
        ----------
        geometry : Geometry
            The triangles.

        Returns
        -------
        Solids
            Its parts.

        Raises
        ------
        None.

        References
        ----------
        Signed volume: Zhang and Chen, "Efficient feature extraction for 2D/3D objects in mesh representation", IEEE
        ICIP (2001). That a surface is closed is told from a sum of random numbers, one for each way along an edge, that
        is 0 for any closed one and for others once in 2**60 times: after Schwartz, J. ACM 27(4), 701-717 (1980).
        """
        first = _runs(geometry.triangles)
        if len(first) > max(_PARTS * geometry.triangle_count, 1):
            turns = np.flatnonzero(np.diff(geometry.instance_index)) + 1
            first = np.concatenate([[0], turns, [geometry.triangle_count]])
        if len(first) == 1:
            none = np.zeros(0, bool)
            nowhere, nothing = np.zeros((0, 3)), np.zeros(0, geometry.dtype)
            return cls(first, none, none, nowhere, nowhere, nothing, np.zeros(0, np.uint8))
        start = first[:-1]
        columns = [np.ascontiguousarray(geometry.triangles[:, k]) for k in range(3)]
        boundary = _boundary(geometry.vertices, columns)
        closed = np.add.reduceat(boundary, start) == 0
        corners = [[np.take(coordinate, column) for column in columns] for coordinate in geometry.vertices.T]
        (ax, bx, cx), (ay, by, cy), (az, bz, cz) = corners
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        outward = np.add.reduceat(volume, start, dtype=np.float64) >= 0.0
        low = [np.minimum.reduceat(np.minimum(np.minimum(a, b), c), start) for a, b, c in corners]
        high = [np.maximum.reduceat(np.maximum(np.maximum(a, b), c), start) for a, b, c in corners]
        lower, upper = np.stack(low, axis=1), np.stack(high, axis=1)
        offsets = np.einsum("ij,ij->i", geometry.geometric_normals, geometry.corners[:, 0])
        return cls(first, closed, outward, lower, upper, offsets, _walls(geometry))

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Opposite corners of the box around all parts; the centre where there are none."""
        if not len(self.lower):
            return np.zeros(3), np.zeros(3)
        return self.lower.min(axis=0), self.upper.max(axis=0)

    def towards_eye(self, geometry: Geometry, box: tuple[ArrayLike, ArrayLike]) -> Bytes:
        """Sides of the triangles that an eye has to look at to find what it meets first.

        Parameters
        ----------
        geometry : Geometry
            The triangles.
        box : pair of (3,) array_like
            Opposite corners of a box in which every line of sight begins; see :func:`sight_box`.

        Returns
        -------
        (T,) ndarray of uint8
            `TOWARDS`, `AWAY` or both for each triangle.

        Raises
        ------
        ValueError
            By numpy, if a corner has not three coordinates.

        References
        ----------
        Own design.
        """
        bits = np.where(self.outward, np.uint8(TOWARDS), np.uint8(AWAY))
        bits[~self._outside(geometry, box)] = BOTH
        return np.repeat(bits, np.diff(self.first))

    def towards_light(
        self, geometry: Geometry, box: tuple[ArrayLike, ArrayLike] | None, position: ArrayLike | None
    ) -> Bytes:
        """Sides of the triangles that a light has to look at to find out which points they hide.

        Parameters
        ----------
        geometry : Geometry
            The triangles.
        box : pair of (3,) array_like or None
            Opposite corners of a box in which the lines of sight begin that lead to the points, without crossing a
            surface though perhaps by way of mirrors. None if nothing is known of the points but that they lie on
            surfaces.
        position : (3,) array_like of float or None
            Where the light is; None for one infinitely far.

        Returns
        -------
        (T,) ndarray of uint8
            `TOWARDS`, `AWAY` or both for each triangle, or 0.

        Raises
        ------
        ValueError
            By numpy, if a position has not three coordinates.

        References
        ----------
        Own design.
        """
        if box is None:
            return self.walls
        bits = np.where(self.outward, np.uint8(AWAY), np.uint8(TOWARDS))
        apart = self._outside(geometry, box)
        if position is not None:
            apart &= self._outside(geometry, (position, position))
        bits[~apart] = BOTH
        return np.repeat(bits, np.diff(self.first)) & self.walls

    def seen(self, geometry: Geometry, sides: Bytes, eye: Floats | None, towards: Floats | None = None) -> Integers:
        """Leave out the triangles that surely show an eye none of the sides it looks at.

        Those nearly edge on stay: which way they face is for the rounded screen to tell.

        Parameters
        ----------
        geometry : Geometry
            The triangles.
        sides : (T,) ndarray of uint8
            The sides to look at.
        eye : (3,) ndarray of float64 or None
            Where the eye is; None for one infinitely far.
        towards : (3,) ndarray of float64, optional
            Unit vector to an eye that is infinitely far.

        Returns
        -------
        (S,) ndarray of int64
            Numbers of the other triangles, increasing.

        Raises
        ------
        ValueError
            By numpy, if a position has not three coordinates.

        References
        ----------
        Own design.
        """
        if eye is None:
            height, margin = geometry.geometric_normals @ np.asarray(towards, geometry.dtype), _EDGE_ON
        else:
            height = geometry.geometric_normals @ eye.astype(geometry.dtype)
            height -= self.offsets
            margin = _EDGE_ON * float(geometry.radius + np.abs(eye).max())
        shown = (height > -margin).view(np.uint8) * np.uint8(TOWARDS)
        shown |= (height < margin).view(np.uint8) * np.uint8(AWAY)
        shown &= sides
        return np.flatnonzero(shown)

    def shining_sides(self, geometry: Geometry, triangles: Integers) -> Bytes:
        """Sides of glowing triangles that anything but the triangles' own solid can see.

        Parameters
        ----------
        geometry : Geometry
            The triangles.
        triangles : (S,) ndarray of int64
            Numbers of those that glow.

        Returns
        -------
        (S,) ndarray of uint8
            `TOWARDS` where the side that the normal points to is seen, `AWAY` where the other is, or both. Of a closed
            part that stops light and that no other triangle's box touches it is the outer one.

        Raises
        ------
        IndexError
            By numpy, if there is no such triangle.

        References
        ----------
        Own design.
        """
        part = np.searchsorted(self.first, triangles, side="right") - 1
        sides = np.full(len(self.closed), BOTH, np.uint8)
        for p in np.unique(part):
            if self.closed[p] and geometry.shadow_visible[self.first[p]] and self._is_alone(geometry, p):
                sides[p] = TOWARDS if self.outward[p] else AWAY
        return sides[part]

    def _is_alone(self, geometry: Geometry, part: int) -> bool:
        """Whether no triangle of another part has a box that touches a part's."""
        box = self.lower[part], self.upper[part]
        near = np.flatnonzero(_touching(self.lower, self.upper, *box))
        for other in near[near != part]:
            corners = geometry.corners[self.first[other] : self.first[other + 1]]
            if _touching(corners.min(axis=1), corners.max(axis=1), *box).any():
                return False
        return True

    def _outside(self, geometry: Geometry, box: tuple[ArrayLike, ArrayLike]) -> NDArray[np.bool_]:
        """Closed parts that everybody sees and that a box is clear of."""
        margin = 16.0 * np.finfo(geometry.dtype).eps * geometry.radius
        lower, upper = (np.asarray(corner, np.float64) for corner in box)
        touches = _touching(self.lower, self.upper, lower - margin, upper + margin)
        # A run lies within one instance, whose triangles are all seen or all hidden.
        start = self.first[:-1]
        whole = geometry.camera_visible[start] & geometry.shadow_visible[start]
        outside: NDArray[np.bool_] = self.closed & whole & ~touches
        return outside


def sight_box(geometry: Geometry, camera: Camera) -> tuple[Floats, Floats]:
    """Box, about the geometry's centre, in which all lines of sight of a camera begin.

    Parameters
    ----------
    geometry : Geometry
        What is looked at.
    camera : Camera
        The camera; rays begin on its near plane, whatever point of the lens they come from. Those that leave the window
        by a tenth, as a pixel filter's may, are included.

    Returns
    -------
    lower, upper : (3,) ndarray of float64
        Opposite corners.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    left, right, bottom, top = camera.window
    more_x, more_y = 0.1 * (right - left), 0.1 * (top - bottom)
    reach = camera.clip_start if camera.kind == "perspective" else 1.0
    corners = np.array(
        [
            (x * reach, y * reach, -camera.clip_start)
            for x in (left - more_x, right + more_x)
            for y in (bottom - more_y, top + more_y)
        ]
    )
    world = corners @ camera.matrix[:3, :3].T + (camera.matrix[:3, 3] - geometry.centre)
    lens = camera.lens_radius * max(1.0, 1.0 / camera.lens_ratio) if camera.has_lens else 0.0
    return world.min(axis=0) - lens, world.max(axis=0) + lens


def _touching(lower: Array, upper: Array, low: Array, high: Array) -> NDArray[np.bool_]:
    """Which of some boxes touch one."""
    return np.asarray(np.all((lower <= high) & (upper >= low), axis=1))


def _runs(triangles: Integers) -> Integers:
    """Where runs of triangles begin that share no vertex number with the triangles before, and their end."""
    if not len(triangles):
        return np.zeros(1, np.int64)
    a, b, c = (triangles[:, k] for k in range(3))
    highest_before = np.maximum.accumulate(np.maximum(np.maximum(a, b), c))[:-1]
    lowest_after = np.minimum.accumulate(np.minimum(np.minimum(a, b), c)[::-1])[::-1][1:]
    inner = np.flatnonzero(highest_before < lowest_after) + 1
    return np.concatenate([[0], inner, [len(triangles)]])


def _boundary(vertices: Array, columns: list[Integers]) -> NDArray[np.uint64]:
    """A number for each triangle; those of a surface add up to 0 if and, almost surely, only if it is closed.

    An edge from place p to place q counts r(p) s(q) - r(q) s(p), with r and s scrambled from the coordinates: minus the
    number of the way back.
    """
    bits = np.uint64 if vertices.dtype == np.float64 else np.uint32
    key = np.zeros(len(vertices), np.uint64)
    for axis in range(3):
        coordinate = vertices[:, axis] + vertices.dtype.type(0.0)  # -0 is the same place as 0
        key = _scrambled(key + coordinate.view(bits))
    r, s = key, _scrambled(key)
    ra, rb, rc = (np.take(r, column) for column in columns)
    sa, sb, sc = (np.take(s, column) for column in columns)
    return np.asarray(ra * (sb - sc) + rb * (sc - sa) + rc * (sa - sb), np.uint64)


def _scrambled(key: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Mix bits (splitmix64)."""
    key = key + np.uint64(0x9E3779B97F4A7C15)
    key = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    key = (key ^ (key >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return key ^ (key >> np.uint64(31))


def _walls(geometry: Geometry) -> Bytes:
    """Sides from which each triangle may hide a part of the scene; only the largest are tried."""
    sides = np.full(geometry.triangle_count, BOTH, np.uint8)
    corners, vertices = geometry.corners, geometry.vertices
    edge_b, edge_c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    extent = np.einsum("ij,ij->i", edge_b, edge_b) * np.einsum("ij,ij->i", edge_c, edge_c)
    tried = np.arange(len(sides))
    if len(tried) > _WALLS:
        tried = np.argpartition(extent, len(tried) - _WALLS)[-_WALLS:]
    normal = geometry.geometric_normals[tried].astype(np.float64)
    height = np.einsum("ij,ij->i", normal, corners[tried, 0].astype(np.float64))
    margin = _MARGIN * np.finfo(geometry.dtype).eps * geometry.radius
    for some in (vertices[:: max(len(vertices) // _FEW, 1)], vertices):
        least, most = np.full(len(tried), np.inf), np.full(len(tried), -np.inf)
        for k in range(0, len(some), 4096):
            above = normal @ some[k : k + 4096].T.astype(np.float64) - height[:, None]
            np.minimum(least, above.min(axis=1), out=least)
            np.maximum(most, above.max(axis=1), out=most)
        before, behind = least >= -margin, most <= margin
        kept = np.flatnonzero(before | behind)
        tried, normal, height = tried[kept], normal[kept], height[kept]
    # All before it: what faces the light hides nothing.
    sides[tried] = BOTH & ~(TOWARDS * before[kept] | AWAY * behind[kept])
    return sides
