"""Pictures are the same however they are cut up and whoever works on them."""

import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from spectral_core.colorimetry import observer, wavelength_grid
from spectral_core.errors import DichromaticError, InvalidParameterError, RenderCancelledError, SceneError
from spectral_core.film_builder import Deposits
from spectral_core.job import Job
from spectral_core.renderer import render
from spectral_core.sample_pattern import SamplePattern
from spectral_core.scene import RenderSettings
from spectral_core.shading import component_coefficients, facing, surface_points
from spectral_core.sub_pictures import refinement, sub_pictures, tile_places
from spectral_core.tracing import Acceleration, Geometry, sobol_points
from spectral_core.tracing.hits import offset_origins
from tests.render.render_scenes import still_life

SMALL = RenderSettings(48, 32, samples=3)


def soft_still_life():
    """The still life with lamps that have a size, and a sky that lights it."""
    scene = still_life()
    key, sun, spot = scene.lights
    lights = (replace(key, radius=0.4), replace(sun, angle=0.1), replace(spot, radius=0.2))
    return replace(scene, lights=lights, world=replace(scene.world, lights_surfaces=True))


SCENES = {"hard": still_life, "soft": soft_still_life}


@given(st.integers(1, 70), st.integers(1, 40), st.sampled_from([1, 2, 4, 8]), st.integers(1, 3000))
def test_every_pixel_is_in_one_part(width, height, step, most):
    parts = list(sub_pictures(width, height, step, most))
    pixels = np.concatenate([part.pixels for part in parts])
    assert np.array_equal(np.sort(pixels), np.arange(width * height))
    for part in parts:
        assert len(part) == len(part.pixels) <= max(most, part.width)
        assert np.all(np.diff(part.pixels) > 0)


@pytest.mark.parametrize("step", [1, 2, 4, 8])
def test_what_pixels_stand_for_covers_the_tile_at_any_time(step):
    covered = np.full((step, step), -1)
    for part in sub_pictures(step, step, step, 1):
        side = refinement(step, part.number)
        covered[part.row : part.row + side, part.column : part.column + side] = part.number
        assert part.number > 0 or np.all(covered == 0)
    assert len(np.unique(covered)) == step * step


@pytest.mark.parametrize("name", SCENES)
def test_threads_and_bands_change_nothing(name):
    scene = SCENES[name]()
    whole = render(scene, replace(SMALL, threads=1))
    for change in ({"threads": 2}, {"threads": 4}, {"threads": 3, "band_samples": 100}, {"band_samples": 1}):
        other = render(scene, replace(SMALL, **change))
        assert np.array_equal(other.tristimulus(), whole.tristimulus())
        assert np.array_equal(other.depth, whole.depth)
        assert np.array_equal(other.alpha, whole.alpha)
        assert other.statistics.shadow_rays == whole.statistics.shadow_rays
        for one, two in zip(whole.film.blocks, other.film.blocks, strict=True):
            assert one.terms == two.terms
            assert np.array_equal(one.pixels, two.pixels)
            assert np.array_equal(one.coefficients, two.coefficients)


def test_a_pool_of_processes_gives_the_same_picture():
    scene = soft_still_life()
    here = render(scene, SMALL)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        there = render(scene, SMALL, executor=pool)
        again = render(scene, replace(SMALL, seed=5), executor=pool)
    assert np.array_equal(here.tristimulus(), there.tristimulus())
    assert here.statistics.camera_rays == there.statistics.camera_rays
    assert not np.array_equal(again.tristimulus(), here.tristimulus())


def test_any_executor_will_do():
    bands = []
    with ThreadPoolExecutor(3) as pool:
        there = render(still_life(), replace(SMALL, band_samples=100), on_band=bands.append, executor=pool)
    assert np.array_equal(there.tristimulus(), render(still_life(), SMALL).tristimulus())
    assert [band.first_row for band in bands] == sorted(band.first_row for band in bands)


class UnableError(DichromaticError):
    pass


@pytest.mark.parametrize("threads", [1, 3])
def test_an_error_in_a_part_ends_the_render_and_leaves_no_thread(threads, monkeypatch):
    def refuse(self, task, stop_if_cancelled=None):
        raise UnableError("no")

    monkeypatch.setattr(Job, "run", refuse)
    with pytest.raises(UnableError):
        render(still_life(), replace(SMALL, threads=threads, band_samples=50))
    assert not [t for t in threading.enumerate() if t.name.startswith("dichromatic")]


