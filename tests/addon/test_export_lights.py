"""Lights and world: the same units as Cycles, measured against Cycles itself, and notes on what is approximated."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon.operators import render_layers
from tests.addon.building import add_light, add_plane, combined, look_down, small_picture, white_material
from tests.tolerances import EXPOSURE_AGAINST_CYCLES

pytestmark = pytest.mark.bpy

TILT = (0.3, 0.2, 0.0)
LAMPS: dict[str, tuple[str, float, dict[str, Any]]] = {
    "point": ("POINT", 500.0, {"shadow_soft_size": 0.0}),
    "sun": ("SUN", 2.5, {"angle": 0.0}),
    "spot, on its axis": ("SPOT", 700.0, {"shadow_soft_size": 0.0, "spot_size": 1.0, "spot_blend": 0.3}),
    "spot, in its soft edge": ("SPOT", 700.0, {"shadow_soft_size": 0.0, "spot_size": 1.0, "spot_blend": 1.0}),
    "tinted point": ("POINT", 500.0, {"shadow_soft_size": 0.0, "color": (0.9, 0.5, 0.2)}),
    "area, on its axis": ("AREA", 300.0, {"size": 0.02}),
}
NEW_LAMPS: dict[str, tuple[str, float, dict[str, Any]]] = {  # properties that lights have from 4.5 on
    "point with exposure": ("POINT", 100.0, {"shadow_soft_size": 0.0, "exposure": 1.5}),
    "point that is not normalised": ("POINT", 50.0, {"shadow_soft_size": 0.2, "normalize": False}),
    "spot that is not normalised": ("SPOT", 50.0, {"shadow_soft_size": 0.2, "normalize": False, "spot_size": 1.0}),
    "sun that is not normalised": ("SUN", 30.0, {"angle": 0.1, "normalize": False}),
}


def luminance(scene: Any, engine: str, path: Path) -> float:
    scene.render.engine = engine
    red, green, blue, _ = combined(scene, str(path)).mean(axis=(0, 1))
    return float(0.2126 * red + 0.7152 * green + 0.0722 * blue)


@pytest.fixture
def card(scene: Any) -> Any:
    """A white card, seen from above in a picture small enough to be evenly lit."""
    add_plane(scene, white_material())
    look_down(scene)
    small_picture(scene, 4, 4)
    scene.cycles.samples, scene.cycles.use_denoising = 64, False
    return scene


@pytest.mark.parametrize("lamp", [*LAMPS, *NEW_LAMPS])
def test_white_card_is_as_bright_as_in_cycles(card: Any, tmp_path: Path, lamp: str) -> None:
    kind, energy, properties = {**LAMPS, **NEW_LAMPS}[lamp]
    known = getattr(bpy.types, f"{kind.title()}Light").bl_rna.properties
    missing = [name for name in properties if name not in known]
    if missing:
        pytest.skip(f"lights have no {', '.join(missing)} in Blender {bpy.app.version_string}")
    light = add_light(card, kind, energy, (0, 0, 3), **properties)
    if "soft edge" in lamp:
        light.rotation_euler = TILT
    ours = luminance(card, "DICHROMATIC", tmp_path / "ours.exr")
    theirs = luminance(card, "CYCLES", tmp_path / "theirs.exr")
    assert theirs > 0.05
    assert ours == pytest.approx(theirs, rel=EXPOSURE_AGAINST_CYCLES)


def test_grey_card_under_a_white_sun_is_its_reflectance(card: Any, tmp_path: Path) -> None:
    """A sun of strength pi shows a surface as bright as its reflectance: the definition of the scale."""
    add_light(card, "SUN", math.pi, angle=0.0)
    assert luminance(card, "DICHROMATIC", tmp_path / "card.exr") == pytest.approx(1.0, rel=1e-3)


def test_lights_are_found_in_instanced_collections(card: Any) -> None:
    light = add_light(card, "POINT", 10.0, (1, 2, 3))
    collection = bpy.data.collections.new("Rig")
    collection.objects.link(light)
    card.collection.objects.unlink(light)
    for height in (0.0, 5.0):
        empty = bpy.data.objects.new("Rig", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location.z = height
        card.collection.objects.link(empty)
    lights = render_layers(card)[0].exported.scene.lights
    assert sorted(tuple(light.position) for light in lights) == [(1, 2, 3), (1, 2, 8)]


@pytest.mark.parametrize(
    ("kind", "energy", "properties", "words"),
    [
        ("AREA", 10.0, {}, "area light 'Area' is approximated"),
        ("POINT", -3.0, {}, "negative strength"),
        ("POINT", 10.0, {"use_shadow": False}, "casts shadows although"),
        ("POINT", 10.0, {"shadow_soft_size": 0.3}, "hard shadow"),
        ("SUN", 10.0, {"angle": 0.1}, "hard shadow"),
        ("SPOT", 10.0, {"use_square": True}, "square cone"),
    ],
)
def test_what_is_approximated_is_noted(
    card: Any, kind: str, energy: float, properties: dict[str, Any], words: str
) -> None:
    add_light(card, kind, energy, **properties)
    assert any(words in note for note in render_layers(card)[0].exported.notes)


def test_plain_lights_leave_no_note(card: Any) -> None:
    add_light(card, "POINT", 10.0, shadow_soft_size=0.0)
    add_light(card, "SUN", 1.0, angle=0.0)
    notes = [note for note in render_layers(card)[0].exported.notes if "material" not in note]
    assert notes == []


def background(scene: Any, colour: tuple[float, float, float], strength: float) -> Any:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    node = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")
    node.inputs["Color"].default_value = (*colour, 1.0)
    node.inputs["Strength"].default_value = strength
    scene.world = world
    return node


def test_world_shows_its_colour(scene: Any, tmp_path: Path) -> None:
    background(scene, (0.2, 0.4, 0.1), 1.5)
    look_down(scene)
    small_picture(scene, 4, 4)
    pixels = combined(scene, str(tmp_path / "world.exr"))
    np.testing.assert_allclose(pixels[0, 0, :3], (0.3, 0.6, 0.15), atol=2e-3)  # the uplift's own colour error


def test_linked_background_is_noted(scene: Any) -> None:
    node = background(scene, (0.2, 0.4, 0.1), 1.0)
    texture = scene.world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    scene.world.node_tree.links.new(texture.outputs[0], node.inputs["Color"])
    look_down(scene)
    small_picture(scene, 4, 4)
    assert any("linked to Color" in note for note in render_layers(scene)[0].exported.notes)


def test_transparent_film_has_no_background(scene: Any, tmp_path: Path) -> None:
    background(scene, (1.0, 1.0, 1.0), 1.0)
    scene.render.film_transparent = True
    add_plane(scene, white_material(), size=0.04)  # covers the middle of the picture
    add_light(scene, "SUN", math.pi)
    look_down(scene)
    small_picture(scene, 10, 10)
    scene.dichromatic.pixel_filter, scene.dichromatic.filter_width = "box", 1.0
    pixels = combined(scene, str(tmp_path / "film.exr"))
    assert pixels[0, 0].tolist() == [0, 0, 0, 0]
    np.testing.assert_allclose(pixels[5, 5], (1, 1, 1, 1), atol=2e-3)
