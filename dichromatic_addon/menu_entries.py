"""Entries of ours at the end of Blender's own menus and panels."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import bpy

__all__ = ["Entry", "append_entries", "remove_entries"]

Entry: TypeAlias = tuple[str, Callable[[Any, Any], None]]
"""Name of Blender's menu or panel, and what draws our part of it."""


def append_entries(entries: Iterable[Entry]) -> None:
    """Append entries; those whose menu a Blender without its own interface scripts does not have are left out."""
    for name, draw in entries:
        menu = getattr(bpy.types, name, None)
        if menu is not None:
            menu.append(draw)


def remove_entries(entries: Iterable[Entry]) -> None:
    """Take entries out again."""
    for name, draw in entries:
        menu = getattr(bpy.types, name, None)
        if menu is not None:
            menu.remove(draw)
