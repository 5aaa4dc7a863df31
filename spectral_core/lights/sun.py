"""Parallel light from one direction, or from a disk in the sky."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..spectra import Spectrum
from ..tracing.sampling import disk_points
from ..validation import require_in_range
from .base import Floats, Illumination, LampPoint, Vector, check_light, frame_about, require_unit_vector

__all__ = ["SunLight"]

_WIDEST = math.radians(179.0)  # a wider disk would have no finite tangent


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
        Angular diameter (rad), 0 to pi; its shadows are soft. 0 is a point in the sky.
    casts_shadow : bool
        Whether surfaces hide the light.
    receivers : frozenset of int, optional
        Numbers of the instances that it lights; None for all.
    blockers : frozenset of int, optional
        Numbers of the instances that hide it, of those that cast shadows; None for all.

    Raises
    ------
    InvalidParameterError
        If a value breaks its rule.
    """

    to_light: Vector
    strength: float
    illuminant: Spectrum
    name: str = "Sun"
    angle: float = 0.0
    casts_shadow: bool = True
    receivers: frozenset[int] | None = None
    blockers: frozenset[int] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "to_light", require_unit_vector(f"direction of light '{self.name}'", self.to_light))
        check_light(self)
        require_in_range(f"angle of light '{self.name}'", self.angle, 0.0, math.pi, unit="rad")

    @property
    def is_extended(self) -> bool:
        """Whether the light has a size, so that it takes many points to see it."""
        return self.angle > 0.0

    def lamp_point(self, unit_square: Vector, aim: Vector) -> LampPoint:
        """Choose a direction within the sun's disk.

        Parameters
        ----------
        unit_square : ndarray of float64, shape (3,)
            Random numbers from 0 to 1; the third is not used.
        aim : ndarray of float64, shape (3,)
            Not used.

        Returns
        -------
        LampPoint
            The direction. Its factor makes direction times factor linear in the place on the disk, so that the mean
            over the disk is the direction of its centre.

        Raises
        ------
        None.

        References
        ----------
        A disk of that angular diameter, evenly bright, as Blender's sun has it.
        """
        if not self.is_extended:
            return LampPoint(to_light=self.to_light)
        first, second = frame_about(self.to_light)
        x, y = math.tan(0.5 * min(self.angle, _WIDEST)) * disk_points(unit_square[None, :2])[0]
        direction = self.to_light + x * first + y * second
        length = float(np.linalg.norm(direction))
        return LampPoint(to_light=direction / length, factor=length)

    def illuminate(self, points: Floats, centre: Vector, at: LampPoint | None = None) -> Illumination:
        """Direction, distance and irradiance of unit strength at N points.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Origin of `points` in the world; a sun does not need it.
        at : LampPoint, optional
            Direction within the disk; its centre when left out.

        Returns
        -------
        Illumination
            In the dtype of `points`; the distance is infinite and the irradiance 1 at the centre of the disk.

        Raises
        ------
        ValueError
            From numpy when the shapes do not fit.

        References
        ----------
        The unit is that of Blender's sun light.
        """
        towards, factor = (self.to_light, 1.0) if at is None or at.to_light is None else (at.to_light, at.factor)
        count, dtype = len(points), points.dtype
        direction = np.broadcast_to(towards.astype(dtype), (count, 3))
        return Illumination(direction, np.full(count, np.inf, dtype), np.full(count, factor, dtype))
