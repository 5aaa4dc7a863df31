"""Light sources: where their light comes from and how strong it is, apart from its spectrum.

The geometry of a light (direction and irradiance for one unit of strength) and its spectrum (illuminant and strength)
are kept apart, so that a lamp can be exchanged after the rays have been traced.

Units follow Blender's: a point or spot light of power P (W) gives the irradiance P / (4 pi d^2) on a plane that faces
it at distance d; the strength of a sun is that irradiance itself (W/m^2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError
from .spectra import Spectrum, require_not_negative
from .validation import require_finite, require_in_range, require_shape

__all__ = ["LARGEST_STRENGTH", "Illumination", "Light", "PointLight", "SpotLight", "SunLight", "require_strength"]

LARGEST_STRENGTH = 1.0e30
"""The largest strength of a light; so that pictures in float32 cannot overflow."""

FloatArray: TypeAlias = NDArray[np.floating[Any]]


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


def _vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = require_finite(name, value)
    require_shape(name, array, (3,))
    array.flags.writeable = False
    return array


def _unit_vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = _vector(name, value)
    largest = float(np.abs(array).max())
    if largest == 0.0:
        raise InvalidParameterError(f"{name} must not be the zero vector")
    scaled = array / largest  # so that no square under- or overflows
    unit: NDArray[np.float64] = scaled / math.sqrt(float(scaled @ scaled))
    unit.flags.writeable = False
    return unit


@dataclass(frozen=True, slots=True)
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

    to_light: FloatArray
    distance: FloatArray
    irradiance: FloatArray


@dataclass(frozen=True, slots=True)
class PointLight:
    """A light that radiates equally in all directions.

    Attributes
    ----------
    position : array_like, shape (3,)
        World position (m).
    strength : float
        Power (W), 0 to 1e30.
    illuminant : Spectrum
        Relative spectral power distribution; its scale does not matter, it is brought to Y = 1.
    name : str
        Shown in the plan, and the handle for relighting.
    radius : float
        Radius of the emitting sphere (m); kept for reference, shadows are hard whatever it is.
    """

    position: NDArray[np.float64]
    strength: float
    illuminant: Spectrum
    name: str = "Point"
    radius: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", _vector(f"position of light '{self.name}'", self.position))
        _check_strength(self)
        require_in_range(f"radius of light '{self.name}'", self.radius, 0.0)

    def illuminate(self, points: FloatArray, centre: NDArray[np.float64]) -> Illumination:
        """Direction, distance and irradiance of one watt at N points.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Origin of `points` in the world, float64.

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
        Inverse square law; the unit is that of Blender's point light.
        """
        offset = (self.position - centre).astype(points.dtype) - points
        distance, to_light = _normalise(offset)
        return Illumination(to_light, distance, _inverse_square(distance))


@dataclass(frozen=True, slots=True)
class SunLight:
    """Parallel light from one direction.

    Attributes
    ----------
    to_light : array_like, shape (3,)
        Direction from the scene to the sun, any length but zero.
    strength : float
        Irradiance on a plane that faces the sun (W/m^2), 0 to 1e30.
    illuminant : Spectrum
        Relative spectral power distribution; brought to Y = 1.
    name : str
        Shown in the plan, and the handle for relighting.
    angle : float
        Angular diameter (rad); kept for reference, shadows are hard whatever it is.
    """

    to_light: NDArray[np.float64]
    strength: float
    illuminant: Spectrum
    name: str = "Sun"
    angle: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "to_light", _unit_vector(f"direction of light '{self.name}'", self.to_light))
        _check_strength(self)
        require_in_range(f"angle of light '{self.name}'", self.angle, 0.0, math.pi, unit="rad")

    def illuminate(self, points: FloatArray, centre: NDArray[np.float64]) -> Illumination:
        """Direction, distance and irradiance of unit strength at N points.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Origin of `points` in the world; a sun does not need it.

        Returns
        -------
        Illumination
            In the dtype of `points`; the distance is infinite and the irradiance 1.

        Raises
        ------
        ValueError
            From numpy when the shapes do not fit.

        References
        ----------
        The unit is that of Blender's sun light.
        """
        count = len(points)
        direction = np.broadcast_to(self.to_light.astype(points.dtype), (count, 3))
        return Illumination(direction, np.full(count, np.inf, points.dtype), np.ones(count, points.dtype))


@dataclass(frozen=True, slots=True)
class SpotLight:
    """A point light that is limited to a cone.

    Attributes
    ----------
    position : array_like, shape (3,)
        World position (m).
    direction : array_like, shape (3,)
        Axis of the cone, away from the light; any length but zero.
    strength : float
        Power (W) of the point light that shines as strongly along the axis, 0 to 1e30.
    illuminant : Spectrum
        Relative spectral power distribution; brought to Y = 1.
    spot_size : float
        Full opening angle of the cone (rad), 0 to pi.
    blend : float
        Part of the cone over which its edge softens, 0 (hard) to 1.
    name : str
        Shown in the plan, and the handle for relighting.
    radius : float
        Radius of the emitting sphere (m); kept for reference, shadows are hard whatever it is.
    """

    position: NDArray[np.float64]
    direction: NDArray[np.float64]
    strength: float
    illuminant: Spectrum
    spot_size: float = math.radians(45.0)
    blend: float = 0.15
    name: str = "Spot"
    radius: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", _vector(f"position of light '{self.name}'", self.position))
        object.__setattr__(self, "direction", _unit_vector(f"direction of light '{self.name}'", self.direction))
        _check_strength(self)
        require_in_range(f"spot_size of light '{self.name}'", self.spot_size, 0.0, math.pi, unit="rad")
        require_in_range(f"blend of light '{self.name}'", self.blend, 0.0, 1.0)
        require_in_range(f"radius of light '{self.name}'", self.radius, 0.0)

    def illuminate(self, points: FloatArray, centre: NDArray[np.float64]) -> Illumination:
        """Direction, distance and irradiance of one watt at N points.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Origin of `points` in the world, float64.

        Returns
        -------
        Illumination
            In the dtype of `points`; zero irradiance outside the cone.

        Raises
        ------
        ValueError
            From numpy when the shapes do not fit.

        References
        ----------
        The smoothstep edge over the cosine is that of Blender's spot light.
        """
        offset = (self.position - centre).astype(points.dtype) - points
        distance, to_light = _normalise(offset)
        cosine = -(to_light @ self.direction.astype(points.dtype))
        edge = math.cos(0.5 * self.spot_size)
        width = (1.0 - edge) * self.blend
        if width > 0.0:
            ramp = np.clip((cosine - edge) / width, 0.0, 1.0)
            falloff = ramp * ramp * (3.0 - 2.0 * ramp)
        else:
            falloff = (cosine >= edge).astype(points.dtype)
        return Illumination(to_light, distance, _inverse_square(distance) * falloff.astype(points.dtype))


Light: TypeAlias = PointLight | SunLight | SpotLight


def _check_strength(light: Light) -> None:
    if not isinstance(light.illuminant, Spectrum):
        raise InvalidParameterError(
            f"illuminant of light '{light.name}' must be a Spectrum, but is {light.illuminant!r}"
        )
    require_strength(f"strength of light '{light.name}'", light.strength)
    require_not_negative(f"illuminant of light '{light.name}'", light.illuminant)


def _normalise(offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lengths (N,) and unit vectors (N, 3); the zero vector keeps length 0 and direction 0."""
    distance = np.sqrt(np.einsum("ij,ij->i", offset, offset))
    safe = np.where(distance > 0, distance, 1)
    return distance, offset / safe[:, None]


def _inverse_square(distance: FloatArray) -> FloatArray:
    # A point that lies in the light itself receives nothing rather than an infinite irradiance.
    safe = np.where(distance > 0, distance, np.inf)
    result: FloatArray = (1.0 / (4.0 * math.pi) / safe / safe).astype(distance.dtype)
    return result
