"""The error that each grid of wavelengths makes, against sums at 1 nm: what its name promises, as colour difference."""

from __future__ import annotations

import numpy as np
import pytest

from spectral_core.colorimetry import (
    delta_e_2000,
    lab,
    observer,
    tristimulus_weights,
    wavelength_grid,
    white_point,
)
from spectral_core.library import illuminant, reflectance
from spectral_core.spectra import REFERENCE_WAVELENGTHS_NM, Spectrum
from spectral_core.tables import table, table_names

LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "HP1")
PATCHES = tuple(name.partition("/")[2] for name in table_names("reflectance"))

# Mean and largest Delta E 2000 allowed: one reflectance, and the product of three (light that has bounced twice).
ALLOWED = {
    "draft": ((0.55, 2.3), (0.75, 4.4)),
    "standard": ((0.08, 0.27), (0.09, 0.45)),
    "high": ((0.05, 0.16), (0.05, 0.24)),
    "paper": ((0.04, 0.14), (0.05, 0.22)),
    "reference": ((0.03, 0.14), (0.03, 0.08)),
    "exact": ((0.0, 0.0), (0.0, 0.0)),
}


def differences(preset: str, power: int, interpolation: str) -> np.ndarray:
    """Delta E 2000 (6 lamps, 24 patches) between a grid and the sum at 1 nm."""
    watcher, grid, exact = observer("cie_1931_2"), wavelength_grid(preset), wavelength_grid("exact")
    paints = [Spectrum(*table(f"reflectance/{name}"), interpolation=interpolation) for name in PATCHES]
    fine = np.array([paint.at(REFERENCE_WAVELENGTHS_NM) for paint in paints]) ** power
    coarse = np.array([paint.at(grid.wavelengths_nm) for paint in paints]) ** power
    found = []
    for name in LAMPS:
        lamp = illuminant(name)
        white = white_point(lamp, watcher)
        right = fine @ tristimulus_weights(lamp, watcher, exact)
        got = np.maximum(coarse @ tristimulus_weights(lamp, watcher, grid), 0.0)
        found.append(delta_e_2000(lab(right, white), lab(got, white)))
    return np.array(found)


# Whether the 5 nm samples of the chart are joined by cubics or by straight lines is not for the grid to choose.
@pytest.mark.parametrize("interpolation", ["lagrange", "linear"])
@pytest.mark.parametrize("preset", list(ALLOWED))
def test_presets_hold_their_promise_on_the_colorchecker(preset, interpolation):
    for power, (mean, largest) in zip((1, 3), ALLOWED[preset], strict=True):
        found = differences(preset, power, interpolation)
        assert found.shape == (6, 24)
        assert found.mean() <= mean
        assert found.max() <= largest


def test_more_wavelengths_mean_less_error():
    means = [
        differences(preset, 1, "lagrange").mean() for preset in ("draft", "standard", "high", "paper", "reference")
    ]
    assert means == sorted(means, reverse=True)


def test_a_plain_sum_is_worse_than_the_table():
    """The reason for weighting tables: sums over 10 nm samples of fluorescent light are off by whole steps."""
    watcher = observer("cie_1931_2")
    nodes = np.arange(400.0, 701.0, 10.0)
    rows = np.searchsorted(REFERENCE_WAVELENGTHS_NM, nodes)
    lamp = illuminant("FL11")
    plain = watcher.matching_functions[rows] * lamp.at(nodes)[:, None]
    plain = plain / plain[:, 1].sum()
    paints = np.array([reflectance(name).at(nodes) for name in PATCHES])
    exact = np.array([reflectance(name).at(REFERENCE_WAVELENGTHS_NM) for name in PATCHES])
    white = white_point(lamp, watcher)
    right = lab(exact @ tristimulus_weights(lamp, watcher, wavelength_grid("exact")), white)
    by_sum = delta_e_2000(right, lab(paints @ plain, white)).mean()
    by_table = differences("high", 1, "lagrange")[LAMPS.index("FL11")].mean()
    assert by_sum > 2.0
    assert by_table < 0.1
