"""Shared helpers for the scripts that make the sample files: profiles, turned and swept meshes, lamps, cameras, notes.

Everything here speaks of points and of Blender's data; the scenes themselves, with their numbers, are in the scripts
that use it. Lengths are metres, angles radians. Normals are those of the curve a mesh was made from, not averages over
its faces: a long cone beside a small fillet is shaded as the cone it is.
"""

from __future__ import annotations

import itertools
import math
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

__all__ = [
    "Curve",
    "add_camera",
    "add_grey_world",
    "add_note",
    "add_object",
    "add_point_light",
    "add_spot_light",
    "add_sun",
    "add_turned_uv",
    "empty_file",
    "extruded_mesh",
    "height_field",
    "join_parts",
    "new_mesh",
    "parallel",
    "rounded",
    "rounded_box",
    "save",
    "sphere",
    "swept_tube",
    "turned_body",
]

#: Vertices (V, 3), faces (tuples of vertex indices) and vertex normals (V, 3) of one closed piece.
Part = tuple[np.ndarray, list[tuple[int, ...]], np.ndarray]


class Curve:
    """A plane curve as points (P, 2) with unit tangents (P, 2)."""

    def __init__(self, points: np.ndarray, tangents: np.ndarray) -> None:
        self.points = points
        self.tangents = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)

    def lengths(self) -> np.ndarray:
        """Arc length from the first point, (P,)."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def resampled(self, count: int) -> Curve:
        """Return the same curve with `count` points at equal distances along it."""
        lengths = self.lengths()
        wanted = np.linspace(0.0, lengths[-1], count)
        points = np.column_stack([np.interp(wanted, lengths, self.points[:, axis]) for axis in (0, 1)])
        tangents = np.column_stack([np.interp(wanted, lengths, self.tangents[:, axis]) for axis in (0, 1)])
        return Curve(points, tangents)

    def smoothed(self, rounds: int) -> Curve:
        """Return the same curve with each point moved towards its neighbours' mean, `rounds` times.

        It spreads the jump of curvature between straight pieces and arcs, which a highlight would show as a kink. The
        two points at either end keep their places, and with them the direction there.
        """
        points = self.points.copy()
        for _ in range(rounds):
            points[2:-2] = 0.25 * points[1:-3] + 0.5 * points[2:-2] + 0.25 * points[3:-1]
        return Curve(points, np.gradient(points, axis=0))


def rounded(corners: Sequence[tuple[float, float, float]], tolerance: float = 1.2e-5) -> Curve:
    """Polyline whose corners are replaced by tangent arcs.

    Each corner is ``(x, y, radius)``; the first and last radius are ignored. A corner of radius zero stays sharp and is
    given twice, once with either tangent, so that the mesh has its edge there. Chords leave the arcs by `tolerance`
    metres at most, and turn 15 degrees at most.
    """
    vertices = [np.array(corner[:2], dtype=float) for corner in corners]
    points: list[np.ndarray] = [vertices[0]]
    tangents: list[np.ndarray] = [vertices[1] - vertices[0]]
    for before, here, after, (*_, radius) in zip(vertices, vertices[1:], vertices[2:], corners[1:], strict=False):
        arriving = (here - before) / np.linalg.norm(here - before)
        leaving = (after - here) / np.linalg.norm(after - here)
        turn = math.atan2(arriving[0] * leaving[1] - arriving[1] * leaving[0], float(arriving @ leaving))
        if abs(turn) < 1e-9:
            continue
        if radius == 0.0:
            points += [here, here]
            tangents += [arriving, leaving]
            continue
        reach = radius * math.tan(abs(turn) / 2.0)
        shortest = min(np.linalg.norm(here - before), np.linalg.norm(after - here))
        if reach > shortest:
            raise ValueError(f"corner {tuple(here)}: an arc of radius {radius} needs {reach:.5f} m of its shorter side")
        start = here - reach * arriving
        side = math.copysign(1.0, turn)
        centre = start + radius * side * np.array([-arriving[1], arriving[0]])
        step = min(math.radians(15.0), 2.0 * math.acos(1.0 - tolerance / radius))
        count = max(2, math.ceil(abs(turn) / step))
        for angle in np.linspace(0.0, turn, count + 1):
            cos, sin = math.cos(angle), math.sin(angle)
            turned = np.array([[cos, -sin], [sin, cos]])
            points.append(centre + turned @ (start - centre))
            tangents.append(turned @ arriving)
    points.append(vertices[-1])
    tangents.append(vertices[-1] - vertices[-2])
    return Curve(np.array(points), np.array(tangents))


def parallel(corners: Sequence[tuple[float, float, float]], distance: float) -> list[tuple[float, float, float]]:
    """Corners of the polyline that runs `distance` to the left, its arcs about the same centres."""
    points = [np.array(corner[:2], dtype=float) for corner in corners]
    result: list[tuple[float, float, float]] = []
    for index, (x, y, radius) in enumerate(corners):
        sides = []
        for a, b in ((index - 1, index), (index, index + 1)):
            if a >= 0 and b < len(points):
                along = (points[b] - points[a]) / np.linalg.norm(points[b] - points[a])
                sides.append(np.array([-along[1], along[0]]))
        mitre = sum(sides) / (1.0 + float(sides[0] @ sides[-1])) if len(sides) == 2 else sides[0]
        turns_left = len(sides) == 2 and sides[0][0] * sides[1][1] - sides[0][1] * sides[1][0] > 0.0
        moved = radius - distance if turns_left else radius + distance
        if len(sides) == 2 and moved <= 0.0:
            raise ValueError(f"corner ({x}, {y}): its arc of radius {radius} has no parallel at {distance}")
        result.append((x + distance * mitre[0], y + distance * mitre[1], moved))
    return result


def turned_body(profile: Curve, segments: int) -> Part:
    """Body of revolution about z from a profile in (radius, z), the outside on the right of its course.

    A profile that begins or ends on the axis is closed there by a fan.
    """
    angles = 2.0 * math.pi * np.arange(segments) / segments
    cos, sin = np.cos(angles), np.sin(angles)
    vertices: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    rings: list[np.ndarray] = []
    count = 0
    for (radius, height), (along, up) in zip(profile.points, profile.tangents, strict=True):
        if radius < 1e-9:
            vertices.append(np.array([[0.0, 0.0, height]]))
            normals.append(np.array([[0.0, 0.0, -math.copysign(1.0, along)]]))
            rings.append(np.array([count]))
            count += 1
            continue
        vertices.append(np.stack([radius * cos, radius * sin, np.full(segments, height)], axis=1))
        normals.append(np.stack([up * cos, up * sin, np.full(segments, -along)], axis=1))
        rings.append(count + np.arange(segments))
        count += segments
    faces: list[tuple[int, ...]] = []
    for index, (low, high) in enumerate(itertools.pairwise(rings)):
        if np.allclose(profile.points[index], profile.points[index + 1]):
            continue  # the two sides of a sharp corner
        for i in range(segments):
            j = (i + 1) % segments
            if len(low) == 1:
                faces.append((int(low[0]), int(high[j]), int(high[i])))
            elif len(high) == 1:
                faces.append((int(low[i]), int(low[j]), int(high[0])))
            else:
                faces.append((int(low[i]), int(low[j]), int(high[j]), int(high[i])))
    return np.concatenate(vertices), faces, np.concatenate(normals)


def rounded_box(width: float, depth: float, height: float, radius: float, steps: int = 3) -> Part:
    """Build a box about the origin with edges rounded to `radius` and flat faces between them."""
    half = 0.5 * np.array([width, depth, height])
    angles = np.linspace(0.0, 0.5 * math.pi, steps + 1)
    # The box is a sphere of the edges' radius, cut along its three planes of symmetry and drawn apart: a grid of
    # longitudes and latitudes, in which those at the cuts are there twice.
    longitudes = np.concatenate([angles + quarter * 0.5 * math.pi for quarter in range(4)])
    latitudes = np.concatenate([angles - 0.5 * math.pi, angles])
    round_x, round_y = np.cos(longitudes), np.sin(longitudes)
    sign_x = np.repeat([1.0, -1.0, -1.0, 1.0], steps + 1)
    sign_y = np.repeat([1.0, 1.0, -1.0, -1.0], steps + 1)
    sign_z = np.repeat([-1.0, 1.0], steps + 1)
    flat = half - radius
    normals = np.stack(
        [
            np.outer(np.cos(latitudes), round_x),
            np.outer(np.cos(latitudes), round_y),
            np.outer(np.sin(latitudes), np.ones_like(round_x)),
        ],
        axis=-1,
    )
    ones = np.ones((len(latitudes), len(longitudes)))
    corners = np.stack([ones * sign_x * flat[0], ones * sign_y * flat[1], ones * sign_z[:, None] * flat[2]], axis=-1)
    points = corners + radius * normals
    count = len(longitudes)
    faces: list[tuple[int, ...]] = []
    for k in range(len(latitudes) - 1):
        for i in range(count):
            j = (i + 1) % count
            faces.append((k * count + i, k * count + j, (k + 1) * count + j, (k + 1) * count + i))
    return _merged(
        points.reshape(-1, 3),
        [*faces, tuple(range(count))[::-1], tuple((len(latitudes) - 1) * count + i for i in range(count))],
        normals.reshape(-1, 3),
    )


def _merged(points: np.ndarray, faces: list[tuple[int, ...]], normals: np.ndarray) -> Part:
    """Merge vertices of equal place and normal, and drop what collapses with them."""
    _, first, inverse = np.unique(
        np.round(np.hstack([points, normals]), 9), axis=0, return_index=True, return_inverse=True
    )
    inverse = inverse.ravel()
    kept: list[tuple[int, ...]] = []
    for face in faces:
        ring = [int(inverse[index]) for index in face]
        ring = [here for here, before in zip(ring, ring[-1:] + ring[:-1], strict=True) if here != before]
        if len(ring) > 2:
            kept.append(tuple(ring))
    return points[first], kept, normals[first]


def height_field(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Part:
    """Build a sheet over a grid: x (C,), y (R,), z (R, C), seen from above, with the normals of the surface itself."""
    rows, columns = z.shape
    slope_y, slope_x = np.gradient(z, y, x)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(z)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    points = np.stack([*np.meshgrid(x, y), z], axis=-1)
    faces = [
        (r * columns + c, r * columns + c + 1, (r + 1) * columns + c + 1, (r + 1) * columns + c)
        for r in range(rows - 1)
        for c in range(columns - 1)
    ]
    return points.reshape(-1, 3), faces, normals.reshape(-1, 3)


def sphere(radius: float, segments: int, rings: int) -> Part:
    """Build a sphere about the origin, its poles on the z axis."""
    angles = np.linspace(-0.5 * math.pi, 0.5 * math.pi, rings + 1)
    points = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    points[[0, -1], 0] = 0.0
    return turned_body(Curve(points, np.column_stack([-np.sin(angles), np.cos(angles)])), segments)


def swept_tube(
    path: Curve, half_widths: np.ndarray, half_heights: np.ndarray, segments: int, squareness: float
) -> Part:
    """Tube along a path in the (x, z) plane whose section is a superellipse, closed at both ends.

    `half_widths` (P,) lie along y, `half_heights` (P,) in the plane of the path. `squareness` 2 is an ellipse, more is
    nearer to a rounded rectangle. The slope of the widths along the path is part of the normals.
    """
    angles = 2.0 * math.pi * np.arange(segments) / segments
    power = 2.0 / squareness
    across = np.sign(np.cos(angles)) * np.abs(np.cos(angles)) ** power
    upward = np.sign(np.sin(angles)) * np.abs(np.sin(angles)) ** power
    tangent = np.stack([path.tangents[:, 0], np.zeros(len(path.points)), path.tangents[:, 1]], axis=1)
    aside = np.tile([0.0, 1.0, 0.0], (len(path.points), 1))
    outward = np.cross(tangent, aside)
    centre = np.stack([path.points[:, 0], np.zeros(len(path.points)), path.points[:, 1]], axis=1)
    rings = (
        centre[:, None]
        + (half_widths[:, None] * across)[..., None] * aside[:, None]
        + (half_heights[:, None] * upward)[..., None] * outward[:, None]
    )
    # Normal of the surface: the cross product of its two directions, by central differences on the rings themselves.
    around = np.roll(rings, -1, axis=1) - np.roll(rings, 1, axis=1)
    along = np.gradient(rings, path.lengths(), axis=0)
    normals = np.cross(around, along)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    if np.sum(normals * (rings - centre[:, None])) < 0.0:
        normals = -normals
    count, faces = len(path.points), []
    for k in range(count - 1):
        for i in range(segments):
            j = (i + 1) % segments
            faces.append((k * segments + i, k * segments + j, (k + 1) * segments + j, (k + 1) * segments + i))
    first = tuple(range(segments))
    last = tuple((count - 1) * segments + i for i in range(segments))
    faces += [first[::-1], last]
    vertices, directions = rings.reshape(-1, 3), normals.reshape(-1, 3)
    one, two, three = (vertices[i] for i in faces[0][:3])
    if np.cross(two - one, three - one) @ directions[0] < 0.0:
        faces = [face[::-1] for face in faces]
    return vertices, faces, directions


def extruded_mesh(profile: Curve, half_width: float) -> Part:
    """Sheet from a profile in the (y, z) plane drawn out along x, facing to the left of the profile's course."""
    count = len(profile.points)
    left = np.column_stack([np.full(count, -half_width), profile.points])
    right = np.column_stack([np.full(count, half_width), profile.points])
    normal = np.column_stack([np.zeros(count), -profile.tangents[:, 1], profile.tangents[:, 0]])
    faces = [(i, count + i, count + i + 1, i + 1) for i in range(count - 1)]
    return np.concatenate([left, right]), faces, np.concatenate([normal, normal])


