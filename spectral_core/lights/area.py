"""A flat lamp: a rectangle or an ellipse that shines to one side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidParameterError
from ..spectra import Spectrum
from ..tracing.columns import dot_rows
from ..tracing.sampling import disk_points
from ..validation import require_choice, require_in_range
from .base import Floats, Illumination, LampPoint, Vector, check_light, normalise, require_vector

__all__ = ["AREA_SHAPES", "AreaLight"]

AREA_SHAPES = ("rectangle", "ellipse")
"""Outlines of an area light."""

_NARROWEST = math.radians(1.0)
_FLAT_ANGLE = 1e-3  # half spreads below this use the leading term of tan x - x, which would cancel


@dataclass(frozen=True, slots=True)
class AreaLight:
    """An evenly bright rectangle or ellipse that shines to one side.

    Attributes
    ----------
    position : array_like, shape (3,)
        World position of its centre (m).
    axis_x, axis_y : array_like, shape (3,)
        Half of its sides, or the half-axes of the ellipse (m), neither zero nor parallel. It shines to the side
        opposite to axis_x x axis_y, as a lamp of Blender shines along its -Z.
    strength : float
        Power (W), 0 to 1e30.
    illuminant : Spectrum
        Relative spectral power distribution; brought to Y = 1.
    shape : str
        One of `AREA_SHAPES`.
    spread : float
        Full angle into which it shines (rad), 1 degree to pi. pi is a matte emitter; less is one behind a grid, with
        the same power.
    name : str
        Shown in the plan, and the handle for relighting.
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

    position: Vector
    axis_x: Vector
    axis_y: Vector
    strength: float
    illuminant: Spectrum
    shape: str = "rectangle"
    spread: float = math.pi
    name: str = "Area"
    casts_shadow: bool = True
    receivers: frozenset[int] | None = None
    blockers: frozenset[int] | None = None

    def __post_init__(self) -> None:
        for attribute in ("position", "axis_x", "axis_y"):
            value = require_vector(f"{attribute} of light '{self.name}'", getattr(self, attribute))
            object.__setattr__(self, attribute, value)
        check_light(self)
        require_choice(f"shape of light '{self.name}'", self.shape, AREA_SHAPES)
        require_in_range(f"spread of light '{self.name}'", self.spread, _NARROWEST, math.pi, unit="rad")
        with np.errstate(over="ignore", invalid="ignore"):
            cross = np.cross(self.axis_x / self._scale(), self.axis_y / self._scale())
        if not float(np.linalg.norm(cross)) > 0.0:
            raise InvalidParameterError(
                f"axis_x and axis_y of light '{self.name}' must span an area, "
                f"but are {self.axis_x.tolist()} and {self.axis_y.tolist()}"
            )

    def _scale(self) -> float:
        return max(float(np.abs(self.axis_x).max()), float(np.abs(self.axis_y).max()), 1e-300)

    @property
    def direction(self) -> Vector:
        """Unit vector of the side it shines to, (3,)."""
        cross = -np.cross(self.axis_x / self._scale(), self.axis_y / self._scale())
        unit: Vector = cross / np.linalg.norm(cross)
        return unit

    @property
    def is_extended(self) -> bool:
        """Whether the light has a size, so that it takes many points to see it: always."""
        return True

    def lamp_point(self, unit_square: Vector, aim: Vector) -> LampPoint:
        """Choose a point of the lamp.

        Parameters
        ----------
        unit_square : ndarray of float64, shape (3,)
            Random numbers from 0 to 1; the third is not used.
        aim : ndarray of float64, shape (3,)
            Not used.

        Returns
        -------
        LampPoint
            Its position; points lie evenly over the area.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        x, y = 2.0 * unit_square[:2] - 1.0
        if self.shape == "ellipse":
            x, y = disk_points(unit_square[None, :2])[0]
        return LampPoint(self.position + x * self.axis_x + y * self.axis_y)

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
            In the dtype of `points`; zero irradiance behind the lamp.

        Raises
        ------
        ValueError
            From numpy when the shapes do not fit.

        References
        ----------
        A Lambertian emitter of power P has the radiance P / (pi A). The factor (tan h - tan a) / (tan h - h) for a half
        spread h at the angle a is that of a grid of slats, brought to the same power, as Blender's lamp has it.
        """
        position = self.position if at is None or at.position is None else at.position
        distance, to_light = normalise((position - centre).astype(points.dtype) - points)
        cosine = np.clip(-dot_rows(to_light, self.direction.astype(points.dtype)), 0.0, 1.0)
        safe = np.where(distance > 0, distance, np.inf)
        irradiance = cosine / safe / safe / math.pi
        half = 0.5 * self.spread
        if self.spread < math.pi:
            tangent = math.tan(half)
            excess = tangent - half if half > _FLAT_ANGLE else half**3 / 3.0
            sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
            angle = sine / np.maximum(cosine, np.finfo(points.dtype).tiny ** 0.5)
            irradiance = irradiance * np.maximum((tangent - angle) / excess, 0.0)
        return Illumination(to_light, distance, irradiance.astype(points.dtype))
