"""Flattening a scene onto the screen of an eye: a camera, or a light that asks whom it sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .clipping import clip_triangles
from .geometry import Geometry
from .solids import AWAY, TOWARDS

__all__ = ["Projection", "ScreenTriangles"]

Array = NDArray[Any]
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_GUARD = 0.5
"""Screen coordinates may leave the screen by this many of its sizes: float32 has no digits to spare for more."""


_CUT = np.uint8(64)
"""Outcode of a vertex before the near plane or beyond the guard band."""


@dataclass(frozen=True, slots=True, eq=False)
class ScreenTriangles:
    """Triangles as a screen sees them.

    Parameters
    ----------
    x, y : (V,) ndarray
        Screen positions of the vertices, x right, y down. Vertices that no triangle uses may hold anything.
    nearness : (V,) ndarray
        Grows towards the eye and is linear on the screen.
    corners : (S, 3) ndarray of int64
        Vertex numbers of each screen triangle.
    triangle : (S,) ndarray of int64
        Triangle of the geometry that each is, or is a piece of.

    References
    ----------
    Own design.
    """

    x: Array
    y: Array
    nearness: Array
    corners: Integers
    triangle: Integers


@dataclass(frozen=True, slots=True, eq=False)
class Projection:
    """A perspective or parallel projection onto a screen.

    Parameters
    ----------
    eye : (3,) ndarray of float64
        Where the eye is, relative to the geometry's centre. For a parallel projection any point on its axis.
    axes : (3, 3) ndarray of float64
        Rows: unit vectors to the right, down and forward.
    perspective : bool
        Whether rays meet in the eye, or run parallel.
    scale, shift : tuple of float
        Screen x and y are ``scale * (sideways / depth) + shift``, without the division in a parallel projection.
    near, far : float
        Depths between which things are seen.
    size : tuple of float
        Width and height of the screen, from 0.
    reference : float
        Depth at which nearness is 0; infinite when the eye is inside the scene.

    References
    ----------
    Own design.
    """

    eye: Floats
    axes: Floats
    perspective: bool
    scale: tuple[float, float]
    shift: tuple[float, float]
    near: float
    far: float
    size: tuple[float, float]
    reference: float

    @classmethod
    def of_camera(
        cls, geometry: Geometry, camera: Camera, width: int, height: int, offset: tuple[float, float] = (0.5, 0.5)
    ) -> Projection:
        """Look through a camera; the sample of pixel (i, j) lies at the screen's (i, j).

        Parameters
        ----------
        geometry : Geometry
            What is looked at; its centre becomes the origin.
        camera : Camera
            The camera.
        width, height : int
            Size of the picture in pixels.
        offset : tuple of float, optional
            Position of the sample within the pixel, x and y from its upper left corner.

        Returns
        -------
        Projection
            With screen units of pixels.

        Raises
        ------
        ZeroDivisionError
            If width or height is 0.

        References
        ----------
        Own design.
        """
        left, right, bottom, top = camera.window
        eye = camera.position - geometry.centre
        forward = -camera.matrix[:3, 2]
        across, down = width / (right - left), height / (top - bottom)
        return cls(
            eye=eye,
            axes=np.stack([camera.matrix[:3, 0], -camera.matrix[:3, 1], forward]),
            perspective=camera.kind == "perspective",
            scale=(across, down),
            shift=(-left * across - offset[0], top * down - offset[1]),
            near=camera.clip_start,
            far=camera.clip_end,
            size=(float(width), float(height)),
            reference=reference_depth(eye, forward, geometry.radius, camera.kind == "perspective"),
        )

    @property
    def farthest(self) -> float:
        """Nearness at the far end, below which nothing is seen."""
        return float(self.nearness(np.array([self.far]))[0])

    def nearness(self, depth: Array) -> Array:
        """Order depths: ``1/depth`` (perspective) or ``-depth``, less its value at the reference depth.

        Parameters
        ----------
        depth : ndarray of float64
            Distances along the forward axis.

        Returns
        -------
        ndarray of float64
            Same shape.

        Raises
        ------
        FloatingPointError
            Only under numpy's "raise" setting, at depth 0.

        References
        ----------
        Own design.
        """
        if not self.perspective:
            return self.reference - depth
        if np.isinf(self.reference):
            return 1.0 / depth
        return (self.reference - depth) / (depth * self.reference)

    def eye_space(self, points: Array) -> tuple[Floats, Floats, Floats]:
        """Positions along the three axes, times the scale for x and y, with the shift added.

        Parameters
        ----------
        points : (V, 3) ndarray
            Relative to the geometry's centre.

        Returns
        -------
        hx, hy, depth : (V,) ndarray of float64
            Screen x is ``hx / depth``, or `hx` in a parallel projection.

        Raises
        ------
        ValueError
            By numpy, if the last axis is not 3 long.

        References
        ----------
        Own design.
        """
        # Element by element: a library's product of matrices may round a point differently among other neighbours.
        px, py, pz = points.T.astype(np.float64)
        right, down, forward = ([*row, -float(row @ self.eye)] for row in self.axes)
        depth = forward[0] * px + forward[1] * py + forward[2] * pz + forward[3]
        hx = right[0] * px + right[1] * py + right[2] * pz + right[3]
        hy = down[0] * px + down[1] * py + down[2] * pz + down[3]
        hx *= self.scale[0]
        hy *= self.scale[1]
        w = depth if self.perspective else 1.0
        hx += self.shift[0] * w
        hy += self.shift[1] * w
        return hx, hy, depth

    def project(
        self, geometry: Geometry, chosen: Integers | None = None, sides: NDArray[np.uint8] | None = None
    ) -> ScreenTriangles:
        """Bring triangles to the screen, without those that lie wholly outside it.

        Triangles that cross the near plane, or leave the screen so far that their coordinates would be coarse, are
        cut.

        Parameters
        ----------
        geometry : Geometry
            The triangles.
        chosen : (S,) ndarray of int64, optional
            Numbers of those to project; None for all.
        sides : (T,) ndarray of uint8, optional
            Sides of each triangle of the geometry to project, :data:`~.solids.TOWARDS` or :data:`~.solids.AWAY` or
            both; None for both of all.

        Returns
        -------
        ScreenTriangles
            In the geometry's dtype.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Outcodes: Newman and Sproull, Principles of Interactive Computer Graphics (1979).
        """
        corners = geometry.triangles if chosen is None else np.take(geometry.triangles, chosen, axis=0)
        number = np.arange(len(corners)) if chosen is None else chosen
        vertices = geometry.vertices
        if 6 * len(corners) < len(vertices):
            # So few that their corners one by one are less work.
            vertices, corners = np.take(vertices, corners.ravel(), axis=0), np.arange(3 * len(corners)).reshape(-1, 3)
        hx, hy, depth = self.eye_space(vertices)
        code = self._outcodes(hx, hy, depth)
        dtype = geometry.dtype
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            x, y = (hx / depth, hy / depth) if self.perspective else (hx, hy)
            x, y, nearness = x.astype(dtype), y.astype(dtype), self.nearness(depth).astype(dtype)
        torn = np.zeros(0, np.int64)
        if code.any():
            a, b, c = (np.take(code, corners[:, k]) for k in range(3))
            seen = (a & b & c & ~_CUT) == 0
            cut = ((a | b | c) & _CUT) != 0
            whole, torn = np.flatnonzero(seen & ~cut), np.flatnonzero(seen & cut)
        if len(torn):
            at = corners[torn]
            pieces, source = clip_triangles(np.stack([hx[at], hy[at], depth[at]], axis=2), self._guard_planes())
            px, py, pd = pieces.reshape(-1, 3).T
            if self.perspective:
                px, py = px / pd, py / pd
            added = len(x) + np.arange(3 * len(pieces)).reshape(-1, 3)
            x, y = np.concatenate([x, px.astype(dtype)]), np.concatenate([y, py.astype(dtype)])
            nearness = np.concatenate([nearness, self.nearness(pd).astype(dtype)])
            torn_number = number[torn[source]]
        if code.any() and len(whole) < len(corners):
            corners, number = np.take(corners, whole, axis=0), np.take(number, whole)
        if len(torn):
            corners, number = np.concatenate([corners, added]), np.concatenate([number, torn_number])
        if sides is not None:
            mirrored = bool(np.linalg.det(self.axes) < 0.0)
            shown = np.flatnonzero(_shown(x, y, corners, mirrored) & np.take(sides, number))
            corners, number = np.take(corners, shown, axis=0), np.take(number, shown)
        return ScreenTriangles(x, y, nearness, corners, number)

    def _outcodes(self, hx: Floats, hy: Floats, depth: Floats) -> NDArray[np.uint8]:
        """Bits for the sides of the seen volume that a vertex lies beyond, and one if its triangles must be cut."""
        width, height = self.size
        w = depth if self.perspective else 1.0
        code = np.zeros(len(depth), np.uint8)
        # A pixel of margin: what is left out must be out after rounding too.
        sides = (hx < -w, hx > (width + 1.0) * w, hy < -w, hy > (height + 1.0) * w, depth < self.near, depth > self.far)
        for bit, side in enumerate(sides):
            code |= side.astype(np.uint8) << np.uint8(bit)
        (low_x, high_x), (low_y, high_y) = self._guard_band()
        cut = (depth < self.near) | (hx < low_x * w) | (hx > high_x * w) | (hy < low_y * w) | (hy > high_y * w)
        code |= np.where(cut, _CUT, np.uint8(0))
        return code

    def _guard_band(self) -> tuple[tuple[float, float], tuple[float, float]]:
        width, height = self.size
        return (-_GUARD * width, (1.0 + _GUARD) * width), (-_GUARD * height, (1.0 + _GUARD) * height)

    def _guard_planes(self) -> Floats:
        """Planes in (hx, hy, depth)."""
        near = (0.0, 0.0, 1.0, -self.near)
        sides = []
        for axis, (low, high) in enumerate(self._guard_band()):
            for sign, end in ((1.0, low), (-1.0, high)):
                plane = np.zeros(4)
                plane[axis] = sign
                plane[2 if self.perspective else 3] = -sign * end
                sides.append(plane)
        return np.array([near, *sides])


def _shown(x: Array, y: Array, corners: Integers, mirrored: bool) -> NDArray[np.uint8]:
    """Bits TOWARDS and AWAY of the sides that screen triangles show, both for those seen edge on.

    Told from the rounded positions: on them too a closed surface covers each point as often one way as the other.
    """
    a, b, c = (np.ascontiguousarray(corners[:, k]) for k in range(3))
    xa, ya = np.take(x, a), np.take(y, a)
    twice = (np.take(x, b) - xa) * (np.take(y, c) - ya) - (np.take(x, c) - xa) * (np.take(y, b) - ya)
    # Counter-clockwise seen from outside, but y grows downward.
    negative, positive = (AWAY, TOWARDS) if mirrored else (TOWARDS, AWAY)
    shown = (twice <= 0.0).view(np.uint8) * np.uint8(negative)
    shown |= (twice >= 0.0).view(np.uint8) * np.uint8(positive)
    return shown


def reference_depth(eye: Floats, forward: Floats, radius: float, perspective: bool) -> float:
    """Depth to measure nearness from: the scene's middle when the eye is well outside, else infinite.

    Subtracting it before the cast to float32 keeps a distant scene's depths apart.

    Parameters
    ----------
    eye, forward : (3,) ndarray of float64
        Position relative to the scene's centre, and view axis.
    radius : float
        The scene's radius.
    perspective : bool
        Whether the projection is perspective.

    Returns
    -------
    float
        The depth; always finite for parallel projections.

    Raises
    ------
    ValueError
        By numpy, if the shapes differ.

    References
    ----------
    Own design.
    """
    depth = float(-eye @ forward)
    return depth if not perspective or depth > 2.0 * radius > 0.0 else np.inf
