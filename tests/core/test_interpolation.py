"""Interpolation weights against polynomials (closed form), numpy, and exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.interpolation import INTERPOLATIONS, interpolate, interpolation_matrix
from tests.tolerances import FLOAT64_ROUNDING, INTERPOLATED_POLYNOMIAL

NODES = st.lists(st.integers(3000, 9000), min_size=1, max_size=12, unique=True).map(
    lambda whole: np.sort(np.array(whole)) / 10.0
)
TARGETS = st.lists(st.floats(100.0, 1200.0), min_size=1, max_size=20).map(np.array)


@given(NODES, TARGETS, st.sampled_from(INTERPOLATIONS))
def test_weights_sum_to_one_and_are_held_beyond_the_ends(nodes, targets, method):
    matrix = interpolation_matrix(nodes, targets, method)
    assert np.isfinite(matrix).all()
    # Close nodes beside wide gaps make large weights of both signs, whose rounding the sum keeps.
    assert np.abs(matrix.sum(axis=1) - 1.0).max() <= FLOAT64_ROUNDING * np.abs(matrix).sum(axis=1).max()
    assert (matrix[targets <= nodes[0]] == np.eye(nodes.size)[0]).all()
    assert (matrix[targets >= nodes[-1]] == np.eye(nodes.size)[-1]).all()


@given(NODES, st.sampled_from(INTERPOLATIONS))
def test_nodes_are_read_exactly(nodes, method):
    difference = np.abs(interpolation_matrix(nodes, nodes, method) - np.eye(nodes.size)).max()
    assert difference == 0.0


@given(NODES, TARGETS, st.sampled_from(["linear", "lagrange"]))
def test_matrix_and_direct_reading_agree(nodes, targets, method):
    values = np.cos(nodes / 50.0)
    matrix = interpolation_matrix(nodes, targets, method)
    scale = np.abs(matrix).sum(axis=1).max()
    assert np.abs(matrix @ values - interpolate(nodes, values, targets, method)).max() <= FLOAT64_ROUNDING * scale


def test_linear_equals_numpy():
    rng = np.random.default_rng(5)
    nodes = np.sort(rng.uniform(350.0, 850.0, 40))
    values = rng.normal(size=40)
    targets = rng.uniform(300.0, 900.0, 500)
    expected = np.interp(targets, nodes, values)
    np.testing.assert_allclose(interpolate(nodes, values, targets), expected, rtol=0, atol=INTERPOLATED_POLYNOMIAL)


@pytest.mark.parametrize(("degree", "place"), [(3, "inner"), (2, "ends")])
def test_lagrange_reproduces_polynomials(degree, place):
    nodes = np.array([400.0, 405.0, 412.0, 430.0, 431.0, 450.0, 500.0])
    targets = np.linspace(405.0, 450.0, 91) if place == "inner" else np.linspace(400.0, 500.0, 101)
    values = ((nodes - 440.0) / 50.0) ** degree
    expected = ((targets - 440.0) / 50.0) ** degree
    np.testing.assert_allclose(
        interpolate(nodes, values, targets, "lagrange"), expected, rtol=0, atol=INTERPOLATED_POLYNOMIAL
    )


def test_lagrange_in_exact_arithmetic():
    nodes, target = [400, 410, 430, 435], 417
    expected = []
    for i, node in enumerate(nodes):
        weight = Fraction(1)
        for j, other in enumerate(nodes):
            if i != j:
                weight *= Fraction(target - other, node - other)
        expected.append(float(weight))
    # Two more nodes on each side, which the four-point formula must not touch.
    around = [300, 350, *nodes, 500, 600]
    weights = interpolation_matrix(around, [target], "lagrange")[0]
    np.testing.assert_allclose(weights[2:6], expected, rtol=FLOAT64_ROUNDING)
    assert (weights[[0, 1, 6, 7]] == 0.0).all()


def test_natural_spline_against_its_definition():
    nodes = np.array([400.0, 420.0, 425.0, 470.0, 500.0])
    values = np.array([0.1, 0.9, 0.4, 0.3, 0.8])
    step = 1e-3

    def curve(x):
        return interpolation_matrix(nodes, np.atleast_1d(x), "spline") @ values

    # Natural: the second difference vanishes towards both ends. Smooth: slope and curvature agree across each node.
    for end, inward in ((400.0, 1.0), (500.0, -1.0)):
        x = end + inward * step * np.array([0.0, 1.0, 2.0])
        second = np.dot([1.0, -2.0, 1.0], curve(x)) / step**2
        assert abs(second) < 1e-4  # curvature grows in proportion to the distance, here 1e-3 nm
    for node in nodes[1:-1]:
        left = np.gradient(curve(node + step * np.array([-2.0, -1.0, 0.0])), step)[-1]
        right = np.gradient(curve(node + step * np.array([0.0, 1.0, 2.0])), step)[0]
        assert left == pytest.approx(right, abs=1e-4)  # one-sided differences err by half a step times the curvature


def test_spline_reproduces_a_straight_line():
    nodes = np.array([433.0, 457.0, 484.0, 518.0, 546.0, 578.0, 609.0, 643.0])
    targets = np.linspace(433.0, 643.0, 99)
    matrix = interpolation_matrix(nodes, targets, "spline")
    np.testing.assert_allclose(matrix @ nodes, targets, rtol=FLOAT64_ROUNDING * 10)


@pytest.mark.parametrize(
    ("nodes", "reason"),
    [([400.0, 400.0], "increase strictly"), ([410.0, 400.0], "400 follows 410"), ([], "at least one"),
     ([400.0, np.nan], "finite")],
)  # fmt: skip
def test_bad_nodes_are_refused(nodes, reason):
    with pytest.raises(InvalidParameterError, match=reason):
        interpolation_matrix(nodes, [405.0])


def test_bad_arguments_are_refused():
    with pytest.raises(InvalidParameterError, match="must be one of"):
        interpolation_matrix([400.0, 410.0], [405.0], "quintic")
    with pytest.raises(InvalidParameterError, match="must be one of"):
        interpolate([400.0, 410.0], [1.0, 2.0], [405.0], "spline")
    with pytest.raises(InvalidParameterError, match="2 samples"):
        interpolate([400.0, 410.0], [1.0, 2.0, 3.0], [405.0])
    with pytest.raises(InvalidParameterError, match="list of numbers"):
        interpolation_matrix([400.0, 410.0], [[405.0]])
