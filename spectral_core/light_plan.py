"""Which sources of light a scene requires, and what stands for them in the render."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lights import AreaLight, EmittingMesh, EnvironmentLight, Light, LightSource, SpotLight
from .render_pass import RenderPass
from .scene import Scene
from .tracing.acceleration import Acceleration

__all__ = ["ENVIRONMENT_POINTS", "SourcePlan", "emitting_materials", "light_sources", "plan_sources"]

ENVIRONMENT_POINTS = 4  # directions of the surroundings that a sample takes; they are much larger than a lamp


@dataclass(frozen=True, slots=True)
class SourcePlan:
    """A source of light that surfaces receive.

    Attributes
    ----------
    kind : str
        "light", "world" or "emission".
    index : int
        Of the light in the scene, or of the material that emits; 0 for the world.
    emitter : int
        Whose spectrum it sends.
    filters : tuple of tuple of int
        Slots that its spectrum is multiplied by, one list for each primary of an image; ((),) where there is none.
    points : int
        Points of it that a sample takes.
    is_extended : bool
        Whether it has a size.
    """

    kind: str
    index: int
    emitter: int
    filters: tuple[tuple[int, ...], ...] = ((),)
    points: int = 1
    is_extended: bool = False


def plan_sources(
    scene: Scene,
    filters: tuple[tuple[int, ...], ...],
    emissive: dict[int, int],
    sphere: Callable[[], tuple[NDArray[np.float64], float]],
    passes: list[RenderPass],
) -> list[SourcePlan]:
    """List what can light the surfaces of a scene.

    Parameters
    ----------
    scene : Scene
        The scene.
    filters : tuple of tuple of int
        Slots of the primaries of the world's image; ((),) without one.
    emissive : dict of int to int
        Emitter of each material that emits.
    sphere : callable
        Gives centre and radius of a sphere around the scene, when asked.
    passes : list of RenderPass
        Gets a line for each source, used or not.

    Returns
    -------
    list of SourcePlan
        The scene's lights, the world, materials.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    return [
        *_lamp_sources(scene, sphere, passes),
        *_world_source(scene, filters, passes),
        *_emission_sources(scene, emissive, passes),
    ]


def _lamp_sources(
    scene: Scene, sphere: Callable[[], tuple[NDArray[np.float64], float]], passes: list[RenderPass]
) -> list[SourcePlan]:
    sources = []
    for index, light in enumerate(scene.lights):
        step = f"shadow rays and shading for light '{light.name}'"
        if light.strength == 0.0:
            passes.append(RenderPass(step, False, "its strength is 0"))
        elif not scene.instances:
            passes.append(RenderPass(step, False, "the scene has no surface"))
        elif _misses(light, *sphere()):
            passes.append(RenderPass(step, False, "it shines past the whole scene"))
        else:
            sources.append(SourcePlan("light", index, index, is_extended=light.is_extended))
            shadow = ("soft shadows" if light.is_extended else "hard shadows") if light.casts_shadow else "no shadows"
            passes.append(
                RenderPass(step, True, f"lit by {light.illuminant.name or 'an unnamed illuminant'}, {shadow}")
            )
    return sources


def _misses(light: Light, centre: NDArray[np.float64], radius: float) -> bool:
    """Whether what a light shines into does not touch the sphere around the scene."""
    if isinstance(light, SpotLight):
        half, extent = 0.5 * light.spot_size, light.radius
    elif isinstance(light, AreaLight):
        half, extent = 0.5 * light.spread, float(np.linalg.norm(light.axis_x) + np.linalg.norm(light.axis_y))
    else:
        return False
    offset = centre - light.position
    distance = float(np.linalg.norm(offset))
    # From any point of the light the scene looks as from its centre, but for the light's own size.
    if distance <= radius + extent:
        return False
    cosine = float(np.clip(offset @ light.direction / distance, -1.0, 1.0))
    return math.acos(cosine) - math.asin((radius + extent) / distance) > half + 1e-6


def _world_source(
    scene: Scene, filters: tuple[tuple[int, ...], ...], passes: list[RenderPass]
) -> tuple[SourcePlan, ...]:
    """The world as a source of light, where it is one."""
    world, step = scene.world, "light from the world"
    if world.strength == 0.0:
        return ()
    if not world.lights_surfaces:
        passes.append(RenderPass(step, False, f"world '{world.name}' is only looked at"))
        return ()
    if not scene.instances:
        passes.append(RenderPass(step, False, "the scene has no surface"))
        return ()
    passes.append(RenderPass(step, True, f"world '{world.name}', {ENVIRONMENT_POINTS} directions a sample"))
    return (SourcePlan("world", 0, len(scene.lights), filters, ENVIRONMENT_POINTS, True),)


def emitting_materials(scene: Scene, used: set[int]) -> dict[int, int]:
    """Find the emitter of each material that emits.

    Parameters
    ----------
    scene : Scene
        The scene.
    used : set of int
        Materials that some triangle has.

    Returns
    -------
    dict of int to int
        Index into ``SceneSpectra.emitters``, by material.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    emitter, found = len(scene.lights) + 1, {}
    for index, emission in enumerate(scene.emissions):
        if emission is None:
            continue
        if index in used and emission.strength > 0.0:
            found[index] = emitter
        emitter += 1
    return found


def _emission_sources(scene: Scene, emissive: dict[int, int], passes: list[RenderPass]) -> list[SourcePlan]:
    sources = []
    for index, emitter in emissive.items():
        emission = scene.emissions[index]
        assert emission is not None
        step = f"light from the surfaces of material '{scene.material_names[index]}'"
        if emission.lights_surfaces:
            sources.append(SourcePlan("emission", index, emitter, is_extended=True))
            passes.append(RenderPass(step, True, f"they emit {emission.illuminant.name or 'an unnamed illuminant'}"))
        else:
            passes.append(RenderPass(step, False, "it is only looked at"))
    return sources


def light_sources(sources: Sequence[SourcePlan], scene: Scene, acceleration: Acceleration) -> tuple[LightSource, ...]:
    """Make the sources of light that a plan lists.

    Parameters
    ----------
    sources : sequence of SourcePlan
        What the plan lists.
    scene : Scene
        The scene.
    acceleration : Acceleration
        Its triangles.

    Returns
    -------
    tuple of LightSource
        One for each.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    made: list[LightSource] = []
    for source in sources:
        if source.kind == "light":
            made.append(scene.lights[source.index])
        elif source.kind == "world":
            made.append(EnvironmentLight(scene.world.image, scene.world.name))
        else:
            emission = scene.emissions[source.index]
            assert emission is not None
            triangles = np.flatnonzero(acceleration.geometry.material_index == source.index)
            made.append(EmittingMesh(acceleration.geometry, acceleration.solids, triangles, emission.name))
    return tuple(made)
