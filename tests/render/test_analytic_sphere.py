"""A sphere known in closed form against its rendered mesh: the error falls with the square of the edge length."""

import math

import numpy as np
import pytest

from spectral_core.colorimetry import observer
from spectral_core.library import illuminant
from spectral_core.lights import PointLight, SunLight
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene
from tests.render.render_scenes import ball, look_at, placed, three_types

SIZE = 48
WAVELENGTHS = np.arange(360.0, 831.0)
LIGHTS = {
    "point": PointLight((3.0, -4.0, 2.5), 600.0, illuminant("D65"), "lamp"),
    "sun": SunLight((0.8, -1.0, 0.6), 3.0, illuminant("D65"), "lamp"),
}


def closed_form(material, light, camera):
    """XYZ of the unit sphere at the origin where it is hit well inside its outline and lit; NaN elsewhere."""
    rows, columns = np.mgrid[0:SIZE, 0:SIZE] + 0.5
    origins, directions = camera.rays(columns.ravel(), rows.ravel(), SIZE, SIZE)
    along = np.einsum("ij,ij->i", origins, directions)
    root = along**2 - np.einsum("ij,ij->i", origins, origins) + 1.0
    inside = root > 0.15  # away from the outline, where the mesh's own outline differs by a whole pixel
    point = origins + (-along - np.sqrt(np.where(inside, root, 0.0)))[:, None] * directions
    if isinstance(light, PointLight):
        offset = light.position - point
        distance = np.linalg.norm(offset, axis=1)
        to_light = offset / distance[:, None]
        irradiance = light.strength / (4.0 * math.pi * distance**2)
    else:
        to_light = np.broadcast_to(light.to_light, point.shape)
        irradiance = np.full(len(point), light.strength)
    lit = inside & (np.einsum("ij,ij->i", point, to_light) > 0.15)  # away from the terminator, likewise
    factor = material.radiance_factor(point[lit], to_light[lit], -directions[lit], WAVELENGTHS)
    functions = observer("cie_1931_2").matching_functions
    power = light.illuminant.at(WAVELENGTHS)
    xyz = np.full((SIZE * SIZE, 3), np.nan)
    xyz[lit] = (factor * power) @ functions / (power @ functions[:, 1]) * irradiance[lit, None] / math.pi
    return xyz.reshape(SIZE, SIZE, 3)


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
@pytest.mark.parametrize("material", three_types(), ids=["type-1", "type-2", "type-3"])
def test_mesh_converges_to_the_sphere(material, light):
    camera = look_at((0.0, -4.0, 1.0), (0.0, 0.0, 0.0), 0.27, 0.27)
    expected = closed_form(material, light, camera)
    known = np.isfinite(expected)
    assert known.sum() > 1000
    errors = []
    for subdivisions in (2, 3, 4):
        scene = Scene([placed(ball(subdivisions))], [material], [light], camera)
        settings = RenderSettings(SIZE, SIZE, samples=1, precision="float64")
        got = render(scene, settings).tristimulus()
        errors.append(np.abs(got - expected)[known].mean() / expected[known].mean())
    # Each subdivision halves the edges: the interpolated normal's and the position's errors fall by four, and by no
    # less than three once lobes are resolved.
    assert errors[1] < errors[0] / 3.0
    assert errors[2] < errors[1] / 3.0
    assert errors[2] < 2e-3
