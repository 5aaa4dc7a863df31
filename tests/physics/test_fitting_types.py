"""The recommended type: right for synthetic samples, honest where the data cannot tell, loud where they are bad."""

from __future__ import annotations

import numpy as np
import pytest

from spectral_core.errors import FittingError, InvalidParameterError
from spectral_core.fitting import (
    FitOptions,
    MeasurementGeometry,
    Measurements,
    component_weights,
    extreme_components,
    fit_lobe,
    fit_material,
    normalised,
    recommend_type,
    spectral_tests,
)
from spectral_core.library import optical_constants
from spectral_core.reflection import TypeIII, fresnel_conductor
from spectral_core.spectra import Spectrum
from tests.physics.fitting_data import (
    WAVELENGTHS,
    Truth,
    around_mirror,
    around_several_mirrors,
    departure_from_span,
    printed_dielectric,
    random_truth,
    smooth,
)
from tests.tolerances import FLOAT64_ROUNDING


def without_angles(data: Measurements) -> Measurements:
    return Measurements(data.wavelengths_nm, data.reflectances)


@pytest.mark.parametrize("noise", ["none", "proportional", "uniform"])
@pytest.mark.parametrize("material_type", ["I", "II", "III"])
def test_the_recommendation_is_right(material_type, noise) -> None:
    for seed in range(100, 105):
        recommendation = recommend_type(random_truth(material_type, seed).measure(noise, seed=seed))
        assert recommendation.material_type == material_type, (seed, recommendation.evidence)
        assert recommendation.decisive, (seed, recommendation.evidence)
        assert recommendation.evidence[-1] == f"Recommended: Type {material_type}."


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("noise", ["none", "proportional", "uniform"])
@pytest.mark.parametrize("material_type", ["I", "II", "III"])
def test_the_recommendation_is_right_over_many_seeds(material_type, noise) -> None:
    wrong = [
        seed
        for seed in range(1000, 1050)
        if recommend_type(random_truth(material_type, seed).measure(noise, seed=seed)).material_type != material_type
    ]
    assert wrong == []


@pytest.mark.parametrize("metal", ["copper", "gold", "aluminium"])
def test_real_metals_are_recognised(metal) -> None:
    # Not Eq. 13 but Fresnel's equations at every wavelength: the model is only an approximation of these data.
    geometry = around_several_mirrors()
    constants = optical_constants(metal)
    n, k = constants.at(WAVELENGTHS)
    reflectance = fresnel_conductor(np.cos(geometry.facet_incidence())[:, None], n, k)
    lobe = TypeIII(Spectrum.constant(1.0), TypeIII.from_optical_constants(constants, 0.1).mean_reflectance, 0.1)
    facets = lobe.coefficients(geometry.normal(), geometry.to_light(), geometry.to_viewer()).sum(axis=1)
    data = Measurements(WAVELENGTHS, facets[:, None] * reflectance, geometry, "beam")
    fit = fit_material(data)
    assert fit.recommendation.material_type == "III"
    # The paper's Fig. 9 shows Eq. 13 within a few thousandths of xy of Fresnel's copper: about 2 % of the reflectance.
    assert fit.fit.relative_residual < 0.02
    assert fit.material.beta == pytest.approx(0.1, rel=0.01)
    # That error of Eq. 13 moves the scale by up to 4 %; with the scale known, S_I is as good as Eq. 13 (gold: 2 %).
    np.testing.assert_allclose(fit.interface.values, fresnel_conductor(1.0, n, k), atol=0.05)
    known = fit_material(data, FitOptions(material_type="III", scale=1.0), fit.recommendation)
    np.testing.assert_allclose(known.interface.values, fresnel_conductor(1.0, n, k), atol=0.03)


def test_the_departure_from_a_constant_is_that_of_least_squares() -> None:
    for seed in range(5):
        truth = random_truth("II", seed)
        tests = spectral_tests(truth.measure())
        # Two ways to the same projection; the second solves a system with a condition number up to about 1e2.
        expected = departure_from_span(np.stack([truth.interface, truth.body]))
        assert tests.constant_deviation == pytest.approx(expected, rel=1e-9)
        assert not tests.constant_in_span
        assert np.linalg.norm(tests.constant_line) == pytest.approx(1.0, rel=FLOAT64_ROUNDING)


