"""The scripts that made the shipped tables make the same tables again."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import spectral_core

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(spectral_core.__file__).parent / "data"


def run(*arguments: object) -> None:
    # colour-science warns about absent optional libraries, and must not stop the script where warnings are errors.
    done = subprocess.run(
        [sys.executable, "-W", "ignore", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=200,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )
    assert done.returncode == 0, done.stderr


def assert_same_tables(made: Path, shipped: Path) -> None:
    with np.load(made) as one, np.load(shipped) as two:
        assert one.files == two.files
        for name in one.files:
            # Daylight beyond 780 nm is computed, by a matrix product whose order of summation may differ.
            np.testing.assert_allclose(one[name], two[name], rtol=1e-12, err_msg=name)


def test_extraction_from_colour_science(tmp_path):
    run("tools/extract_tables.py", "--output", tmp_path)
    assert_same_tables(tmp_path / "colorimetry.npz", DATA / "colorimetry.npz")
    made = json.loads((tmp_path / "colorimetry.json").read_text(encoding="utf-8"))["tables"]
    assert made == json.loads((DATA / "colorimetry.json").read_text(encoding="utf-8"))["tables"]


def test_conversion_of_optical_constants(tmp_path):
    """The database's files are not shipped: write the tables in its layout, and convert them again."""
    entries = json.loads((DATA / "metals.json").read_text(encoding="utf-8"))["tables"]
    with np.load(DATA / "metals.npz") as stored:
        for name, entry in entries.items():
            lines = [
                "REFERENCES: |",
                f"    <i>{entry['source']}</i>",
                "COMMENTS: |",
                f"    {entry['comment']}",
                "DATA:",
            ]
            lines += ["  - type: tabulated nk", "    data: |"]
            # Decimal shifts: the database counts in micrometres.
            lines += [f"        {float(w)!r}e-3 {float(n)!r} {float(k)!r}" for w, n, k in stored[name].T]
            (tmp_path / entry["file"]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    run("tools/convert_optical_constants.py", tmp_path, "--output", tmp_path)
    assert_same_tables(tmp_path / "metals.npz", DATA / "metals.npz")
    made = json.loads((tmp_path / "metals.json").read_text(encoding="utf-8"))["tables"]
    for name, entry in entries.items():
        assert {**made[name], "full_range_nm": entry["full_range_nm"]} == entry
