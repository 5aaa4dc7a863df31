"""Which points a light does not reach, exact and without rays: the light looks at the points.

All points are sorted into a grid on the light's screen; every triangle then finds the points in the cells it touches,
and hides those that lie inside its outline and behind its plane. It is no shadow map: nothing is sampled but the points
themselves. A light outside the scene has one screen, one within it the six faces of a cube, a sun a parallel one.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .geometry import Geometry
from .projection import Projection, ScreenTriangles
from .sample_grid import SampleGrid
from .spans import batches, expand, top_to_bottom

__all__ = ["LightView", "occluded_from_direction", "occluded_from_point"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_TRIANGLES = 16384
"""Triangles set up together; their tables stay in the second-level cache."""

_PAIRS = 32768
"""(triangle, row) or (triangle, point) pairs worked on together."""

_SCREEN = 1024.0
"""Width of a light's screen in its own units."""

_WIDEST = 3.0
"""Tangent of the half angle up to which a light has a single screen."""

_NEAR = 1e-5
"""Depth, in scene radii, up to which nothing counts: closer to the light there is no telling what hides what."""

_HIDDEN_PART = 0.35
"""Part of the points of a grid that must be hidden before it is worth while to sort them out."""

_NARROW = 3.0
"""Width in cells up to which a triangle is taken for its bounding box until its edges are tested."""


class LightView:
    """A light's view of a scene, ready to tell which points are hidden from it.

    The points lie on the scene's surfaces. Make it once for a light and ask it for any number of points: what it knows
    about the triangles is kept.

    Parameters
    ----------
    geometry : Geometry
        The scene; triangles that cast no shadow are left out.
    position : (3,) array_like of float, optional
        Where the light stands, in recentred coordinates. Either this or `to_light` is given.
    to_light : (3,) array_like of float, optional
        Direction to a light that is infinitely far, of any length.
    """

    def __init__(
        self, geometry: Geometry, position: ArrayLike | None = None, to_light: ArrayLike | None = None
    ) -> None:
        if (position is None) == (to_light is None):
            raise TypeError("either position or to_light must be given")
        self._geometry = geometry
        casting = geometry.shadow_visible
        self._casting = None if casting.all() else np.flatnonzero(casting)
        self._position = None if position is None else np.array(position, np.float64)
        self._projections = _projections(geometry, self._position, to_light)
        self._screens: dict[int, ScreenTriangles] = {}

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
        own = np.full(len(points), -1) if own is None else np.asarray(own, np.int64)
        if not self._geometry.triangle_count or not len(points):
            return hidden
        for number, chosen in self._faces(points):
            at, owner = (points, own) if chosen is None else (np.take(points, chosen, axis=0), np.take(own, chosen))
            projection = self._projections[number]
            if number not in self._screens:
                self._screens[number] = projection.project(self._geometry, self._casting)
            found = _hidden(self._screens[number], _grid(projection, self._geometry, at), owner)
            if chosen is None:
                hidden = found
            else:
                hidden[chosen] = found
        return hidden

    def _faces(self, points: Array) -> Iterator[tuple[int, Integers | None]]:
        """Screens and the points that fall on each; None for all points."""
        if len(self._projections) == 1:
            yield 0, None
            return
        assert self._position is not None
        x, y, z = (points[:, axis] - self._position[axis] for axis in range(3))
        ax, ay, az = np.abs(x), np.abs(y), np.abs(z)
        face = (x < 0.0).astype(np.uint8)
        np.copyto(face, (y < 0.0).astype(np.uint8) + np.uint8(2), where=ay > ax)
        np.copyto(face, (z < 0.0).astype(np.uint8) + np.uint8(4), where=az > np.maximum(ax, ay))
        for number in range(6):
            chosen = np.flatnonzero(face == number)
            if len(chosen):
                yield number, chosen


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


def _projections(geometry: Geometry, position: Array | None, to_light: ArrayLike | None) -> list[Projection]:
    """One screen that holds the scene, or six around a light amid it."""
    radius = max(geometry.radius, 1e-300)
    half = 0.5 * _SCREEN
    if position is None:
        axis = -np.asarray(to_light, np.float64)
        axis = axis / np.linalg.norm(axis)
        return [_looking(np.zeros(3), axis, False, half / (1.01 * radius), -2.0 * radius, 2.0 * radius, 0.0)]
    near, far = _NEAR * radius, float(np.linalg.norm(position)) + 2.0 * radius
    axis, tangent = _cone(geometry, position)
    tangent = max(tangent, 1e-6)  # an empty scene
    if tangent < _WIDEST:
        reference = float(-position @ axis)
        return [_looking(position, axis, True, half / tangent, near, far, reference if reference > near else np.inf)]
    axes = [sign * row for row in np.eye(3) for sign in (1.0, -1.0)]
    return [_looking(position, axis, True, half, near, far, np.inf) for axis in axes]


def _cone(geometry: Geometry, apex: Array) -> tuple[Array, float]:
    """Axis of a cone from a point around the scene, and the tangent of its half angle (infinite from 90 degrees on)."""
    vertices, distance = geometry.vertices, float(np.linalg.norm(apex))
    if distance > 1.5 * geometry.radius:
        return -apex / distance, 1.01 * float(geometry.radius / np.sqrt(distance**2 - geometry.radius**2))
    low, high = vertices.min(axis=0).astype(np.float64), vertices.max(axis=0).astype(np.float64)
    corners = np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    away = corners - apex
    axis = np.sum(away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-300), axis=0)
    axis /= max(float(np.linalg.norm(axis)), 1e-300)
    away = vertices - apex
    depth = away @ axis
    nearest = float(depth.min())
    if nearest <= 0.0:
        return axis, np.inf
    squared = np.einsum("ij,ij->i", away, away) / (depth * depth)
    return axis, 1.01 * float(np.sqrt(max(float(squared.max()) - 1.0, 1e-12)))


