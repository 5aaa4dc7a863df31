"""Scene in, film out: bands of rows are worked off one after the other, with progress and cancel between them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
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
from .statistics import RenderStatistics
from .tracing.camera import Camera
from .tracing.geometry import Geometry
from .tracing.sampling import pixel_offsets
from .transport import Transport
from .validation import require_integer
from .visibility import Visibility

__all__ = ["Band", "Cancel", "Progress", "Render", "render", "render_bands"]

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
        return self.film.tristimulus(
            self.spectra, observer(self.observer), wavelength_grid(self.grid), own_spectra=True
        )

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
            If the film could not be kept by terms, the spectra have other slots, or a light is turned on that was dark
            when the rays were traced.

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
        kept = {term.emitter for term in self.film.terms}
        for index, (old, new) in enumerate(zip(self.spectra.emitters, spectra.emitters, strict=True)):
            if old.strength == 0.0 and new.strength > 0.0 and index not in kept:
                raise InvalidParameterError(
                    f"this render holds no light of '{new.name}': it was dark when the rays were traced, or reaches no "
                    "pixel; render again to light it"
                )
        return replace(self, spectra=spectra)


def render(
    scene: Scene,
    settings: RenderSettings | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    on_band: Callable[[Band], None] | None = None,
    rows: int | None = None,
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
    rows : int, optional
        Render only so many rows, spread evenly over the picture, each as thin as one of the whole; the render is so
        high. A cheap and fair sample of the picture.

    Returns
    -------
    Render
        The film and what goes with it.

    Raises
    ------
    SceneError
        If the scene has no camera.
    InvalidParameterError
        If a spectrum or parameter is invalid, or `rows` is not between 1 and the height.
    RenderCancelledError
        If `cancel` said so.

    References
    ----------
    Tominaga 1996, Eqs. 4-13, traced as the paper's Applications section does, with spectra kept out of the pixels.
    """
    settings = settings or RenderSettings()
    if scene.camera is None:
        raise SceneError(f"scene '{scene.name}' has no camera")
    thinness = 1.0
    if rows is not None:
        require_integer("rows", rows, 1, settings.height)
        thinness = rows / settings.height
        settings = replace(settings, height=rows)
    job = _Job.prepare(scene, scene.camera, settings, progress or _ignore_progress, cancel or _never)
    job.offsets[:, 1] = 0.5 + (job.offsets[:, 1] - 0.5) * thinness
    bands = _bands(settings)
    for number, (first, last) in enumerate(bands):
        job.progress(number / len(bands), f"rows {first + 1} to {last} of {settings.height}")
        job.render_band(first, last, on_band)
    result = job.finish()
    job.progress(1.0, "done")
    return result


def render_bands(
    scene: Scene, settings: RenderSettings | None = None, *, geometry: Geometry | None = None
) -> Iterator[Band]:
    """Render a scene band by band, at the caller's pace: for views that must answer between two bands.

    Parameters
    ----------
    scene : Scene
        What to render; it needs a camera.
    settings : RenderSettings, optional
        How; the defaults when left out. ``band_samples`` bounds the work between two bands.
    geometry : Geometry, optional
        The triangles of the scene's instances, gathered earlier in the settings' precision.

    Yields
    ------
    Band
        From the top down.

    Raises
    ------
    SceneError
        If the scene has no camera.
    InvalidParameterError
        If a spectrum or parameter is invalid.

    References
    ----------
    As :func:`render`.
    """
    settings = settings or RenderSettings()
    if scene.camera is None:
        raise SceneError(f"scene '{scene.name}' has no camera")
    job = _Job.prepare(scene, scene.camera, settings, _ignore_progress, _never, geometry)
    for first, last in _bands(settings):
        finished: list[Band] = []
        job.render_band(first, last, finished.append)
        yield from finished


def _bands(settings: RenderSettings) -> list[tuple[int, int]]:
    """Cut the rows into bands that keep to the bound of rays in memory."""
    height = max(1, settings.band_samples // settings.width)
    return [(row, min(row + height, settings.height)) for row in range(0, settings.height, height)]


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
    stop_if_cancelled: Callable[[], None]
    plan: RenderPlan
    spectra: SceneSpectra
    observer: Observer
    grid: WavelengthGrid
    geometry: Geometry
    visibility: Visibility
    transport: Transport
    offsets: NDArray[np.float64]
    film: FilmBuilder
    depth: NDArray[np.float32]
    statistics: RenderStatistics = field(default_factory=RenderStatistics)
    started: float = 0.0

    @classmethod
    def prepare(
        cls,
        scene: Scene,
        camera: Camera,
        settings: RenderSettings,
        progress: Progress,
        cancel: Cancel,
        geometry: Geometry | None = None,
    ) -> _Job:
        started = time.perf_counter()
        dtype = np.float64 if settings.precision == "float64" else np.float32
        if geometry is None:
            progress(0.0, "gathering triangles")
            geometry = Geometry.from_instances(scene.instances, dtype)
        progress(0.0, "planning")
        plan = make_plan(scene, settings, geometry)
        spectra = SceneSpectra.from_scene(scene)
        sees, grid = observer(settings.observer), wavelength_grid(settings.grid)
        # A lamp without luminance should fail before the first ray, not after minutes; every lamp has a direct term.
        spectra.tristimulus_table(plan.direct_terms, sees, grid)
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
        film = FilmBuilder(
            settings.width, settings.height, settings.samples, dtype, spectra, sees, grid, settings.film_bytes
        )

        def stop_if_cancelled() -> None:
            if cancel():
                raise RenderCancelledError("the render was cancelled")

        return cls(
            scene=scene,
            camera=camera,
            settings=settings,
            progress=progress,
            stop_if_cancelled=stop_if_cancelled,
            plan=plan,
            spectra=spectra,
            observer=sees,
            grid=grid,
            geometry=geometry,
            visibility=visibility,
            transport=Transport(
                scene, settings, plan, spectra, sees, geometry, visibility, film, statistics, stop_if_cancelled
            ),
            offsets=pixel_offsets(settings.samples, settings.pixel_filter, settings.filter_width, settings.seed),
            film=film,
            depth=np.full((settings.height, settings.width), np.inf, np.float32),
            statistics=statistics,
            started=started,
        )

    def render_band(self, first: int, last: int, on_band: Callable[[Band], None] | None) -> None:
        width = self.settings.width
        pixels = np.arange(first * width, last * width)
        for number, offset in enumerate(self.offsets):
            self.stop_if_cancelled()
            with self.statistics.timed("visibility"):
                hits, directions, view_depth = self.visibility.primary(first, last, offset)
            self.statistics.camera_rays += len(pixels)
            found = hits.hit
            self.film.count_hits(pixels[found])
            if number == 0:
                self.depth.reshape(-1)[pixels[found]] = view_depth[found]
            self.transport.from_camera(pixels, hits, directions)
        with self.statistics.timed("film"):
            part = self.film.end_band(first, last)
        if on_band is not None:
            colour = part.tristimulus(self.spectra, self.observer, self.grid, own_spectra=True)
            on_band(Band(first, colour, part.coverage))

    def finish(self) -> Render:
        with self.statistics.timed("film"):
            film = self.film.finish()
        self.statistics.film_bytes = film.nbytes
        self.statistics.terms = len(film.terms)
        self.statistics.is_relightable = film.is_relightable
        self.statistics.seconds["total"] = time.perf_counter() - self.started
        return Render(film, self.spectra, self.settings.observer, self.settings.grid, self.depth, self.statistics)
