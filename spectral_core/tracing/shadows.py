"""Which points a light does not reach, exact and without rays: the light looks at the points.

All points are sorted into a grid on the light's screen; every triangle then finds the points in the cells it touches,
and hides those that lie inside its outline and behind its plane. It is no shadow map: nothing is sampled but the points
themselves. A light outside the scene has one screen, one within it the six faces of a cube, a sun a parallel one.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .geometry import Geometry
from .light_screens import LightScreen, face_of, light_projections, touching_faces
from .projection import Projection
from .sample_grid import SampleGrid
from .solids import BOTH, Solids
from .spans import batches, expand, top_to_bottom

__all__ = ["LightView", "occluded_from_direction", "occluded_from_point"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_TRIANGLES = 16384
"""Triangles set up together; their tables stay in the second-level cache."""

_PAIRS = 32768
"""(triangle, row) or (triangle, point) pairs worked on together."""

_HIDDEN_PART = 0.35
"""Part of the points of a grid that must be hidden before it is worth while to sort them out."""

_NARROW = 3.0
"""Width in cells up to which a triangle is taken for its bounding box until its edges are tested."""


class LightView:
    """A light's view of a scene, ready to tell which points are hidden from it.

    The points lie on the scene's surfaces. Make it once for a light and ask it for any number of points: what it knows
    about the triangles is kept. Several threads may ask one view at once; what a point is told does not depend on the
    points it is asked with.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    position : (3,) array_like of float, optional
        Where the light stands, in recentred coordinates. Either this or `to_light` is given.
    to_light : (3,) array_like of float, optional
        Direction to a light that is infinitely far, of any length.
    sight : pair of (3,) array_like of float, optional
        Promise that every point lies on the light's side of a surface that is seen from this box without crossing
        another, directly or in mirrors; see :func:`~.solids.sight_box`. Half the triangles of closed meshes clear of
        the box and of the light then need no look, with the same verdicts.
    solids : Solids, optional
        The geometry's closed parts and walls; None does without.
    members : (T,) ndarray of bool, optional
        The triangles that may hide the light, all or none of an instance's; None for all that cast shadows.
    """

    def __init__(
        self,
        geometry: Geometry,
        position: ArrayLike | None = None,
        to_light: ArrayLike | None = None,
        sight: tuple[ArrayLike, ArrayLike] | None = None,
        solids: Solids | None = None,
        members: NDArray[np.bool_] | None = None,
    ) -> None:
        if (position is None) == (to_light is None):
            raise TypeError("either position or to_light must be given")
        self._geometry = geometry
        self._solids = solids
        self._position = None if position is None else np.array(position, np.float64)
        if solids is None:
            bounds = _bounds(geometry)
            self._sides = np.full(geometry.triangle_count, BOTH, np.uint8)
        else:
            bounds = solids.bounds
            self._sides = solids.towards_light(geometry, sight, self._position)
        self._projections = light_projections(geometry, self._position, to_light, bounds)
        casting = geometry.shadow_visible if members is None else members
        if not casting.all():
            self._sides = self._sides * casting
        self._chosen: list[Integers] | None = None
        self._screens: dict[int, LightScreen] = {}
        self._lock = threading.Lock()

    def occluded(self, points: Array, own: Integers | None = None) -> NDArray[np.bool_]:
        """Find the points that something hides from the light.

        Parameters
        ----------
        points : (N, 3) ndarray
            Recentred positions, lifted off their surfaces by :func:`~.hits.offset_origins`.
        own : (N,) ndarray of int64, optional
            A triangle that does not hide the point (the one it lies on); -1 for none.

        Returns
        -------
        (N,) ndarray of bool
            True where a triangle lies between the point and the light.

        Raises
        ------
        ValueError
            By numpy, if the shapes do not fit together.

        References
        ----------
        Own design.
        """
        hidden = np.zeros(len(points), bool)
        if not self._geometry.triangle_count or not len(points):
            return hidden
        # Points that lie behind nothing are let go part by part, before tables of all of them fill the memory.
        doubtful: list[list[tuple[Array, ...]]] = [[] for _ in self._projections]
        for begin in range(0, len(points), _PAIRS):
            for face, number, part in self._parts(points[begin : begin + _PAIRS]):
                x, y, nearness = _on_screen(self._projections[face], self._geometry, part)
                below = self._screen(face).ceilings.below(x, y, nearness)
                if len(below):
                    number = below if number is None else np.take(number, below)
                    doubtful[face].append(
                        (number + begin, np.take(x, below), np.take(y, below), np.take(nearness, below))
                    )
        for face, parts in enumerate(doubtful):
            if parts:
                number, x, y, nearness = (np.concatenate(column) for column in zip(*parts, strict=True))
                owner = None if own is None else np.take(np.asarray(own, np.int64), number)
                hidden[number] = _hidden(self._screen(face), SampleGrid.of(x, y, nearness), owner)
        return hidden

    def _screen(self, face: int) -> LightScreen:
        """What is seen on a screen, made when it is first asked for."""
        if face not in self._screens:
            with self._lock:
                if face not in self._screens:
                    chosen = self._on_face(face)
                    self._screens[face] = LightScreen.of(self._projections[face], self._geometry, chosen, self._sides)
        return self._screens[face]

    def _on_face(self, face: int) -> Integers:
        """Triangles that may be seen on a screen."""
        if self._chosen is None:
            towards = -self._projections[0].axes[2]
            if self._solids is None:
                chosen = np.flatnonzero(self._sides)
            else:
                chosen = self._solids.seen(self._geometry, self._sides, self._position, towards)
            if len(self._projections) == 1 or self._position is None:
                self._chosen = [chosen]
            else:
                touching = touching_faces(self._geometry, self._position, chosen)
                self._chosen = [np.take(chosen, np.flatnonzero(touching & (1 << face))) for face in range(6)]
        return self._chosen[face]

    def _parts(self, points: Array) -> list[tuple[int, Integers | None, Array]]:
        """Screens, the numbers of the points that fall on each (None for all), and those points."""
        if len(self._projections) == 1:
            return [(0, None, points)]
        assert self._position is not None
        face = face_of(*(points[:, axis] - self._position[axis] for axis in range(3)))
        parts = [(number, np.flatnonzero(face == number)) for number in range(6)]
        return [(number, chosen, np.take(points, chosen, axis=0)) for number, chosen in parts if len(chosen)]


def occluded_from_point(
    geometry: Geometry, points: Array, own: Integers | None, light_position: ArrayLike
) -> NDArray[np.bool_]:
    """Find the points that something hides from a light at a place.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    points : (N, 3) ndarray
        Recentred positions, lifted off their surfaces by :func:`~.hits.offset_origins`.
    own : (N,) ndarray of int64 or None
        A triangle that does not hide the point.
    light_position : (3,) array_like of float
        Where the light stands, in recentred coordinates.

    Returns
    -------
    (N,) ndarray of bool
        True where a triangle lies between the point and the light.

    Raises
    ------
    ValueError
        By numpy, if the shapes do not fit together.

    References
    ----------
    Own design.
    """
    return LightView(geometry, position=light_position).occluded(points, own)


def occluded_from_direction(
    geometry: Geometry, points: Array, own: Integers | None, to_light: ArrayLike
) -> NDArray[np.bool_]:
    """Find the points that something hides from a light that is infinitely far.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    points : (N, 3) ndarray
        Recentred positions, lifted off their surfaces by :func:`~.hits.offset_origins`.
    own : (N,) ndarray of int64 or None
        A triangle that does not hide the point.
    to_light : (3,) array_like of float
        Direction to the light, of any length.

    Returns
    -------
    (N,) ndarray of bool
        True where a triangle lies between the point and the light.

    Raises
    ------
    ValueError
        By numpy, if the shapes do not fit together.

    References
    ----------
    Own design.
    """
    return LightView(geometry, to_light=to_light).occluded(points, own)


def _bounds(geometry: Geometry) -> tuple[Array, Array]:
    if not len(geometry.vertices):
        return np.zeros(3), np.zeros(3)
    return geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)


def _on_screen(projection: Projection, geometry: Geometry, points: Array) -> tuple[Array, Array, Array]:
    """Positions of points on a screen, and what a triangle's nearness must exceed to hide them."""
    dtype = geometry.dtype
    # Depths are rounded by a few units in the last place of the scene's size; so much farther is not behind.
    blur = 4.0 * np.finfo(dtype).eps * geometry.radius
    x, y, depth = projection.eye_space(points)
    if projection.perspective:
        np.maximum(depth, projection.near, out=depth)
        x /= depth
        y /= depth
        depth = np.maximum(depth - blur, 0.5 * depth)
    else:
        depth -= blur
    return x.astype(dtype), y.astype(dtype), projection.nearness(depth).astype(dtype)


