"""F12 as a key, what is shown meanwhile, and the studies of the last render in the Image Editor."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
from stage import ENGINE, Stage, Step, act, until
from x_window import press_key

ended: list[tuple[str, float]] = []


def note_ends() -> None:
    for name in ("render_complete", "render_cancel"):
        kind = name.removeprefix("render_")
        getattr(bpy.app.handlers, name).append(lambda *_, kind=kind: ended.append((kind, time.perf_counter())))


def render_with_f12(stage: Stage) -> Step:
    ended.clear()
    press_key("F12")
    yield until(lambda: ended, "F12 ended", limit=120.0)
    assert ended[0][0] == "complete", ended
    yield from job_over(stage)


def job_over(stage: Stage) -> Step:
    """Wait for Blender to take the render's job down, and close the window that it opened."""
    yield until(lambda: not bpy.app.is_job_running("RENDER"), "the render job was over")
    while len(bpy.context.window_manager.windows) > 1:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[-1]):
            bpy.ops.wm.window_close()
        yield until(lambda: True, "the render's window was closed")


def image_area(stage: Stage) -> Any:
    area = stage.area("VIEW_3D")
    area.ui_type = "IMAGE_EDITOR"
    area.spaces.active.show_region_ui = True
    return area


def studies(stage: Stage) -> Step:
    """The Image Editor's panels with a kept render: all operators of the studies, by their names."""
    area = image_area(stage)
    region = next(region for region in area.regions if region.type == "UI")
    yield until(lambda: area.tag_redraw() or region.width > 10, "the sidebar was open")
    yield until(lambda: show_category(region, area), "the sidebar showed the tab Dichromatic", limit=20.0)
    yield from stage.show(area, "a kept render", "UI")
    scene = stage.scene
    with stage.override(area):
        assert bpy.ops.dichromatic.relight() == {"FINISHED"}
        assert bpy.ops.dichromatic.show_render() == {"FINISHED"}
    yield from stage.show(area, "relit", "UI")
    stage.shot("image_editor", area)
    for name, call in (
        ("metamerism_map", lambda: bpy.ops.dichromatic.metamerism_map(first="D65", second="A")),
        ("contact_sheet", lambda: bpy.ops.dichromatic.contact_sheet()),
        ("probe_pixel", lambda: bpy.ops.dichromatic.probe_pixel(x=100, y=60)),
    ):
        with stage.override(area):
            assert call() == {"FINISHED"}, name
        yield from stage.show(area, f"after {name}", "UI")
        if name == "contact_sheet":
            assert_seen_whole(area)
            stage.shot("contact_sheet", area)
    with stage.override(area):
        bpy.ops.dichromatic.study_lamps(action="STANDARD")
    yield from stage.show(area, "lamps chosen", "UI")
    stage.shot("image_editor_studied", area)
    bpy.data.lights["Light"].dichromatic.source = "LIBRARY"
    bpy.data.lights["Light"].dichromatic.illuminant = "A"
    bpy.data.objects["Cube"].location.x += 0.5
    images = bpy.data.images
    before = mean_of(images["Dichromatic Render"])
    yield until(
        lambda: abs(mean_of(images["Dichromatic Render"])[2] - before[2]) > 0.01 * before[2],
        "live relighting changed the image",
    )
    yield from stage.show(area, "relit live, and out of date", "UI")
    stage.shot("image_editor_outdated", area)
    scene.render.engine = "BLENDER_WORKBENCH"
    yield from stage.show(area, "a kept render, and another engine", "UI")
    scene.render.engine = ENGINE
    properties = stage.area("PROPERTIES")
    yield stage.tab("RENDER")
    yield from stage.show(properties, "Render properties with a kept render")
    stage.shot("render_properties_studied", properties)
    with stage.override(area):
        assert bpy.ops.dichromatic.free_render() == {"FINISHED"}
    yield from stage.show(area, "the render was freed", "UI")
    stage.shot("image_editor_free", area)


def assert_seen_whole(area: Any) -> None:
    """The picture lies within the editor's window, and not below its sidebar."""
    regions = {region.type: region for region in area.regions}
    window, sidebar = regions["WINDOW"], regions["UI"]
    left, bottom = window.view2d.view_to_region(0.0, 0.0, clip=False)
    right, top = window.view2d.view_to_region(1.0, 1.0, clip=False)
    free = min(window.width, sidebar.x - window.x)
    where = f"({left}, {bottom}) to ({right}, {top}) of {free} x {window.height}"
    assert 0 <= left < right <= free, where
    assert 0 <= bottom < top <= window.height, where


def show_category(region: Any, area: Any) -> bool:
    """Choose the add-on's tab of the sidebar, which has it once it was drawn."""
    try:
        region.active_panel_category = "Dichromatic"
    except (AttributeError, TypeError):
        area.tag_redraw()
        return False
    return True


def mean_of(image: Any) -> list[float]:
    import numpy as np

    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, 4).mean(axis=0).tolist()


def script(stage: Stage) -> Step:
    yield until(lambda: stage.window.screen, "there was a window")
    scene = stage.scene
    scene.render.engine = ENGINE
    scene.render.resolution_x, scene.render.resolution_y, scene.dichromatic.samples = 480, 270, 4
    stage.watch_panels()
    note_ends()
    yield from render_with_f12(stage)
    stage.shot("f12")
    pixels = mean_of_result(stage)
    assert pixels[1] > 0.0, f"the kept render is black: {pixels}"
    yield from studies(stage)


def mean_of_result(stage: Stage) -> list[float]:
    kept = stage.module("last_render").kept_render(stage.scene)
    return [float(value) for value in kept.layer(stage.window.view_layer.name).render.tristimulus().mean(axis=(0, 1))]


act(script)
