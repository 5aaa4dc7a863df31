"""Scene in, film out: bands of rows are worked off one after the other, with progress and cancel between them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import Observer, WavelengthGrid, observer, wavelength_grid
from .errors import InvalidParameterError, RenderCancelledError, SceneError
from .film import Film, FilmBuilder
from .plan import RenderPlan, make_plan
from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra
from .shading import component_coefficients, facing, surface_points
from .statistics import RenderStatistics
from .tracing.camera import Camera
from .tracing.geometry import Geometry
from .tracing.sampling import pixel_offsets
from .visibility import Visibility

__all__ = ["Band", "Cancel", "Progress", "Render", "render"]

Progress = Callable[[float, str], None]
Cancel = Callable[[], bool]


@dataclass(frozen=True, slots=True)
class Band:
    """A finished run of whole rows, for showing an image while it is made.

    Attributes
    ----------
    first_row : int
        Row 0 is the top.
    tristimulus : ndarray, shape (rows, width, 3)
        X, Y, Z.
    coverage : ndarray, shape (rows, width)
        Part of the samples that met a surface.
    """

    first_row: int
    tristimulus: NDArray[np.floating[Any]]
    coverage: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Render:
    """A finished render: the film, the spectra it was made with, and what it took.

    Attributes
    ----------
    film : Film
        Coefficients by term.
    spectra : SceneSpectra
        The spectral side of the scene.
    observer : str
        Name of the observer.
    grid : str
        Name of the wavelength grid.
    depth : ndarray of float32, shape (height, width)
        Distance along the view axis (m) of the first sample of each pixel; infinite where it met nothing.
    statistics : RenderStatistics
        Counts and times.
    """

    film: Film
    spectra: SceneSpectra
    observer: str
    grid: str
    depth: NDArray[np.float32]
    statistics: RenderStatistics

    @property
    def alpha(self) -> NDArray[np.float32]:
        """Part of each pixel that is covered by surfaces, shape (height, width), 0 to 1."""
        return self.film.coverage

    def tristimulus(self) -> NDArray[np.floating[Any]]:
        """Colour of every pixel.

        Returns
        -------
        ndarray, shape (height, width, 3)
            X, Y, Z; row 0 is the top; Y = 1 for a perfect diffuser under an irradiance of pi.

        Raises
        ------
        InvalidParameterError
            If a spectrum is invalid.

        References
        ----------
        Tominaga 1996, Eqs. 4 and 7-10.
        """
        if self.film.fixed_tristimulus is not None:
            return self.film.fixed_tristimulus
        return self.film.tristimulus(self.spectra, observer(self.observer), wavelength_grid(self.grid))

    def relit(self, spectra: SceneSpectra) -> Render:
        """Return the same render with other spectra; no ray is traced.

        Parameters
        ----------
        spectra : SceneSpectra
            Changed with ``SceneSpectra.with_light`` or ``with_reflectance``.

        Returns
        -------
        Render
            Shares the film.

        Raises
        ------
        InvalidParameterError
            If the film could not be kept by terms, or the spectra have other slots.

        References
        ----------
        Own design.
        """
        if not self.film.is_relightable:
            raise InvalidParameterError(
                "this render reached its memory limit and kept plain colour: it cannot be relit"
            )
        if len(spectra.emitters) != len(self.spectra.emitters) or len(spectra.slots) != len(self.spectra.slots):
            raise InvalidParameterError("the spectra belong to another scene: lights or reflectances differ in number")
        return replace(self, spectra=spectra)


def render(
    scene: Scene,
    settings: RenderSettings | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    on_band: Callable[[Band], None] | None = None,
) -> Render:
    """Render a scene.

    Parameters
    ----------
    scene : Scene
        What to render; it needs a camera.
    settings : RenderSettings, optional
        How; the defaults when left out.
    progress : callable, optional
        Called as ``progress(fraction, message)`` between bands; fraction 0 to 1.
    cancel : callable, optional
        Asked between bands, samples and lights; a true answer stops the render.
    on_band : callable, optional
        Called with each finished :class:`Band`, from the top down.

    Returns
    -------
    Render
        The film and what goes with it.

    Raises
    ------
    SceneError
        If the scene has no camera.
    InvalidParameterError
        If a spectrum or parameter is invalid.
    RenderCancelledError
        If `cancel` said so.

    References
    ----------
    Tominaga 1996, Eqs. 4-13, traced as the paper's Applications section does, with spectra kept out of the pixels.
    """
    settings = settings or RenderSettings()
    if scene.camera is None:
        raise SceneError(f"scene '{scene.name}' has no camera")
    job = _Job.prepare(scene, scene.camera, settings, progress or _ignore_progress, cancel or _never)
    rows = max(1, settings.band_samples // settings.width)
    bands = math.ceil(settings.height / rows)
    for number in range(bands):
        first = number * rows
        last = min(first + rows, settings.height)
        job.progress(number / bands, f"rows {first + 1} to {last} of {settings.height}")
        job.render_band(first, last, on_band)
    result = job.finish()
    job.progress(1.0, "done")
    return result


def _ignore_progress(fraction: float, message: str) -> None:
    """Stand in for a progress callable."""


def _never() -> bool:
    return False


@dataclass(slots=True)
class _Job:
    """One render under way."""

    scene: Scene
    camera: Camera
    settings: RenderSettings
    progress: Progress
    cancel: Cancel
    plan: RenderPlan
    spectra: SceneSpectra
    observer: Observer
    grid: WavelengthGrid
    geometry: Geometry
    visibility: Visibility
    offsets: NDArray[np.float64]
    film: FilmBuilder
    depth: NDArray[np.float32]
    statistics: RenderStatistics = field(default_factory=RenderStatistics)
    started: float = 0.0

    @classmethod
    def prepare(
        cls, scene: Scene, camera: Camera, settings: RenderSettings, progress: Progress, cancel: Cancel
    ) -> _Job:
        started = time.perf_counter()
        progress(0.0, "planning")
        plan = make_plan(scene, settings)
        spectra = SceneSpectra.from_scene(scene)
        dtype = np.float64 if settings.precision == "float64" else np.float32
        sees, grid = observer(settings.observer), wavelength_grid(settings.grid)
        # The spectra are integrated before the first ray: a lamp without luminance should fail now, not after minutes.
        spectra.tristimulus_table(plan.terms, sees, grid)
        progress(0.0, "gathering triangles")
        geometry = Geometry.from_instances(scene.instances, dtype)
        statistics = RenderStatistics(
            scene=scene.name,
            width=settings.width,
            height=settings.height,
            samples=settings.samples,
            triangles=geometry.triangle_count,
            dropped_triangles=geometry.dropped,
            plan=plan.describe(),
        )
        if cancel():
            raise RenderCancelledError("the render was cancelled")
        progress(0.0, f"sorting {geometry.triangle_count} triangles")
        visibility = Visibility(geometry, camera, settings.width, settings.height)
        statistics.seconds["geometry"] = time.perf_counter() - started
        return cls(
            scene=scene,
            camera=camera,
            settings=settings,
            progress=progress,
            cancel=cancel,
            plan=plan,
            spectra=spectra,
            observer=sees,
            grid=grid,
            geometry=geometry,
            visibility=visibility,
            offsets=pixel_offsets(settings.samples, settings.pixel_filter, settings.filter_width, settings.seed),
            film=FilmBuilder(
                settings.width, settings.height, settings.samples, dtype, spectra, sees, grid, settings.film_bytes
            ),
            depth=np.full((settings.height, settings.width), np.inf, np.float32),
            statistics=statistics,
            started=started,
        )

    def stop_if_cancelled(self) -> None:
        if self.cancel():
            raise RenderCancelledError("the render was cancelled")

    def render_band(self, first: int, last: int, on_band: Callable[[Band], None] | None) -> None:
        width = self.settings.width
        pixels = np.arange(first * width, last * width)
        for number, offset in enumerate(self.offsets):
            self.stop_if_cancelled()
            self._render_sample(pixels, first, last, offset, is_first=number == 0)
        with self.statistics.timed("film"):
            part = self.film.end_band(first, last)
        if on_band is not None:
            on_band(Band(first, part.tristimulus(self.spectra, self.observer, self.grid), part.coverage))

    def _render_sample(
        self, pixels: NDArray[np.int64], first: int, last: int, offset: NDArray[np.float64], *, is_first: bool
    ) -> None:
        statistics = self.statistics
        with statistics.timed("visibility"):
            hits, directions, view_depth = self.visibility.primary(first, last, offset)
        statistics.camera_rays += len(pixels)
        with statistics.timed("shading"):
            found = hits.hit
            self.film.count_hits(pixels[found])
            if is_first:
                self.depth.reshape(-1)[pixels[found]] = view_depth[found]
            if self.plan.background is not None:
                missed = pixels[~found]
                self.film.deposit((self.plan.background,), missed, np.ones((len(missed), 1), self.geometry.dtype))
            points = surface_points(self.geometry, hits, pixels, directions)
            groups = points.groups()
            widths = [len(self.scene.materials[index].reflectances) for index, _ in groups]
            coefficients = [
                np.zeros((part.stop - part.start, width * len(self.plan.lights)), self.geometry.dtype)
                for (_, part), width in zip(groups, widths, strict=True)
            ]
        for column, light_index in enumerate(self.plan.lights):
            self.stop_if_cancelled()
            light = self.scene.lights[light_index]
            with statistics.timed("shading"):
                illumination = light.illuminate(points.position, self.geometry.centre)
                candidates = facing(points, illumination)
            with statistics.timed("shadows"):
                lit = self.visibility.unoccluded(light, points, illumination, candidates)
            statistics.shadow_rays += len(candidates)
            with statistics.timed("shading"):
                for (index, part), width, target in zip(groups, widths, coefficients, strict=True):
                    inside = lit[np.searchsorted(lit, part.start) : np.searchsorted(lit, part.stop)]
                    if len(inside):
                        target[inside - part.start, column * width : (column + 1) * width] = component_coefficients(
                            self.scene.materials[index], points, illumination, inside
                        )
        with statistics.timed("film"):
            for (index, part), values in zip(groups, coefficients, strict=True):
                material_plan = self.plan.materials[index]
                if material_plan is not None and material_plan.terms:
                    self.film.deposit(material_plan.terms, points.pixel[part], values)

    def finish(self) -> Render:
        with self.statistics.timed("film"):
            film = self.film.finish()
        self.statistics.film_bytes = film.nbytes
        self.statistics.terms = len(film.terms)
        self.statistics.is_relightable = film.is_relightable
        self.statistics.seconds["total"] = time.perf_counter() - self.started
        return Render(film, self.spectra, self.settings.observer, self.settings.grid, self.depth, self.statistics)