def join_parts(parts: Sequence[Part]) -> Part:
    """Several pieces as one."""
    offsets = np.cumsum([0] + [len(vertices) for vertices, _, _ in parts])
    faces = [
        tuple(index + int(offset) for index in face)
        for (_, part_faces, _), offset in zip(parts, offsets, strict=False)
        for face in part_faces
    ]
    return np.concatenate([part[0] for part in parts]), faces, np.concatenate([part[2] for part in parts])


def new_mesh(name: str, part: Part) -> bpy.types.Mesh:
    """Blender mesh with the part's own normals."""
    vertices, faces, normals = part
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices.tolist(), [], faces)
    mesh.shade_smooth()
    mesh.normals_split_custom_set_from_vertices(normals.tolist())
    if mesh.validate(verbose=False):
        raise ValueError(f"mesh {name!r}: Blender found faces to repair in it")
    return mesh


def add_turned_uv(mesh: bpy.types.Mesh) -> None:
    """Give a body of revolution about z a UV map: U runs around the axis, V along it."""
    layer = mesh.uv_layers.new(name="Turned")
    low = min(vertex.co.z for vertex in mesh.vertices)
    high = max(vertex.co.z for vertex in mesh.vertices)
    for polygon in mesh.polygons:
        centre = math.atan2(polygon.center.y, polygon.center.x)
        for corner in polygon.loop_indices:
            point = mesh.vertices[mesh.loops[corner].vertex_index].co
            on_axis = math.hypot(point.x, point.y) < 1e-9
            turn = 0.0 if on_axis else math.remainder(math.atan2(point.y, point.x) - centre, 2.0 * math.pi)
            layer.uv[corner].vector = ((centre + turn) / (2.0 * math.pi), (point.z - low) / (high - low))


