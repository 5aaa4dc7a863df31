"""Holdouts, shadow catchers and the share of light that shadows take: against plain renders and closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_core.errors import SceneError
from spectral_core.library import illuminant
from spectral_core.lights import AreaLight, PointLight
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.tracing import Camera, Instance
from tests.render.render_scenes import ball, floor, placed, still_life, three_types
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING

SETTINGS = RenderSettings(width=48, height=32, samples=3, precision="float64", max_bounces=1)
LAMPS = (
    PointLight((1.43, 0.57, 3.0), 100.0, illuminant("A"), "warm"),
    PointLight((-1.03, -1.87, 4.0), 300.0, illuminant("D65"), "cold"),
)


def masked(scene: Scene, number: int, mask: str) -> Scene:
    instances = list(scene.instances)
    instances[number] = replace(instances[number], mask=mask)
    return replace(scene, instances=instances)


def stage(lights=LAMPS, mask="", world=None) -> Scene:
    """A floor of 4 x 4 m, seen straight from above, and a sheet of 1 x 1 m that hovers 1 m over it, unseen."""
    sheet = replace(placed(floor(0.5), (0.0, 0.0, 1.0)), camera_visible=False)
    matrix = np.eye(4)
    matrix[2, 3] = 10.0
    camera = Camera(matrix, (-2.0, 2.0, -2.0, 2.0), "orthographic", clip_start=0.01, clip_end=100.0)
    return Scene(
        [replace(placed(floor(2.0)), mask=mask), sheet],
        three_types()[:1],
        lights,
        camera,
        World() if world is None else world,
    )


def pixel_positions(size: int) -> np.ndarray:
    """Where the centres of the pixels lie on the floor, (size, size, 3)."""
    across = (np.arange(size) + 0.5) / size * 4.0 - 2.0
    x, y = np.meshgrid(across, across[::-1])
    return np.stack([x, y, np.zeros_like(x)], axis=-1)


def expected_occlusion(size: int, lights=LAMPS) -> np.ndarray:
    """Illuminance that the sheet takes over illuminance that is sent, from positions alone."""
    points = pixel_positions(size)
    sent, lost = np.zeros((size, size)), np.zeros((size, size))
    for lamp in lights:
        offset = lamp.position - points
        distance = np.linalg.norm(offset, axis=-1)
        given = lamp.strength * offset[..., 2] / distance**3
        crossing = points + offset / offset[..., 2:]  # one metre up
        sent += given
        lost += given * (np.abs(crossing[..., :2]) < 0.5).all(axis=-1)
    return lost / sent


def one_ray(size: int) -> RenderSettings:
    return RenderSettings(
        width=size,
        height=size,
        samples=1,
        pixel_filter="box",
        filter_width=1e-3,
        precision="float64",
        shadow_share=True,
    )


def test_the_share_that_shadows_take_is_that_of_the_closed_form():
    size = 41
    result = render(stage(), one_ray(size))
    expected = expected_occlusion(size)
    assert len(np.unique(expected.round(6) > 0)) == 2
    assert ((expected > 0.1) & (expected < 0.9)).any()
    wrong = np.abs(result.film.planes["occluded"] - expected) > 1e-3  # a pixel is a few millimetres wide
    assert wrong.mean() < 0.01  # rays that pass the sheet's edge


def test_a_soft_shadow_takes_a_share_between():
    lamp = AreaLight((0.0, 0.0, 3.0), (0.6, 0, 0), (0, 0.6, 0), 100.0, illuminant("E"))
    result = render(stage([lamp]), replace(one_ray(32), samples=64))
    occluded = result.film.planes["occluded"]
    assert occluded.min() == 0.0
    assert occluded.max() == 1.0
    assert ((occluded > 0.2) & (occluded < 0.8)).mean() > 0.05


def test_a_shadow_catcher_is_covered_by_its_shadow_alone():
    result = render(stage(mask="shadow_catcher"), one_ray(41))
    np.testing.assert_allclose(
        result.alpha, render(stage(), one_ray(41)).film.planes["occluded"], atol=FLOAT32_ROUNDING
    )
    assert result.tristimulus().max() == 0.0
    assert np.isinf(result.depth).all()


def test_a_shadow_catcher_shows_the_background_as_far_as_it_is_lit():
    world = World(illuminant("D50"), 0.7)
    result = render(stage(mask="shadow_catcher", world=world), one_ray(41))
    sky = render(replace(stage(world=world), instances=()), one_ray(41)).tristimulus()
    np.testing.assert_allclose(
        result.tristimulus(), sky * (1.0 - result.alpha[..., None].astype(np.float64)), atol=FLOAT32_ROUNDING
    )


def test_a_holdout_is_a_hole_and_keeps_its_shadow():
    scene = still_life()
    plain, held = render(scene, SETTINGS), render(masked(scene, 0, "holdout"), SETTINGS)
    alone = render(replace(scene, instances=scene.instances[:1]), SETTINGS)
    hole = held.film.planes["held"]
    assert hole.max() == 1.0
    assert ((hole > 0.0) & (hole < 1.0)).any()
    # The ball stands before everything else, so that its hole is as large as the ball.
    np.testing.assert_allclose(hole, alone.alpha, atol=FLOAT32_ROUNDING)
    np.testing.assert_allclose(held.alpha + hole, plain.alpha, atol=FLOAT32_ROUNDING)
    outside = hole == 0.0
    np.testing.assert_allclose(held.tristimulus()[outside], plain.tristimulus()[outside], atol=FLOAT64_ROUNDING)
    assert held.tristimulus()[hole == 1.0].max() == 0.0
    assert np.isinf(held.depth[hole == 1.0]).all()


def test_mirrors_show_masked_things():
    """The copper ball mirrors the plastic one, whether or not the camera sees this."""
    scene = still_life()
    scene = replace(
        scene, materials=[*scene.materials[:2], replace(scene.materials[2], mirror=1.0)], lights=scene.lights
    )
    plain, held = render(scene, SETTINGS), render(masked(scene, 0, "holdout"), SETTINGS)
    copper = render(replace(scene, instances=scene.instances[2:3]), SETTINGS).alpha == 1.0
    inside = copper & (held.film.planes["held"] == 0.0)
    assert inside.any()
    np.testing.assert_allclose(held.tristimulus()[inside], plain.tristimulus()[inside], atol=FLOAT64_ROUNDING)


def test_parts_of_the_picture_and_threads_change_no_mask():
    scene = masked(masked(still_life(), 0, "holdout"), 3, "shadow_catcher")
    settings = replace(SETTINGS, shadow_share=True, samples=8)
    whole = render(scene, replace(settings, threads=1))
    cut = render(scene, replace(settings, threads=3, band_samples=100))
    refined = render(scene, replace(settings, adaptive_threshold=1e-6, min_samples=2))
    np.testing.assert_allclose(cut.alpha, whole.alpha, atol=FLOAT32_ROUNDING)
    for name in ("held", "occluded"):
        np.testing.assert_allclose(cut.film.planes[name], whole.film.planes[name], atol=FLOAT32_ROUNDING)
    # A hole's edge is refined whatever its colours.
    held = refined.film.planes["held"]
    edges = (held > 0.0) & (held < 1.0)
    assert edges.any()
    np.testing.assert_allclose(held[edges], whole.film.planes["held"][edges], atol=FLOAT32_ROUNDING)


def test_edges_of_black_things_before_black_are_refined():
    """No colour differs there, but the picture may be laid over another one."""
    scene = replace(still_life(), lights=(), world=World())
    settings = replace(SETTINGS, samples=16)
    whole = render(scene, settings)
    refined = render(scene, replace(settings, adaptive_threshold=1.0, min_samples=4))
    assert whole.tristimulus().max() == 0.0
    edges = (refined.alpha > 0.0) & (refined.alpha < 1.0)
    assert edges.any()
    assert edges.sum() < refined.statistics.refined_pixels < edges.size / 2
    np.testing.assert_allclose(refined.alpha[edges], whole.alpha[edges], atol=FLOAT32_ROUNDING)


def test_an_unknown_mask_is_refused():
    with pytest.raises(SceneError, match=r"instance 'ball': mask must be one of .*, but is 'matte'"):
        Instance(ball(1), mask="matte")


def test_a_scene_without_masks_keeps_no_planes():
    assert render(still_life(), SETTINGS).film.planes == {}
