"""Fresnel's laws against complex amplitudes in mpmath, closed forms, and the estimates of Fig. 9 at their ends."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.reflection import (
    absorptance,
    cook_torrance_estimate,
    dichromatic_estimate,
    fresnel_conductor,
    fresnel_dielectric,
    hall_absorbing_estimate,
    hall_linear_estimate,
    schlick_estimate,
)
from tests.physics import exact
from tests.tolerances import FLOAT64_ROUNDING, FRESNEL_AT_CORNERS

DENORMAL = float(np.finfo(np.float64).smallest_subnormal)
COSINE = st.one_of(st.sampled_from([1.0, 1e-8, 1e-160, DENORMAL]), st.floats(DENORMAL, 1.0))
INDEX = st.one_of(st.sampled_from([0.05, 0.999, 1.0, 1.5, 20.0]), st.floats(0.01, 20.0))
EXTINCTION = st.one_of(st.sampled_from([0.0, 1e-3, 2.0, 20.0]), st.floats(1e-3, 20.0))
SHARE = st.floats(0.0, 1.0)


@given(c=COSINE, n=INDEX, k=EXTINCTION)
def test_conductor_against_complex_amplitudes(c, n, k):
    with mp.workdps(700):
        truth = float(1 - exact.fresnel(c, n, k))
    # Near the corner of total reflection the result itself is steep: 1e-16 in the cosine is 1e-8 in R.
    steep = k < 1e-2 and abs(n * n - 1 + c * c) < 1e-2
    tolerance = FRESNEL_AT_CORNERS if steep else FLOAT64_ROUNDING * 10
    assert float(absorptance(c, n, k)) == pytest.approx(truth, rel=tolerance, abs=1e-307)
    assert float(fresnel_conductor(c, n, k)) == pytest.approx(1 - truth, abs=tolerance)


@given(c=COSINE, n=st.one_of(st.sampled_from([0.05, 1.0, 1.5, 20.0]), st.floats(0.05, 20.0)))
def test_dielectric_against_complex_amplitudes(c, n):
    with mp.workdps(700):
        truth = float(exact.fresnel(c, n, 0))
    steep = abs(n * n - 1 + c * c) < 1e-2
    tolerance = FRESNEL_AT_CORNERS if steep else FLOAT64_ROUNDING
    assert float(fresnel_dielectric(c, n)) == pytest.approx(truth, abs=tolerance)
    assert float(fresnel_dielectric(c, n)) == pytest.approx(float(fresnel_conductor(c, n, 0.0)), abs=2 * tolerance)


@pytest.mark.parametrize("excess", [1e-3, 1e-6, 1e-9, 1e-12])
def test_small_reflectance_of_matched_media_keeps_its_digits(excess):
    """At normal incidence R = ((n-1)/(n+1))^2, down to 1e-25, where 1 - (1 - R) has lost all."""
    n = 1.0 + excess
    assert float(fresnel_dielectric(1.0, n)) == pytest.approx(((n - 1) / (n + 1)) ** 2, rel=FLOAT64_ROUNDING)


def test_normal_incidence_in_closed_form():
    n, k = np.meshgrid(np.linspace(0.05, 5, 40), np.linspace(0, 20, 40))
    np.testing.assert_allclose(
        fresnel_conductor(1.0, n, k), ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2), rtol=0, atol=FLOAT64_ROUNDING
    )


def test_brewster_angle_leaves_half_of_the_other_polarisation():
    n = 1.5
    c = 1 / np.sqrt(1 + n * n)  # tan = n
    s = (1 - n * n) / (1 + n * n)
    assert float(fresnel_dielectric(c, n)) == pytest.approx(s * s / 2, rel=FLOAT64_ROUNDING)


def test_total_reflection():
    n = 1 / 1.5
    critical = np.sqrt(1 - n * n)
    c = np.linspace(0, critical * (1 - 1e-9), 50)
    np.testing.assert_array_equal(fresnel_dielectric(c, n), 1.0)
    np.testing.assert_array_equal(absorptance(c, n), 0.0)
    assert fresnel_dielectric(critical * 1.01, n) < 0.9


def test_grazing_incidence_reflects_everything():
    for n, k in ((1.5, 0.0), (0.2, 3.0), (1.0, 0.0), (20.0, 20.0)):
        assert fresnel_conductor(0.0, n, k) == 1.0
    assert fresnel_dielectric(0.0, 1.5) == 1.0


def test_no_interface_reflects_nothing():
    c = np.array([1.0, 0.5, 1e-8, 1e-200, DENORMAL])
    np.testing.assert_array_equal(fresnel_conductor(c, 1.0, 0.0), 0.0)
    np.testing.assert_array_equal(fresnel_dielectric(c, 1.0), 0.0)


@given(r=SHARE, a=SHARE, b=SHARE)
def test_equation_13_is_the_printed_weighted_mean(r, a, b):
    answer = float(dichromatic_estimate(r, a, b))
    assert 0.0 <= answer <= 1.0
    if b < 1 - 1e-6:
        printed = (1 - a) / (1 - b) * r + (a - b) / (1 - b)
        assert answer == pytest.approx(np.clip(printed, 0, 1), abs=FLOAT64_ROUNDING / (1 - b))


@given(r=SHARE, a=SHARE)
def test_equation_13_at_its_ends(r, a):
    assert dichromatic_estimate(r, 0.4, 0.4) == pytest.approx(r, abs=FLOAT64_ROUNDING)  # normal incidence
    assert dichromatic_estimate(r, 1.0, 0.4) == 1.0  # grazing incidence
    assert dichromatic_estimate(r, a, 1.0) == pytest.approx(r, abs=FLOAT64_ROUNDING)  # a perfect mirror
    assert dichromatic_estimate(1.0, a, 0.4) == 1.0


@pytest.mark.parametrize(
    "estimate",
    [
        lambda r, phi: schlick_estimate(r, np.cos(phi)),
        lambda r, phi: cook_torrance_estimate(r, np.cos(phi)),
        hall_linear_estimate,
        lambda r, phi: hall_absorbing_estimate(r, 0.5 * r + 0.2, np.cos(phi)),
    ],
    ids=["schlick", "cook-torrance", "hall-linear", "hall-absorbing"],
)
def test_estimates_start_at_the_normal_reflectance_and_end_near_one(estimate):
    for r in (0.0, 0.04, 0.5, 0.98, 1.0):
        assert float(estimate(r, 0.0)) == pytest.approx(r, abs=1e-12)
        angles = np.linspace(0, np.pi / 2, 500)
        values = estimate(r, angles)
        assert np.all((values >= 0) & (values <= 1))
        if r > 0:  # Cook-Torrance: an interface of no reflectance is none, at any angle
            assert float(estimate(r, np.pi / 2 - 1e-9)) > 0.999


def test_hall_and_schlick_in_closed_form():
    assert float(hall_linear_estimate(0.4, np.radians(45))) == pytest.approx(0.7, rel=FLOAT64_ROUNDING)
    assert float(schlick_estimate(0.4, 0.5)) == pytest.approx(0.4 + 0.6 / 32, rel=FLOAT64_ROUNDING)


@pytest.mark.parametrize(
    ("call", "rule"),
    [
        (lambda: absorptance(1.5, 1.5, 0), "cos_incidence must lie between 0 and 1"),
        (lambda: absorptance(0.5, -1, 0), "n must lie between 0"),
        (lambda: absorptance(0.5, 1, -1), "k must lie between 0"),
        (lambda: absorptance(0.5, 0, 0), r"n \+ k must be at least"),
        (lambda: fresnel_conductor(np.nan, 1, 1), "cos_incidence must be finite"),
        (lambda: fresnel_dielectric(0.5, 0.0), "n must lie between 1e-06"),
        (lambda: dichromatic_estimate(1.2, 0.5, 0.5), "normal_reflectance must lie between 0 and 1"),
        (lambda: dichromatic_estimate(0.5, -0.1, 0.5), "mean_at_incidence must lie between 0 and 1"),
        (lambda: schlick_estimate(0.5, -0.1), "cos_incidence must lie between 0 and 1"),
        (lambda: cook_torrance_estimate(-0.5, 0.1), "normal_reflectance must lie between 0 and 1"),
        (lambda: hall_linear_estimate(0.5, 2.0), "incidence must lie between 0 and 1.57"),
        (lambda: hall_absorbing_estimate(0.5, 1.1, 0.5), "mean_at_normal must lie between 0 and 1"),
    ],
)
def test_invalid_parameters(call, rule):
    with pytest.raises(InvalidParameterError, match=rule):
        call()
