"""Text that is too long for one line of a panel or a node."""

from __future__ import annotations

import textwrap
from typing import Any

__all__ = ["NODE_LINE", "draw_wrapped", "panel_line"]

NODE_LINE = 30  # characters that fit into a node of the width that ours start with
PIXELS_PER_CHARACTER = 6.5  # of Blender's interface font at a scale of 1, rounded up
PIXELS_FOR_ICON = 70  # icon, margins and tabs


def panel_line(context: Any) -> int:
    """Return how many characters fit into a line of the region that is being drawn."""
    scale = context.preferences.system.ui_scale or 1.0  # 0 without a window
    return max(20, int((context.region.width / scale - PIXELS_FOR_ICON) / PIXELS_PER_CHARACTER))


def draw_wrapped(layout: Any, text: str, icon: str, width: int) -> None:
    """Draw a text in as many lines as it needs, an error in red."""
    if not text:
        return
    column = layout.column(align=True)
    column.alert = icon == "ERROR"
    for index, line in enumerate(textwrap.wrap(text, width)):
        column.label(text=line, icon="BLANK1" if index else icon)
