"""Types I, II and III as wholes: Eqs. 8 to 10 as printed, the split into coefficients and reflectances, the rules."""

import dataclasses

import numpy as np
import pytest

from spectral_core.errors import InvalidParameterError
from spectral_core.optical_constants import OpticalConstants
from spectral_core.reflection import (
    ATTENUATIONS,
    MEAN_BAND_NM,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeII,
    TypeIII,
    absorptance,
    fresnel_conductor,
)
from spectral_core.spectra import Spectrum
from tests.physics import copper
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING, PLAIN_FORMULAS

WAVELENGTHS = np.arange(400.0, 701.0, 20.0)
BODY = Spectrum([400, 520, 600, 700], [0.05, 0.1, 0.7, 0.8], "red")
GLOSS = Spectrum([400, 550, 700], [0.3, 0.5, 0.4], "satin")
COPPER = OpticalConstants(copper.WAVELENGTHS_NM, copper.N, copper.K, "copper")

MATERIALS = [
    TypeI(BODY, 5.0, "cosine", 11.0),
    TypeI(BODY, 0.3, "gaussian", 40.0),
    TypeII(BODY, GLOSS, "exponential", 10.0),
    TypeIII.from_optical_constants(COPPER, np.radians(15)),
    TypeIII.from_optical_constants(COPPER, np.radians(15), incidence="surface"),
    TypeIII.from_optical_constants(COPPER, np.radians(5), beta_across=np.radians(25)),
    TypeIII.from_normal_reflectance(BODY, np.radians(20)),
    TypeIII(BODY, MeasuredMeanReflectance(np.radians([5, 40, 75]), [0.4, 0.41, 0.6]), 0.3),
    TypeI(BODY, 5.0, "cosine", 11.0, energy_conserving=True),
    TypeII(BODY, GLOSS, "exponential", 10.0, energy_conserving=True),
    TypeIII.from_normal_reflectance(BODY, np.radians(20), energy_conserving=True),
]


def printed_lobe(kind, n, rho):
    """The laws of f as the paper prints them."""
    if kind == "cosine":
        return np.maximum(np.cos(rho), 0.0) ** n
    return np.exp(-n * np.abs(rho)) if kind == "exponential" else np.exp(-n * rho**2)


def dot(a, b):
    return (a * b).sum(axis=1)


@pytest.mark.parametrize("kind", ATTENUATIONS)
def test_type_i_is_equation_8(kind, unit_vectors):
    normal, light, viewer = unit_vectors(2000, np.float64)
    rho = np.arccos(np.clip(dot(2 * dot(normal, light)[:, None] * normal - light, viewer), -1, 1))
    expected = printed_lobe(kind, 7.0, rho)[:, None] * 5.0 + dot(normal, light)[:, None] * BODY.at(WAVELENGTHS)
    answer = TypeI(BODY, 5.0, kind, 7.0).radiance_factor(normal, light, viewer, WAVELENGTHS)
    np.testing.assert_allclose(answer, expected, rtol=PLAIN_FORMULAS)


@pytest.mark.parametrize("kind", ATTENUATIONS)
def test_type_ii_is_equation_9(kind, unit_vectors):
    normal, light, viewer = unit_vectors(2000, np.float64)
    rho = np.arccos(np.clip(dot(2 * dot(normal, light)[:, None] * normal - light, viewer), -1, 1))
    expected = printed_lobe(kind, 7.0, rho)[:, None] * GLOSS.at(WAVELENGTHS)
    expected = expected + dot(normal, light)[:, None] * BODY.at(WAVELENGTHS)
    answer = TypeII(BODY, GLOSS, kind, 7.0).radiance_factor(normal, light, viewer, WAVELENGTHS)
    np.testing.assert_allclose(answer, expected, rtol=PLAIN_FORMULAS)


@pytest.mark.parametrize("incidence", ["facet", "surface"])
def test_type_iii_is_equations_10_to_13(incidence, unit_vectors):
    normal, light, viewer = unit_vectors(2000, np.float64)
    half = (light + viewer) / np.linalg.norm(light + viewer, axis=1, keepdims=True)
    nh, nv, nl, vh = dot(normal, half), dot(normal, viewer), dot(normal, light), dot(viewer, half)
    beta = np.radians(25)
    facets = np.exp(-np.log(2) * np.arccos(np.clip(nh, -1, 1)) ** 2 / beta**2)
    shadow = np.minimum(1, np.minimum(2 * nh * nv / vh, 2 * nh * nl / vh))
    n, k = COPPER.at(MEAN_BAND_NM)
    cosine = vh if incidence == "facet" else nl
    mean = fresnel_conductor(cosine[:, None], n, k).mean(axis=1)[:, None]
    at_normal = fresnel_conductor(1.0, n, k).mean()
    colour = fresnel_conductor(1.0, *COPPER.at(WAVELENGTHS))
    eq13 = (1 - mean) / (1 - at_normal) * colour + (mean - at_normal) / (1 - at_normal)
    expected = (facets * shadow / nv)[:, None] * eq13
    metal = TypeIII.from_optical_constants(COPPER, beta, incidence=incidence)
    answer = metal.radiance_factor(normal, light, viewer, WAVELENGTHS)
    np.testing.assert_allclose(answer, expected, rtol=1e-7, atol=1e-12)  # the table of Sa, 1e-9 of its largest


