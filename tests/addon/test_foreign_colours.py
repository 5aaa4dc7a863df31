"""Chains of Blender's colour nodes, evaluated here and by Cycles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon.nodes.colour_chains import ColourChains
from tests.addon.building import add_plane, combined, look_down, small_picture
from tests.tolerances import BLACKBODY_FITS, COLOUR_NODES, MEAN_OF_A_PATTERN

pytestmark = pytest.mark.bpy

RGB = (0.2, 0.5, 0.8, 1.0)
OTHER = (0.7, 0.3, 0.1, 1.0)
BLENDS = [item.identifier for item in bpy.types.ShaderNodeMix.bl_rna.properties["blend_type"].enum_items]
OPERATIONS = {
    "ADD": (0.2, 0.3), "SUBTRACT": (0.8, 0.3), "MULTIPLY": (0.5, 0.3), "DIVIDE": (0.2, 0.5), "POWER": (0.5, 2.0),
    "LOGARITHM": (0.9, 0.3), "SQRT": (0.4,), "INVERSE_SQRT": (4.0,), "ABSOLUTE": (-0.4,), "EXPONENT": (-0.4,),
    "MINIMUM": (0.4, 0.2), "MAXIMUM": (0.4, 0.2), "LESS_THAN": (0.4, 0.5), "GREATER_THAN": (0.4, 0.2), "SIGN": (0.3,),
    "COMPARE": (0.4, 0.45, 0.1), "ROUND": (0.7,), "FLOOR": (1.7,), "CEIL": (0.2,), "TRUNC": (1.2,), "FRACT": (1.2,),
    "MODULO": (1.7, 0.5), "FLOORED_MODULO": (-0.2, 0.5), "SNAP": (0.7, 0.3), "SINE": (0.4,), "COSINE": (0.4,),
    "TANGENT": (0.4,), "ARCSINE": (0.4,), "ARCCOSINE": (0.4,), "ARCTANGENT": (0.4,), "ARCTAN2": (0.4, 0.8),
    "RADIANS": (40.0,), "DEGREES": (0.01,), "MULTIPLY_ADD": (0.4, 0.5, 0.2),
}  # fmt: skip


@pytest.fixture
def card(scene: Any) -> tuple[Any, Any, Any]:
    """A glowing card that fills Cycles' picture: the scene, the material's tree and the emission's colour input."""
    material = bpy.data.materials.new("Chain")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    add_plane(scene, material, size=4.0)
    look_down(scene)
    small_picture(scene, 4, 4)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    return scene, tree, emission.inputs["Color"]


def both(card: tuple[Any, Any, Any], output: Any, path: Path) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """The colour of a node's output: ours, Cycles', and our notes."""
    scene, tree, target = card
    tree.links.new(output, target)
    chains = ColourChains()
    ours = np.array(chains.colour(target))
    theirs = combined(scene, str(path / "card.exr"))[..., :3].mean(axis=(0, 1))
    return ours, theirs, chains.notes


def node(tree: Any, kind: str, *values: Any) -> Any:
    """A node with the values of its first inputs."""
    made = tree.nodes.new(kind)
    for socket, value in zip(made.inputs, values, strict=False):
        socket.default_value = value
    return made


def ramp(tree: Any) -> Any:
    made = node(tree, "ShaderNodeValToRGB", 0.35)
    made.color_ramp.elements[0].color, made.color_ramp.elements[1].color = RGB, OTHER
    made.color_ramp.elements.new(0.6).color = (1.0, 1.0, 0.0, 1.0)
    return made.outputs["Color"]


def curves(tree: Any) -> Any:
    made = node(tree, "ShaderNodeRGBCurve", 0.8, RGB)
    made.mapping.curves[3].points.new(0.4, 0.6)
    made.mapping.curves[0].points.new(0.5, 0.2)
    made.mapping.update()
    return made.outputs[0]


def float_curve(tree: Any) -> Any:
    made = node(tree, "ShaderNodeFloatCurve", 1.0, 0.3)
    made.mapping.curves[0].points.new(0.4, 0.7)
    made.mapping.update()
    return made.outputs[0]


def separated(tree: Any, mode: str) -> Any:
    made = tree.nodes.new("ShaderNodeSeparateColor")
    made.mode = mode
    made.inputs[0].default_value = RGB
    back = tree.nodes.new("ShaderNodeCombineColor")
    back.mode = mode
    for source, target in ((0, 0), (1, 2), (2, 1)):  # swapped, so that both must be right
        tree.links.new(made.outputs[source], back.inputs[target])
    return back.outputs[0]


def map_range(tree: Any, kind: str) -> Any:
    made = node(tree, "ShaderNodeMapRange", 0.35, 0.1, 0.9, 0.2, 0.7, 3.0)
    made.interpolation_type = kind
    return made.outputs[0]


def to_number_and_back(tree: Any) -> Any:
    made = node(tree, "ShaderNodeMath", 0.0, 0.25)
    tree.links.new(node(tree, "ShaderNodeBrightContrast", RGB, 0.1, 0.3).outputs[0], made.inputs[0])
    return made.outputs[0]


