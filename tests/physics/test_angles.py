"""Angles between vectors keep their digits at both ends: 2 atan2 of chord and sum."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.reflection import angle_between, mirror_direction
from spectral_core.reflection.angles import chord_squared
from tests.physics import exact
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING


@given(exponent=st.floats(-12, 0.49), turn=st.floats(0, 6.28))
def test_small_and_large_angles_against_mpmath(exponent, turn):
    rho = 10.0**exponent
    a = np.array([0.0, 0.0, 1.0])
    b = np.array([np.sin(rho) * np.cos(turn), np.sin(rho) * np.sin(turn), np.cos(rho)])
    for dtype, tolerance in ((np.float32, FLOAT32_ROUNDING), (np.float64, FLOAT64_ROUNDING)):
        first, second = a.astype(dtype), b.astype(dtype)
        with mp.workdps(40):
            truth = exact.angle(exact.vector(first), exact.vector(second))
        answer = angle_between(first, second)
        assert answer.dtype == dtype
        assert float(answer) == pytest.approx(float(truth), rel=tolerance)


def test_arccos_would_fail_where_this_does_not():
    a = np.array([0, 0, 1], np.float32)
    b = np.array([1e-4, 0, 1], np.float32)
    assert np.arccos(np.clip(a @ b, -1, 1)) == 0.0  # the digits that the plain formula loses
    assert angle_between(a, b) == pytest.approx(1e-4, rel=FLOAT32_ROUNDING)


def test_right_and_straight_angles():
    x, y = np.eye(3)[:2]
    assert angle_between(x, y) == pytest.approx(np.pi / 2, rel=FLOAT64_ROUNDING)
    assert angle_between(x, -x) == np.pi
    assert angle_between(x, x) == 0.0
    assert chord_squared(x, -x) == 4.0


def test_mirror_keeps_the_normal_part_and_turns_the_rest(unit_vectors):
    normal, light, _ = unit_vectors(500, np.float64)
    mirrored = mirror_direction(normal, light)
    np.testing.assert_allclose((mirrored * normal).sum(1), (light * normal).sum(1), atol=FLOAT64_ROUNDING)
    along = (light * normal).sum(1)[:, None] * normal
    np.testing.assert_allclose(mirrored - along, along - light, atol=FLOAT64_ROUNDING)


@pytest.mark.parametrize("bad", [np.zeros(2), 1.0, np.zeros((4, 2)), np.array(["a", "b", "c"]), np.zeros(3, complex)])
def test_what_is_no_vector_is_refused(bad):
    with pytest.raises(InvalidParameterError, match="first must be real vectors with three components"):
        angle_between(bad, np.array([0.0, 0.0, 1.0]))
