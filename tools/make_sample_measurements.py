"""Make the sample data sets of docs/fitting.md: synthetic measurements, made with the material classes and 1 % noise.

Run ``python tools/make_sample_measurements.py`` to write docs/data again; the same seed gives the same files.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from spectral_core.fitting import MeasurementGeometry, Measurements, write_measurements  # noqa: E402
from spectral_core.library import optical_constants  # noqa: E402
from spectral_core.reflection import TypeI, TypeII, TypeIII  # noqa: E402
from spectral_core.spectra import Spectrum  # noqa: E402

WAVELENGTHS_NM = np.arange(400.0, 701.0, 10.0)
NOISE = 0.01
DIGITS = 6


def red_paint() -> Spectrum:
    return Spectrum(WAVELENGTHS_NM, 0.04 + 0.62 / (1.0 + np.exp((595.0 - WAVELENGTHS_NM) / 14.0)), "red")


def green_dye() -> Spectrum:
    return Spectrum(WAVELENGTHS_NM, 0.05 + 0.30 * np.exp(-(((WAVELENGTHS_NM - 525.0) / 38.0) ** 2)), "green")


def satin_sheen() -> Spectrum:
    return Spectrum(WAVELENGTHS_NM, 0.75 + 0.35 * np.sin((WAVELENGTHS_NM - 430.0) / 90.0), "sheen")


def samples() -> dict[str, tuple[str, TypeI | TypeII | TypeIII, MeasurementGeometry]]:
    """File name, what it is, material and geometry of each sample."""
    around = np.array([-10, 0, 10, 20, 27, 32, 35, 38, 41, 43, 45, 47, 50, 55, 60], dtype=float)
    fixed = MeasurementGeometry.from_degrees(np.full(around.size, 45.0), around)
    pairs = [(i, i + d) for i in (10, 30, 50, 65, 75) for d in (-8, -4, 0, 4)]
    metal = MeasurementGeometry.from_degrees(*np.array(pairs, dtype=float).T)
    return {
        "plastic.csv": (
            "red plastic: Type I, f = cos(rho)^11, S_I = 0.9",
            TypeI(red_paint(), 0.9, "cosine", 11.0),
            fixed,
        ),
        "satin.csv": (
            "green satin: Type II, f = exp(-10 rho)",
            TypeII(green_dye(), satin_sheen(), "exponential", 10.0),
            fixed,
        ),
        "copper.csv": (
            "copper: Type III, beta = 5 degrees, S_I and Sa(phi) from the optical constants of the library",
            TypeIII.from_optical_constants(optical_constants("copper"), np.radians(5.0)),
            metal,
        ),
    }


def measure(
    material: TypeI | TypeII | TypeIII, geometry: MeasurementGeometry, name: str, rng: np.random.Generator
) -> Measurements:
    """Radiance factors against a perfect diffuser lit in the same way, with noise in proportion, rounded."""
    values = material.radiance_factor(
        geometry.normal(), geometry.to_light(), geometry.to_viewer(), WAVELENGTHS_NM, geometry.tangent()
    )
    values = values / np.cos(geometry.incidence)[:, None] * (1.0 + NOISE * rng.standard_normal(values.shape))
    rounded = np.array([[float(f"{v:.{DIGITS}g}") for v in row] for row in values])
    return Measurements(WAVELENGTHS_NM, rounded, geometry, "diffuser", name)


def write_all(folder: Path) -> None:
    """Write the three files into a folder."""
    rng = np.random.default_rng(1996)
    for file, (what, material, geometry) in samples().items():
        comment = (
            f"SYNTHETIC measurements of {what}\n"
            f"made by tools/make_sample_measurements.py with {100 * NOISE:g} % of noise on every value\n"
            "rows are wavelengths in nm; columns are spectra; angles in degrees, see docs/fitting.md"
        )
        write_measurements(folder / file, measure(material, geometry, Path(file).stem, rng), comment)


if __name__ == "__main__":
    write_all(ROOT / "docs" / "data")
