"""The spectrum that is drawn by hand: its values are Blender's own, and the node keeps it through everything."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon.names import PLASTIC_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes.approximation import linear_rgb
from dichromatic_addon.nodes.curve import CURVE_KEY, DICHROMATIC_OT_edit_curve, _lend, _selected, curve_points
from dichromatic_addon.nodes.editing import link_spectrum_node, set_surface_node
from dichromatic_addon.nodes.evaluation import spectrum_of_node
from dichromatic_addon.nodes.reading import link_problems, read_material
from tests.addon.building import add_light, add_plane, combined, look_down, small_picture
from tests.addon.fake_layout import FakeLayout
from tests.tolerances import BLENDER_FLOAT, COLOUR_NODES, REC709_ROUND_TRIP

pytestmark = pytest.mark.bpy

POINTS = [(380.0, 0.1), (500.0, 0.2, "VECTOR"), (620.0, 0.8), (780.0, 0.6)]


def drawn(name: str = "Paint") -> tuple[Any, Any]:
    material = bpy.data.materials.new(name)
    node = set_surface_node(material, PLASTIC_NODE)
    node.inputs["Interface Reflectance"].default_value = 0.0
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source = "CURVE"
    spectrum.set_curve(POINTS)
    return material, spectrum


def test_the_values_are_those_of_blenders_curve(scene: Any) -> None:
    _, node = drawn()
    tree = bpy.data.node_groups.new("Other", "ShaderNodeTree")
    mapping = tree.nodes.new("ShaderNodeFloatCurve").mapping
    curve = mapping.curves[0]
    curve.points[0].location, curve.points[1].location = (0.0, 0.1), (1.0, 0.6)
    for x, y in ((0.3, 0.2), (0.6, 0.8)):
        curve.points.new(x, y)
    for point, handle in zip(curve.points, ("AUTO_CLAMPED", "VECTOR", "AUTO_CLAMPED", "AUTO_CLAMPED"), strict=True):
        point.handle_type = handle
    mapping.update()
    mapping.initialize()
    spectrum = spectrum_of_node(node)
    for nanometres in (380.0, 431.0, 500.0, 555.0, 620.0, 700.0, 780.0):
        expected = mapping.evaluate(curve, (nanometres - 380.0) / 400.0)
        assert spectrum.at([nanometres])[0] == pytest.approx(expected, abs=BLENDER_FLOAT)
    assert spectrum.at([500.0])[0] == pytest.approx(
        0.2, abs=COLOUR_NODES
    )  # through its points, as far as the curve's table
    assert [tree.name for tree in bpy.data.node_groups if "Curve" in tree.name] == []  # the lent node was given back


def test_two_points_with_vector_handles_are_a_line(scene: Any) -> None:
    _, node = drawn()
    node.set_curve([(380.0, 0.2, "VECTOR"), (780.0, 0.6, "VECTOR")])
    at = np.array([380.0, 480.0, 580.0, 780.0])
    np.testing.assert_allclose(spectrum_of_node(node).at(at), [0.2, 0.3, 0.4, 0.6], atol=1e-6)


def test_a_new_curve_can_be_rendered_at_once(scene: Any) -> None:
    material = bpy.data.materials.new("New")
    surface = set_surface_node(material, PLASTIC_NODE)
    node = link_spectrum_node(material.node_tree, surface, "Body Reflectance")
    node.source = "CURVE"
    assert link_problems(node) == []
    assert read_material(material).material.body_reflectance.name == "drawn curve"


def test_other_engines_see_its_colour(scene: Any) -> None:
    _, node = drawn()
    expected = linear_rgb(spectrum_of_node(node))
    assert tuple(node.inputs["RGB"].default_value)[:3] == pytest.approx(expected, rel=REC709_ROUND_TRIP)


def test_the_picture_shows_the_curve(scene: Any, tmp_path: Path) -> None:
    material, node = drawn()
    node.set_curve([(380.0, 0.35), (780.0, 0.35)])
    add_plane(scene, material, size=4.0)
    add_light(scene, "SUN", math.pi, angle=0.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    pixels = combined(scene, str(tmp_path / "curve.exr"))
    np.testing.assert_allclose(pixels[..., :3], 0.35, rtol=1e-3)


@pytest.mark.parametrize("how", ["copy", "undo", "save", "append", "link"])
def test_the_node_keeps_its_curve(scene: Any, tmp_path: Path, how: str) -> None:
    material, node = drawn()
    before = spectrum_of_node(node)
    path = str(tmp_path / "paint.blend")
    if how == "copy":
        copy = material.copy()
        node.set_curve([(380.0, 0.9), (780.0, 0.9)])  # the copy has a curve of its own
        material = copy
    elif how == "undo":
        bpy.ops.ed.undo_push(message="drawn")
        node.set_curve([(380.0, 0.9), (780.0, 0.9)])
        bpy.ops.ed.undo_push(message="drawn again")
        bpy.ops.ed.undo()
        material = bpy.data.materials["Paint"]
    else:
        material.use_fake_user = True
        bpy.ops.wm.save_as_mainfile(filepath=path)
        if how != "save":
            bpy.ops.wm.read_factory_settings(use_empty=True)
            with bpy.data.libraries.load(path, link=how == "link") as (source, target):
                target.materials = source.materials
        else:
            bpy.ops.wm.open_mainfile(filepath=path)
        material = bpy.data.materials["Paint"]
    found = next(item for item in material.node_tree.nodes if item.bl_idname == SPECTRUM_NODE)
    assert spectrum_of_node(found) == before
    assert len(curve_points(found)) == len(POINTS)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([(380.0, 0.5)], "at least 2 points"),
        ([(300.0, 0.5), (780.0, 0.5)], "300 nm"),
        ([(380.0, 1.5), (780.0, 0.5)], "1.5"),
    ],
)
def test_points_out_of_range_are_refused(scene: Any, points: Any, words: str) -> None:
    _, node = drawn()
    before = spectrum_of_node(node)
    with pytest.raises(core.InvalidParameterError, match=words):
        node.set_curve(points)
    assert spectrum_of_node(node) == before


def test_a_damaged_curve_is_named(scene: Any) -> None:
    material, node = drawn()
    node[CURVE_KEY] = "{}"
    assert "damaged" in "".join(link_problems(node))
    with pytest.raises(core.SceneError, match=r"Spectrum of node .* in material 'Paint': .*damaged"):
        read_material(material)


def test_the_operator_draws_and_keeps(scene: Any) -> None:
    _, node = drawn()
    del node[CURVE_KEY]
    with bpy.context.temp_override(dichromatic_curve_owner=node):
        assert bpy.ops.dichromatic.edit_curve() == {"FINISHED"}
    assert len(curve_points(node)) == 4
    layout = FakeLayout()
    node.draw_compact(layout)
    assert "dichromatic.edit_curve" in layout.names("operator")


def test_the_dialog_is_asked_nothing_when_ok_is_pressed(scene: Any) -> None:
    """Blender asks an operator's poll again at OK, where the context no longer has the button's node."""
    assert bpy.ops.dichromatic.edit_curve.poll()
    with pytest.raises(RuntimeError, match="with the button of a Spectrum node"):
        bpy.ops.dichromatic.edit_curve()
    _, node = drawn()
    lent = _lend(POINTS)
    lent.nodes[0].mapping.curves[0].points[2].location = (0.6, 0.3)
    lent.nodes[0].mapping.update()
    refreshed = spectrum_of_node(node)
    dialog = SimpleNamespace(_node=node, _lent=lent)
    dialog._give_back = lambda: DICHROMATIC_OT_edit_curve._give_back(dialog)
    assert DICHROMATIC_OT_edit_curve.execute(dialog, bpy.context) == {"FINISHED"}
    assert spectrum_of_node(node) != refreshed
    assert curve_points(node)[2][1] == pytest.approx(0.3)
    assert dialog._lent is None


def test_the_dialog_says_where_the_selected_points_are(scene: Any) -> None:
    tree = _lend(POINTS)
    points = tree.nodes[0].mapping.curves[0].points
    for index, point in enumerate(points):
        point.select = index == 2
    layout = FakeLayout()
    layout.template_curve_mapping = lambda node, name: getattr(node, name)  # type: ignore[attr-defined]
    DICHROMATIC_OT_edit_curve.draw(SimpleNamespace(layout=layout, _lent=tree), bpy.context)
    assert layout.names("label") == ["380 nm", "480 nm", "580 nm", "680 nm", "780 nm", "Selected: 620.0 nm, 0.800"]
    for point in points:
        point.select = False
    assert _selected(tree.nodes[0].mapping) == "Selected: none"
