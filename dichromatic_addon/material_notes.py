"""What the material panel tells about a material: where an imported one comes from, and where one creates light."""

from __future__ import annotations

from typing import Any

import bpy

from ._core import core
from .nodes.imported import record_of
from .nodes.reading import read_material
from .wrapped import draw_wrapped

__all__ = [
    "draw_approximations",
    "draw_energy_warnings",
    "draw_provenance",
    "fitted_lines",
    "unregister",
    "warnings_of",
]

_REST = 0.25  # seconds without a new value before warnings are computed: a slider that is dragged must not stutter
_KEPT = 256  # materials whose warnings are remembered

_warnings: dict[core.Material, tuple[str, ...]] = {}
_waiting: list[core.Material] = []  # the one that was drawn last without its warnings


def warnings_of(material: core.Material) -> tuple[str, ...]:
    """Return where a material creates light; a tenth of a second for new values, nothing for known ones.

    Parameters
    ----------
    material : Material
        The core's material.

    Returns
    -------
    tuple of str
        One sentence each.
    """
    if material not in _warnings:
        if len(_warnings) >= _KEPT:
            _warnings.clear()
        _warnings[material] = core.energy_warnings(material)
    return _warnings[material]


def _after_rest() -> None:
    """Compute what was drawn last, and have it drawn (Blender's timer)."""
    while _waiting:
        warnings_of(_waiting.pop())
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def _request(material: core.Material) -> None:
    _waiting[:] = [material]
    if bpy.app.timers.is_registered(_after_rest):
        bpy.app.timers.unregister(_after_rest)
    bpy.app.timers.register(_after_rest, first_interval=_REST)


def unregister() -> None:
    """Forget everything, with the add-on."""
    if bpy.app.timers.is_registered(_after_rest):
        bpy.app.timers.unregister(_after_rest)
    _waiting.clear()
    _warnings.clear()


def draw_energy_warnings(layout: Any, material: Any, width: int) -> None:
    """Draw where a Blender material creates light.

    Parameters
    ----------
    layout : bpy.types.UILayout
        Where to draw.
    material : bpy.types.Material
        One with a surface node of ours.
    width : int
        Characters in a line.
    """
    try:
        read = read_material(material, pictures="none").material  # an image is judged as if it were white
        if read not in _warnings and not bpy.app.background:
            _request(read)  # drawn as soon as the values rest
            return
        found = warnings_of(read)
    except core.DichromaticError:
        return  # the panel shows the reason with the node
    for text in found:
        draw_wrapped(layout, text, "INFO", width)


def draw_approximations(layout: Any, material: Any, width: int) -> None:
    """Draw what is approximated in a foreign material, in a sub-panel.

    Parameters
    ----------
    layout : bpy.types.UILayout
        Where to draw.
    material : bpy.types.Material
        One without a surface node of ours.
    width : int
        Characters in a line.
    """
    header, body = layout.panel("dichromatic_approximations", default_closed=True)
    header.label(text="Approximations")
    if body is None:
        return
    try:
        notes = read_material(material, pictures="none").notes
    except core.DichromaticError as error:
        draw_wrapped(body, str(error), "ERROR", width)
        return
    for text in notes:
        told = text.partition(": ")[2]
        draw_wrapped(body, told[:1].upper() + told[1:], "DOT", width)


def fitted_lines(record: core.fitting.MaterialRecord) -> list[str]:
    """Say what an imported material was fitted to, and with which result.

    Parameters
    ----------
    record : MaterialRecord
        What was imported.

    Returns
    -------
    list of str
        Source and residual, then the fitted numbers with their intervals.
    """
    origin = record.provenance
    lines = []
    if origin.source:
        residual = f", residual {origin.relative_residual:.2g} of the data" if origin.relative_residual else ""
        lines.append(f"Fitted to {origin.source}{residual}")
    if origin.confidence and origin.parameters:
        lines.append(f"{origin.confidence:.0%} intervals when imported:")
    return lines + [interval.describe() for interval in origin.parameters]


def draw_provenance(layout: Any, node: Any, width: int) -> None:
    """Draw a box that tells where an imported material comes from, and its evidence below; nothing for other nodes.

    Parameters
    ----------
    layout : bpy.types.UILayout
        Where to draw.
    node : bpy.types.Node
        A surface node.
    width : int
        Characters in a line.
    """
    try:
        record = record_of(node)
    except core.DichromaticError as error:
        draw_wrapped(layout, str(error), "ERROR", width)
        return
    if record is None:
        return
    box = layout.box().column(align=True)
    box.label(text=f"Imported: {record.name or 'a material without a name'}", icon="IMPORT")
    for text in fitted_lines(record):
        draw_wrapped(box, text, "NONE", width - 4)
    evidence = (*record.provenance.evidence, *record.provenance.notes)
    if not evidence:
        return
    header, body = layout.panel("dichromatic_evidence", default_closed=True)
    header.label(text="Evidence")
    if body is not None:
        for text in evidence:
            draw_wrapped(body, text, "DOT", width)