def _hidden(screen: LightScreen, grid: SampleGrid, own: Integers | None) -> NDArray[np.bool_]:
    """Points of a grid that triangles of the same screen hide, in the order the points were given."""
    result = np.zeros(len(grid.order), bool)
    dark = np.zeros(len(grid.order), bool)
    starts = np.arange(0, len(screen.triangle), _TRIANGLES)
    closest = [screen.nearest[k : k + _TRIANGLES].max() for k in starts]
    # From the light outward, so that points are found hidden early; once enough are, they leave the grid, and with them
    # the need to look at what lies behind.
    for k in starts[np.argsort(closest)[::-1]]:
        if np.count_nonzero(dark) > _HIDDEN_PART * len(dark):
            result[grid.order[dark]] = True
            if dark.all():
                return result
            grid = grid.without(dark)
            dark = np.zeros(len(grid.order), bool)
        part = slice(k, k + _TRIANGLES)
        left, top = grid.cells(screen.left[part], screen.top[part])
        right, bottom = grid.cells(screen.right[part], screen.bottom[part])
        # Seen edge on a triangle hides nothing; its neighbours meet without it.
        may = grid.may_hide(left, top, right, bottom, screen.nearest[part]) & (bottom > top)
        wide = right - left > _NARROW
        for some, narrow in ((np.flatnonzero(may & ~wide), True), (np.flatnonzero(may & wide), False)):
            if len(some):
                x, y, z = (np.take(values[:, part], some, axis=1) for values in (screen.x, screen.y, screen.nearness))
                spans = (
                    _Box(*(np.take(side, some) for side in (left, right, top, bottom)))
                    if narrow
                    else _Outline(*grid.cells(x, y))
                )
                _shade(spans, _Planes(x, y, z), np.take(screen.triangle[part], some), grid, own, dark)
    result[grid.order[dark]] = True
    return result


