"""The material nodes: what they are, how they are read, and how they look to engines that know no spectra."""

from __future__ import annotations

import bpy

from . import dielectric, editing, handlers, menu, metal, spectrum
from .reading import MaterialReading, read_material

__all__ = ["CLASSES", "MaterialReading", "read_material", "register", "unregister"]

CLASSES = (*spectrum.CLASSES, *dielectric.CLASSES, *metal.CLASSES, *editing.CLASSES, *menu.CLASSES)


def register() -> None:
    """Register the nodes, their operators and menus."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    menu.register()
    handlers.register()


def unregister() -> None:
    """Take everything out again, last first."""
    handlers.unregister()
    menu.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
