"""The render engine: F12, ``blender -b FILE -E DICHROMATIC -f 1`` and animations."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import bpy
import gpu
import numpy as np
from numpy.typing import NDArray

from . import last_render
from ._core import core
from .first_look import enlarged, first_look, is_worth_it
from .names import ENGINE_ID
from .persistent import acceleration_for
from .progress_bar import format_duration
from .render_passes import PassRequest, pass_pixels, passes_of_layer
from .scene_export import ExportedScene, export_camera, export_scene
from .stereo import StereoEye, stereo_views
from .viewport import View, ViewSession
from .window_updates import WaitingBands, window_pace

__all__ = [
    "CLASSES",
    "Capture",
    "DichromaticRenderEngine",
    "FinishedLayer",
    "begin_capture",
    "capture",
    "end_capture",
    "register",
    "unregister",
]

_BANDS_WANTED = 24  # so that the window shows the picture growing
_RAYS_A_BAND = 1 << 20  # about a second or two of work, however many samples a pixel has
_GOOD_BAND = 1 << 17  # pixels; a fifth quicker than a quarter of it, since each band looks through the triangles anew
_LEAST_BAND = 1 << 15  # pixels; smaller bands cost more than they show
_STRIP = 1 << 18  # pixels that are handed to Blender at once while the render goes on: some hundredths of a second


@dataclass(frozen=True, slots=True)
class FinishedLayer:
    """What one view layer's render left behind.

    Attributes
    ----------
    render : Render
        Film, spectra, depth and statistics.
    exported : ExportedScene
        What was rendered, and how its colours are shown.
    """

    render: Any
    exported: ExportedScene


@dataclass(slots=True)
class Capture:
    """What renders inside a ``with capture()`` block produced, and how they report.

    Attributes
    ----------
    progress : callable, optional
        Called as ``progress(fraction, message)``; Blender's own status line is left alone then.
    adjust : callable, optional
        From the exported RenderSettings to those that are used.
    executor : concurrent.futures.Executor, optional
        Who works on the picture; threads of Blender's own process when left out.
    layers : list of FinishedLayer
        In the order of rendering.
    error : Exception or None
        What ended a render early.
    """

    progress: Callable[[float, str], None] | None = None
    adjust: Callable[[Any], Any] | None = None
    executor: Executor | None = None
    layers: list[FinishedLayer] = field(default_factory=list)
    error: BaseException | None = None


_captures: list[Capture] = []


@contextmanager
def capture(
    progress: Callable[[float, str], None] | None = None,
    adjust: Callable[[Any], Any] | None = None,
    executor: Executor | None = None,
) -> Iterator[Capture]:
    """Collect what the engine renders inside the block; Blender's render operator itself returns no pixels."""
    made = begin_capture(progress, adjust, executor)
    try:
        yield made
    finally:
        end_capture(made)


def begin_capture(
    progress: Callable[[float, str], None] | None = None,
    adjust: Callable[[Any], Any] | None = None,
    executor: Executor | None = None,
) -> Capture:
    """Start to collect what the engine renders, until :func:`end_capture`; for renders that outlive the caller."""
    made = Capture(progress, adjust, executor)
    _captures.append(made)
    return made


def end_capture(made: Capture) -> None:
    """Stop collecting into `made`."""
    _captures.remove(made)


class DichromaticRenderEngine(bpy.types.RenderEngine):
    """Spectral rendering with the dichromatic reflection models."""

    bl_idname = ENGINE_ID
    bl_label = "Dichromatic"
    bl_use_preview = True
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def update_render_passes(self, scene: Any = None, renderlayer: Any = None) -> None:
        """Tell the compositor which passes a view layer has."""
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for item in passes_of_layer(renderlayer):
            self.register_pass(scene, renderlayer, item.name, len(item.channels), item.channels, item.kind)

    def render(self, depsgraph: Any) -> None:
        """Render one view layer; Blender calls it once for each."""
        listener = _captures[-1] if _captures and not self.is_preview else None
        try:
            finished = _LayerJob(self, listener).run(depsgraph)
            if not self.is_preview:
                last_render.remember(finished)
            if listener is not None:
                listener.layers.append(finished)
        except (core.RenderCancelledError, KeyboardInterrupt) as error:
            _remember(listener, error)
        except core.DichromaticError as error:
            _remember(listener, error)
            self._fail(str(error))
        except Exception as error:  # Blender would swallow it: whatever it is, the user is told
            _remember(listener, error)
            traceback.print_exc()
            self._fail(f"{type(error).__name__}: {error}")

    def view_update(self, context: Any, depsgraph: Any) -> None:
        """Take in a change of the scene; Blender calls it before the first drawing of a rendered view, too."""
        self._view_session().update(depsgraph)
        self.tag_redraw()

    def view_draw(self, context: Any, depsgraph: Any) -> None:
        """Render a slice of the view, and draw what there is."""
        session = self._view_session()
        render = context.scene.render
        view = View.of(context.region, context.region_data, render.preview_pixel_size)
        if session.advance(view):
            self.tag_redraw()
        self.update_stats("Dichromatic", session.status)
        gpu.state.blend_set("ALPHA_PREMULT")
        self.bind_display_space_shader(context.scene)
        session.draw()
        self.unbind_display_space_shader()
        gpu.state.blend_set("NONE")

    def _view_session(self) -> ViewSession:
        # Kept on the engine's Python object; there is no __init__, because its signature differs between versions.
        session: ViewSession | None = getattr(self, "_session", None)
        if session is None:
            session = ViewSession()
            self._session = session
        return session

    def _fail(self, reason: str) -> None:
        # error_set alone lets a script's render call end as FINISHED; report alone does not mark the result.
        self.error_set(reason)
        if not self.is_preview:  # drawn again at every edit: the node and the panel tell the reason
            self.report({"ERROR"}, reason)


