"""Directions to an even sky, shared out among neighbouring pixels: against the closed form of its irradiance."""

import numpy as np
import pytest

from spectral_core.lights import EnvironmentLight
from spectral_core.reflection.materials import TypeI
from spectral_core.renderer import render
from spectral_core.sample_pattern import SamplePattern
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.spectra import Spectrum
from spectral_core.tracing import Camera, Instance, Mesh
from spectral_core.tracing.balance import MOST_BALANCED, balanced_groups
from spectral_core.tracing.sampling import sobol_points
from tests.render.render_scenes import floor, placed


def sky_directions(groups, size, seed):
    rng = np.random.default_rng(seed)
    numbers = sobol_points(np.arange(groups * size).reshape(groups, size), rng.integers(0, 1 << 32, 3, np.uint32))
    return EnvironmentLight().directions(numbers)


def normals(seed, count=200):
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def error(directions, chosen, hiding=None):
    """Root mean square, over groups and normals, of the mean cosine of a group less its true value, 1/4 (or 1/8)."""
    unit = directions.reshape(-1, 3)[chosen]
    cosine = np.maximum(np.einsum("gsi,ni->gsn", unit, normals(1)), 0.0)
    if hiding is not None:
        cosine = cosine * (np.einsum("gsi,ni->gsn", unit, hiding) > 0.0)
    return float(np.sqrt(np.mean((cosine.mean(axis=1) - (0.25 if hiding is None else 0.125)) ** 2)))


@pytest.mark.parametrize(("groups", "size"), [(16, 4), (16, 16), (4, 16), (4, 60), (16, 1), (1, 8)])
def test_every_direction_is_given_once_and_groups_are_more_even(groups, size):
    before, after, half_before, half_after = [], [], [], []
    across = np.cross(normals(1), normals(2))
    across /= np.linalg.norm(across, axis=1)[:, None]  # walls that stand on the surfaces
    for seed in range(5):
        directions = sky_directions(groups, size, seed)
        chosen = balanced_groups(directions)
        plain = np.arange(groups * size).reshape(groups, size)
        assert np.array_equal(np.sort(chosen, axis=None), plain.ravel())
        assert np.array_equal(chosen, balanced_groups(directions))
        before.append(error(directions, plain))
        after.append(error(directions, chosen))
        half_before.append(error(directions, plain, across))
        half_after.append(error(directions, chosen, across))
    if groups > 1 and size > 1:
        assert np.mean(after) < 0.6 * np.mean(before)  # as found: 0.3 to 0.55
        assert np.mean(half_after) < 0.95 * np.mean(half_before)  # 0.7 to 0.9
    else:  # there is nothing to choose
        assert np.mean(after) == pytest.approx(np.mean(before), rel=1e-12)


def pattern_of(samples, step, seed=0):
    settings = RenderSettings(8, 8, samples=samples, seed=seed)
    return SamplePattern.make(settings, step, (1, 4))


@pytest.mark.parametrize("step", [2, 4])
def test_a_tile_keeps_its_points_and_other_sources_theirs(step):
    pattern = pattern_of(4, step)
    made = pattern.balanced(1, EnvironmentLight().directions, 0)
    assert np.array_equal(made.lamps[0], pattern.lamps[0])
    before, after = (lamps[1].reshape(-1, 3) for lamps in (pattern.lamps, made.lamps))
    assert not np.array_equal(before, after)
    assert set(map(tuple, before)) == set(map(tuple, after))


def test_no_pixel_prefers_a_direction():
    """The mean direction of each pixel over many seeds: none, to four deviations of a mean of random directions."""
    seeds, samples = 60, 2
    sums = np.zeros((16, 3))
    for seed in range(seeds):
        made = pattern_of(samples, 4, seed).balanced(1, EnvironmentLight().directions, seed)
        sums += EnvironmentLight().directions(made.lamps[1]).sum(axis=(1, 2))
    deviation = np.sqrt(1.0 / 3.0 / (seeds * samples * 4))
    assert np.abs(sums / (seeds * samples * 4)).max() < 4.0 * deviation


