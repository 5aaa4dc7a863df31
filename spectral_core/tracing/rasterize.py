"""What a camera sees, by rasterisation: the hits of the ray caster at a fraction of its cost.

Every triangle is cut into the rows of samples it crosses; on a row it covers the samples between the crossings of two
of its edges. A crossing depends on its edge alone and is computed the same way for both triangles of the edge, so
their spans meet without a gap. Nearness is linear along a span. What is left of each sample's winner is then computed
as a ray caster would: barycentric coordinates in the triangle's plane, and from them the distance.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .geometry import Geometry
from .hits import Hits
from .projection import Projection, ScreenTriangles
from .solids import Solids, sight_box
from .spans import Edges, batches, expand, ordered_edges

__all__ = ["PrimaryView", "primary_hits"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_TRIANGLES = 16384
"""Triangles set up together; their tables stay in the second-level cache."""

_PAIRS = 32768
"""(triangle, row) or (triangle, sample) pairs worked on together."""

_SMALLEST_SPAN = 1e-6
"""Stands for the width of a span that float32 cannot tell from a point; it holds one sample at most."""


class PrimaryView:
    """A camera's view of a scene through one sub-pixel position of every pixel, ready to give hits row by row.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    camera : Camera
        The camera.
    width, height : int
        Size of the picture in pixels.
    offset : tuple of float, optional
        Position of the sample within each pixel; (0.5, 0.5) is the centre.
    solids : Solids, optional
        The geometry's closed parts: of those the camera is outside of, only the sides that face it are drawn.
    """

    def __init__(
        self,
        geometry: Geometry,
        camera: Camera,
        width: int,
        height: int,
        offset: tuple[float, float] = (0.5, 0.5),
        solids: Solids | None = None,
    ) -> None:
        self._geometry = geometry
        self._width = width
        self._height = height
        self._projection = Projection.of_camera(geometry, camera, width, height, offset)
        seen = geometry.camera_visible
        if solids is None:
            self._screen = self._projection.project(geometry, None if seen.all() else np.flatnonzero(seen))
        else:
            sides = solids.towards_eye(geometry, sight_box(geometry, camera)) * seen
            eye = self._projection.eye if self._projection.perspective else None
            chosen = solids.seen(geometry, sides, eye, camera.matrix[:3, 2])
            self._screen = self._projection.project(geometry, chosen, sides)
        self._first, self._last = _row_ranges(self._screen, width, height)
        self._in_some_row = np.flatnonzero(self._first <= self._last)

    def hits(self, rows: tuple[int, int] | None = None) -> Hits:
        """Find the nearest triangle at each sample of some rows.

        Parameters
        ----------
        rows : tuple of int, optional
            First row and the one behind the last; None for the whole picture. Memory grows with their number.

        Returns
        -------
        Hits
            One a pixel, row by row from the top. Distances count from the camera's near plane along unit directions,
            as for the rays of :meth:`Camera.rays`.

        Raises
        ------
        ValueError
            By numpy, if the range is reversed.

        References
        ----------
        Own design.
        """
        first, end = (0, self._height) if rows is None else rows
        geometry = self._geometry
        nearness = np.full((end - first) * self._width, self._projection.farthest, geometry.dtype)
        winner = np.full(len(nearness), -1)
        band = self._in_some_row
        if (first, end) != (0, self._height):
            crosses = (np.take(self._first, band) < end) & (np.take(self._last, band) >= first)
            band = np.take(band, np.flatnonzero(crosses))
        for k in range(0, len(band), _TRIANGLES):
            self._draw(band[k : k + _TRIANGLES], first, end, nearness, winner)
        return self._resolve(winner, first)

    def _draw(self, chosen: Integers, first: int, end: int, nearness: Array, winner: Integers) -> None:
        """Write triangles into the buffers of a band of rows."""
        screen, width = self._screen, self._width
        edges = ordered_edges(screen.x, screen.y, screen.nearness, np.take(screen.corners, chosen, axis=0))
        number = np.take(screen.triangle, chosen)
        top = np.maximum(np.take(self._first, chosen), first)
        count = np.minimum(np.take(self._last, chosen), end - 1) + 1 - top
        turn = np.ceil(edges.middle)
        for begin, stop in batches(count, _PAIRS):
            owner, rank = expand(count[begin:stop])
            owner += begin
            row = np.take(top, owner) + rank
            left, near_left, right, near_right = _row_crossings(edges, turn, owner, row.astype(nearness.dtype))
            start = np.maximum(np.ceil(left), 0.0)
            length = (np.minimum(np.floor(right), width - 1.0) - start).astype(np.int64) + 1
            kept = np.flatnonzero(length > 0)
            left, right, near_left, start = (np.take(a, kept) for a in (left, right, near_left, start))
            slope = (np.take(near_right, kept) - near_left) / np.maximum(right - left, _SMALLEST_SPAN)
            at_start = near_left + (start - left) * slope
            pixel = (np.take(row, kept) - first) * width + start.astype(np.int64)
            triangle = np.take(number, np.take(owner, kept))
            length = np.take(length, kept)
            for low, high in batches(length, _PAIRS):
                part = slice(low, high)
                _fill(length[part], pixel[part], at_start[part], slope[part], triangle[part], nearness, winner)

    def _resolve(self, winner: Integers, first: int) -> Hits:
        """Barycentric coordinates and distances of the winners."""
        dtype, width = self._geometry.dtype, self._width
        hits = Hits(
            np.full(len(winner), np.inf, dtype), winner, np.zeros(len(winner), dtype), np.zeros(len(winner), dtype)
        )
        shown, plane = _numbered(winner, self._geometry.triangle_count)
        table = _ScreenPlanes.of(self._projection, self._geometry, shown)
        scale, shift = self._projection.scale, self._projection.shift
        x, y = np.arange(width), np.arange(first, first + len(winner) // max(width, 1))
        across = ((x - shift[0]) / scale[0]).astype(dtype)
        down = ((y - shift[1]) / scale[1]).astype(dtype)
        near = dtype.type(self._projection.near)
        shape = (len(y), width)
        hit, plane = (winner >= 0).reshape(shape), plane.reshape(shape)
        u, v, distance = (a.reshape(shape) for a in (hits.u, hits.v, hits.distance))
        x, y = x.astype(dtype), y.astype(dtype)
        step = max(_PAIRS // max(width, 1), 1)
        for k in range(0, len(y), step):
            rows = slice(k, k + step)
            if not hit[rows].any():
                continue
            at_u, at_v, depth = table.at(plane[rows], x, y[rows, None])
            depth -= near
            if self._projection.perspective:
                depth *= np.sqrt(1.0 + across * across + down[rows, None] * down[rows, None])
            np.maximum(depth, 0.0, out=depth)
            for result, values in ((u, at_u), (v, at_v), (distance, depth)):
                np.copyto(result[rows], values, where=hit[rows])
        return hits


def primary_hits(
    geometry: Geometry,
    camera: Camera,
    width: int,
    height: int,
    rows: tuple[int, int] | None = None,
    offset: tuple[float, float] = (0.5, 0.5),
) -> Hits:
    """Find what a camera sees through one sub-pixel position of every pixel of some rows.

    To go through a picture band by band, make one :class:`PrimaryView` and ask it: the triangles are projected once.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    camera : Camera
        The camera.
    width, height : int
        Size of the picture in pixels.
    rows : tuple of int, optional
        First row and the one behind the last; None for the whole picture.
    offset : tuple of float, optional
        Position of the sample within each pixel; (0.5, 0.5) is the centre.

    Returns
    -------
    Hits
        One a pixel, row by row from the top; those of the rays of :meth:`Camera.rays` up to :meth:`Camera.reach`.

    Raises
    ------
    ZeroDivisionError
        If width or height is 0.

    References
    ----------
    Own design.
    """
    return PrimaryView(geometry, camera, width, height, offset).hits(rows)


def _row_ranges(screen: ScreenTriangles, width: int, height: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """First and last row of samples each triangle may cover; last < first where it covers no sample's column or row.

    A row is crossed where top <= row < bottom: of two triangles that meet at a corner one has it.
    """
    first = np.empty(len(screen.corners), np.int32)
    last = np.empty(len(screen.corners), np.int32)
    for k in range(0, len(first), _TRIANGLES):
        part = slice(k, k + _TRIANGLES)
        a, b, c = (np.ascontiguousarray(screen.corners[part, corner]) for corner in range(3))
        y0, y1, y2 = np.take(screen.y, a), np.take(screen.y, b), np.take(screen.y, c)
        top, bottom = np.minimum(np.minimum(y0, y1), y2), np.maximum(np.maximum(y0, y1), y2)
        first[part] = np.ceil(np.clip(top, 0.0, height))
        last[part] = np.ceil(np.clip(bottom, 0.0, height)) - 1.0
        x0, x1, x2 = np.take(screen.x, a), np.take(screen.x, b), np.take(screen.x, c)
        left, right = np.minimum(np.minimum(x0, x1), x2), np.maximum(np.maximum(x0, x1), x2)
        # A hundredth of a pixel of margin: crossings are rounded, and may lie beyond the corners by as little.
        none = np.ceil(np.maximum(left - 0.01, 0.0)) > np.floor(np.minimum(right + 0.01, width - 1.0))
        last[part][none] = -1
        first[part][none] = 0
    return first, last


def _row_crossings(edges: Edges, turn: Array, owner: Integers, row: Array) -> tuple[Array, Array, Array, Array]:
    """Left and right end of triangles' spans on rows, and the nearness there."""
    count = len(turn)
    below = row >= np.take(turn, owner)
    x_long, near_long = edges.crossing(owner, row)
    x_short, near_short = edges.crossing(owner + count + count * below, row)
    swap = x_long > x_short
    left, right = np.minimum(x_long, x_short), np.maximum(x_long, x_short)
    return left, np.where(swap, near_short, near_long), right, np.where(swap, near_long, near_short)


