"""What a light sees on its screens: one that holds the scene, or six around a light amid it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .ceilings import Ceilings
from .geometry import Geometry
from .projection import Projection

__all__ = ["SCREEN", "LightScreen", "face_of", "light_projections", "touching_faces"]

Array = NDArray[Any]
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SCREEN = 1024.0
"""Width of a light's screen in its own units."""

_WIDEST = 3.0
"""Tangent of the half angle up to which a light has a single screen."""

_NEAR = 1e-5
"""Depth, in scene radii, up to which nothing counts: closer to the light there is no telling what hides what."""

_BESIDE = 1.001
"""How much farther to the side than ahead a vertex must lie to be surely off a face."""


@dataclass(frozen=True, slots=True, eq=False)
class LightScreen:
    """Triangles on a light's screen, corner by corner.

    Parameters
    ----------
    x, y, nearness : (3, S) ndarray
        Screen positions of the corners, and their nearness.
    triangle : (S,) ndarray of int64
        Triangle of the geometry that each is, or is a piece of.
    left, right, top, bottom, nearest : (S,) ndarray
        Bounding boxes, and the greatest nearness in each.
    ceilings : Ceilings
        Bounds of what may be hidden.

    References
    ----------
    Own design.
    """

    x: Array
    y: Array
    nearness: Array
    triangle: Integers
    left: Array
    right: Array
    top: Array
    bottom: Array
    nearest: Array
    ceilings: Ceilings

    @classmethod
    def of(
        cls, projection: Projection, geometry: Geometry, chosen: Integers | None, sides: NDArray[np.uint8]
    ) -> LightScreen:
        """Project triangles.

        Parameters
        ----------
        projection : Projection
            The screen.
        geometry : Geometry
            The triangles.
        chosen : (S,) ndarray of int64 or None
            Numbers of those to project; None for all.
        sides : (T,) ndarray of uint8
            Sides of each that hide something; see :class:`~.solids.Solids`.

        Returns
        -------
        LightScreen
            In the geometry's dtype.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        flat = projection.project(geometry, chosen, sides)
        corners = np.ascontiguousarray(flat.corners.T)
        x, y, nearness = (np.take(values, corners) for values in (flat.x, flat.y, flat.nearness))
        left, right = np.minimum(np.minimum(x[0], x[1]), x[2]), np.maximum(np.maximum(x[0], x[1]), x[2])
        top, bottom = np.minimum(np.minimum(y[0], y[1]), y[2]), np.maximum(np.maximum(y[0], y[1]), y[2])
        nearest = np.maximum(np.maximum(nearness[0], nearness[1]), nearness[2])
        ceilings = Ceilings.of(x, y, nearness, (left, right, top, bottom), nearest, SCREEN)
        return cls(x, y, nearness, flat.triangle, left, right, top, bottom, nearest, ceilings)


def light_projections(
    geometry: Geometry, position: Floats | None, to_light: ArrayLike | None, bounds: tuple[Array, Array]
) -> list[Projection]:
    """One screen that holds the scene, or six around a light amid it.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    position : (3,) ndarray of float64 or None
        Where the light stands, in recentred coordinates; None for one infinitely far.
    to_light : (3,) array_like of float or None
        Direction to it then.
    bounds : pair of (3,) ndarray
        Opposite corners of the scene's box.

    Returns
    -------
    list of Projection
        One, or six in the order +x, -x, +y, -y, +z, -z.

    Raises
    ------
    ValueError
        By numpy, if a position has not three coordinates.

    References
    ----------
    Own design.
    """
    radius = max(geometry.radius, 1e-300)
    half = 0.5 * SCREEN
    if position is None:
        axis = -np.asarray(to_light, np.float64)
        axis = axis / np.linalg.norm(axis)
        return [_looking(np.zeros(3), axis, False, half / (1.01 * radius), -2.0 * radius, 2.0 * radius, 0.0)]
    near, far = _NEAR * radius, float(np.linalg.norm(position)) + 2.0 * radius
    axis, tangent = _cone(geometry, position, bounds)
    tangent = max(tangent, 1e-6)  # an empty scene
    if tangent < _WIDEST:
        reference = float(-position @ axis)
        return [_looking(position, axis, True, half / tangent, near, far, reference if reference > near else np.inf)]
    return [_onto(position, axes, True, half, near, far, np.inf) for axes in _CUBE]


def face_of(x: Array, y: Array, z: Array) -> NDArray[np.uint8]:
    """Face of the cube around a light on which each of some points falls.

    Parameters
    ----------
    x, y, z : (N,) ndarray
        Positions relative to the light.

    Returns
    -------
    (N,) ndarray of uint8
        Numbers of the projections that :func:`light_projections` gives.

    Raises
    ------
    ValueError
        By numpy, if the lengths differ.

    References
    ----------
    Own design.
    """
    ax, ay, az = np.abs(x), np.abs(y), np.abs(z)
    face = (x < 0.0).view(np.uint8)
    np.copyto(face, (y < 0.0).view(np.uint8) + np.uint8(2), where=ay > ax)
    np.copyto(face, (z < 0.0).view(np.uint8) + np.uint8(4), where=az > np.maximum(ax, ay))
    return face


def touching_faces(geometry: Geometry, position: Floats, chosen: Integers) -> NDArray[np.uint8]:
    """Faces of the cube around a light that triangles may fall on, as bits.

    Parameters
    ----------
    geometry : Geometry
        The triangles.
    position : (3,) ndarray of float64
        Where the light stands.
    chosen : (S,) ndarray of int64
        Numbers of the triangles to tell of.

    Returns
    -------
    (S,) ndarray of uint8
        Bit k for face k.

    Raises
    ------
    IndexError
        By numpy, if a triangle number is out of range.

    References
    ----------
    Outcodes: Newman and Sproull, Principles of Interactive Computer Graphics (1979).
    """
    relative = [geometry.vertices[:, axis] - position[axis].astype(geometry.dtype) for axis in range(3)]
    # Bit 2 p: surely not on the positive side of the p-th plane between two faces; bit 2 p + 1: not on the negative.
    code = np.zeros(len(geometry.vertices), np.uint16)
    masks = np.zeros(6, np.uint16)
    bit = 0
    for ahead in range(3):
        for aside in range(3):
            if ahead == aside:
                continue
            one, other = relative[ahead], relative[aside]
            # Face +ahead needs one >= other and one >= -other; face -ahead needs -one >= other and -one >= -other.
            if aside > ahead:
                sum_, difference = one + other, one - other
                slack = (_BESIDE - 1.0) * (np.abs(one) + np.abs(other))
                for value, positive, negative in (
                    (difference, (2 * ahead, 2 * aside + 1), (2 * ahead + 1, 2 * aside)),
                    (sum_, (2 * ahead, 2 * aside), (2 * ahead + 1, 2 * aside + 1)),
                ):
                    for outside, faces in ((value < -slack, positive), (value > slack, negative)):
                        code |= outside.astype(np.uint16) << np.uint16(bit)
                        masks[list(faces)] |= np.uint16(1 << bit)
                        bit += 1
    a, b, c = (np.take(code, np.take(geometry.triangles[:, k], chosen)) for k in range(3))
    all_outside = a & b & c
    touching = np.zeros(len(chosen), np.uint8)
    for face in range(6):
        touching |= ((all_outside & masks[face]) == 0).view(np.uint8) << np.uint8(face)
    return touching


def _cone(geometry: Geometry, apex: Array, bounds: tuple[Array, Array]) -> tuple[Array, float]:
    """Axis of a cone from a point around the scene, and the tangent of its half angle (infinite from 90 degrees on)."""
    vertices, distance = geometry.vertices, float(np.linalg.norm(apex))
    if distance > 1.5 * geometry.radius:
        return -apex / distance, 1.01 * float(geometry.radius / np.sqrt(distance**2 - geometry.radius**2))
    low, high = (corner.astype(np.float64) for corner in bounds)
    if np.all((apex >= low) & (apex <= high)):
        return np.eye(3)[2], np.inf
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
    return _onto(eye, _axes(forward), perspective, scale, near, far, reference)


def _onto(
    eye: Array, axes: Floats, perspective: bool, scale: float, near: float, far: float, reference: float
) -> Projection:
    return Projection(
        eye=eye,
        axes=axes,
        perspective=perspective,
        scale=(scale, scale),
        shift=(0.5 * SCREEN, 0.5 * SCREEN),
        near=near,
        far=far,
        size=(SCREEN, SCREEN),
        reference=reference,
    )


def _axes(forward: Floats) -> Floats:
    """Right, down and forward."""
    aside = np.eye(3)[np.abs(forward).argmin()]
    right = np.cross(forward, aside)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


_CUBE = tuple(_axes(sign * row) for row in np.eye(3) for sign in (1.0, -1.0))
"""Axes of the six screens around a light, which look along +x, -x, +y, -y, +z, -z."""
