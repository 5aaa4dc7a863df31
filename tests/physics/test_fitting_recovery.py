"""Fits find what synthetic samples were made of, and say rightly how well.

The samples come from the equations as printed, in code of the tests; the core's own coefficients are held to them too.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from spectral_core.errors import FittingError
from spectral_core.fitting import FitOptions, MeasurementGeometry, Measurements, fit_lobe, fit_material, recommend_type
from spectral_core.fitting.lobes import BodyAndLobe
from spectral_core.fitting.metal_lobe import FixedWeight, MetalLobe
from spectral_core.reflection import (
    ATTENUATIONS,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeIII,
)
from spectral_core.spectra import Spectrum
from tests.physics.fitting_data import (
    WAVELENGTHS,
    Truth,
    around_mirror,
    around_several_mirrors,
    printed_dielectric,
    printed_metal,
    random_truth,
    schlick_weight,
    smooth,
)
from tests.tolerances import FIT_OF_EXACT_DATA, FLOAT64_ROUNDING, PRINTED_ANGLES

DRAWS = 200


def fitted_shape(fit) -> float:
    return fit.material.beta if isinstance(fit.material, TypeIII) else fit.material.n


def binomial_ends(draws: int, probability: float, miss: float = 1e-4) -> tuple[int, int]:
    """Counts that a binomial variable leaves on either side with the probability `miss`."""
    total, low, high = 0.0, None, draws
    for k in range(draws + 1):
        total += math.comb(draws, k) * probability**k * (1.0 - probability) ** (draws - k)
        if low is None and total > miss:
            low = k
        if total > 1.0 - miss:
            high = k
            break
    return low, high


# --- the coefficients that are fitted are those that are rendered ----------------------------------------------------


@pytest.mark.parametrize("kind", ATTENUATIONS)
@pytest.mark.parametrize("reference", ["beam", "diffuser"])
def test_the_plastic_that_is_fitted_is_the_plastic_that_is_rendered(kind, reference) -> None:
    geometry = around_mirror(40.0)
    body = Spectrum(WAVELENGTHS, np.full(WAVELENGTHS.size, 0.5))
    material = TypeI(body, 1.0, kind, 12.5)
    rendered = material.coefficients(geometry.normal(), geometry.to_light(), geometry.to_viewer())
    if reference == "diffuser":
        rendered = rendered / np.cos(geometry.incidence)[:, None]
    data = Measurements(WAVELENGTHS, np.ones((geometry.count, WAVELENGTHS.size)), geometry, reference)
    terms = BodyAndLobe(data, kind, constant_interface=False)(np.log([12.5]))
    np.testing.assert_allclose(terms.free, rendered, rtol=FLOAT64_ROUNDING, atol=FLOAT64_ROUNDING)


@pytest.mark.parametrize("beta_across", [None, 0.17])
def test_the_metal_that_is_fitted_is_the_metal_that_is_rendered(beta_across) -> None:
    geometry = around_several_mirrors(turned=True)
    mean = SchlickMeanReflectance(0.6)
    material = TypeIII(Spectrum.constant(0.6), mean, 0.08, beta_across)
    rendered = material.coefficients(geometry.normal(), geometry.to_light(), geometry.to_viewer(), geometry.tangent())
    data = Measurements(WAVELENGTHS, np.ones((geometry.count, WAVELENGTHS.size)), geometry, "beam")
    weight = 1.0 - mean.interface_weight(np.cos(geometry.facet_incidence()))
    model = MetalLobe(data, FixedWeight(weight), anisotropic=beta_across is not None)
    terms = model(np.log([0.08] if beta_across is None else [0.08, beta_across]))
    np.testing.assert_allclose(terms.free[:, 0], rendered[:, 0], rtol=PRINTED_ANGLES, atol=FLOAT64_ROUNDING)
    np.testing.assert_allclose(terms.flat, rendered[:, 1], rtol=PRINTED_ANGLES, atol=FLOAT64_ROUNDING)


@pytest.mark.parametrize("kind", ATTENUATIONS)
def test_slopes_are_derivatives(kind) -> None:
    truth = random_truth("I", 1)
    plastic = BodyAndLobe(truth.measure(), kind, constant_interface=False)
    metal = MetalLobe(random_truth("III", 1).measure(), FixedWeight(schlick_weight(around_several_mirrors())))
    turned = MetalLobe(
        Measurements(WAVELENGTHS, np.ones((50, WAVELENGTHS.size)), around_several_mirrors(True)),
        FixedWeight(schlick_weight(around_several_mirrors(True))),
        anisotropic=True,
    )
    for model, point in ((plastic, [2.3]), (metal, [-2.0]), (turned, [-2.0, -1.6])):
        for index in range(len(point)):
            step = np.zeros(len(point))
            step[index] = 1e-5
            numeric = (model(point + step).free - model(point - step).free) / 2e-5
            # Central differences: the third derivative of order 1 times 1e-10, and rounding of 1e-16 / 1e-5.
            np.testing.assert_allclose(model(np.array(point)).free_slopes[index], numeric, atol=1e-8)


# --- without noise: to 1e-6 ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("material_type", ["I", "II", "III"])
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("reference", ["beam", "diffuser"])
def test_exact_data_give_back_the_sample(material_type, seed, reference) -> None:
    truth = random_truth(material_type, seed)
    fit = fit_material(truth.measure(reference=reference))
    assert fit.material_type == material_type
    assert fitted_shape(fit) == pytest.approx(truth.shape, rel=FIT_OF_EXACT_DATA)
    np.testing.assert_allclose(fit.interface.values, truth.interface, rtol=FIT_OF_EXACT_DATA)
    if material_type != "III":
        assert fit.material.attenuation == truth.kind
        np.testing.assert_allclose(fit.body.values, truth.body, rtol=FIT_OF_EXACT_DATA)
    assert fit.fit.relative_residual < FIT_OF_EXACT_DATA
    geometry = truth.geometry
    rendered = fit.material.radiance_factor(
        geometry.normal(), geometry.to_light(), geometry.to_viewer(), WAVELENGTHS, geometry.tangent()
    )
    np.testing.assert_allclose(rendered, truth.values, rtol=1e-5, atol=FIT_OF_EXACT_DATA * truth.values.max())


def test_a_brushed_metal_gives_back_both_half_value_angles() -> None:
    geometry = around_several_mirrors(turned=True)
    reflectance = smooth(np.random.default_rng(3), 0.4, 0.95, 0.3)
    beta, across = np.radians([4.0, 9.0])
    values = printed_metal(geometry, beta, across, reflectance, schlick_weight(geometry))
    fit = fit_material(Measurements(WAVELENGTHS, values, geometry, "beam"))
    assert fit.material.beta == pytest.approx(beta, rel=FIT_OF_EXACT_DATA)
    assert fit.material.beta_across == pytest.approx(across, rel=FIT_OF_EXACT_DATA)
    assert [p.name for p in fit.parameters] == ["beta", "beta_across", "scale"]


def test_an_isotropic_metal_is_not_called_brushed() -> None:
    geometry = around_several_mirrors(turned=True)
    reflectance = smooth(np.random.default_rng(4), 0.4, 0.95, 0.3)
    values = printed_metal(geometry, 0.1, 0.1, reflectance, schlick_weight(geometry))
    noisy = values * (1.0 + 0.01 * np.random.default_rng(5).standard_normal(values.shape))
    for data in (values, noisy):
        assert fit_material(Measurements(WAVELENGTHS, data, geometry, "beam")).material.beta_across is None


@pytest.mark.parametrize(("n", "k"), [(0.05, 3.0), (0.9, 2.6), (1.2, 7.0), (2.9, 3.1)])
def test_the_mean_reflectance_of_a_metal_is_found(n, k) -> None:
    geometry = around_several_mirrors()
    reflectance = smooth(np.random.default_rng(8), 0.4, 0.95, 0.3)
    mean = OpticalMeanReflectance(np.array([n]), np.array([k]))
    weight = 1.0 - mean.interface_weight(np.cos(geometry.facet_incidence()))
    values = 2.5 * printed_metal(geometry, 0.1, 0.1, reflectance, weight)
    fit = fit_material(Measurements(WAVELENGTHS, values, geometry, "beam"))
    # The weight is read from a table in cos(phi) that is exact to 1e-9; n and k follow from its curvature.
    np.testing.assert_allclose(
        [fit.material.mean_reflectance.n[0], fit.material.mean_reflectance.k[0]], [n, k], rtol=1e-4
    )
    np.testing.assert_allclose(fit.interface.values, reflectance, rtol=FIT_OF_EXACT_DATA)
    assert next(p.value for p in fit.parameters if p.name == "scale") == pytest.approx(2.5, rel=FIT_OF_EXACT_DATA)


def test_a_mirror_series_gives_back_a_table_of_the_mean_reflectance() -> None:
    # The paper's Fig. 4: the viewer always in the mirror direction, incidence 5 to 75 degrees; D cannot show.
    angles = np.radians(np.arange(5.0, 76.0, 5.0))
    geometry = MeasurementGeometry(angles, angles)
    reflectance = smooth(np.random.default_rng(9), 0.4, 0.95, 0.3)
    at_normal = float(np.interp(np.arange(400.0, 701.0, 5.0), WAVELENGTHS, reflectance).mean())
    weight = np.concatenate([[0.0], 0.3 * np.linspace(0.02, 1.0, 14) ** 3 - 0.01])
    mean = 1.0 - (1.0 - weight) * (1.0 - at_normal)
    values = printed_metal(geometry, 0.1, 0.1, reflectance, weight)
    options = FitOptions(material_type="III", mean_reflectance="table", beta=0.1)
    fit = fit_material(Measurements(WAVELENGTHS, values, geometry, "beam"), options)
    table = fit.material.mean_reflectance
    assert isinstance(table, MeasuredMeanReflectance)
    # The knots are the incidences, rounded to 1e-6 rad.
    np.testing.assert_allclose(table.incidence, angles, atol=1e-6)
    np.testing.assert_allclose(table.mean, mean, rtol=FIT_OF_EXACT_DATA)
    np.testing.assert_allclose(fit.interface.values, reflectance, rtol=FIT_OF_EXACT_DATA)
    with pytest.raises(FittingError, match="beta is not determined"):
        fit_material(Measurements(WAVELENGTHS, values, geometry, "beam"), FitOptions(material_type="III"))


def test_figure_7_is_reproduced() -> None:
    # f(rho) = exp(-10 |rho|), incidence 45, viewing 5 to 45 degrees as in Fig. 6, on the averages over wavelength.
    viewing = np.concatenate([np.arange(5.0, 35.0, 5.0), np.arange(35.0, 46.0, 1.0)])
    geometry = MeasurementGeometry.from_degrees(np.full(viewing.size, 45.0), viewing)
    rng = np.random.default_rng(2)
    values = printed_dielectric(geometry, "exponential", 10.0, smooth(rng, 0.3, 1, 0.4), smooth(rng, 0.1, 0.5, 0.3))
    lobe = fit_lobe(Measurements(WAVELENGTHS, values, geometry, "beam"))
    assert lobe.kind == "exponential"
    assert lobe.n.value == pytest.approx(10.0, rel=FIT_OF_EXACT_DATA)
    assert lobe.averages.max() == 1.0
    residuals = dict(lobe.residuals)
    assert set(residuals) == set(ATTENUATIONS)
    assert residuals["exponential"] < 1e-3 * min(residuals["cosine"], residuals["gaussian"])


def test_a_scale_that_cannot_be_seen_is_held_and_said() -> None:
    pairs = np.array([(i, i + d) for i in (5.0, 15.0, 25.0) for d in (-9.0, -5.0, -2.0, 0.0, 4.0)])
    geometry = MeasurementGeometry.from_degrees(*pairs.T)
    reflectance = smooth(np.random.default_rng(6), 0.4, 0.95, 0.3)
    values = printed_metal(geometry, 0.1, 0.1, reflectance, schlick_weight(geometry))
    noisy = values * (1.0 + 0.01 * np.random.default_rng(7).standard_normal(values.shape))
    fit = fit_material(Measurements(WAVELENGTHS, noisy, geometry, "beam"), FitOptions(material_type="III"))
    assert any("do not determine the scale" in note for note in fit.notes)
    assert fit.parameters[-1].name == "scale (held)"
    # With the scale at 1, S_I is what the 1 % of noise in 15 spectra allows: 5 standard errors of 1 % / sqrt(15).
    np.testing.assert_allclose(fit.interface.values, reflectance, rtol=5 * 0.01 / math.sqrt(15))


# --- with 1 % of noise: within the stated intervals ------------------------------------------------------------------


def options_for(truth: Truth) -> FitOptions:
    if truth.material_type == "III":
        return FitOptions(material_type="III", mean_reflectance="schlick")
    return FitOptions(material_type=truth.material_type, attenuation=truth.kind)


@pytest.mark.parametrize("noise", ["proportional", "uniform"])
@pytest.mark.parametrize("material_type", ["I", "II", "III"])
def test_intervals_hold_the_truth_95_times_in_100(material_type, noise) -> None:
    truth = random_truth(material_type, 2)
    recommendation = recommend_type(truth.measure(noise, seed=9999))
    shape_held, spectra_held = 0, []
    for draw in range(DRAWS):
        fit = fit_material(truth.measure(noise, seed=draw), options_for(truth), recommendation)
        shape = np.degrees(truth.shape) if material_type == "III" else truth.shape
        shape_held += fit.parameters[0].low <= shape <= fit.parameters[0].high
        pairs = [(fit.interface, truth.interface)] + ([] if fit.body is None else [(fit.body, truth.body)])
        spectra_held.append([(e.low <= true) & (true <= e.high) for e, true in pairs])
    low, high = binomial_ends(DRAWS, 0.95)
    assert low <= shape_held <= high, f"n or beta was inside {shape_held} of {DRAWS} times"
    for name, share in zip(("S_I", "S_B"), np.mean(spectra_held, axis=(0, 2)), strict=False):
        # Values of one draw share the noise of n and of the level, so a draw counts as little as once.
        assert low / DRAWS <= share <= high / DRAWS, f"{name} was inside {100 * share:.1f} % of the times"


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("noise", ["proportional", "uniform"])
@pytest.mark.parametrize("material_type", ["I", "II", "III"])
def test_intervals_hold_when_everything_is_left_to_the_data(material_type, noise) -> None:
    truth = random_truth(material_type, 2)
    shape = np.degrees(truth.shape) if material_type == "III" else truth.shape
    held = []
    for draw in range(DRAWS):
        fit = fit_material(truth.measure(noise, seed=draw))
        assert fit.material_type == material_type
        if material_type != "III" and fit.material.attenuation != truth.kind:
            # cos^n and a Gaussian hardly differ; where the wrong one is taken, the fit must say that it may be.
            assert any(truth.kind in note for note in fit.notes)
            continue
        held.append(fit.parameters[0].low <= shape <= fit.parameters[0].high)
    assert len(held) > 0.7 * DRAWS
    low, high = binomial_ends(len(held), 0.95)
    assert low <= sum(held) <= high


def test_noise_is_recognised() -> None:
    truth = random_truth("II", 2)
    proportional = fit_material(truth.measure("proportional", seed=1)).fit.noise
    uniform = fit_material(truth.measure("uniform", seed=1)).fit.noise
    # 1 % known from a few hundred residuals: its standard error is 1 / sqrt(2 * 270) = 4.3 %, five of them allowed.
    assert proportional.proportional == pytest.approx(0.01, rel=0.22)
    deviation = uniform.deviation(np.array([0.0]))[0]
    assert deviation == pytest.approx(0.01 * truth.values.mean(), rel=0.22)


def test_what_is_held_stays_held() -> None:
    plastic, metal = random_truth("I", 3), random_truth("III", 3)
    fit = fit_material(plastic.measure(), FitOptions(attenuation=plastic.kind, n=plastic.shape))
    assert fit.material.n == plastic.shape
    assert fit.parameters[0].name == "n (held)"
    np.testing.assert_allclose(fit.body.values, plastic.body, rtol=FIT_OF_EXACT_DATA)
    fit = fit_material(metal.measure(), FitOptions(beta=metal.shape, scale=1.0, mean_reflectance="schlick"))
    assert (fit.material.beta, fit.material.beta_across) == (metal.shape, None)
    assert [p.name for p in fit.parameters] == ["beta (held)", "scale (held)"]
    np.testing.assert_allclose(fit.interface.values, metal.interface, rtol=FIT_OF_EXACT_DATA)
    fit = fit_material(metal.measure(), FitOptions(mean_reflectance=SchlickMeanReflectance(0.5)))
    assert fit.material.mean_reflectance.normal_mean == 0.5
    assert fit.material.beta == pytest.approx(metal.shape, rel=FIT_OF_EXACT_DATA)