def test_normalised_curves_have_unit_length() -> None:
    truth = random_truth("I", 0)
    np.testing.assert_allclose(np.linalg.norm(normalised(truth.measure()), axis=1), 1.0, rtol=FLOAT64_ROUNDING)


def test_shares_of_variance_are_those_of_the_gram_matrix() -> None:
    data = random_truth("II", 3).measure("proportional")
    curves = normalised(data)
    eigenvalues = np.linalg.eigvalsh(curves @ curves.T)[::-1]
    tests = spectral_tests(data)
    assert tests.one_share == pytest.approx(eigenvalues[0] / eigenvalues.sum(), rel=FLOAT64_ROUNDING)
    assert tests.two_share == pytest.approx(eigenvalues[:2].sum() / eigenvalues.sum(), rel=FLOAT64_ROUNDING)


def test_a_slight_tint_within_the_noise_does_not_make_a_cloth() -> None:
    geometry = around_mirror()
    body = smooth(np.random.default_rng(1), 0.1, 0.8, 0.4)
    tint = 1.0 + 0.04 * np.sin((WAVELENGTHS - 400.0) / 40.0)
    assert 0.02 < departure_from_span(np.stack([tint, body])) < 0.04
    exact = Truth("II", "cosine", 15.0, tint, body, geometry, printed_dielectric(geometry, "cosine", 15.0, tint, body))
    assert recommend_type(exact.measure()).material_type == "II"
    noisy = recommend_type(exact.measure("uniform", size=0.1, seed=1))
    assert noisy.material_type == "I"
    assert noisy.tests.constant_noise > 0.02


def test_three_components_are_not_dichromatic() -> None:
    geometry = around_mirror()
    rng = np.random.default_rng(0)
    curves = np.stack([smooth(rng, 0.1, 1.0, 0.5) for _ in range(3)])
    weights = rng.uniform(0.1, 1.0, (geometry.count, 3))
    data = Measurements(WAVELENGTHS, weights @ curves, geometry, "beam")
    recommendation = recommend_type(data)
    assert recommendation.material_type is None
    assert "not dichromatic" in recommendation.evidence[-1]
    with pytest.raises(FittingError, match="none of the three types"):
        fit_material(data)
    assert fit_material(data, FitOptions(material_type="II")).material_type == "II"


def test_without_angles_the_spectra_are_tested_but_not_fitted() -> None:
    for material_type, seen in (("I", "I"), ("II", "II"), ("III", "I")):
        recommendation = recommend_type(without_angles(random_truth(material_type, 4).measure()))
        assert recommendation.material_type == seen
        assert "Without angles" in recommendation.evidence[-1]
        assert recommendation.candidates == ()
    data = without_angles(random_truth("I", 4).measure())
    with pytest.raises(FittingError, match="must state the angles of each spectrum for fitting a material"):
        fit_material(data)
    with pytest.raises(FittingError, match="angles"):
        fit_lobe(data)


def test_extreme_curves_span_the_data() -> None:
    for data in (random_truth("II", 5).measure(), without_angles(random_truth("II", 5).measure())):
        components = extreme_components(data, spectral_tests(data))
        weights, residual = component_weights(data, components)
        # Two measured curves of a two-dimensional set span it; the least squares lose their condition number, ~1e2.
        np.testing.assert_allclose(residual, 0.0, atol=1e-12)
        assert weights[components.interface_index] == pytest.approx([1.0, 0.0], abs=1e-11)
        assert weights[components.body_index] == pytest.approx([0.0, 1.0], abs=1e-11)
        assert components.body_index != components.interface_index
    with_angles = extreme_components(random_truth("II", 5).measure(), spectral_tests(random_truth("II", 5).measure()))
    assert with_angles.interface_index == int(np.argmin(random_truth("II", 5).geometry.from_mirror()))