def _fill(
    length: Integers,
    pixel: Integers,
    at_start: Array,
    slope: Array,
    triangle: Integers,
    nearness: Array,
    winner: Integers,
) -> None:
    """Write spans into the buffers where they are nearer, or as near with a lower triangle number."""
    owner, rank = expand(length)
    value = np.take(slope, owner)
    value *= rank.astype(value.dtype)
    value += np.take(at_start, owner)
    rank += np.take(pixel, owner)
    nearer = np.flatnonzero(value >= np.take(nearness, rank))
    value, pixel = np.take(value, nearer), np.take(rank, nearer)
    triangle = np.take(triangle, np.take(owner, nearer))
    while len(pixel):
        held, holder = np.take(nearness, pixel), np.take(winner, pixel)
        wins = np.flatnonzero((value > held) | ((value == held) & (triangle < holder)))
        value, pixel, triangle = np.take(value, wins), np.take(pixel, wins), np.take(triangle, wins)
        # Of several at one pixel the last one writes; the others look again at what it left.
        nearness[pixel], winner[pixel] = value, triangle
        again = np.flatnonzero(np.take(winner, pixel) != triangle)
        value, pixel, triangle = np.take(value, again), np.take(pixel, again), np.take(triangle, again)


def _numbered(values: Integers, bound: int) -> tuple[Integers, Integers]:
    """Distinct values in rising order, and the place of each value among them; -1 has the place 0."""
    occurs = np.zeros(bound + 1, bool)
    occurs[values] = True  # -1 marks the last
    distinct = np.flatnonzero(occurs[:bound])
    place = np.zeros(bound + 1, np.int64)
    place[distinct] = np.arange(len(distinct))
    return distinct, np.take(place, values, mode="wrap")


