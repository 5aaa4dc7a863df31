"""The light of a film taken apart: each part against a render of that part alone, and all of them against the whole."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_core.errors import InvalidParameterError
from spectral_core.light_groups import LIGHT_COMPONENTS, LightPart, component_of, split_light
from spectral_core.reflection.materials import TypeI, TypeII
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene
from spectral_core.spectra import Spectrum
from tests.render.render_scenes import still_life
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING, STANDARD_GRID_COLOUR

SETTINGS = RenderSettings(width=48, height=32, samples=2, precision="float64", max_bounces=2, bounce_spectra="terms")
BLACK = Spectrum.constant(0.0, name="black")


def mirrored() -> Scene:
    """The still life with every surface a mirror."""
    scene = still_life()
    return replace(scene, materials=[replace(material, mirror=0.4) for material in scene.materials])


@pytest.mark.parametrize("scene", [still_life(), mirrored()], ids=["direct", "mirrored"])
def test_components_add_up_to_the_picture(scene):
    result = render(scene, SETTINGS)
    parts = split_light(result, [LightPart(name) for name in LIGHT_COMPONENTS])
    assert all(part.max() > 0.01 for part in parts)
    np.testing.assert_allclose(sum(parts), result.tristimulus(), atol=10 * FLOAT64_ROUNDING)


def test_lamps_and_the_world_add_up_to_the_picture():
    result = render(mirrored(), SETTINGS)
    names = [emitter.name for emitter in result.spectra.emitters]
    parts = split_light(result, [LightPart(lights=(name,)) for name in names])
    assert all(part.max() > 0.01 for part in parts)
    np.testing.assert_allclose(sum(parts), result.tristimulus(), atol=10 * FLOAT64_ROUNDING)


@pytest.mark.parametrize("light", [0, 1, 2])
def test_the_part_of_a_lamp_is_what_it_gives_alone(light):
    scene = mirrored()
    alone = replace(
        scene,
        lights=[replace(lamp, strength=lamp.strength * (i == light)) for i, lamp in enumerate(scene.lights)],
        world=replace(scene.world, strength=0.0),
    )
    expected = render(alone, SETTINGS).tristimulus()
    (part,) = split_light(render(scene, SETTINGS), [LightPart(lights=(scene.lights[light].name,))])
    assert expected.max() > 0.1
    np.testing.assert_allclose(part, expected, atol=10 * FLOAT64_ROUNDING)


def test_the_body_is_what_black_bodies_take_away():
    """Mirrored bodies as well: what is left is the interface's and the world's."""
    scene = mirrored()

    def without_body(material):
        return replace(material, body_reflectance=BLACK) if isinstance(material, TypeI | TypeII) else material

    bodiless = replace(scene, materials=[without_body(material) for material in scene.materials])
    whole, left = render(scene, SETTINGS), render(bodiless, SETTINGS)
    (body,) = split_light(whole, [LightPart("body")])
    assert body.max() > 0.1
    np.testing.assert_allclose(body, whole.tristimulus() - left.tristimulus(), atol=10 * FLOAT64_ROUNDING)


def test_a_metal_has_interface_reflection_only_and_the_empty_sky_is_emission():
    result = render(still_life(), SETTINGS)
    slots = result.spectra.slots
    metal = {term for term in result.film.terms if any(slots[slot].material == "copper" for slot in term.slots)}
    assert metal
    assert {component_of(term, result.spectra) for term in metal} == {"interface"}
    (sky,) = split_light(result, [LightPart("emission")])
    np.testing.assert_allclose(sky[0], result.tristimulus()[0], rtol=FLOAT64_ROUNDING)
    assert sky[result.alpha == 1.0].max() == 0.0


def test_a_relit_render_is_split_with_its_new_lamps():
    result = render(still_life(), SETTINGS)
    relit = result.relit(result.spectra.with_light("sun", strength=result.spectra.emitters[1].strength * 2))
    (before,), (after,) = (split_light(r, [LightPart(lights=("sun",))]) for r in (result, relit))
    np.testing.assert_allclose(after, 2 * before, rtol=FLOAT64_ROUNDING)


def test_what_cannot_be_split_says_why():
    result = render(still_life(), SETTINGS)
    with pytest.raises(InvalidParameterError, match="no light is named or numbered 'Key'; the render has 'key', 'sun'"):
        split_light(result, [LightPart(lights=("Key",))])
    with pytest.raises(InvalidParameterError, match="no light is named or numbered 9"):
        split_light(result, [LightPart(lights=(9,))])
    with pytest.raises(InvalidParameterError, match="component must be one of"):
        LightPart("gloss")
    with pytest.raises(InvalidParameterError, match="sequence of names, but is the text 'key'"):
        LightPart(lights="key")
    deep = render(mirrored(), replace(SETTINGS, bounce_spectra="nodes"))
    assert not deep.film.is_relightable
    with pytest.raises(InvalidParameterError, match="cannot be split"):
        split_light(deep, [LightPart("body")])
    assert split_light(result, []) == []


@pytest.mark.parametrize(
    "changes",
    [
        {"bounce_spectra": "nodes"},
        {"film_bytes": 50_000, "band_samples": 300},
        {"bounce_spectra": "nodes", "film_bytes": 20_000, "adaptive_threshold": 1.0, "min_samples": 2, "samples": 6},
    ],
    ids=["nodes", "memory limit", "both, adaptive"],
)
def test_light_without_terms_is_split_too_when_asked(changes):
    scene = mirrored()
    settings = replace(SETTINGS, **changes)
    result = render(scene, replace(settings, split_light=True))
    assert not result.film.is_relightable
    np.testing.assert_allclose(result.tristimulus(), render(scene, settings).tristimulus(), atol=10 * FLOAT32_ROUNDING)
    components = split_light(result, [LightPart(name) for name in LIGHT_COMPONENTS])
    lamps = split_light(result, [LightPart(lights=(i,)) for i in range(len(result.spectra.emitters))])
    for parts in (components, lamps):
        np.testing.assert_allclose(sum(parts), result.tristimulus(), atol=10 * FLOAT32_ROUNDING)
    # The nodes integrate what the terms hold exactly; the memory limit loses nothing but the terms.
    exact = split_light(render(scene, replace(settings, bounce_spectra="terms", film_bytes=None)), [LightPart("body")])
    np.testing.assert_allclose(components[0], exact[0], atol=STANDARD_GRID_COLOUR)
    alone = split_light(result, [LightPart("body", lights=("sun",))])[0]
    assert 0.0 < alone.sum() < components[0].sum()


def test_what_metals_reflect_of_the_sky_is_their_interface():
    scene = still_life()
    lit = replace(scene, lights=(), world=replace(scene.world, lights_surfaces=True), instances=scene.instances[2:3])
    result = render(lit, SETTINGS)
    interface, emission = split_light(result, [LightPart("interface"), LightPart("emission")])
    ball, sky = result.alpha == 1.0, result.alpha == 0.0
    assert interface[ball].min() > 0.0
    assert emission[ball].max() == interface[sky].max() == 0.0
