"""Sa(phi) of Eq. 13 from optical constants, from measurements, and from the normal reflectance alone."""

import mpmath as mp
import numpy as np
import pytest

from spectral_core.errors import InvalidParameterError
from spectral_core.library import metal_names, optical_constants
from spectral_core.reflection import (
    MEAN_BAND_NM,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    schlick_estimate,
)
from tests.physics import copper, exact
from tests.tolerances import FLOAT64_ROUNDING, TABLE_OF_MEAN_REFLECTANCE


def copper_constants():
    return np.interp(MEAN_BAND_NM, copper.WAVELENGTHS_NM, copper.N), np.interp(
        MEAN_BAND_NM, copper.WAVELENGTHS_NM, copper.K
    )


def exact_mean(cosine, n, k):
    with mp.workdps(40):
        return float(mp.fsum(exact.fresnel(cosine, float(a), float(b)) for a, b in zip(n, k, strict=True)) / len(n))


@pytest.mark.parametrize("degrees", [0, 5, 33.3, 60, 75, 85, 89.9])
def test_optical_mean_is_the_mean_of_fresnel(degrees):
    n, k = copper_constants()
    mean = OpticalMeanReflectance(n, k)
    truth = exact_mean(np.sin(np.pi / 2 - np.radians(degrees)), n, k)
    assert float(mean.at(np.radians(degrees))) == pytest.approx(truth, abs=TABLE_OF_MEAN_REFLECTANCE)


def test_weight_is_one_at_normal_and_proportional_to_the_cosine_at_grazing_incidence():
    mean = OpticalMeanReflectance(*copper_constants())
    assert float(mean.interface_weight(1.0)) == pytest.approx(1.0, abs=FLOAT64_ROUNDING)
    assert mean.interface_weight(0.0) == 0.0
    assert mean.at(np.pi / 2) == 1.0
    c = np.array([1e-9, 1e-8])
    weights = mean.interface_weight(c)
    assert weights[1] / weights[0] == pytest.approx(10.0, rel=1e-5)


def test_aluminium_reflects_less_at_80_degrees_and_the_weight_is_not_clamped():
    """Aluminium's constant part has a weight of about -0.65 at 80 deg (n = 0.96, k = 6.7 at 580 nm)."""
    n, k = np.full(61, 0.96), np.full(61, 6.7)
    c = np.cos(np.radians(80))
    truth = 1 - (1 - exact_mean(c, n, k)) / (1 - exact_mean(1.0, n, k))
    assert truth < -0.6
    assert 1 - float(OpticalMeanReflectance(n, k).interface_weight(c)) == pytest.approx(truth, abs=1e-9)


@pytest.mark.parametrize(("n", "k"), [(0.6, 0.0), (0.99, 0.0)])
def test_total_reflection_is_computed_not_read(n, k):
    mean = OpticalMeanReflectance(np.full(5, n), np.full(5, k))
    cosines = np.linspace(0, 1, 97)
    truth = np.array([1 - float(exact.fresnel(float(c), n, k)) for c in cosines]) / (4 * n / (1 + n) ** 2)
    np.testing.assert_allclose(mean.interface_weight(cosines), truth, atol=1e-9)


def test_perfect_mirror_keeps_its_colour():
    c = np.linspace(0, 1, 11)
    np.testing.assert_array_equal(SchlickMeanReflectance(1.0).interface_weight(c), 1.0)
    np.testing.assert_array_equal(MeasuredMeanReflectance([0.1], [1.0]).interface_weight(c), 1.0)
    np.testing.assert_array_equal(OpticalMeanReflectance([0.0], [3.0]).interface_weight(c), 1.0)


def test_schlick_needs_no_more_than_the_law():
    angles = np.linspace(0, np.pi / 2, 50)
    mean = SchlickMeanReflectance(0.7)
    np.testing.assert_allclose(mean.at(angles), schlick_estimate(0.7, np.cos(angles)), atol=FLOAT64_ROUNDING)
    c = 1e-12
    assert float(mean.interface_weight(c)) == pytest.approx(5 * c, rel=1e-11)  # 1 - (1 - c)^5 without cancellation


def test_measured_table_passes_through_its_points_and_stays_between_them():
    angles = np.radians([5, 15, 30, 45, 60, 75])
    values = np.array([0.60, 0.60, 0.595, 0.59, 0.60, 0.68])
    mean = MeasuredMeanReflectance(angles, values)
    np.testing.assert_allclose(mean.at(angles), values, atol=FLOAT64_ROUNDING)
    assert float(mean.at(0.0)) == pytest.approx(0.60, abs=FLOAT64_ROUNDING)
    fine = mean.at(np.linspace(0, np.pi / 2, 5000))
    assert fine.min() == pytest.approx(0.59, abs=1e-6)
    assert fine[-1] == 1.0
    rising = fine[np.linspace(0, 90, 5000) > 45]
    assert np.all(np.diff(rising) >= -FLOAT64_ROUNDING)


def test_dense_measurements_of_copper_give_the_optical_curve():
    optical = OpticalMeanReflectance(*copper_constants())
    angles = np.radians(np.arange(0, 90, 2.5))
    measured = MeasuredMeanReflectance(angles, optical.at(angles))
    between = np.radians(np.arange(1.25, 87, 2.5))
    np.testing.assert_allclose(measured.at(between), optical.at(between), atol=2e-3)  # 2.5 deg apart, cubic


@pytest.mark.parametrize(
    ("call", "rule"),
    [
        (lambda: SchlickMeanReflectance(1.1), "normal_mean must lie between 0 and 1"),
        (lambda: MeasuredMeanReflectance([0.1, 0.1], [0.5, 0.5]), "incidence must increase strictly"),
        (lambda: MeasuredMeanReflectance([0.1, 0.2], [0.5]), "incidence and mean must be lists of one length"),
        (lambda: MeasuredMeanReflectance([0.1, np.pi / 2], [0.5, 0.9]), "mean must be 1 at the incidence pi/2"),
        (lambda: MeasuredMeanReflectance([], []), "incidence and mean must be lists of one length"),
        (lambda: MeasuredMeanReflectance([0.1], [1.5]), "mean must lie between 0 and 1"),
        (lambda: MeasuredMeanReflectance([2.0], [0.5]), "incidence must lie between 0 and 1.57"),
        (lambda: OpticalMeanReflectance([1.0, 2.0], [1.0]), "n and k must be lists of one length"),
        (lambda: OpticalMeanReflectance([-1.0], [1.0]), "n must lie between 0"),
        (lambda: SchlickMeanReflectance(0.5).interface_weight(1.5), "cos_incidence must lie between 0 and 1"),
        (lambda: SchlickMeanReflectance(0.5).at(-0.5), "incidence must lie between 0 and 1.57"),
    ],
)
def test_invalid_parameters(call, rule):
    with pytest.raises(InvalidParameterError, match=rule):
        call()


@pytest.mark.parametrize("name", metal_names())
def test_metals_of_the_library_against_their_exact_mean(name):
    n, k = optical_constants(name).at(MEAN_BAND_NM)
    mean = OpticalMeanReflectance(n, k)
    for degrees in (0, 30, 60, 80, 88):
        truth = exact_mean(np.cos(np.radians(degrees)), n, k)
        assert float(mean.at(np.radians(degrees))) == pytest.approx(truth, abs=TABLE_OF_MEAN_REFLECTANCE)
    weight_of_white = 1 - float(mean.interface_weight(np.cos(np.radians(80))))
    assert (weight_of_white < -0.3) == name.startswith("aluminium")
