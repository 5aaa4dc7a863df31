"""The rendered 3D view: coarse at once, then finer, in slices between redraws so that the window never waits.

Blender draws a view from its main thread, and Python threads must not outlive the call; so each redraw gives the
renderer a slice of time, shows what there is and asks for the next redraw until the picture is finished.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import core
from .camera_reading import Region, view_camera
from .image_reading import forget
from .scene_export import ExportedScene, export_scene

__all__ = ["Pass", "ProgressivePicture", "View", "ViewSession", "passes_of"]

_COARSEST = 16  # pixels of the view on a side of the first picture's pixels
_BAND_PIXELS = 1 << 13  # a few hundredths of a second between two looks at the clock
_SLICE_S = 0.04  # of rendering between two redraws: the view stays at about 20 pictures a second
_LARGEST_HALF = 65519.0  # above this a half-precision texture holds infinity


@dataclass(frozen=True, slots=True)
class Pass:
    """One picture of the sequence from coarse to fine.

    Attributes
    ----------
    step : int
        Pixels of the view on a side of one pixel of the pass.
    samples : int
        Rays for each of its pixels.
    is_draft : bool
        Whether all of it is lit from one point of each lamp.
    """

    step: int
    samples: int
    is_draft: bool = False


def passes_of(finest: int, samples: int) -> tuple[Pass, ...]:
    """Return the passes: drafts of one ray a pixel, each twice as fine as the last, and one with all `samples`."""
    steps = []
    step = max(_COARSEST, finest)
    while step > finest:
        steps.append(step)
        step //= 2
    return (*(Pass(step, 1, is_draft=True) for step in steps), Pass(finest, samples))


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Where a 3D view looks from, and how large it is.

    Attributes
    ----------
    camera : Camera
        The core's camera.
    width, height : int
        Pixels.
    finest : int
        Pixels of the view on a side of the finest pixels that are rendered.
    key : bytes
        Equal for equal views.
    """

    camera: Any
    width: int
    height: int
    finest: int
    key: bytes

    @classmethod
    def of(cls, region: Any, region_data: Any, pixel_size: str) -> View:
        """Read a region of the 3D view; `pixel_size` is that of the scene's performance settings."""
        view_matrix = np.array(region_data.view_matrix, np.float64)
        window_matrix = np.array(region_data.window_matrix, np.float64)
        finest = 1 if pixel_size == "AUTO" else int(pixel_size)
        size = np.array([region.width, region.height, finest], np.int64)
        return cls(
            view_camera(view_matrix, window_matrix),
            max(1, region.width),
            max(1, region.height),
            finest,
            view_matrix.tobytes() + window_matrix.tobytes() + size.tobytes(),
        )


