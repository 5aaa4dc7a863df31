"""Write the tables of the documents into their pages, between markers.

    python -m tools.document_tables [--timed]

A table stands between ``<!-- generated: NAME -->`` and ``<!-- end of NAME -->``. Those that are the same on every
machine are made anew, and compared by the tests; with --timed also those that hold times, with their plots (some
minutes).
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import spectral_core as sc
from spectral_core.reflection import attenuation_at_angle
from tools import measure_grids

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"

__all__ = ["TABLES", "TIMED", "between", "main", "replaced"]


def half_heights() -> str:
    """The angle from the mirror direction at which f(rho) is one half, in degrees."""
    lines = [
        f"| n | {' | '.join(sc.ATTENUATIONS)} |",
        f"| --- |{' --- |' * len(sc.ATTENUATIONS)}",
    ]
    rho = np.radians(np.linspace(0.0, 90.0, 90_001))
    for n in (1, 5, 10, 11, 25, 60, 200, 1000):
        cells = []
        for law in sc.ATTENUATIONS:
            below = np.flatnonzero(attenuation_at_angle(law, n, rho) < 0.5)
            cells.append(f"{np.degrees(rho[below[0]]):.1f}°" if below.size else "beyond 90°")
        lines.append(f"| {n} | {' | '.join(cells)} |")
    return "\n".join(lines)


def library_of(names: tuple[str, ...]) -> str:
    """Names of the library with their sources, those of one source in a row."""
    sources: dict[str, list[str]] = {}
    for name in names:
        sources.setdefault(sc.source_of(name), []).append(name)
    lines = ["| names | source |", "| --- | --- |"]
    lines += [f"| {', '.join(f'`{name}`' for name in names)} | {source} |" for source, names in sources.items()]
    return "\n".join(lines)


def tradeoff_of(sample: str) -> str:
    """What accuracy costs in a sample file, as `dichromatic tradeoff` prints it; the plot goes to docs/images."""
    plot = DOCS / "images" / f"tradeoff_{sample}.png"
    command = ["tradeoff", f"sample_blends/{sample}.blend", "--size", "320x180", "--plot"]
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / plot.name
        done = subprocess.run(
            [sys.executable, "-m", "dichromatic_addon", *command, str(drawn)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        plot.write_bytes(drawn.read_bytes())
    printed = [line for line in done.stdout.splitlines() if line and not line.startswith("Read blend")]
    printed = [line for line in printed if not line.endswith("written")]
    return "\n".join(["```text", *printed, "```"])


TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "grids": ("accuracy.md", measure_grids.table),
    "half heights": ("manual/material.md", half_heights),
    "illuminants": ("library.md", lambda: library_of(sc.illuminant_names())),
    "reflectances": ("library.md", lambda: library_of(sc.reflectance_names())),
    "metals": ("library.md", lambda: library_of(sc.metal_names())),
}
TIMED: dict[str, tuple[str, Callable[[], str]]] = {
    f"trade-off of {sample}": ("accuracy.md", lambda sample=sample: tradeoff_of(sample))
    for sample in ("cups", "metal_balls")
}


def between(text: str, name: str) -> str:
    """What stands between the markers of a table."""
    found = re.search(
        rf"<!-- generated: {re.escape(name)} -->\n(.*?)<!-- end of {re.escape(name)} -->", text, re.DOTALL
    )
    if not found:
        raise ValueError(f"there are no markers of the table {name!r}")
    return found[1]


def replaced(text: str, name: str, table: str) -> str:
    """The text of a page with a new table between the markers."""
    old = between(text, name)
    head = f"<!-- generated: {name} -->\n"
    return text.replace(head + old, f"{head}\n{table}\n\n", 1)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Write the tables of the documents.")
    parser.add_argument("--timed", action="store_true", help="also those that hold times")
    timed = parser.parse_args(arguments).timed
    for name, (page, make) in (TABLES | (TIMED if timed else {})).items():
        path = DOCS / page
        text = path.read_text(encoding="utf-8")
        path.write_text(replaced(text, name, make()), encoding="utf-8")
        print(f"docs/{page}: {name}")


if __name__ == "__main__":
    main()
