"""A picture for a view: coarse at once, then finer and finer, at the caller's pace and in other colours when asked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import observer, wavelength_grid
from .film import Film
from .film_builder import FilmPart, joined_parts
from .job import Job, Task
from .recolouring import differ_in_spectra_only
from .scene import RenderSettings, Scene
from .scene_spectra import SceneSpectra, Term
from .sub_pictures import SubPicture, refinement, spread
from .tracing.acceleration import Acceleration

__all__ = ["ProgressiveRender"]


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    """What is known of some pixels: their light, and the squares that they stood for when it was shown last."""

    part: SubPicture
    side: int
    film: FilmPart
    row: Film


class ProgressiveRender:
    """A render that shows something after each step of a few hundredths of a second.

    The first sample of all pixels comes first, then the second, and so on; with all of them the picture is that of
    :func:`~spectral_core.render` without adaptive samples. What is traced is kept by terms, so that other spectra,
    strengths, another observer or other wavelengths colour what is there at once.

    Parameters
    ----------
    scene : Scene
        What to render; it needs a camera.
    settings : RenderSettings
        How. ``band_samples`` bounds the work of a step; `adaptive_threshold` and `threads` are not used.
    acceleration : Acceleration, optional
        What is known of the scene's triangles from an earlier render.
    is_draft : bool
        Light the whole picture from one point of each lamp, and see it from one point of the lens, as a first glance
        in which hard shadows do no harm.

    Attributes
    ----------
    tristimulus : ndarray, shape (height, width, 3)
        X, Y, Z of what is there.
    coverage : ndarray of float32, shape (height, width)
        Part of the samples that met a surface.
    covered_rows : int
        Rows from the top in which every pixel has a colour.

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

    def __init__(
        self,
        scene: Scene,
        settings: RenderSettings,
        acceleration: Acceleration | None = None,
        *,
        is_draft: bool = False,
    ) -> None:
        self._given = settings
        self._job = Job.prepare(
            scene, replace(settings, adaptive_threshold=0.0), None, acceleration, step=1 if is_draft else None
        )
        self._spectra, self._observer, self._grid = self._job.spectra, self._job.observer, self._job.grid
        self._weights: dict[Term, NDArray[np.float64]] = {}
        self._kept: dict[tuple[int, int], _Kept] = {}
        shape = settings.height, settings.width
        self.tristimulus = np.zeros((*shape, 3), self._job.geometry.dtype)
        self.coverage: NDArray[np.float32] = np.zeros(shape, np.float32)
        self.covered_rows = 0

    def steps(self) -> Iterator[tuple[int, int, float]]:
        """Work the picture off.

        Yields
        ------
        first, end : int
            Rows that changed: the first, and the one behind the last.
        done : float
            Part of the work that is done, 0 to 1.

        Raises
        ------
        InvalidParameterError
            If a parameter turns out to be invalid.

        References
        ----------
        Own design.
        """
        tasks = self._job.tasks(1)
        samples = self._job.settings.samples
        total, done = len(tasks) * samples, 0
        for sample in range(samples):
            for task in tasks:
                part = task.part
                film = self._job.run(Task(part, sample, sample + 1)).film
                key = part.number, part.first
                if key in self._kept:
                    film = joined_parts([self._kept[key].film, film])
                side = refinement(part.step, part.number) if sample == 0 else 1
                kept = self._kept[key] = _Kept(part, side, film, film.as_row())
                self._show(kept)
                done += 1
                first = part.row + part.step * part.first
                end = min(part.row + part.step * (part.end - 1) + side, len(self.tristimulus))
                self.covered_rows = max(self.covered_rows, end)
                yield first, end, done / total

    def recolour(self, scene: Scene, settings: RenderSettings) -> bool:
        """Show what is there, and what is to come, with the spectra of another scene; no ray is traced.

        Parameters
        ----------
        scene : Scene
            A scene with the same triangles; it needs no camera.
        settings : RenderSettings
            Its settings.

        Returns
        -------
        bool
            Whether that was possible; if not, nothing was changed, and the scene must be rendered.

        Raises
        ------
        InvalidParameterError
            If the scene's spectra are invalid.

        References
        ----------
        Linearity of Tominaga 1996, Eqs. 4 and 7, in the spectra.
        """
        if any(kept.film.fixed for kept in self._kept.values()) or self._carries_nodes:
            return False
        if not differ_in_spectra_only(self._job.scene, scene, self._given, settings, self._job.geometry):
            return False
        spectra = SceneSpectra.from_scene(scene)
        sees, grid = observer(settings.observer), wavelength_grid(settings.grid)
        spectra.tristimulus_table(self._job.plan.direct_terms, sees, grid)  # raises before anything is changed
        self._spectra, self._observer, self._grid = spectra, sees, grid
        self._weights.clear()
        for kept in self._kept.values():
            self._show(kept)
        return True

    @property
    def _carries_nodes(self) -> bool:
        """Whether light that is to come may be kept as plain colour."""
        return self._job.plan.exact_depth < self._job.settings.max_bounces and any(
            plan is not None and plan.mirror_slots for plan in self._job.plan.materials
        )

    def _show(self, kept: _Kept) -> None:
        spread(kept.part, kept.side, self.tristimulus, self._colour(kept.row))
        spread(kept.part, kept.side, self.coverage, kept.film.coverage)

    def _colour(self, row: Film) -> NDArray[np.floating[Any]]:
        """Colour of some pixels, with what is integrated once for all of them."""
        missing = [term for term in row.terms if term not in self._weights]
        if missing:
            table = self._spectra.tristimulus_table(missing, self._observer, self._grid)
            self._weights.update(zip(missing, table, strict=True))
        table = np.array([self._weights[term] for term in row.terms]).reshape(-1, 3)
        colour = row.weighted_sum(table, row.terms, self.tristimulus.dtype.type)[0]
        return colour if row.fixed_tristimulus is None else colour + row.fixed_tristimulus[0]
