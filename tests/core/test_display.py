"""Displays against colour-science and the standards; gamut mapping by its invariants."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.colorimetry import xy
from spectral_core.display import DISPLAYS, SRGB_WHITE, Display, display, fit_to_gamut
from spectral_core.errors import InvalidParameterError
from tests.tolerances import FLOAT64_ROUNDING, STANDARD_FOUR_DIGITS

KEYS = {"srgb": "sRGB", "display_p3": "Display P3", "rec2020": "ITU-R BT.2020"}
COLOURS = st.lists(
    st.tuples(*[st.floats(-2.0, 4.0)] * 3), min_size=1, max_size=20
).map(np.array)  # fmt: skip


@pytest.mark.parametrize("name", DISPLAYS)
def test_matrices_equal_colour_science(colour, name):
    space = colour.RGB_COLOURSPACES[KEYS[name]].copy()
    space.use_derived_transformation_matrices(True)  # the standards print rounded matrices
    shown = display(name)
    np.testing.assert_allclose(shown.to_tristimulus, space.matrix_RGB_to_XYZ, rtol=0, atol=FLOAT64_ROUNDING)
    np.testing.assert_allclose(shown.from_tristimulus, space.matrix_XYZ_to_RGB, rtol=0, atol=10 * FLOAT64_ROUNDING)
    np.testing.assert_allclose(shown.white, SRGB_WHITE, rtol=FLOAT64_ROUNDING)
    np.testing.assert_allclose(xy(shown.white), [0.3127, 0.3290], rtol=FLOAT64_ROUNDING)
    assert shown.white[1] == pytest.approx(1.0, rel=FLOAT64_ROUNDING)


def test_srgb_matrix_of_its_standard():
    printed = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    np.testing.assert_allclose(display("srgb").to_tristimulus, printed, rtol=0, atol=STANDARD_FOUR_DIGITS)


@pytest.mark.parametrize("name", DISPLAYS)
def test_transfer_curves_equal_colour_science(colour, name):
    light = np.linspace(0.0, 1.0, 2001)
    triples = np.repeat(light[:, None], 3, axis=1)
    encoded = display(name).encode(triples)
    if name == "rec2020":
        # BT.2020 prints alpha and beta in four digits; ours are exact, so that value and slope are continuous.
        expected = colour.models.oetf_BT2020(light, is_12_bits_system=True)
        np.testing.assert_allclose(encoded[:, 0], expected, rtol=0, atol=STANDARD_FOUR_DIGITS)
    else:
        expected = colour.models.eotf_inverse_sRGB(light)
        np.testing.assert_allclose(encoded[:, 0], expected, rtol=0, atol=10 * FLOAT64_ROUNDING)
    assert (encoded == encoded[:, :1]).all()


@pytest.mark.parametrize("name", DISPLAYS)
@given(values=st.lists(st.floats(-4.0, 4.0), min_size=3, max_size=3))
def test_encoding_and_decoding_are_inverse_and_odd(name, values):
    shown = display(name)
    # sRGB's two branches miss each other by 2e-8 at their seam, where its constants are rounded.
    np.testing.assert_allclose(shown.decode(shown.encode(values)), values, rtol=1e-6, atol=1e-12)
    np.testing.assert_array_equal(shown.encode(-np.array(values)), -shown.encode(values))
    np.testing.assert_allclose(shown.linear(shown.tristimulus(values)), values, rtol=0, atol=1e3 * FLOAT64_ROUNDING)


def test_rec2020_curve_is_smooth_at_its_seam():
    beta = 0.018053968510807
    step = 1e-7
    points = np.repeat(beta + step * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])[:, None], 3, axis=1)
    value = display("rec2020").encode(points)[:, 0]
    np.testing.assert_allclose(np.diff(value) / step, 4.5, rtol=1e-4)  # the curvature times the step


def test_anchors():
    np.testing.assert_allclose(display("srgb").linear(SRGB_WHITE), [1, 1, 1], rtol=10 * FLOAT64_ROUNDING)
    np.testing.assert_allclose(display("srgb").encode([[0, 0, 0], [1, 1, 1]]), [[0, 0, 0], [1, 1, 1]], atol=1e-15)
    assert display("srgb").encode([0.5, 0.0, 0.0])[0] == pytest.approx(0.7353569830524495, rel=1e-12)
    assert Display.from_primaries("plain", [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]], [1 / 3, 1 / 3]).encode(
        [0.2, 0.4, 0.6]
    ).tolist() == [0.2, 0.4, 0.6]


@pytest.mark.parametrize("method", ["clip", "compress"])
@given(values=COLOURS)
def test_fitted_colours_lie_inside_and_inner_ones_stay(method, values):
    mapping = fit_to_gamut(values, display("srgb"), method)
    assert mapping.linear_rgb.shape == values.shape
    assert (mapping.linear_rgb >= 0.0).all()
    assert (mapping.linear_rgb <= 1.0).all()
    inside = ((values >= 0.0) & (values <= 1.0)).all(axis=-1)
    np.testing.assert_array_equal(mapping.linear_rgb[inside], values[inside])
    assert mapping.below == np.count_nonzero((values < -1e-9).any(axis=-1))
    assert mapping.above == np.count_nonzero((values > 1.0 + 1e-9).any(axis=-1))
    assert mapping.total == len(values)
    again = fit_to_gamut(mapping.linear_rgb, display("srgb"), method)
    np.testing.assert_array_equal(again.linear_rgb, mapping.linear_rgb)
    assert (again.below, again.above) == (0, 0)


@pytest.mark.parametrize("name", DISPLAYS)
@given(values=COLOURS)
def test_compression_keeps_luminance_and_then_chromaticity(name, values):
    shown = display(name)
    luminance = values @ shown.to_tristimulus[1]
    values = values[luminance > 1e-3]
    if not len(values):
        return
    luminance = values @ shown.to_tristimulus[1]
    fitted = fit_to_gamut(values, shown, "compress").linear_rgb
    got = fitted @ shown.to_tristimulus[1]
    # Scaling down is all that may change luminance: undo it by the largest channel of the desaturated colour.
    grey = luminance[:, None]
    lowest = values.min(axis=-1, keepdims=True)
    share = np.where(lowest < 0.0, grey / (grey - np.minimum(lowest, 0.0)), 1.0)
    scale = np.maximum((grey + share * (values - grey)).max(axis=-1), 1.0)
    np.testing.assert_allclose(got * scale, luminance, rtol=1e-9, atol=1e-12)  # clipped rounding below zero
    # Hue line: the fitted colour is the scaled mixture of the colour and its grey.
    np.testing.assert_allclose(fitted * scale[:, None], grey + share * (values - grey), rtol=0, atol=1e-9)


def test_compression_and_clipping_differ():
    green = [[-0.5, 0.8, 0.1]]
    clipped = fit_to_gamut(green, display("srgb"), "clip")
    compressed = fit_to_gamut(green, display("srgb"), "compress")
    assert clipped.linear_rgb.tolist() == [[0.0, 0.8, 0.1]]
    luminance = np.array(green) @ display("srgb").to_tristimulus[1]
    assert compressed.linear_rgb @ display("srgb").to_tristimulus[1] == pytest.approx(luminance)
    assert compressed.linear_rgb[0, 0] == 0.0
    assert clipped.describe() == "gamut: of 1 colours 1 were too saturated and 0 too bright, and clipped"
    assert "compressed" in compressed.describe()
    assert fit_to_gamut([[-1.0, -1.0, -1.0]], display("srgb"), "compress").linear_rgb.tolist() == [[0.0, 0.0, 0.0]]


def test_bad_displays_are_refused():
    with pytest.raises(InvalidParameterError, match="display must be one of srgb"):
        display("crt")
    with pytest.raises(InvalidParameterError, match="gamut method must be one of"):
        fit_to_gamut([[0, 0, 0]], display("srgb"), "cut")
    with pytest.raises(InvalidParameterError, match="must span a triangle"):
        Display.from_primaries("flat", [[0.3, 0.3], [0.4, 0.4], [0.5, 0.5]], [0.3127, 0.329])
    with pytest.raises(InvalidParameterError, match="independent primaries"):
        Display("flat", np.ones((3, 3)))
    with pytest.raises(InvalidParameterError, match=r"shape \(3, 3\)"):
        Display("small", np.eye(2))
    with pytest.raises(InvalidParameterError, match="transfer of display 'x' must be one of"):
        Display("x", np.eye(3), "gamma")
    with pytest.raises(InvalidParameterError, match="needs drive_table"):
        Display("x", np.eye(3), "table")
    ramp = np.array([0.0, 0.5, 1.0])
    with pytest.raises(InvalidParameterError, match="must be 'table' when tables are given"):
        Display("x", np.eye(3), "srgb", ramp, np.stack([ramp] * 3, axis=1))
    with pytest.raises(InvalidParameterError, match="increase strictly from 0 to 1 in each channel"):
        Display("x", np.eye(3), "table", ramp, np.stack([ramp, ramp, [0.0, 0.0, 1.0]], axis=1))
    with pytest.raises(InvalidParameterError, match="drive table of display 'x' must increase"):
        Display("x", np.eye(3), "table", ramp[::-1], np.stack([ramp] * 3, axis=1))
    with pytest.raises(InvalidParameterError, match="finite"):
        display("srgb").linear([np.nan, 0.0, 0.0])
    with pytest.raises(InvalidParameterError, match="three values"):
        display("srgb").encode([0.0, 0.0])
