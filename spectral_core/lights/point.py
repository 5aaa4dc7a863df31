"""A lamp that radiates equally in all directions: a point, or a sphere."""

from __future__ import annotations

from dataclasses import dataclass

from ..spectra import Spectrum
from ..validation import require_in_range
from .base import Floats, Illumination, LampPoint, Vector, check_light, require_vector
from .sphere import sphere_illumination, sphere_point

__all__ = ["PointLight"]


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
        Radius of the emitting sphere (m); its shadows are soft. 0 is a point, with hard ones.
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
    strength: float
    illuminant: Spectrum
    name: str = "Point"
    radius: float = 0.0
    casts_shadow: bool = True
    receivers: frozenset[int] | None = None
    soft_falloff: bool = False
    blockers: frozenset[int] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", require_vector(f"position of light '{self.name}'", self.position))
        check_light(self)
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
            In the dtype of `points`.

        Raises
        ------
        ValueError
            From numpy when the shapes do not fit.

        References
        ----------
        Inverse square law; the unit is that of Blender's point light. For spheres see
        :func:`~spectral_core.lights.sphere.sphere_irradiance`.
        """
        return sphere_illumination(self, points, centre, at)