def _shade(
    spans: _Box | _Outline,
    plane: _Planes,
    triangle: Integers,
    grid: SampleGrid,
    own: Integers | None,
    dark: NDArray[np.bool_],
) -> None:
    """Mark the points that some triangles hide."""
    first = np.clip(spans.top - grid.pad, 0.0, grid.rows - 1.0).astype(np.int64)
    count = np.clip(spans.bottom + grid.pad, 0.0, grid.rows - 1.0).astype(np.int64) - first + 1
    for begin, stop in batches(count, _PAIRS):
        owner, row = expand(count[begin:stop])
        owner += begin
        row += np.take(first, owner)
        left, right = spans.extent(owner, row)
        # Both ends are kept one cell beyond the grid at most: empty there, the range of samples is too.
        low = np.clip(left - grid.pad, 0.0, float(grid.columns)).astype(np.int64)
        high = np.clip(right + (1.0 + grid.pad), 0.0, float(grid.columns)).astype(np.int64)
        row *= grid.columns
        start = np.take(grid.start, row + low)
        length = np.take(grid.start, row + high) - start
        kept = np.flatnonzero(length > 0)
        owner, start, length = np.take(owner, kept), np.take(start, kept), np.take(length, kept)
        for low_span, high_span in batches(length, _PAIRS):
            part = slice(low_span, high_span)
            span, point = expand(length[part])
            point += np.take(start[part], span)
            of = np.take(owner[part], span)
            px, py = np.take(grid.x, point), np.take(grid.y, point)
            behind = plane.nearness(of, px, py) > np.take(grid.nearness, point)
            behind &= ~np.take(dark, point)
            near = np.flatnonzero(behind)
            of, point = np.take(of, near), np.take(point, near)
            inside = np.flatnonzero(plane.covers(of, np.take(px, near), np.take(py, near)))
            of, point = np.take(of, inside), np.take(point, inside)
            if own is not None:
                other = np.flatnonzero(np.take(triangle, of) != np.take(own, np.take(grid.order, point)))
                point = np.take(point, other)
            dark[point] = True