def add_object(
    name: str,
    data: bpy.types.ID,
    location: Sequence[float] = (0.0, 0.0, 0.0),
    rotation: Sequence[float] = (0.0, 0.0, 0.0),
    material: bpy.types.Material | None = None,
) -> bpy.types.Object:
    """Object in the scene's collection. A material goes to the object's slot, so that objects can share a mesh."""
    item = bpy.data.objects.new(name, data)
    item.location = location
    item.rotation_euler = rotation
    bpy.context.scene.collection.objects.link(item)
    if material is not None:
        if not data.materials:
            data.materials.append(None)
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = material
    return item


def _look(item: bpy.types.Object, target: Sequence[float]) -> None:
    """Turn an object's -z axis to a point, its y axis up."""
    item.rotation_euler = (Vector(target) - item.location).to_track_quat("-Z", "Y").to_euler()


def add_camera(
    name: str, location: Sequence[float], target: Sequence[float], focal_mm: float, shift: tuple[float, float] = (0, 0)
) -> bpy.types.Object:
    """Camera of a 36 mm sensor looking at a point; the first one added becomes the scene's."""
    data = bpy.data.cameras.new(name)
    data.lens = focal_mm
    data.sensor_width = 36.0
    data.clip_start, data.clip_end = 0.01, 100.0
    data.shift_x, data.shift_y = shift
    camera = add_object(name, data, location)
    _look(camera, target)
    if bpy.context.scene.camera is None:
        bpy.context.scene.camera = camera
    return camera


