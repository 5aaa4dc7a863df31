"""F12: what Blender receives is what the core computed, in every pass, layer and band."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon import engine as engine_module
from dichromatic_addon._core import core
from dichromatic_addon.engine import DichromaticRenderEngine, _LayerJob
from dichromatic_addon.first_look import enlarged, first_look, is_worth_it
from dichromatic_addon.operators import _our_engine, render_layers
from dichromatic_addon.window_updates import Pace
from tests.addon.building import add_camera, add_light, add_plane, combined, small_picture, white_material
from tests.tolerances import FLOAT32_ROUNDING

pytestmark = pytest.mark.bpy


@pytest.fixture
def studio(scene: Any) -> Any:
    """A white and a red plane, one above the other, seen from aside, under a lamp."""
    add_plane(scene, white_material(), name="Floor")
    red = bpy.data.materials.new("Red")
    red.diffuse_color = (0.6, 0.05, 0.02, 1.0)
    if red.node_tree is not None:
        red.node_tree.nodes.clear()
    add_plane(scene, red, size=1.5, height=0.5, name="Sheet")
    add_light(scene, "POINT", 800.0, (2, -3, 4), shadow_soft_size=0.0)
    add_camera(scene, (0, -6, 4), (math.radians(55), 0, 0))
    small_picture(scene, 40, 24)
    return scene


def expected(finished: Any) -> np.ndarray:
    """Linear Rec.709 of the core's own render of the exported scene."""
    exported = finished.exported
    xyz = core.render(exported.scene, exported.settings).tristimulus()
    return core.display("srgb").linear(exported.colour.adapted(xyz.astype(np.float64)))


def test_picture_is_the_cores(studio: Any, tmp_path: Path) -> None:
    pixels = combined(studio, str(tmp_path / "picture.exr"))
    finished = render_layers(studio)[0]
    reference = expected(finished)
    assert reference.max() > 0.5
    assert np.ptp(reference[..., 0] - reference[..., 2]) > 0.1
    # Blender's own matrix to Rec.709 has four digits.
    np.testing.assert_allclose(pixels[..., :3], reference, atol=1e-3 * reference.max())
    assert (pixels[..., 3] == 1.0).all()


def test_picture_is_not_upside_down(studio: Any, tmp_path: Path) -> None:
    """The lamp-lit floor is below; above the horizon there is nothing."""
    studio.camera.rotation_euler.x = math.radians(75)
    pixels = combined(studio, str(tmp_path / "picture.exr"))
    assert pixels[0, :, :3].max() == 0.0
    assert pixels[-1, :, 1].min() > 0.0


def test_border_renders_the_same_pixels(studio: Any) -> None:
    studio.dichromatic.samples = 1
    whole = expected(render_layers(studio)[0])
    render = studio.render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
    finished = render_layers(studio)[0]
    part = expected(finished)
    assert part.shape == (12, 20, 3)
    difference = np.abs(part - whole[:12, 10:30]).max(axis=-1)
    # The rays are the same up to rounding; one on an edge may fall on the other side.
    assert np.quantile(difference, 0.98) < 1e-4


def test_every_view_layer_has_its_own_picture(studio: Any) -> None:
    second = studio.view_layers.new("Without sheet")
    sheet = bpy.data.collections.new("Sheets")
    studio.collection.children.link(sheet)
    sheet.objects.link(bpy.data.objects["Sheet"])
    studio.collection.objects.unlink(bpy.data.objects["Sheet"])
    second.layer_collection.children["Sheets"].exclude = True
    layers = render_layers(studio)
    assert [finished.exported.layer for finished in layers] == ["ViewLayer", "Without sheet"]
    assert [len(finished.exported.scene.instances) for finished in layers] == [2, 1]
    assert [f.exported.layer for f in render_layers(studio, layer="Without sheet")] == ["Without sheet"]
    assert [layer.use for layer in studio.view_layers] == [True, True]


def test_a_view_layer_overrides_samples_and_materials(studio: Any) -> None:
    second = studio.view_layers.new("Second")
    studio.dichromatic.samples = 3
    second.samples = 7
    second.material_override = white_material("Clay")
    first, other = (finished.exported for finished in render_layers(studio))
    assert (first.settings.samples, other.settings.samples) == (3, 7)
    assert (first.scene.material_names, other.scene.material_names) == (("White", "Red"), ("Clay",))


def test_frames_of_an_animation_differ(studio: Any, tmp_path: Path) -> None:
    sheet = bpy.data.objects["Sheet"]
    for frame, x in ((1, -1.0), (2, 1.0)):
        sheet.location.x = x
        sheet.keyframe_insert("location", frame=frame)
    studio.frame_start, studio.frame_end = 1, 2
    studio.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["frame_0001.exr", "frame_0002.exr"]
    places = []
    for frame in (1, 2):
        studio.frame_set(frame)
        sheet_instance = next(i for i in render_layers(studio)[0].exported.scene.instances if i.name == "Sheet")
        places.append(float(sheet_instance.matrix[0, 3]))
    assert places == [-1.0, 1.0]


