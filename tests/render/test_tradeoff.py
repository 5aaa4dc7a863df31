"""The trade of error against time: what is measured, what it says, and how it is chosen from."""

import csv
import io
from dataclasses import replace

import colour
import numpy as np
import pytest

from spectral_core.colorimetry import GRID_PRESETS, chromatic_adaptation, observer, white_point
from spectral_core.development import Development
from spectral_core.errors import InvalidParameterError, RenderCancelledError, SceneError
from spectral_core.estimate import ColourError, colour_error, reference_settings
from spectral_core.library import illuminant, optical_constants
from spectral_core.reflection.materials import TypeIII
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene
from spectral_core.tradeoff import QUALITIES, Measurement, Tradeoff, measure_tradeoff, quality_settings
from tests.render.render_scenes import still_life
from tests.tolerances import FLOAT64_ROUNDING

SMALL = RenderSettings(16, 12, samples=2, max_bounces=2)


def with_a_mirror():
    """The still life with a metal that mirrors."""
    scene = still_life()
    metal = TypeIII.from_optical_constants(optical_constants("copper"), beta=0.2, mirror=0.8)
    return replace(scene, materials=(*scene.materials[:2], metal))


@pytest.fixture(scope="module")
def measured():
    seen = []
    found = measure_tradeoff(with_a_mirror(), SMALL, progress=lambda fraction, message: seen.append(fraction))
    return found, seen


def fabricated():
    """Four ways: fast and far, slow and close, one between, and one that is worse than the one between."""
    rows = (("1", 2.0, 1.0), ("4", 0.4, 3.0), ("2", 0.9, 2.0), ("3", 0.95, 2.5))
    return Tradeoff(
        "fabricated",
        SMALL,
        tuple(Measurement("samples", v, ColourError(mean, 2 * mean, 9.0), seconds) for v, mean, seconds in rows),
        60.0,
    )


def test_every_setting_is_varied_by_itself(measured):
    found, _ = measured
    axes = [m.axis for m in found.measurements]
    assert sorted(set(axes)) == ["bounces", "precision", "resolution", "samples", "wavelengths"]
    assert [m.value for m in found.measurements if m.axis == "wavelengths"] == list(GRID_PRESETS)
    plain = measure_tradeoff(still_life(), RenderSettings(6, 4, samples=1))
    assert "bounces" not in {m.axis for m in plain.measurements}


def test_errors_are_those_of_the_renders_against_the_reference(measured):
    found, _ = measured
    scene = with_a_mirror()
    (four,) = [m for m in found.measurements if (m.axis, m.value) == ("samples", "4")]
    made = render(scene, RenderSettings(16, 12, samples=4, max_bounces=2)).tristimulus()
    reference = render(scene, reference_settings(RenderSettings(16, 12, samples=16, max_bounces=2))).tristimulus()
    assert four.error == colour_error(made, reference, SMALL.observer)
    assert four.error.mean > 0.0


def test_more_samples_wavelengths_and_bounces_are_closer(measured):
    found, _ = measured
    mean = {(m.axis, m.value): m.error.mean for m in found.measurements}
    assert mean["samples", "16"] < 0.5 * mean["samples", "1"]
    assert mean["bounces", "4"] < mean["bounces", "0"]
    assert mean["wavelengths", "standard"] < mean["wavelengths", "draft"]
    assert mean["resolution", "8x6"] < mean["resolution", "4x3"]


def test_the_pareto_set_is_what_nothing_beats(measured):
    found, _ = measured
    points = [(m.seconds, m.error.mean) for m in found.measurements]
    for m in found.measurements:
        own = (m.seconds, m.error.mean)
        beaten = any(p[0] <= own[0] and p[1] <= own[1] and p != own for p in points)
        assert m.is_pareto != beaten
    assert any(m.is_pareto for m in found.measurements)
    assert not all(m.is_pareto for m in found.measurements)


def test_progress_goes_from_zero_to_one(measured):
    found, seen = measured
    assert seen[0] == 0.0
    assert seen[-1] == 1.0
    assert seen == sorted(seen)
    assert len(seen) == len(found.measurements) + 2