def test_many_points_and_a_single_sub_picture_are_left_alone():
    def unasked(numbers):
        raise AssertionError("no direction is needed")

    many = pattern_of(MOST_BALANCED // 64 + 1, 4)
    assert many.balanced(1, unasked, 0) is many
    whole = pattern_of(4, 1)
    assert whole.balanced(1, unasked, 0) is whole


@pytest.mark.parametrize("samples", [3, 5, 6, 7, 12])
@pytest.mark.parametrize("step", [2, 4])
def test_numbers_of_samples_between_powers_of_two_leave_no_gap(samples, step):
    """Each of as many equal boxes as a tile has pixels has a pixel's number of points: no part is left out."""
    points = pattern_of(samples, step).lamps[0].reshape(-1, 3)
    bits = 2 * (step.bit_length() - 1)
    for along in range(bits + 1):
        box = np.floor(points[:, 0] * 2**along) * 2 ** (bits - along) + np.floor(points[:, 1] * 2 ** (bits - along))
        assert np.array_equal(np.bincount(box.astype(int), minlength=step * step), np.full(step * step, samples))
    third = np.floor(points[:, 2] * step * step).astype(int)
    assert np.array_equal(np.bincount(third), np.full(step * step, samples))


def floor_under_the_sky(wall=False) -> Scene:
    """A matte floor, seen from above; a wall without end, unseen, hides half of the sky from where it stands."""
    matrix = np.eye(4)
    matrix[2, 3] = 10.0
    camera = Camera(matrix, (-1.0, 1.0, -1.0, 1.0), "orthographic", clip_start=0.01, clip_end=100.0)
    matte = TypeI(Spectrum.constant(0.5, "grey"), 0.0, "cosine", 1.0)
    sky = World(Spectrum.constant(1.0, "E"), strength=1.0, lights_surfaces=True)
    instances = [placed(floor(2.0))]
    if wall:
        corners = [(-1.01, -500.0, -0.1), (-1.01, 500.0, -0.1), (-1.01, 500.0, 1000.0), (-1.01, -500.0, 1000.0)]
        instances.append(Instance(Mesh(corners, [(0, 1, 2), (0, 2, 3)]), camera_visible=False))
    return Scene(instances, [matte], [], camera, sky)


def unevenness(scene, columns):
    """Root mean square of how much pixels differ from the mean of their tile of 4 x 4, relative, over four seeds."""
    squares = []
    for seed in range(4):
        y = render(scene, RenderSettings(32, 32, samples=4, seed=seed)).tristimulus()[:, :columns, 1]
        tiles = y.reshape(8, 4, columns // 4, 4)
        squares.append(np.mean((tiles / tiles.mean(axis=(1, 3), keepdims=True) - 1.0) ** 2))
    return float(np.sqrt(np.mean(squares)))


@pytest.mark.parametrize(("wall", "largest"), [(False, 0.04), (True, 0.18)])
def test_pixels_of_a_matte_floor_differ_less_once_directions_are_exchanged(monkeypatch, wall, largest):
    scene, columns = floor_under_the_sky(wall), 8 if wall else 32  # near the wall, where it hides a half
    after = unevenness(scene, columns)
    monkeypatch.setattr(SamplePattern, "balanced", lambda self, *given: self)
    before = unevenness(scene, columns)
    print(f"\nwall {wall}: pixels differ by {100 * after:.1f} %, by {100 * before:.1f} % without the exchange")
    assert after < largest
    assert after < 0.75 * before


def test_a_matte_floor_under_an_even_sky_is_evenly_lit():
    """Radiance is reflectance times that of the sky, in each pixel of a render with few samples."""
    scene = floor_under_the_sky()
    errors = []
    for seed in range(4):
        y = render(scene, RenderSettings(32, 32, samples=4, seed=seed)).tristimulus()[..., 1]
        errors.append(np.sqrt(np.mean((y / 0.5 - 1.0) ** 2)))
    assert np.mean(errors) < 0.04  # 16 directions a pixel: 0.025; not exchanged, 0.072
