"""From Blender's lights and world to the core's, in Cycles' units."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import compat
from ._core import core

__all__ = ["read_light", "read_world_colour"]


def read_light(light: Any, matrix_world: Any, illuminant: Any, factor: float, notes: list[str]) -> Any | None:
    """Convert an evaluated light to the core's, or return None (and a note) when it gives no light.

    `factor` is the luminance of the light's own colour, with which Cycles multiplies the power.
    """
    name = light.name
    matrix = np.array(matrix_world, dtype=np.float64)
    position = matrix[:3, 3]
    axis = matrix[:3, 2]  # a lamp shines along its own -Z
    strength = float(light.energy) * compat.light_exposure_factor(light) * factor
    if strength < 0.0:
        notes.append(f"light '{name}' has a negative strength ({strength:g}), which is no light: left out")
        return None
    if strength == 0.0:
        return None
    if not compat.light_is_normalized(light):
        strength *= _emitting_area(light)
    _note_what_is_not_rendered(light, notes)
    extent = _extent(light)
    if light.type == "POINT":
        return core.PointLight(position, strength, illuminant, name=name, radius=extent)
    if light.type == "SUN":
        return core.SunLight(axis, strength, illuminant, name=name, angle=min(extent, math.pi))
    if light.type == "SPOT":
        return core.SpotLight(
            position,
            -axis,
            strength,
            illuminant,
            spot_size=float(light.spot_size),
            blend=float(light.spot_blend),
            name=name,
            radius=extent,
        )
    notes.append(
        f"area light '{name}' is approximated: its whole power comes from its centre, with a falloff near the "
        "cosine of a flat emitter; its shape and its soft shadow are not rendered"
    )
    # On its axis a flat emitter of power P has four times the intensity of a point of that power (P/pi, not P/4pi).
    # A spot of 180 degrees with full blend falls off as c^2 (3 - 2 c), within 0.1 of the wanted cosine c.
    return core.SpotLight(position, -axis, 4.0 * strength, illuminant, spot_size=math.pi, blend=1.0, name=name)


def _extent(light: Any) -> float:
    """Return the radius of a point or spot light (m), the angle of a sun (rad)."""
    if light.type == "SUN":
        return float(light.angle)
    return float(light.shadow_soft_size) if light.type in {"POINT", "SPOT"} else 0.0


def _emitting_area(light: Any) -> float:
    """Return the factor by which Cycles multiplies a light that is not normalised (measured on Cycles 4.5)."""
    if light.type == "SUN":
        half = 0.5 * light.angle
        return math.pi * math.sin(half) ** 2 if half > 0.0 else 1.0
    if light.type in {"POINT", "SPOT"}:
        radius = light.shadow_soft_size
        return 4.0 * math.pi * radius**2 if radius > 0.0 else 4.0
    size_x = light.size
    size_y = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    area = size_x * size_y
    return float(area * math.pi / 4.0 if light.shape in {"DISK", "ELLIPSE"} else area)


def _note_what_is_not_rendered(light: Any, notes: list[str]) -> None:
    name = light.name
    if compat.node_tree_of(light) is not None and _has_custom_nodes(light):
        notes.append(f"light '{name}' has its own shader nodes: their strength and textures are not rendered")
    if not light.use_shadow:
        notes.append(f"light '{name}' casts shadows although its shadow is switched off")
    if light.type != "AREA" and _extent(light) > 0.0:
        notes.append(f"light '{name}' casts a hard shadow: its size is not rendered")
    if light.type == "SPOT" and getattr(light, "use_square", False):
        notes.append(f"spot '{name}' has a square cone: a round one is rendered")


def _has_custom_nodes(light: Any) -> bool:
    """Whether the node tree differs from the one that Blender makes (one emission of strength 1)."""
    for node in compat.node_tree_of(light).nodes:
        if node.bl_idname == "ShaderNodeEmission":
            strength = node.inputs["Strength"]
            if strength.is_linked or node.inputs["Color"].is_linked or strength.default_value != 1.0:
                return True
        elif node.bl_idname != "ShaderNodeOutputLight":
            return True
    return False


def read_world_colour(world: Any, notes: list[str]) -> tuple[tuple[float, float, float], float]:
    """Return the scene-linear colour and the strength of a world's background; what is approximated goes to `notes`."""
    if world is None:
        return (0.0, 0.0, 0.0), 0.0
    tree = compat.node_tree_of(world)
    if tree is None:
        red, green, blue = world.color
        return (red, green, blue), 1.0
    output = next((n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputWorld" and n.is_active_output), None)
    if output is None or not output.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0), 0.0
    background = output.inputs["Surface"].links[0].from_node
    if background.bl_idname != "ShaderNodeBackground":
        notes.append(f"world '{world.name}': the node '{background.name}' is not understood, the background is black")
        return (0.0, 0.0, 0.0), 0.0
    colour, strength = background.inputs["Color"], background.inputs["Strength"]
    notes.extend(
        f"world '{world.name}': what is linked to {socket.name} of '{background.name}' is not rendered; "
        "the socket's own value is used"
        for socket in (colour, strength)
        if socket.is_linked
    )
    red, green, blue, _ = colour.default_value
    return (red, green, blue), float(strength.default_value)
