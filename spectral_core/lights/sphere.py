"""What point and spot lights share when they are spheres."""

from __future__ import annotations

import math

import numpy as np

from .base import Floats, Vector, inverse_square

__all__ = ["aim_of_sphere", "sphere_irradiance"]


def aim_of_sphere(position: Vector, aim: Vector) -> Vector:
    """Direction along which the points of a spherical lamp are spread best.

    Parameters
    ----------
    position, aim : ndarray of float64, shape (3,)
        The lamp's centre, and the middle of the scene.

    Returns
    -------
    ndarray of float64, shape (3,)
        Unit vector; upwards where the two are one.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    offset = aim - position
    length = float(np.linalg.norm(offset))
    return offset / length if length > 0.0 else np.array([0.0, 0.0, 1.0])


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
    to_centre = np.maximum(np.sqrt(np.einsum("ij,ij->i", offset, offset)), radius)
    result: Floats = (distance / to_centre / to_centre / to_centre / (4.0 * math.pi)).astype(points.dtype)
    if soft_falloff:
        result = (result / (1.0 + np.square(radius / to_centre))).astype(points.dtype)
    return result
