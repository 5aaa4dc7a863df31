"""What a scene requires: the terms of its light, the passes that find them, and the reasons for both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra, Term

__all__ = ["MaterialPlan", "RenderPass", "RenderPlan", "make_plan"]


@dataclass(frozen=True, slots=True)
class RenderPass:
    """One kind of work, done or left out.

    Attributes
    ----------
    name : str
        What would be done.
    is_needed : bool
        Whether it is.
    reason : str
        Why, or why not.
    """

    name: str
    is_needed: bool
    reason: str


@dataclass(frozen=True, slots=True)
class MaterialPlan:
    """How light from one material enters the film.

    Attributes
    ----------
    index : int
        The material's index in the scene.
    terms : tuple of Term
        For each light of ``RenderPlan.lights`` in turn, one term per component of the material.
    """

    index: int
    terms: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class RenderPlan:
    """The work that a scene requires.

    Attributes
    ----------
    lights : tuple of int
        Indices of the lights that can contribute.
    materials : tuple of MaterialPlan or None
        By material index; None for a material that no triangle uses.
    background : Term or None
        The world's term, when it is seen and not black.
    passes : tuple of RenderPass
        Work that is done or left out, with reasons.
    distinct_products : int
        Products of spectra that are integrated, after equal ones are merged.
    """

    lights: tuple[int, ...]
    materials: tuple[MaterialPlan | None, ...]
    background: Term | None
    passes: tuple[RenderPass, ...]
    distinct_products: int

    @property
    def terms(self) -> tuple[Term, ...]:
        """All terms that may occur, sorted."""
        found = {term for plan in self.materials if plan is not None for term in plan.terms}
        if self.background is not None:
            found.add(self.background)
        return tuple(sorted(found))

    def describe(self) -> str:
        """Say in words what is computed and what is not.

        Returns
        -------
        str
            One line a fact.

        Raises
        ------
        None

        References
        ----------
        Own design.
        """
        lines = [
            f"{len(self.terms)} terms (spectra multiplied along a path), "
            f"{self.distinct_products} distinct products integrated"
        ]
        lines.extend(f"{'+' if step.is_needed else '-'} {step.name}: {step.reason}" for step in self.passes)
        return "\n".join(lines)


def make_plan(scene: Scene, settings: RenderSettings) -> RenderPlan:
    """Find out what a scene requires.

    Parameters
    ----------
    scene : Scene
        The scene.
    settings : RenderSettings
        How it is to be rendered.

    Returns
    -------
    RenderPlan
        Terms, passes and reasons.

    Raises
    ------
    InvalidParameterError
        If the scene's spectra are invalid.

    References
    ----------
    Own design.
    """
    spectra = SceneSpectra.from_scene(scene)
    used = _used_materials(scene)
    passes: list[RenderPass] = []
    lights = []
    for index, light in enumerate(scene.lights):
        step = f"shadow rays and shading for light '{light.name}'"
        if light.strength == 0.0:
            passes.append(RenderPass(step, False, "its strength is 0"))
        elif not scene.instances:
            passes.append(RenderPass(step, False, "the scene has no surface"))
        else:
            lights.append(index)
            passes.append(RenderPass(step, True, f"lit by {light.illuminant.name or 'an unnamed illuminant'}"))
    materials: list[MaterialPlan | None] = []
    slot = 0
    for index, (name, material) in enumerate(zip(scene.material_names, scene.materials, strict=True)):
        slots = range(slot, slot + len(material.reflectances))
        slot += len(slots)
        if index not in used:
            materials.append(None)
            passes.append(RenderPass(f"material '{name}'", False, "no triangle uses it"))
            continue
        terms = tuple(Term(light, (s,)) for light in lights for s in slots)
        materials.append(MaterialPlan(index, terms))
    world = scene.world
    if world.strength > 0.0:
        background = Term(len(scene.lights))
        passes.append(RenderPass("background", True, f"world '{world.name}' has strength {world.strength:g}"))
    else:
        background = None
        passes.append(RenderPass("background", False, f"world '{world.name}' is black"))
    passes.append(_spectral_pass(settings))
    plan = RenderPlan(tuple(lights), tuple(materials), background, tuple(passes), 0)
    return RenderPlan(plan.lights, plan.materials, plan.background, plan.passes, spectra.distinct_products(plan.terms))


def _used_materials(scene: Scene) -> set[int]:
    used: set[int] = set()
    for instance in scene.instances:
        indices = instance.mesh.material_index
        found: Sequence[int] = [0] if indices is None else np.unique(indices).tolist()
        used.update(found)
    return used


def _spectral_pass(settings: RenderSettings) -> RenderPass:
    if settings.grid == "exact":
        return RenderPass("wavelengths per pixel", False, "each term is integrated once, at 1 nm from 360 to 830 nm")
    return RenderPass(
        "wavelengths per pixel", False, f"each term is integrated once, on the '{settings.grid}' wavelength grid"
    )
