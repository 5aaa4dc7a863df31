"""Extract the colorimetric tables of the package from colour-science (run at development time only).

    python tools/extract_tables.py [--output spectral_core/data]

Writes ``colorimetry.npz`` and ``colorimetry.json``, the latter with the source of every table. The package itself
never imports colour-science: it is large, slow to import and puts substitutes into ``sys.modules``.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import numpy as np
from table_archive import write_archive, write_provenance

with warnings.catch_warnings():
    # colour-science warns about every optional library that is absent; none of them is used here.
    warnings.simplefilter("ignore")
    import colour
    from colour.colorimetry import SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    from colour.quality.datasets import SDS_TCS
    from colour.recovery import MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019

LICENCE = "colour-science is BSD-3-Clause; the figures themselves are published facts"
OBSERVERS = {
    "cie_1931_2": ("CIE 1931 2 Degree Standard Observer", "CIE 1931 2 deg observer, ISO/CIE 11664-1:2019"),
    "cie_1964_10": ("CIE 1964 10 Degree Standard Observer", "CIE 1964 10 deg observer, ISO/CIE 11664-1:2019"),
}
CIE_ILLUMINANTS = (
    *("B", "C", "D50", "D55", "D65", "D75", "ID50", "ID65"),
    *(f"FL{i}" for i in range(1, 13)),
    *(f"FL3.{i}" for i in range(1, 16)),
    *(f"HP{i}" for i in range(1, 6)),
    *("LED-B1", "LED-B2", "LED-B3", "LED-B4", "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"),
)
LIGHT_SOURCES = {
    "sodium-low-pressure": "LPS",
    "sodium-high-pressure": "HPS",
    "mercury": "Mercury",
    "metal-halide": "Metal Halide",
    "neodymium-incandescent": "Neodimium Incandescent",
    "projector-xenon": "Kinoton 75P",
}
ISO_7589 = {"studio-tungsten": "ISO 7589 Studio Tungsten", "photoflood": "ISO 7589 Photoflood"}
DAYLIGHT_TEMPERATURES = {"D50": 5000.0, "D55": 5500.0, "D65": 6500.0, "D75": 7500.0}


def stacked(distribution: object) -> np.ndarray:
    """Wavelengths on the first row, the curve or curves below."""
    values = np.asarray(distribution.values, dtype=np.float64)
    return np.vstack([distribution.wavelengths, values.T if values.ndim == 2 else values[None]])


def with_daylight_tail(name: str, stored: np.ndarray) -> np.ndarray:
    """Continue a D illuminant from 780 to 830 nm by the formula that defines it (colour stores it to 780 nm)."""
    temperature = DAYLIGHT_TEMPERATURES[name] * 1.4388 / 1.4380
    xy = colour.temperature.CCT_to_xy_CIE_D(temperature)
    formula = stacked(colour.sd_CIE_illuminant_D_series(xy))
    tail = formula[:, formula[0] > stored[0, -1]]
    return np.hstack([stored, tail])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = Path(__file__).resolve().parents[1] / "spectral_core" / "data"
    parser.add_argument("--output", type=Path, default=default, help="folder to write to")
    folder = parser.parse_args().output

    tables: dict[str, np.ndarray] = {}
    sources: dict[str, dict[str, object]] = {}

    def add(name: str, array: np.ndarray, key: str, source: str, note: str = "") -> None:
        if name in tables:
            raise SystemExit(f"{name} would be stored twice")
        if not np.isfinite(array).all() or np.any(np.diff(array[0]) <= 0):
            raise SystemExit(f"{name} from {key} is not finite or not in order")
        tables[name] = array
        entry: dict[str, object] = {
            "colour_science_key": key,
            "source": source,
            "range_nm": [float(array[0, 0]), float(array[0, -1])],
            "step_nm": float(array[0, 1] - array[0, 0]),
        }
        if note:
            entry["note"] = note
        sources[name] = entry

    for name, (key, source) in OBSERVERS.items():
        add(f"observer/{name}", stacked(colour.MSDS_CMFS[key]), f"MSDS_CMFS[{key!r}]", source)

    series = SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    curves = [stacked(series[name]) for name in ("S0", "S1", "S2")]
    add(
        "daylight/S",
        np.vstack([curves[0][0], *(curve[1] for curve in curves)]),
        "SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES",
        "CIE 15:2004, appendix C: S0, S1, S2 of daylight",
    )
    for name in CIE_ILLUMINANTS:
        array = stacked(colour.SDS_ILLUMINANTS[name])
        note = ""
        if name in DAYLIGHT_TEMPERATURES:
            array = with_daylight_tail(name, array)
            note = "785 to 830 nm by the D-series formula at the nominal temperature times 1.4388 / 1.4380"
        add(f"illuminant/{name}", array, f"SDS_ILLUMINANTS[{name!r}]", "CIE 15:2018 illuminant tables", note)
    for name, key in LIGHT_SOURCES.items():
        source = "NIST spreadsheet of Ohno and Davis (2008)" if key != "Kinoton 75P" else "House (2006), measured"
        add(f"illuminant/{name}", stacked(colour.SDS_LIGHT_SOURCES[key]), f"SDS_LIGHT_SOURCES[{key!r}]", source)
    for name, key in ISO_7589.items():
        add(f"iso7589/{name}", stacked(colour.SDS_ILLUMINANTS[key]), f"SDS_ILLUMINANTS[{key!r}]", "ISO 7589:2002")

    for patch, distribution in colour.SDS_COLOURCHECKERS["ColorChecker N Ohta"].items():
        name = patch.partition(" (")[0]
        add(
            f"reflectance/{name}",
            stacked(distribution),
            f"SDS_COLOURCHECKERS['ColorChecker N Ohta'][{patch!r}]",
            "ColorChecker chart, measured by N. Ohta (1997)",
        )
    for name, distribution in SDS_TCS["CIE 1995"].items():
        add(
            f"test_colour/{name}",
            stacked(distribution),
            f"quality.datasets.SDS_TCS['CIE 1995'][{name!r}]",
            "CIE 13.3-1995 test-colour samples (Munsell papers and simulated skin and leaf)",
        )
    add(
        "basis/mallett_2019",
        stacked(MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019),
        "recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019",
        "Mallett and Yuksel, Spectral Primary Decomposition for Rendering with sRGB Reflectance, EGSR 2019",
    )

    folder.mkdir(parents=True, exist_ok=True)
    write_archive(folder / "colorimetry.npz", tables)
    about = (
        f"Extracted from colour-science {colour.__version__} by tools/extract_tables.py. {LICENCE}. "
        "First row wavelengths in nm, then one row a curve."
    )
    write_provenance(folder / "colorimetry.json", about, sources)
    size = (folder / "colorimetry.npz").stat().st_size
    print(f"{len(tables)} tables, {size / 1000:.1f} kB, in {folder / 'colorimetry.npz'}")


if __name__ == "__main__":
    main()