def _remember(listener: Capture | None, error: BaseException) -> None:
    if listener is not None:
        listener.error = error


def _band_samples(settings: Any) -> int:
    """Return how many pixels are worked off at once, between two looks at the ESC key and two at the picture."""
    share = -(-settings.height // _BANDS_WANTED) * settings.width
    return max(_LEAST_BAND, min(max(share, _GOOD_BAND), _RAYS_A_BAND // settings.samples))


def _is_watched() -> bool:
    """Whether there is a window in which the picture can be seen growing."""
    return not bpy.app.background


def _alpha(render: Any, exported: ExportedScene) -> NDArray[np.float32] | None:
    """Return the opacity of each pixel; None where all are opaque. Holdouts are holes in any picture."""
    if exported.is_transparent:
        return render.alpha  # type: ignore[no-any-return]
    held = render.film.planes.get("held")
    return None if held is None else 1.0 - held


class _LayerJob:
    """One view layer from the dependency graph to the passes of Blender's result."""

    def __init__(self, engine: Any, listener: Capture | None) -> None:
        self._engine = engine
        self._listener = listener
        self._started = time.monotonic()
        self._layer = ""
        self._view = ""
        self._views_done, self._views = 0, 1
        self._pace, self._is_due = window_pace(), True  # whether the window is to hear of what comes now
        self._waiting = WaitingBands()
        self._text: tuple[float, str] | None = None  # for the status line: what part is done, and which

    def run(self, depsgraph: Any) -> FinishedLayer:
        self._progress(0.0, "reading the scene")
        exported = export_scene(
            depsgraph, camera=self._engine.camera_override, stop_if_cancelled=self._stop_if_cancelled
        )
        self._layer = exported.layer
        if self._engine.is_preview:
            exported = replace(exported, passes=PassRequest())
        for item in exported.passes.passes:
            self._engine.add_pass(item.name, len(item.channels), item.channels, layer=self._layer)
        settings = exported.settings
        if self._listener is not None and self._listener.adjust is not None:
            settings = self._listener.adjust(settings)
        settings = replace(settings, band_samples=_band_samples(settings))

        self._progress(0.0, "gathering triangles")
        acceleration = acceleration_for(
            exported,
            settings.precision,
            is_kept=depsgraph.scene.render.use_persistent_data and not self._engine.is_preview,
            stop_if_cancelled=self._stop_if_cancelled,
        )
        views = () if self._engine.is_preview else stereo_views(depsgraph.scene)
        if not views:
            return self._render(exported, settings, acceleration)
        self._views = len(views)
        finished = []
        for number, view in enumerate(views):
            self._views_done, self._view = number, view
            self._engine.active_view_set(view)
            camera = self._engine.camera_override or depsgraph.scene.camera
            eye = StereoEye(self._engine.camera_model_matrix(camera), self._engine.camera_shift_x(camera))
            seen = replace(exported, scene=replace(exported.scene, camera=export_camera(depsgraph, camera, eye)))
            finished.append(self._render(seen, settings, acceleration))
        return finished[0]  # what the studies go on with is the first eye's

    def _render(self, exported: ExportedScene, settings: Any, acceleration: Any) -> FinishedLayer:
        """Render what one eye sees, and hand it to Blender."""

        def show(band: Any) -> None:
            self._show(band, exported)

        self._waiting = WaitingBands()
        executor = None if self._listener is None else self._listener.executor
        is_watched = _is_watched()
        if is_watched and is_worth_it(settings):
            self._progress(0.0, "a first look")
            look = first_look(exported, settings, acceleration, self._is_cancelled)
            self._put_strips(
                0, settings.height, exported, lambda first, end: enlarged(look, settings.width, first, end)
            )
        render = core.render(
            exported.scene,
            settings,
            self._progress,
            self._is_cancelled,
            show if is_watched else None,
            acceleration=acceleration,
            executor=executor,
        )
        render.statistics.notes.extend(exported.notes)
        pixels = exported.colour.rgba(render.tristimulus(), _alpha(render, exported))
        self._put(0, {"Combined": pixels, **pass_pixels(render, exported)})
        self._tell(render)
        return FinishedLayer(render, exported)

    def _is_cancelled(self) -> bool:
        return bool(self._engine.test_break())

    def _stop_if_cancelled(self) -> None:
        if self._is_cancelled():
            raise core.RenderCancelledError("the render was cancelled")

    def _progress(self, fraction: float, message: str) -> None:
        # What is about to be done is told at once: it may take long.
        self._is_due = not _is_watched() or fraction == 0.0 or self._pace.is_due()
        fraction = (self._views_done + fraction) / self._views
        if self._listener is not None and self._listener.progress is not None:
            self._listener.progress(fraction, message)
            return
        if not self._is_due and fraction < 1.0:
            return
        self._text = (fraction, message)
        # Where rows are shown, these come first: what is told before them has Blender draw twice.
        if not _is_watched() or fraction in (0.0, 1.0):
            self._tell_progress()

    def _tell_progress(self) -> None:
        if self._text is None:
            return
        fraction, message = self._text
        self._text = None
        if 0.0 < fraction < 1.0:
            left = (time.monotonic() - self._started) * (1.0 - fraction) / fraction
            message = f"{message} | remaining {format_duration(left)}"
        self._engine.update_stats(self._layer, message)
        self._engine.update_progress(fraction)

    def _show(self, band: Any, exported: ExportedScene) -> None:
        """Hand a finished band to the window, with those that waited for it, if the window is to hear of it now."""
        self._waiting.add(band)
        if not self._is_due:
            return
        begun = self._pace.clock()
        for ready in self._waiting.take():
            self._put_band(ready, exported)
        self._tell_progress()
        self._pace.rest_after(self._pace.clock() - begun)

    def _put_band(self, band: Any, exported: ExportedScene) -> None:
        def pixels(first: int, end: int) -> NDArray[np.float32]:
            rows = slice(first - band.first_row, end - band.first_row)
            coverage = band.coverage[rows] if exported.is_transparent else None
            return exported.colour.rgba(band.tristimulus[rows], coverage)

        self._put_strips(band.first_row, band.first_row + len(band.tristimulus), exported, pixels)

    def _put_strips(
        self, first: int, end: int, exported: ExportedScene, pixels: Callable[[int, int], NDArray[np.float32]]
    ) -> None:
        """Write rows from `first` to before `end`, counted from the top, some at a time.

        ESC is asked for in between, and small arrays get memory that was used before, which is much sooner written.
        """
        height, width = exported.region.height, exported.region.width
        step = max(1, _STRIP // width)
        for top in range(first, end, step):
            self._stop_if_cancelled()
            bottom = min(top + step, end)
            self._put(height - bottom, {"Combined": pixels(top, bottom)})

    def _put(self, bottom: int, pixels: dict[str, NDArray[np.float32]]) -> None:
        """Write rows of some passes to the result, `bottom` being the lowest of them."""
        # Everything is computed before begin_result: an exception between it and end_result ends Blender.
        height, width, _ = pixels["Combined"].shape
        flat = {name: np.ascontiguousarray(rows[::-1], np.float32).ravel() for name, rows in pixels.items()}
        result = self._engine.begin_result(0, bottom, width, height, layer=self._layer, view=self._view)
        try:
            for render_pass in result.layers[0].passes:
                if render_pass.name in flat:
                    render_pass.rect.foreach_set(flat[render_pass.name])
        finally:
            self._engine.end_result(result)

    def _tell(self, render: Any) -> None:
        """Print the statistics, and report what was approximated."""
        notes = render.statistics.notes
        if self._engine.is_preview:
            return
        if notes:
            summary = (
                notes[0] if len(notes) == 1 else f"{len(notes)} things were approximated (see the console): {notes[0]}"
            )
            self._engine.report({"WARNING"}, summary)
        if self._listener is None or self._listener.progress is None:
            print(f"Dichromatic, view layer {self._layer}:\n{render.statistics.describe()}")


CLASSES = (DichromaticRenderEngine,)


def register() -> None:
    """Offer the engine to Blender."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take the engine out of Blender; one left registered at exit crashes 4.2 and hangs 4.5."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