@pytest.mark.parametrize("after", [0, 1, 40])
def test_cancel_stops_at_once(after):
    asked = []

    def cancel():
        asked.append(1)
        return len(asked) > after

    with pytest.raises(RenderCancelledError):
        measure_tradeoff(still_life(), RenderSettings(6, 4, samples=1), cancel=cancel)
    assert len(asked) == after + 1


def test_a_scene_without_a_camera_is_refused():
    with pytest.raises(SceneError, match="has no camera"):
        measure_tradeoff(Scene(), SMALL)


def test_the_fastest_that_is_close_enough_is_chosen():
    found = fabricated()
    assert found.choose(1.0).value == "2"
    assert found.choose(0.5).value == "4"
    assert found.choose(0.4).value == "4"
    assert found.choose(0.1) is None
    with pytest.raises(InvalidParameterError, match="target"):
        found.choose(0.0)


def test_the_advice_is_one_sentence():
    assert fabricated().advise() == (
        "For a mean Delta E 2000: for 1 take samples 2 (2.00 s); for 0.5 take samples 4 (3.00 s); "
        "for 0.1 more than was measured is needed."
    )


def test_the_file_says_what_the_table_says(measured):
    found, _ = measured
    rows = list(csv.DictReader(io.StringIO(found.csv())))
    assert len(rows) == len(found.measurements)
    for row, m in zip(rows, found.measurements, strict=True):
        assert (row["axis"], row["value"], row["pareto"]) == (m.axis, m.value, str(int(m.is_pareto)))
        numbers = [float(row[c]) for c in ("delta_e_mean", "delta_e_95", "delta_e_max", "seconds")]
        expected = [m.error.mean, m.error.percentile_95, m.error.largest, m.seconds]
        np.testing.assert_allclose(numbers, expected, rtol=5e-6)  # six digits are written
    lines = found.table().splitlines()
    assert len(lines) == len(rows) + 2
    assert sum("*" in line for line in lines[1:-1]) == sum(m.is_pareto for m in found.measurements)


@pytest.mark.parametrize("adaptation", ["none", "bradford", "cat16"])
def test_colour_error_is_that_of_colour_science(adaptation):
    rng = np.random.default_rng(4)
    one = rng.uniform(0.02, 0.8, (40, 3))
    other = one * rng.uniform(0.9, 1.1, (40, 3))
    development = Development(adopted_white=illuminant("A"), adaptation=adaptation, exposure=-0.5)
    found = colour_error(one, other, "cie_1931_2", development)
    scene_white = white_point(illuminant("A"), observer("cie_1931_2"))
    matrix = chromatic_adaptation(scene_white, development.shown.white, adaptation)
    white = scene_white if adaptation == "none" else development.shown.white
    chromaticity = white[:2] / white.sum()
    lab = [colour.XYZ_to_Lab(np.clip(2.0**-0.5 * p @ matrix.T, 0.0, white), chromaticity) for p in (one, other)]
    expected = colour.delta_E(*lab, method="CIE 2000")
    assert found.mean == pytest.approx(expected.mean(), rel=1e4 * FLOAT64_ROUNDING)
    assert found.percentile_95 == pytest.approx(np.percentile(expected, 95), rel=1e4 * FLOAT64_ROUNDING)
    assert found.largest == pytest.approx(expected.max(), rel=1e4 * FLOAT64_ROUNDING)


def test_presets_keep_the_picture_and_get_finer():
    base = RenderSettings(30, 20, seed=7, observer="cie_1964_10")
    ways = [quality_settings(name, base) for name in QUALITIES]
    assert {(w.width, w.height, w.seed, w.observer, w.grid) for w in ways} == {(30, 20, 7, "cie_1964_10", "exact")}
    assert [w.samples for w in ways] == sorted({w.samples for w in ways})
    assert [w.max_bounces for w in ways] == sorted({w.max_bounces for w in ways})
    with pytest.raises(InvalidParameterError, match="draft, standard, high, reference"):
        quality_settings("best")
