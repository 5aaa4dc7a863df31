"""A spectrum drawn by hand: what a Spectrum node keeps of it, and the dialog with Blender's own curve widget.

Only nodes of Blender's own have a curve that the widget can show, and a node of ours cannot own one that survives copy,
undo, append and link. So the node keeps the points, and their values every nanometre, as text in an ID property; the
dialog lends a Float Curve node for as long as it is open.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import bpy
import numpy as np

from .._core import core

__all__ = [
    "CLASSES",
    "FIRST_CURVE",
    "LONGEST_NM",
    "SHORTEST_NM",
    "curve_points",
    "curve_problem",
    "draw_curve",
    "drawn_spectrum",
    "keep_curve",
]

CURVE_KEY = "dichromatic_curve"
SHORTEST_NM, LONGEST_NM = 380.0, 780.0
FIRST_CURVE = ((380.0, 0.05), (520.0, 0.1), (600.0, 0.7), (780.0, 0.8))
"""Wavelengths (nm) and values that a new curve starts with."""

_SPAN = LONGEST_NM - SHORTEST_NM
_LENT = ".Dichromatic Curve"  # name of the tree that the widget edits

Points = Sequence[Sequence[Any]]


def keep_curve(node: Any, points: Points) -> None:
    """Keep a curve on a Spectrum node, through given points as Blender's Float Curve node draws it.

    Parameters
    ----------
    node : bpy.types.Node
        A Spectrum node of the source "CURVE".
    points : sequence of (float, float) or (float, float, str)
        Wavelength from 380 to 780 nm, value from 0 to 1, and the kind of handle ("AUTO", "AUTO_CLAMPED" or "VECTOR").

    Raises
    ------
    InvalidParameterError
        If there are fewer than two points, or one is out of range.
    """
    if len(points) < 2:
        raise core.InvalidParameterError(f"a curve must have at least 2 points, but has {len(points)}")
    for point in points:
        if not (SHORTEST_NM <= point[0] <= LONGEST_NM and 0.0 <= point[1] <= 1.0):
            raise core.InvalidParameterError(
                f"points of a curve must lie between {SHORTEST_NM:g} and {LONGEST_NM:g} nm and between 0 and 1, "
                f"but one is at {point[0]:g} nm, {point[1]:g}"
            )
    lent = _lend(points)
    try:
        _keep_mapping(node, lent.nodes[0].mapping)
    finally:
        bpy.data.node_groups.remove(lent)


def _lend(points: Points) -> Any:
    """Make a tree with one Float Curve node that has the points."""
    tree = bpy.data.node_groups.new(_LENT, "ShaderNodeTree")
    mapping = tree.nodes.new("ShaderNodeFloatCurve").mapping
    curve = mapping.curves[0]
    ordered = sorted(points, key=lambda point: float(point[0]))
    while len(curve.points) < len(ordered):
        curve.points.new(0.5, 0.5)
    for target, point in zip(curve.points, ordered, strict=True):
        target.location = ((point[0] - SHORTEST_NM) / _SPAN, point[1])
        target.handle_type = point[2] if len(point) > 2 else "AUTO_CLAMPED"
    mapping.update()
    return tree


def _keep_mapping(node: Any, mapping: Any) -> None:
    """Keep what a curve mapping holds, with its values every nanometre."""
    mapping.initialize()
    curve = mapping.curves[0]
    points = [(SHORTEST_NM + _SPAN * point.location[0], point.location[1], point.handle_type) for point in curve.points]
    values = [min(max(mapping.evaluate(curve, x), 0.0), 1.0) for x in np.linspace(0.0, 1.0, int(_SPAN) + 1).tolist()]
    node[CURVE_KEY] = json.dumps({"points": points, "values": values}, allow_nan=False)


@lru_cache(maxsize=128)
def _parsed(text: str) -> tuple[tuple[tuple[Any, ...], ...], core.Spectrum]:
    try:
        content = json.loads(text)
        points = tuple((float(nm), float(value), str(handle)) for nm, value, handle in content["points"])
        values = np.array(content["values"], np.float64)
        wavelengths = np.linspace(SHORTEST_NM, LONGEST_NM, len(values))
        return points, core.Spectrum(wavelengths, values, name="drawn curve")
    except (ValueError, TypeError, KeyError) as error:
        raise core.SpectrumFileError(f"the drawn curve is damaged: {error!r}") from error


def drawn_spectrum(node: Any) -> core.Spectrum:
    """Return the curve of a Spectrum node, every nanometre from 380 to 780 nm.

    Raises
    ------
    DichromaticError
        If none was drawn, or it was damaged by hand.
    """
    text = node.get(CURVE_KEY)
    if text is None:
        raise core.SpectrumFileError("no curve has been drawn yet; use Edit Curve")
    return _parsed(str(text))[1]


def curve_points(node: Any) -> Points:
    """Return the points of a Spectrum node's curve; those of a new curve where it has none that can be read."""
    return FIRST_CURVE if curve_problem(node) else _parsed(str(node[CURVE_KEY]))[0]


