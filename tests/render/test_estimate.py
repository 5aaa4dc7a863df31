"""The estimate of error and time: against the whole picture, and its time model on times that are known."""

import numpy as np
import pytest

from spectral_core.colorimetry import observer, white_point
from spectral_core.development import Development
from spectral_core.errors import InvalidParameterError, RenderCancelledError
from spectral_core.estimate import colour_error, estimate, expected_seconds, reference_settings
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings
from spectral_core.statistics import RenderStatistics
from tests.benchmarks.cost_scene import random_scene
from tests.tolerances import FLOAT64_ROUNDING


def statistics_of(samples, rows, once, per_sample, per_row, geometry=0.25):
    seconds = {"geometry": geometry, "total": geometry + once + samples * (per_sample + rows * per_row)}
    return RenderStatistics(height=rows, samples=samples, seconds=seconds)


@pytest.mark.parametrize(("once", "per_sample", "per_row"), [(0.3, 0.02, 0.004), (0.0, 0.0, 0.01), (1.5, 0.4, 1e-5)])
@pytest.mark.parametrize("samples", [1, 4, 64])
def test_the_time_model_finds_what_the_times_were_made_of(once, per_sample, per_row, samples):
    parts = [statistics_of(n, rows, once, per_sample, per_row) for n, rows in ((1, 90), (1, 22), (2, 22))]
    expected = 0.25 + once + samples * (per_sample + 540 * per_row)
    found = expected_seconds(parts, RenderSettings(960, 540, samples=samples))
    # differences of times of about 1 s that cancel to 1e-4 s
    assert found == pytest.approx(expected, rel=1e4 * FLOAT64_ROUNDING)


def test_the_time_model_stays_sane_when_noise_turns_times_round():
    settings = RenderSettings(960, 540, samples=4)
    parts = [statistics_of(n, rows, 0.0, 0.0, 0.0) for n, rows in ((1, 90), (1, 22), (2, 22))]
    parts[1].seconds["total"] = 0.25 + 0.05  # the low picture took long, the others no time at all
    found = expected_seconds(parts, settings)
    assert 0.25 + 0.05 <= found <= 0.25 + 4 * 540 * 0.05 / 22
    flat = [statistics_of(n, 1, 0.0, 0.0, 0.1) for n in (1, 1, 2)]  # a picture so low that all parts have one row
    assert expected_seconds(flat, RenderSettings(8, 2, samples=3)) == pytest.approx(0.25 + 3 * 2 * 0.1)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_estimated_error_is_within_a_factor_of_two_of_the_true_one(seed):
    scene = random_scene(seed, balls=6, subdivisions=2)
    settings = RenderSettings(96, 72, samples=2, max_bounces=2, seed=seed)
    found = estimate(scene, settings)
    made, reference = (render(scene, s).tristimulus() for s in (settings, reference_settings(settings)))
    true = colour_error(made, reference, settings.observer)
    assert 0.5 * true.mean <= found.error.mean <= 2.0 * true.mean
    assert true.mean > 0.05
    assert found.error.percentile_95 <= found.error.largest
    assert found.seconds > 0.0
    assert "Delta E 2000" in found.describe()


def test_the_estimate_traces_a_small_part_of_the_rays(monkeypatch):
    rays = []

    def counted(scene, settings, *arguments, **named):
        made = render(scene, settings, *arguments, **named)
        rays.append(made.statistics.camera_rays)
        return made

    monkeypatch.setitem(estimate.__globals__, "render", counted)
    settings = RenderSettings(60, 480, samples=4, max_bounces=1)
    estimate(random_scene(4, balls=3, subdivisions=1), settings)
    assert sum(rays) < 0.2 * 60 * 480 * 4


@pytest.mark.parametrize("height", [1, 2, 5])
def test_low_pictures_are_estimated_too(height):
    found = estimate(random_scene(5, balls=3, subdivisions=1), RenderSettings(16, height, samples=1, max_bounces=1))
    assert np.isfinite([found.seconds, found.error.mean]).all()


def test_an_estimate_can_be_cancelled():
    asked = []

    def cancel():
        asked.append(1)
        return len(asked) > 5

    with pytest.raises(RenderCancelledError):
        estimate(random_scene(6, balls=2, subdivisions=1), RenderSettings(16, 24), cancel=cancel)
    assert len(asked) == 6


def test_colour_error_of_known_colours():
    """Greys, whose difference CIEDE2000 gives in closed form: of lightness alone, weighted by S_L."""
    development = Development()
    white = development.shown.white
    lightness = np.array([[50.0, 50.0], [50.0, 60.0]])
    changed = lightness + np.array([[0.0, 1.0], [2.0, 4.0]])
    dark, light = (((values + 16.0) / 116.0) ** 3 for values in (lightness, changed))
    mean_lightness = 0.5 * (lightness + changed)
    weight = 1.0 + 0.015 * (mean_lightness - 50.0) ** 2 / np.sqrt(20.0 + (mean_lightness - 50.0) ** 2)
    expected = (changed - lightness) / weight
    scene_white = white_point(development.adopted_white, observer("cie_1931_2"))
    found = colour_error(dark[..., None] * scene_white, light[..., None] * scene_white, "cie_1931_2", development)
    assert found.mean == pytest.approx(expected.mean(), rel=1e-9)
    assert found.largest == pytest.approx(expected.max(), rel=1e-9)
    assert found.percentile_95 == pytest.approx(np.percentile(expected, 95.0), rel=1e-9)
    assert white[1] == pytest.approx(1.0)


def test_pictures_of_two_sizes_are_not_compared():
    with pytest.raises(InvalidParameterError, match=r"one shape, but have \(2, 3\) and \(3, 3\)"):
        colour_error(np.ones((2, 3)), np.ones((3, 3)), "cie_1931_2")


def test_some_rows_of_a_picture_are_those_of_the_whole():
    """Every third row, each as thin as in the whole and at its place: the same samples, so the same colours."""
    scene = random_scene(7, balls=5, subdivisions=1)
    settings = RenderSettings(40, 30, samples=3, precision="float64", max_bounces=1)
    whole, some = render(scene, settings), render(scene, settings, rows=10)
    assert some.film.height == 10
    np.testing.assert_allclose(some.tristimulus(), whole.tristimulus()[1::3], rtol=1e-9)
    assert np.array_equal(render(scene, settings, rows=30).tristimulus(), whole.tristimulus())
    with pytest.raises(InvalidParameterError, match="rows"):
        render(scene, settings, rows=31)
