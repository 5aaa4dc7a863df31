"""What point and spot lights share when they are spheres."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ..tracing.columns import dot_rows
from .base import Floats, Illumination, LampPoint, Vector, ball_point, inverse_square, normalise

__all__ = ["SphericalLamp", "sphere_illumination", "sphere_irradiance", "sphere_point"]


class SphericalLamp(Protocol):
    """A lamp that radiates from a sphere, or from a point where its radius is 0."""

    @property
    def position(self) -> Vector:
        """World position of its centre (m), (3,)."""

    @property
    def radius(self) -> float:
        """Radius (m)."""

    @property
    def soft_falloff(self) -> bool:
        """Whether it is a disk that turns to each point instead."""


def sphere_point(lamp: SphericalLamp, unit_square: Vector, aim: Vector) -> LampPoint:
    """Choose a point of a spherical lamp.

    Parameters
    ----------
    lamp : SphericalLamp
        The lamp.
    unit_square : ndarray of float64, shape (3,)
        Random numbers from 0 to 1; the first two spread the points over the disk that is seen from `aim`.
    aim : ndarray of float64, shape (3,)
        Middle of the scene, in the world.

    Returns
    -------
    LampPoint
        Its position; the centre for a lamp without a size.

    Raises
    ------
    None.

    References
    ----------
    See :func:`~spectral_core.lights.base.ball_point`.
    """
    if lamp.radius == 0.0:
        return LampPoint(lamp.position)
    offset = aim - lamp.position
    length = float(np.linalg.norm(offset))
    axis = offset / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    return LampPoint(lamp.position + lamp.radius * ball_point(unit_square, axis))


def sphere_illumination(lamp: SphericalLamp, points: Floats, centre: Vector, at: LampPoint | None) -> Illumination:
    """Direction, distance and irradiance of one watt from a point of a spherical lamp.

    Parameters
    ----------
    lamp : SphericalLamp
        The lamp.
    points : ndarray, shape (N, 3)
        Points relative to `centre` (m), float32 or float64.
    centre : ndarray, shape (3,)
        Origin of `points` in the world, float64.
    at : LampPoint or None
        Point of the lamp; None for its centre.

    Returns
    -------
    Illumination
        In the dtype of `points`.

    Raises
    ------
    ValueError
        From numpy when the shapes do not fit.

    References
    ----------
    Inverse square law; the unit is that of Blender's point light. For spheres see :func:`sphere_irradiance`.
    """
    position = lamp.position if at is None or at.position is None else at.position
    distance, to_light = normalise((position - centre).astype(points.dtype) - points)
    middle = (lamp.position - centre).astype(points.dtype) if lamp.radius > 0.0 else None
    irradiance = sphere_irradiance(points, distance, middle, lamp.radius, lamp.soft_falloff)
    return Illumination(to_light, distance, irradiance)


def sphere_irradiance(
    points: Floats, distance: Floats, middle: Floats | None, radius: float, soft_falloff: bool = False
) -> Floats:
    """Irradiance of one watt from a point of a spherical lamp.

    An evenly bright sphere gives a surface that sees all of it exactly what a point at its centre would. The points
    that stand for it lie at other distances and directions; the weight d / c^3, with d the distance to the point and
    c that to the centre, makes weight times direction linear in the point's place, so that the mean is exact.

    Parameters
    ----------
    points : ndarray, shape (N, 3)
        Points that are lit.
    distance : ndarray, shape (N,)
        Their distance to the point of the lamp.
    middle : ndarray, shape (3,), optional
        Centre of the sphere, in the same coordinates; None for a light without a size.
    radius : float
        Radius of the sphere; nearer than this the distance counts as it.
    soft_falloff : bool, optional
        Whether the lamp is instead a disk of that radius that turns to each point, and gives c^2 / (c^2 + r^2) of that.

    Returns
    -------
    ndarray, shape (N,)
        Irradiance on a plane that faces the point of the lamp.

    Raises
    ------
    ValueError
        From numpy when the shapes do not fit.

    References
    ----------
    Irradiance of a uniform sphere: Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-38. A disk of
    radiance L that faces a point on its axis gives pi L r^2 / (c^2 + r^2).
    """
    if middle is None:
        return inverse_square(distance)
    offset = middle - points
    to_centre = np.maximum(np.sqrt(dot_rows(offset, offset)), radius)
    result: Floats = (distance / to_centre / to_centre / to_centre / (4.0 * math.pi)).astype(points.dtype)
    if soft_falloff:
        result = (result / (1.0 + np.square(radius / to_centre))).astype(points.dtype)
    return result
