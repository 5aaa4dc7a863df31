"""D and G against Eqs. 11 and 12 as printed, the largest values of G/(N.V), and the ends of the ranges."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.reflection import (
    SchlickMeanReflectance,
    TypeIII,
    attenuation_over_cosine,
    elliptic_facet_distribution,
    facet_distribution,
    geometrical_attenuation,
)
from spectral_core.spectra import Spectrum
from tests.physics import exact
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING, SAMPLED_SUPREMUM

WHITE = Spectrum.constant(1.0)
DENORMAL = float(np.finfo(np.float64).smallest_subnormal)
COSINE = st.one_of(st.sampled_from([1.0, DENORMAL, 3 * DENORMAL, 1e-300, 1e-160]), st.floats(DENORMAL, 1.0))


def test_half_value_angle():
    for beta in np.radians([0.01, 5.0, 45.0, 90.0]):
        assert facet_distribution(beta, beta) == pytest.approx(0.5, rel=FLOAT64_ROUNDING)
        assert facet_distribution(0.0, beta) == 1.0


@given(alpha=st.floats(0.0, np.pi / 2), beta=st.floats(1e-6, np.pi / 2))
def test_distribution_against_mpmath(alpha, beta):
    with mp.workdps(40):
        truth = float(exact.facet_distribution(alpha, beta))
    exponent = max(alpha / beta, 1.0) ** 2  # error of the exponent, carried into the result
    assert float(facet_distribution(alpha, beta)) == pytest.approx(truth, rel=FLOAT64_ROUNDING * exponent, abs=1e-300)


def test_mirror_is_a_spike():
    np.testing.assert_array_equal(facet_distribution(np.array([0.0, 1e-300, 0.1]), 0.0), [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(facet_distribution(np.array([0.0, 0.1]), 1e-300), [1.0, 0.0])


@given(light=COSINE, viewer=COSINE, turn=st.floats(0.0, np.pi))
def test_attenuation_against_equation_12(light, viewer, turn):
    with mp.workdps(700):
        low, v = mp.mpf(light), mp.mpf(viewer)
        flat = mp.sqrt((1 - low**2) * (1 - v**2))
        apart = mp.sqrt(1 - low**2) - mp.sqrt(1 - v**2)
        squared = float((low + v) ** 2 + 2 * flat * (1 + mp.cos(turn)) + apart**2)
        squared = min(squared, 4.0)
        if squared < 1e-300:
            return  # the square itself has left the range of float64; the materials rescale the bisector instead
        s = mp.sqrt(mp.mpf(squared))
        nh, vh = (low + v) / s, s / 2
        g = min(1, 2 * nh * v / vh, 2 * nh * low / vh)
        truth, quotient = float(g), float(min(g / v, mp.mpf(np.finfo(float).max) / 256))
    assert float(geometrical_attenuation(light, viewer, squared)) == pytest.approx(truth, rel=1e-14, abs=1e-300)
    assert float(attenuation_over_cosine(light, viewer, squared)) == pytest.approx(quotient, rel=1e-14, abs=1e-300)


@pytest.mark.parametrize(("elevation", "supremum"), [(90, 2.0), (45, 4.828), (10, 22.86), (1, 229.2)])
def test_largest_attenuation_over_cosine(elevation, supremum):
    """The supremum over V for a light at elevation b is 2 (1 + cos b) / sin b, reached at the horizon."""
    b = np.radians(elevation)
    closed = 2 * (1 + np.cos(b)) / np.sin(b)
    assert closed == pytest.approx(supremum, rel=3e-4)  # the figures are given to four digits
    light = np.array([np.cos(b), 0.0, np.sin(b)])
    # Viewers over the half sphere, thickest at the horizon opposite the light.
    height = np.concatenate([10.0 ** np.linspace(-300, -3, 60), np.linspace(2e-3, 1.0, 400)])
    azimuth = np.pi + np.concatenate([[0.0], 10.0 ** np.linspace(-6, np.log10(np.pi), 200)])
    z, turn = (a.ravel() for a in np.meshgrid(height, azimuth))
    flat = np.sqrt((1 - z) * (1 + z))
    viewer = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    squared = ((light + viewer) ** 2).sum(axis=1)
    values = attenuation_over_cosine(light[2], z, squared)
    assert values.max() <= closed * (1 + SAMPLED_SUPREMUM)
    assert values.max() >= closed * (1 - SAMPLED_SUPREMUM)


def test_plain_quotient_would_fail_where_this_does_not():
    """G/(N.V) as a quotient is 0/0 for a viewer at the horizon."""
    assert attenuation_over_cosine(0.5, 0.0, 1.0) == 4 * (0.5 + 0.0) / 1.0  # Eq. 12, second case, over N.V
    assert geometrical_attenuation(0.5, 0.0, 1.0) == 0.0
    assert attenuation_over_cosine(0.0, 0.0, 0.0) == 0.0


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_material_against_mpmath(dtype, unit_vectors):
    vectors = unit_vectors(60, dtype, lowest=0.05)
    beta = np.radians(20)
    coefficients = TypeIII(WHITE, SchlickMeanReflectance(0.3), beta).coefficients(*vectors)
    assert coefficients.dtype == dtype
    with mp.workdps(40):
        truth = [
            float(exact.torrance_sparrow(*(exact.vector(v[i]) for v in vectors), beta)) for i in range(len(vectors[0]))
        ]
    tolerance = FLOAT32_ROUNDING if dtype is np.float32 else 1e-13  # alpha^2/beta^2 up to 20 magnifies 1e-15
    np.testing.assert_allclose(coefficients.sum(axis=1), truth, rtol=tolerance, atol=1e-20)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("depth", [1e-10, 1e-20, 1e-30, 1e-40, 1e-160, 1e-300, DENORMAL])
def test_light_and_viewer_sink_into_the_horizon(dtype, depth):
    """Exactly opposite each other the bisector is the normal, D = G = 1 and the value is 1/(N.V)."""
    low = max(depth, float(np.finfo(dtype).smallest_subnormal))
    light, viewer = np.array([[1, 0, low]], dtype), np.array([[-1, 0, low]], dtype)
    answer = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.1).coefficients(np.array([0, 0, 1], dtype), light, viewer)
    limit = float(np.finfo(dtype).max) / 256
    with mp.workdps(30):
        truth = float(min(1 / mp.mpf(float(light[0, 2])), mp.mpf(limit)))
    assert float(answer.sum()) == pytest.approx(truth, rel=FLOAT32_ROUNDING)
    assert answer.sum() <= limit * (1 + FLOAT32_ROUNDING)


def test_elliptic_distribution_is_the_isotropic_one_for_equal_angles(unit_vectors):
    along, across = np.linspace(-0.5, 0.5, 21), np.linspace(0.0, 0.4, 21)
    np.testing.assert_allclose(
        elliptic_facet_distribution(along, across, 0.1, 0.1),
        facet_distribution(np.hypot(along, across), 0.1),
        rtol=FLOAT64_ROUNDING,
    )
    vectors = unit_vectors(1000, np.float64)
    plain = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.2).coefficients(*vectors)
    equal = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.2, beta_across=0.2).coefficients(*vectors)
    np.testing.assert_array_equal(plain, equal)
    nearly = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.2, beta_across=0.2 * (1 + 1e-12))
    tangent = np.cross(vectors[0], vectors[1])
    np.testing.assert_allclose(nearly.coefficients(*vectors, tangent), plain, rtol=1e-8)  # exponent to 60 x 1e-12


def test_elliptic_distribution_has_its_half_values_along_and_across_the_tangent():
    narrow, wide = np.radians(4), np.radians(25)
    metal = TypeIII(WHITE, SchlickMeanReflectance(0.3), narrow, wide)
    normal, tangent = np.array([0.0, 0, 1]), np.array([3.0, 0, 0.7])  # neither unit nor perpendicular
    peak = metal.coefficients(normal, normal, normal, tangent).sum()
    for tilt, axis in ((narrow, [1.0, 0, 0]), (wide, [0, 1.0, 0])):
        half = np.cos(tilt) * normal + np.sin(tilt) * np.array(axis)
        light = half  # light and viewer both along the facet's normal
        value = metal.coefficients(normal, light, half, tangent).sum()
        over_cosine = min(1.0, 2 * np.cos(tilt) ** 2) / np.cos(tilt)  # Eq. 12 with L = V = H
        assert value / over_cosine / peak == pytest.approx(0.5, rel=1e-12)


def test_elliptic_distribution_does_not_see_the_sign_or_length_of_the_tangent(unit_vectors):
    normal, light, viewer = unit_vectors(500, np.float64)
    tangent = np.cross(normal, light)
    metal = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.05, 0.4)
    reference = metal.coefficients(normal, light, viewer, tangent)
    for same in (-tangent, 7.0 * tangent, tangent + 2.0 * normal):
        np.testing.assert_allclose(metal.coefficients(normal, light, viewer, same), reference, rtol=1e-10)
    turned = metal.coefficients(normal, light, viewer, np.cross(normal, tangent))
    assert np.abs(turned - reference).max() > 0.01


def test_useless_tangents_are_replaced():
    metal = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.05, 0.4)
    normal = np.array([[0.0, 0, 1], [0, 1, 0], [0.6, 0, 0.8]])
    answer = metal.coefficients(normal, normal, normal, np.array([[0.0, 0, 2], [0, 0, 0], [-0.3, 0, -0.4]]))
    np.testing.assert_allclose(answer.sum(axis=1), 1.0, rtol=FLOAT64_ROUNDING)


def test_missing_and_broken_tangents_are_refused():
    metal = TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.05, 0.4)
    normal = np.array([0.0, 0, 1])
    with pytest.raises(InvalidParameterError, match="tangent must be given for an anisotropic material"):
        metal.coefficients(normal, normal, normal)
    with pytest.raises(InvalidParameterError, match="tangent must be finite"):
        metal.coefficients(normal, normal, normal, np.array([np.nan, 0, 0]))


@pytest.mark.parametrize(
    "call",
    [
        lambda: facet_distribution(2.0, 0.1),
        lambda: facet_distribution(0.0, 1.7),
        lambda: facet_distribution(np.inf, 0.1),
        lambda: elliptic_facet_distribution(0.0, np.nan, 0.1, 0.2),
        lambda: elliptic_facet_distribution(0.0, 0.0, 0.1, -0.2),
        lambda: geometrical_attenuation(1.1, 0.5, 1.0),
        lambda: geometrical_attenuation(0.5, -0.1, 1.0),
        lambda: attenuation_over_cosine(0.5, 0.5, 0.0),
        lambda: attenuation_over_cosine(0.5, 0.5, 4.1),
        lambda: TypeIII(WHITE, SchlickMeanReflectance(0.3), -0.1),
        lambda: TypeIII(WHITE, SchlickMeanReflectance(0.3), 0.1, 3.0),
    ],
)
def test_invalid_parameters(call):
    with pytest.raises(InvalidParameterError):
        call()