RANGES = ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")
CHAINS: dict[str, Callable[[Any], Any]] = {
    "ramp": ramp,
    "curves": curves,
    "float curve": float_curve,
    "hue": lambda tree: node(tree, "ShaderNodeHueSaturation", 0.7, 1.2, 0.9, 0.8, RGB).outputs[0],
    "gamma": lambda tree: node(tree, "ShaderNodeGamma", RGB, 2.2).outputs[0],
    "contrast": lambda tree: node(tree, "ShaderNodeBrightContrast", RGB, 0.1, 0.3).outputs[0],
    "invert": lambda tree: node(tree, "ShaderNodeInvert", 0.8, RGB).outputs[0],
    "grey": lambda tree: node(tree, "ShaderNodeRGBToBW", RGB).outputs[0],
    "clamp": lambda tree: node(tree, "ShaderNodeClamp", 0.9, 0.1, 0.6).outputs[0],
    "separate RGB": lambda tree: separated(tree, "RGB"),
    "separate HSV": lambda tree: separated(tree, "HSV"),
    "colour to number": to_number_and_back,
    "scaled": lambda tree: node(tree, "ShaderNodeVectorMath", RGB[:3], OTHER[:3]).outputs[0],
    **{kind.lower(): lambda tree, k=kind: map_range(tree, k) for kind in RANGES},
}  # fmt: skip


@pytest.mark.parametrize("chain", CHAINS)
def test_colour_nodes_give_what_cycles_makes_of_them(card: Any, tmp_path: Path, chain: str) -> None:
    ours, theirs, notes = both(card, CHAINS[chain](card[1]), tmp_path)
    assert notes == []
    assert theirs.max() > 0.01
    np.testing.assert_allclose(ours, theirs, atol=COLOUR_NODES)


@pytest.mark.parametrize("blend", BLENDS)
def test_every_blend_mode(card: Any, tmp_path: Path, blend: str) -> None:
    made = card[1].nodes.new("ShaderNodeMix")
    made.data_type, made.blend_type = "RGBA", blend
    by_identifier = {socket.identifier: socket for socket in made.inputs}
    by_identifier["Factor_Float"].default_value = 0.7
    by_identifier["A_Color"].default_value, by_identifier["B_Color"].default_value = RGB, OTHER
    output = next(socket for socket in made.outputs if socket.identifier == "Result_Color")
    ours, theirs, notes = both(card, output, tmp_path)
    assert notes == []
    np.testing.assert_allclose(ours, theirs, atol=COLOUR_NODES)


def test_operations_of_numbers(card: Any, tmp_path: Path) -> None:
    """Each by a card of its own, and all of them judged at once."""
    tree = card[1]
    known = {item.identifier for item in bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items}
    wrong = {}
    for operation, values in OPERATIONS.items():
        if operation not in known:
            continue
        made = node(tree, "ShaderNodeMath", *values)
        made.operation = operation
        ours, theirs, _ = both(card, made.outputs[0], tmp_path)
        if np.abs(ours - theirs).max() > COLOUR_NODES:
            wrong[operation] = (float(ours[0]), float(theirs[0]))
    assert wrong == {}


def test_a_blackbody_has_cycles_colour(card: Any, tmp_path: Path) -> None:
    ours, theirs, _ = both(card, node(card[1], "ShaderNodeBlackbody", 3200.0).outputs[0], tmp_path)
    np.testing.assert_allclose(ours, theirs, atol=BLACKBODY_FITS)


@pytest.mark.parametrize("texture", ["Noise", "Checker", "Brick", "Voronoi", "Wave", "Gradient", "Magic"])
def test_a_pattern_becomes_its_mean_and_is_noted(card: Any, tmp_path: Path, texture: str) -> None:
    """Through a ramp, so that the mean of the colours is not the colour of the mean."""
    scene, tree, _ = card
    scene.camera.data.ortho_scale, scene.cycles.samples = 3.9, 16
    small_picture(scene, 32, 32)
    pattern = tree.nodes.new(f"ShaderNodeTex{texture}")
    mapping = node(tree, "ShaderNodeMapping")
    mapping.inputs["Location"].default_value = (0.5, 0.5, 0.31)
    if texture == "Gradient":  # from 0 to 1 over the card
        mapping.inputs["Scale"].default_value = (0.25, 0.25, 0.25)
    place = tree.nodes.new("ShaderNodeNewGeometry")
    tree.links.new(place.outputs["Position"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], pattern.inputs["Vector"])
    made = tree.nodes.new("ShaderNodeValToRGB")
    made.color_ramp.elements[0].color, made.color_ramp.elements[1].color = (0, 0, 0, 1), (0.9, 0.5, 0.1, 1)
    made.color_ramp.elements[0].position = 0.4
    if texture in ("Checker", "Brick"):
        output = pattern.outputs["Color"]
    else:
        factor = next(socket for socket in pattern.outputs if socket.type == "VALUE")
        tree.links.new(factor, made.inputs[0])
        output = made.outputs[0]
    ours, theirs, notes = both(card, output, tmp_path)
    assert any(f"the pattern of '{pattern.name}'" in note for note in notes)
    np.testing.assert_allclose(ours, theirs, atol=MEAN_OF_A_PATTERN)


def test_what_is_not_understood_is_noted(card: Any) -> None:
    _, tree, target = card
    tree.links.new(tree.nodes.new("ShaderNodeAttribute").outputs["Color"], target)
    chains = ColourChains()
    assert chains.colour(target) == (0.5, 0.5, 0.5)
    assert chains.notes == ["'Attribute' is not understood; a middle value stands for it"]
