"""What all lights share: the light that they give to points, the point that is looked from, and their checks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..spectra import Spectrum, require_not_negative
from ..tracing.columns import dot_rows
from ..validation import require_finite, require_in_range, require_shape

__all__ = [
    "LARGEST_STRENGTH",
    "Floats",
    "Illumination",
    "LampPoint",
    "Vector",
    "ball_point",
    "check_light",
    "frame_about",
    "inverse_square",
    "normalise",
    "require_strength",
    "require_unit_vector",
    "require_vector",
]

LARGEST_STRENGTH = 1.0e30
"""The largest strength of a light; so that pictures in float32 cannot overflow."""

Floats: TypeAlias = NDArray[np.floating[Any]]
Vector: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Illumination:
    """What one light of unit strength gives to N points.

    Attributes
    ----------
    to_light : ndarray, shape (N, 3)
        Unit vectors from the points to the light.
    distance : ndarray, shape (N,)
        Distance to the light; infinite for a sun.
    irradiance : ndarray, shape (N,)
        Irradiance on a plane that faces the light, for one unit of strength.
    """

    to_light: Floats
    distance: Floats
    irradiance: Floats


@dataclass(frozen=True, slots=True, eq=False)
class LampPoint:
    """One place or direction that stands for a light, for as long as one sample is taken.

    Attributes
    ----------
    position : ndarray of float64, shape (3,), optional
        World position (m); None for a light that is infinitely far.
    to_light : ndarray of float64, shape (3,), optional
        Unit direction to a light that is infinitely far; None for one that has a position.
    factor : float
        Part of the light that the point stands for, times their number; 1 unless points are drawn unevenly.
    normal : ndarray of float64, shape (3,), optional
        Unit normal of the emitting surface at the position.
    weights : tuple of float
        For sources of several emitters (the primaries of an image): how strongly each shines from here.
    """

    position: Vector | None = None
    to_light: Vector | None = None
    factor: float = 1.0
    normal: Vector | None = None
    weights: tuple[float, ...] = (1.0,)


def require_strength(name: str, value: float) -> None:
    """Raise when a number cannot be the strength of a light.

    Parameters
    ----------
    name : str
        What the strength is called in the error.
    value : float
        A single number, 0 to 1e30.

    Raises
    ------
    InvalidParameterError
        If it is not a single number, not finite, or outside its range.

    References
    ----------
    Own design.
    """
    require_shape(name, require_in_range(name, value, 0.0, LARGEST_STRENGTH), ())


def require_vector(name: str, value: ArrayLike) -> Vector:
    """Convert to three finite numbers that cannot be changed, or raise.

    Parameters
    ----------
    name : str
        What the vector is called in the error.
    value : array_like, shape (3,)
        The numbers.

    Returns
    -------
    ndarray of float64, shape (3,)
        A read-only copy.

    Raises
    ------
    InvalidParameterError
        If there are not three, or one is not finite.

    References
    ----------
    Own design.
    """
    array = np.array(require_finite(name, value))
    require_shape(name, array, (3,))
    array.flags.writeable = False
    return array


def require_unit_vector(name: str, value: ArrayLike) -> Vector:
    """Convert to a vector of length 1 that cannot be changed, or raise.

    Parameters
    ----------
    name : str
        What the vector is called in the error.
    value : array_like, shape (3,)
        Any length but zero.

    Returns
    -------
    ndarray of float64, shape (3,)
        Read-only.

    Raises
    ------
    InvalidParameterError
        If there are not three finite numbers, or all are 0.

    References
    ----------
    Own design.
    """
    array = require_vector(name, value)
    largest = float(np.abs(array).max())
    if largest == 0.0:
        raise InvalidParameterError(f"{name} must not be the zero vector")
    scaled = array / largest  # so that no square under- or overflows
    unit: Vector = scaled / math.sqrt(float(scaled @ scaled))
    unit.flags.writeable = False
    return unit


def check_light(light: Any) -> None:
    """Raise when what all lights have is not as it must be: their spectrum, and the instances they name.

    Parameters
    ----------
    light : object
        With `name`, `strength`, `illuminant`, `receivers` and `blockers`.

    Raises
    ------
    InvalidParameterError
        If the illuminant is no spectrum or has negative values, the strength breaks its rule, or receivers or blockers
        are no set of whole numbers from 0.

    References
    ----------
    Own design.
    """
    if not isinstance(light.illuminant, Spectrum):
        raise InvalidParameterError(
            f"illuminant of light '{light.name}' must be a Spectrum, but is {light.illuminant!r}"
        )
    require_strength(f"strength of light '{light.name}'", light.strength)
    require_not_negative(f"illuminant of light '{light.name}'", light.illuminant)
    for attribute in ("receivers", "blockers"):
        numbers = getattr(light, attribute)
        if numbers is None:
            continue
        if not (isinstance(numbers, frozenset) and all(isinstance(n, (int, np.integer)) and n >= 0 for n in numbers)):
            raise InvalidParameterError(
                f"{attribute} of light '{light.name}' must be a frozenset of numbers of instances, but is {numbers!r}"
            )


def normalise(offset: Floats) -> tuple[Floats, Floats]:
    """Split vectors into length and direction.

    Parameters
    ----------
    offset : ndarray, shape (N, 3)
        Vectors.

    Returns
    -------
    length : ndarray, shape (N,)
        Their lengths.
    direction : ndarray, shape (N, 3)
        Unit vectors; the zero vector keeps the direction 0.

    Raises
    ------
    ValueError
        From numpy if the last axis is missing.

    References
    ----------
    Own design.
    """
    length = np.sqrt(dot_rows(offset, offset))
    safe = np.where(length > 0, length, 1)
    return length, offset / safe[:, None]


def inverse_square(distance: Floats) -> Floats:
    """Irradiance of one watt that spreads evenly in all directions.

    Parameters
    ----------
    distance : ndarray, shape (N,)
        Distances (m), at least 0.

    Returns
    -------
    ndarray, shape (N,)
        1 / (4 pi d^2); 0 at distance 0, where a point lies in the light itself.

    Raises
    ------
    None.

    References
    ----------
    Inverse square law; the unit is that of Blender's point light.
    """
    safe = np.where(distance > 0, distance, np.inf)
    result: Floats = (1.0 / (4.0 * math.pi) / safe / safe).astype(distance.dtype)
    return result


def frame_about(axis: Vector) -> tuple[Vector, Vector]:
    """Give two unit vectors perpendicular to an axis and to each other.

    Parameters
    ----------
    axis : ndarray of float64, shape (3,)
        A unit vector.

    Returns
    -------
    tuple of ndarray of float64, shape (3,)
        The vectors; first x second = axis.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    aside = np.eye(3)[np.abs(axis).argmin()]
    first = np.cross(aside, axis)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def ball_point(unit_square: Vector, axis: Vector) -> Vector:
    """Draw a point of the unit ball whose shadow on any plane is spread evenly over the unit disk.

    So whoever looks at a spherical lamp sees its points evenly over its disk, from wherever. Uniform points of the
    sphere in four dimensions have this property when one coordinate is dropped: their density in the ball is
    proportional to 1 / sqrt(1 - r^2), and along every chord it integrates to the same.

    Parameters
    ----------
    unit_square : ndarray of float64, shape (3,)
        Random numbers from 0 to 1. The first two spread the points over the disk that is seen along `axis`, so they
        should be stratified; the third is how deep in the ball they lie.
    axis : ndarray of float64, shape (3,)
        Unit vector.

    Returns
    -------
    ndarray of float64, shape (3,)
        The point; of length 1 at most.

    Raises
    ------
    None.

    References
    ----------
    Points on the sphere in four dimensions: Shoemake, "Uniform random rotations", Graphics Gems III (1992).
    """
    first, second = frame_about(axis)
    radius, angle = math.sqrt(1.0 - unit_square[0]), 2.0 * math.pi * unit_square[1]
    depth = math.sqrt(unit_square[0]) * math.sin(2.0 * math.pi * unit_square[2])
    return radius * math.cos(angle) * first + radius * math.sin(angle) * second + depth * axis
