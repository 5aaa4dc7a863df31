"""The verbs that work on kept renders, on a render that the core made; they need no Blender."""

from pathlib import Path

import numpy as np
import pytest

from dichromatic_addon import cli
from spectral_core import Development, illuminant, open_render, save_render
from spectral_core.image_io import read_image
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings
from spectral_core.studies import relit_by
from tests.optional import needs_matplotlib
from tests.render.render_scenes import still_life


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("kept") / "still_life.npz"
    save_render(path, render(still_life(), RenderSettings(24, 16, samples=1)))
    return path


def test_relight_writes_what_the_core_computes(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "relit.png"
    assert cli.main(["relight", str(kept), "--light", "key=FL11", "--power", "sun=0", "-o", str(out)]) == 0
    assert "24 x 16 pixels relit in" in capsys.readouterr().out
    original, _ = open_render(kept)
    spectra = original.spectra.with_light("key", illuminant=illuminant("FL11")).with_light("sun", strength=0.0)
    expected, _ = Development().picture(original.relit(spectra).tristimulus(), original.observer)
    pixels, _ = read_image(out)
    assert np.abs(pixels - expected).max() <= 0.5 / 255 + 1e-6  # rounding to 8 bits


def test_relight_keeps_and_lists(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "again.npz"
    change = ["--reflectance", "plastic:body=red", "--light", "key=3200K", "--exposure", "1", "--white", "A"]
    assert cli.main(["relight", str(kept), *change, "--adaptation", "bradford", "--list", "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "plastic:body" in printed
    assert "copper:grazing" not in printed
    again, development = open_render(out)
    assert (development.exposure, development.adaptation) == (1.0, "bradford")
    assert next(s for s in again.spectra.slots if s.component == "body").reflectance.name == "red"


def test_relight_names_what_is_wrong(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "x.png")
    for words, reason in (
        (["--light", "Key=FL11"], "no light is named 'Key'"),
        (["--light", "key=FL99"], "the library has no illuminant 'FL99', and there is no such file"),
        (["--power", "key=bright"], "must be a number, but is 'bright'"),
        (["--light", "key"], "must be NAME=VALUE, but is 'key'"),
    ):
        assert cli.main(["relight", str(kept), *words, "-o", out]) == 1
        assert reason in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_lamps_and_metamerism(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sheet, picture, figures = tmp_path / "sheet.png", tmp_path / "map.png", tmp_path / "map.exr"
    assert cli.main(["lamps", str(kept), "D65", "A", "5000D", "-o", str(sheet), "--adapt"]) == 0
    pixels, _ = read_image(sheet)
    assert pixels.shape == (2 * 16 + 8, 2 * 24 + 8, 3)
    assert cli.main(["metamerism", str(kept), "D65", "FL11", "-o", str(picture)]) == 0
    assert "Delta E 2000 between D65 and FL11: mean" in capsys.readouterr().out
    assert cli.main(["metamerism", str(kept), "D65", "FL11", "-o", str(figures)]) == 0
    values, channels = read_image(figures)
    assert channels == ("deltaE2000",)
    assert values.max() > 1.0


def test_probe_splits_a_pixel(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "pixel.csv"
    assert cli.main(["probe", str(kept), "12", "8", "-o", str(table)]) == 0
    assert "pixel (12, 8): Y" in capsys.readouterr().out
    rows = np.genfromtxt(table, delimiter=",", skip_header=1)
    assert len(rows) == 471
    np.testing.assert_allclose(rows[:, 1], rows[:, 2:].sum(axis=1), rtol=1e-6, atol=1e-12)  # nine digits
    assert cli.main(["probe", str(kept), "24", "0"]) == 1
    assert "column must lie between 0 and 23, but is 24" in capsys.readouterr().err


@needs_matplotlib
def test_probe_draws_a_pixel(kept: Path, tmp_path: Path) -> None:
    plot = tmp_path / "pixel.png"
    assert cli.main(["probe", str(kept), "12", "8", "--plot", str(plot)]) == 0
    pixels, _ = read_image(plot)
    assert pixels.shape[0] > 400
    assert pixels[..., :3].std() > 0.05  # something is drawn on the white


def test_spectral_picture(kept: Path, tmp_path: Path) -> None:
    out = tmp_path / "spectral.exr"
    assert cli.main(["relight", str(kept), "--light", "key=A", "--spectral", "-o", str(out)]) == 0
    pixels, channels = read_image(out)
    assert channels[3] == "S0.400,000000nm"
    assert pixels.shape == (16, 24, 64)
    assert relit_by(open_render(kept)[0], illuminant("A")).film.is_relightable
