"""A lamp that shines into a cone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..spectra import Spectrum
from ..tracing.columns import dot_rows
from ..validation import require_in_range
from .base import (
    Floats,
    Illumination,
    LampPoint,
    Vector,
    check_light,
    require_unit_vector,
    require_vector,
)
from .sphere import sphere_illumination, sphere_point

__all__ = ["SpotLight"]


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
        Radius of the emitting sphere (m); its shadows and the edge of its cone are soft. 0 is a point.
    casts_shadow : bool
        Whether surfaces hide the light.
    receivers : frozenset of int, optional
        Numbers of the instances that it lights; None for all.
    soft_falloff : bool
        Whether it is a disk that turns to each point instead of a sphere, so that it falls off more slowly up close;
        what Blender's lamps are unless told otherwise.
    blockers : frozenset of int, optional
        Numbers of the instances that hide it, of those that cast shadows; None for all.

    Raises
    ------
    InvalidParameterError
        If a value breaks its rule.
    """

    position: Vector
    direction: Vector
    strength: float
    illuminant: Spectrum
    spot_size: float = math.radians(45.0)
    blend: float = 0.15
    name: str = "Spot"
    radius: float = 0.0
    casts_shadow: bool = True
    receivers: frozenset[int] | None = None
    soft_falloff: bool = False
    blockers: frozenset[int] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", require_vector(f"position of light '{self.name}'", self.position))
        object.__setattr__(self, "direction", require_unit_vector(f"direction of light '{self.name}'", self.direction))
        check_light(self)
        require_in_range(f"spot_size of light '{self.name}'", self.spot_size, 0.0, math.pi, unit="rad")
        require_in_range(f"blend of light '{self.name}'", self.blend, 0.0, 1.0)
        require_in_range(f"radius of light '{self.name}'", self.radius, 0.0)

    @property
    def is_extended(self) -> bool:
        """Whether the light has a size, so that it takes many points to see it."""
        return self.radius > 0.0

    def lamp_point(self, unit_square: Vector, aim: Vector) -> LampPoint:
        """Choose a point of the lamp.

        Parameters
        ----------
        unit_square : ndarray of float64, shape (3,)
            Random numbers from 0 to 1; the first two spread the points over the disk that is seen from `aim`.
        aim : ndarray of float64, shape (3,)
            Middle of the scene, in the world.

        Returns
        -------
        LampPoint
            Its position; the centre for a light without a size.

        Raises
        ------
        None.

        References
        ----------
        See :func:`~spectral_core.lights.base.ball_point`.
        """
        return sphere_point(self, unit_square, aim)

    def illuminate(self, points: Floats, centre: Vector, at: LampPoint | None = None) -> Illumination:
        """Direction, distance and irradiance of one watt at N points.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Origin of `points` in the world, float64.
        at : LampPoint, optional
            Point of the lamp; its centre when left out.

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
        lit = sphere_illumination(self, points, centre, at)
        cosine = -dot_rows(lit.to_light, self.direction.astype(points.dtype))
        edge = math.cos(0.5 * self.spot_size)
        width = (1.0 - edge) * self.blend
        if width > 0.0:
            ramp = np.clip((cosine - edge) / width, 0.0, 1.0)
            falloff = ramp * ramp * (3.0 - 2.0 * ramp)
        else:
            falloff = (cosine >= edge).astype(points.dtype)
        return Illumination(lit.to_light, lit.distance, lit.irradiance * falloff.astype(points.dtype))
