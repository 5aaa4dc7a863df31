"""From Blender's lights to the core's, in Cycles' units."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import compat
from ._core import core
from .light_colours import LightColour

__all__ = ["read_light"]

_WIDEST_SPREAD = math.pi
_NARROWEST_SPREAD = math.radians(1.0)  # what Blender offers as the least


def read_light(
    light: Any, matrix_world: Any, colour: LightColour, notes: list[str], receivers: frozenset[int] | None = None
) -> Any | None:
    """Convert an evaluated light to the core's.

    Parameters
    ----------
    light : bpy.types.Light
        Evaluated.
    matrix_world : array_like, shape (4, 4)
        Where it is.
    colour : LightColour
        Its spectrum.
    notes : list of str
        What is approximated is added.
    receivers : frozenset of int, optional
        The instances that it lights; None for all.

    Returns
    -------
    Light or None
        None (and a note) where it gives no light.

    Raises
    ------
    InvalidParameterError
        If a number of the light breaks a rule of the core.
    """
    name = light.name
    if light.type == "AREA" and light.cycles.is_portal:
        return None  # a window for Cycles' sampling, no lamp
    matrix = np.array(matrix_world, dtype=np.float64)
    strength = float(light.energy) * compat.light_exposure_factor(light) * colour.factor
    if strength < 0.0:
        notes.append(f"light '{name}' has a negative strength ({strength:g}), which is no light: left out")
        return None
    if not compat.light_is_normalized(light):
        strength *= _emitting_area(light, matrix)
    if strength == 0.0:
        return None
    shared: dict[str, Any] = {"name": name, "casts_shadow": bool(light.use_shadow), "receivers": receivers}
    position, axis = matrix[:3, 3], matrix[:3, 2]  # a lamp shines along its own -Z
    if light.type == "SUN":
        return core.SunLight(axis, strength, colour.illuminant, angle=min(float(light.angle), math.pi), **shared)
    if light.type == "AREA":
        return _area(light, matrix, strength, colour.illuminant, shared, notes)
    radius = float(light.shadow_soft_size)
    shared["soft_falloff"] = bool(light.use_soft_falloff)
    if light.type == "POINT":
        return core.PointLight(position, strength, colour.illuminant, radius=radius, **shared)
    if getattr(light, "use_square", False):
        notes.append(f"spot '{name}' has a square cone, which EEVEE alone shows: a round one is rendered, as by Cycles")
    return core.SpotLight(
        position,
        -axis,
        strength,
        colour.illuminant,
        spot_size=float(light.spot_size),
        blend=float(light.spot_blend),
        radius=radius,
        **shared,
    )


def _area(
    light: Any, matrix: np.ndarray, strength: float, illuminant: core.Spectrum, shared: dict[str, Any], notes: list[str]
) -> Any | None:
    """Make an area light; the scale of its object scales it, as in Cycles."""
    size_x, size_y = _sides(light)
    axis_x, axis_y = 0.5 * size_x * matrix[:3, 0], 0.5 * size_y * matrix[:3, 1]
    if np.cross(axis_x, axis_y) @ matrix[:3, 2] < 0.0:  # a mirrored object: it still shines along its own -Z
        axis_y = -axis_y
    if not np.linalg.norm(np.cross(axis_x, axis_y)) > 0.0:
        notes.append(f"area light '{light.name}' has no area: left out")
        return None
    return core.AreaLight(
        matrix[:3, 3],
        axis_x,
        axis_y,
        strength,
        illuminant,
        shape="ellipse" if light.shape in {"DISK", "ELLIPSE"} else "rectangle",
        spread=min(max(float(light.spread), _NARROWEST_SPREAD), _WIDEST_SPREAD),
        **shared,
    )


def _sides(light: Any) -> tuple[float, float]:
    return float(light.size), float(light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size)


def _emitting_area(light: Any, matrix: np.ndarray) -> float:
    """Return the factor by which Cycles multiplies a light that is not normalised (measured on Cycles 4.5)."""
    if light.type == "SUN":
        half = 0.5 * light.angle
        return math.pi * math.sin(half) ** 2 if half > 0.0 else 1.0
    if light.type in {"POINT", "SPOT"}:
        radius = light.shadow_soft_size
        return 4.0 * math.pi * radius**2 if radius > 0.0 else 4.0
    size_x, size_y = _sides(light)
    area = size_x * size_y * float(np.linalg.norm(np.cross(matrix[:3, 0], matrix[:3, 1])))
    return area * math.pi / 4.0 if light.shape in {"DISK", "ELLIPSE"} else area
