"""Tristimulus values, weighting tables, Lab, differences and adaptation against colour-science."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.colorimetry import (
    ADAPTATIONS,
    GRID_PRESETS,
    OBSERVERS,
    Observer,
    WavelengthGrid,
    chromatic_adaptation,
    delta_e_2000,
    lab,
    observer,
    tristimulus,
    tristimulus_from_xy,
    tristimulus_weights,
    uv,
    wavelength_grid,
    white_point,
    xy,
)
from spectral_core.errors import InvalidParameterError
from spectral_core.library import illuminant, illuminant_names, reflectance
from spectral_core.spectra import REFERENCE_WAVELENGTHS_NM, Spectrum, blackbody, gaussian
from spectral_core.tables import table_names
from tests.tolerances import ASTM_WEIGHTS, FLOAT64_ROUNDING, SUM_OF_HUNDREDS, TRISTIMULUS_SUM

COLOURCHECKER = tuple(name.partition("/")[2] for name in table_names("reflectance"))
KEYS = {
    "cie_1931_2": "CIE 1931 2 Degree Standard Observer",
    "cie_1964_10": "CIE 1964 10 Degree Standard Observer",
}
EXACT = wavelength_grid("exact")


def sampled(colour, spectrum):
    """A spectrum at 1 nm for colour-science, so that both integrate the same samples."""
    return colour.SpectralDistribution(spectrum.at(REFERENCE_WAVELENGTHS_NM), REFERENCE_WAVELENGTHS_NM)


@pytest.mark.parametrize("name", OBSERVERS)
def test_observers_are_those_of_the_cie(colour, name):
    expected = colour.MSDS_CMFS[KEYS[name]]
    np.testing.assert_array_equal(observer(name).wavelengths_nm, expected.wavelengths)
    np.testing.assert_array_equal(observer(name).matching_functions, expected.values)
    # The functions are normalised to the equal-energy white; the CIE's own smoothing leaves them 3.3e-4 apart.
    sums = observer(name).matching_functions.sum(axis=0)
    np.testing.assert_allclose(sums, sums[1], rtol=4e-4)


@pytest.mark.parametrize("lamp", ["A", "D65", "FL2"])
@pytest.mark.parametrize("watcher", OBSERVERS)
def test_colorchecker_equals_colour_science(colour, lamp, watcher):
    light = illuminant(lamp)
    weights = tristimulus_weights(light, observer(watcher), EXACT)
    assert len(COLOURCHECKER) == 24
    for patch in COLOURCHECKER:
        paint = reflectance(patch)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it says that it interpolates, where there is nothing to interpolate
            expected = colour.colorimetry.sd_to_XYZ_integration(
                sampled(colour, paint), colour.MSDS_CMFS[KEYS[watcher]], sampled(colour, light)
            )
        got = 100.0 * paint.at(REFERENCE_WAVELENGTHS_NM) @ weights
        np.testing.assert_allclose(got, expected, rtol=TRISTIMULUS_SUM, err_msg=patch)
        np.testing.assert_allclose(100.0 * tristimulus(paint, light, observer(watcher)), expected, rtol=TRISTIMULUS_SUM)


@pytest.mark.parametrize("lamp", ["A", "D65", "FL2", "HP1"])
@pytest.mark.parametrize(("step", "end"), [(10, 830), (20, 820)])
def test_lagrange_table_equals_astm_e2022(colour, lamp, step, end):
    # Where the nodes end before 830 nm, colour-science ends the integral and we hold the end value: compare without
    # light beyond the nodes.
    power = np.where(end >= REFERENCE_WAVELENGTHS_NM, illuminant(lamp).at(REFERENCE_WAVELENGTHS_NM), 0.0)
    nodes = np.arange(360.0, end + 1.0, step)
    weights = tristimulus_weights(
        Spectrum(REFERENCE_WAVELENGTHS_NM, power), observer("cie_1931_2"), WavelengthGrid("astm", nodes, "lagrange")
    )
    inside = end >= REFERENCE_WAVELENGTHS_NM
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = colour.colorimetry.tristimulus_weighting_factors_ASTME2022(
            colour.MSDS_CMFS[KEYS["cie_1931_2"]].copy().align(colour.SpectralShape(360, end, 1)),
            colour.SpectralDistribution(power[inside], REFERENCE_WAVELENGTHS_NM[inside]),
            colour.SpectralShape(360, end, step),
        )
    np.testing.assert_allclose(weights, expected / 100.0, rtol=0, atol=ASTM_WEIGHTS)


@pytest.mark.parametrize("preset", GRID_PRESETS)
@pytest.mark.parametrize("lamp", ["D65", "FL11", "HP1", "sodium-low-pressure"])
def test_every_table_is_exact_for_constants(preset, lamp):
    grid = wavelength_grid(preset)
    weights = tristimulus_weights(illuminant(lamp), observer("cie_1931_2"), grid)
    assert weights.shape == (grid.wavelengths_nm.size, 3)
    assert weights.dtype == np.float64
    white = white_point(illuminant(lamp), observer("cie_1931_2"))
    np.testing.assert_allclose(weights.sum(axis=0), white, rtol=SUM_OF_HUNDREDS)
    assert white[1] == pytest.approx(1.0, rel=SUM_OF_HUNDREDS)


@pytest.mark.parametrize(("preset", "degree"), [("reference", 3), ("paper", 3), ("high", 1), ("standard", 1)])
def test_tables_integrate_what_their_interpolation_reproduces(preset, degree):
    grid = wavelength_grid(preset)
    nodes = grid.wavelengths_nm
    # A lamp that shines only where the four-point formula holds, between the second and the last but one node.
    inside = (nodes[1] <= REFERENCE_WAVELENGTHS_NM) & (nodes[-2] >= REFERENCE_WAVELENGTHS_NM)
    lamp = Spectrum(REFERENCE_WAVELENGTHS_NM, inside.astype(float))

    def polynomial(wavelengths):
        return ((wavelengths - 550.0) / 200.0) ** degree

    for watcher in map(observer, OBSERVERS):
        direct = polynomial(REFERENCE_WAVELENGTHS_NM) @ tristimulus_weights(lamp, watcher, EXACT)
        table = polynomial(nodes) @ tristimulus_weights(lamp, watcher, grid)
        np.testing.assert_allclose(table, direct, rtol=0, atol=SUM_OF_HUNDREDS)


def test_weights_keep_their_negative_values():
    weights = tristimulus_weights(illuminant("HP1"), observer("cie_1931_2"), wavelength_grid("standard"))
    assert weights.min() < -1e-3


@pytest.mark.parametrize("centre", [435.83, 546.07, 589.29, 632.816])
@pytest.mark.parametrize("width", [1e-3, 0.02, 0.3])
def test_a_line_has_the_chromaticity_of_its_wavelength(centre, width):
    line = gaussian(centre, width)
    functions = observer("cie_1931_2").matching_functions
    expected = [np.interp(centre, REFERENCE_WAVELENGTHS_NM, functions[:, i]) for i in range(3)]
    got = white_point(line, observer("cie_1931_2"))
    # Straight lines between the 1 nm samples of the observer, over a line a fraction of a nm wide: curvature of the
    # functions at the corner times the width.
    np.testing.assert_allclose(xy(got), xy(expected), rtol=0, atol=1e-6 + 3e-3 * width)


@pytest.mark.parametrize("preset", ["standard", "draft", "paper"])
def test_a_line_beside_the_nodes_is_not_missed(preset):
    lamp = Spectrum([560.0, 588.9, 589.0, 589.1, 620.0], [1e-6, 1e-6, 1.0, 1e-6, 1e-6])
    weights = tristimulus_weights(lamp, observer("cie_1931_2"), wavelength_grid(preset))
    np.testing.assert_allclose(weights.sum(axis=0), white_point(lamp, observer("cie_1931_2")), rtol=SUM_OF_HUNDREDS)


@given(
    st.lists(st.tuples(st.floats(380.0, 780.0), st.sampled_from([0.0, 5e-324, 1e-300, 0.5, 1.0, 1e100])),
             min_size=1, max_size=8, unique_by=lambda s: round(s[0], 2)),
    st.sampled_from(GRID_PRESETS),
    st.sampled_from(OBSERVERS),
)  # fmt: skip
def test_any_lamp_gives_finite_weights_or_a_named_error(samples, preset, watcher):
    lamp = Spectrum(*np.array(sorted(samples)).T)
    if not lamp.values.any():
        with pytest.raises(InvalidParameterError, match="must emit"):
            tristimulus_weights(lamp, observer(watcher), wavelength_grid(preset))
        return
    weights = tristimulus_weights(lamp, observer(watcher), wavelength_grid(preset))
    assert np.isfinite(weights).all()
    assert weights[:, 1].sum() == pytest.approx(1.0, rel=1e-10)  # spline weights of both signs cancel


@given(st.floats(1e-300, 1e99))
def test_the_scale_of_a_lamp_does_not_count(scale):
    lamp = illuminant("LED-B3")
    scaled = lamp.scaled(scale / lamp.values.max())
    np.testing.assert_allclose(
        white_point(scaled, observer("cie_1931_2")), white_point(lamp, observer("cie_1931_2")), rtol=SUM_OF_HUNDREDS
    )


def test_lamps_without_visible_light_are_refused():
    with pytest.raises(InvalidParameterError, match="dark emits none"):
        white_point(Spectrum.constant(0.0, "dark"), observer("cie_1931_2"))
    infrared = Spectrum([800.0, 900.0, 1000.0], [0.0, 0.0, 1.0], "heater")
    with pytest.raises(InvalidParameterError, match="heater emits none"):
        white_point(infrared, observer("cie_1931_2"))
    # The 1964 observer sees nothing at 360 nm to the table's precision; the 1931 one 4e-6.
    blind = Observer("blind", REFERENCE_WAVELENGTHS_NM, np.zeros((471, 3)))
    with pytest.raises(InvalidParameterError, match="Y of D65 is 0"):
        white_point(illuminant("D65"), blind)


@pytest.mark.parametrize(
    ("name", "expected"),
    [  # CIE 15:2018, tables T.3, T.8.1: chromaticity for the 1931 observer, rounded in the last place
        ("A", (0.44758, 0.40745)),
        ("D65", (0.31272, 0.32903)),
        ("C", (0.31006, 0.31616)),
        ("D50", (0.34567, 0.35851)),
        ("D55", (0.33243, 0.34744)),
        ("D75", (0.29903, 0.31488)),
        ("FL2", (0.3721, 0.3751)),
        ("FL11", (0.3805, 0.3769)),
        ("HP1", (0.5330, 0.4150)),
        ("LED-B3", (0.3756, 0.3723)),
        ("E", (1 / 3, 1 / 3)),
    ],
)
def test_chromaticities_published_by_the_cie(name, expected):
    watcher, lamp = observer("cie_1931_2"), illuminant(name)
    # The CIE sums its 5 nm tables at 5 nm: the tables are right when that gives the published figures as rounded.
    nodes = np.arange(380.0, 781.0, 5.0)
    by_five = lamp.at(nodes) @ watcher.matching_functions[np.searchsorted(REFERENCE_WAVELENGTHS_NM, nodes)]
    np.testing.assert_allclose(xy(by_five), expected, rtol=0, atol=6e-5)
    # Sums at 1 nm over the same tables, joined by straight lines, weigh a lamp's lines with the observer's curvature.
    np.testing.assert_allclose(xy(white_point(lamp, watcher)), expected, rtol=0, atol=3e-4)


def test_lab_and_difference_equal_colour_science(colour):
    rng = np.random.default_rng(3)
    white = white_point(illuminant("D50"), observer("cie_1931_2"))
    xyz = np.concatenate([rng.uniform(0.0, 1.2, (400, 3)), rng.uniform(0.0, 0.01, (100, 3)), np.zeros((1, 3))]) * white
    expected = colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(white))
    got = lab(xyz, white)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e3 * FLOAT64_ROUNDING)
    first, second = got[:-1], got[1:]
    np.testing.assert_allclose(
        delta_e_2000(first, second), colour.difference.delta_E_CIE2000(first, second), rtol=0, atol=1e-10
    )  # hues pass through degrees and radians


# Sharma, Wu and Dalal 2005, table 1: the pairs that separate right from wrong implementations, to four decimals.
SHARMA = np.array([
    [50, 2.6772, -79.7751, 50, 0, -82.7485, 2.0425], [50, 3.1571, -77.2803, 50, 0, -82.7485, 2.8615],
    [50, 2.8361, -74.02, 50, 0, -82.7485, 3.4412], [50, -1.3802, -84.2814, 50, 0, -82.7485, 1.0],
    [50, -1.1848, -84.8006, 50, 0, -82.7485, 1.0], [50, -0.9009, -85.5211, 50, 0, -82.7485, 1.0],
    [50, 0, 0, 50, -1, 2, 2.3669], [50, -1, 2, 50, 0, 0, 2.3669], [50, 2.49, -0.001, 50, -2.49, 0.0009, 7.1792],
    [50, 2.49, -0.001, 50, -2.49, 0.001, 7.1792], [50, 2.49, -0.001, 50, -2.49, 0.0011, 7.2195],
    [50, 2.49, -0.001, 50, -2.49, 0.0012, 7.2195], [50, -0.001, 2.49, 50, 0.0009, -2.49, 4.8045],
    [50, -0.001, 2.49, 50, 0.001, -2.49, 4.8045], [50, -0.001, 2.49, 50, 0.0011, -2.49, 4.7461],
    [50, 2.5, 0, 50, 0, -2.5, 4.3065], [50, 2.5, 0, 73, 25, -18, 27.1492], [50, 2.5, 0, 61, -5, 29, 22.8977],
    [50, 2.5, 0, 56, -27, -3, 31.903], [50, 2.5, 0, 58, 24, 15, 19.4535], [50, 2.5, 0, 50, 3.1736, 0.5854, 1.0],
    [50, 2.5, 0, 50, 3.2972, 0, 1.0], [50, 2.5, 0, 50, 1.8634, 0.5757, 1.0], [50, 2.5, 0, 50, 3.2592, 0.335, 1.0],
    [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
    [63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.263],
    [61.2901, 3.7196, -5.3901, 61.4292, 2.248, -4.962, 1.8731],
    [35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645],
    [22.7233, 20.0904, -46.694, 23.0331, 14.973, -42.5619, 2.0373],
    [36.4612, 47.858, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146],
    [90.8027, -2.0831, 1.441, 91.1528, -1.6435, 0.0447, 1.4441],
    [90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381],
    [6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377],
    [2.0776, 0.0795, -1.135, 0.9033, -0.0636, -0.5514, 0.9082],
])  # fmt: skip


def test_difference_of_the_published_pairs():
    np.testing.assert_allclose(delta_e_2000(SHARMA[:, :3], SHARMA[:, 3:6]), SHARMA[:, 6], rtol=0, atol=5.1e-5)
    np.testing.assert_allclose(delta_e_2000(SHARMA[:, 3:6], SHARMA[:, :3]), SHARMA[:, 6], rtol=0, atol=5.1e-5)
    assert (delta_e_2000(SHARMA[:, :3], SHARMA[:, :3]) == 0.0).all()


def test_lab_of_anchors_and_below_zero():
    white = np.array([0.9505, 1.0, 1.089])
    np.testing.assert_allclose(lab([[0.0, 0.0, 0.0], white], white), [[0, 0, 0], [100, 0, 0]], rtol=0, atol=1e-13)
    edge = (6 / 29) ** 3
    around = lab(np.array([[edge * (1 - 1e-12)] * 3, [edge * (1 + 1e-12)] * 3]) * white, white)
    assert abs(around[0, 0] - around[1, 0]) < 1e-9  # no jump where the cube root begins
    assert lab([-1e-4, -1e-4, -1e-4] * white, white)[0] == pytest.approx(-1e-4 * 116 * (29 / 6) ** 2 / 3)
    with pytest.raises(InvalidParameterError, match="white must be positive"):
        lab([0.1, 0.1, 0.1], [0.9, 0.0, 1.0])
    with pytest.raises(InvalidParameterError, match="three values"):
        lab([0.1, 0.1], white)
    with pytest.raises(InvalidParameterError, match="finite"):
        lab([0.1, np.nan, 0.1], white)


@pytest.mark.parametrize(("method", "key"), [("bradford", "Bradford"), ("cat16", "CAT16")])
@pytest.mark.parametrize("lamp", ["A", "D50", "FL2", "projector-halogen"])
def test_adaptation_equals_colour_science(colour, method, key, lamp):
    source = white_point(illuminant(lamp), observer("cie_1931_2"))
    target = white_point(illuminant("D65"), observer("cie_1931_2"))
    matrix = chromatic_adaptation(source, target, method)
    expected = colour.adaptation.matrix_chromatic_adaptation_VonKries(source, target, transform=key)
    np.testing.assert_allclose(matrix, expected, rtol=0, atol=1e2 * FLOAT64_ROUNDING)
    np.testing.assert_allclose(matrix @ source, target, rtol=0, atol=1e2 * FLOAT64_ROUNDING)


@pytest.mark.parametrize("method", ADAPTATIONS)
def test_adaptation_to_the_same_white_is_nothing(method):
    white = white_point(illuminant("FL7"), observer("cie_1964_10"))
    np.testing.assert_allclose(chromatic_adaptation(white, white, method), np.eye(3), rtol=0, atol=FLOAT64_ROUNDING)


def test_adaptation_errors():
    with pytest.raises(InvalidParameterError, match="adaptation must be one of"):
        chromatic_adaptation([1, 1, 1], [1, 1, 1], "wrong")
    # Low-pressure sodium lies outside the cone triangle of Bradford, where its blue response is negative; not of CAT16.
    sodium = white_point(illuminant("sodium-low-pressure"), observer("cie_1931_2"))
    with pytest.raises(InvalidParameterError, match="positive bradford cone responses"):
        chromatic_adaptation(sodium, [0.95, 1.0, 1.09], "bradford")
    assert np.isfinite(chromatic_adaptation(sodium, [0.95, 1.0, 1.09], "cat16")).all()
    with pytest.raises(InvalidParameterError, match="source_white"):
        chromatic_adaptation([[1, 1, 1]], [1, 1, 1])


def test_chromaticity_equals_colour_science(colour):
    xyz = np.random.default_rng(8).uniform(0.01, 1.0, (4, 5, 3))
    np.testing.assert_allclose(xy(xyz), colour.XYZ_to_xy(xyz), rtol=FLOAT64_ROUNDING)
    np.testing.assert_allclose(uv(xyz), colour.Luv_to_uv(colour.XYZ_to_Luv(xyz)), rtol=0, atol=1e-9)  # by way of Luv
    np.testing.assert_allclose(tristimulus_from_xy(xy(xyz), xyz[..., 1]), xyz, rtol=1e2 * FLOAT64_ROUNDING)
    assert np.isnan(xy([0.0, 0.0, 0.0])).all()
    assert np.isnan(uv([0.0, 0.0, 0.0])).all()
    with pytest.raises(InvalidParameterError, match="y other than 0"):
        tristimulus_from_xy([0.7, 0.0])
    with pytest.raises(InvalidParameterError, match="two values"):
        tristimulus_from_xy([0.7, 0.2, 0.1])


def test_blackbody_lies_on_the_planckian_locus(colour):
    for temperature in (1500.0, 2856.0, 5000.0, 20000.0):
        got = uv(white_point(blackbody(temperature), observer("cie_1931_2")))
        expected = colour.temperature.CCT_to_uv(np.array([temperature, 0.0]), method="Ohno 2013")
        # CIE 1960 v is 2/3 of 1976 v'; Ohno's method interpolates a table.
        np.testing.assert_allclose(got * [1.0, 2.0 / 3.0], expected, rtol=0, atol=2e-5)


def test_names_and_grids_are_checked():
    with pytest.raises(InvalidParameterError, match="observer must be one of cie_1931_2"):
        observer("cie_2015")
    with pytest.raises(InvalidParameterError, match="grid must be one of exact"):
        wavelength_grid("rgb")
    with pytest.raises(InvalidParameterError, match="method"):
        WavelengthGrid("mine", [400.0, 500.0], "cubic")
    with pytest.raises(InvalidParameterError, match="increases strictly"):
        WavelengthGrid("mine", [500.0, 400.0], "linear")
    with pytest.raises(InvalidParameterError, match="'exact' of grid 'mine' needs 360 to 830"):
        WavelengthGrid("mine", [400.0, 500.0], "exact")
    with pytest.raises(InvalidParameterError, match=r"shape \(471, 3\)"):
        Observer("mine", REFERENCE_WAVELENGTHS_NM, np.zeros((471, 4)))
    with pytest.raises(InvalidParameterError, match="360 to 830"):
        Observer("mine", REFERENCE_WAVELENGTHS_NM[1:], np.zeros((470, 3)))


def test_every_lamp_of_the_library_has_a_white():
    for name in illuminant_names():
        for watcher in OBSERVERS:
            white = white_point(illuminant(name), observer(watcher))
            assert np.isfinite(white).all()
            assert (white[:2] > 0.0).all()
            assert white[2] > 0.0 or name == "sodium-low-pressure"  # z is 0 at its one line


def test_colour_differences_of_huge_chroma_are_finite():
    # Far beyond any colour C^7 / (C^7 + 25^7) is 1; its power alone would pass the largest float at C = 1e44.
    found = delta_e_2000([50.0, 1e50, 0.0], [50.0, 1e50, 0.0])
    assert found == 0.0
    assert np.isfinite(delta_e_2000([50.0, 1e50, 0.0], [50.0, 2.0, 3.0]))
