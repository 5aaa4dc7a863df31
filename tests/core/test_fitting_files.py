"""Measured data sets and materials as files, and the quantiles behind the intervals."""

from __future__ import annotations

import json
import os

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import DichromaticError, InvalidParameterError, SpectrumFileError
from spectral_core.fitting import (
    Interval,
    MeasurementGeometry,
    Measurements,
    Provenance,
    read_material_json,
    read_measurements,
    write_material_json,
    write_measurements,
)
from spectral_core.fitting.distributions import f_quantile, regularised_incomplete_beta, student_t_quantile
from spectral_core.reflection import (
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeII,
    TypeIII,
)
from spectral_core.spectra import Spectrum
from tests.tolerances import QUANTILE

WIDE = """# a comment
reference, beam
incidence (deg), 45, 45, 30
viewing_deg, 45, 10, -5
label, peak, far, back
400, 0.5, 0.1, 0.2

500, 0.6, 0.2, 0.3
600, 0.7, 0.3, 0.4
"""

LONG = """unit;percent
wavelength_nm;incidence_deg;viewing_deg;value
400;45;45;50,0
500;45;45;60,0
600;45;45;70,0
600;45;10;30,0
500;45;10;20,0
400;45;10;10,0
400;30;-5;20,0
500;30;-5;30,0
600;30;-5;40,0
"""


@pytest.fixture
def write(tmp_path):
    def put(text: str, name: str = "data.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return put


def test_the_wide_and_the_long_layout_say_the_same(write) -> None:
    wide, long = read_measurements(write(WIDE)), read_measurements(write(LONG, "long.csv"))
    np.testing.assert_array_equal(wide.wavelengths_nm, [400.0, 500.0, 600.0])
    np.testing.assert_array_equal(wide.reflectances, [[0.5, 0.6, 0.7], [0.1, 0.2, 0.3], [0.2, 0.3, 0.4]])
    np.testing.assert_allclose(long.reflectances, wide.reflectances, rtol=1e-15)  # percent to unit: one rounding
    assert (wide.reference, long.reference) == ("beam", "diffuser")
    assert (wide.labels, wide.name) == (("peak", "far", "back"), "data")
    for data in (wide, long):
        np.testing.assert_array_equal(data.geometry.incidence, np.radians([45.0, 45.0, 30.0]))
        np.testing.assert_array_equal(data.geometry.viewing, np.radians([45.0, 10.0, -5.0]))
        np.testing.assert_array_equal(data.geometry.azimuth, 0.0)
    assert read_measurements(write(WIDE), reference="diffuser").reference == "diffuser"


@pytest.mark.parametrize("separator", ["\t", ";", " "])
def test_separators(write, separator) -> None:
    text = "\n".join(separator.join(cell.strip() for cell in line.split(",")) for line in WIDE.splitlines())
    text = text.replace(f"incidence (deg){separator}", f"incidence{separator}")
    data = read_measurements(write(text))
    np.testing.assert_array_equal(data.reflectances, read_measurements(write(WIDE, "w.csv")).reflectances)


def test_angles_may_be_missing_altogether(write) -> None:
    data = read_measurements(write("400,1,2,3\n500,1,2,4\n600,1,2,5\n"))
    assert data.geometry is None
    assert data.count == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "holds no data"),
        ("# nothing\n", "holds no data"),
        ("incidence,1,2\nviewing,1,2\n", "holds no line that begins with a wavelength"),
        (WIDE.replace("viewing_deg, 45, 10, -5\n", ""), "states incidence but not viewing"),
        (WIDE.replace("0.6, 0.2, 0.3", "0.6, 0.2"), "line 8: there must be 3 columns of data, but there are 2"),
        (WIDE.replace("0.6, 0.2", "0.6, x"), "line 8: value in column 3 must be a number, but is 'x'"),
        (WIDE.replace("0.6, 0.2", "0.6, nan"), "line 8: value in column 3 must be finite, but is 'nan'"),
        (WIDE.replace("500,", "400,"), "line 8: wavelengths must increase, but 400 nm follows 400 nm"),
        (WIDE.replace("500,", "azimuth,"), "line 8: azimuth must stand before the first wavelength"),
        (WIDE.replace("label", "incidence"), "line 5: incidence is stated twice"),
        (WIDE.replace("reference, beam", "reference, sun"), "line 2: reference must be one of diffuser, beam"),
        (WIDE.replace("reference, beam", "unit, lux"), "line 2: unit must be one of unit, percent, but is 'lux'"),
        (WIDE.replace("45, 45, 30", "45, 95, 30"), "incidence must lie between"),
        (WIDE.replace("600, 0.7, 0.3, 0.4\n", ""), "must have at least 3 wavelengths"),
        (
            LONG.replace("600;30;-5;40,0\n", ""),
            "share their wavelengths, but the one at incidence 30, viewing -5 has 2",
        ),
        (LONG.replace("600;45;10;30,0", "500;45;10;30,0"), "line 7: this geometry has two values at 500 nm"),
        (LONG.replace(";viewing_deg", ";tilt"), "the heading has an unknown column 'tilt'"),
        (LONG.replace("incidence_deg;viewing_deg", "viewing_deg"), "must name the column incidence once, but has 0"),
        (LONG.replace("400;45;10;10,0", "400;45;10"), "line 8: there must be 4 cells, but there are 3"),
        ("wavelength_nm,incidence,viewing,value\n", "holds no line of data"),
    ],
)
def test_bad_files_are_refused_with_the_reason(write, text, message) -> None:
    with pytest.raises(SpectrumFileError) as caught:
        read_measurements(write(text))
    assert message in str(caught.value)
    assert "data.csv" in str(caught.value)


