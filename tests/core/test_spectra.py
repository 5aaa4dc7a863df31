"""Spectra and the formulas that make them: identity, extremes, Planck, daylight."""

from __future__ import annotations

import pickle

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.spectra import LARGEST_VALUE, REFERENCE_WAVELENGTHS_NM, Spectrum, blackbody, daylight, gaussian
from tests.tolerances import FLOAT64_ROUNDING, INTERPOLATED_POLYNOMIAL, PLANCK_ROUNDING

TINY, HUGE = 5e-324, LARGEST_VALUE
VALUES = st.one_of(st.floats(0.0, 10.0), st.sampled_from([0.0, -0.0, TINY, 1e-310, HUGE]))
SAMPLES = st.lists(st.tuples(st.floats(1.0, 3000.0), VALUES), min_size=1, max_size=12, unique_by=lambda s: s[0]).map(
    lambda pairs: np.array(sorted(pairs)).T
)


@given(SAMPLES, st.lists(st.floats(1e-3, 1e5), min_size=1, max_size=10), st.sampled_from(["linear", "lagrange"]))
def test_reading_is_finite_and_not_negative(samples, wavelengths, interpolation):
    read = Spectrum(*samples, interpolation=interpolation).at(wavelengths)
    assert read.shape == (len(wavelengths),)
    assert np.isfinite(read).all()
    assert (read >= 0.0).all()


@given(SAMPLES)
def test_linear_reading_stays_between_neighbours(samples):
    spectrum = Spectrum(*samples)
    middles = 0.5 * (samples[0][1:] + samples[0][:-1])
    read = spectrum.at(middles)
    low, high = np.minimum(samples[1][1:], samples[1][:-1]), np.maximum(samples[1][1:], samples[1][:-1])
    # Denormals are spaced by TINY; each of the two products may lose half of that.
    assert (read >= low * (1.0 - FLOAT64_ROUNDING) - 2 * TINY).all()
    assert (read <= high * (1.0 + FLOAT64_ROUNDING) + 2 * TINY).all()


def test_ends_are_held():
    spectrum = Spectrum([400.0, 500.0, 600.0], [0.2, 0.5, 0.9])
    assert spectrum.at([1.0, 399.0, 601.0, 1e6]).tolist() == [0.2, 0.2, 0.9, 0.9]
    assert spectrum.at(450.0).shape == ()
    assert spectrum.at(np.full((2, 3), 500.0)).tolist() == np.full((2, 3), 0.5).tolist()


@given(SAMPLES)
def test_equal_content_has_equal_keys(samples):
    one, two = Spectrum(*samples, name="one"), Spectrum(*samples, name="two")
    assert one == two
    assert hash(one) == hash(two)
    assert one.key == pickle.loads(pickle.dumps(two)).key
    changed = samples[1].copy()
    changed[0] = np.nextafter(changed[0], 1e9 if changed[0] < HUGE else 0.0)
    assert Spectrum(samples[0], changed) != one


def test_what_makes_spectra_equal():
    assert Spectrum.constant(0.3) == Spectrum([400.0, 700.0], [0.3, 0.3], "grey", "lagrange")
    assert Spectrum.constant(0.0) == Spectrum([500.0], [-0.0])
    assert Spectrum([400.0, 500.0], [0.1, 0.2]) != Spectrum([400.0, 500.0], [0.1, 0.2], interpolation="lagrange")
    assert Spectrum([400.0, 500.0], [0.1, 0.2]) != Spectrum([400.0, 501.0], [0.1, 0.2])
    assert Spectrum.constant(0.5) != 0.5
    assert len({Spectrum.constant(0.5, "a"), Spectrum.constant(0.5, "b")}) == 1


