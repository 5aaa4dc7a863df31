"""Small scenes for the tests of the add-on, made through Blender's data and not its operators."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np

__all__ = [
    "add_camera",
    "add_light",
    "add_mesh",
    "add_plane",
    "combined",
    "grey_material",
    "look_down",
    "small_picture",
    "white_material",
]


def add_mesh(
    scene: Any, name: str, vertices: Sequence[Sequence[float]], faces: Sequence[Sequence[int]], *materials: Any
) -> Any:
    """A mesh object; one material slot for each material, None for an empty one."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    for material in materials:
        mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(made)
    return made


def add_plane(scene: Any, *materials: Any, size: float = 10.0, name: str = "Plane", height: float = 0.0) -> Any:
    half = size / 2
    corners = [(-half, -half, height), (half, -half, height), (half, half, height), (-half, half, height)]
    return add_mesh(scene, name, corners, [(0, 1, 2, 3)], *materials)


def white_material(name: str = "White") -> Any:
    """A perfect diffuser of the same colour for this engine and for Cycles."""
    return grey_material(1.0, name)


def grey_material(reflectance: float = 0.18, name: str = "Grey Card") -> Any:
    """A matte surface of the same reflectance for this engine and for Cycles."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (reflectance, reflectance, reflectance, 1.0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def add_light(scene: Any, kind: str, energy: float, location: Sequence[float] = (0, 0, 4), **properties: Any) -> Any:
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    for name, value in properties.items():
        setattr(data, name, value)
    made = bpy.data.objects.new(kind.title(), data)
    made.location = location
    scene.collection.objects.link(made)
    return made


def add_camera(scene: Any, location: Sequence[float] = (0, 0, 10), rotation: Sequence[float] = (0, 0, 0)) -> Any:
    made = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    made.location, made.rotation_euler = location, rotation
    scene.collection.objects.link(made)
    scene.camera = made
    return made


def look_down(scene: Any, width: float = 0.1) -> Any:
    """An orthographic camera over the origin that sees a square of `width` metres."""
    camera = add_camera(scene)
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = width
    return camera


def small_picture(scene: Any, width: int = 16, height: int = 16) -> None:
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"


def combined(scene: Any, path: str) -> np.ndarray:
    """Render with the scene's engine as F12 does, and return the linear pixels (H, W, 4), row 0 at the top."""
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    assert math.isfinite(float(pixels.sum()))
    return pixels.reshape(height, width, 4)[::-1]