class ProgressivePicture:
    """A picture that becomes finer whenever it is given time.

    Parameters
    ----------
    exported : ExportedScene
        What is shown.
    acceleration : Acceleration
        What is known of its triangles.
    view : View
        From where.

    Attributes
    ----------
    pixels : ndarray of float32, shape (height, width, 4)
        Scene linear, row 0 at the top.
    done : float
        Part of all passes that is rendered, 0 to 1.
    is_finished : bool
        Whether nothing is left to do.
    """

    def __init__(self, exported: ExportedScene, acceleration: Any, view: View) -> None:
        self._exported = exported
        self._acceleration = acceleration
        self._view = view
        self._passes = passes_of(view.finest, exported.settings.samples)
        self._renders: list[tuple[Pass, Any]] = []  # the pass under way, behind the last one that covers the view
        self._changed = [0, 0]  # rows of the pass under way that are not in the pixels yet
        self._steps = self._render()
        self.done = 0.0
        self.is_finished = False
        self.pixels: NDArray[np.float32] = np.zeros((view.height, view.width, 4), np.float32)

    def advance(self, seconds: float) -> bool:
        """Render until the time is over, at least one step; return whether the picture changed."""
        end = time.perf_counter() + seconds
        changed = False
        while not self.is_finished:
            try:
                next(self._steps)
            except StopIteration:
                self.is_finished = True
            else:
                changed = True
            if time.perf_counter() >= end:
                break
        self._paint_changed()
        return changed

    def recolour(self, exported: ExportedScene) -> bool:
        """Show another scene with the same triangles, if it differs in spectra only; return whether it does.

        Nothing is traced for it, and what is under way goes on in the new colours.
        """
        if exported.is_transparent != self._exported.is_transparent:
            return False
        for step, render in self._renders:
            if not render.recolour(exported.scene, self._settings(exported, step)):
                return False
        self._exported = exported
        for step, render in self._renders:
            self._paint(step, render, 0, render.covered_rows)
        return True

    def _render(self) -> Iterator[None]:
        for number, step in enumerate(self._passes):
            self._paint_changed()
            scene = replace(self._exported.scene, camera=self._camera(step))
            settings = self._settings(self._exported, step)
            render = core.ProgressiveRender(scene, settings, self._acceleration, is_draft=step.is_draft)
            self._renders = [*self._renders[-1:], (step, render)]
            for first, end, done in render.steps():
                low, high = self._changed
                self._changed = [min(low, first), max(high, end)] if high > low else [first, end]
                self.done = (number + done) / len(self._passes)
                yield

    def _size(self, step: Pass) -> tuple[int, int]:
        return -(-self._view.width // step.step), -(-self._view.height // step.step)

    def _settings(self, exported: ExportedScene, step: Pass) -> Any:
        width, height = self._size(step)
        return replace(
            exported.settings,
            width=width,
            height=height,
            samples=step.samples,
            # The first picture comes in one piece.
            band_samples=width * height if step == self._passes[0] else _BAND_PIXELS,
            pixel_filter=exported.settings.pixel_filter if step.samples > 1 else "box",
            filter_width=exported.settings.filter_width if step.samples > 1 else 1.0,
            buffers=(),
            shadow_share=False,
            threads=1,
        )

    def _camera(self, step: Pass) -> Any:
        """Return the camera for a pass, whose last column and row may reach beyond the view."""
        camera, view, side = self._view.camera, self._view, step.step
        width, height = self._size(step)
        region = Region(view.width, view.height, 0, view.height - height * side, width * side, height * side)
        return replace(camera, window=region.crop(camera.window))

    def _paint_changed(self) -> None:
        first, end = self._changed
        if end > first:
            step, render = self._renders[-1]
            self._paint(step, render, first, end)
            self._changed = [0, 0]

    def _paint(self, step: Pass, render: Any, first: int, end: int) -> None:
        exported, side = self._exported, step.step
        coverage = render.coverage[first:end] if exported.is_transparent else None
        rows = exported.colour.rgba(render.tristimulus[first:end], coverage)
        if side > 1:
            rows = np.repeat(np.repeat(rows, side, axis=0), side, axis=1)
        part = self.pixels[first * side : first * side + len(rows)]
        part[...] = rows[: len(part), : part.shape[1]]


class ViewSession:
    """What one 3D view shows: the exported scene, the picture under way and the texture on the screen."""

    def __init__(self) -> None:
        self._exported: ExportedScene | None = None
        self._cache = core.AccelerationCache()
        self._acceleration: Any = None
        self._view_key = b""
        self._picture: ProgressivePicture | None = None
        self._texture: Any = None
        self.problem = ""

    def update(self, depsgraph: Any) -> None:
        """Read the scene anew: something in it has changed.

        What is known of the triangles is kept while they are the same, and the picture while nothing but spectra,
        strengths, the observer or the white differs.
        """
        if depsgraph.id_type_updated("IMAGE"):
            forget()
        try:
            view = core.Camera(np.eye(4), (-1.0, 1.0, -1.0, 1.0)), Region(1, 1, 0, 0, 1, 1)  # replaced at each redraw
            exported = export_scene(depsgraph, view=view)
            dtype = np.float64 if exported.settings.precision == "float64" else np.float32
            acceleration = self._cache.get(exported.scene.instances, dtype)
            is_kept = self._picture is not None and not self.problem and acceleration is self._acceleration
            if is_kept and self._picture is not None and self._picture.recolour(exported):
                self._texture = None
            else:
                self._picture = None
        except core.DichromaticError as error:
            self._picture = self._exported = None
            self.problem = str(error)
        else:
            self._exported, self._acceleration = exported, acceleration
            self.problem = ""

    def advance(self, view: View, seconds: float = _SLICE_S) -> bool:
        """Render a slice for a view; return whether there is more to do."""
        if self._exported is None:
            return False
        if self._picture is None or view.key != self._view_key:
            self._view_key = view.key
            self._acceleration.forget_lights()  # what they see depends on where one looks from
            self._picture = ProgressivePicture(self._exported, self._acceleration, view)
        try:
            if self._picture.advance(seconds):
                self._texture = None
        except core.DichromaticError as error:
            self.problem = str(error)
            self._exported = None
            return False
        return not self._picture.is_finished

    @property
    def status(self) -> str:
        """What the view says in its corner."""
        if self.problem:
            return self.problem
        if self._picture is None:
            return ""
        return "Done" if self._picture.is_finished else f"{self._picture.done:.0%}"

    def draw(self) -> None:
        """Draw the picture into the view; Blender's shader for the display's colours is bound by the caller."""
        import gpu
        from gpu_extras.presets import draw_texture_2d

        if self._picture is None:
            return
        if self._texture is None:
            pixels = np.clip(self._picture.pixels[::-1], -_LARGEST_HALF, _LARGEST_HALF)
            height, width, _ = pixels.shape
            data = gpu.types.Buffer("FLOAT", height * width * 4, np.ascontiguousarray(pixels).ravel())
            self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
        draw_texture_2d(self._texture, (0, 0), self._texture.width, self._texture.height)