def test_copper_at_normal_incidence_has_its_fresnel_colour():
    metal = TypeIII.from_optical_constants(COPPER, 0.1)
    z = np.array([0.0, 0.0, 1.0])
    n, k = COPPER.at(WAVELENGTHS)
    np.testing.assert_allclose(metal.radiance_factor(z, z, z, WAVELENGTHS)[0], 1 - absorptance(1.0, n, k), rtol=1e-8)


@pytest.mark.parametrize("material", MATERIALS, ids=range(len(MATERIALS)))
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_radiance_factor_is_coefficients_times_reflectances(material, dtype, unit_vectors):
    normal, light, viewer = unit_vectors(300, dtype)
    tangent = np.cross(normal, light)
    coefficients = material.coefficients(normal, light, viewer, tangent)
    assert coefficients.shape == (300, len(material.reflectances)) == (300, len(material.component_names))
    assert coefficients.dtype == dtype
    spectra = np.stack([s.at(WAVELENGTHS) for s in material.reflectances])
    answer = material.radiance_factor(normal, light, viewer, WAVELENGTHS, tangent)
    assert answer.dtype == dtype
    assert answer.shape == (300, len(WAVELENGTHS))
    np.testing.assert_allclose(
        answer, np.maximum(coefficients.astype(float) @ spectra, 0), rtol=FLOAT32_ROUNDING, atol=1e-12
    )


@pytest.mark.parametrize("material", MATERIALS, ids=range(len(MATERIALS)))
def test_nothing_below_the_horizon(material):
    normal = np.tile([0.0, 0.0, 1.0], (6, 1))
    up, level, down = [0.6, 0, 0.8], [1.0, 0, 0], [0.6, 0, -0.8]
    light = np.array([down, up, level, up, down, level])
    viewer = np.array([up, down, up, level, down, level])
    answer = material.coefficients(normal, light, viewer, np.array([1.0, 0, 0]))
    np.testing.assert_array_equal(answer, 0.0)


@pytest.mark.parametrize("material", MATERIALS, ids=range(len(MATERIALS)))
def test_a_whole_picture_is_the_same_as_its_rays(material, unit_vectors):
    """Blocks, broadcasting and the type of the input change nothing."""
    normal, light, viewer = unit_vectors(20_000, np.float64)
    tangent = np.cross(normal, light)
    whole = material.coefficients(normal, light, viewer, tangent)
    some = np.array([0, 1, 8191, 8192, 8193, 19_999])
    for i in some:
        alone = material.coefficients(normal[i], light[i], viewer[i], tangent[i])
        np.testing.assert_array_equal(alone[0], whole[i])
    one_light = material.coefficients(normal, light[:1], viewer, tangent)
    np.testing.assert_array_equal(
        one_light, material.coefficients(normal, np.repeat(light[:1], 20_000, axis=0), viewer, tangent)
    )
    assert material.coefficients(normal[:0], light[:0], viewer[:0], tangent[:0]).shape == (0, 2)


@pytest.mark.parametrize("material", MATERIALS, ids=range(len(MATERIALS)))
def test_float32_differs_by_rounding_only(material, unit_vectors):
    normal, light, viewer = unit_vectors(3000, np.float32)
    tangent = np.cross(normal, light)
    single = material.coefficients(normal, light, viewer, tangent)
    exact = [v.astype(np.float64) for v in (normal, light, viewer)]
    exact = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in exact]
    double = material.coefficients(*exact, tangent.astype(np.float64))
    scale = np.abs(double).sum(axis=1, keepdims=True)  # the parts of Eq. 13 may cancel, their sum does not
    assert np.max(np.abs(single - double) / np.maximum(scale, 1e-30)) < FLOAT32_ROUNDING


def test_reflectances_tell_the_components():
    one, two, three = MATERIALS[0], MATERIALS[2], MATERIALS[3]
    assert one.reflectances == (Spectrum.constant(5.0), BODY)
    assert one.component_names == two.component_names == ("interface", "body")
    assert two.reflectances == (GLOSS, BODY)
    assert three.reflectances[1] == Spectrum.constant(1.0)
    assert three.component_names == ("normal", "grazing")
    assert [m.needs_tangent for m in MATERIALS[:6]] == [False, False, False, False, False, True]


