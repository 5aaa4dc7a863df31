"""Five scenes as Cycles users make them, with the nodes that they use; the tests render them by both engines."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import bpy
import numpy as np

from tests.addon.building import add_camera, add_light, add_mesh, add_plane

__all__ = ["SCENES", "build"]

Colour = Sequence[float]


def build(name: str) -> Any:
    """Make one of the scenes in an empty file and return it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 120, 80
    scene.view_settings.view_transform = "Standard"
    SCENES[name](scene)
    return scene


# ---- parts


def _material(name: str) -> tuple[Any, Any, Any]:
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]


def _node(tree: Any, kind: str, target: Any = None, output: str | int = 0, **values: Any) -> Any:
    node = tree.nodes.new(kind)
    for name, value in values.items():
        node.inputs[name.replace("_", " ")].default_value = value
    if target is not None:
        tree.links.new(node.outputs[output], target)
    return node


def _principled(name: str, colour: Colour, **values: Any) -> Any:
    material, tree, target = _material(name)
    _node(tree, "ShaderNodeBsdfPrincipled", target, Base_Color=(*colour, 1.0), **values)
    return material


def _ball(scene: Any, place: Sequence[float], radius: float, material: Any, name: str = "Ball") -> Any:
    """A smooth sphere of longitudes and latitudes, with UVs."""
    columns, rows = 48, 24
    vertices, faces = [], []
    for row in range(rows + 1):
        polar = math.pi * row / rows
        for column in range(columns + 1):
            around = 2.0 * math.pi * column / columns
            across = math.sin(polar)
            vertices.append((across * math.cos(around), across * math.sin(around), math.cos(polar)))
    for row in range(rows):
        for column in range(columns):
            first = row * (columns + 1) + column
            faces.append((first, first + columns + 1, first + columns + 2, first + 1))
    ball = add_mesh(scene, name, vertices, faces, material)
    layer = ball.data.uv_layers.new(name="UVMap")
    for loop in ball.data.loops:
        row, column = divmod(loop.vertex_index, columns + 1)
        layer.data[loop.index].uv = (column / columns, 1.0 - row / rows)
    for polygon in ball.data.polygons:
        polygon.use_smooth = True
    ball.location, ball.scale = place, (radius, radius, radius)
    return ball