@pytest.mark.parametrize("threads", [1, 3])
def test_cancel_ends_the_render_and_leaves_no_thread(threads):
    asked = 0

    def cancel():
        nonlocal asked
        asked += 1
        return asked > 3

    with pytest.raises(RenderCancelledError):
        render(soft_still_life(), replace(SMALL, threads=threads, samples=40), cancel=cancel)
    assert not [t for t in threading.enumerate() if t.name.startswith("dichromatic")]


def test_a_viewer_that_raises_ends_the_render_and_leaves_no_thread():
    """Also for as long as somebody keeps the error, and with it all that its traceback holds."""

    def refuse(band):
        raise RenderCancelledError("seen enough")

    settings = replace(SMALL, threads=3, band_samples=50)
    with pytest.raises(RenderCancelledError, match="seen enough") as kept:
        render(still_life(), settings, on_band=refuse)
    assert kept.value.__traceback__ is not None
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("dichromatic")]


def test_parts_that_are_shown_end_as_the_picture():
    """Coarse to fine: every call covers its rows, and the last of them are the render's own."""
    scene, bands = soft_still_life(), []
    result = render(scene, replace(SMALL, threads=2), on_band=bands.append)
    shown = np.full((32, 48, 3), np.nan)
    for number, band in enumerate(bands):
        shown[band.first_row : band.first_row + len(band.tristimulus)] = band.tristimulus
        assert number < 1 or not np.isnan(shown).any()
    assert np.array_equal(shown, result.tristimulus())
    assert [band.is_finished for band in bands] == [False] * (len(bands) - 1) + [True]


@pytest.mark.parametrize("size", [(1, 1), (3, 3), (2, 9), (9, 2)])
def test_pictures_narrower_than_a_tile_are_finished_as_well(size):
    bands = []
    settings = replace(SMALL, width=size[0], height=size[1])
    result = render(soft_still_life(), settings, on_band=bands.append)
    assert np.isfinite(result.tristimulus()).all()
    assert [band.is_finished for band in bands] == [False] * (len(bands) - 1) + [True]


def test_nothing_to_refine_is_finished_as_well():
    bands = []
    settings = replace(SMALL, samples=4, min_samples=2, adaptive_threshold=1e6)
    result = render(still_life(), settings, on_band=bands.append)
    assert result.statistics.refined_pixels == 0
    assert [band.is_finished for band in bands] == [False] * (len(bands) - 1) + [True]
    np.testing.assert_allclose(bands[-1].tristimulus, result.tristimulus(), rtol=1e-4, atol=1e-6)


def test_each_pixel_is_lit_from_the_points_of_its_own_sub_picture():
    """The soft render against single samples through the tree, each from its point of the lamp."""
    scene = still_life()
    key = replace(scene.lights[0], radius=0.5)
    settings = RenderSettings(24, 16, samples=2, precision="float64", pixel_filter="box")
    soft = render(replace(scene, lights=(key,)), settings).tristimulus()
    job = Job.prepare(replace(scene, lights=(key,)), settings)
    assert job.step == 4
    expected = np.zeros_like(soft)
    for part in sub_pictures(24, 16, 4, 10**6):
        for sample in range(2):
            at = key.lamp_point(job.pattern.lamps[0][part.number, sample, 0], job.geometry.centre)
            single = _single_sample(replace(scene, lights=(key,)), settings, job, part, sample, at)
            expected.reshape(-1, 3)[part.pixels] += single / 2
    np.testing.assert_allclose(soft, expected, rtol=1e-12, atol=1e-15)


