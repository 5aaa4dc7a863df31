"""Cut the panels out of the pictures that `make test-ui` takes of Blender's window, for the pages of the manual.

    python tools/crop_screenshots.py artifacts/ui/5.2

Panels are found by the colour of their left edge in Blender's dark theme and numbered from the top, so that a panel
that grows or moves is still found.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
EDGE, LEFT, RIGHT = 44, 34, 278  # columns: just inside a panel's left side, and what is kept around it
PANEL = np.array([61, 61, 61])
SMALLEST = 12  # rows; less is a line between panels

# Picture in docs/images: the window's picture, and the first and the last panel that are kept.
PANELS = {
    "panel_material": ("panels/material_plastic_source_library", 1, 2),
    "panel_metal": ("panels/material_metal", 1, 1),
    "panel_light": ("panels/light_point_source_library", 1, 2),
    "panel_world": ("panels/world_source_library", 1, 1),
    "panel_sampling": ("panels/mesh_render", 0, 0),
    "panel_spectral": ("panels/mesh_render", 1, 1),
    "panel_mirrored_light": ("panels/mesh_render", 2, 2),
    "panel_white_adaptation": ("panels/mesh_render", 3, 3),
    "panel_film_and_output": ("panels/mesh_render", 4, 4),
}
# Parts of a picture as it is: left, top, right, bottom.
PARTS = {
    "sidebar_studies": ("rendering/image_editor_studied", (168, 28, 1311, 1102)),
    "preferences": ("panels/preferences", (170, 60, 1311, 376)),
    "node_spectrum": ("nodes/spectrum_source_library", (486, 652, 826, 994)),
}

__all__ = ["main", "panel_rows"]


def panel_rows(picture: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of each panel, from the top."""
    is_panel = np.abs(picture[:, EDGE, :3].astype(int) - PANEL).max(axis=1) < 6
    changes = np.flatnonzero(np.diff(np.concatenate([[False], is_panel, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in changes.reshape(-1, 2) if b - a > SMALLEST]


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Cut panels out of pictures of Blender's window.")
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args(arguments).folder
    for name, (source, first, last) in PANELS.items():
        picture = Image.open(folder / f"{source}.png").convert("RGB")
        rows = panel_rows(np.asarray(picture))
        kept = picture.crop((LEFT, rows[first][0] - 3, RIGHT, rows[last][1] + 4))
        kept.quantize(192).save(IMAGES / f"{name}.png", optimize=True)
    for name, (source, box) in PARTS.items():
        picture = Image.open(folder / f"{source}.png").convert("RGB")
        picture.crop(box).quantize(192).save(IMAGES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