def test_the_interface_of_plastic_without_angles_is_constant() -> None:
    data = without_angles(random_truth("I", 5).measure())
    components = extreme_components(data, spectral_tests(data))
    assert components.interface_index == -1
    assert np.ptp(components.interface) == 0.0


def test_proportional_curves_show_one_component() -> None:
    curve = smooth(np.random.default_rng(0), 0.1, 0.9, 0.4)
    data = Measurements(WAVELENGTHS, np.linspace(0.2, 1.0, 6)[:, None] * curve)
    tests = spectral_tests(data)
    assert tests.one_dimensional
    assert recommend_type(data).material_type is None
    with pytest.raises(FittingError, match="proportional"):
        extreme_components(data, tests)


def test_a_grey_plastic_is_fitted_by_its_angles() -> None:
    # One component in the spectra, two in the angles: only the lobes tell them apart.
    geometry = around_mirror()
    grey = np.full(WAVELENGTHS.size, 0.4)
    data = Measurements(WAVELENGTHS, printed_dielectric(geometry, "exponential", 8.0, 1.5, grey), geometry, "beam")
    fit = fit_material(data)
    assert fit.material_type == "I"
    assert fit.material.interface_reflectance == pytest.approx(1.5, rel=1e-6)
    np.testing.assert_allclose(fit.body.values, grey, rtol=1e-6)


# --- bad input -------------------------------------------------------------------------------------------------------


def test_fewer_than_three_spectra_are_refused() -> None:
    truth = random_truth("I", 0)
    for count in (1, 2):
        geometry = MeasurementGeometry(truth.geometry.incidence[:count], truth.geometry.viewing[:count])
        data = Measurements(WAVELENGTHS, truth.values[:count], geometry, "beam")
        with pytest.raises(FittingError, match=f"at least 3 spectra to be tested, but the measurements has {count}"):
            recommend_type(data)
        with pytest.raises(FittingError, match="at least 3 spectra"):
            fit_material(data, FitOptions(material_type="II"))


def test_all_zero_is_refused() -> None:
    with pytest.raises(FittingError, match="must not be zero everywhere"):
        Measurements(WAVELENGTHS, np.zeros((5, WAVELENGTHS.size)))


@pytest.mark.parametrize("size", [1e-10, 1e7])
def test_values_of_no_reflectance_are_refused(size) -> None:
    with pytest.raises((FittingError, InvalidParameterError), match=r"must reach 1e-09|must lie between -1e"):
        Measurements(WAVELENGTHS, np.full((5, WAVELENGTHS.size), size))


def test_whatever_is_measured_is_fitted_or_refused_by_name() -> None:
    # Rubbish of every kind: white noise, proportional curves, mostly zeros, angles all alike. Warnings are errors here.
    outcomes = {"fitted": 0, "refused": 0}
    for seed in range(16):
        rng = np.random.default_rng(seed)
        count, width = int(rng.integers(3, 9)), int(rng.integers(4, 14))
        values = [
            rng.standard_normal((count, width)),
            rng.random((count, 1)) @ rng.random((1, width)),
            rng.random((count, 2)) @ rng.random((2, width)),
            rng.random((count, width)) * (rng.random((count, width)) < 0.3),
        ][seed % 4] * 10.0 ** float(rng.integers(-6, 4))
        geometry = MeasurementGeometry.from_degrees(
            rng.choice([0.0, 45.0, 80.0], count),
            rng.choice([0.0, 45.0, -10.0, 89.0], count),
            rng.choice([0, 180], count),
        )
        options = FitOptions(material_type=str(rng.choice(["I", "II", "III"])))
        try:
            data = Measurements(400.0 + 10.0 * np.arange(width), values, geometry)
            fit = fit_material(data, options)
        except (FittingError, InvalidParameterError):
            outcomes["refused"] += 1
            continue
        outcomes["fitted"] += 1
        assert np.isfinite(fit.interface.values).all()
        assert fit.describe()
    assert min(outcomes.values()) > 0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_are_refused(bad) -> None:
    values = np.array(random_truth("I", 0).values)
    values[3, 4] = bad
    with pytest.raises(InvalidParameterError, match=r"reflectances of measurements must be finite, but .*\[3, 4\]"):
        Measurements(WAVELENGTHS, values)


