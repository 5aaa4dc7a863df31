"""Convert refractiveindex.info files of n and k to the package's table of metals (run at development time only).

    python tools/convert_optical_constants.py FOLDER [--output spectral_core/data]

FOLDER holds the database's YAML files (public domain, CC0 1.0) under the names ``<shelf>_<book>_nk_<page>.yml``.
Writes ``metals.npz`` and ``metals.json`` with the source, the range and the comment of each.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

import numpy as np
from table_archive import write_archive, write_provenance

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from spectral_core.spectrum_files import read_optical_constants

# The first of a metal is the one that goes by the plain name: recent, evaporated or bulk films of good optical
# quality, tabulated over the whole visible range.
METALS = {
    "copper": "main_Cu_nk_McPeak.yml",
    "copper-johnson": "main_Cu_nk_Johnson.yml",
    "copper-querry": "main_Cu_nk_Querry.yml",
    "copper-babar": "main_Cu_nk_Babar.yml",
    "brass-70-30": "other_alloys_Cu-Zn_nk_Querry-Cu70Zn30.yml",
    "brass-85-15": "other_alloys_Cu-Zn_nk_Querry-Cu85Zn15.yml",
    "brass-90-10": "other_alloys_Cu-Zn_nk_Querry-Cu90Zn10.yml",
    "gold": "main_Au_nk_McPeak.yml",
    "gold-johnson": "main_Au_nk_Johnson.yml",
    "gold-babar": "main_Au_nk_Babar.yml",
    "silver": "main_Ag_nk_McPeak.yml",
    "silver-johnson": "main_Ag_nk_Johnson.yml",
    "aluminium": "main_Al_nk_McPeak.yml",
    "aluminium-rakic": "main_Al_nk_Rakic.yml",
    "aluminium-cheng": "main_Al_nk_Cheng.yml",
}
KEPT_RANGE_NM = (250.0, 1000.0)


def without_markup(text: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", "", text)).strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder with the YAML files")
    default = Path(__file__).resolve().parents[1] / "spectral_core" / "data"
    parser.add_argument("--output", type=Path, default=default, help="folder to write to")
    arguments = parser.parse_args()

    tables: dict[str, np.ndarray] = {}
    sources: dict[str, dict[str, object]] = {}
    for name, filename in METALS.items():
        read = read_optical_constants(arguments.folder / filename, name=name)
        inside = np.flatnonzero((read.wavelengths_nm >= KEPT_RANGE_NM[0]) & (read.wavelengths_nm <= KEPT_RANGE_NM[1]))
        # One sample more on each side, so that the ends of the range are interpolated, not held.
        kept = slice(max(inside[0] - 1, 0), inside[-1] + 2)
        array = np.stack([read.wavelengths_nm, read.n, read.k])[:, kept]
        tables[f"metal/{name}"] = array
        sources[f"metal/{name}"] = {
            "file": filename,
            "source": without_markup(read.source),
            "comment": without_markup(read.comment),
            "range_nm": [float(array[0, 0]), float(array[0, -1])],
            "samples": int(array.shape[1]),
            "full_range_nm": [float(read.wavelengths_nm[0]), float(read.wavelengths_nm[-1])],
        }
    write_archive(arguments.output / "metals.npz", tables)
    about = (
        "Optical constants from the refractiveindex.info database (public domain, CC0 1.0), converted by "
        "tools/convert_optical_constants.py. Rows: wavelength in nm, n, k."
    )
    write_provenance(arguments.output / "metals.json", about, sources)
    size = (arguments.output / "metals.npz").stat().st_size
    print(f"{len(tables)} metals, {size / 1000:.1f} kB, in {arguments.output / 'metals.npz'}")


if __name__ == "__main__":
    main()
