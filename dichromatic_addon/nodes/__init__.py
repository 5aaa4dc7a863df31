"""The material nodes: what they are, how they are read, and how they look to engines that know no spectra."""

from __future__ import annotations

import bpy

from . import curve, dielectric, editing, handlers, image_panel, importing, menu, metal, mix, plot, spectrum
from .reading import MaterialReading, read_material

__all__ = ["CLASSES", "MaterialReading", "read_material", "register", "unregister"]

NODES = (*spectrum.CLASSES, *dielectric.CLASSES, *metal.CLASSES, *mix.CLASSES)
CLASSES = (*NODES, *curve.CLASSES, *editing.CLASSES, *image_panel.CLASSES, *importing.CLASSES, *menu.CLASSES)


def register() -> None:
    """Register the nodes, their operators and menus."""
    for cls in CLASSES:
        _rebase(cls)
        bpy.utils.register_class(cls)
    plot.register()
    menu.register()
    handlers.register()


def unregister() -> None:
    """Take everything out again, last first."""
    handlers.unregister()
    menu.unregister()
    plot.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


def _rebase(cls: type) -> None:
    """Let a node class derive from today's ShaderNodeCustomGroup.

    When such a class is unregistered, Blender (4.2 to 5.2) forgets its Python type of the base and makes a new one for
    whoever asks next; classes of the old one are then refused: the add-on could not be enabled a second time.
    """
    current = bpy.types.ShaderNodeCustomGroup
    bases = tuple(current if base.__name__ == current.__name__ else base for base in cls.__bases__)
    if bases != cls.__bases__:
        cls.__bases__ = bases
