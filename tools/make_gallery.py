"""Render the pictures of docs/gallery.md, 1280 x 720, from the files of sample_blends as they are.

    python -m tools.make_gallery [--samples 36] [NAME ...]

Names are those of pictures in docs/images; all are made when none is given. The pictures of the tutorials are made by
their own code.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
SIZE, SHEET_SIZE = "1280x720", "640x360"

# Picture: the sample, and its frame.
VIEWS = {
    "cups": ("cups", 1),
    "cloth": ("cloth", 1),
    "cloth_across": ("cloth", 2),
    "metal_balls": ("metal_balls", 1),
    "colour_booth": ("colour_booth", 1),
    "texture": ("texture", 1),
}
# Picture: the sample, and the lamps that its one render is shown under.
SHEETS = {"colour_booth_lamps": ("colour_booth", ("D65", "A", "FL11", "LED-B3"))}
# Picture: the page whose code makes it, and what the code calls it.
OF_TUTORIALS = {
    "satin_ball": ("tutorials/measured_spectra.md", "satin_ball.png"),
    "two_fabrics": ("tutorials/two_fabrics.md", "fabrics.png"),
}

__all__ = ["OF_TUTORIALS", "SHEETS", "VIEWS", "main"]


def _dichromatic(folder: Path, *arguments: str) -> None:
    command = [sys.executable, "-m", "dichromatic_addon", *arguments]
    subprocess.run(
        command, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True, stdout=subprocess.DEVNULL
    )


def _make(name: str, folder: Path, samples: int) -> Path:
    """Make one picture in a folder; its path."""
    picture = folder / f"{name}.png"
    if name in OF_TUTORIALS:
        page, file_name = OF_TUTORIALS[name]
        for link in ("docs", "sample_blends"):
            (folder / link).symlink_to(ROOT / link)
        command = [sys.executable, "-m", "tests.docs.run_page", str(ROOT / "docs" / page)]
        subprocess.run(command, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True)
        return folder / file_name
    if name in SHEETS:
        sample, lamps = SHEETS[name]
        blend = str(ROOT / "sample_blends" / f"{sample}.blend")
        film = str(folder / "kept.npz")
        shared = ("--size", SHEET_SIZE, "--samples", str(samples), "--quiet")
        _dichromatic(folder, "render", blend, "-o", "unused.png", "--film", film, *shared)
        _dichromatic(folder, "lamps", film, *lamps, "-o", str(picture), "--adapt", "--columns", "2")
        return picture
    sample, frame = VIEWS[name]
    blend = str(ROOT / "sample_blends" / f"{sample}.blend")
    settings = ("--size", SIZE, "--samples", str(samples), "--frame", str(frame))
    _dichromatic(folder, "render", blend, "-o", str(picture), *settings, "--quiet")
    return picture


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Render the pictures of the gallery.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="pictures to make (default: all)")
    parser.add_argument("--samples", type=int, default=36, metavar="N", help="rays a pixel (default: 36)")
    options = parser.parse_args(arguments)
    known = [*VIEWS, *SHEETS, *OF_TUTORIALS]
    for name in options.names or known:
        if name not in known:
            parser.error(f"there is no picture {name!r}; there are {', '.join(known)}")
        with tempfile.TemporaryDirectory() as folder:
            made = _make(name, Path(folder), options.samples)
            (IMAGES / f"{name}.png").write_bytes(made.read_bytes())
        print(f"docs/images/{name}.png", flush=True)


if __name__ == "__main__":
    main()
