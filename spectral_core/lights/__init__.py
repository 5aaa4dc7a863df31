"""Light sources: where their light comes from and how strong it is, apart from its spectrum.

The geometry of a light (direction and irradiance for one unit of strength) and its spectrum (illuminant and strength)
are kept apart, so that a lamp can be exchanged after the rays have been traced.

Units follow Blender's: a point or spot light of power P (W) gives the irradiance P / (4 pi d^2) on a plane that faces
it at distance d, a flat one P cos / (pi d^2); the strength of a sun is that irradiance itself (W/m^2).

A light that has a size is looked at from one of its points at a time: :class:`LampPoint`. The mean over its points is
the light of the whole, and each point's shadow is exact.
"""

from __future__ import annotations

from typing import TypeAlias

from .area import AREA_SHAPES, AreaLight
from .base import LARGEST_STRENGTH, Illumination, LampPoint, require_strength
from .emitting_mesh import EmittingMesh
from .environment import EnvironmentImage, EnvironmentLight
from .point import PointLight
from .spot import SpotLight
from .sun import SunLight

__all__ = [
    "AREA_SHAPES",
    "LARGEST_STRENGTH",
    "AreaLight",
    "EmittingMesh",
    "EnvironmentImage",
    "EnvironmentLight",
    "Illumination",
    "LampPoint",
    "Light",
    "LightSource",
    "PointLight",
    "SpotLight",
    "SunLight",
    "require_strength",
]

Light: TypeAlias = PointLight | SunLight | SpotLight | AreaLight
"""What a scene lists as its lights."""

LightSource: TypeAlias = Light | EnvironmentLight | EmittingMesh
"""Whatever sends light to surfaces: the scene's lights, its surroundings, and surfaces that emit."""
