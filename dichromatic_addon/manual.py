"""Right click > Online Manual: which page of the manual tells of a property, a node or an operator of ours.

The manual is built with the documents. Where it lies is a preference: the address of a website, or a folder of files.
"""

from __future__ import annotations

from pathlib import Path

import bpy

from .preferences import preferences

__all__ = ["PAGES", "manual_map", "register", "unregister"]

# The first pattern that fits counts, so what is special stands before what is general. Names are those of RNA, in
# lower letters, as Blender asks for them.
PAGES = (
    ("bpy.types.dichromaticlightsettings*", "light"),
    ("bpy.types.dichromaticworldsettings*", "world"),
    ("bpy.types.dichromaticscenesettings.observer*", "spectral"),
    ("bpy.types.dichromaticscenesettings.grid*", "spectral"),
    ("bpy.types.dichromaticscenesettings.precision*", "spectral"),
    ("bpy.types.dichromaticscenesettings.max_bounces*", "mirrored_light"),
    ("bpy.types.dichromaticscenesettings.bounce_*", "mirrored_light"),
    ("bpy.types.dichromaticscenesettings.term_limit*", "mirrored_light"),
    ("bpy.types.dichromaticscenesettings.adaptation*", "white_adaptation"),
    ("bpy.types.dichromaticscenesettings.white_*", "white_adaptation"),
    ("bpy.types.dichromaticscenesettings.display*", "film_and_output"),
    ("bpy.types.dichromaticscenesettings.monitor_file*", "film_and_output"),
    ("bpy.types.dichromaticscenesettings.gamut*", "film_and_output"),
    ("bpy.types.dichromaticscenesettings*", "sampling"),
    ("bpy.types.dichromaticviewlayersettings*", "passes"),
    ("bpy.types.dichromaticstudy*", "studies"),
    ("bpy.types.dichromaticpreferences*", "preferences"),
    ("bpy.types.dichromaticnode*", "material"),
    ("bpy.ops.dichromatic.set_surface*", "material"),
    ("bpy.ops.dichromatic.*link_spectrum*", "material"),
    ("bpy.ops.dichromatic.*material*", "material"),
    ("bpy.ops.dichromatic.reload_spectrum*", "material"),
    ("bpy.ops.dichromatic.estimate*", "sampling"),
    ("bpy.ops.dichromatic.render_image*", "film_and_output"),
    ("bpy.ops.dichromatic.*", "studies"),
)


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """Return where the manual is, and its pages; nothing where the preferences do not say where it is.

    Returns
    -------
    tuple of (str, tuple of (str, str))
        As ``bpy.utils.register_manual_map`` wants it.
    """
    chosen = preferences()
    place = chosen.manual.strip() if chosen is not None else ""
    if not place:
        return "", ()
    if "://" not in place:
        place = Path(bpy.path.abspath(place)).resolve().as_uri()
    return f"{place.rstrip('/')}/manual/", tuple((pattern, f"{page}.html") for pattern, page in PAGES)


def register() -> None:
    """Tell Blender of the manual."""
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    """Let Blender forget it."""
    bpy.utils.unregister_manual_map(manual_map)
