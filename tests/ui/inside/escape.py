"""ESC while a picture is rendered, by Dichromatic and by Cycles in the same window, with the parts of the wait.

The key comes from a thread of its own at moments that have nothing to do with what Blender is at, as a user's does:
in the middle of a drawing as well as between two.
"""

from __future__ import annotations

import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
from stage import ENGINE, Stage, Step, act, until
from x_window import press_key

SIZES = ((1280, 720, 64), (1920, 1080, 64), (3840, 2160, 16))
BEGUN_S = 2.0  # after F12: both engines are at their rays then
MOMENTS = (0.0, 0.23, 0.51, 0.88, 1.37, 1.74, 2.29)  # seconds after that
CYCLES_SAMPLES = 4096  # it shows all of the picture and adds samples to it; these are not over soon
AT_REST = 30  # rounds of the main loop without a drawing: the 3D view draws itself several times after a change


@dataclass
class Watched:
    """What is known of the render under way.

    Attributes
    ----------
    ended : list of (str, float)
        "complete" or "cancel", and when.
    rows_shown : bool
        Whether Dichromatic has handed rows to Blender.
    noticed, engine_ended : float or None
        When Dichromatic was first told to end, and when it had.
    seen : float or None
        When Blender's main loop, which draws the windows too, came round to the key.
    draws : int
        How often the picture or the 3D view was drawn.
    rounds, drawn : int
        Rounds of the main loop without a drawing, and how many drawings there were at the last.
    """

    ended: list[tuple[str, float]] = field(default_factory=list)
    rows_shown: bool = False
    noticed: float | None = None
    engine_ended: float | None = None
    seen: float | None = None
    draws: int = 0
    rounds: int = 0
    drawn: int = 0


now = Watched()


class STAGE_OT_watch_keys(bpy.types.Operator):  # noqa: N801
    """Sees every key that the window gets, and leaves it to the others."""

    bl_idname = "stage.watch_keys"
    bl_label = "Watch Keys"

    def invoke(self, context: Any, event: Any) -> set[str]:
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        if event.type == "ESC" and now.seen is None:
            now.seen = time.perf_counter()
        return {"PASS_THROUGH"}


def watch(stage: Stage) -> None:
    for name in ("render_complete", "render_cancel"):
        kind = name.removeprefix("render_")
        getattr(bpy.app.handlers, name).append(lambda *_, kind=kind: now.ended.append((kind, time.perf_counter())))
    engine = stage.module("engine")
    job, render = engine._LayerJob, engine.DichromaticRenderEngine.render
    asked, shown = job._is_cancelled, job._show

    def asking(self: Any) -> bool:
        is_cancelled = bool(asked(self))
        if is_cancelled and now.noticed is None:
            now.noticed = time.perf_counter()
        return is_cancelled

    def showing(self: Any, *given: Any) -> None:
        shown(self, *given)
        now.rows_shown = True

    def rendering(self: Any, depsgraph: Any) -> None:
        render(self, depsgraph)
        now.engine_ended = time.perf_counter()

    def drawn() -> None:
        now.draws += 1

    job._is_cancelled, job._show, engine.DichromaticRenderEngine.render = asking, showing, rendering
    for space in (bpy.types.SpaceImageEditor, bpy.types.SpaceView3D):
        space.draw_handler_add(drawn, (), "WINDOW", "POST_PIXEL")


def is_at_rest() -> bool:
    """Whether nothing was drawn for some rounds of the main loop."""
    now.rounds, before, now.drawn = now.rounds + 1, now.drawn, now.draws
    if now.draws != before:
        now.rounds = 0
    return now.rounds > AT_REST


def press_soon(seconds: float) -> tuple[threading.Thread, list[float]]:
    """Press ESC after a while, whatever Blender is doing then."""
    pressed: list[float] = []

    def press() -> None:
        time.sleep(seconds)
        pressed.append(press_key("ESC"))

    thread = threading.Thread(target=press)
    thread.start()
    return thread, pressed


def cancel(stage: Stage, name: str, moment: float) -> Step:
    """Start a render, have ESC pressed, and note how long it took to end."""
    global now
    now = Watched()
    yield until(is_at_rest, "the 3D view was at rest")
    now.draws = 0
    press_key("F12")
    begun = time.perf_counter()
    if stage.scene.render.engine == ENGINE:
        yield until(lambda: now.rows_shown or now.ended, "the first rows were shown", limit=120.0)
    else:
        yield until(lambda: bpy.app.is_job_running("RENDER"), "the render began")
    assert not now.ended, "the render was over before it could be cancelled"
    thread, pressed = press_soon(max(begun + BEGUN_S - time.perf_counter(), 0.0) + moment)
    yield until(lambda: now.ended, "ESC ended the render", limit=60.0)
    thread.join()
    assert pressed, f"the render ended by itself, {now.ended}"
    kind, when = now.ended[0]
    assert kind == "cancel", f"the render ended as '{kind}', not by ESC"
    windows = bpy.context.window_manager.windows
    moments = {"seen": now.seen, "noticed": now.noticed, "engine ended": now.engine_ended, "ended": when}
    parts = {
        **{name: None if at is None else at - pressed[0] for name, at in moments.items()},
        "draws a second": now.draws / (when - begun),
        "moment": moment,
        "window": [windows[-1].width, windows[-1].height],
    }
    stage.report.setdefault("escape", {}).setdefault(name, {}).setdefault(stage.scene.render.engine, []).append(parts)
    yield until(lambda: not bpy.app.is_job_running("RENDER"), "the render job was over")


def drawing_time(stage: Stage, name: str) -> None:
    """Note how long Blender takes to draw its windows when nothing is rendered."""
    found = []
    for _ in range(5):
        begun = time.perf_counter()
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                area.tag_redraw()
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
        found.append(time.perf_counter() - begun)
    stage.report.setdefault("drawing", {})[name] = found


def close_windows() -> Step:
    while len(bpy.context.window_manager.windows) > 1:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[-1]):
            bpy.ops.wm.window_close()
        yield until(lambda: True, "the render's window was closed")


def script(stage: Stage) -> Step:
    yield until(lambda: stage.window.screen, "there was a window")
    scene = stage.scene
    watch(stage)
    bpy.utils.register_class(STAGE_OT_watch_keys)
    with bpy.context.temp_override(window=stage.window):
        bpy.ops.stage.watch_keys("INVOKE_DEFAULT")
    compares = "compare" in stage.arguments
    scene.cycles.samples = CYCLES_SAMPLES
    scene.cycles.use_adaptive_sampling = False
    for width, height, samples in SIZES:
        name = f"{width} x {height}"
        scene.render.resolution_x, scene.render.resolution_y = width, height
        scene.dichromatic.samples = samples
        for moment in MOMENTS if compares else MOMENTS[1:2]:
            for engine in (ENGINE, "CYCLES") if compares else (ENGINE,):  # in turn: others may use the machine, too
                scene.render.engine = engine
                yield from cancel(stage, name, moment)
        drawing_time(stage, name)
        yield from close_windows()


act(script)
