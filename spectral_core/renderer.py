"""Scene in, film out: the picture is worked off part by part, with progress and cancel between them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .adaptive import pixels_that_differ
from .buffers import SurfaceBuffers
from .colorimetry import observer, wavelength_grid
from .errors import InvalidParameterError
from .film import Film
from .film_builder import FilmBuilder, FilmPart
from .job import Job, Task, TaskResult
from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra
from .statistics import RenderStatistics
from .sub_pictures import SubPicture, refinement, spread
from .tracing.acceleration import Acceleration
from .workers import remote_results, results, stopper, thread_count

__all__ = ["Band", "Cancel", "Progress", "Render", "render"]

Progress = Callable[[float, str], None]
Cancel = Callable[[], bool]


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """A run of whole rows, for showing an image while it is made.

    Attributes
    ----------
    first_row : int
        Row 0 is the top.
    tristimulus : ndarray, shape (rows, width, 3)
        X, Y, Z.
    coverage : ndarray, shape (rows, width)
        Part of the samples that met a surface.
    is_finished : bool
        False where pixels still stand for their neighbours, or more samples are to come.
    """

    first_row: int
    tristimulus: NDArray[np.floating[Any]]
    coverage: NDArray[np.float32]
    is_finished: bool = True


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
    buffers : SurfaceBuffers
        What the first sample of each pixel met.
    statistics : RenderStatistics
        Counts and times.
    """

    film: Film
    spectra: SceneSpectra
    observer: str
    grid: str
    buffers: SurfaceBuffers
    statistics: RenderStatistics

    @property
    def depth(self) -> NDArray[np.float32]:
        """Distance along the view axis (m) of each pixel's first sample; infinite where it met nothing."""
        return self.buffers.depth

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
    *,
    acceleration: Acceleration | None = None,
    executor: Executor | None = None,
) -> Render:
    """Render a scene.

    Parameters
    ----------
    scene : Scene
        What to render; it needs a camera.
    settings : RenderSettings, optional
        How; the defaults when left out.
    progress : callable, optional
        Called as ``progress(fraction, message)`` between parts, in the caller's thread; fraction 0 to 1.
    cancel : callable, optional
        Asked every few hundredths of a second in the caller's thread (with one thread: between parts, samples and
        lights); a true answer stops the render.
    on_band : callable, optional
        Called with each :class:`Band` that is new, in the caller's thread; what it raises ends the render.
    rows : int, optional
        Render only so many rows, spread evenly over the picture, each as thin as one of the whole; the render is so
        high. A cheap and fair sample of the picture.
    acceleration : Acceleration, optional
        What is known of the scene's triangles from an earlier render, while they have not changed.
    executor : concurrent.futures.Executor, optional
        Where to work: a pool of processes, or of machines that have this package. It gets the scene, so
        `acceleration` is not used there. Threads of this process (``settings.threads``) when left out.

    Returns
    -------
    Render
        The film and what goes with it; the same whoever works on it.

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
    tell, is_cancelled = progress or _ignore_progress, cancel or _never
    started = time.perf_counter()
    job = Job.prepare(scene, settings, rows, acceleration, tell, stopper(is_cancelled))
    workers = thread_count(settings)
    if executor is not None:
        workers = getattr(executor, "_max_workers", None) or workers

    def work(tasks: list[Task]) -> Iterator[TaskResult]:
        if executor is not None:
            return remote_results(executor, scene, settings, rows, tasks, is_cancelled)
        return results(job, tasks, workers, is_cancelled)

    assembly = _Assembly.of(job)
    for found in assembly.rounds(job, workers, work, tell, is_wanted=on_band is not None):
        if on_band is not None:
            for band in found:
                on_band(band)
    finished = assembly.finish(job)
    finished.statistics.seconds["total"] = time.perf_counter() - started
    tell(1.0, "done")
    return finished


def _ignore_progress(fraction: float, message: str) -> None:
    """Stand in for a progress callable."""


def _never() -> bool:
    return False


@dataclass(slots=True, eq=False)
class _Assembly:
    """A picture that is put together from the parts as they come."""

    film: FilmBuilder
    buffers: SurfaceBuffers
    statistics: RenderStatistics
    shown: NDArray[np.floating[Any]]
    coverage: NDArray[np.float32]

    @classmethod
    def of(cls, job: Job) -> _Assembly:
        settings, geometry = job.settings, job.geometry
        shape = (settings.height, settings.width)
        return cls(
            film=FilmBuilder(
                settings.width,
                settings.height,
                job.spectra,
                job.observer,
                job.grid,
                settings.film_bytes,
                settings.split_light,
            ),
            buffers=SurfaceBuffers.empty(settings.height, settings.width, settings.buffers),
            statistics=RenderStatistics(
                scene=job.scene.name,
                width=settings.width,
                height=settings.height,
                samples=settings.samples,
                triangles=geometry.triangle_count,
                dropped_triangles=geometry.dropped,
                plan=job.plan.describe(),
                seconds={"geometry": job.seconds},
            ),
            shown=np.zeros((*shape, 3), geometry.dtype),
            coverage=np.zeros(shape, np.float32),
        )

    def rounds(
        self,
        job: Job,
        workers: int,
        work: Callable[[list[Task]], Iterator[TaskResult]],
        progress: Progress,
        *,
        is_wanted: bool,
    ) -> Iterator[list[Band]]:
        """Work off the samples of all pixels, then those of the pixels that need more; yield what is new to show."""
        settings = job.settings
        tasks = job.tasks(workers)
        total = settings.width * settings.height * settings.samples
        done = 0
        distance = np.zeros(settings.width * settings.height, np.float32)
        progress(0.0, f"{settings.width} x {settings.height} pixels, {settings.samples} samples")
        for task, result in zip(tasks, work(tasks), strict=True):
            self._take(task, result)
            if result.difference is not None:
                distance[task.part.pixels] = result.difference
            done += len(task)
            progress(done / total, _what(task.part, settings.height))
            is_last = not job.is_adaptive and task.part.number == tasks[-1].part.number
            yield [self._band(job, task.part, result.film, is_last)] if is_wanted else []
        if not job.is_adaptive:
            return
        differs = pixels_that_differ(distance, settings.height, settings.width, settings.adaptive_threshold)
        self.statistics.refined_pixels = int(np.count_nonzero(differs))
        tasks = job.further_tasks(tasks, differs)
        if not tasks and is_wanted:
            yield [self._rows(0, settings.height, True)]
        wanted, begun = sum(len(task) for task in tasks), done
        for task, result in zip(tasks, work(tasks), strict=True):
            self._take(task, result)
            done += len(task)
            fraction = begun / total + (1.0 - begun / total) * (done - begun) / wanted
            progress(fraction, f"further samples where the first differ, {_what(task.part, settings.height)}")
            yield [self._refined(job, task, result.film, task is tasks[-1])] if is_wanted else []

    def _take(self, task: Task, result: TaskResult) -> None:
        with self.statistics.timed("film"):
            self.film.add(result.film)
        if result.buffers is not None:
            self.buffers.put(task.part.pixels, result.buffers)
        self.statistics.add(result.statistics)

    def _band(self, job: Job, part: SubPicture, film: FilmPart, is_finished: bool) -> Band:
        """Show a part; its pixels stand for the square to the right of and below them until others are there."""
        side = refinement(part.step, part.number)
        spread(part, side, self.shown, film.tristimulus(job.spectra, job.observer, job.grid))
        spread(part, side, self.coverage, film.coverage)
        return self._rows(int(part.y[0]), int(part.y[-1]) + side, is_finished)

    def _refined(self, job: Job, task: Task, film: FilmPart, is_finished: bool) -> Band:
        """Show further samples of some pixels."""
        earlier, share = task.first / task.end, 1.0 - task.first / task.end
        for image, values in (
            (self.shown, film.tristimulus(job.spectra, job.observer, job.grid)),
            (self.coverage, film.coverage),
        ):
            flat = image.reshape(-1, *image.shape[2:])
            flat[film.pixels] = flat[film.pixels] * image.dtype.type(earlier) + values * image.dtype.type(share)
        return self._rows(int(task.part.y[0]), int(task.part.y[-1]) + 1, is_finished)

    def _rows(self, first: int, end: int, is_finished: bool) -> Band:
        rows = slice(first, min(end, len(self.shown)))
        return Band(first, self.shown[rows].copy(), self.coverage[rows].copy(), is_finished)

    def finish(self, job: Job) -> Render:
        with self.statistics.timed("film"):
            film = self.film.finish()
        self.statistics.film_bytes = film.nbytes
        self.statistics.terms = len(film.terms)
        self.statistics.is_relightable = film.is_relightable
        return Render(film, job.spectra, job.settings.observer, job.settings.grid, self.buffers, self.statistics)


def _what(part: SubPicture, height: int) -> str:
    """Name a part of the picture, for the status line."""
    rows = f"rows {int(part.y[0]) + 1} to {min(int(part.y[-1]) + 1, height)} of {height}"
    return rows if part.step == 1 else f"{rows}, pass {part.number + 1} of {part.step * part.step}"
