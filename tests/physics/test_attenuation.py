"""f(rho): the three laws against mpmath, up to n = 1e8."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.reflection import ATTENUATIONS, TypeI, attenuation, attenuation_at_angle
from spectral_core.spectra import Spectrum
from tests.physics import exact
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING, LOBE_OF_FLOAT64_DIRECTIONS

BLACK = Spectrum.constant(0.0)


@pytest.mark.parametrize("kind", ATTENUATIONS)
@given(n=st.one_of(st.sampled_from([0.0, 1.0, 11.0, 1e8]), st.floats(0.0, 1e8)), rho=st.floats(0.0, 3.14159))
def test_law_of_the_angle(kind, n, rho):
    with mp.workdps(40):
        truth = exact.lobe(kind, n, mp.mpf(rho))
        # What one unit in the last place of cos(rho) or n rho does to the result.
        condition = max(n * rho**2 if kind == "gaussian" else n * rho, n / max(abs(float(mp.cos(rho))), 1e-300), 1.0)
    answer = float(attenuation_at_angle(kind, n, rho))
    assert abs(answer - float(truth)) <= FLOAT64_ROUNDING * min(condition, 1e13) * float(truth) + 1e-300


@pytest.mark.parametrize("kind", ATTENUATIONS)
@pytest.mark.parametrize("n", [0.0, 0.5, 1.0, 11.0, 1e3, 1e5, 1e8])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_material_against_mpmath(kind, n, dtype):
    """The coefficient of a material, from vectors, at angles from deep inside the lobe to its skirt."""
    rng = np.random.default_rng(3)
    width = 1 / max(n, 0.5) if kind == "exponential" else 1 / np.sqrt(max(n, 0.5))
    material = TypeI(BLACK, 1.0, kind, n)
    for rho in width * np.array([0.0, 1e-3, 0.1, 1.0, 2.0]):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        side = np.cross(normal, rng.normal(size=3))
        side /= np.linalg.norm(side)
        other = np.cross(normal, side)
        light = np.cos(0.7) * normal + np.sin(0.7) * side
        mirrored = np.cos(0.7) * normal - np.sin(0.7) * side
        spread = min(rho, 0.85)
        viewer = np.cos(spread) * mirrored + np.sin(spread) * (other if spread < 1e-9 else -other)
        vectors = [v.astype(dtype) for v in (normal, light, viewer)]
        with mp.workdps(50):
            n_, l_, v_ = (exact.vector(v) for v in vectors)
            truth = float(exact.lobe(kind, n, exact.angle(exact.mirror(n_, l_), v_)))
        answer = material.coefficients(*vectors)
        assert answer.dtype == dtype
        tolerance = FLOAT32_ROUNDING if dtype is np.float32 else FLOAT64_ROUNDING + LOBE_OF_FLOAT64_DIRECTIONS * n
        assert float(answer[0, 0]) == pytest.approx(truth, rel=tolerance)


def test_power_of_a_rounded_cosine_would_fail_where_this_does_not():
    """At n = 1e8 pow(R.V, n) in float32 has lost all, the form used holds 4e-8."""
    r = np.array([0, 0, 1], np.float32)
    v = np.array([1e-4, 0, 1], np.float32)
    assert float(np.clip(r @ v, 0, 1)) ** 1e8 == 1.0
    with mp.workdps(40):
        truth = float(mp.cos(exact.angle(exact.vector(r), exact.vector(v))) ** mp.mpf(10**8))
    assert float(attenuation("cosine", 1e8, r, v)) == pytest.approx(truth, rel=FLOAT32_ROUNDING)


@pytest.mark.parametrize("kind", ATTENUATIONS)
def test_peak_is_one_and_the_lobe_falls(kind):
    assert attenuation_at_angle(kind, 10.0, 0.0) == 1.0
    rho = np.linspace(0, np.pi, 2001)
    assert np.all(np.diff(attenuation_at_angle(kind, 10.0, rho)) <= 0)
    np.testing.assert_array_equal(attenuation_at_angle(kind, 10.0, -rho), attenuation_at_angle(kind, 10.0, rho))


def test_paper_exponents():
    """Fig. 7: exp(-10 rho) has fallen to 0.1745 at 10 deg; Fig. 10: (cos 10 deg)^11 = 0.8450."""
    assert attenuation_at_angle("exponential", 10.0, np.radians(10)) == pytest.approx(np.exp(-np.pi / 1.8), rel=1e-14)
    assert attenuation_at_angle("cosine", 11.0, np.radians(60)) == pytest.approx(2.0**-11, rel=1e-13)


def test_cosine_law_is_zero_beyond_a_right_angle():
    assert attenuation_at_angle("cosine", 0.0, 1.6) == 0.0
    assert attenuation_at_angle("cosine", 0.0, 1.5) == 1.0
    assert attenuation_at_angle("exponential", 0.0, 3.0) == 1.0


@pytest.mark.parametrize(
    ("kind", "n", "rule"),
    [
        ("phong", 1.0, "attenuation must be one of cosine, exponential, gaussian, but is 'phong'"),
        ("cosine", -1.0, "n must lie between 0 and 1e"),
        ("cosine", 2e8, "n must lie between 0 and 1e"),
        ("gaussian", np.nan, "n must be finite"),
    ],
)
def test_invalid_parameters(kind, n, rule):
    with pytest.raises(InvalidParameterError, match=rule):
        attenuation_at_angle(kind, n, 0.1)
    with pytest.raises(InvalidParameterError, match=rule):
        attenuation(kind, n, np.array([0, 0, 1.0]), np.array([0, 0, 1.0]))
    with pytest.raises(InvalidParameterError, match=rule):
        TypeI(BLACK, 1.0, kind, n)
