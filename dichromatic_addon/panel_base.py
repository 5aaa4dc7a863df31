"""What our panels in the Properties editor have in common."""

from __future__ import annotations

from typing import Any

from .names import ENGINE_ID

__all__ = ["PropertiesPanel", "columns"]


class PropertiesPanel:
    """Where the panels are, and that they are for our engine only."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE_ID}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.engine in cls.COMPAT_ENGINES)


def columns(layout: Any) -> Any:
    """Set a layout to labels on the left and values on the right, and return it."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout
