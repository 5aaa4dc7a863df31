"""The scenes of the tracing benchmark: cups (22k triangles), terrain (125k), spheres (983k), and the sample blends."""

import importlib.util
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from spectral_core.tracing import Camera, Geometry, Instance, Mesh
from tests.render.tracing_meshes import icosphere

SCENES = ("cups", "terrain", "spheres")
BLENDS = Path(__file__).parents[2] / "sample_blends"


def sample_blends():
    """Names of the sample blends, if there is a Blender to read them with."""
    return sorted(path.name for path in BLENDS.glob("*.blend")) if importlib.util.find_spec("bpy") else []


@dataclass(frozen=True)
class BenchmarkScene:
    name: str
    geometry: Geometry
    camera: Camera
    lights: np.ndarray  # (L, 3), world
    suns: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))  # (S, 3), towards them


def looking(eye, target, fov_degrees=40.0, aspect=16 / 9):
    """A camera at `eye` that looks at `target`, +Z up, with this horizontal angle of view."""
    eye = np.asarray(eye, float)
    forward = np.asarray(target, float) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(right, forward), -forward], axis=1)
    matrix[:3, 3] = eye
    half = np.tan(np.radians(fov_degrees / 2))
    return Camera(matrix, (-half, half, -half / aspect, half / aspect), clip_start=0.1, clip_end=1000.0)


def quads(rows, columns, closed_columns):
    """Two triangles for each cell of a grid of vertices stored row by row."""
    width = columns if closed_columns else columns + 1
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    k = (j + 1) % width
    a, b, c, d = i * width + j, i * width + k, (i + 1) * width + k, (i + 1) * width + j
    return np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])


def sheet(cells, half_size, height=lambda x, y: 0.0 * x):
    x, y = np.meshgrid(*[np.linspace(-half_size, half_size, cells + 1)] * 2, indexing="ij")
    vertices = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)
    return vertices, quads(cells, cells, closed_columns=False)[:, ::-1]


def smoothed(vertices, triangles):
    """A mesh with the area-weighted mean of the faces around each vertex as its normal."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], faces)
    return Mesh(vertices, triangles, corner_normals=normals[triangles])


def cup():
    """A turned body with an inside, a rounded rim and a bent handle."""
    t = np.linspace(0.0, 1.0, 30)
    outside = np.stack([0.55 + 0.4 * np.sqrt(t), 2.0 * t], axis=1)
    bend = np.linspace(0.0, np.pi, 9)[1:-1]
    rim = np.stack([0.91 + 0.04 * np.cos(bend), 2.0 + 0.04 * np.sin(bend)], axis=1)
    inside = np.stack([0.48 + 0.39 * np.sqrt(t[::-1]), 0.1 + 1.9 * t[::-1]], axis=1)
    profile = np.concatenate([[(0.0, 0.0)], outside, rim, inside, [(0.0, 0.1)]])
    angle = np.arange(72) * (2 * np.pi / 72)
    radius, height = profile[:, :1], profile[:, 1:]
    body = np.stack([radius * np.cos(angle), radius * np.sin(angle), height + 0 * angle], axis=-1).reshape(-1, 3)
    bow, ring = np.meshgrid(np.linspace(-1.6, 1.6, 41), np.arange(16) * (2 * np.pi / 16), indexing="ij")
    arm = 0.5 + 0.09 * np.cos(ring)
    handle = np.stack([0.85 + arm * np.cos(bow), 0.09 * np.sin(ring), 1.05 + arm * np.sin(bow)], axis=-1)
    faces = [quads(len(profile) - 1, 72, closed_columns=True), quads(40, 16, closed_columns=True) + len(body)]
    return smoothed(np.concatenate([body, handle.reshape(-1, 3)]), np.concatenate(faces))


def placed(mesh, angle=0.0, scale=1.0, position=(0.0, 0.0, 0.0)):
    matrix = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    matrix[:3, :3] = scale * np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])
    matrix[:3, 3] = position
    return Instance(mesh, matrix)


def scene(name, dtype=np.float32):
    """One of SCENES, or a sample blend."""
    if name.endswith(".blend"):
        return blend(name, dtype)
    if name == "cups":
        one = cup()
        ground = Mesh(*sheet(8, 8.0))
        instances = [
            placed(one, 0.0, 1.0, (-1.2, 0.0, 0.001)),
            placed(one, 0.7, 1.0, (1.3, 0.6, 0.001)),
            placed(ground),
        ]
        camera, lights = looking((0.6, -6.5, 3.6), (0.1, 0.0, 0.8)), [(4, -4, 7), (-6, -3, 5), (0, 6, 8)]
    elif name == "terrain":

        def hills(x, y):
            broad = 0.35 * np.sin(1.3 * x + 0.4 * y) + 0.25 * np.sin(2.7 * y - 0.8 * x)
            return broad + 0.1 * np.sin(6.1 * x) * np.cos(5.3 * y) + 0.03 * np.sin(19 * x + 3 * np.sin(7 * y))

        instances = [placed(smoothed(*sheet(250, 5.0, hills)))]
        camera, lights = looking((1.0, -8.5, 3.5), (0.0, -0.5, 0.0)), [(6, -2, 4), (-7, 3, 3), (0, 7, 6)]
    else:
        vertices, triangles = icosphere(6)
        ball = smoothed(vertices * (1.0 + 0.03 * np.sin(9.0 * vertices[:, :1])), triangles)
        radii = 0.7 + 0.5 * np.random.default_rng(3).random(12)
        places = [(2.3 * (k % 4 - 1.5), 2.4 * (k // 4 - 1), radii[k] * 1.03 + 0.01) for k in range(12)]
        instances = [placed(ball, 0.3 * k, radii[k], places[k]) for k in range(12)]
        instances.append(placed(Mesh(*sheet(8, 12.0))))
        camera, lights = looking((2.0, -10.0, 5.5), (0.0, 0.0, 0.8)), [(6, -6, 9), (-8, -2, 7), (0, 8, 9)]
    return BenchmarkScene(name, Geometry.from_instances(instances, dtype), camera, np.array(lights, float))


def blend(name, dtype):
    """A sample blend as the renderer gets it; lamps with a size are taken at their middle."""
    import bpy

    import dichromatic_addon
    from dichromatic_addon.scene_export import export_scene

    dichromatic_addon.register()
    try:
        bpy.ops.wm.open_mainfile(filepath=str(BLENDS / name))
        exported = export_scene(bpy.context.evaluated_depsgraph_get()).scene
    finally:
        dichromatic_addon.unregister()
    places = [light.position for light in exported.lights if hasattr(light, "position")]
    suns = [light.to_light for light in exported.lights if not hasattr(light, "position")]
    geometry = Geometry.from_instances(exported.instances, dtype)
    return BenchmarkScene(
        name, geometry, exported.camera, np.reshape(places, (-1, 3)), np.reshape(suns, (-1, 3)).astype(float)
    )
