"""Depth of field, samples where they are needed, and what is kept of the first surface."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spectral_core.errors import InvalidParameterError
from spectral_core.library import illuminant
from spectral_core.lights import PointLight
from spectral_core.renderer import render
from spectral_core.scene import Emission, RenderSettings, Scene
from spectral_core.tracing.camera import Camera
from spectral_core.tracing.mesh import Instance, Mesh
from spectral_core.tracing.sampling import polygon_points, square_points
from tests.render.render_scenes import still_life
from tests.render.test_lights_with_size import MATTE
from tests.tolerances import FLOAT32_ROUNDING

WHITE = illuminant("D65")
WATCHING = Camera(np.eye(4), (-0.5, 0.5, -0.5, 0.5), clip_start=0.01, clip_end=100.0)


def glowing_edge(depth):
    """A half plane x < 0 at a depth before the camera, which glows as brightly as display white."""
    side = Mesh(
        np.array([(-50.0, -50, -depth), (0, -50, -depth), (0, 50, -depth), (-50, 50, -depth)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    return Scene([Instance(side)], [MATTE], [], WATCHING, emissions=[Emission(WHITE, 1.0)])


@pytest.mark.parametrize(("depth", "focus", "blades"), [(4.0, 2.0, 0), (1.5, 2.0, 0), (4.0, 2.0, 4)])
def test_an_edge_out_of_focus_is_blurred_by_the_aperture(depth, focus, blades):
    radius, size = 0.1, 64
    camera = replace(WATCHING, lens_radius=radius, focus_distance=focus, lens_blades=blades)
    scene = replace(glowing_edge(depth), camera=camera)
    y = render(scene, RenderSettings(size, size, samples=64, filter_width=1e-3)).tristimulus()[..., 1].mean(axis=0)
    # The point of the lens at u shows the edge at -u r (1/f - 1/d) on the window, from similar triangles.
    x = (np.arange(size) + 0.5) / size - 0.5
    t = np.clip(x / (radius * abs(1.0 / focus - 1.0 / depth)), -1.0, 1.0)
    if blades == 4:  # a square on its corner: its part on one side of an upright line
        part = np.where(t < 0, 1.0 - 0.5 * (1.0 + t) ** 2, 0.5 * (1.0 - t) ** 2)
    else:
        part = 0.5 - (t * np.sqrt(1 - t * t) + np.arcsin(t)) / math.pi
    # An edge through a lattice of 256 points, which the corners of an aperture cut in pieces.
    np.testing.assert_allclose(y, part, atol=(2 if blades else 1) * 256**-0.75)


def test_what_is_in_focus_is_sharp():
    camera = replace(WATCHING, lens_radius=0.2, focus_distance=3.0)
    settings = RenderSettings(32, 32, samples=4)
    sharp = render(glowing_edge(3.0), settings).tristimulus()
    lens = render(replace(glowing_edge(3.0), camera=camera), settings).tristimulus()
    np.testing.assert_allclose(lens, sharp, atol=1e-4)  # the edge runs between two columns of samples


def test_a_lens_is_checked_and_an_orthographic_camera_has_none():
    with pytest.raises(InvalidParameterError, match="focus_distance must be above 0"):
        replace(WATCHING, lens_radius=0.1, focus_distance=0.0)
    with pytest.raises(InvalidParameterError, match="lens_radius"):
        replace(WATCHING, lens_radius=-0.1)
    flat = replace(WATCHING, kind="orthographic", lens_radius=0.1)
    assert not flat.has_lens
    assert flat.through_lens(np.ones(2)) is flat


def test_a_turned_and_squeezed_aperture_keeps_its_shape():
    camera = replace(WATCHING, lens_radius=2.0, focus_distance=1.0, lens_rotation=0.5 * math.pi, lens_ratio=4.0)
    moved = camera.through_lens(np.array([1.0, 0.0])).position
    np.testing.assert_allclose(moved, (0.0, 2.0, 0.0), atol=1e-12)
    moved = camera.through_lens(np.array([0.0, 1.0])).position
    np.testing.assert_allclose(moved, (-0.5, 0.0, 0.0), atol=1e-12)


@pytest.mark.parametrize("corners", [3, 5, 6, 9])
def test_points_of_a_polygon_lie_evenly_in_it(corners):
    points = polygon_points(square_points(4096), corners)
    angle = np.arctan2(points[:, 1], points[:, 0]) % (2 * math.pi / corners) - math.pi / corners
    along = np.linalg.norm(points, axis=1) * np.cos(angle)  # the height over the nearest side's foot
    inner = math.cos(math.pi / corners)
    assert along.max() <= inner + 1e-9
    np.testing.assert_allclose(np.mean(along / inner), 2.0 / 3.0, rtol=2e-3)  # of triangles with the apex in the middle
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=5e-3)
    with pytest.raises(InvalidParameterError, match="corners"):
        polygon_points(square_points(4), 2)


# ---- adaptive samples


def test_pixels_that_take_all_samples_are_those_of_a_render_without_choice():
    scene = still_life()
    settings = RenderSettings(48, 32, samples=12, seed=2)
    whole = render(scene, settings)
    chosen = render(scene, replace(settings, adaptive_threshold=1e-9, min_samples=4))
    assert chosen.statistics.refined_pixels is not None
    few = render(scene, replace(settings, adaptive_threshold=3.0, min_samples=4))
    assert 0 < few.statistics.refined_pixels < 48 * 32
    assert few.statistics.camera_rays == 48 * 32 * 4 + few.statistics.refined_pixels * 8
    assert few.statistics.shadow_rays < whole.statistics.shadow_rays
    # Means of means: the same samples in another order of summation.
    same = np.isclose(few.tristimulus(), whole.tristimulus(), rtol=4 * FLOAT32_ROUNDING, atol=1e-6).all(axis=2)
    assert same.sum() >= few.statistics.refined_pixels
    assert "took all samples" in few.statistics.describe()


def test_adaptive_pictures_are_near_the_whole_and_nearer_than_the_first_samples():
    scene = replace(still_life(), lights=(PointLight((3.0, -3.0, 4.0), 900.0, WHITE, "key", radius=0.8),))
    settings = RenderSettings(96, 64, samples=16)
    whole = render(scene, settings).tristimulus()
    some = render(scene, replace(settings, adaptive_threshold=1.0, min_samples=4))
    first = render(scene, replace(settings, samples=4)).tristimulus()
    assert some.statistics.refined_pixels < 0.7 * 96 * 64
    error, before = (np.abs(x - whole).mean() for x in (some.tristimulus(), first))
    assert error < 0.3 * before


def test_adaptive_pictures_do_not_depend_on_threads_and_can_be_relit():
    scene = still_life()
    settings = RenderSettings(48, 32, samples=8, adaptive_threshold=2.0, min_samples=2)
    one = render(scene, replace(settings, threads=1))
    four = render(scene, replace(settings, threads=4, band_samples=100))
    assert np.array_equal(one.tristimulus(), four.tristimulus())
    for block in one.film.blocks:
        assert np.all(np.diff(block.pixels) > 0)
    relit = one.relit(one.spectra.with_light("key", strength=0.0)).tristimulus()
    dark = replace(scene, lights=tuple(replace(x, strength=0.0) if x.name == "key" else x for x in scene.lights))
    again = render(dark, replace(settings, adaptive_threshold=0.0, samples=8)).tristimulus()
    assert np.median(np.abs(relit - again)) < 1e-6


def test_shown_parts_of_adaptive_pictures_end_as_the_picture():
    bands = []
    settings = RenderSettings(48, 32, samples=8, adaptive_threshold=2.0, min_samples=2, band_samples=400)
    result = render(still_life(), settings, on_band=bands.append)
    shown = np.zeros((32, 48, 3))
    for band in bands:
        shown[band.first_row : band.first_row + len(band.tristimulus)] = band.tristimulus
    np.testing.assert_allclose(shown, result.tristimulus(), rtol=1e-4, atol=1e-6)  # colours added up in float32
    assert bands[-1].is_finished
    assert not bands[0].is_finished


# ---- buffers


def test_buffers_are_what_the_rays_of_the_first_sample_meet():
    scene = still_life()
    settings = RenderSettings(
        40, 30, samples=1, buffers=("normal", "position", "object_index", "material_index"), precision="float64"
    )
    buffers = render(scene, settings).buffers
    assert buffers.names == ("depth", "normal", "position", "object_index", "material_index")
    x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    origins, directions = scene.camera.rays(x.ravel(), y.ravel(), 40, 30)
    met = np.isfinite(buffers.depth.ravel())
    assert 0.3 < met.mean() < 1.0
    position = buffers.position.reshape(-1, 3)
    offset = position - origins
    across = offset - np.sum(offset * directions, axis=1, keepdims=True) * directions
    np.testing.assert_allclose(across[met], 0.0, atol=1e-5)  # on the ray, to float32
    assert np.all(position[~met] == 0.0)
    normal = buffers.normal.reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(normal[met], axis=1), 1.0, rtol=1e-6)
    assert np.all(np.sum(normal * directions, axis=1)[met] < 0.0)
    ball = buffers.object_index.ravel() == 0
    middle = scene.instances[0].matrix[:3, 3]
    outward = position[ball] - middle
    assert np.sum(outward / np.linalg.norm(outward, axis=1, keepdims=True) * normal[ball], axis=1).min() > 0.98
    assert set(np.unique(buffers.object_index)) == {-1, 0, 1, 2, 3}
    assert np.array_equal(
        buffers.material_index[buffers.object_index == 2], np.full(np.sum(buffers.object_index == 2), 2)
    )
    assert np.all(buffers.material_index[buffers.object_index == -1] == -1)


def test_buffers_that_are_not_asked_for_are_not_kept():
    result = render(still_life(), RenderSettings(16, 12, samples=2, buffers=("normal",)))
    assert result.buffers.names == ("depth", "normal")
    assert result.depth is result.buffers.depth
    with pytest.raises(InvalidParameterError, match="buffers"):
        RenderSettings(buffers=("smell",))