def test_persistent_settings_reach_the_core(studio: Any) -> None:
    settings = studio.dichromatic
    settings.samples, settings.seed, settings.observer, settings.grid = 3, 5, "cie_1964_10", "standard"
    settings.precision, settings.pixel_filter, settings.filter_width = "float64", "box", 2.0
    used = render_layers(studio)[0].exported.settings
    assert (used.samples, used.seed, used.observer, used.grid) == (3, 5, "cie_1964_10", "standard")
    assert (used.precision, used.pixel_filter, used.filter_width) == ("float64", "box", 2.0)
    assert (used.width, used.height) == (40, 24)


def test_adopted_white_is_brought_to_the_displays_white(studio: Any, tmp_path: Path) -> None:
    lamp = bpy.data.lights["Point"].dichromatic
    lamp.source, lamp.illuminant = "LIBRARY", "A"
    studio.dichromatic.adaptation = "none"
    orange = combined(studio, str(tmp_path / "orange.exr"))[-1, 20, :3]
    assert orange[0] > 1.5 * orange[2]
    studio.dichromatic.adaptation, studio.dichromatic.white_illuminant = "bradford", "A"
    neutral = combined(studio, str(tmp_path / "neutral.exr"))[-1, 20, :3]
    assert np.ptp(neutral) < 2e-3 * neutral.max()


class Recorder:
    """Stands in for the engine and its result, and keeps what is put into them."""

    is_preview = False
    camera_override = None

    def __init__(self, width: int, height: int) -> None:
        self.pixels = np.full((height, width, 4), np.nan, np.float32)
        self.depth: np.ndarray | None = None
        self.tiles: list[tuple[int, int, int, int]] = []
        self.open = False
        self.messages: list[str] = []
        self.shown_before: list[int] = []  # tiles, by message of the status line
        self.fractions: list[float] = []

    def begin_result(self, x: int, y: int, width: int, height: int, layer: str, view: str = "") -> Any:
        assert not self.open
        self.open = True
        self.tiles.append((x, y, width, height))
        return self

    def end_result(self, result: Any) -> None:
        assert self.open
        self.open = False

    @property
    def layers(self) -> Any:
        return [self]

    @property
    def passes(self) -> Any:
        return [self]

    def test_break(self) -> bool:
        return False

    def update_stats(self, layer: str, message: str) -> None:
        self.messages.append(message)
        self.shown_before.append(len(self.tiles))

    def update_progress(self, fraction: float) -> None:
        self.fractions.append(fraction)

    def report(self, kind: set[str], message: str) -> None:
        self.messages.append(message)

    name = "Combined"

    @property
    def rect(self) -> Any:
        return self

    def foreach_set(self, values: np.ndarray) -> None:
        x, y, width, height = self.tiles[-1]
        self.pixels[y : y + height, x : x + width] = values.reshape(height, width, 4)


def test_bands_build_up_the_picture_from_the_top(studio: Any) -> None:
    """Each band lands where the whole picture has it; rows are counted from below in Blender."""
    studio.render.resolution_x, studio.render.resolution_y = 1200, 48
    studio.dichromatic.samples = 1
    exported = render_layers(studio)[0].exported
    recorder = Recorder(1200, 48)
    job = _LayerJob(recorder, None)
    bands: list[Any] = []
    whole = core.render(exported.scene, exported.settings, on_band=bands.append)
    bands.clear()
    core.render(exported.scene, replace(exported.settings, band_samples=1200 * 7), on_band=bands.append)
    for band in bands:
        job._show(band, exported)
    assert [tile[1] for tile in recorder.tiles] == [41, 34, 27, 20, 13, 6, 0]
    reference = exported.colour.rgba(whole.tristimulus(), None)
    np.testing.assert_allclose(recorder.pixels[::-1], reference, atol=FLOAT32_ROUNDING * reference.max())