def add_point_light(name: str, location: Sequence[float], power_w: float, radius: float = 0.0) -> bpy.types.Object:
    """Light that shines to all sides from a ball; without a radius it is a point, and its shadows are sharp."""
    data = bpy.data.lights.new(name, "POINT")
    data.energy = power_w
    data.shadow_soft_size = radius
    return add_object(name, data, location)


def add_spot_light(
    name: str,
    location: Sequence[float],
    target: Sequence[float],
    power_w: float,
    spot_size: float,
    blend: float,
    radius: float = 0.0,
) -> bpy.types.Object:
    """Spot light of some radius, shining at a point in a cone of full angle `spot_size`."""
    data = bpy.data.lights.new(name, "SPOT")
    data.energy = power_w
    data.shadow_soft_size = radius
    data.spot_size, data.spot_blend = spot_size, blend
    item = add_object(name, data, location)
    _look(item, target)
    return item


def add_sun(name: str, to_light: Sequence[float], irradiance: float, angle: float = 0.0) -> bpy.types.Object:
    """Directional light that shines from `to_light` onto the origin, from a disk of the angular diameter `angle`."""
    data = bpy.data.lights.new(name, "SUN")
    data.energy = irradiance
    data.angle = angle
    item = add_object(name, data, to_light)
    _look(item, (0.0, 0.0, 0.0))
    return item


