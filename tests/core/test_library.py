"""The library: every name works, every table has a source, and the tables are those of their sources."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import spectral_core
from spectral_core.colorimetry import observer, tristimulus_weights, uv, wavelength_grid, white_point
from spectral_core.errors import InvalidParameterError
from spectral_core.library import (
    illuminant,
    illuminant_names,
    metal_names,
    optical_constants,
    reflectance,
    reflectance_names,
    source_of,
)
from spectral_core.optical_constants import OpticalConstants
from spectral_core.spectra import REFERENCE_WAVELENGTHS_NM, Spectrum, blackbody
from spectral_core.tables import table, table_names

DATA = Path(spectral_core.__file__).parent / "data"
REQUIRED_LAMPS = (
    *("A", "C", "D50", "D55", "D65", "D75", "E", "projector-halogen"),
    *(f"FL{i}" for i in range(1, 13)),
    *(f"FL3.{i}" for i in range(1, 16)),
    *(f"HP{i}" for i in range(1, 6)),
    *("LED-B1", "LED-B2", "LED-B3", "LED-B4", "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"),
)
METALS = ("copper", "brass-70-30", "brass-85-15", "brass-90-10", "gold", "silver", "aluminium")


def test_names_are_complete_and_without_repetition():
    assert set(REQUIRED_LAMPS) <= set(illuminant_names())
    assert set(METALS) <= set(metal_names())
    names = illuminant_names() + reflectance_names() + metal_names()
    assert len(names) == len(set(names))
    assert sum(source_of(name).startswith("synthetic") for name in reflectance_names()) >= 20
    wanted = {"plastic blue", "plastic red", "satin green body", "satin green interface", "dark skin"}
    assert wanted <= set(reflectance_names())


def test_every_spectrum_has_a_source_and_is_sound():
    for name in illuminant_names():
        assert illuminant(name).values.min() >= 0.0
        assert len(source_of(name)) > 8
    for name in reflectance_names():
        values = reflectance(name).at(REFERENCE_WAVELENGTHS_NM)
        assert values.min() > 0.0
        assert values.max() < 1.0
        assert reflectance(name).name == name
        assert len(source_of(name)) > 8
    for name in metal_names():
        constants = optical_constants(name)
        assert constants.source
        assert constants.wavelengths_nm[0] <= 360.0
        assert constants.wavelengths_nm[-1] >= 830.0  # the whole range of the observers, nothing held


def test_every_stored_table_has_its_provenance():
    for archive in DATA.glob("*.npz"):
        entries = json.loads(archive.with_suffix(".json").read_text(encoding="utf-8"))["tables"]
        with np.load(archive) as stored:
            assert set(stored.files) == set(entries)
            for name in stored.files:
                assert entries[name]["source"]
                assert entries[name]["range_nm"] == [stored[name][0, 0], stored[name][0, -1]]
    assert sum(path.stat().st_size for path in DATA.glob("*.npz")) < 200_000


def test_stored_lamps_are_those_of_colour_science(colour):
    for full in table_names("illuminant"):
        name = full.partition("/")[2]
        if name in colour.SDS_ILLUMINANTS:
            expected = colour.SDS_ILLUMINANTS[name]
            wavelengths, values = table(full)
            shared = wavelengths <= expected.wavelengths[-1]
            np.testing.assert_array_equal(wavelengths[shared], expected.wavelengths)
            np.testing.assert_array_equal(values[shared], expected.values)
    for name, expected in colour.SDS_COLOURCHECKERS["ColorChecker N Ohta"].items():
        np.testing.assert_array_equal(reflectance(name.partition(" (")[0]).values, expected.values)


def test_daylight_is_continued_by_its_formula(colour):
    for name, temperature in {"D50": 5000.0, "D55": 5500.0, "D65": 6500.0, "D75": 7500.0}.items():
        wavelengths, values = table(f"illuminant/{name}")
        assert wavelengths[-1] == 830.0
        formula = colour.sd_CIE_illuminant_D_series(colour.temperature.CCT_to_xy_CIE_D(temperature * 1.4388 / 1.4380))
        # The tables were made with less rounding of M1 and M2 than the formula now has.
        expected = np.interp(wavelengths, formula.wavelengths, formula.values)
        np.testing.assert_allclose(values, expected, rtol=0, atol=0.06)


def test_illuminant_a_by_formula_equals_its_table(colour):
    stored = colour.SDS_ILLUMINANTS["A"]
    np.testing.assert_allclose(illuminant("A").at(stored.wavelengths), stored.values, rtol=5e-6)  # six digits
    assert illuminant("E").is_constant


def test_projector_lamp_is_continued_smoothly():
    for name, stored in {"projector-halogen": "iso7589/studio-tungsten", "photoflood": "iso7589/photoflood"}.items():
        lamp = illuminant(name)
        wavelengths, values = table(stored)
        np.testing.assert_array_equal(lamp.at(wavelengths), values)
        assert lamp.wavelengths_nm[-1] == 830.0
        steps = np.diff(lamp.at(np.arange(600.0, 831.0, 10.0)))
        assert (steps > 0.0).all()  # tungsten rises to beyond 900 nm
        assert np.abs(np.diff(steps)).max() < 2.5  # the table is rounded to whole numbers; the seam is no worse
        # It looks like a tungsten lamp: within 0.003 of the Planckian locus in u', v'.
        white = uv(white_point(lamp, observer("cie_1931_2")))
        locus = np.array([
            uv(white_point(blackbody(t), observer("cie_1931_2"))) for t in np.arange(2600.0, 3800.0, 20.0)
        ])  # fmt: skip
        assert np.hypot(*(locus - white).T).min() < 0.003


def test_unknown_names_are_answered_with_near_ones():
    with pytest.raises(InvalidParameterError, match=r"near: .*D65"):
        illuminant("D66")
    with pytest.raises(InvalidParameterError, match=r"near: .*plastic blue"):
        reflectance("plastik blue")
    with pytest.raises(InvalidParameterError, match="near: copper"):
        optical_constants("coper")
    with pytest.raises(InvalidParameterError, match="name must be one of"):
        source_of("nothing like it")
    with pytest.raises(InvalidParameterError, match="table must be one of group 'illuminant'"):
        table("illuminant/D66")


def normal_reflectance(constants: OpticalConstants) -> np.ndarray:
    n, k = constants.at(REFERENCE_WAVELENGTHS_NM)
    return ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)


# Luminous reflectance at normal incidence under D65 (handbook figures for evaporated films, to a few percent), and on
# which side of white the colour lies.
@pytest.mark.parametrize(
    ("metal", "low", "high", "warm"),
    [("copper", 0.62, 0.78, True), ("gold", 0.72, 0.84, True), ("silver", 0.95, 1.0, True),
     ("aluminium", 0.88, 0.94, False), ("brass-70-30", 0.70, 0.85, True)],
)  # fmt: skip
def test_metals_look_like_themselves(metal, low, high, warm):
    weights = tristimulus_weights(illuminant("D65"), observer("cie_1931_2"), wavelength_grid("exact"))
    xyz = normal_reflectance(optical_constants(metal)) @ weights
    assert low < xyz[1] < high
    assert (xyz[2] / xyz[1] < weights[:, 2].sum()) == warm


def test_brass_turns_red_with_copper():
    weights = tristimulus_weights(illuminant("D65"), observer("cie_1931_2"), wavelength_grid("exact"))
    a_to_b = []
    for name in ("brass-70-30", "brass-85-15", "brass-90-10", "copper-querry"):
        xyz = normal_reflectance(optical_constants(name)) @ weights
        a_to_b.append(xyz[0] / xyz[1])
    assert a_to_b[0] == min(a_to_b)
    assert a_to_b[-1] == max(a_to_b)


def test_optical_constants_are_checked():
    good = OpticalConstants([400.0, 500.0], [1.0, 1.5], [2.0, 3.0], "glass")
    assert [float(x) for x in good.at(450.0)] == [1.25, 2.5]
    for arguments, reason in (
        (([400.0, 500.0], [1.0, 0.0], [0.0, 0.0]), "n of 'x' must be positive"),
        (([400.0, 500.0], [1.0, 1.0], [0.0, -1.0]), "k of 'x' must be at least 0"),
        (([500.0, 400.0], [1.0, 1.0], [0.0, 0.0]), "400.0 nm follows 500.0 nm"),
        (([400.0, 500.0], [1.0], [0.0, 0.0]), "lists of one length"),
        (([400.0, np.nan], [1.0, 1.0], [0.0, 0.0]), "finite"),
    ):
        with pytest.raises(InvalidParameterError, match=reason):
            OpticalConstants(*arguments, name="x")


def test_spectra_of_the_library_are_shared():
    assert illuminant("D65") is illuminant("D65")
    assert isinstance(reflectance("plastic blue"), Spectrum)