def test_files_that_cannot_be_read_are_named(tmp_path) -> None:
    with pytest.raises(SpectrumFileError, match="there is no such file"):
        read_measurements(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(SpectrumFileError, match="cannot be read as text"):
        read_measurements(tmp_path / "picture.csv")


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=12, max_size=12).filter(lambda v: max(map(abs, v)) > 1e-9),
    st.lists(st.floats(0.0, 89.0), min_size=4, max_size=4),
    st.lists(st.floats(-89.0, 89.0), min_size=4, max_size=4),
    st.booleans(),
)
def test_writing_and_reading_keep_every_value(tmp_path_factory, values, incidence, viewing, diffuser) -> None:
    path = tmp_path_factory.mktemp("data") / "set.csv"
    geometry = MeasurementGeometry.from_degrees(incidence, viewing, rotation=[0.0, 30.0, 60.0, -90.0])
    before = Measurements(
        [400.0, 512.25, 700.0],
        np.reshape(values, (4, 3)),
        geometry,
        "diffuser" if diffuser else "beam",
        "set",
        ("a", "b", "c", "d"),
    )
    write_measurements(path, before, "made up\nfor a test")
    after = read_measurements(path)
    np.testing.assert_array_equal(after.reflectances, before.reflectances)
    np.testing.assert_array_equal(after.wavelengths_nm, before.wavelengths_nm)
    # Angles are written in degrees to 9 places: 5e-10 degrees are 9e-12 rad.
    for name in ("incidence", "viewing", "azimuth", "rotation"):
        np.testing.assert_allclose(getattr(after.geometry, name), getattr(geometry, name), atol=1e-11)
    assert (after.reference, after.labels, after.name) == (before.reference, before.labels, "set")


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch) -> None:
    path = tmp_path / "material.json"
    path.write_text("old")

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(DichromaticError, match="disk full"):  # the error of every file that is written
        write_material_json(path, TypeI(Spectrum.constant(0.5)))
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["material.json"]


# --- material.json ---------------------------------------------------------------------------------------------------

