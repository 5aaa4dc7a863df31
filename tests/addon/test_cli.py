"""The command line, as a user runs it (a process of its own) and from within."""

from __future__ import annotations

import argparse
import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon import cli, cli_render
from dichromatic_addon._core import core
from dichromatic_addon.operators import render_layers
from dichromatic_addon.progress_bar import ProgressBar, format_duration
from tests.addon.building import add_camera, add_light, add_plane, small_picture, white_material
from tests.optional import needs_matplotlib
from tests.tolerances import FLOAT32_ROUNDING

pytestmark = pytest.mark.bpy

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def blend(scene: Any, tmp_path: Path) -> Path:
    """A saved file: a tilted white plane that fades from light to dark, with a keyframed lamp."""
    add_plane(scene, white_material(), size=4.0)
    light = add_light(scene, "POINT", 300.0, (2, 0, 2), shadow_soft_size=0.0)
    light.data.keyframe_insert("energy", frame=1)
    light.data.energy = 30.0
    light.data.keyframe_insert("energy", frame=10)
    add_camera(scene, (0, 0, 5))
    small_picture(scene, 40, 24)
    scene.frame_set(1)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def run(*arguments: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "dichromatic_addon", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        timeout=120,
        check=False,
    )


def pixels_of(path: Path) -> np.ndarray:
    """A picture as Blender reads it, without any conversion; (H, W, 4), row 0 at the top."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[::-1]


def test_png_holds_what_the_display_is_to_show(blend: Path, tmp_path: Path) -> None:
    output = tmp_path / "picture.png"
    done = run("render", blend, "-o", output)
    assert done.returncode == 0, done.stderr
    assert "camera rays" in done.stdout
    assert f"{output} written" in done.stdout
    finished = render_layers(bpy.context.scene)[0]
    shown = core.display("srgb")
    linear = shown.linear(finished.exported.colour.adapted(finished.render.tristimulus().astype(np.float64)))
    expected = shown.encode(core.fit_to_gamut(linear, shown).linear_rgb)
    assert np.ptp(expected) > 0.3
    # Half a step of rounding, and half a step of dither.
    np.testing.assert_allclose(pixels_of(output)[..., :3], expected, atol=1.01 / 255)


def test_exr_holds_linear_light(blend: Path, tmp_path: Path) -> None:
    output = tmp_path / "picture.exr"
    done = run("render", blend, "-o", output, "--frame", 10, "--samples", 2, "-q")
    assert done.returncode == 0, done.stderr
    assert "dichromatic" not in done.stderr  # Blender may speak of the system there; we have nothing to complain of
    assert "\r" not in done.stderr  # nor is a progress bar drawn where there is no terminal
    bpy.context.scene.frame_set(10)
    bpy.context.scene.dichromatic.samples = 2
    finished = render_layers(bpy.context.scene)[0]
    assert finished.exported.settings.samples == 2
    linear = core.display("srgb").linear(
        finished.exported.colour.adapted(finished.render.tristimulus().astype(np.float64))
    )
    np.testing.assert_allclose(pixels_of(output)[..., :3], linear, atol=10 * FLOAT32_ROUNDING * linear.max())


def test_size_replaces_the_files_own(blend: Path, tmp_path: Path) -> None:
    bpy.context.scene.render.resolution_percentage = 50
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "a.png"), "--size", "32x18", "-q"]) == 0
    assert pixels_of(tmp_path / "a.png").shape == (18, 32, 4)
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "b.png"), "-q"]) == 0
    assert pixels_of(tmp_path / "b.png").shape == (12, 20, 4)


def test_view_layer_is_chosen_by_name(blend: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "a.png"
    assert cli.main(["render", str(blend), "-o", str(output), "--layer", "Wrong"]) == 1
    assert "no view layer 'Wrong'; it has ViewLayer" in capsys.readouterr().err
    assert cli.main(["render", str(blend), "-o", str(output), "--layer", "ViewLayer", "-q"]) == 0


def test_exposure_and_display_change_the_png(blend: Path, tmp_path: Path) -> None:
    output = tmp_path / "a.png"
    assert cli.main(["render", str(blend), "-o", str(output), "-q"]) == 0
    plain = pixels_of(output)
    bpy.context.scene.view_settings.exposure = -2.0
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(output), "-q", "--display", "rec2020"]) == 0
    darker = pixels_of(output)
    linear = [core.display(name).decode(p[12, 20, :3]) for name, p in (("srgb", plain), ("rec2020", darker))]
    np.testing.assert_allclose(linear[1], linear[0] / 4, atol=0.01)  # two 8-bit steps


def test_transparent_film_gives_an_alpha_channel(blend: Path, tmp_path: Path) -> None:
    bpy.context.scene.render.film_transparent = True
    bpy.data.objects["Plane"].scale = (0.2, 0.2, 1.0)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "a.exr"), "-q"]) == 0
    alpha = pixels_of(tmp_path / "a.exr")[..., 3]
    assert alpha[12, 20] == 1.0
    assert alpha[0, 0] == 0.0


@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_blender_writes_where_openimageio_is_missing(
    blend: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    first, second = tmp_path / f"first{suffix}", tmp_path / f"second{suffix}"
    assert cli.main(["render", str(blend), "-o", str(first), "-q"]) == 0

    def missing(*arguments: Any, **named: Any) -> None:
        raise core.MissingDependencyError("OpenImageIO is not installed")

    monkeypatch.setattr(core, "write_image", missing)
    assert cli.main(["render", str(blend), "-o", str(second), "-q"]) == 0
    atol = 1.01 / 255 if suffix == ".png" else 0.0  # rounding with and without dither
    np.testing.assert_allclose(pixels_of(second), pixels_of(first), atol=atol)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([first.name, second.name, blend.name])


def test_failure_says_why_and_writes_nothing(blend: Path, tmp_path: Path) -> None:
    bpy.context.scene.camera.data.type = "PANO"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    before = {path.name for path in tmp_path.iterdir()}
    done = run("render", blend, "-o", tmp_path / "picture.png")
    assert done.returncode == 1
    assert "dichromatic: camera 'Camera' must be perspective or orthographic" in done.stderr
    assert "Traceback" not in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == before


def test_earlier_picture_survives_a_failure(blend: Path, tmp_path: Path) -> None:
    output = tmp_path / "picture.png"
    output.write_bytes(b"an earlier picture")
    bpy.context.scene.camera = None
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(output), "-q"]) == 1
    assert output.read_bytes() == b"an earlier picture"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["render", "absent.blend", "-o", "a.png"], "there is no file absent.blend"),
        (["render", "README.md", "-o", "a.png"], "README.md cannot be opened"),
        (["render", "README.md", "-o", "no/such/folder/a.png"], "folder no/such/folder of the output does not exist"),
    ],
)
def test_what_cannot_be_done_is_said(
    addon: Any, arguments: list[str], words: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    assert cli.main(arguments) == 1
    assert words in capfd.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "VERB"),
        (["paint"], "invalid choice"),
        (["render", "a.blend"], "-o"),
        (["render", "a.blend", "-o", "a.jpg"], ".png or .exr"),
        (["render", "a.blend", "-o", "a.png", "--size", "12"], "960x540"),
        (["render", "a.blend", "-o", "a.png", "--size", "0x9"], "between 4 and 65536"),
        (["render", "a.blend", "-o", "a.png", "--samples", "0"], "at least 1"),
        (["render", "a.blend", "-o", "a.png", "--samples", "many"], "at least 1"),
    ],
)
def test_wrong_arguments_are_explained(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(arguments) == 2
    assert words in capsys.readouterr().err


def test_help_lists_every_verb_and_needs_no_blender() -> None:
    script = (
        "import sys; sys.modules['bpy'] = None; from dichromatic_addon.cli import main, VERBS; "
        "code = main(['--help']); print('code', code, 'verbs', len(VERBS))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    assert f"code 0 verbs {len(cli.VERBS)}" in done.stdout, done.stderr
    for verb in cli.VERBS:
        assert verb.name in done.stdout


@pytest.mark.parametrize("verb", cli.VERBS, ids=lambda verb: verb.name)
def test_every_verb_declares_its_arguments(verb: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([verb.name, "--help"]) == 0
    assert verb.summary.capitalize() in " ".join(capsys.readouterr().out.split())


def test_interrupt_ends_with_the_shells_code(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for error in (KeyboardInterrupt(), core.RenderCancelledError("the render was cancelled")):

        def stopped(arguments: argparse.Namespace, error: BaseException = error) -> int:
            raise error

        monkeypatch.setattr(cli_render, "run", stopped)
        assert cli.main(["render", "a.blend", "-o", "a.png"]) == 130
        assert "nothing was written" in capsys.readouterr().err


def test_progress_bar_fits_the_terminal_and_is_silent_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setenv("COLUMNS", "60")
    terminal, file = Terminal(), io.StringIO()
    for stream in (terminal, file):
        bar = ProgressBar(stream)
        bar.update(0.5, "rows 1 to 10 of 20")
        bar.update(1.0, "done")
        bar.close()
    assert file.getvalue() == ""
    assert terminal.getvalue().endswith("\n")
    line = ProgressBar(terminal).line(0.25, "rows 1 to 10 of 20", 75.0)
    assert line.startswith(" 25% [####")
    assert "1:15, 3:45 left  rows" in line
    assert len(line) < 60


@pytest.mark.parametrize(("seconds", "text"), [(0.0, "0:00"), (59.6, "1:00"), (75.2, "1:15"), (3661.0, "1:01:01")])
def test_durations_read_like_a_clock(seconds: float, text: str) -> None:
    assert format_duration(seconds) == text


def test_command_is_offered_inside_blender(addon: Any) -> None:
    """As ``blender --command dichromatic ...``; a second registration of the name would be refused."""
    assert len(cli._handles) == 1
    cli.unregister()
    assert cli._handles == []
    cli.register()
    assert len(cli._handles) == 1


def test_plan_says_what_the_file_requires(blend: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["plan", str(blend)]) == 0
    printed = capfd.readouterr().out
    assert "+ shadow rays and shading for light 'Point': lit by" in printed
    assert "- mirror bounces: no visible material mirrors the scene" in printed


@needs_matplotlib
def test_tradeoff_measures_the_file(blend: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    table, plot = tmp_path / "cost.csv", tmp_path / "cost.png"
    assert cli.main(["tradeoff", str(blend), "--size", "24x16", "--csv", str(table), "--plot", str(plot)]) == 0
    printed = capfd.readouterr().out
    assert "24 x 16, 4 samples a pixel; Delta E 2000:" in printed
    assert "For a mean Delta E 2000: for 1 take" in printed
    rows = table.read_text().splitlines()
    assert rows[0] == "axis,value,delta_e_mean,delta_e_95,delta_e_max,seconds,pareto"
    assert {row.split(",")[0] for row in rows[1:]} == {"samples", "precision", "wavelengths", "resolution"}
    assert plot.stat().st_size > 1000


@pytest.mark.parametrize(
    ("plot", "words"),
    [("cost.gif", "plot must end in .png, .svg or .pdf"), ("nowhere/cost.png", "nowhere of the plot does not exist")],
)
def test_tradeoff_refuses_a_plot_before_it_measures(
    blend: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    plot: str,
    words: str,
) -> None:
    monkeypatch.setattr(core, "measure_tradeoff", lambda *_, **__: pytest.fail("it was measured"))
    if plot.startswith("nowhere"):
        monkeypatch.setattr(
            "dichromatic_addon.plotting.new_figure", lambda *_: None
        )  # where matplotlib is missing, too
    assert cli.main(["tradeoff", str(blend), "--plot", str(tmp_path / plot)]) == 1
    assert words in capsys.readouterr().err


def test_a_kept_film_is_relit_like_a_fresh_render(blend: Path, tmp_path: Path) -> None:
    """What the command line keeps and relights is what Blender renders once the lamp is dimmed in the file."""
    film, relit, fresh = tmp_path / "kept.npz", tmp_path / "relit.exr", tmp_path / "fresh.exr"
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "a.exr"), "--film", str(film), "-q"]) == 0
    assert cli.main(["relight", str(film), "--power", "Point=30", "-o", str(relit)]) == 0
    assert cli.main(["render", str(blend), "-o", str(fresh), "--frame", "10", "-q"]) == 0
    np.testing.assert_allclose(pixels_of(relit), pixels_of(fresh), rtol=4 * FLOAT32_ROUNDING, atol=1e-7)


def test_processes_and_threads_give_the_same_picture(blend: Path, tmp_path: Path) -> None:
    pictures = []
    for number, options in enumerate((["--threads", 1], ["--threads", 3], ["--processes", 2])):
        output = tmp_path / f"{number}.png"
        done = run("render", blend, "-o", output, "--samples", 5, "--adaptive", 0.5, *options)
        assert done.returncode == 0, done.stderr
        assert "took all samples" in done.stdout
        pictures.append(output.read_bytes())
    assert pictures[0] == pictures[1] == pictures[2]
    refused = run("render", blend, "-o", tmp_path / "x.png", "--processes", -1)
    assert refused.returncode != 0
    assert "processes must be at least 0, but is -1" in refused.stderr