def test_contents_cannot_change():
    given_values = np.array([0.1, 0.2])
    spectrum = Spectrum([400.0, 500.0], given_values)
    given_values[0] = 0.9
    assert spectrum.values[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        spectrum.values[0] = 0.5
    with pytest.raises(AttributeError):
        spectrum.name = "other"


def test_scaling():
    spectrum = Spectrum([400.0, 500.0], [0.1, 0.2], "paint", "lagrange").scaled(0.5)
    assert spectrum.values.tolist() == [0.05, 0.1]
    assert (spectrum.name, spectrum.interpolation) == ("paint", "lagrange")
    assert spectrum.scaled(2.0, "bright").name == "bright"
    with pytest.raises(InvalidParameterError, match="must not be negative"):
        spectrum.scaled(-1.0)


@pytest.mark.parametrize(
    ("wavelengths", "values", "reason"),
    [
        ([400.0, np.nan], [0.1, 0.2], "wavelengths of spectrum 'x' must be finite"),
        ([400.0, 500.0], [0.1, np.nan], r"values of spectrum 'x' must be finite, but .*\[1\] is nan"),
        ([400.0, 500.0], [0.1, np.inf], "must be finite"),
        ([505.0, 500.0], [0.1, 0.2], "500.0 nm follows 505.0 nm"),
        ([500.0, 500.0], [0.1, 0.2], "increase strictly"),
        ([0.0, 500.0], [0.1, 0.2], "must be positive, but one is 0 nm"),
        ([400.0, 500.0], [0.1, -0.2], "at 500 nm it is -0.2"),
        ([400.0, 500.0], [0.1, 1.1e100], r"at most 1e\+100 in size, but at 500 nm it is 1.1e\+100"),
        ([400.0, 500.0], [0.1], "as many as its wavelengths, 2"),
        ([], [], "at least one"),
        ([[400.0]], [[0.1]], "must be a list"),
        (["blue"], [0.1], "must be numeric"),
    ],
)
def test_bad_spectra_are_refused_by_name_rule_and_value(wavelengths, values, reason):
    with pytest.raises(InvalidParameterError, match=reason):
        Spectrum(wavelengths, values, "x")


def test_signed_spectra_keep_negative_values():
    assert Spectrum([400.0, 500.0], [-0.1, 0.2], signed=True).at(400.0) == -0.1
    steep = [400.0, 410.0, 420.0, 430.0, 440.0], [0.0, 0.0, 0.0, 1.0, 1.0]
    assert Spectrum(*steep, interpolation="lagrange", signed=True).at(415.0) < 0.0
    assert Spectrum(*steep, interpolation="lagrange").at(415.0) == 0.0


def test_repr_is_short():
    assert repr(Spectrum.constant(0.25, "grey")) == "Spectrum('grey', constant 0.25)"
    assert repr(Spectrum([400.0, 500.0], [0.1, 0.2])) == "Spectrum(2 samples, 400 to 500 nm, linear)"


@pytest.mark.parametrize("temperature", [1.0, 50.0, 500.0, 2856.0, 6504.0, 1e5, 1e9, 1e300])
def test_blackbody_against_high_precision(temperature):
    values = blackbody(temperature).values
    with mpmath.workdps(50):
        c2 = mpmath.mpf("1.438776877e7")
        exact = [1 / (mpmath.mpf(w) ** 5 * mpmath.expm1(c2 / w / mpmath.mpf(temperature)))
                 for w in REFERENCE_WAVELENGTHS_NM[::47]]  # fmt: skip
        peak = max(
            1 / (mpmath.mpf(w) ** 5 * mpmath.expm1(c2 / w / mpmath.mpf(temperature))) for w in REFERENCE_WAVELENGTHS_NM
        )
        ratios = [float(value / peak) for value in exact]
    # The exponential of a logarithm has the rounding of the largest of its terms: 5 ln(830) = 34, x, and ln(x).
    x = 1.44e7 / 360.0 / temperature
    size = 34.0 + x + abs(np.log(x))
    np.testing.assert_allclose(values[::47], ratios, rtol=PLANCK_ROUNDING * size, atol=1e-307)
    assert values.max() == 1.0


def test_blackbody_refuses_the_absolute_zero():
    for temperature in (0.0, -3.0, np.nan, np.inf):
        with pytest.raises(InvalidParameterError, match="temperature_k"):
            blackbody(temperature)


@pytest.mark.parametrize("temperature", [4000.0, 5000.0, 6503.616, 7000.0, 7000.5, 12000.0, 25000.0])
def test_daylight_equals_colour_science(colour, temperature):
    xy = colour.temperature.CCT_to_xy_CIE_D(temperature)
    expected = colour.sd_CIE_illuminant_D_series(xy)
    made = daylight(temperature)
    np.testing.assert_array_equal(made.wavelengths_nm, expected.wavelengths)
    np.testing.assert_allclose(made.values, np.maximum(expected.values, 0.0), rtol=0, atol=1e2 * FLOAT64_ROUNDING)


def test_daylight_at_its_nominal_temperature_is_d65(colour):
    stored = colour.SDS_ILLUMINANTS["D65"]
    made = daylight(6500.0 * 1.4388 / 1.4380).at(stored.wavelengths)
    np.testing.assert_allclose(made, stored.values, rtol=0, atol=0.02)  # the table was made with M1, M2 unrounded


def test_daylight_refuses_what_is_no_daylight():
    for temperature in (3999.0, 25001.0, np.nan):
        with pytest.raises(InvalidParameterError, match="temperature_k"):
            daylight(temperature)


@pytest.mark.parametrize("width", [1e-3, 0.1, 20.0, 900.0])
def test_gaussian(width):
    band = gaussian(550.0, width, 0.8, 0.1)
    half = band.at([550.0 - width / 2, 550.0, 550.0 + width / 2])
    np.testing.assert_allclose(half, [0.45, 0.8, 0.45], rtol=0, atol=INTERPOLATED_POLYNOMIAL / width)
    assert band.at(550.0 + 4 * width) == 0.1
    dip = gaussian(550.0, width, 0.1, 0.8)
    assert dip.at(550.0) == pytest.approx(0.1)
    with pytest.raises(InvalidParameterError, match="full_width_nm"):
        gaussian(550.0, 0.0)
