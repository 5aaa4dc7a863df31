"""One render: everything that is made once for it, and the tasks that its picture is cut into.

A task is worked off by itself, from its pixels to a part of the film, and changes nothing that another could see. So
tasks may run one after the other, in threads, or in other processes; the parts are the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .adaptive import colour_distance
from .colorimetry import Observer, WavelengthGrid, observer, wavelength_grid
from .errors import InvalidParameterError, SceneError
from .film_builder import Deposits, FilmPart, joined_parts
from .light_plan import light_sources
from .lights import EnvironmentLight, LampPoint, LightSource
from .plan import RenderPlan, make_plan
from .sample_pattern import SamplePattern, first_samples, interleaving
from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra
from .shading import SurfacePoints
from .statistics import RenderStatistics
from .sub_pictures import SubPicture, sub_pictures
from .tracing.acceleration import Acceleration
from .tracing.geometry import Geometry
from .tracing.mesh import MASKS
from .transport import Transport
from .validation import require_integer
from .visibility import Visibility

__all__ = ["Job", "Task", "TaskResult"]

_TASKS_A_THREAD = 4  # so that threads finish at about the same time
_SMALLEST_TASK = 1 << 15  # pixels; for fewer, what numpy does not share between threads counts


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """Some samples of some pixels.

    Attributes
    ----------
    part : SubPicture
        The pixels.
    first, end : int
        Samples: the first, and the one behind the last.
    chosen : ndarray of int64, shape (n,), optional
        Which of the part's pixels take them; all when left out.
    """

    part: SubPicture
    first: int
    end: int
    chosen: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        pixels = len(self.part) if self.chosen is None else len(self.chosen)
        return pixels * (self.end - self.first)


@dataclass(frozen=True, slots=True, eq=False)
class TaskResult:
    """What a task found.

    Attributes
    ----------
    film : FilmPart
        The light.
    difference : ndarray of float32, shape (N,), or None
        Colour distance between the two halves of the samples, where more samples depend on it.
    buffers : dict of str to ndarray, or None
        What the first sample met, by buffer; None for a task without the first sample.
    statistics : RenderStatistics
        Counts and times of the task alone.
    """

    film: FilmPart
    difference: NDArray[np.float32] | None
    buffers: dict[str, NDArray[Any]] | None
    statistics: RenderStatistics


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """A render that is ready to be worked off.

    Attributes
    ----------
    scene : Scene
        What is rendered; it has a camera.
    settings : RenderSettings
        How.
    plan, spectra, observer, grid
        What the scene requires, and its spectral side.
    geometry, visibility, sources
        The triangles, who sees whom, and what sends light.
    pattern : SamplePattern
        The points of all samples.
    step : int
        How many sub-pictures a side the picture is cut into.
    masks : ndarray of int8, or None
        What camera rays make of each instance, an index into ``MASKS``; None where all are surfaces.
    seconds : float
        Time that the preparation took.
    """

    scene: Scene
    settings: RenderSettings
    plan: RenderPlan
    spectra: SceneSpectra
    observer: Observer
    grid: WavelengthGrid
    geometry: Geometry
    visibility: Visibility
    sources: tuple[LightSource, ...]
    pattern: SamplePattern
    step: int
    masks: NDArray[np.int8] | None
    seconds: float

    @classmethod
    def prepare(
        cls,
        scene: Scene,
        settings: RenderSettings,
        rows: int | None = None,
        acceleration: Acceleration | None = None,
        progress: Callable[[float, str], None] = lambda fraction, message: None,
        stop_if_cancelled: Callable[[], None] = lambda: None,
        step: int | None = None,
    ) -> Job:
        """Make what all tasks share.

        Parameters
        ----------
        scene : Scene
            What to render.
        settings : RenderSettings
            How.
        rows : int, optional
            Render only so many rows, spread evenly over the picture.
        acceleration : Acceleration, optional
            Of the scene's triangles, in the settings' precision, where there is one already.
        progress : callable
            Told what is being done.
        stop_if_cancelled : callable
            Asked often; raises when the caller wants an end.
        step : int, optional
            How many sub-pictures a side to cut the picture into, instead of as many as its light needs.

        Returns
        -------
        Job
            Ready to run.

        Raises
        ------
        SceneError
            If the scene has no camera.
        InvalidParameterError
            If a spectrum or parameter is invalid.

        References
        ----------
        Own design.
        """
        started = time.perf_counter()
        camera = scene.camera
        if camera is None:
            raise SceneError(f"scene '{scene.name}' has no camera")
        thinness = 1.0
        if rows is not None:
            require_integer("rows", rows, 1, settings.height)
            thinness = rows / settings.height
            settings = replace(settings, height=rows)
        dtype = np.dtype(np.float64 if settings.precision == "float64" else np.float32)
        if acceleration is None:
            progress(0.0, "gathering triangles")
            acceleration = Acceleration(Geometry.from_instances(scene.instances, dtype, stop_if_cancelled))
        geometry = acceleration.geometry
        if geometry.dtype != dtype:
            raise InvalidParameterError(f"the triangles must be {dtype}, as the settings ask, but are {geometry.dtype}")
        stop_if_cancelled()
        progress(0.0, "planning")
        plan = make_plan(scene, settings, geometry)
        spectra = SceneSpectra.from_scene(scene)
        sees, grid = observer(settings.observer), wavelength_grid(settings.grid)
        # A lamp without luminance should fail before the first ray, not after minutes; every lamp has a direct term.
        spectra.tristimulus_table(plan.direct_terms, sees, grid)
        if step is None:
            step = interleaving(settings, plan.is_sampled or camera.has_lens)
        sources = light_sources(plan.sources, scene, acceleration)
        counts = tuple(source.points for source in plan.sources)
        pattern = SamplePattern.make(settings, step, counts, camera.lens_blades, thinness)
        for number, source in enumerate(sources):
            if isinstance(source, EnvironmentLight):
                pattern = pattern.balanced(number, source.directions, settings.seed)
        return cls(
            scene=scene,
            settings=settings,
            plan=plan,
            spectra=spectra,
            observer=sees,
            grid=grid,
            geometry=geometry,
            visibility=Visibility(acceleration, camera, settings.width, settings.height),
            sources=sources,
            pattern=pattern,
            step=step,
            masks=_masks(scene),
            seconds=time.perf_counter() - started,
        )

    @property
    def is_adaptive(self) -> bool:
        """Whether some samples are taken only where the first ones differ."""
        return first_samples(self.settings) < self.settings.samples

    def tasks(self, workers: int) -> list[Task]:
        """Cut the picture up for the samples that every pixel takes.

        Parameters
        ----------
        workers : int
            How many work at a time.

        Returns
        -------
        list of Task
            In the order in which their parts join the film.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        settings = self.settings
        most = settings.band_samples
        if workers > 1 and self.step == 1:
            share = settings.width * settings.height // (workers * _TASKS_A_THREAD)
            most = min(most, max(share, _SMALLEST_TASK))
        end = first_samples(settings)
        return [Task(part, 0, end) for part in sub_pictures(settings.width, settings.height, self.step, most)]

    def further_tasks(self, tasks: list[Task], differs: NDArray[np.bool_]) -> list[Task]:
        """List what is left to do where the first samples differ.

        Parameters
        ----------
        tasks : list of Task
            Those of :meth:`tasks`.
        differs : ndarray of bool, shape (H * W,)
            The pixels.

        Returns
        -------
        list of Task
            In the same order; parts of which no pixel differs are left out.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        found = ((task, np.flatnonzero(differs[task.part.pixels])) for task in tasks)
        return [Task(task.part, task.end, self.settings.samples, chosen) for task, chosen in found if len(chosen)]

    def run(self, task: Task, stop_if_cancelled: Callable[[], None] = lambda: None) -> TaskResult:
        """Work a task off.

        Parameters
        ----------
        task : Task
            One of this job's.
        stop_if_cancelled : callable
            Asked often; raises when the caller wants an end.

        Returns
        -------
        TaskResult
            What was found.

        Raises
        ------
        RenderCancelledError
            If `stop_if_cancelled` said so.
        InvalidParameterError
            If a parameter turns out to be invalid.

        References
        ----------
        Tominaga 1996, Eqs. 4-13.
        """
        statistics = RenderStatistics()
        pixels = task.part.pixels if task.chosen is None else task.part.pixels[task.chosen]
        is_judged = self.is_adaptive and task.first == 0
        halves = np.array_split(np.arange(task.first, task.end), 2 if is_judged else 1)
        buffers = None
        parts = []
        for samples in halves:
            film = Deposits(pixels, self.settings.width, self.geometry.dtype)
            transport = Transport(
                self.scene,
                self.settings,
                self.plan,
                self.spectra,
                self.observer,
                self.sources,
                self.geometry,
                self.visibility,
                film,
                statistics,
                stop_if_cancelled,
            )
            for sample in samples.tolist():
                found = self._sample(task, sample, transport, film, statistics)
                if sample == 0:
                    buffers = found
            with statistics.timed("film"):
                parts.append(film.merge(len(samples)))
        with statistics.timed("film"):
            merged = joined_parts(parts)
        difference = None
        if is_judged:
            with statistics.timed("film"):
                one, other = (part.tristimulus(self.spectra, self.observer, self.grid) for part in parts)
                difference = np.maximum(colour_distance(one, other), self._opacity_distance(merged))
        return TaskResult(merged, difference, buffers, statistics)

    def _opacity_distance(self, part: FilmPart) -> NDArray[np.float32]:
        """How far pixels are from being covered or empty, as lightness before white, (N,).

        Where no background is seen the picture will lie over another one, and an edge of something black before black
        matters. Both halves of the samples may find the same part of an edge, so that their difference does not tell.
        """
        if self.plan.background and self.scene.world.camera_visible and self.masks is None:
            return np.zeros(len(part.pixels), np.float32)
        shares = [part.coverage]
        if "held" in part.planes:
            shares.append(part.planes["held"] / np.float32(part.samples))
        distance: NDArray[np.float32] = np.max([np.minimum(share, 1.0 - share) for share in shares], axis=0)
        return np.float32(100.0) * distance

    def _sample(
        self, task: Task, sample: int, transport: Transport, film: Deposits, statistics: RenderStatistics
    ) -> dict[str, NDArray[Any]] | None:
        """Follow one sample of each pixel; return what the first of all samples met."""
        part, number = task.part, task.part.number
        transport.stop_if_cancelled()
        with statistics.timed("visibility"):
            hits, directions, depth = self.visibility.primary(
                part, self.pattern.offsets[sample], self.pattern.lens[number, sample]
            )
            if task.chosen is not None:
                hits, directions = hits.take(task.chosen), directions[task.chosen]
        statistics.camera_rays += len(hits)
        lamp_points = self._lamp_points(number, sample)
        plain = np.arange(len(hits))
        if self.masks is not None:
            found = np.flatnonzero(hits.hit)
            mask = np.zeros(len(hits), np.int8)
            mask[found] = self.masks[self.geometry.instance_index[hits.triangle[found]]]
            film.count("held", np.flatnonzero(mask == MASKS.index("holdout")))
            caught = np.flatnonzero(mask == MASKS.index("shadow_catcher"))
            transport.catch_shadows(caught, hits.take(caught), directions[caught], lamp_points)
            plain = np.flatnonzero(mask == 0)
            hits, directions = hits.take(plain), directions[plain]
        film.count_hits(plain[hits.hit])
        points = transport.from_camera(plain, hits, directions, lamp_points)
        return self._buffers(points, plain, depth) if sample == 0 else None

    def _lamp_points(self, number: int, sample: int) -> list[list[LampPoint]]:
        aim = self.geometry.centre
        return [
            [source.lamp_point(u, aim) for u in unit_squares[number, sample]]
            for source, unit_squares in zip(self.sources, self.pattern.lamps, strict=True)
        ]

    def _buffers(
        self, points: SurfacePoints, rays: NDArray[np.int64], depth: NDArray[np.floating[Any]]
    ) -> dict[str, NDArray[Any]]:
        """What the first sample met, by buffer; `rays` are those that found the points, nothing masked among them."""
        at = rays[points.ray]
        far = np.full(len(depth), np.inf, np.float32)
        far[at] = depth[at]
        values: dict[str, NDArray[Any]] = {"depth": far}
        for name in self.settings.buffers:
            met: NDArray[Any]
            if name == "normal":
                met = points.normal
            elif name == "position":
                met = points.position + self.geometry.centre
            elif name == "object_index":
                met = self.geometry.instance_index[points.triangle]
            else:
                met = points.material
            is_index = met.ndim == 1
            array = np.full((len(depth), *met.shape[1:]), -1 if is_index else 0.0, np.int32 if is_index else np.float32)
            array[at] = met
            values[name] = array
        return values


def _masks(scene: Scene) -> NDArray[np.int8] | None:
    masks = np.array([MASKS.index(instance.mask) for instance in scene.instances], np.int8)
    return masks if masks.any() else None
