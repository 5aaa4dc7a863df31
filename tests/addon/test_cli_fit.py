"""``dichromatic fit``: from a data file to a material file and a plot, without Blender."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from dichromatic_addon import cli
from spectral_core.fitting import read_material_json, read_measurements
from spectral_core.reflection import OpticalMeanReflectance, TypeI, TypeII, TypeIII
from tests.optional import needs_matplotlib
from tools.make_sample_measurements import write_all

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "docs" / "data"


@pytest.mark.parametrize(
    ("sample", "kind", "low", "high"),
    [("plastic", TypeI, 10.8, 11.2), ("satin", TypeII, 9.8, 10.2), ("copper", TypeIII, 4.9, 5.1)],
)
def test_the_samples_are_fitted(tmp_path, capsys, sample, kind, low, high) -> None:
    output = tmp_path / "material.json"
    assert cli.main(["fit", str(DATA / f"{sample}.csv"), "-o", str(output), "--name", "probe"]) == 0
    record = read_material_json(output)
    assert isinstance(record.material, kind)
    assert (record.name, record.provenance.source) == ("probe", f"{sample}.csv")
    # The samples have 1 % of noise in a few hundred values; their n (or beta in degrees) is known to better than 2 %.
    shape = np.degrees(record.material.beta) if kind is TypeIII else record.material.n
    assert low < shape < high
    said = capsys.readouterr().out
    assert f"Recommended: Type {record.provenance.recommended_type}." in said
    assert record.provenance.parameters[0].describe() in said


def test_the_samples_are_what_the_script_makes(tmp_path) -> None:
    write_all(tmp_path)
    for path in sorted(DATA.glob("*.csv")):
        made, kept = read_measurements(tmp_path / path.name), read_measurements(path)
        assert "SYNTHETIC" in path.read_text(encoding="utf-8").splitlines()[0]
        # Six digits are written; a different libm may round the last of them.
        np.testing.assert_allclose(made.reflectances, kept.reflectances, rtol=2e-5)
        np.testing.assert_array_equal(made.geometry.viewing, kept.geometry.viewing)
    assert len(list(DATA.glob("*.csv"))) == 3


def test_options_reach_the_fit(tmp_path) -> None:
    output = tmp_path / "material.json"
    held = ["--beta", "5", "--scale", "1", "--mean-reflectance", "copper", "--confidence", "0.9"]
    assert cli.main(["fit", str(DATA / "copper.csv"), "-o", str(output), *held]) == 0
    record = read_material_json(output)
    assert record.material.beta == np.radians(5.0)
    assert isinstance(record.material.mean_reflectance, OpticalMeanReflectance)
    assert record.material.mean_reflectance.n.size > 1
    assert record.provenance.confidence == 0.9
    assert cli.main(["fit", str(DATA / "satin.csv"), "-o", str(output), "--type", "I", "--attenuation", "cosine"]) == 0
    assert isinstance(read_material_json(output).material, TypeI)
    assert read_material_json(output).provenance.recommended_type == "II"


@needs_matplotlib
@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_plot_is_drawn(tmp_path, suffix) -> None:
    plot = tmp_path / f"fit{suffix}"
    assert cli.main(["fit", str(DATA / "copper.csv"), "--plot", str(plot)]) == 0
    head = plot.read_bytes()[:400]
    assert head.startswith(b"\x89PNG") if suffix == ".png" else b"<svg" in plot.read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == [plot.name]


def test_without_matplotlib_the_reason_is_told(tmp_path, capsys, monkeypatch) -> None:
    for name in ("matplotlib", "matplotlib.backends", "matplotlib.backends.backend_agg", "matplotlib.figure"):
        monkeypatch.setitem(sys.modules, name, None)
    output = tmp_path / "material.json"
    arguments = ["fit", str(DATA / "plastic.csv"), "-o", str(output), "--plot", str(tmp_path / "fit.png")]
    assert cli.main(arguments) == 1
    assert "drawing a plot needs matplotlib: pip install matplotlib" in capsys.readouterr().err
    assert output.is_file()  # the material does not depend on the plot


def test_matplotlib_is_only_imported_for_a_plot(tmp_path) -> None:
    code = (
        "import sys; from dichromatic_addon import cli; "
        f"assert cli.main(['fit', {str(DATA / 'plastic.csv')!r}]) == 0; assert 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, timeout=120)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.csv"], "there is no such file"),
        (["bad.csv"], "bad.csv, line 3: value in column 3 must be a number, but is 'x'"),
        (["noangles.csv", "-o", "m.json"], "noangles.csv must state incidence and viewing angles"),
        (["plastic.csv", "-o", "nowhere/m.json"], "the folder nowhere of the output does not exist"),
        (["plastic.csv", "--plot", "fit.gif"], "plot must end in .png, .svg or .pdf, but is 'fit.gif'"),
        (["plastic.csv", "--n", "-1"], "n must lie between 0 and 1e+08"),
        (["copper.csv", "--mean-reflectance", "unobtainium"], "unobtainium"),
    ],
)
def test_failures_tell_why_and_write_nothing(tmp_path, monkeypatch, capsys, arguments, message) -> None:
    for path in DATA.glob("*.csv"):
        shutil.copy(path, tmp_path)
    (tmp_path / "bad.csv").write_text("incidence,1,2\nviewing,1,2\n400,0.5,x\n")
    (tmp_path / "noangles.csv").write_text("400,1,2,3\n500,1,3,2\n600,2,1,4\n700,1,2,5\n")
    monkeypatch.chdir(tmp_path)
    before = sorted(p.name for p in tmp_path.iterdir())
    assert cli.main(["fit", *arguments]) == 1
    assert message in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_without_angles_the_tests_are_reported(tmp_path, capsys) -> None:
    data = tmp_path / "noangles.csv"
    lines = [line for line in (DATA / "satin.csv").read_text().splitlines() if "_deg" not in line]
    data.write_text("\n".join(lines))
    assert cli.main(["fit", str(data)]) == 0
    assert "Without angles a metal (Type III) cannot be told from a plastic." in capsys.readouterr().out


def test_an_angle_out_of_range_is_named_in_degrees(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["fit", "data.csv", "--beta", "200"]) == 2
    assert "must lie between 0 and 90 degrees, but is '200'" in capsys.readouterr().err
