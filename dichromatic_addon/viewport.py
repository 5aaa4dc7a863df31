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
    """

    step: int
    samples: int


def passes_of(finest: int, samples: int) -> tuple[Pass, ...]:
    """Return the passes down to pixels of `finest`: one ray a pixel each, and a last one with all `samples`."""
    steps = []
    step = max(_COARSEST, finest)
    while step > finest:
        steps.append(step)
        step //= 2
    coarse = tuple(Pass(step, 1) for step in [*steps, finest])
    return coarse if samples == 1 else (*coarse, Pass(finest, samples))


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
    """

    def __init__(self, exported: ExportedScene, acceleration: Any, view: View) -> None:
        self._exported = exported
        self._acceleration = acceleration
        self._view = view
        self._passes = passes_of(view.finest, exported.settings.samples)
        self._bands = self._render()
        self._done = 0.0
        self.is_finished = False
        self.pixels: NDArray[np.float32] = np.zeros((view.height, view.width, 4), np.float32)

    @property
    def done(self) -> float:
        """Part of all passes' rows that is rendered, 0 to 1."""
        return self._done

    def advance(self, seconds: float) -> bool:
        """Render until the time is over, at least one band; return whether the picture changed."""
        end = time.perf_counter() + seconds
        changed = False
        while not self.is_finished:
            try:
                next(self._bands)
            except StopIteration:
                self.is_finished = True
            else:
                changed = True
            if time.perf_counter() >= end:
                break
        return changed

    def _render(self) -> Iterator[None]:
        view, exported = self._view, self._exported
        for number, step in enumerate(self._passes):
            width, height = -(-view.width // step.step), -(-view.height // step.step)
            settings = replace(
                exported.settings,
                width=width,
                height=height,
                samples=step.samples,
                # The first picture comes in one piece, and the passes that are refined have no soft edges to refine.
                band_samples=width * height if number == 0 else _BAND_PIXELS,
                pixel_filter=exported.settings.pixel_filter if step.samples > 1 else "box",
                filter_width=exported.settings.filter_width if step.samples > 1 else 1.0,
            )
            scene = replace(exported.scene, camera=self._camera(step.step, width, height))
            for band in core.render_bands(scene, settings, acceleration=self._acceleration):
                self._paint(band, step.step)
                self._done = (number + (band.first_row + len(band.tristimulus)) / height) / len(self._passes)
                yield

    def _camera(self, step: int, width: int, height: int) -> Any:
        """Return the camera for a pass, whose last column and row may reach beyond the view."""
        camera, view = self._view.camera, self._view
        region = Region(view.width, view.height, 0, view.height - height * step, width * step, height * step)
        return replace(camera, window=region.crop(camera.window))

    def _paint(self, band: Any, step: int) -> None:
        exported = self._exported
        rows = exported.colour.rgba(band.tristimulus, band.coverage if exported.is_transparent else None)
        large = np.repeat(np.repeat(rows, step, axis=0), step, axis=1)
        top = band.first_row * step
        part = self.pixels[top : top + len(large)]
        part[...] = large[: len(part), : part.shape[1]]


class ViewSession:
    """What one 3D view shows: the exported scene, the picture under way and the texture on the screen."""

    def __init__(self) -> None:
        self._exported: ExportedScene | None = None
        self._acceleration: Any = None
        self._view_key = b""
        self._picture: ProgressivePicture | None = None
        self._texture: Any = None
        self.problem = ""

    def update(self, depsgraph: Any) -> None:
        """Read the scene anew: something in it has changed."""
        self._picture = None
        self._exported = None
        try:
            view = core.Camera(np.eye(4), (-1.0, 1.0, -1.0, 1.0)), Region(1, 1, 0, 0, 1, 1)  # replaced at each redraw
            exported = export_scene(depsgraph, view=view)
            dtype = np.float64 if exported.settings.precision == "float64" else np.float32
            self._acceleration = core.Acceleration(core.Geometry.from_instances(exported.scene.instances, dtype))
        except core.DichromaticError as error:
            self.problem = str(error)
        else:
            self._exported = exported
            self.problem = ""

    def advance(self, view: View, seconds: float = _SLICE_S) -> bool:
        """Render a slice for a view; return whether there is more to do."""
        if self._exported is None:
            return False
        if self._picture is None or view.key != self._view_key:
            self._view_key = view.key
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