class _Box:
    """Bounding boxes for outlines: as good for triangles of a few cells, and at hand."""

    def __init__(self, left: Array, right: Array, top: Array, bottom: Array) -> None:
        self._left, self._right = left, right
        self.top, self.bottom = top, bottom

    def extent(self, owner: Integers, row: Integers) -> tuple[Array, Array]:
        """Least and greatest x of each triangle, the same on every row."""
        return np.take(self._left, owner), np.take(self._right, owner)


class _Outline:
    """How far triangles extend to the left and right on rows of cells."""

    def __init__(self, x: Array, y: Array) -> None:
        count = y.shape[1]
        x, y = x.ravel(), y.ravel()
        a, b, c = top_to_bottom(y, np.arange(count)[:, None] + count * np.arange(3))
        ya, yb, yc = np.take(y, a), np.take(y, b), np.take(y, c)
        xa, xb, xc = np.take(x, a), np.take(x, b), np.take(x, c)
        self.top, self.middle, self.bottom = ya, yb, yc
        self._middle_x = xb
        self._x = np.concatenate([xa, xa, xb])
        self._y = np.concatenate([ya, ya, yb])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            slope = np.concatenate([(xc - xa) / (yc - ya), (xb - xa) / (yb - ya), (xc - xb) / (yc - yb)])
        slope[np.flatnonzero(~np.isfinite(slope))] = 0.0  # horizontal edges, met at their first end only
        self._slope = slope

    def extent(self, owner: Integers, row: Integers) -> tuple[Array, Array]:
        """Least and greatest x of each triangle between y = row and y = row + 1."""
        count = len(self.top)
        middle = np.take(self.middle, owner)
        height = row.astype(middle.dtype)
        upper = np.maximum(height, np.take(self.top, owner))
        lower = np.minimum(height + 1.0, np.take(self.bottom, owner))
        # Rounding may put a row just past the triangle: meet it at its end then.
        lower = np.maximum(lower, upper)
        ends = []
        for height in (upper, lower):
            short = owner + count + count * (height >= middle)
            for edge in (owner, short):
                across = height - np.take(self._y, edge)
                across *= np.take(self._slope, edge)
                across += np.take(self._x, edge)
                ends.append(across)
        left = np.minimum(np.minimum(ends[0], ends[1]), np.minimum(ends[2], ends[3]))
        right = np.maximum(np.maximum(ends[0], ends[1]), np.maximum(ends[2], ends[3]))
        corner = np.take(self._middle_x, owner)
        turns = (middle >= upper) & (middle <= lower)
        return (
            np.where(turns, np.minimum(left, corner), left),
            np.where(turns, np.maximum(right, corner), right),
        )


class _Planes:
    """Nearness of triangles' planes, and their insides, at points of the screen."""

    def __init__(self, x: Array, y: Array, nearness: Array) -> None:
        self._x, self._y, self._z = x, y, nearness[0]
        (bx, cx), (by, cy), (bz, cz) = (values[1:] - values[0] for values in (x, y, nearness))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            scale = 1.0 / (bx * cy - by * cx)
            self._slope_x = (bz * cy - by * cz) * scale
            self._slope_y = (bx * cz - bz * cx) * scale

    def nearness(self, owner: Integers, x: Array, y: Array) -> Array:
        """Value of each triangle's plane at a point; NaN for triangles seen edge on."""
        with np.errstate(invalid="ignore", over="ignore"):
            value = x - np.take(self._x[0], owner)
            value *= np.take(self._slope_x, owner)
            down = y - np.take(self._y[0], owner)
            down *= np.take(self._slope_y, owner)
            value += down
            value += np.take(self._z, owner)
        return value

    def covers(self, owner: Integers, x: Array, y: Array) -> NDArray[np.bool_]:
        """Whether each triangle has the point inside or on its border; exact for borders shared by two triangles."""
        ax, bx, cx = (np.take(corner, owner) - x for corner in self._x)
        ay, by, cy = (np.take(corner, owner) - y for corner in self._y)
        u, v, w = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
        least, most = np.minimum(np.minimum(u, v), w), np.maximum(np.maximum(u, v), w)
        return (least >= 0.0) | (most <= 0.0)