def curve_problem(node: Any) -> str:
    """Say why a Spectrum node's curve cannot be had; an empty string when it can."""
    try:
        drawn_spectrum(node)
    except core.DichromaticError as error:
        return str(error)
    return ""


def draw_curve(layout: Any, node: Any) -> None:
    """Draw the button that opens the dialog."""
    row = layout.row()
    row.context_pointer_set("dichromatic_curve_owner", node)
    row.operator(DICHROMATIC_OT_edit_curve.bl_idname, icon="FCURVE")


def _draw_wavelengths(layout: Any) -> None:
    """Draw the scale below the widget's grid, which has a line every quarter."""
    rest, width = layout, 1.0
    for index, part in enumerate((0.125, 0.25, 0.25, 0.25, 0.125)):
        last = index == 4
        rest = rest if last else rest.split(factor=part / width, align=True)
        width -= part
        row = rest.row()
        row.alignment = "LEFT" if index == 0 else "RIGHT" if last else "CENTER"
        row.label(text=f"{SHORTEST_NM + 0.25 * index * _SPAN:.0f} nm")


def _selected(mapping: Any) -> str:
    """Say where the selected points are, which the widget's own fields count from 0 to 1."""
    chosen = [point.location for point in mapping.curves[0].points if point.select]
    told = "; ".join(f"{SHORTEST_NM + _SPAN * x:.1f} nm, {y:.3f}" for x, y in chosen)
    return f"Selected: {told or 'none'}"


class DICHROMATIC_OT_edit_curve(bpy.types.Operator):
    bl_idname = "dichromatic.edit_curve"
    bl_label = "Edit Curve"
    bl_description = "Draw the spectrum by hand, from 380 to 780 nm and from 0 to 1; the node keeps the curve"
    bl_options = {"UNDO", "INTERNAL"}

    # No poll: it would be asked again when OK is pressed, where the context no longer has the button's node.

    def invoke(self, context: Any, event: Any) -> set[str]:
        self._node = getattr(context, "dichromatic_curve_owner", None)
        if self._node is None:
            return self._without_node()
        self._lent = _lend(curve_points(self._node))
        return set(context.window_manager.invoke_props_dialog(self, width=420))

    def draw(self, context: Any) -> None:
        layout = self.layout
        mapping = self._lent.nodes[0].mapping
        layout.template_curve_mapping(self._lent.nodes[0], "mapping")
        _draw_wavelengths(layout)
        layout.label(text=_selected(mapping))

    def execute(self, context: Any) -> set[str]:
        """Keep the curve (also called from scripts, where it starts the curve that the dialog would show)."""
        lent = getattr(self, "_lent", None)
        node = self._node if lent is not None else getattr(context, "dichromatic_curve_owner", None)
        if node is None:
            return self._without_node()
        if lent is None:
            keep_curve(node, curve_points(node))
        else:
            _keep_mapping(node, lent.nodes[0].mapping)
            self._give_back()
        node.refresh()
        node.id_data.update_tag()
        return {"FINISHED"}

    def cancel(self, context: Any) -> None:
        """Give the lent node back when the dialog is left."""
        self._give_back()

    def _without_node(self) -> set[str]:
        self.report({"ERROR"}, "Curves are edited with the button of a Spectrum node whose source is Curve")
        return {"CANCELLED"}

    def _give_back(self) -> None:
        bpy.data.node_groups.remove(self._lent)
        self._lent = None


CLASSES = (DICHROMATIC_OT_edit_curve,)
