"""What a scene requires: the terms of its light, the passes that find them, and the reasons for both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .light_plan import SourcePlan, emitting_materials, plan_sources
from .reflection.materials import Material, TypeI, TypeIII
from .reflection.mirror import mirror_reflectances
from .render_pass import RenderPass
from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra, Term, slots_of_material
from .tracing.geometry import Geometry, bounding_sphere

__all__ = ["MaterialPlan", "RenderPlan", "make_plan"]


MAX_CHAINS = 1024  # lists of terms, each a block of the film, that one depth of mirroring may add


@dataclass(frozen=True, slots=True)
class MaterialPlan:
    """How light from one material enters the film.

    Attributes
    ----------
    index : int
        The material's index in the scene.
    terms : tuple of Term
        For each source of ``RenderPlan.sources`` and each of its filters in turn, one term per component of the
        material.
    mirror_slots : tuple of int or None
        Slots that a mirror bounce multiplies by, None for the constant 1; empty when the material does not mirror.
    emission : Term or None
        What the material sends out by itself.
    """

    index: int
    terms: tuple[Term, ...]
    mirror_slots: tuple[int | None, ...] = ()
    emission: Term | None = None


@dataclass(frozen=True, slots=True)
class RenderPlan:
    """The work that a scene requires.

    Attributes
    ----------
    sources : tuple of SourcePlan
        What can light surfaces: the scene's lights in their order, the world, and materials that emit.
    materials : tuple of MaterialPlan or None
        By material index; None for a material that no triangle uses.
    background : tuple of Term
        The world's terms, when it is seen and not black: one, or one for each primary of its image.
    passes : tuple of RenderPass
        Work that is done or left out, with reasons.
    monomials : tuple of tuple of int
        Products of slots that mirrors may multiply light by, as far as they are kept exactly; the empty one, for
        light that meets no mirror, first.
    exact_depth : int
        How many mirror bounces are kept as products of spectra, 0 to ``RenderSettings.max_bounces``.
    terms : tuple of Term
        All terms that may occur, mirrored ones included, sorted.
    distinct_products : int
        Products of spectra that are integrated, after equal ones are merged.
    """

    sources: tuple[SourcePlan, ...]
    materials: tuple[MaterialPlan | None, ...]
    background: tuple[Term, ...]
    passes: tuple[RenderPass, ...]
    monomials: tuple[tuple[int, ...], ...] = ((),)
    exact_depth: int = 0
    terms: tuple[Term, ...] = ()
    distinct_products: int = 0

    @property
    def lights(self) -> tuple[int, ...]:
        """Indices of the scene's lights that can contribute."""
        return tuple(source.index for source in self.sources if source.kind == "light")

    @property
    def is_sampled(self) -> bool:
        """Whether a source of light takes many points."""
        return any(source.is_extended for source in self.sources)

    @property
    def direct_terms(self) -> tuple[Term, ...]:
        """Terms of the light that meets no mirror, sorted."""
        found = {term for plan in self.materials if plan is not None for term in plan.terms}
        found.update(plan.emission for plan in self.materials if plan is not None and plan.emission is not None)
        found.update(self.background)
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


def make_plan(scene: Scene, settings: RenderSettings, geometry: Geometry | None = None) -> RenderPlan:
    """Find out what a scene requires.

    Parameters
    ----------
    scene : Scene
        The scene.
    settings : RenderSettings
        How it is to be rendered.
    geometry : Geometry, optional
        The scene's triangles where they have been gathered, which tell its extent at no cost.

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

    @cache
    def sphere() -> tuple[NDArray[np.float64], float]:
        return bounding_sphere(scene.instances) if geometry is None else (geometry.centre, geometry.radius)

    passes: list[RenderPass] = []
    image_slots = tuple((len(spectra.slots) - 3 + k,) for k in range(3)) if scene.world.image is not None else ((),)
    emissive = emitting_materials(scene, used)
    sources = plan_sources(scene, image_slots, emissive, sphere, passes)
    materials: list[MaterialPlan | None] = []
    slot = 0
    for index, (name, material) in enumerate(zip(scene.material_names, scene.materials, strict=True)):
        slots = range(slot, slot + len(material.reflectances))
        slot += len(slots_of_material(name, material))
        if index not in used:
            materials.append(None)
            passes.append(RenderPass(f"material '{name}'", False, "no triangle uses it"))
            continue
        # What a metal reflects of the world and of surfaces at grazing angles must be told apart from what is seen of
        # them directly; a lamp is not seen, so its light needs no name for a factor of 1.
        named = {s for s in slots if not spectra.slots[s].is_unit}
        terms = tuple(
            Term(source.emitter, tuple(sorted((*chosen, s) if s in named or source.kind != "light" else chosen)))
            for source in sources
            for chosen in source.filters
            for s in slots
        )
        mirror = _mirror_slots(material, slots, slot - 1) if settings.max_bounces else ()
        emission = Term(emissive[index]) if index in emissive else None
        materials.append(MaterialPlan(index, terms, mirror, emission))
    world = scene.world
    background: tuple[Term, ...] = ()
    if world.strength > 0.0:
        background = tuple(Term(len(scene.lights), chosen) for chosen in image_slots)
        seen = "" if world.camera_visible else ", in mirrors only"
        passes.append(RenderPass("background", True, f"world '{world.name}' has strength {world.strength:g}{seen}"))
    else:
        passes.append(RenderPass("background", False, f"world '{world.name}' is black"))
    passes.append(_lens_pass(scene))
    passes.append(_texture_pass(scene, materials))
    passes.append(_spectral_pass(settings))
    depth, monomials = _chains(settings, materials)
    passes.append(_mirror_pass(scene, settings, materials, depth))
    plan = RenderPlan(tuple(sources), tuple(materials), background, tuple(passes), monomials, depth)
    terms = _multiplied(plan.direct_terms, monomials)
    return replace(plan, terms=terms, distinct_products=spectra.distinct_products(terms))


def _multiplied(terms: Sequence[Term], monomials: Sequence[tuple[int, ...]]) -> tuple[Term, ...]:
    """Multiply all terms by all monomials."""
    products = {Term(t.emitter, tuple(sorted((*t.slots, *monomial)))) for t in terms for monomial in monomials}
    return tuple(sorted(products))


def _lens_pass(scene: Scene) -> RenderPass:
    camera, step = scene.camera, "depth of field"
    if camera is None or not camera.has_lens:
        return RenderPass(step, False, "the camera is a pinhole")
    return RenderPass(step, True, f"a lens of radius {camera.lens_radius:g}, focused at {camera.focus_distance:g}")


def _mirror_slots(material: Material, slots: range, extra: int) -> tuple[int | None, ...]:
    """Slots of the spectra that a mirror bounce multiplies by; `extra` is the material's last slot."""
    spectra = mirror_reflectances(material)
    if not spectra or isinstance(material, TypeI):
        return (None,) * len(spectra)
    if isinstance(material, TypeIII):
        return (slots[0], None)
    return (extra,)