def test_a_watched_render_shows_a_first_look_then_its_parts_then_the_whole(
    studio: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    studio.render.resolution_x, studio.render.resolution_y = 1024, 96
    studio.dichromatic.samples = 2
    monkeypatch.setattr(engine_module, "_is_watched", lambda: True)
    monkeypatch.setattr(engine_module, "is_worth_it", lambda settings: True)
    monkeypatch.setattr(engine_module, "window_pace", lambda: Pace(clock=itertools.count(0.0, 100.0).__next__))
    recorder = Recorder(1024, 96)
    finished = _LayerJob(recorder, None).run(bpy.context.evaluated_depsgraph_get())
    first, *parts, whole = recorder.tiles
    assert first == whole == (0, 0, 1024, 96)
    assert len(parts) > 1
    assert all(height < 96 for _, _, _, height in parts)
    reference = finished.exported.colour.rgba(finished.render.tristimulus(), None)
    np.testing.assert_array_equal(recorder.pixels[::-1], reference)
    assert recorder.messages.index("a first look") < next(i for i, m in enumerate(recorder.messages) if "rows" in m)
    assert any("remaining" in message for message in recorder.messages)
    assert recorder.fractions == sorted(recorder.fractions)
    assert recorder.fractions[-1] == 1.0


@pytest.mark.parametrize("seconds_a_look", [0.0, 0.2])
def test_bands_that_waited_are_shown_with_the_next(
    studio: Any, monkeypatch: pytest.MonkeyPatch, seconds_a_look: float
) -> None:
    """From the top, none left out; with time standing still nothing is shown between the first and the whole."""
    studio.render.resolution_x, studio.render.resolution_y = 1200, 480
    studio.dichromatic.samples, studio.render.threads_mode, studio.render.threads = 1, "FIXED", 1
    monkeypatch.setattr(engine_module, "_is_watched", lambda: True)
    monkeypatch.setattr(engine_module, "_band_samples", lambda settings: 1200 * 20)
    ticks = itertools.count(0.0, seconds_a_look)
    monkeypatch.setattr(engine_module, "window_pace", lambda: Pace(clock=ticks.__next__))
    recorder = Recorder(1200, 480)
    _LayerJob(recorder, None).run(bpy.context.evaluated_depsgraph_get())
    *parts, whole = recorder.tiles
    assert whole == (0, 0, 1200, 480)
    tops = [480 - y - height for _, y, _, height in parts]
    assert tops == list(range(0, 20 * len(parts), 20))
    told = [message for message in recorder.messages if "rows" in message]
    first_rows = next(i for i, message in enumerate(recorder.messages) if "rows" in message)
    assert recorder.shown_before[first_rows] == 1  # text and rows come together, for one drawing
    if seconds_a_look == 0.0:
        assert len(parts) == 1
        assert len(told) == 2  # the last part's, when all is done, is told
    else:
        assert 1 < len(told) < len(parts)


def test_a_cancelled_render_shows_no_more(studio: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A first look of four strips, and a key that is pressed while the first is shown."""
    studio.render.resolution_x, studio.render.resolution_y = 1024, 1024
    studio.dichromatic.samples = 1
    monkeypatch.setattr(engine_module, "_is_watched", lambda: True)
    monkeypatch.setattr(engine_module, "is_worth_it", lambda settings: True)
    recorder = Recorder(1024, 1024)
    monkeypatch.setattr(recorder, "test_break", lambda: len(recorder.tiles) > 0)
    with pytest.raises(core.RenderCancelledError):
        _LayerJob(recorder, None).run(bpy.context.evaluated_depsgraph_get())
    assert recorder.tiles == [(0, 768, 1024, 256)]
    assert not recorder.open


def test_the_first_look_is_the_picture_in_coarse(studio: Any) -> None:
    """Each of its squares is what one ray through the square's middle sees: the pixel of the picture there."""
    studio.render.resolution_x, studio.render.resolution_y = 131, 75
    studio.dichromatic.samples, studio.dichromatic.pixel_filter, studio.dichromatic.filter_width = 1, "box", 0.001
    finished = render_layers(studio)[0]
    exported = finished.exported
    fine = exported.colour.rgba(finished.render.tristimulus(), None)
    acceleration = core.Acceleration(core.Geometry.from_instances(exported.scene.instances))
    coarse = first_look(exported, exported.settings, acceleration, lambda: False)
    look = enlarged(coarse, 131, 0, 75)
    np.testing.assert_array_equal(enlarged(coarse, 131, 13, 42), look[13:42])
    assert look.shape == (75, 131, 4)
    middles = look[3::8, 3::8, 1]
    assert len(np.unique(middles)) > 50
    for corner in (look[:72:8, :128:8], look[7::8, 7::8]):
        np.testing.assert_array_equal(corner[:9, :16], look[3:72:8, 3:128:8][:9, :16])
    # The ray of a square goes through the corner of four pixels, half a pixel away from their middles.
    around = [fine[3 + dy : 72 : 8, 3 + dx : 128 : 8, 1][:9, :16] for dy in (0, 1) for dx in (0, 1)]
    between = np.mean(around, axis=0)
    assert np.quantile(np.abs(look[3:72:8, 3:128:8, 1][:9, :16] - between), 0.9) < 0.01 * fine[..., 1].max()
    with pytest.raises(core.RenderCancelledError):
        first_look(exported, exported.settings, acceleration, lambda: True)
    assert not is_worth_it(exported.settings)
    assert is_worth_it(replace(exported.settings, samples=1000))


def test_working_space_matrix_is_that_of_rec709(addon: Any) -> None:
    from dichromatic_addon.picture import working_space_from_tristimulus

    np.testing.assert_allclose(working_space_from_tristimulus(), core.display("srgb").from_tristimulus, atol=1e-3)


def test_depth_pass_holds_distances(studio: Any, tmp_path: Path) -> None:
    studio.view_layers[0].use_pass_z = True
    studio.dichromatic.samples = 1
    finished = render_layers(studio)[0]
    assert [item.name for item in finished.exported.passes.passes] == ["Depth"]
    depth = finished.render.depth
    centre = float(depth[12, 20])
    # The view axis meets the floor, 4 m below, after 4 / cos 55 degrees.
    assert centre == pytest.approx(4.0 / math.cos(math.radians(55)), rel=0.02)
    saved = depth_of_multilayer(studio, tmp_path / "passes.exr")
    finite = np.isfinite(depth)
    np.testing.assert_allclose(saved[finite], depth[finite], rtol=FLOAT32_ROUNDING)
    assert (saved[~finite] >= 1e9).all()


def depth_of_multilayer(scene: Any, path: Path) -> np.ndarray:
    """The Depth pass as Blender saves it."""
    from dichromatic_addon import compat

    openimageio = pytest.importorskip("OpenImageIO")
    compat.set_multilayer_exr(scene.render.image_settings)
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    source = openimageio.ImageInput.open(str(path))
    try:
        part = 0
        while source.seek_subimage(part, 0):
            names = source.spec().channelnames
            for channel, name in enumerate(names):
                if "Depth" in name:
                    return np.array(source.read_image(part, 0, channel, channel + 1, openimageio.FLOAT))[..., 0]
            part += 1
    finally:
        source.close()
    raise AssertionError(f"{path} has no Depth")


def test_image_datablock_holds_the_linear_picture(studio: Any) -> None:
    studio.render.engine = "CYCLES"  # any engine may be set
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    assert studio.render.engine == "CYCLES"
    image = bpy.data.images["Dichromatic Render"]
    assert image.colorspace_settings.name == "Linear Rec.709"
    assert image.is_float
    pixels = np.empty(40 * 24 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    reference = expected(render_layers(studio)[0])
    np.testing.assert_allclose(
        pixels.reshape(24, 40, 4)[::-1, :, :3], reference, atol=10 * FLOAT32_ROUNDING * reference.max()
    )
    # Again in another size: the same datablock, so that its users keep it.
    studio.render.resolution_x = 30
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    assert tuple(image.size) == (30, 24)
    assert [i.name for i in bpy.data.images if i.name.startswith("Dichromatic")] == ["Dichromatic Render"]


def test_rendering_loads_neither_colour_science_nor_scipy(tmp_path: Path) -> None:
    script = """
import sys
import bpy
import dichromatic_addon
dichromatic_addon.register()
try:
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    scene.render.engine = "DICHROMATIC"
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.filepath = sys.argv[1]
    bpy.ops.render.render(write_still=True)
    print("loaded:", sorted({"colour", "scipy", "matplotlib", "OpenImageIO"} & set(sys.modules)))
finally:
    dichromatic_addon.unregister()
"""
    path = tmp_path / "picture.png"
    run = subprocess.run(
        [sys.executable, "-c", script, str(path)],
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[2],
        stdin=subprocess.DEVNULL,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert path.stat().st_size > 0
    assert "loaded: []" in run.stdout


def test_engine_is_as_blender_expects(addon: Any) -> None:
    assert DichromaticRenderEngine.is_registered
    assert DichromaticRenderEngine.bl_use_postprocess
    # An __init__ without *args and **kwargs breaks from 4.4 on; there is none.
    assert "__init__" not in vars(DichromaticRenderEngine)


@pytest.mark.parametrize("engine", ["DICHROMATIC", "CYCLES"])
def test_the_engine_is_set_only_where_it_is_another(engine):
    """Blender waits for running previews when it is set, even to what it is; ours wait for the Python that sets it."""
    chosen = []

    class Settings(SimpleNamespace):
        def __setattr__(self, name: str, value: Any) -> None:
            if name == "engine":
                chosen.append(value)
            super().__setattr__(name, value)

    render = Settings(engine=engine, use_compositing=True, use_sequencer=True)
    with _our_engine(SimpleNamespace(render=render, view_layers=[])):
        assert (render.engine, render.use_compositing) == ("DICHROMATIC", False)
    assert (render.engine, render.use_compositing, render.use_sequencer) == (engine, True, True)
    assert chosen == ([] if engine == "DICHROMATIC" else ["DICHROMATIC", "CYCLES"])