def test_negative_reflectance_is_clamped_only_at_the_end():
    """A metal with a black wavelength: Eq. 13 falls below 0 there where Sa falls below Sa(0)."""
    spectrum = Spectrum([400, 500, 700], [0.0, 0.95, 0.95])
    metal = TypeIII(spectrum, OpticalMeanReflectance([0.96], [6.7]), 0.3)
    phi = np.radians(80)
    light, viewer = np.array([np.sin(phi), 0, np.cos(phi)]), np.array([-np.sin(phi), 0, np.cos(phi)])
    z = np.array([0.0, 0, 1])
    assert metal.coefficients(z, light, viewer)[0, 1] < -0.6
    factor = metal.radiance_factor(z, light, viewer, [400.0, 600.0])
    assert factor[0, 0] == 0.0
    assert factor[0, 1] > 0.5


def test_materials_are_frozen_values():
    material = TypeI(BODY, 0.5, "cosine", 3.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        material.n = 4.0
    assert material == TypeI(BODY, 0.5, "cosine", 3.0)
    assert material != TypeI(BODY, 0.5, "cosine", 4.0)
    assert dataclasses.replace(material, n=4.0).n == 4.0
    assert hash(material) == hash(TypeI(BODY, 0.5, "cosine", 3.0))


def test_schlick_metal_takes_its_mean_from_the_band_of_the_paper():
    metal = TypeIII.from_normal_reflectance(BODY, 0.2)
    assert metal.mean_reflectance.normal_mean == pytest.approx(BODY.at(np.arange(400, 701, 5)).mean(), rel=1e-14)
    flat = TypeIII.from_normal_reflectance(Spectrum.constant(1.0), 0.2)
    z = np.array([0.0, 0, 1])
    np.testing.assert_allclose(flat.radiance_factor(z, z, z, [500.0]), 1.0, rtol=FLOAT64_ROUNDING)


Z = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("call", "rule"),
    [
        (lambda: TypeI(BODY, -1.0), "interface_reflectance must lie between 0 and 1e"),
        (lambda: TypeI(BODY, np.inf), "interface_reflectance must be finite"),
        (lambda: TypeI(BODY, 1.0, "blinn"), "attenuation must be one of"),
        (lambda: TypeII(BODY, GLOSS, "cosine", -0.1), "n must lie between 0"),
        (lambda: TypeIII(Spectrum.constant(1.2), SchlickMeanReflectance(0.5), 0.1), "normal_reflectance must lie"),
        (lambda: TypeIII(BODY, 0.5, 0.1), "mean_reflectance must be a MeanReflectance, but is 0.5"),
        (lambda: TypeIII(BODY, SchlickMeanReflectance(0.5), 2.0), "beta must lie between 0 and 1.57"),
        (lambda: TypeIII(BODY, SchlickMeanReflectance(0.5), np.nan), "beta must be finite"),
        (lambda: TypeIII(BODY, SchlickMeanReflectance(0.5), 0.1, -1.0), "beta_across must lie between 0"),
        (lambda: TypeIII(BODY, SchlickMeanReflectance(0.5), 0.1, incidence="half"), "incidence must be one of"),
        (
            lambda: TypeIII(BODY, SchlickMeanReflectance(0.5), 0.0, energy_conserving=True),
            "beta must be at least 1e-06",
        ),
        (lambda: TypeIII.from_normal_reflectance(Spectrum.constant(2.0), 0.1), "normal_reflectance must lie"),
        (lambda: MATERIALS[0].coefficients(Z, [0, 0, 2.0], Z), "to_light must be finite vectors of length 1"),
        (lambda: MATERIALS[3].coefficients([0, 0, np.nan], Z, Z), "normal must be finite vectors of length 1"),
        (lambda: MATERIALS[2].coefficients(Z, Z, [0, 0, np.inf]), "to_viewer must be finite vectors of length 1"),
        (lambda: MATERIALS[0].coefficients(Z, [0, 1.0], Z), "to_light must be real vectors with three components"),
        (lambda: MATERIALS[0].coefficients(np.zeros((2, 3)), np.zeros((5, 3)), Z), "directions must have one shape"),
        (lambda: MATERIALS[0].coefficients(np.zeros((2, 2, 3)), Z, Z), "directions must have the shape"),
        (lambda: MATERIALS[0].radiance_factor(Z, Z, Z, 500.0), "wavelengths_nm must be a list"),
        (lambda: MATERIALS[0].radiance_factor(Z, Z, Z, [np.nan]), "must be finite"),
    ],
)
def test_invalid_input(call, rule):
    with pytest.raises(InvalidParameterError, match=rule):
        call()
