"""Light that mirrors show, within the limit of terms, against the slow sum in every pixel and under every lamp."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from spectral_core.library import illuminant, illuminant_names, optical_constants, reflectance
from spectral_core.lights import PointLight, SunLight
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.tracing.sampling import pixel_offsets
from tests.render import brute_force
from tests.render.render_scenes import RED, SHEEN, ball, floor, look_at, placed
from tests.tolerances import FILM_AGAINST_BRUTE_FORCE

WIDTH, HEIGHT, BOUNCES = 24, 16, 2
SETTINGS = RenderSettings(WIDTH, HEIGHT, samples=1, precision="float64", max_bounces=BOUNCES, bounce_spectra="auto")
COPPER, GOLD = optical_constants("copper"), optical_constants("gold")
CONSTANTS = (COPPER, GOLD, None, None)


def mirrors(lamps=("FL2", "HP1")):
    """Balls of copper and gold, one reflected in the other, on a glossy cloth, beside a matte ball."""
    return Scene(
        instances=[
            placed(ball(1, 0), (-0.95, 0.3, 0.9), 0.9),
            placed(ball(2, 1), (0.95, 0.0, 0.9), 0.9),
            placed(ball(1, 3, smooth=False), (0.1, -1.4, 0.4), 0.4),
            placed(floor(4.0, 2)),
        ],
        materials=[
            TypeIII.from_optical_constants(COPPER, math.radians(18.0), mirror=0.9),
            TypeIII.from_optical_constants(GOLD, math.radians(12.0), mirror=1.0),
            TypeII(RED, SHEEN, "exponential", 10.0, mirror=0.3),
            TypeI(reflectance("blue"), 0.5, "cosine", 11.0),
        ],
        lights=[
            PointLight((2.0, -4.0, 4.0), 900.0, illuminant(lamps[0]), "key"),
            SunLight((-0.5, -0.6, 1.0), 1.2, illuminant(lamps[1]), "sun"),
        ],
        camera=look_at((0.4, -5.0, 2.4), (0.0, 0.0, 0.6), 0.36, 0.24),
        world=World(illuminant("D50"), 0.3),
        material_names=("copper", "gold", "cloth", "plastic"),
    )


@functools.cache
def rendered():
    return render(mirrors(), SETTINGS)


@functools.cache
def summed():
    """What each emitter's spectrum is multiplied by in every pixel, by the slow way; lamps come later."""
    offsets = pixel_offsets(1, SETTINGS.pixel_filter, SETTINGS.filter_width, SETTINGS.seed)
    return brute_force.transported(mirrors(), WIDTH, HEIGHT, offsets, CONSTANTS, BOUNCES)


def test_the_scene_mirrors_mirrors():
    """What follows would prove little if few rays met two mirrors."""
    statistics = rendered().statistics
    assert "'copper', 'gold', 'cloth', up to 2 deep, kept exactly as products of spectra" in statistics.plan
    assert rendered().film.is_relightable
    longest = max(len(term.slots) for term in rendered().film.terms)
    assert longest == BOUNCES + 1
    assert statistics.mirror_rays > 1.1 * WIDTH * HEIGHT


def test_mirrored_light_equals_the_spectral_sum_in_every_pixel():
    scene = mirrors()
    expected = brute_force.seen(
        summed(),
        [e.illuminant for e in (*scene.lights, scene.world)],
        [e.strength for e in (*scene.lights, scene.world)],
        SETTINGS.observer,
    )
    np.testing.assert_allclose(rendered().tristimulus(), expected, rtol=FILM_AGAINST_BRUTE_FORCE)
    once = render(scene, RenderSettings(WIDTH, HEIGHT, samples=1, precision="float64", max_bounces=0)).tristimulus()
    assert np.abs(expected - once).max() > 0.1


@pytest.mark.parametrize("observer", ["cie_1931_2", "cie_1964_10"])
def test_every_lamp_of_the_library_gives_the_colours_of_the_spectral_sum(observer):
    """One render, relit by each lamp in turn: F and HP lines included."""
    render_ = rendered()
    emitters = render_.spectra.emitters
    assert {"FL1", "FL12", "FL3.15", "HP1", "HP5", "LED-V2", "D65", "A"} <= set(illuminant_names())
    for name in illuminant_names():
        lamp = illuminant(name)
        spectra = render_.spectra
        for emitter in emitters:
            spectra = spectra.with_light(emitter.name, illuminant=lamp)
        relit = replace(render_.relit(spectra), observer=observer).tristimulus()
        expected = brute_force.seen(summed(), [lamp] * 3, [e.strength for e in emitters], observer)
        np.testing.assert_allclose(relit, expected, rtol=FILM_AGAINST_BRUTE_FORCE, err_msg=name)
