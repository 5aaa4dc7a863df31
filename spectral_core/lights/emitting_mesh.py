"""Surfaces that emit, as sources of light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..tracing.clusters import along_curve
from ..tracing.columns import dot_rows
from ..tracing.geometry import Geometry
from ..tracing.solids import AWAY, TOWARDS, Solids
from .base import Floats, Illumination, LampPoint, Vector, normalise

__all__ = ["EmittingMesh"]

_LIFT = 2e-5
"""Height of a lamp point over its surface, in scene radii: so that the surface does not hide it."""


class EmittingMesh:
    """The triangles of an emitting material, one of their points at a time.

    Both sides of a surface shine, as in Blender; of a closed one with nothing in it only the outer side is seen, and
    only it is used.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    solids : Solids
        Its closed parts.
    triangles : ndarray of int64, shape (T,)
        Numbers of the emitting triangles.
    name : str
        Of the material.
    """

    casts_shadow = True
    is_extended = True
    receivers: frozenset[int] | None = None
    blockers: frozenset[int] | None = None

    def __init__(self, geometry: Geometry, solids: Solids, triangles: NDArray[np.int64], name: str) -> None:
        self.name = name
        if len(triangles):  # so that an even row of numbers is even over the surface
            triangles = triangles[along_curve(geometry.corners[triangles].mean(axis=1))[1]]
        self._corners = geometry.corners[triangles].astype(np.float64) + geometry.centre
        self._normals = geometry.geometric_normals[triangles].astype(np.float64)
        self._lift = _LIFT * geometry.radius
        edge1, edge2 = self._corners[:, 1] - self._corners[:, 0], self._corners[:, 2] - self._corners[:, 0]
        area = 0.5 * np.linalg.norm(np.cross(edge1, edge2), axis=1)
        sides = solids.shining_sides(geometry, triangles)
        # Faces along the normals first, then those against them: a row of numbers is as even over the two as over each.
        front, back = np.flatnonzero(sides & TOWARDS), np.flatnonzero(sides & AWAY)
        self._face = np.concatenate([front, back])
        self._sign = np.concatenate([np.ones(len(front)), -np.ones(len(back))])
        self._cumulative = np.cumsum(area[self._face])

    @property
    def area(self) -> float:
        """Area that shines (m^2): both sides of what has two."""
        return float(self._cumulative[-1]) if len(self._cumulative) else 0.0

    def lamp_point(self, unit_square: Vector, aim: Vector) -> LampPoint:
        """Choose a point of the surface.

        Parameters
        ----------
        unit_square : ndarray of float64, shape (3,)
            Random numbers from 0 to 1: the place within a triangle, and the triangle and its side.
        aim : ndarray of float64, shape (3,)
            Not used.

        Returns
        -------
        LampPoint
            Position, normal, and as the factor the area that it stands for.

        Raises
        ------
        None.

        References
        ----------
        Uniform points of a triangle: Turk, "Generating random points in triangles", Graphics Gems (1990).
        """
        if not len(self._corners):  # all of them were without area
            return LampPoint(position=aim, normal=np.array([0.0, 0.0, 1.0]), factor=0.0)
        root, v, choice = float(np.sqrt(unit_square[0])), float(unit_square[1]), float(unit_square[2])
        face = min(int(np.searchsorted(self._cumulative, choice * self.area, side="right")), len(self._face) - 1)
        chosen = self._face[face]
        a, b, c = self._corners[chosen]
        normal = self._sign[face] * self._normals[chosen]
        position = (1.0 - root) * a + root * (1.0 - v) * b + root * v * c + self._lift * normal
        return LampPoint(position=position, normal=normal, factor=self.area)

    def illuminate(self, points: Floats, centre: Vector, at: LampPoint | None = None) -> Illumination:
        """Direction, distance and irradiance of N points from one point of the surface, for a radiance of 1.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Origin of `points` in the world, float64.
        at : LampPoint
            The point of the surface.

        Returns
        -------
        Illumination
            In the dtype of `points`; zero behind the surface.

        Raises
        ------
        ValueError
            If no point is given.

        References
        ----------
        Irradiance is radiance times projected area over distance squared.
        """
        if at is None or at.position is None or at.normal is None:
            raise ValueError("light from a surface needs a point of it")
        distance, to_light = normalise((at.position - centre).astype(points.dtype) - points)
        cosine = np.maximum(-dot_rows(to_light, at.normal.astype(points.dtype)), 0.0)
        # Nearer than the lifted point lies over its surface nothing is told apart.
        safe = np.maximum(distance, self._lift)
        irradiance = at.factor * cosine / safe / safe
        return Illumination(to_light, distance, irradiance.astype(points.dtype))
