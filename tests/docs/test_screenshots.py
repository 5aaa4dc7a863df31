"""Panels are found in a picture of Blender's window by their colour, wherever they lie."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PIL")

from tools.crop_screenshots import PANEL, PANELS, panel_rows

BACKGROUND = 48


def test_panels_are_found_from_the_top() -> None:
    picture = np.full((400, 282, 3), BACKGROUND, np.uint8)
    for top, bottom in ((40, 120), (124, 300), (310, 316)):  # the last is a line, not a panel
        picture[top:bottom, 34:278] = PANEL
    assert panel_rows(picture) == [(40, 120), (124, 300)]


def test_first_panel_comes_before_the_last() -> None:
    assert all(first <= last for _, first, last in PANELS.values())