def _floor(scene: Any, material: Any, size: float = 12.0) -> Any:
    floor = add_plane(scene, material, size=size, name="Floor")
    layer = floor.data.uv_layers.new(name="UVMap")
    for loop, uv in zip(floor.data.loops, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
        layer.data[loop.index].uv = uv
    return floor


def _image(name: str, pixels: np.ndarray, *, is_float: bool = False) -> Any:
    """An image of colours (H, W, 3), row 0 at the bottom: linear when it is float, else bytes of sRGB."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new(name, width, height, float_buffer=is_float)
    if is_float:
        image.colorspace_settings.name = "Linear Rec.709"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    return image


def _tiles() -> Any:
    """Terracotta and cream tiles with a dark joint."""
    rows, columns = np.mgrid[0:64, 0:64]
    is_light = ((rows // 32 + columns // 32) % 2 == 0)[..., None]
    pixels = np.where(is_light, (0.85, 0.78, 0.62), (0.62, 0.3, 0.2))
    pixels[(rows % 32 < 2) | (columns % 32 < 2)] = (0.2, 0.18, 0.16)
    return _image("Tiles", pixels)


def _world(scene: Any, colour: Colour, strength: float) -> tuple[Any, Any]:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    scene.world = world
    background = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = strength
    return world.node_tree, background


def _camera(scene: Any, place: Sequence[float], rotation: Sequence[float], lens: float = 40.0) -> None:
    add_camera(scene, place, rotation).data.lens = lens


# ---- the scenes


def _tiled_floor(scene: Any) -> None:
    """An image texture with a Mapping, adjusted by Hue/Saturation; plastics under a soft area light."""
    material, tree, target = _material("Tiles")
    shader = _node(tree, "ShaderNodeBsdfPrincipled", target, Roughness=0.6)
    hue = _node(tree, "ShaderNodeHueSaturation", shader.inputs["Base Color"])
    hue.inputs["Saturation"].default_value = 0.9
    texture = _node(tree, "ShaderNodeTexImage", hue.inputs["Color"])
    texture.image = _tiles()
    mapping = _node(tree, "ShaderNodeMapping", texture.inputs["Vector"], Scale=(4, 4, 1), Rotation=(0, 0, 0.4))
    _node(tree, "ShaderNodeTexCoord", mapping.inputs["Vector"], "UV")
    _floor(scene, material)
    for x, roughness, colour in (
        (-1.6, 0.55, (0.7, 0.1, 0.1)),
        (0.0, 0.3, (0.1, 0.4, 0.7)),
        (1.6, 0.8, (0.2, 0.5, 0.1)),
    ):
        _ball(scene, (x, 0, 0.7), 0.7, _principled(f"Plastic {roughness}", colour, Roughness=roughness))
    lamp = add_light(scene, "AREA", 400.0, (2.0, -2.5, 4.0), shape="RECTANGLE", size=2.0, size_y=1.0)
    lamp.rotation_euler = (0.55, 0.45, 0.0)
    _world(scene, (0.5, 0.6, 0.8), 0.25)
    _camera(scene, (0, -6.5, 2.8), (1.22, 0, 0))


def _mixed_shaders(scene: Any) -> None:
    """Mix and Add Shader, Fresnel, ramps and curves; a sun with an angle and a spot."""
    floor, tree, target = _material("Plaster")
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.35, 0.33, 0.3, 1), (0.6, 0.58, 0.55, 1)
    noise = _node(tree, "ShaderNodeTexNoise", ramp.inputs[0], Scale=60.0)
    assert noise.outputs[0].is_linked
    tree.links.new(ramp.outputs[0], _node(tree, "ShaderNodeBsdfDiffuse", target).inputs["Color"])
    _floor(scene, floor)

    varnish, tree, target = _material("Varnish")
    mix = _node(tree, "ShaderNodeMixShader", target)
    _node(tree, "ShaderNodeFresnel", mix.inputs[0], IOR=1.5)
    _node(tree, "ShaderNodeBsdfDiffuse", mix.inputs[1], Color=(0.5, 0.25, 0.08, 1))
    _node(tree, "ShaderNodeBsdfAnisotropic", mix.inputs[2], Color=(1, 1, 1, 1), Roughness=0.35)
    _ball(scene, (-1.6, 0, 0.7), 0.7, varnish)

    rust, tree, target = _material("Half Rusty")
    mix = _node(tree, "ShaderNodeMixShader", target)
    mix.inputs[0].default_value = 0.4
    _node(tree, "ShaderNodeBsdfPrincipled", mix.inputs[1], Base_Color=(0.6, 0.6, 0.62, 1), Metallic=1.0, Roughness=0.6)
    _node(tree, "ShaderNodeBsdfDiffuse", mix.inputs[2], Color=(0.4, 0.15, 0.05, 1))
    _ball(scene, (0.0, 0, 0.7), 0.7, rust)

    satin, tree, target = _material("Satin")
    both = _node(tree, "ShaderNodeAddShader", target)
    diffuse = _node(tree, "ShaderNodeBsdfDiffuse", both.inputs[0])
    curves = _node(tree, "ShaderNodeRGBCurve", diffuse.inputs["Color"])
    curves.inputs[1].default_value = (0.1, 0.3, 0.5, 1)
    curves.mapping.curves[3].points.new(0.5, 0.35)
    curves.mapping.update()
    _node(tree, "ShaderNodeBsdfAnisotropic", both.inputs[1], Color=(0.1, 0.12, 0.15, 1), Roughness=0.6)
    _ball(scene, (1.6, 0, 0.7), 0.7, satin)
    add_light(scene, "SUN", 2.5, angle=0.15).rotation_euler = (0.7, 0.3, 0.2)
    spot = add_light(scene, "SPOT", 250.0, (-2, -3, 4), shadow_soft_size=0.3, spot_size=1.0, spot_blend=0.5)
    spot.rotation_euler = (0.65, -0.4, 0.0)
    _world(scene, (0.6, 0.65, 0.7), 0.2)
    _camera(scene, (0, -6.5, 2.8), (1.22, 0, 0))


def _glowing_strips(scene: Any) -> None:
    """A corner lit by strips that glow, one of them by a blackbody; no lamp and no world."""
    walls = _principled("Wall", (0.3, 0.3, 0.32), Roughness=0.9, Specular_IOR_Level=0.0)
    _floor(scene, walls)
    back = add_plane(scene, walls, size=12.0, name="Back")
    back.location, back.rotation_euler = (0, 3.0, 2.0), (math.pi / 2, 0, 0)
    for name, place, colour, strength in (
        ("Warm", (-1.9, -1.4, 2.7), None, 7.0),
        ("Blue", (1.9, -1.4, 2.7), (0.15, 0.35, 1.0), 9.0),
    ):
        material, tree, target = _material(name)
        emission = _node(tree, "ShaderNodeEmission", target, Strength=strength)
        if colour is None:
            _node(tree, "ShaderNodeBlackbody", emission.inputs["Color"], Temperature=3000.0)
        else:
            emission.inputs["Color"].default_value = (*colour, 1.0)
        strip = add_plane(scene, material, size=1.0, name=name)
        strip.location, strip.rotation_euler, strip.scale = place, (-0.6, 0, 0), (2.6, 0.3, 1.0)
    _ball(scene, (-1.0, 0.2, 0.8), 0.8, _principled("Clay", (0.6, 0.45, 0.35), Roughness=0.7))
    _ball(scene, (1.0, 0.2, 0.8), 0.8, _principled("Paint", (0.7, 0.7, 0.65), Roughness=0.5))
    _camera(scene, (0, -7.0, 2.4), (1.35, 0, 0))


def _studio_sky(scene: Any) -> None:
    """Metals, a coat and glass under a picture of a sky that is turned by a Mapping."""
    tree, background = _world(scene, (1, 1, 1), 1.0)
    rows, columns = np.mgrid[0:32, 0:64]
    up = (rows - 15.5)[..., None] / 16.0
    sky = np.where(up > 0, (0.35, 0.5, 0.85) * (1.0 - 0.6 * up) + 0.25 * (1.0 - up), (0.18, 0.15, 0.12))
    sky[(rows > 19) & (rows < 25) & (columns > 8) & (columns < 16)] = (6.0, 5.5, 5.0)  # a window
    sky[(rows > 18) & (rows < 22) & (columns > 40) & (columns < 44)] = (4.0, 2.5, 1.5)
    texture = _node(tree, "ShaderNodeTexEnvironment", background.inputs["Color"])
    texture.image = _image("Sky", sky, is_float=True)
    mapping = _node(tree, "ShaderNodeMapping", texture.inputs["Vector"], Rotation=(0, 0, 1.9))
    _node(tree, "ShaderNodeTexCoord", mapping.inputs["Vector"], "Generated")
    _floor(scene, _principled("Table", (0.35, 0.33, 0.3), Roughness=0.8))
    _ball(scene, (-2.1, 0, 0.7), 0.7, _principled("Chrome", (0.8, 0.8, 0.82), Metallic=1.0, Roughness=0.05))
    _ball(scene, (-0.7, 0, 0.7), 0.7, _principled("Gold", (0.9, 0.6, 0.2), Metallic=1.0, Roughness=0.35))
    _ball(scene, (0.7, 0, 0.7), 0.7, _principled("Car Paint", (0.5, 0.05, 0.05), Roughness=0.5, Coat_Weight=1.0))
    glass, tree, target = _material("Glass")
    _node(tree, "ShaderNodeBsdfGlass", target, Color=(0.8, 0.9, 0.85, 1), Roughness=0.0, IOR=1.45)
    _ball(scene, (2.1, 0, 0.7), 0.7, glass)
    _camera(scene, (0, -6.5, 2.2), (1.3, 0, 0), 36.0)


def _scattered(scene: Any) -> None:
    """Instances that geometry nodes scatter over a floor, and a collection instance; a point light with a radius."""
    floor = _floor(scene, _principled("Ground", (0.3, 0.28, 0.22), Roughness=0.9))
    pebble = _ball(scene, (0, 0, -50.0), 1.0, _principled("Pebble", (0.55, 0.5, 0.42), Roughness=0.6), "Pebble")
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    points = tree.nodes.new("GeometryNodeDistributePointsOnFaces")
    points.inputs["Density"].default_value, points.inputs["Seed"].default_value = 1.2, 3
    source, place = tree.nodes.new("GeometryNodeObjectInfo"), tree.nodes.new("GeometryNodeInstanceOnPoints")
    source.inputs["Object"].default_value, source.inputs["As Instance"].default_value = pebble, True
    place.inputs["Scale"].default_value = (0.28, 0.28, 0.2)
    both = tree.nodes.new("GeometryNodeJoinGeometry")
    for a, b in (
        (start.outputs[0], points.inputs["Mesh"]),
        (points.outputs["Points"], place.inputs["Points"]),
        (source.outputs["Geometry"], place.inputs["Instance"]),
        (place.outputs[0], both.inputs[0]),
        (start.outputs[0], both.inputs[0]),
        (both.outputs[0], end.inputs[0]),
    ):
        tree.links.new(a, b)
    floor.modifiers.new("Scatter", "NODES").node_group = tree

    post = bpy.data.collections.new("Post")
    red = _principled("Red", (0.6, 0.06, 0.04), Roughness=0.5)
    for height, radius in ((0.4, 0.4), (1.1, 0.3)):
        ball = _ball(scene, (0, 0, height), radius, red)
        scene.collection.objects.unlink(ball)
        post.objects.link(ball)
    for x in (-1.2, 1.2):
        empty = bpy.data.objects.new("Post", None)
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", post, (x, 0, 0)
        scene.collection.objects.link(empty)
    add_light(scene, "POINT", 500.0, (-2.0, -3.0, 3.5), shadow_soft_size=0.4)
    _world(scene, (0.4, 0.5, 0.7), 0.3)
    _camera(scene, (0, -6.5, 2.8), (1.22, 0, 0))


SCENES: dict[str, Callable[[Any], None]] = {
    "tiled floor": _tiled_floor,
    "mixed shaders": _mixed_shaders,
    "glowing strips": _glowing_strips,
    "studio sky": _studio_sky,
    "scattered instances": _scattered,
}
