"""The picture of a view against the whole render: at its end, on its way, and in other colours."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import spectral_core as core
from spectral_core.lights import AreaLight
from tests.render.render_scenes import RED, still_life
from tests.tolerances import FLOAT32_ROUNDING

SETTINGS = core.RenderSettings(width=44, height=31, samples=3, band_samples=500, threads=1)


def soft_scene() -> Any:
    scene = still_life()
    lamp = AreaLight((2.0, -3.0, 4.0), (0.8, 0.0, 0.0), (0.0, 0.8, 0.0), 400.0, core.illuminant("A"), name="panel")
    return replace(scene, lights=[*scene.lights, lamp])


def relit(scene: Any) -> Any:
    """Other lamps, strengths, sky and paint; the same geometry."""
    lights = [replace(scene.lights[0], illuminant=core.illuminant("HP1"), strength=300.0), *scene.lights[1:]]
    lights[1] = core.SunLight((-0.5, -0.4, 1.0), 0.3, core.illuminant("A"), "sun")
    materials = (replace(scene.materials[0], body_reflectance=RED, interface_reflectance=0.3), *scene.materials[1:])
    world = replace(scene.world, illuminant=core.illuminant("A"), strength=0.4)
    return replace(scene, lights=lights, materials=materials, world=world)


def assert_same_picture(progressive: Any, scene: Any, settings: Any = SETTINGS) -> None:
    whole = core.render(scene, settings)
    expected = whole.tristimulus()
    # The samples of a pixel are added up one by one, and not all at once.
    tolerance = 10 * FLOAT32_ROUNDING * float(expected.max())
    np.testing.assert_allclose(progressive.tristimulus, expected, atol=tolerance)
    np.testing.assert_allclose(progressive.coverage, whole.alpha, atol=FLOAT32_ROUNDING)


@pytest.mark.parametrize("scene", [still_life(), soft_scene()], ids=["hard", "soft"])
def test_finished_picture_is_that_of_render(scene: Any) -> None:
    progressive = core.ProgressiveRender(scene, SETTINGS)
    steps = list(progressive.steps())
    assert [done for _, _, done in steps] == sorted(done for _, _, done in steps)
    assert steps[-1][2] == 1.0
    assert_same_picture(progressive, scene)


@pytest.mark.parametrize("scene", [still_life(), soft_scene()], ids=["hard", "soft"])
@pytest.mark.parametrize("after", [1, 4, 1000])
def test_recoloured_on_the_way_it_ends_as_the_other_scene(scene: Any, after: int) -> None:
    progressive = core.ProgressiveRender(scene, SETTINGS)
    other, settings = relit(scene), replace(SETTINGS, observer="cie_1964_10")
    for number, _ in enumerate(progressive.steps()):
        if number + 1 == after:
            break
    before, rows = progressive.tristimulus.copy(), progressive.covered_rows
    assert progressive.recolour(other, settings)
    assert not np.allclose(progressive.tristimulus[:rows], before[:rows], rtol=0.01)
    # What is shown at once is what the other scene would show at this point of its own way.
    own = core.ProgressiveRender(other, settings)
    for number, _ in enumerate(own.steps()):
        if number + 1 == after:
            break
    np.testing.assert_allclose(
        progressive.tristimulus, own.tristimulus, atol=10 * FLOAT32_ROUNDING * float(own.tristimulus.max())
    )


def test_steps_after_a_change_of_colours_have_the_new_ones() -> None:
    scene = soft_scene()
    progressive, other = core.ProgressiveRender(scene, SETTINGS), relit(scene)
    for number, _ in enumerate(progressive.steps()):
        if number == 20:
            assert progressive.recolour(other, SETTINGS)
    assert_same_picture(progressive, other)


def changed_light(scene: Any, **what: Any) -> Any:
    return replace(scene, lights=[replace(scene.lights[0], **what), *scene.lights[1:]])


def changed_material(scene: Any, index: int, **what: Any) -> Any:
    materials = list(scene.materials)
    materials[index] = replace(materials[index], **what)
    return replace(scene, materials=tuple(materials))


def gold() -> Any:
    return core.TypeIII.from_optical_constants(core.optical_constants("gold"), beta=math.radians(20.0))


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: changed_light(scene, position=(3.0, -3.0, 4.1)),
        lambda scene: changed_light(scene, radius=0.2),
        lambda scene: changed_light(scene, casts_shadow=False),
        lambda scene: replace(scene, lights=scene.lights[1:]),
        lambda scene: replace(scene, lights=[scene.lights[1], scene.lights[0], *scene.lights[2:]]),
        lambda scene: changed_material(scene, 0, n=12.0),
        lambda scene: changed_material(scene, 0, attenuation="gaussian"),
        lambda scene: changed_material(scene, 1, energy_conserving=True),
        lambda scene: changed_material(scene, 2, beta=math.radians(21.0)),
        lambda scene: changed_material(scene, 2, mirror=0.5),
        lambda scene: replace(scene, materials=(scene.materials[1], *scene.materials[1:])),
        lambda scene: replace(scene, world=replace(scene.world, lights_surfaces=True)),
        lambda scene: replace(scene, materials=(*scene.materials[:2], gold())),
    ],
)
def test_other_changes_are_not_taken_for_colours(change: Any) -> None:
    scene = still_life()
    progressive = core.ProgressiveRender(scene, SETTINGS)
    next(progressive.steps())
    before = progressive.tristimulus.copy()
    assert not progressive.recolour(change(scene), SETTINGS)
    np.testing.assert_array_equal(progressive.tristimulus, before)


def test_lamp_that_was_dark_is_not_lit_without_rays() -> None:
    scene = still_life()
    progressive = core.ProgressiveRender(changed_light(scene, strength=0.0), SETTINGS)
    assert not progressive.recolour(scene, SETTINGS)
    progressive = core.ProgressiveRender(scene, SETTINGS)
    assert progressive.recolour(changed_light(scene, strength=0.0), SETTINGS)
    assert progressive.recolour(scene, SETTINGS)


def test_other_samples_are_traced() -> None:
    progressive = core.ProgressiveRender(still_life(), SETTINGS)
    assert not progressive.recolour(still_life(), replace(SETTINGS, samples=4))
    assert progressive.recolour(still_life(), replace(SETTINGS, grid="paper"))


def test_strongest_interface_of_a_conserving_material_is_geometry() -> None:
    scene = changed_material(still_life(), 0, energy_conserving=True)
    progressive = core.ProgressiveRender(scene, SETTINGS)
    assert progressive.recolour(changed_material(scene, 0, body_reflectance=RED), SETTINGS)
    assert not progressive.recolour(changed_material(scene, 0, interface_reflectance=0.6), SETTINGS)


def test_strongest_interface_of_a_mirror_is_geometry() -> None:
    """It decides how much of the light of the world the mirror leaves to the lobe."""
    scene = changed_material(still_life(), 0, mirror=0.05)
    progressive = core.ProgressiveRender(scene, SETTINGS)
    assert progressive.recolour(changed_material(scene, 0, body_reflectance=RED), SETTINGS)
    assert not progressive.recolour(changed_material(scene, 0, interface_reflectance=0.3), SETTINGS)


def test_pictures_on_surfaces_are_compared_by_their_pixels() -> None:
    def printed(seed: int) -> Any:
        pixels = np.random.default_rng(seed).random((4, 4, 3))
        return changed_material(still_life(), 0, body_reflectance=core.uplift_texture(core.ImageTexture(pixels)))

    progressive = core.ProgressiveRender(printed(0), SETTINGS)
    assert progressive.recolour(changed_light(printed(0), strength=300.0), SETTINGS)
    assert not progressive.recolour(printed(1), SETTINGS)


def test_draft_covers_the_view_in_its_first_step() -> None:
    settings = replace(SETTINGS, samples=1, band_samples=44 * 31)
    draft = core.ProgressiveRender(soft_scene(), settings, is_draft=True)
    first, end, done = next(draft.steps())
    assert (first, end, done, draft.covered_rows) == (0, 31, 1.0, 31)
    assert (draft.tristimulus[..., 1] > 0.0).mean() > 0.9
