"""Lights and world: the same units as Cycles, measured against Cycles itself, and notes on what is approximated."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon.scene_export import export_scene
from dichromatic_addon.world_reading import read_world
from tests.addon.building import (
    add_camera,
    add_light,
    add_plane,
    combined,
    grey_material,
    look_down,
    small_picture,
    white_material,
)
from tests.tolerances import EDGES_OF_A_PICTURE, EXPOSURE_AGAINST_CYCLES, SAMPLES_AT_AN_EDGE

pytestmark = pytest.mark.bpy

TILT = (0.3, 0.2, 0.0)
LAMPS: dict[str, tuple[str, float, dict[str, Any]]] = {
    "point": ("POINT", 500.0, {"shadow_soft_size": 0.0}),
    "disk that turns to the card": ("POINT", 500.0, {"shadow_soft_size": 1.2}),
    "sphere": ("POINT", 500.0, {"shadow_soft_size": 1.2, "use_soft_falloff": False}),
    "sun": ("SUN", 2.5, {"angle": 0.0}),
    "sun with a disk": ("SUN", 2.5, {"angle": 1.0}),
    "spot, on its axis": ("SPOT", 700.0, {"shadow_soft_size": 0.0, "spot_size": 1.0, "spot_blend": 0.3}),
    "spot, in its soft edge": ("SPOT", 700.0, {"shadow_soft_size": 0.0, "spot_size": 1.0, "spot_blend": 1.0}),
    "spot with a radius": ("SPOT", 700.0, {"shadow_soft_size": 0.5, "spot_size": 1.0, "spot_blend": 0.3}),
    "tinted point": ("POINT", 500.0, {"shadow_soft_size": 0.0, "color": (0.9, 0.5, 0.2)}),
    "square": ("AREA", 300.0, {"shape": "SQUARE", "size": 2.0}),
    "rectangle": ("AREA", 300.0, {"shape": "RECTANGLE", "size": 3.0, "size_y": 0.5}),
    "disk": ("AREA", 300.0, {"shape": "DISK", "size": 2.0}),
    "ellipse": ("AREA", 300.0, {"shape": "ELLIPSE", "size": 3.0, "size_y": 0.5}),
    "spread": ("AREA", 300.0, {"shape": "SQUARE", "size": 1.0, "spread": 1.0}),
    "narrow spread, tilted": ("AREA", 300.0, {"shape": "DISK", "size": 1.0, "spread": 1.5}),
}
NEW_LAMPS: dict[str, tuple[str, float, dict[str, Any]]] = {  # properties that lights have from 4.5 on
    "point with exposure": ("POINT", 100.0, {"shadow_soft_size": 0.0, "exposure": 1.5}),
    "point that is not normalised": ("POINT", 50.0, {"shadow_soft_size": 0.2, "normalize": False}),
    "spot that is not normalised": ("SPOT", 50.0, {"shadow_soft_size": 0.2, "normalize": False, "spot_size": 1.0}),
    "sun that is not normalised": ("SUN", 30.0, {"angle": 0.1, "normalize": False}),
    "area that is not normalised": ("AREA", 30.0, {"shape": "ELLIPSE", "size": 1.0, "size_y": 0.5, "normalize": False}),
}


def exported_of(scene: Any) -> Any:
    """What the renderer is given, without rendering it."""
    return export_scene(bpy.context.evaluated_depsgraph_get())


def luminance(scene: Any, engine: str, path: Path) -> float:
    scene.render.engine = engine
    red, green, blue, _ = combined(scene, str(path)).mean(axis=(0, 1))
    return float(0.2126 * red + 0.7152 * green + 0.0722 * blue)


@pytest.fixture
def card(scene: Any) -> Any:
    """A grey card (0.18), seen from above in a picture small enough to be evenly lit."""
    add_plane(scene, grey_material())
    look_down(scene)
    small_picture(scene, 4, 4)
    scene.cycles.samples, scene.cycles.use_denoising = 400, False
    scene.dichromatic.samples = 256
    return scene


@pytest.mark.parametrize("lamp", [*LAMPS, *NEW_LAMPS])
def test_grey_card_is_as_bright_as_in_cycles(card: Any, tmp_path: Path, lamp: str) -> None:
    kind, energy, properties = {**LAMPS, **NEW_LAMPS}[lamp]
    known = getattr(bpy.types, f"{kind.title()}Light").bl_rna.properties
    missing = [name for name in properties if name not in known]
    if missing:
        pytest.skip(f"lights have no {', '.join(missing)} in Blender {bpy.app.version_string}")
    light = add_light(card, kind, energy, (0, 0, 3), **properties)
    if "soft edge" in lamp or "tilted" in lamp:
        light.rotation_euler = TILT
    ours = luminance(card, "DICHROMATIC", tmp_path / "ours.exr")
    theirs = luminance(card, "CYCLES", tmp_path / "theirs.exr")
    assert theirs > 0.01
    print(f"{lamp}: {ours:.5f}, Cycles {theirs:.5f}, {100 * (ours / theirs - 1):+.2f} %")
    assert ours == pytest.approx(theirs, rel=EXPOSURE_AGAINST_CYCLES)


def test_grey_card_under_a_white_sun_is_its_reflectance(card: Any, tmp_path: Path) -> None:
    """A sun of strength pi shows a surface as bright as its reflectance: the definition of the scale."""
    add_light(card, "SUN", math.pi, angle=0.0)
    assert luminance(card, "DICHROMATIC", tmp_path / "card.exr") == pytest.approx(0.18, rel=1e-3)


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
    lights = exported_of(card).scene.lights
    assert sorted(tuple(light.position) for light in lights) == [(1, 2, 3), (1, 2, 8)]


@pytest.mark.parametrize("how", ["emission mesh", "tilted emission mesh", "uniform world", "world with a picture"])
def test_grey_card_under_other_light_is_as_bright_as_in_cycles(card: Any, tmp_path: Path, how: str) -> None:
    if "mesh" in how:
        strip = add_plane(card, emissive(strength=5.0, colour=(1.0, 0.8, 0.5)), size=2.0, name="Strip")
        strip.location = (0.5, 0.0, 3.0)
        strip.rotation_euler = (0.6, 0.0, 0.0) if "tilted" in how else (0.0, 0.0, 0.0)
        strip.visible_camera = False
    elif how == "uniform world":
        background(card, (0.2, 0.4, 0.1), 1.5)
    else:
        picture_world(card, rotation=(0.3, 0.2, 1.0))
    card.dichromatic.samples = 256  # one place of the mesh or direction of the sky each
    ours = luminance(card, "DICHROMATIC", tmp_path / "ours.exr")
    theirs = luminance(card, "CYCLES", tmp_path / "theirs.exr")
    assert theirs > 0.01
    print(f"{how}: {ours:.5f}, Cycles {theirs:.5f}, {100 * (ours / theirs - 1):+.2f} %")
    assert ours == pytest.approx(theirs, rel=EXPOSURE_AGAINST_CYCLES)


def emissive(strength: float, colour: tuple[float, float, float]) -> Any:
    material = bpy.data.materials.new("Strip")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value, emission.inputs["Strength"].default_value = (*colour, 1.0), strength
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def picture_world(scene: Any, rotation: tuple[float, float, float]) -> Any:
    """A picture with a bright patch, a colour of its own in each quarter, and a turned Mapping."""
    node = background(scene, (1.0, 1.0, 1.0), 2.0)
    image = bpy.data.images.new("Sky", 32, 16, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    pixels = np.ones((16, 32, 4), np.float32)
    pixels[8:, :, :3] = (0.1, 0.2, 0.4)  # the upper half
    pixels[:8, :, :3] = (0.2, 0.1, 0.05)
    pixels[11:13, 5:8, :3] = (30.0, 25.0, 20.0)
    image.pixels.foreach_set(pixels.ravel())
    tree = scene.world.node_tree
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    texture.image = image
    mapping.inputs["Rotation"].default_value = rotation
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], node.inputs["Color"])
    return node


@pytest.mark.parametrize(
    ("kind", "energy", "properties", "words"),
    [
        ("POINT", -3.0, {}, "negative strength"),
        ("AREA", 10.0, {"size": 0.0}, "no area"),
        ("SPOT", 10.0, {"use_square": True}, "square cone"),
    ],
)
def test_what_is_approximated_is_noted(
    card: Any, kind: str, energy: float, properties: dict[str, Any], words: str
) -> None:
    add_light(card, kind, energy, **properties)
    assert any(words in note for note in exported_of(card).notes)


def test_plain_lights_leave_no_note(card: Any) -> None:
    add_light(card, "POINT", 10.0, shadow_soft_size=0.1, use_shadow=False)
    add_light(card, "SUN", 1.0, angle=0.1)
    add_light(card, "AREA", 1.0, shape="ELLIPSE", spread=1.0)
    portal = add_light(card, "AREA", 1.0)
    portal.data.cycles.is_portal = True  # helps Cycles to sample, and gives no light
    exported = exported_of(card)
    assert [note for note in exported.notes if "material" not in note] == []
    assert len(exported.scene.lights) == 3


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


def test_world_picture_is_seen_as_cycles_shows_it(scene: Any, tmp_path: Path) -> None:
    picture_world(scene, rotation=(0.3, 0.2, 1.0))
    camera = add_camera(scene, (0, 0, 0), (1.2, 0.1, 0.4))
    camera.data.angle = 2.5
    small_picture(scene, 96, 64)
    scene.cycles.samples, scene.cycles.use_denoising, scene.dichromatic.samples = 16, False, 16
    pictures = {}
    for engine in ("DICHROMATIC", "CYCLES"):
        scene.render.engine = engine
        pictures[engine] = combined(scene, str(tmp_path / f"{engine}.exr"))[..., :3]
    difference = np.abs(pictures["DICHROMATIC"] - pictures["CYCLES"]).mean()
    assert difference < EDGES_OF_A_PICTURE * pictures["CYCLES"].mean()


def test_a_picture_of_the_world_is_worked_out_once_and_as_behind_a_node_that_changes_nothing(scene: Any) -> None:
    node = picture_world(scene, rotation=(0.3, 0.2, 1.0))
    first, again = (read_world(scene.world, [], pictures) for pictures in ("read", "kept"))
    assert again.image.pixels is first.image.pixels
    tree = scene.world.node_tree
    mapping = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.5)
    turned = read_world(scene.world, [], "kept")
    assert turned.image.pixels is first.image.pixels
    assert not np.allclose(turned.image.rotation, first.image.rotation)
    gamma = tree.nodes.new("ShaderNodeGamma")
    gamma.inputs["Gamma"].default_value = 1.0
    tree.links.new(node.inputs["Color"].links[0].from_socket, gamma.inputs["Color"])
    tree.links.new(gamma.outputs[0], node.inputs["Color"])
    np.testing.assert_allclose(read_world(scene.world, [], "kept").image.pixels, first.image.pixels, rtol=1e-6)
    tree.links.new(gamma.inputs["Color"].links[0].from_socket, node.inputs["Color"])
    painted = bpy.data.images["Sky"]
    painted.pixels[0] = 7.0
    changed = read_world(scene.world, [], "kept").image.pixels
    assert changed is not first.image.pixels
    assert changed[-1, 0, 0] == pytest.approx(7.0, rel=1e-5)  # the image's first row is the lowest


def test_a_picture_without_pixels_is_named(scene: Any) -> None:
    picture_world(scene, rotation=(0.0, 0.0, 0.0))
    texture = next(n for n in scene.world.node_tree.nodes if n.bl_idname == "ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.new("Lost", 4, 4)
    texture.image.source, texture.image.filepath = "FILE", "//nowhere.exr"
    with pytest.raises(core.SceneError, match="world 'World': image 'Lost' has no pixels: the file"):
        read_world(scene.world, [])


def test_world_of_the_background_only(card: Any, tmp_path: Path) -> None:
    background(card, (1.0, 1.0, 1.0), 1.0)
    card.world.dichromatic.lights_surfaces = False
    assert luminance(card, "DICHROMATIC", tmp_path / "dark.exr") == 0.0


def test_camera_rays_may_see_another_background(card: Any) -> None:
    """The light counts: what surfaces see is kept."""
    node = background(card, (0.5, 0.5, 0.5), 1.0)
    tree = card.world.node_tree
    seen, mix, path = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Background", "MixShader", "LightPath"))
    seen.inputs["Color"].default_value = (0.9, 0.1, 0.1, 1.0)
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(node.outputs[0], mix.inputs[1])
    tree.links.new(seen.outputs[0], mix.inputs[2])
    output = next(item for item in tree.nodes if item.bl_idname == "ShaderNodeOutputWorld")
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    exported = exported_of(card)
    assert exported.scene.world.strength == pytest.approx(0.5)
    assert any("the camera sees the background" in note for note in exported.notes)


@pytest.mark.parametrize(
    ("kind", "words"), [("ShaderNodeTexSky", "'Sky Texture' is not understood"), ("ShaderNodeTexNoise", "the pattern")]
)
def test_worlds_that_are_approximated_are_noted(card: Any, kind: str, words: str) -> None:
    node = background(card, (0.2, 0.4, 0.1), 1.0)
    texture = card.world.node_tree.nodes.new(kind)
    card.world.node_tree.links.new(texture.outputs["Color"], node.inputs["Color"])
    exported = exported_of(card)
    assert sum(words in note for note in exported.notes) == 1
    assert exported.scene.world.strength == pytest.approx(0.5, rel=0.1)


def test_colours_of_a_picture_may_be_changed_by_nodes(card: Any) -> None:
    picture_world(card, rotation=(0.0, 0.0, 0.0))
    before = exported_of(card).scene.world.image.pixels
    tree = card.world.node_tree
    gamma = tree.nodes.new("ShaderNodeGamma")
    gamma.inputs["Gamma"].default_value = 2.0
    node = next(item for item in tree.nodes if item.bl_idname == "ShaderNodeBackground")
    tree.links.new(node.inputs["Color"].links[0].from_socket, gamma.inputs[0])
    tree.links.new(gamma.outputs[0], node.inputs["Color"])
    np.testing.assert_allclose(exported_of(card).scene.world.image.pixels, before**2, rtol=1e-5)


def light_tree(light: Any) -> tuple[Any, Any]:
    """The tree of a light and its emission node."""
    if not getattr(light, "node_tree", None):
        light.use_nodes = True
    tree = light.node_tree
    return tree, next(node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission")


@pytest.mark.parametrize("nodes", ["strength", "colour", "blackbody", "falloff"])
def test_nodes_of_a_light_count_as_in_cycles(card: Any, tmp_path: Path, nodes: str) -> None:
    light = add_light(card, "POINT", 500.0, (0, 0, 3), shadow_soft_size=0.0).data
    tree, emission = light_tree(light)
    if nodes == "strength":
        emission.inputs["Strength"].default_value = 0.3
    elif nodes == "colour":
        light.color = (1.0, 0.8, 0.9)
        emission.inputs["Color"].default_value = (0.2, 0.5, 0.3, 1.0)
    elif nodes == "falloff":
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        falloff.inputs["Strength"].default_value = 0.7
        tree.links.new(falloff.outputs["Quadratic"], emission.inputs["Strength"])
    else:
        body = tree.nodes.new("ShaderNodeBlackbody")
        body.inputs[0].default_value = 3000.0
        tree.links.new(body.outputs[0], emission.inputs["Color"])
        assert exported_of(card).scene.lights[0].illuminant == core.blackbody(3000.0)
    ours = luminance(card, "DICHROMATIC", tmp_path / "ours.exr")
    theirs = luminance(card, "CYCLES", tmp_path / "theirs.exr")
    assert ours == pytest.approx(theirs, rel=EXPOSURE_AGAINST_CYCLES)


def test_an_ies_profile_is_noted(card: Any) -> None:
    light = add_light(card, "POINT", 500.0, (0, 0, 3), shadow_soft_size=0.0).data
    tree, emission = light_tree(light)
    profile = tree.nodes.new("ShaderNodeTexIES")
    profile.inputs["Strength"].default_value = 0.5
    tree.links.new(profile.outputs[0], emission.inputs["Strength"])
    exported = exported_of(card)
    assert any("light 'Point': the distribution of 'IES Texture'" in note for note in exported.notes)
    assert exported.scene.lights[0].strength == pytest.approx(250.0)


def linked_collection(members: list[Any], state: str) -> Any:
    collection = bpy.data.collections.new("Linked")
    for member in members:
        collection.objects.link(member)
    for link in collection.collection_objects:
        link.light_linking.link_state = state
    return collection


def halves(scene: Any, tmp_path: Path) -> dict[str, tuple[float, float]]:
    """How bright the left and the right of two white planes are, with either engine."""
    look_down(scene, 1.6)
    small_picture(scene, 8, 4)
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.max_bounces = 16, False, 0
    found = {}
    for engine in ("DICHROMATIC", "CYCLES"):
        scene.render.engine = engine
        pixels = combined(scene, str(tmp_path / f"{engine}.exr"))[..., 0]
        found[engine] = (pixels[:, 1:3].mean(), pixels[:, 5:7].mean())
    return found


def add_pair(scene: Any, names: tuple[str, str], height: float = 0.0) -> list[Any]:
    pair = []
    for name, x in zip(names, (-0.5, 0.5), strict=True):
        plane = add_plane(scene, bpy.data.materials.get("White") or white_material(), size=1.0, name=name)
        plane.location = (x, 0.0, height)
        plane.visible_camera = height == 0.0
        pair.append(plane)
    return pair


@pytest.mark.parametrize(
    ("members", "state", "expected"),
    [(1, "INCLUDE", (1.0, 0.0)), (1, "EXCLUDE", (0.0, 1.0)), (0, "INCLUDE", (1.0, 1.0)), (2, "EXCLUDE", (0.0, 0.0))],
)
def test_light_linking(scene: Any, tmp_path: Path, members: int, state: str, expected: tuple[float, float]) -> None:
    planes = add_pair(scene, ("Left", "Right"))
    sun = add_light(scene, "SUN", math.pi, angle=0.0)
    sun.light_linking.receiver_collection = linked_collection(planes[:members], state)
    for engine, found in halves(scene, tmp_path).items():
        np.testing.assert_allclose(found, expected, atol=SAMPLES_AT_AN_EDGE, err_msg=engine)


@pytest.mark.parametrize("kind", ["SUN", "POINT", "AREA"])
@pytest.mark.parametrize(
    ("members", "state", "expected"),
    [(1, "INCLUDE", (0.0, 1.0)), (1, "EXCLUDE", (1.0, 0.0)), (0, "INCLUDE", (0.0, 0.0)), (2, "EXCLUDE", (1.0, 1.0))],
)
def test_shadow_linking(
    scene: Any, tmp_path: Path, kind: str, members: int, state: str, expected: tuple[float, float]
) -> None:
    """Of two roofs, none or some hide the light; in Cycles the same."""
    add_pair(scene, ("Left", "Right"))
    roofs = add_pair(scene, ("Left Roof", "Right Roof"), height=0.2)
    size = {"SUN": {"angle": 0.0}, "POINT": {"shadow_soft_size": 0.05}, "AREA": {"size": 0.1}}[kind]
    # A lamp so far away that the planes are evenly lit, as strong as the sun there.
    energy = {"SUN": math.pi, "POINT": 4.0 * math.pi**2 * 50.0**2, "AREA": math.pi**2 * 50.0**2}[kind]
    lamp = add_light(scene, kind, energy, (0.0, 0.0, 50.0), **size)
    lamp.light_linking.blocker_collection = linked_collection(roofs[:members], state)
    for engine, found in halves(scene, tmp_path).items():
        np.testing.assert_allclose(found, expected, atol=SAMPLES_AT_AN_EDGE, err_msg=engine)
    assert not any("linking" in note for note in exported_of(scene).notes)


def test_linking_of_a_surface_that_emits_is_noted(card: Any) -> None:
    strip = add_plane(card, emissive(strength=5.0, colour=(1.0, 0.8, 0.5)), size=2.0, name="Strip")
    strip.light_linking.blocker_collection = bpy.data.collections.new("Blockers")
    assert any("light linking of 'Strip' is not rendered" in note for note in exported_of(card).notes)


def test_a_light_without_shadow_shines_through(card: Any, tmp_path: Path) -> None:
    roof = add_plane(card, bpy.data.materials["Grey Card"], size=4.0, name="Roof")
    roof.location.z, roof.visible_camera = 1.0, False
    light = add_light(card, "POINT", 500.0, (0, 0, 3), shadow_soft_size=0.0).data
    assert luminance(card, "DICHROMATIC", tmp_path / "shadow.exr") == 0.0
    light.use_shadow = False
    assert luminance(card, "DICHROMATIC", tmp_path / "light.exr") == pytest.approx(
        0.18 * 500.0 / (4.0 * math.pi * 9.0) / math.pi, rel=1e-3
    )


def test_transparent_film_has_no_background(scene: Any, tmp_path: Path) -> None:
    """What is not covered has no colour, but the world lights the card: 1 from the sun and 1 from all around."""
    background(scene, (1.0, 1.0, 1.0), 1.0)
    scene.render.film_transparent = True
    scene.dichromatic.samples = 256
    add_plane(scene, white_material(), size=0.04)  # covers the middle of the picture
    add_light(scene, "SUN", math.pi)
    look_down(scene)
    small_picture(scene, 10, 10)
    scene.dichromatic.pixel_filter, scene.dichromatic.filter_width = "box", 1.0
    pixels = combined(scene, str(tmp_path / "film.exr"))
    assert pixels[0, 0].tolist() == [0, 0, 0, 0]
    np.testing.assert_allclose(pixels[5, 5], (2, 2, 2, 1), rtol=EXPOSURE_AGAINST_CYCLES)