RED = Spectrum([400.0, 550.0, 700.0], [0.1, 1.0 / 3.0, 0.7], "red")
SHEEN = Spectrum([380.0, 780.0], [0.5, 2.0], "sheen", "lagrange")
MATERIALS = [
    TypeI(RED, 5.0, "cosine", 11.0),
    TypeI(RED, 0.5, "gaussian", 1.0 / 3.0, energy_conserving=True),
    TypeII(RED, SHEEN, "exponential", 10.0),
    TypeIII(RED, SchlickMeanReflectance(0.4), np.radians(5.0)),
    TypeIII(RED, MeasuredMeanReflectance([0.1, 0.7, 1.2], [0.4, 0.5, 0.8]), 0.1, 0.2, "surface"),
    TypeIII(RED, OpticalMeanReflectance([0.2, 0.3], [3.0, 3.1]), 0.1, 0.05, energy_conserving=True),
]


@pytest.mark.parametrize("material", MATERIALS, ids=lambda m: type(m).__name__)
def test_a_material_is_rebuilt_bit_by_bit(tmp_path, material) -> None:
    origin = Provenance(
        "data.csv",
        "I",
        ("two components",),
        ("ρ held",),
        (Interval("n", 10.0, 9.0, 11.5), Interval("beta", 5.0, 4.0, 6.0, "deg")),
        0.95,
        0.0123,
    )
    path = tmp_path / "material.json"
    write_material_json(path, material, "Rot Nr. 5", origin)
    record = read_material_json(path)
    assert type(record.material) is type(material)
    assert (record.name, record.provenance) == ("Rot Nr. 5", origin)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(2, 50, 3))
    directions[..., 2] = np.abs(directions[..., 2]) + 0.1
    light, viewer = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    arguments = ([0.0, 0.0, 1.0], light, viewer, np.arange(380.0, 781.0, 20.0), [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(record.material.radiance_factor(*arguments), material.radiance_factor(*arguments))
    assert [s.name for s in record.material.reflectances] == [s.name for s in material.reflectances]
    assert [s.key for s in record.material.reflectances] == [s.key for s in material.reflectances]
    assert record.material.energy_conserving == material.energy_conserving


def test_the_file_states_its_layout_and_version(tmp_path) -> None:
    path = tmp_path / "m.json"
    write_material_json(path, MATERIALS[0])
    content = json.loads(path.read_text(encoding="utf-8"))
    assert (content["format"], content["version"]) == ("dichromatic-material", 1)
    assert content["material"]["n"] == 11.0


def put(content, *path, value):
    *parents, last = path
    for key in parents:
        content = content[key]
    if value is ...:
        del content[last]
    else:
        content[last] = value


@pytest.mark.parametrize(
    ("material", "path", "value", "message"),
    [
        (0, ("format",), "other", "format must be 'dichromatic-material', but is 'other'"),
        (0, ("version",), 2, "version must lie between 1 and 1, but is 2: a newer program wrote it"),
        (0, ("version",), True, "version must be a finite number, but is True"),
        (0, ("name",), 5, "name must be text, but is 5"),
        (0, ("material",), [], "material must be an object, but is list"),
        (0, ("material", "n"), ..., "material.n is missing"),
        (0, ("material", "n"), -1.0, "n must lie between 0"),
        (0, ("material", "n"), "11", "material.n must be a finite number, but is '11'"),
        (0, ("material", "type"), "IV", "material.type must be I, II or III, but is 'IV'"),
        (0, ("material", "energy_conserving"), 1, "material.energy_conserving must be true or false, but is 1"),
        (0, ("material", "body_reflectance", "values"), [0.1, 0.2], "must be as many as its wavelengths"),
        (0, ("material", "body_reflectance", "values"), 3, "body_reflectance.values must be a list of finite numbers"),
        (2, ("material", "interface_reflectance"), 1.0, "material.interface_reflectance must be an object"),
        (3, ("material", "mean_reflectance", "kind"), "x", "mean_reflectance.kind must be schlick, table or optical"),
        (3, ("material", "beta_rad"), 2.0, "beta must lie between 0 and 1.5708"),
        (3, ("provenance", "parameters"), {}, "provenance.parameters must be a list, but is dict"),
        (3, ("provenance", "notes"), [1], "provenance.notes must be a list of texts"),
    ],
)
def test_bad_material_files_are_refused_with_the_key(tmp_path, material, path, value, message) -> None:
    file = tmp_path / "m.json"
    write_material_json(file, MATERIALS[material])
    content = json.loads(file.read_text(encoding="utf-8"))
    put(content, *path, value=value)
    file.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(SpectrumFileError) as caught:
        read_material_json(file)
    assert message in str(caught.value)
    assert str(caught.value).startswith("m.json: ")


def test_no_json_and_no_file_are_refused(tmp_path) -> None:
    with pytest.raises(SpectrumFileError, match="there is no such file"):
        read_material_json(tmp_path / "none.json")
    (tmp_path / "m.json").write_text("{ not json")
    with pytest.raises(SpectrumFileError, match="cannot be read as JSON"):
        read_material_json(tmp_path / "m.json")
    (tmp_path / "m.json").write_text("[1, 2]")
    with pytest.raises(SpectrumFileError, match="the file must be an object, but is list"):
        read_material_json(tmp_path / "m.json")
    with pytest.raises(InvalidParameterError, match="material must be of Type I, II or III, but is str"):
        write_material_json(tmp_path / "m.json", "plastic")


# --- quantiles -------------------------------------------------------------------------------------------------------


@given(st.floats(0.5, 500.0), st.floats(0.5, 500.0), st.floats(0.01, 0.99))
def test_the_incomplete_beta_function(a, b, x) -> None:
    with mp.workdps(40):
        exact = mp.betainc(a, b, 0, x, regularized=True)
    assert regularised_incomplete_beta(a, b, x) == pytest.approx(float(exact), abs=QUANTILE)
    assert regularised_incomplete_beta(a, b, 0.0) == 0.0
    assert regularised_incomplete_beta(a, b, 1.0) == 1.0


@pytest.mark.parametrize("probability", [0.5, 0.9, 0.975, 0.9995])
@pytest.mark.parametrize("freedom", [1, 2, 7, 60, 5000])
def test_student_quantiles(probability, freedom) -> None:
    quantile = student_t_quantile(probability, freedom)
    with mp.workdps(30):  # the share below t, from the definition
        nu, t = mp.mpf(freedom), mp.mpf(quantile)
        density = mp.gamma((nu + 1) / 2) / mp.gamma(nu / 2) / mp.sqrt(nu * mp.pi)
        share = mp.mpf(1) / 2 + density * t * mp.hyp2f1(0.5, (nu + 1) / 2, 1.5, -t * t / nu)
    assert float(share) == pytest.approx(probability, abs=QUANTILE)
    assert student_t_quantile(1.0 - probability, freedom) == pytest.approx(-quantile, rel=QUANTILE, abs=QUANTILE)


@pytest.mark.parametrize("probability", [0.05, 0.5, 0.95, 0.9999])
@pytest.mark.parametrize(("numerator", "denominator"), [(1, 5), (19, 40), (59, 800), (300, 20000)])
def test_fisher_quantiles(probability, numerator, denominator) -> None:
    quantile = f_quantile(probability, numerator, denominator)
    with mp.workdps(30):
        x = numerator * mp.mpf(quantile) / (numerator * mp.mpf(quantile) + denominator)
        share = mp.betainc(mp.mpf(numerator) / 2, mp.mpf(denominator) / 2, 0, x, regularized=True)
    assert float(share) == pytest.approx(probability, abs=QUANTILE)


def test_quantiles_refuse_what_has_none() -> None:
    with pytest.raises(InvalidParameterError, match="probability"):
        student_t_quantile(1.0, 5)
    with pytest.raises(InvalidParameterError, match="degrees_of_freedom"):
        student_t_quantile(0.9, 0)
    with pytest.raises(InvalidParameterError, match="x must lie between"):
        regularised_incomplete_beta(1.0, 1.0, 1.5)
    with pytest.raises(InvalidParameterError, match="interval of n must hold its value"):
        Interval("n", 1.0, 2.0, 3.0)