def _single_sample(scene, settings, job, part, sample, at):
    """One sample of a sub-picture by another way: rays of the camera and shadow rays through the tree."""
    x = np.tile(part.x, part.end - part.first) + job.pattern.offsets[sample, 0]
    y = np.repeat(part.y, part.width) + job.pattern.offsets[sample, 1]
    origins, directions = scene.camera.rays(x, y, settings.width, settings.height)
    tree = Acceleration(job.geometry).tree()
    hits = tree.closest(job.geometry.recentred(origins), directions)
    points = surface_points(job.geometry, hits, directions)
    key = scene.lights[0]
    illumination = key.illuminate(points.position, job.geometry.centre, at)
    candidates = facing(points, illumination)
    start = offset_origins(
        points.position[candidates],
        points.geometric_normal[candidates],
        illumination.to_light[candidates],
        job.geometry.radius,
    )
    target = job.geometry.recentred(at.position)
    dark = tree.occluded(start, target - start, 1.0, points.triangle[candidates])
    lit = candidates[~dark]
    film = Deposits(part.pixels, settings.width, np.dtype(np.float64))
    missed = np.flatnonzero(~hits.hit)
    film.deposit(job.plan.background, missed, np.ones((len(missed), 1)))
    for index, group in points.groups():
        inside = lit[(lit >= group.start) & (lit < group.stop)]
        values = component_coefficients(scene.materials[index], points, illumination, inside)
        film.deposit(job.plan.materials[index].terms, points.ray[inside], values)
    return film.merge(1).tristimulus(job.spectra, observer(settings.observer), wavelength_grid(settings.grid))


def test_the_kept_triangles_must_be_of_the_right_precision():
    scene = still_life()
    kept = Acceleration(Geometry.from_instances(scene.instances, np.float32))
    again = render(scene, SMALL, acceleration=kept)
    assert np.array_equal(again.tristimulus(), render(scene, SMALL).tristimulus())
    with pytest.raises(InvalidParameterError, match="the triangles must be float64"):
        render(scene, replace(SMALL, precision="float64"), acceleration=kept)
    with pytest.raises(SceneError, match="no camera"):
        render(replace(scene, camera=None), SMALL, acceleration=kept)


@pytest.mark.parametrize(("samples", "first"), [(1, 1), (4, 4), (16, 4), (64, 8)])
def test_points_of_lamps_are_even_in_a_pixel_and_among_neighbours(samples, first):
    """One point in each of 2^m equal boxes of any shape: a net in base 2, for pixels, pairs of pairs, and tiles."""
    settings = RenderSettings(8, 8, samples=samples, seed=3, adaptive_threshold=1.0, min_samples=max(first, 2))
    pattern = SamplePattern.make(settings, 4, (1, 4))
    assert [lamp.shape for lamp in pattern.lamps] == [(16, samples, 1, 3), (16, samples, 4, 3)]
    number = {place: k for k, place in enumerate(tile_places(4))}
    for lamp in pattern.lamps:
        sets = [points.reshape(-1, 3) for points in lamp]
        sets += [points[:first].reshape(-1, 3) for points in lamp]
        for x, y in ((0, 0), (2, 0), (0, 2), (2, 2)):
            some = [number[x + dx, y + dy] for dx in (0, 1) for dy in (0, 1)]
            sets.append(lamp[some].reshape(-1, 3))
        sets.append(lamp.reshape(-1, 3))
        for points in sets:
            bits = int(np.log2(len(points)))
            for along in range(bits + 1):
                box = np.floor(points[:, 0] * 2**along) * 2 ** (bits - along)
                box += np.floor(points[:, 1] * 2 ** (bits - along))
                assert np.array_equal(np.sort(box), np.arange(len(points)))
            assert np.array_equal(np.sort(np.floor(points[:, 2] * len(points))), np.arange(len(points)))


def test_patterns_are_repeated_by_their_seed_and_by_nothing_else():
    settings = RenderSettings(8, 8, samples=16, seed=3)
    one, same = (SamplePattern.make(settings, 4, (1, 1)) for _ in range(2))
    other = SamplePattern.make(replace(settings, seed=4), 4, (1, 1))
    for name in ("offsets", "lens"):
        assert np.array_equal(getattr(one, name), getattr(same, name))
        assert not np.array_equal(getattr(one, name), getattr(other, name))
    assert np.array_equal(one.lamps[1], same.lamps[1])
    assert not np.array_equal(one.lamps[0], one.lamps[1])
    # The lens does not go with the point of a lamp: correlation of 16 x 16 draws, whose deviation is 1/16.
    for axis in range(2):
        for lamp in one.lamps:
            assert abs(np.corrcoef(one.lens[..., axis].ravel(), lamp[:, :, 0, axis].ravel())[0, 1]) < 0.3


@pytest.mark.parametrize("bits", [1, 5, 10])
def test_sobol_points_are_those_of_scipy(bits):
    ours = sobol_points(np.arange(2**bits), np.zeros(3, np.uint32))
    theirs = qmc.Sobol(3, scramble=False).random_base2(bits)  # the same points in the order of Gray's code
    assert sorted(map(tuple, ours)) == sorted(map(tuple, theirs))
