"""Light from the lamps by way of surfaces to the camera: direct light, and what mirrors show of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import Observer, tristimulus_weights, wavelength_grid
from .film_builder import Deposits, Label
from .light_components import component_of
from .light_plan import SourcePlan
from .lights import Illumination, LampPoint, LightSource
from .paths import PathBundle, Polynomial, merge_bundles, mirror_directions, multiply, product_terms
from .plan import MaterialPlan, RenderPlan
from .reflection.mirror import mirror_coefficients, unmirrored_scales
from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra, Term
from .shading import SurfacePoints, component_coefficients, facing, place_components, spread_textures, surface_points
from .shadow_share import ShadowTally
from .statistics import RenderStatistics
from .tracing.columns import dot_rows
from .tracing.geometry import Geometry
from .tracing.hits import Hits, offset_origins
from .visibility import Visibility

__all__ = ["Transport"]


@dataclass(slots=True)
class Transport:
    """Follows rays from the camera and deposits on the film what they find.

    Attributes
    ----------
    scene, settings, plan, spectra, observer
        What is rendered, and how.
    sources : tuple of LightSource
        Those of the plan.
    geometry, visibility
        Where the surfaces are, and who sees whom.
    film : Deposits
        Takes what is found.
    statistics : RenderStatistics
        Is counted up.
    stop_if_cancelled : callable
        Raises when the caller wants an end.
    """

    scene: Scene
    settings: RenderSettings
    plan: RenderPlan
    spectra: SceneSpectra
    observer: Observer
    sources: tuple[LightSource, ...]
    geometry: Geometry
    visibility: Visibility
    film: Deposits
    statistics: RenderStatistics
    stop_if_cancelled: Callable[[], None]
    _nodes_nm: NDArray[np.float64] = field(init=False)
    _emitter_weights: dict[int, NDArray[np.float64]] = field(init=False, default_factory=dict)
    _luminances: dict[int, NDArray[np.float64]] = field(init=False, default_factory=dict)
    _lamp_points: Sequence[Sequence[LampPoint]] = field(init=False, default=())

    def __post_init__(self) -> None:
        self._nodes_nm = wavelength_grid(self.settings.bounce_grid).wavelengths_nm

    def from_camera(
        self,
        pixels: NDArray[np.int64],
        hits: Hits,
        directions: NDArray[np.floating[Any]],
        lamp_points: Sequence[Sequence[LampPoint]],
    ) -> SurfacePoints:
        """Deposit what one ray a pixel finds, mirrors included.

        Parameters
        ----------
        pixels : ndarray of int64, shape (N,)
            Which of the film's pixels each ray belongs to.
        hits : Hits, N rays
            What the rays met first.
        directions : ndarray, shape (N, 3)
            Their unit directions.
        lamp_points : sequence of sequence of LampPoint
            For each source, the points of it that all rays are lit from.

        Returns
        -------
        SurfacePoints
            The surfaces that the rays met first.

        Raises
        ------
        RenderCancelledError
            If the caller wants an end.

        References
        ----------
        Tominaga 1996, Eqs. 8-13.
        """
        self._lamp_points = lamp_points
        polynomial = Polynomial.one(len(pixels), self.geometry.dtype)
        if self.scene.world.camera_visible:
            self._deposit_background(pixels, hits, directions, polynomial)
        with self.statistics.timed("shading"):
            first = surface_points(self.geometry, hits, directions)
        tally = ShadowTally(first.normal) if self.settings.shadow_share else None
        bundles = self._light(first, pixels, polynomial, 0, tally)
        if tally is not None:
            self.film.count("occluded", pixels[first.ray], tally.occluded)
        for depth in range(1, self.settings.max_bounces + 1):
            arrivals = merge_bundles(bundles)
            bundles = []
            for bundle in arrivals:
                self.stop_if_cancelled()
                self.statistics.mirror_rays += len(bundle)
                with self.statistics.timed("mirrors"):
                    hits = self.visibility.secondary(bundle, self.stop_if_cancelled)
                self._deposit_background(bundle.pixel, hits, bundle.direction, bundle.polynomial)
                with self.statistics.timed("shading"):
                    points = surface_points(self.geometry, hits, bundle.direction)
                bundles += self._light(points, bundle.pixel, bundle.polynomial, depth)
        return first

    def catch_shadows(
        self,
        pixels: NDArray[np.int64],
        hits: Hits,
        directions: NDArray[np.floating[Any]],
        lamp_points: Sequence[Sequence[LampPoint]],
    ) -> SurfacePoints:
        """Deposit what rays find that met a shadow catcher: the background, as far as it is not in the shadow.

        Parameters
        ----------
        pixels : ndarray of int64, shape (N,)
            Which of the film's pixels each ray belongs to; each at most once.
        hits : Hits, N rays
            Where they met the catcher.
        directions : ndarray, shape (N, 3)
            Their unit directions.
        lamp_points : sequence of sequence of LampPoint
            As for :meth:`from_camera`.

        Returns
        -------
        SurfacePoints
            Where they met it.

        Raises
        ------
        RenderCancelledError
            If the caller wants an end.

        References
        ----------
        Own design.
        """
        self._lamp_points = lamp_points
        points = surface_points(self.geometry, hits, directions)
        tally = ShadowTally(points.normal)
        self._direct_light(points, 0, tally, only_tally=True)
        occluded = np.zeros(len(pixels), self.geometry.dtype)
        occluded[points.ray] = tally.occluded
        one = Polynomial.one(len(pixels), self.geometry.dtype)
        if self.scene.world.camera_visible:
            unshadowed = Polynomial(one.monomials, (1.0 - occluded)[:, None])
            self._deposit_background(pixels, None, directions, unshadowed)
        self.film.count_hits(pixels, occluded)
        if self.settings.shadow_share:
            self.film.count("occluded", pixels, occluded)
        return points

    def _light(
        self,
        points: SurfacePoints,
        pixels: NDArray[np.int64],
        polynomial: Polynomial,
        depth: int,
        tally: ShadowTally | None = None,
    ) -> list[PathBundle]:
        """Light the points that rays have reached, and send on those that mirror."""
        for (index, part), coefficients in zip(points.groups(), self._direct_light(points, depth, tally), strict=True):
            material_plan = self.plan.materials[index]
            if material_plan is None:
                continue
            rays = points.ray[part]
            with self.statistics.timed("film"):
                if material_plan.emission is not None:
                    ones = np.ones((len(rays), 1), self.geometry.dtype)
                    self._deposit(pixels[rays], polynomial.take(rays), (material_plan.emission,), ones)
                if material_plan.terms:
                    self._deposit(pixels[rays], polynomial.take(rays), material_plan.terms, coefficients)
        if depth == self.settings.max_bounces:
            return []
        with self.statistics.timed("mirrors"):
            return self._mirrored(points, pixels, polynomial, depth + 1)

    def _direct_light(
        self, points: SurfacePoints, depth: int, tally: ShadowTally | None = None, *, only_tally: bool = False
    ) -> list[NDArray[np.floating[Any]]]:
        """Coefficients of every group of points: for each source and filter in turn, the material's components."""
        groups = [] if only_tally else points.groups()
        materials = [self.scene.materials[index] for index, _ in groups]
        widths = [len(material.textures or material.reflectances) for material in materials]
        columns = sum(len(source.filters) for source in self.plan.sources)
        coefficients = [
            np.zeros((part.stop - part.start, width * columns), self.geometry.dtype)
            for (_, part), width in zip(groups, widths, strict=True)
        ]
        column = 0
        for planned, source, lamp_points in zip(self.plan.sources, self.sources, self._lamp_points, strict=True):
            self.statistics.lit_points.setdefault(source.name, 0)
            for number, at in enumerate(lamp_points):
                self.stop_if_cancelled()
                illumination, facing_it, lit = self._lit(source, at, points, depth)
                if tally is not None:
                    tally.add(illumination, facing_it, lit, self._luminance(planned, at))
                with self.statistics.timed("shading"):
                    for material, (_, part), width, target in zip(materials, groups, widths, coefficients, strict=True):
                        inside = lit[np.searchsorted(lit, part.start) : np.searchsorted(lit, part.stop)]
                        if not len(inside):
                            continue
                        values = component_coefficients(material, points, illumination, inside)
                        if planned.kind != "light" and material.mirror > 0.0 and depth < self.settings.max_bounces:
                            values = values * unmirrored_scales(material).astype(values.dtype)
                        for k in range(len(planned.filters)):
                            share = at.weights[k] / planned.points
                            weighed = values if share == 1.0 else values * values.dtype.type(share)
                            place_components(
                                target, inside - part.start, (column + k) * width, weighed, is_first=number == 0
                            )
            column += len(planned.filters)
        with self.statistics.timed("shading"):
            return [
                spread_textures(material, points, part, target)
                for material, (_, part), target in zip(materials, groups, coefficients, strict=True)
            ]

    def _lit(
        self, source: LightSource, at: LampPoint, points: SurfacePoints, depth: int
    ) -> tuple[Illumination, NDArray[np.int64], NDArray[np.int64]]:
        """What a point of a light would give to surfaces, which of them face it, and which of these it reaches."""
        with self.statistics.timed("shading"):
            illumination = source.illuminate(points.position, self.geometry.centre, at)
            candidates = facing(points, illumination)
            if source.receivers is not None:
                owner = np.take(self.geometry.instance_index, np.take(points.triangle, candidates))
                candidates = candidates[np.isin(owner, list(source.receivers))]
        with self.statistics.timed("shadows"):
            lit = self.visibility.unoccluded(
                source,
                at,
                points,
                illumination,
                candidates,
                is_scattered=depth > 0,
                stop_if_cancelled=self.stop_if_cancelled,
            )
        self.statistics.shadow_rays += len(candidates)
        self.statistics.lit_points[source.name] += len(lit)
        return illumination, candidates, lit

    def _luminance(self, planned: SourcePlan, at: LampPoint) -> float:
        """Luminance of what a point of a source sends, for weighing sources against each other."""
        if planned.emitter not in self._luminances:
            terms = [Term(planned.emitter, chosen) for chosen in planned.filters]
            table = self.spectra.tristimulus_table(terms, self.observer, wavelength_grid(self.settings.grid))
            self._luminances[planned.emitter] = table[:, 1]
        return float(self._luminances[planned.emitter] @ np.asarray(at.weights)) / planned.points

    def _deposit_background(
        self,
        pixels: NDArray[np.int64],
        hits: Hits | None,
        directions: NDArray[np.floating[Any]],
        polynomial: Polynomial,
    ) -> None:
        """Deposit the background where rays have met nothing; without hits, everywhere."""
        if not self.plan.background:
            return
        missed = np.arange(len(pixels)) if hits is None else np.flatnonzero(~hits.hit)
        image = self.scene.world.image
        if image is None:
            seen: NDArray[np.floating[Any]] = np.ones((len(missed), 1), self.geometry.dtype)
        else:
            seen = image.radiance(np.take(directions, missed, axis=0)).astype(self.geometry.dtype)
        self._deposit(pixels[missed], polynomial.take(missed), self.plan.background, seen)

    def _deposit(
        self,
        pixels: NDArray[np.int64],
        polynomial: Polynomial,
        terms: tuple[Term, ...],
        coefficients: NDArray[np.floating[Any]],
    ) -> None:
        if not len(pixels):
            return
        if polynomial.monomials is None:
            for label, colour in self._colours_at_nodes(polynomial, terms, coefficients).items():
                self.film.deposit_colour(pixels, colour, label)
        elif polynomial.monomials == ((),):
            self.film.deposit(terms, pixels, coefficients * polynomial.weights)
        else:
            products, values = product_terms(polynomial, terms, coefficients)
            self.film.deposit(products, pixels, values)

    def _colours_at_nodes(
        self, polynomial: Polynomial, terms: tuple[Term, ...], coefficients: NDArray[np.floating[Any]]
    ) -> dict[Label, NDArray[np.float64]]:
        """XYZ (N, 3) of light that is carried at the nodes of the bounce grid; by component and emitter, if asked."""
        grid = wavelength_grid(self.settings.bounce_grid)
        columns: dict[tuple[int, Label], list[int]] = {}
        for k, term in enumerate(terms):
            label = (self._component(term), term.emitter) if self.settings.split_light else None
            columns.setdefault((term.emitter, label), []).append(k)
        colours: dict[Label, NDArray[np.float64]] = {}
        for (emitter, label), some in sorted(columns.items()):
            if emitter not in self._emitter_weights:
                source = self.spectra.emitters[emitter]
                weights = tristimulus_weights(source.illuminant, self.observer, grid)
                self._emitter_weights[emitter] = source.strength * weights
            table = np.array([self.spectra.product_at(terms[k].slots, self._nodes_nm) for k in some])
            spectrum = (coefficients[:, some] @ table) * polynomial.weights
            colour = spectrum @ self._emitter_weights[emitter]
            colours[label] = colours[label] + colour if label in colours else colour
        return colours

    def _component(self, term: Term) -> str:
        """Component of light that mirrors have passed on: what was emission has met their interfaces."""
        component = component_of(term, self.spectra)
        return "interface" if component == "emission" else component

    def _mirrored(
        self, points: SurfacePoints, pixels: NDArray[np.int64], polynomial: Polynomial, depth: int
    ) -> list[PathBundle]:
        """Rays that leave the mirroring surfaces among `points`, on their `depth`-th bounce."""
        bundles = []
        for index, part in points.groups():
            material_plan = self.plan.materials[index]
            if material_plan is None or not material_plan.mirror_slots:
                continue
            bundles.append(self._reflect(points, part, pixels, polynomial, material_plan, depth))
        return bundles

    def _reflect(
        self,
        points: SurfacePoints,
        part: slice,
        pixels: NDArray[np.int64],
        polynomial: Polynomial,
        material_plan: MaterialPlan,
        depth: int,
    ) -> PathBundle:
        rays = points.ray[part]
        direction = mirror_directions(points, part)
        origin = offset_origins(points.position[part], points.geometric_normal[part], direction, self.geometry.radius)
        cosine = dot_rows(points.normal[part], points.to_viewer[part])
        weights = mirror_coefficients(self.scene.materials[material_plan.index], np.clip(cosine, 0, 1))
        arriving = polynomial.take(rays)
        if depth > self.plan.exact_depth:
            arriving = arriving.at_nodes(self.spectra, self._nodes_nm)
        product = multiply(arriving, weights, material_plan.mirror_slots, self.spectra, self._nodes_nm)
        return PathBundle(pixels[rays], origin, direction, points.triangle[part], product)
