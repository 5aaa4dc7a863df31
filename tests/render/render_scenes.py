"""Small scenes for the renderer's tests."""

import math

import numpy as np

from spectral_core.library import illuminant, optical_constants, reflectance
from spectral_core.lights import PointLight, SpotLight, SunLight
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.scene import Scene, World
from spectral_core.spectra import Spectrum
from spectral_core.tracing.camera import Camera
from spectral_core.tracing.mesh import Instance, Mesh
from tests.render.tracing_meshes import icosphere


def look_at(eye, target, half_width, half_height, kind="perspective"):
    """A camera at `eye` that looks at `target` with z up."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    back = eye - target
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, eye
    return Camera(matrix, (-half_width, half_width, -half_height, half_height), kind, clip_start=0.01, clip_end=1e3)


def placed(mesh, position=(0.0, 0.0, 0.0), scale=1.0):
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = position
    return Instance(mesh, matrix)


def ball(subdivisions, material=0, smooth=True):
    vertices, triangles = icosphere(subdivisions)
    return Mesh(
        vertices,
        triangles,
        corner_normals=vertices[triangles] if smooth else None,
        material_index=np.full(len(triangles), material),
        name="ball",
    )


def floor(half_size=6.0, material=0):
    x = half_size
    vertices = np.array([(-x, -x, 0), (x, -x, 0), (x, x, 0), (-x, x, 0)], float)
    return Mesh(vertices, np.array([(0, 1, 2), (0, 2, 3)]), material_index=np.full(2, material), name="floor")


RED = Spectrum(np.array([400.0, 560.0, 600.0, 700.0]), np.array([0.04, 0.06, 0.6, 0.7]), name="red")
SHEEN = Spectrum(np.array([400.0, 700.0]), np.array([0.3, 0.8]), name="sheen")


def three_types(constants=None):
    """One material of each type."""
    copper = constants or optical_constants("copper")
    return (
        TypeI(reflectance("blue"), 0.7, "cosine", 11.0),
        TypeII(RED, SHEEN, "exponential", 10.0),
        TypeIII.from_optical_constants(copper, beta=math.radians(20.0)),
    )


def still_life(lamps=("D65", "FL2", "HP1")):
    """Three balls of the three types on a floor, under a point light, a sun and a spot light, before a grey world."""
    return Scene(
        instances=[
            placed(ball(1, 0), (-1.3, 0.2, 1.0)),
            placed(ball(1, 1, smooth=False), (1.2, 0.0, 0.8), 0.8),
            placed(ball(1, 2), (0.1, -1.6, 0.6), 0.6),
            placed(floor(4.0, 0)),
        ],
        materials=three_types(),
        lights=[
            PointLight((3.0, -3.0, 4.0), 900.0, illuminant(lamps[0]), "key"),
            SunLight((-0.5, -0.4, 1.0), 1.2, illuminant(lamps[1]), "sun"),
            SpotLight((-2.0, -4.0, 5.0), (0.4, 0.8, -1.0), 500.0, illuminant(lamps[2]), 0.9, 0.5, "spot"),
        ],
        camera=look_at((0.5, -6.0, 3.0), (0.0, 0.0, 0.6), 0.5, 0.35),
        world=World(illuminant("D50"), 0.2),
        material_names=("plastic", "cloth", "copper"),
    )