def add_grey_world(strength: float) -> None:
    """Add an even grey surrounding, which mirrors show and nothing is lit by."""
    world = bpy.data.worlds.new("Surrounding")
    if world.node_tree is None:  # before Blender 5.0
        world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.location, output.location = (0.0, 0.0), (220.0, 0.0)
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    background.inputs["Strength"].default_value = strength
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])
    world.dichromatic.lights_surfaces = False
    bpy.context.scene.world = world


def empty_file() -> bpy.types.Scene:
    """Nothing but an empty scene, set up so that pixels are what the renderer computed."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 1280, 720, 100
    scene.render.dither_intensity = 0.0
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.filepath = "//render.png"
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.look = "None"
    scene.view_settings.exposure = 0.0
    scene.view_settings.gamma = 1.0
    scene.unit_settings.system = "METRIC"
    return scene


def add_note(title: str, body: str) -> bpy.types.Text:
    """Text block inside the file."""
    text = bpy.data.texts.new(title)
    text.write(body.strip() + "\n")
    text.cursor_set(0)
    return text


def _show_camera_and_note() -> None:
    """Let the file open with the 3D views looking through the camera, and with its note in the Text Editor."""
    note = next(iter(bpy.data.texts), None)
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.region_3d.view_perspective = "CAMERA"
                elif space.type == "TEXT_EDITOR":
                    space.text = note
                    space.show_word_wrap = True


def save(path: Path) -> None:
    """Write the file, compressed, without a backup beside it, and close it.

    Blender writes a file's own path into it, so it is saved elsewhere first: the folders of whoever made it stay out.
    """
    _show_camera_and_note()
    bpy.context.preferences.filepaths.save_version = 0
    first = Path(tempfile.gettempdir(), path.name)
    bpy.ops.wm.save_as_mainfile(filepath=str(first), compress=True, check_existing=False)
    shutil.move(first, path)
    # As a module, Blender 4.2 crashes at the end over the pointers of a file that is still open.
    bpy.ops.wm.read_factory_settings(use_empty=True)