def _used_materials(scene: Scene) -> set[int]:
    used: set[int] = set()
    for instance in scene.instances:
        indices = instance.mesh.material_index
        found: Sequence[int] = [0] if indices is None else np.unique(indices).tolist()
        used.update(found)
    return used


def _mirror_pass(
    scene: Scene, settings: RenderSettings, materials: Sequence[MaterialPlan | None], depth: int
) -> RenderPass:
    step = "mirror bounces"
    mirrors = [plan for plan in materials if plan is not None and plan.mirror_slots]
    if settings.max_bounces == 0:
        return RenderPass(step, False, "the settings allow none")
    if not mirrors:
        return RenderPass(step, False, "no visible material mirrors the scene")
    names = ", ".join(f"'{scene.material_names[plan.index]}'" for plan in mirrors)
    if settings.bounce_spectra == "nodes":
        return RenderPass(
            step, True, f"{names}, up to {settings.max_bounces} deep, carried on the '{settings.bounce_grid}' grid"
        )
    if depth == settings.max_bounces:
        spectra = "kept exactly as products of spectra"
    else:
        spectra = (
            f"kept exactly as products of spectra to depth {depth}; then a pixel's list would pass "
            f"{settings.term_limit} terms, so deeper paths are carried on the '{settings.bounce_grid}' grid"
        )
    return RenderPass(step, True, f"{names}, up to {settings.max_bounces} deep, {spectra}")


def _chains(
    settings: RenderSettings, materials: Sequence[MaterialPlan | None]
) -> tuple[int, tuple[tuple[int, ...], ...]]:
    """Follow all chains of mirrors: how deep they are kept exactly, and the monomials that occur down to there.

    Down to that depth no chain gives a pixel's list of terms more than ``settings.term_limit`` entries, and the chains
    stay below `MAX_CHAINS`.
    """
    found: set[tuple[int, ...]] = {()}
    chains: set[frozenset[tuple[int, ...]]] = {frozenset(found)}
    factors = {plan.mirror_slots for plan in materials if plan is not None and plan.mirror_slots}
    if settings.bounce_spectra == "nodes" or not factors:
        return 0 if settings.bounce_spectra == "nodes" else settings.max_bounces, ((),)
    # Even where no lamp shines, the background is a term.
    widest = max([1, *(len(set(plan.terms)) for plan in materials if plan is not None)])
    is_limited = settings.bounce_spectra == "auto"
    for depth in range(settings.max_bounces):
        longer = set()
        for chain in chains:
            for slots in factors:
                product = frozenset(
                    monomial if slot is None else tuple(sorted((*monomial, slot)))
                    for monomial in chain
                    for slot in slots
                )
                longer.add(product)
                if is_limited and (len(product) * widest > settings.term_limit or len(longer) > MAX_CHAINS):
                    return depth, tuple(sorted(found))
        chains = longer
        found.update(*chains)
    return settings.max_bounces, tuple(sorted(found))


def _texture_pass(scene: Scene, materials: Sequence[MaterialPlan | None]) -> RenderPass:
    reads = []
    for plan in materials:
        if plan is None:
            continue
        found = [t for part in scene.materials[plan.index].textures if part is not None for t in part.textures]
        for texture in dict.fromkeys(found):
            height, width = texture.pixels.shape[:2]
            picture = f"'{texture.name}' ({width} x {height})" if texture.name else f"a picture of {width} x {height}"
            reads.append(f"'{scene.material_names[plan.index]}' reads {picture}")
    if not reads:
        return RenderPass("texture coordinates", False, "no visible material has a texture")
    return RenderPass("texture coordinates", True, "; ".join(reads))


def _spectral_pass(settings: RenderSettings) -> RenderPass:
    if settings.grid == "exact":
        return RenderPass("wavelengths per pixel", False, "each term is integrated once, at 1 nm from 360 to 830 nm")
    return RenderPass(
        "wavelengths per pixel", False, f"each term is integrated once, on the '{settings.grid}' wavelength grid"
    )
