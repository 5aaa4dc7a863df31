"""The uplift: exact colours under D65, physical reflectances, linearity, and the published curves it starts from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.colorimetry import chromatic_adaptation, observer, tristimulus_weights, wavelength_grid, white_point
from spectral_core.display import display
from spectral_core.errors import InvalidParameterError
from spectral_core.library import illuminant
from spectral_core.rgb_uplift import BASIS, BASIS_WAVELENGTHS_NM, basis_spectra, uplift, uplift_values
from tests.tolerances import FLOAT64_ROUNDING, SUM_OF_HUNDREDS

UNIT = st.floats(0.0, 1.0)


def shown(values: np.ndarray) -> np.ndarray:
    """Linear sRGB of reflectances under D65, white scaled to 1 channel by channel (D65 is not quite sRGB's white)."""
    weights = tristimulus_weights(illuminant("D65"), observer("cie_1931_2"), wavelength_grid("exact"))
    to_rgb = display("srgb").from_tristimulus.T
    return (values @ weights @ to_rgb) / (weights.sum(axis=0) @ to_rgb)


@given(st.tuples(UNIT, UNIT, UNIT))
def test_colour_comes_back_and_reflectance_is_physical(rgb):
    spectrum = uplift(rgb)
    values = spectrum.at(BASIS_WAVELENGTHS_NM)
    np.testing.assert_allclose(shown(values), rgb, rtol=0, atol=SUM_OF_HUNDREDS)
    assert values.min() >= 0.0
    assert values.max() <= max(rgb) * (1.0 + FLOAT64_ROUNDING)
    assert values.min() >= min(rgb) * (1.0 - FLOAT64_ROUNDING)


def test_white_difference_is_small_and_adaptation_keeps_colours():
    weights = tristimulus_weights(illuminant("D65"), observer("cie_1931_2"), wavelength_grid("exact"))
    white = white_point(illuminant("D65"), observer("cie_1931_2"))
    matrix = chromatic_adaptation(white, display("srgb").white, "bradford")
    colours = np.random.default_rng(2).uniform(0.0, 1.0, (500, 3))
    seen = display("srgb").linear(uplift_values(colours) @ weights @ matrix.T)
    # sRGB rounds its white to four places; Bradford moves it in cone space and not in sRGB's channels.
    np.testing.assert_allclose(seen, colours, rtol=0, atol=2e-4)


def test_basis_is_a_partition_of_one():
    assert BASIS.shape == (3, 471)
    assert BASIS.min() > 0.0
    np.testing.assert_allclose(BASIS.sum(axis=0), 1.0, rtol=FLOAT64_ROUNDING)
    with pytest.raises(ValueError, match="read-only"):
        BASIS[0, 0] = 0.5


def test_basis_stays_close_to_the_published_one(colour):
    published = colour.recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    rows = np.searchsorted(BASIS_WAVELENGTHS_NM, published.wavelengths)
    # The correction that makes colours exact at 1 nm moves the 5 nm curves by less than a thousandth.
    np.testing.assert_allclose(BASIS[:, rows], published.values.T, rtol=0, atol=1e-3)


def test_uplift_is_linear():
    one, two = np.array([0.1, 0.5, 0.3]), np.array([0.6, 0.2, 0.4])
    np.testing.assert_allclose(
        uplift_values(0.3 * one + 0.5 * two), 0.3 * uplift_values(one) + 0.5 * uplift_values(two), rtol=FLOAT64_ROUNDING
    )
    assert uplift_values(np.zeros((4, 5, 3))).shape == (4, 5, 471)
    for spectrum, curve in zip(basis_spectra(), BASIS, strict=True):
        np.testing.assert_array_equal(spectrum.values, curve)


def test_greys_are_exactly_constant():
    assert uplift([0.18, 0.18, 0.18]).is_constant
    assert uplift([0.18, 0.18, 0.18], "grey").name == "grey"
    assert uplift([0.2, 0.4, 0.6]).name == "sRGB 0.2 0.4 0.6"


@pytest.mark.parametrize("rgb", [[-0.1, 0.2, 0.3], [np.nan, 0, 0], [0.1, 0.2], [[0.1, 0.2, 0.3]]])
def test_bad_colours_are_refused(rgb):
    with pytest.raises(InvalidParameterError, match="rgb_linear"):
        uplift(rgb)
