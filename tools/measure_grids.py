"""Measure the colour error of every grid of wavelengths on the ColorChecker, and print it as a table.

    python tools/measure_grids.py

CIE Delta E 2000 against sums at 1 nm (CIE 1931, 2 degrees), mean and largest over 24 patches and the lamps named
below: for a reflectance S, and for S cubed, which stands for light that has bounced twice between equal surfaces.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from spectral_core.colorimetry import (
    GRID_PRESETS,
    delta_e_2000,
    lab,
    observer,
    tristimulus_weights,
    wavelength_grid,
    white_point,
)
from spectral_core.library import illuminant, reflectance
from spectral_core.spectra import REFERENCE_WAVELENGTHS_NM
from spectral_core.tables import table_names

LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "HP1")


def differences(preset: str, power: int) -> np.ndarray:
    """Delta E 2000 (lamps, patches)."""
    watcher, grid, exact = observer("cie_1931_2"), wavelength_grid(preset), wavelength_grid("exact")
    patches = [reflectance(name.partition("/")[2]) for name in table_names("reflectance")]
    fine = np.array([patch.at(REFERENCE_WAVELENGTHS_NM) for patch in patches]) ** power
    coarse = np.array([patch.at(grid.wavelengths_nm) for patch in patches]) ** power
    found = []
    for lamp in map(illuminant, LAMPS):
        white = white_point(lamp, watcher)
        right = fine @ tristimulus_weights(lamp, watcher, exact)
        got = np.maximum(coarse @ tristimulus_weights(lamp, watcher, grid), 0.0)
        found.append(delta_e_2000(lab(right, white), lab(got, white)))
    return np.array(found)


def table() -> str:
    lines = ["| preset | wavelengths | S: mean / max | S cubed: mean / max |", "| --- | --- | --- | --- |"]
    for preset in GRID_PRESETS:
        cells = []
        for power in (1, 3):
            found = differences(preset, power)
            cells.append(f"{found.mean():.3f} / {found.max():.2f}")
        lines.append(f"| {preset} | {wavelength_grid(preset).wavelengths_nm.size} | {cells[0]} | {cells[1]} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
