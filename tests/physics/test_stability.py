"""The ends of every range: over a million drawn combinations within the bounds that docs/stability.md states."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.reflection import (
    ATTENUATIONS,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeII,
    TypeIII,
)
from spectral_core.spectra import Spectrum
from tests.physics import exact
from tools import stability_table

DRAWS = 25_000  # of each case and type: with 25 cases and two types more than 1.2 million
DENORMAL = float(np.finfo(np.float64).smallest_subnormal)


def test_there_are_a_million_draws():
    assert 2 * DRAWS * len(stability_table.CASES) >= 1_000_000


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("case", stability_table.CASES, ids=lambda case: f"{case.function}: {case.range}")
def test_stated_bounds_hold(case, dtype):
    worst = stability_table.run(case, dtype, DRAWS, seed=20)
    assert worst.sound, "not finite, or negative"
    assert worst.draws >= DRAWS
    assert worst.error <= case.bounds[dtype.__name__]


def test_the_published_table_is_the_one_that_is_tested():
    text = (stability_table.ROOT / "docs" / "stability.md").read_text(encoding="utf-8")
    for case in stability_table.CASES:
        assert f"| `{case.function}` | {case.range} | {case.measure} |" in text
        for bound in case.bounds.values():
            assert f"| {bound:.0e} |" in text


# --- the references of the table, which are in extended precision, against mpmath -----------------------------------


def test_extended_precision_is_extended():
    assert np.finfo(np.longdouble).eps < 1e-18


def test_reference_of_fresnel():
    rng = np.random.default_rng(5)
    n, k = stability_table._index_pairs(rng, 60, np.float64)
    c = stability_table.cosines(rng, 60, np.float64)
    truth = stability_table.long_absorptance(c, n, k)
    with mp.workdps(700):
        for i in range(60):
            assert float(truth[i]) == pytest.approx(float(1 - exact.fresnel(float(c[i]), n[i], k[i])), rel=1e-13)


def test_reference_of_torrance_sparrow_and_of_the_lobes():
    rng = np.random.default_rng(6)
    for case in stability_table._metal(1e-3, number=4)(rng, 40, np.float64):
        assert np.all(np.isfinite(case.exact))
    normal, light, viewer = (stability_table.random_directions(rng, 40) for _ in range(3))
    light *= np.sign((light * normal).sum(1))[:, None]
    viewer *= np.sign((viewer * normal).sum(1))[:, None]
    outcome = stability_table._metal_outcome([normal, light, viewer], 0.4, np.float64)
    with mp.workdps(40):
        for i in range(40):
            vectors = [exact.vector(v[i]) for v in (normal, light, viewer)]
            truth = float(exact.torrance_sparrow(*vectors, 0.4))
            assert float(outcome.exact[i]) == pytest.approx(truth, rel=1e-14)
            rho = exact.angle(exact.mirror(vectors[0], vectors[1]), vectors[2])
            for kind in ATTENUATIONS:
                found = stability_table._lobe(kind, 7.0, np.array([np.longdouble(float(rho))]))
                assert float(found[0]) == pytest.approx(float(exact.lobe(kind, 7.0, mp.mpf(float(rho)))), rel=1e-14)


# --- whole materials, anywhere in their ranges ----------------------------------------------------------------------

REFLECTANCE = st.sampled_from([Spectrum.constant(v) for v in (0.0, 0.5, 1.0)] + [Spectrum([400, 500], [0.0, 1.0])])
BETA = st.one_of(st.sampled_from([0.0, DENORMAL, 1e-8, np.pi / 2]), st.floats(0.0, np.pi / 2))
EXPONENT = st.one_of(st.sampled_from([0.0, DENORMAL, 1.0, 1e8]), st.floats(0.0, 1e8))
MEAN = st.one_of(
    st.builds(SchlickMeanReflectance, st.sampled_from([0.0, 0.5, 1.0 - 2.0**-53, 1.0])),
    st.sampled_from(
        [
            OpticalMeanReflectance([0.96], [6.7]),
            OpticalMeanReflectance([0.5], [0.0]),
            OpticalMeanReflectance([1.5, 0.2], [20.0, 0.0]),
            OpticalMeanReflectance([1.0], [0.0]),
            OpticalMeanReflectance([0.0], [2.0]),
            MeasuredMeanReflectance([0.1, 1.0], [1.0, 0.5]),
            MeasuredMeanReflectance([0.1, 1.0, 1.5], [0.9, 0.1, 0.99]),
        ]
    ),
)
MATERIAL = st.one_of(
    st.builds(TypeI, REFLECTANCE, st.sampled_from([0.0, 1.0, 1e6]), st.sampled_from(ATTENUATIONS), EXPONENT),
    st.builds(TypeII, REFLECTANCE, REFLECTANCE, st.sampled_from(ATTENUATIONS), EXPONENT),
    st.builds(TypeIII, REFLECTANCE, MEAN, BETA, st.one_of(st.none(), BETA), st.sampled_from(["facet", "surface"])),
)


@given(material=MATERIAL, seed=st.integers(0, 2**32 - 1), dtype=st.sampled_from([np.float32, np.float64]))
def test_everything_is_finite_and_not_negative(material, seed, dtype):
    """Any material, light and viewer from the zenith to the smallest denormal above the horizon, any tangent."""
    rng = np.random.default_rng(seed)
    count = 400
    heights = [stability_table.cosines(rng, count, dtype).astype(float) for _ in range(2)]
    turns = rng.choice([0.0, np.pi, 1e-30, 1.0, 3.0], (2, count))
    vectors = []
    for z, turn in zip(heights, turns, strict=True):
        flat = np.sqrt((1 - z) * (1 + z))
        vectors.append(np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1).astype(dtype))
    normal = np.array([0, 0, 1], dtype)
    tangent = rng.choice([-1.0, 0.0, 1e-300, 2.0], (count, 3))
    coefficients = material.coefficients(normal, *vectors, tangent)
    assert coefficients.dtype == dtype
    assert np.all(np.isfinite(coefficients))
    factor = material.radiance_factor(normal, *vectors, [400.0, 450.0, 700.0], tangent)
    assert np.all(np.isfinite(factor))
    assert np.all(factor >= 0)
    if not isinstance(material, TypeIII):
        assert np.all(coefficients >= 0)
    else:
        total = coefficients.astype(np.longdouble).sum(axis=1)
        assert np.all(total >= -np.finfo(dtype).eps * np.abs(coefficients).max(axis=1))