def _looking(
    eye: Array, forward: Array, perspective: bool, scale: float, near: float, far: float, reference: float
) -> Projection:
    aside = np.eye(3)[np.abs(forward).argmin()]
    right = np.cross(forward, aside)
    right /= np.linalg.norm(right)
    return Projection(
        eye=eye,
        axes=np.stack([right, np.cross(forward, right), forward]),
        perspective=perspective,
        scale=(scale, scale),
        shift=(0.5 * _SCREEN, 0.5 * _SCREEN),
        near=near,
        far=far,
        size=(_SCREEN, _SCREEN),
        reference=reference,
    )


def _grid(projection: Projection, geometry: Geometry, points: Array) -> SampleGrid:
    """Points on a screen, in a grid of about one cell a point."""
    dtype = geometry.dtype
    x, y = np.empty(len(points), dtype), np.empty(len(points), dtype)
    nearness = np.empty(len(points), dtype)
    # Depths are rounded by a few units in the last place of the scene's size; so much farther is not behind.
    blur = 4.0 * np.finfo(dtype).eps * geometry.radius
    for k in range(0, len(points), _PAIRS):
        part = slice(k, k + _PAIRS)
        hx, hy, depth = projection.eye_space(points[part])
        if projection.perspective:
            depth = np.maximum(depth, projection.near)
            hx, hy = hx / depth, hy / depth
        x[part], y[part] = hx, hy
        nearness[part] = projection.nearness(
            np.maximum(depth - blur, 0.5 * depth) if projection.perspective else depth - blur
        )
    return SampleGrid.of(x, y, nearness)


def _hidden(screen: ScreenTriangles, grid: SampleGrid, own: Integers) -> NDArray[np.bool_]:
    """Points of a grid that triangles of the same screen hide, in the order the points were given."""
    x, y = grid.cells(screen.x, screen.y)
    result = np.zeros(len(own), bool)
    dark = np.zeros(len(own), bool)
    starts = np.arange(0, len(screen.corners), _TRIANGLES)
    closest = [np.take(screen.nearness, screen.corners[k : k + _TRIANGLES, 0]).max() for k in starts]
    # From the light outward, so that points are found hidden early; once enough are, they leave the grid, and with them
    # the need to look at what lies behind.
    for k in starts[np.argsort(closest)[::-1]]:
        if np.count_nonzero(dark) > _HIDDEN_PART * len(dark):
            result[grid.order[dark]] = True
            if dark.all():
                return result
            grid = grid.without(dark)
            dark = np.zeros(len(grid.order), bool)
        a, b, c = np.ascontiguousarray(screen.corners[k : k + _TRIANGLES].T)
        y0, y1, y2 = np.take(y, a), np.take(y, b), np.take(y, c)
        top, bottom = np.minimum(np.minimum(y0, y1), y2), np.maximum(np.maximum(y0, y1), y2)
        x0, x1, x2 = np.take(x, a), np.take(x, b), np.take(x, c)
        left, right = np.minimum(np.minimum(x0, x1), x2), np.maximum(np.maximum(x0, x1), x2)
        z0, z1, z2 = np.take(screen.nearness, a), np.take(screen.nearness, b), np.take(screen.nearness, c)
        nearest = np.maximum(np.maximum(z0, z1), z2)
        # Seen edge on a triangle hides nothing; its neighbours meet without it.
        may = grid.may_hide(left, top, right, bottom, nearest) & (bottom > top)
        wide = right - left > _NARROW
        for some, narrow in ((np.flatnonzero(may & ~wide), True), (np.flatnonzero(may & wide), False)):
            if len(some):
                corners = np.take(screen.corners, k + some, axis=0)
                spans = (
                    _Box(*(np.take(side, some) for side in (left, right, top, bottom)))
                    if narrow
                    else _Outline(x, y, corners)
                )
                plane = _Planes(x, y, screen.nearness, corners)
                _shade(spans, plane, np.take(screen.triangle, k + some), grid, own, dark)
    result[grid.order[dark]] = True
    return result


def _shade(
    spans: _Box | _Outline,
    plane: _Planes,
    triangle: Integers,
    grid: SampleGrid,
    own: Integers,
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
            other = np.take(triangle, of) != np.take(own, np.take(grid.order, point))
            dark[point[other]] = True


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

    def __init__(self, x: Array, y: Array, corners: Integers) -> None:
        a, b, c = top_to_bottom(y, corners)
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

    def __init__(self, x: Array, y: Array, nearness: Array, corners: Integers) -> None:
        a, b, c = (np.ascontiguousarray(corners[:, k]) for k in range(3))
        self._x = [np.take(x, corner) for corner in (a, b, c)]
        self._y = [np.take(y, corner) for corner in (a, b, c)]
        z = [np.take(nearness, corner) for corner in (a, b, c)]
        bx, cx = (self._x[k] - self._x[0] for k in (1, 2))
        by, cy = (self._y[k] - self._y[0] for k in (1, 2))
        bz, cz = (z[k] - z[0] for k in (1, 2))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            scale = 1.0 / (bx * cy - by * cx)
            self._slope_x = (bz * cy - by * cz) * scale
            self._slope_y = (bx * cz - bz * cx) * scale
        self._z = z[0]

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
