"""What the material panel tells about a material: where an imported one comes from, and where one creates light."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ._core import core
from .nodes.imported import record_of
from .nodes.reading import read_material
from .wrapped import draw_wrapped

__all__ = ["draw_energy_warnings", "draw_provenance", "provenance_lines", "warnings_of"]


@lru_cache(maxsize=256)
def warnings_of(material: core.Material) -> tuple[str, ...]:
    """Return where a material creates light; a tenth of a second for new values, nothing for those of the last redraw.

    Parameters
    ----------
    material : Material
        The core's material.

    Returns
    -------
    tuple of str
        One sentence each.
    """
    return core.energy_warnings(material)


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
        found = warnings_of(read_material(material).material)
    except core.DichromaticError:
        return  # the panel shows the reason with the node
    for text in found:
        draw_wrapped(layout, text, "INFO", width)


def provenance_lines(record: core.fitting.MaterialRecord) -> list[str]:
    """Say where an imported material comes from, a sentence each.

    Parameters
    ----------
    record : MaterialRecord
        What was imported.

    Returns
    -------
    list of str
        Source and residual, the fitted numbers with their intervals, then evidence and notes.
    """
    origin = record.provenance
    lines = []
    if origin.source:
        residual = f", residual {origin.relative_residual:.2g} of the data" if origin.relative_residual else ""
        lines.append(f"Fitted to {origin.source}{residual}")
    if origin.confidence and origin.parameters:
        lines.append(f"{origin.confidence:.0%} intervals when imported:")
    lines += [interval.describe() for interval in origin.parameters]
    return [*lines, *origin.evidence, *origin.notes]


def draw_provenance(layout: Any, node: Any, width: int) -> None:
    """Draw a box that tells where an imported material comes from; nothing for a node without one.

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
    box = layout.box()
    box.label(text=f"Imported: {record.name or 'a material without a name'}", icon="IMPORT")
    for text in provenance_lines(record):
        draw_wrapped(box, text, "NONE", width - 4)
