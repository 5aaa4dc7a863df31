"""Resampling: exactness where it can be exact, no aliasing, and the account of what was done."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.resampling import resample
from spectral_core.spectra import REFERENCE_WAVELENGTHS_NM, Spectrum, gaussian
from tests.tolerances import FLOAT64_ROUNDING, SUM_OF_HUNDREDS


def fine(step: float = 0.4) -> np.ndarray:
    return np.round(np.arange(360.0, 830.0 + step / 2, step), 6)


def test_coarse_data_are_read_at_points():
    source = Spectrum(np.arange(380.0, 781.0, 10.0), np.linspace(0.0, 1.0, 41) ** 2)
    done = resample(source, np.arange(400.0, 701.0, 5.0))
    assert done.method == "points"
    assert done.notes == ()
    np.testing.assert_array_equal(done.spectrum.values, source.at(done.spectrum.wavelengths_nm))


@given(st.floats(0.01, 2.0), st.floats(0.0, 1e3))
def test_constants_and_lines_stay_exact(step, level):
    wavelengths = np.arange(390.0, 710.0, step)
    targets = np.arange(400.0, 701.0, 5.0)
    flat = resample(Spectrum(wavelengths, np.full(wavelengths.size, level)), targets).spectrum.values
    assert (flat == level).all()
    sloped = resample(Spectrum(wavelengths, wavelengths * 1e-3), targets)
    assert sloped.method == "averages"
    np.testing.assert_allclose(sloped.spectrum.values, targets * 1e-3, rtol=SUM_OF_HUNDREDS)


@pytest.mark.parametrize("scale", [1e-300, 1e-320, 1e100])
def test_averages_keep_faint_and_strong_lamps(scale):
    line = gaussian(550.3, 0.2)
    targets = np.arange(400.0, 701.0, 5.0)
    expected = resample(line, targets).spectrum.values
    got = resample(line.scaled(scale), targets).spectrum.values
    # At 1e-320 eleven bits are left; at 1e-300 the feet of the line, 1e-11 of its peak, are denormal already.
    error = 1e-3 if scale == 1e-320 else SUM_OF_HUNDREDS
    np.testing.assert_allclose(got / scale, expected, rtol=error, atol=error)


def test_averages_equal_brute_force():
    rng = np.random.default_rng(11)
    wavelengths = np.sort(rng.uniform(395.0, 460.0, 150))
    source = Spectrum(wavelengths, rng.uniform(0.0, 1.0, 150))
    targets = np.arange(400.0, 451.0, 5.0)
    done = resample(source, targets)
    for target, value in zip(targets, done.spectrum.values, strict=True):
        x = target + (np.arange(1_000_000) + 0.5) * 1e-5 - 5.0
        weights = 1.0 - np.abs(x - target) / 5.0
        assert value == pytest.approx(np.sum(source.at(x) * weights) / weights.sum(), abs=1e-9)  # midpoint rule's error


def test_average_of_a_cubic_is_exact():
    wavelengths = fine()
    u = (wavelengths - 600.0) / 100.0
    source = Spectrum(wavelengths, 20.0 + u**3 + u**2, interpolation="lagrange")
    done = resample(source, np.arange(400.0, 801.0, 5.0))
    v = (done.spectrum.wavelengths_nm - 600.0) / 100.0
    # Under a triangle of half-width h the mean of x^2 is x^2 + h^2/6 and that of x^3 is x^3 + x h^2/2.
    h = 0.05
    expected = 20.0 + v**3 + v * h * h / 2.0 + v**2 + h * h / 6.0
    np.testing.assert_allclose(done.spectrum.values, expected, rtol=SUM_OF_HUNDREDS)


@pytest.mark.parametrize("position", np.linspace(548.0, 552.0, 9))
def test_a_line_keeps_its_energy_wherever_it_falls(position):
    width = 0.2
    energy = width * np.sqrt(np.pi / np.log(2.0)) / 2.0
    for targets in (np.arange(400.0, 701.0, 5.0), REFERENCE_WAVELENGTHS_NM):
        done = resample(gaussian(position, width), targets)
        assert done.method == "averages"
        kept = done.spectrum.values.sum() * (targets[1] - targets[0])
        assert kept == pytest.approx(energy, rel=2e-4)  # 32 straight pieces a width stand for the Gaussian


def test_ripple_finer_than_the_grid_does_not_alias():
    wavelengths = fine()
    ripple = 0.5 + 0.4 * np.cos(2.0 * np.pi * (wavelengths - 360.0) / 1.25)
    targets = np.arange(400.0, 701.0, 5.0)
    done = resample(Spectrum(wavelengths, ripple), targets)
    at_points = Spectrum(wavelengths, ripple).at(targets)
    assert np.abs(at_points - 0.5).max() > 0.39  # every fifth nanometre always meets a crest
    # The triangle lets sinc^2(4) = 0 of it pass; what is left is that of the straight lines between the samples.
    assert np.abs(done.spectrum.values - 0.5).max() < 2e-3


def test_what_lies_beyond_the_ends_is_told():
    source = Spectrum(np.arange(400.0, 701.0, 10.0), np.linspace(0.2, 0.8, 31), "lamp.csv")
    done = resample(source, REFERENCE_WAVELENGTHS_NM)
    assert (done.held_below, done.held_above) == (40, 130)
    assert "lamp.csv: data begin at 400 nm; from 360 nm on their first value 0.2 is held" in done.notes
    assert "lamp.csv: data end at 700 nm; up to 830 nm their last value 0.8 is held" in done.notes
    assert (done.spectrum.values[:40] == 0.2).all()
    assert resample(Spectrum.constant(0.4), REFERENCE_WAVELENGTHS_NM).notes == ()


def test_the_averaging_is_told():
    done = resample(Spectrum(fine(), np.ones(fine().size) + fine() * 1e-3, "scan"), np.arange(400.0, 701.0, 5.0))
    assert done.notes == ("scan: samples as close as 0.4 nm were averaged onto steps of 5 nm",)


def test_a_single_target_is_read_at_its_point():
    source = Spectrum(fine(), fine() * 1e-3)
    assert resample(source, [500.0]).spectrum.values[0] == pytest.approx(0.5, rel=FLOAT64_ROUNDING)


def test_uneven_targets_keep_straight_lines():
    targets = np.array([433.0, 457.0, 484.0, 518.0, 546.0, 578.0, 609.0, 643.0])
    done = resample(Spectrum(fine(), fine()), targets, name="nodes")
    assert done.spectrum.name == "nodes"
    np.testing.assert_allclose(done.spectrum.values, targets, rtol=SUM_OF_HUNDREDS)


@pytest.mark.parametrize("targets", [[500.0, 400.0], [], [np.nan], [0.0, 5.0], [[400.0, 500.0]]])
def test_bad_targets_are_refused(targets):
    with pytest.raises(InvalidParameterError, match="wavelengths_nm"):
        resample(Spectrum.constant(1.0), targets)
