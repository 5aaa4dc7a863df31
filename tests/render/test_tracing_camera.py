"""Cameras against projections worked out by hand, and the samplers against their densities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.tracing import PIXEL_FILTERS, Camera, disk_points, pixel_offsets, square_points
from tests.tolerances import FLOAT64_ROUNDING


def test_corners_and_middle_of_the_picture():
    camera = Camera(np.eye(4), (-2.0, 2.0, -1.0, 1.0), clip_start=0.5, clip_end=10.0)
    origins, directions = camera.rays([0, 200, 100, 0.5], [0, 100, 50, 0.5], 200, 100)
    expected = np.array([(-2, 1, -1), (2, -1, -1), (0, 0, -1), (-1.99, 0.99, -1)], float)
    np.testing.assert_allclose(origins, 0.5 * expected, atol=FLOAT64_ROUNDING)  # on the near plane
    np.testing.assert_allclose(directions, expected / np.linalg.norm(expected, axis=1, keepdims=True), atol=1e-14)
    ends = origins + directions * camera.reach(directions)[:, None]
    np.testing.assert_allclose(ends[:, 2], -10.0, rtol=1e-12)


def test_orthographic_rays_are_parallel():
    camera = Camera(np.eye(4), (-2.0, 2.0, -1.0, 1.0), "orthographic", clip_start=-3.0, clip_end=10.0)
    origins, directions = camera.rays([0, 200], [0, 100], 200, 100)
    np.testing.assert_allclose(origins, [(-2, 1, 3), (2, -1, 3)], atol=FLOAT64_ROUNDING)
    np.testing.assert_array_equal(directions, [(0, 0, -1)] * 2)
    np.testing.assert_array_equal(camera.reach(directions), [13.0, 13.0])


@given(st.floats(-3, 3), st.floats(-3, 3), st.sampled_from(["perspective", "orthographic"]))
def test_placing_a_camera_moves_its_rays(angle, shift, kind):
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([(c, -s, 0, shift), (s, c, 0, 1.0), (0, 0, 1, -shift), (0, 0, 0, 1)])
    scaled = matrix @ np.diag([2.0, 0.5, 3.0, 1.0])  # scale must not matter
    window = (-0.5 + shift / 9, 1.0, -0.25, 0.4)
    o0, d0 = Camera(np.eye(4), window, kind).rays([3.0, 7.5], [1.0, 2.0], 16, 9)
    o1, d1 = Camera(scaled, window, kind).rays([3.0, 7.5], [1.0, 2.0], 16, 9)
    np.testing.assert_allclose(o1, o0 @ matrix[:3, :3].T + matrix[:3, 3], atol=1e-13)
    np.testing.assert_allclose(d1, d0 @ matrix[:3, :3].T, atol=1e-13)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"matrix": np.zeros((4, 4))}, "three independent axes"),
        ({"matrix": np.eye(3)}, "must have the shape"),
        ({"matrix": np.full((4, 4), np.nan)}, "must be finite"),
        ({"window": (1.0, -1.0, -1.0, 1.0)}, "left < right"),
        ({"window": (1.0, 2.0)}, "must have the shape"),
        ({"kind": "fisheye"}, "must be one of perspective, orthographic"),
        ({"clip_start": 0.0}, "clip_start must be above 0"),
        ({"clip_end": 0.05}, "clip_end must be above clip_start"),
        ({"clip_end": np.inf}, "clip_end must be finite"),
    ],
)
def test_broken_cameras_are_refused(changes, message):
    arguments = {"matrix": np.eye(4), "window": (-1.0, 1.0, -1.0, 1.0), **changes}
    with pytest.raises(InvalidParameterError, match=message):
        Camera(**arguments)


@pytest.mark.parametrize("name", PIXEL_FILTERS)
def test_offsets_follow_the_filter(name):
    """Variance of each filter's own density; box w^2/12, triangle w^2/24, the others by quadrature."""
    width = 2.0
    x = np.linspace(-0.5, 0.5, 20001)
    density = {
        "box": np.ones_like(x),
        "triangle": 1 - 2 * np.abs(x),
        "gaussian": np.exp(-18 * x**2),
        "blackman_harris": 0.35875
        + 0.48829 * np.cos(2 * np.pi * x)
        + 0.14128 * np.cos(4 * np.pi * x)
        + 0.01168 * np.cos(6 * np.pi * x),
    }[name]
    offsets = pixel_offsets(4096, name, width, seed=3) - 0.5
    assert np.abs(offsets).max() <= width / 2
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=2e-3)
    np.testing.assert_allclose(offsets.var(axis=0), width**2 * np.sum(density * x * x) / np.sum(density), rtol=5e-3)


@pytest.mark.parametrize("name", PIXEL_FILTERS)
def test_one_sample_is_the_centre(name):
    np.testing.assert_allclose(pixel_offsets(1, name, 1.5, seed=9), [(0.5, 0.5)], atol=1e-12)


def test_seeds_repeat_and_differ():
    np.testing.assert_array_equal(pixel_offsets(16, seed=1), pixel_offsets(16, seed=1))
    assert not np.array_equal(pixel_offsets(16, seed=1), pixel_offsets(16, seed=2))


@given(st.integers(2, 300), st.integers(0, 1000))
def test_points_are_stratified(samples, seed):
    points = square_points(samples, seed)
    assert points.min() >= 0.0
    assert points.max() < 1.0
    gaps = np.diff(np.sort(points[:, 0]))
    np.testing.assert_allclose(gaps, 1 / samples, atol=1e-9)  # one a column
    # Three-distance theorem: gaps of the golden ratio's multiples are at most (1 + golden ratio) / n.
    assert np.diff(np.sort(points[:, 1])).max() <= 2.62 / samples


def test_disk_points_keep_areas():
    points = disk_points(square_points(4096, 1))
    radius = np.linalg.norm(points, axis=1)
    assert radius.max() <= 1.0
    np.testing.assert_allclose(np.mean(radius**2), 0.5, atol=1e-3)  # uniform on the disk
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=1e-3)
    np.testing.assert_array_equal(disk_points(np.array([(0.5, 0.5)])), [(0.0, 0.0)])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0,), "samples must be at least 1"),
        ((4, "sinc"), "pixel_filter must be one of"),
        ((4, "box", 0.0), "width must lie between"),
        ((4, "box", 1.0, -1), "seed must be at least 0"),
    ],
)
def test_broken_sampling_is_refused(arguments, message):
    with pytest.raises(InvalidParameterError, match=message):
        pixel_offsets(*arguments)