class _ScreenPlanes:
    """Barycentric coordinates and depth of triangles as functions of the screen position.

    A screen position p = (x, y, 1) is a positive combination of the corners' homogeneous positions; its coefficients
    are triple products p . (B x C) and so on, and divided by their sum they are the barycentric coordinates. The
    products are formed in float64 about a point of the screen close to the triangle and then cast.
    """

    def __init__(self, rows: Array) -> None:
        self._rows = rows

    @classmethod
    def of(cls, projection: Projection, geometry: Geometry, triangles: Integers) -> _ScreenPlanes:
        rows = np.empty((len(triangles), 14), geometry.dtype)
        for k in range(0, len(triangles), _TRIANGLES):
            part = slice(k, k + _TRIANGLES)
            corners = np.take(geometry.corners, triangles[part], axis=0)
            hx, hy, depth = projection.eye_space(corners.reshape(-1, 3))
            w = depth if projection.perspective else np.ones_like(depth)
            x, y, w, depth = (a.reshape(-1, 3) for a in (hx, hy, w, depth))
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                # About the first corner if it can be seen; float32 holds the reference exactly.
                x_ref, y_ref = (
                    np.where(w[:, 0] > 0.0, np.clip(np.rint(h[:, 0] / w[:, 0]), 0.0, size), 0.0)
                    for h, size in ((x, projection.size[0]), (y, projection.size[1]))
                )
            x, y = x - x_ref[:, None] * w, y - y_ref[:, None] * w
            weights = []  # of corners 1 and 2 and of all three: (constant, per x, per y)
            for i, j in ((1, 2), (2, 0), (0, 1)):
                weights.append(
                    (
                        x[:, i] * y[:, j] - y[:, i] * x[:, j],
                        y[:, i] * w[:, j] - w[:, i] * y[:, j],
                        w[:, i] * x[:, j] - x[:, i] * w[:, j],
                    )
                )
            total = [weights[0][k] + weights[1][k] + weights[2][k] for k in range(3)]
            table = np.stack([*weights[1], *weights[2], *total], axis=1)
            table /= np.maximum(np.abs(table).max(axis=1, keepdims=True), 1e-300)
            rows[part, :9] = table
            rows[part, 9], rows[part, 10] = x_ref, y_ref
            rows[part, 11] = depth[:, 0]
            rows[part, 12:] = depth[:, 1:] - depth[:, :1]
        return cls(rows)

    def at(self, plane: Integers, x: Array, y: Array) -> tuple[Array, Array, Array]:
        """Barycentric coordinates u and v, kept within the triangle, and depth."""
        row = np.moveaxis(np.take(self._rows, plane, axis=0), -1, 0)
        x, y = x - row[9], y - row[10]
        u = row[1] * x
        u += row[2] * y
        u += row[0]
        v = row[4] * x
        v += row[5] * y
        v += row[3]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            scale = row[7] * x
            scale += row[8] * y
            scale += row[6]
            np.divide(1.0, scale, out=scale)
            # fmax and fmin turn the 0/0 of a triangle seen edge on into its first corner.
            u = np.fmin(np.fmax(u * scale, 0.0), 1.0)
            v = np.fmin(np.fmax(v * scale, 0.0), 1.0 - u)
            depth = u * row[12]
            depth += v * row[13]
            depth += row[11]
        return u, v, depth