def test_wavelengths_must_be_shared_and_increase() -> None:
    a, b = Spectrum(WAVELENGTHS, WAVELENGTHS / 700), Spectrum(WAVELENGTHS[1:], WAVELENGTHS[1:] / 700, "late")
    with pytest.raises(FittingError, match=r"must share their wavelengths, but spectrum 1 \(late\) has 20 from 415 nm"):
        Measurements.from_spectra([a, b])
    assert Measurements.from_spectra([a, a]).count == 2
    with pytest.raises(FittingError, match="at least one spectrum"):
        Measurements.from_spectra([])
    with pytest.raises(InvalidParameterError, match="increase strictly: 500 nm follows 500 nm"):
        Measurements([400.0, 500.0, 500.0], np.ones((3, 3)))
    with pytest.raises(InvalidParameterError, match=r"must have the shape \(spectra, 3\), but have \(3, 4\)"):
        Measurements([400.0, 500.0, 600.0], np.ones((3, 4)))
    with pytest.raises(FittingError, match="at least 3 wavelengths"):
        Measurements([400.0, 500.0], np.ones((3, 2)))


@pytest.mark.parametrize(
    ("angles", "message"),
    [
        (([91.0], [0.0]), "incidence must lie between"),
        (([-1.0], [0.0]), "incidence must be at least 0"),
        (([90.0], [0.0]), "incidence must be below 90 degrees"),
        (([0.0], [90.0]), "viewing must be below 90 degrees"),
        (([0.0, 10.0], [0.0]), "viewing must have one angle for each of 2 spectra"),
        (([0.0], [np.nan]), "viewing must be finite"),
    ],
)
def test_angles_out_of_range_are_refused(angles, message) -> None:
    with pytest.raises(InvalidParameterError, match=message):
        MeasurementGeometry.from_degrees(*angles)


def test_geometries_must_be_as_many_as_spectra() -> None:
    with pytest.raises(InvalidParameterError, match="15 geometries and 3 spectra"):
        Measurements(WAVELENGTHS, np.ones((3, WAVELENGTHS.size)), around_mirror())


def test_only_the_mirror_direction_does_not_determine_n() -> None:
    angles = np.radians(np.linspace(5.0, 70.0, 8))
    geometry = MeasurementGeometry(angles, angles)
    body = smooth(np.random.default_rng(0), 0.1, 0.9, 0.4)
    data = Measurements(WAVELENGTHS, printed_dielectric(geometry, "cosine", 10.0, 0.8, body), geometry, "beam")
    with pytest.raises(FittingError, match="n is not determined by these geometries"):
        fit_material(data, FitOptions(material_type="I"))
    with pytest.raises(FittingError, match="n cannot be found"):
        fit_lobe(data)
    held = fit_material(data, FitOptions(material_type="I", n=10.0))
    assert held.material.n == 10.0
    assert held.material.interface_reflectance == pytest.approx(0.8, rel=1e-6)


def test_spectra_drowned_in_noise_are_refused() -> None:
    rng = np.random.default_rng(0)
    wavelengths = np.arange(400.0, 701.0, 5.0)
    with pytest.raises(FittingError, match="only 0 of 6 spectra stand 10 times above their noise"):
        recommend_type(Measurements(wavelengths, rng.standard_normal((6, wavelengths.size))))


@pytest.mark.parametrize(
    "options",
    [
        {"material_type": "IV"},
        {"attenuation": "linear"},
        {"mean_reflectance": "guess"},
        {"beta": 0.0},
        {"beta_across": 0.1},
        {"confidence": 1.0},
    ],
)
def test_bad_options_are_refused(options) -> None:
    with pytest.raises(InvalidParameterError, match=next(iter(options))):
        FitOptions(**options)
