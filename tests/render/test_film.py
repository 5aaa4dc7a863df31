"""The film: merging of samples, relighting, the memory limit, progress and cancel."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core import film_builder
from spectral_core.colorimetry import observer, wavelength_grid
from spectral_core.errors import InvalidParameterError, RenderCancelledError, SceneError
from spectral_core.film import add_rows
from spectral_core.film_builder import Deposits, FilmBuilder
from spectral_core.library import illuminant
from spectral_core.lights import PointLight, SpotLight, SunLight
from spectral_core.plan import make_plan
from spectral_core.reflection.materials import TypeI, TypeIII
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.scene_spectra import SceneSpectra, Term
from spectral_core.spectra import Spectrum
from tests.render.render_scenes import RED, ball, look_at, placed, still_life, three_types
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING

SMALL = {"width": 48, "height": 32, "samples": 3}


def test_merging_is_the_mean_over_samples_whatever_the_order():
    rng = np.random.default_rng(0)
    spectra = SceneSpectra.from_scene(still_life())
    terms = (Term(0, (1,)), Term(1, (0,)))
    builder = FilmBuilder(5, 4, spectra, observer("cie_1931_2"), wavelength_grid("exact"))
    pixels = rng.integers(10, 20, 300)
    values = rng.random((300, 2))
    deposits = Deposits(np.arange(10, 20), 5, np.dtype(np.float64))
    deposits.deposit(terms, pixels[:100] - 10, values[:100])
    deposits.deposit(terms, pixels[100:] - 10, values[100:])
    builder.add(deposits.merge(7))
    block = builder.finish().blocks[0]
    expected = np.zeros((20, 2))
    np.add.at(expected, pixels, values / 7)
    np.testing.assert_allclose(block.coefficients, expected[block.pixels], rtol=FLOAT64_ROUNDING)
    assert np.array_equal(block.pixels, np.unique(pixels))


@pytest.mark.parametrize("samples", [1, 3])
@pytest.mark.parametrize("order", ["increasing", "shuffled"])
def test_pixels_of_a_deposit_may_come_in_any_order(samples, order):
    """Mirrored rays come sorted by what they met, those of the camera row by row; a pixel's sum is the same bits."""
    rng = np.random.default_rng(1)
    spectra = SceneSpectra.from_scene(still_life())
    terms = (Term(0, (1,)), Term(1, (0,)), Term(2))
    built = FilmBuilder(9, 6, spectra, observer("cie_1931_2"), wavelength_grid("exact"))
    deposits = Deposits(np.arange(54), 9, np.dtype(np.float32))
    expected = np.zeros((54, 3))
    for _ in range(samples):
        pixels = rng.permutation(54)[:40]
        pixels = np.sort(pixels) if order == "increasing" else pixels
        values = rng.random((40, 3)).astype(np.float32)
        expected[pixels] += values
        deposits.deposit(terms, pixels, values)
    built.add(deposits.merge(samples))
    (block,) = built.finish().blocks
    assert np.array_equal(block.pixels, np.flatnonzero(expected[:, 0]))
    assert block.pixels.dtype == np.int32
    assert np.array_equal(block.coefficients, (expected / samples).astype(np.float32)[block.pixels])


def test_memory_for_deposits_does_not_grow_with_the_samples():
    rows, samples, terms = 1 << 16, 64, tuple(Term(emitter) for emitter in range(8))
    rng = np.random.default_rng(1)
    deposits = Deposits(np.arange(rows), 256, np.dtype(np.float32))
    tracemalloc.start()
    for _ in range(samples):
        deposits.deposit(terms, np.arange(rows), rng.random((rows, 8), np.float32))
        deposits.deposit_colour(np.arange(rows), rng.random((rows, 3)))
    part = deposits.merge(samples)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    waiting = samples * rows * (8 * 4 + 3 * 8 + 2 * 8)
    assert peak < 0.5 * waiting
    np.testing.assert_allclose(part.blocks[0].coefficients.mean(), 0.5, atol=1e-3)


@pytest.mark.parametrize("bounce_spectra", ["terms", "nodes"])
def test_when_deposits_are_added_up_changes_nothing(bounce_spectra, monkeypatch):
    scene = still_life()
    mirrors = tuple(replace(material, mirror=0.6) for material in scene.materials)
    scene = replace(scene, materials=mirrors)
    settings = RenderSettings(24, 16, samples=3, bounce_spectra=bounce_spectra, split_light=True, threads=1)
    at_the_end = render(scene, settings)
    monkeypatch.setattr(film_builder, "_MOST_PENDING", 5000)
    often = render(scene, settings)
    assert np.array_equal(often.tristimulus(), at_the_end.tristimulus())
    for one, other in zip(often.film.blocks, at_the_end.film.blocks, strict=True):
        assert np.array_equal(one.pixels, other.pixels)
        assert np.array_equal(one.coefficients, other.coefficients)


def test_rows_are_added_where_they_belong():
    rng = np.random.default_rng(2)
    for width, dtype in ((1, np.float32), (3, np.float32), (7, np.float64)):
        image = rng.random((20, width)).astype(dtype)
        expected = image.copy()
        index, rows = rng.permutation(20)[:12], rng.random((12, width)).astype(dtype)
        for i, row in zip(index, rows, strict=True):
            expected[i] += row
        add_rows(image, index, rows)
        assert np.array_equal(image, expected)


def test_a_coefficient_that_is_not_finite_is_refused_with_its_pixel():
    builder = Deposits(np.arange(20), 5, np.dtype(np.float64))
    with pytest.raises(InvalidParameterError, match=r"pixel \(3, 1\) is not finite"):
        builder.deposit((Term(0),), np.array([8]), np.array([[np.nan]]))
    with pytest.raises(InvalidParameterError, match=r"pixel \(1, 2\) is not finite"):
        builder.deposit((Term(0),), np.array([8, 11, 12]), np.array([[1.0], [np.inf], [-np.inf]]))
    huge = np.full((2, 1), 3e38, np.float32)  # the sum of finite values may overflow
    builder.deposit((Term(0),), np.array([8, 9]), huge)


@pytest.mark.parametrize("band_samples", [1, 48, 200, 10**6])
def test_the_size_of_the_bands_changes_nothing(band_samples):
    scene = still_life()
    whole = render(scene, RenderSettings(**SMALL))
    banded = render(scene, RenderSettings(**SMALL, band_samples=band_samples))
    assert np.array_equal(whole.tristimulus(), banded.tristimulus())
    assert np.array_equal(whole.depth, banded.depth)


def test_bands_as_they_finish_make_up_the_image():
    bands = []
    result = render(still_life(), RenderSettings(**SMALL, band_samples=200), on_band=bands.append)
    assert len(bands) == 8
    image = result.tristimulus()
    for band in bands:
        rows = slice(band.first_row, band.first_row + len(band.tristimulus))
        assert np.array_equal(image[rows], band.tristimulus)
        assert np.array_equal(result.alpha[rows], band.coverage)


def test_relighting_equals_a_fresh_render():
    scene = still_life()
    settings = RenderSettings(**SMALL, precision="float64")
    first = render(scene, settings)
    spectra = first.spectra.with_light("key", illuminant=illuminant("FL11"), strength=300.0)
    spectra = spectra.with_reflectance("plastic", "body", RED)
    relit = first.relit(spectra).tristimulus()
    plastic, *others = three_types()
    changed = type(plastic)(RED, plastic.interface_reflectance, plastic.attenuation, plastic.n)
    key = scene.lights[0]
    lights = [PointLight(key.position, 300.0, illuminant("FL11"), "key"), *scene.lights[1:]]
    fresh = render(
        Scene(scene.instances, [changed, *others], lights, scene.camera, scene.world, scene.material_names), settings
    ).tristimulus()
    np.testing.assert_allclose(relit, fresh, rtol=FLOAT64_ROUNDING)
    assert np.abs(relit - first.tristimulus()).max() > 0.01


def test_relighting_names_what_it_does_not_know():
    spectra = SceneSpectra.from_scene(still_life())
    with pytest.raises(InvalidParameterError, match=r"no light is named 'Key'; the scene has 'key', 'sun'"):
        spectra.with_light("Key", strength=1.0)
    with pytest.raises(InvalidParameterError, match="no material 'wood' has a body reflectance"):
        spectra.with_reflectance("wood", "body", RED)


def test_beyond_the_memory_limit_the_film_keeps_plain_colour():
    scene = still_life()
    kept = render(scene, RenderSettings(**SMALL))
    fixed = render(scene, RenderSettings(**SMALL, film_bytes=10_000, band_samples=200))
    assert not fixed.statistics.is_relightable
    assert fixed.film.nbytes < kept.film.nbytes
    np.testing.assert_allclose(fixed.tristimulus(), kept.tristimulus(), rtol=FLOAT32_ROUNDING, atol=1e-6)
    with pytest.raises(InvalidParameterError, match="plain colour"):
        fixed.relit(fixed.spectra)


def test_equal_seeds_give_equal_images_and_others_do_not():
    scene = still_life()
    one, same, other = (render(scene, RenderSettings(**SMALL, seed=s)).tristimulus() for s in (5, 5, 6))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_pixel_spectrum_integrates_to_the_pixels_colour():
    result = render(still_life(), RenderSettings(**SMALL, precision="float64"))
    sees = observer("cie_1931_2")
    terms, radiance = result.film.spectrum_at(20, 16, result.spectra, sees.wavelengths_nm, sees)
    assert len(terms) == len(radiance) > 1
    np.testing.assert_allclose(
        radiance.sum(axis=0) @ sees.matching_functions, result.tristimulus()[16, 20], rtol=FLOAT64_ROUNDING
    )


def test_cancel_between_bands_stops_the_render():
    calls = []

    def cancel():
        calls.append(1)
        return len(calls) > 4

    with pytest.raises(RenderCancelledError):
        render(still_life(), RenderSettings(**SMALL, band_samples=48), cancel=cancel)
    assert len(calls) == 5


def test_progress_goes_from_zero_to_one():
    seen = []
    render(still_life(), RenderSettings(**SMALL, band_samples=300), progress=lambda f, m: seen.append((f, m)))
    fractions = [f for f, _ in seen]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0.0
    assert seen[-1] == (1.0, "done")


def test_a_scene_without_a_camera_is_refused():
    with pytest.raises(SceneError, match="scene 'Scene' has no camera"):
        render(Scene())


@pytest.mark.parametrize(("part", "kind"), [("instances", "instance"), ("materials", "material"), ("lights", "light")])
def test_a_scene_holds_nothing_of_another_kind(part, kind):
    with pytest.raises(SceneError, match=f"holds 'a word', which is no {kind}"):
        Scene(**{part: ["a word"]})


def test_a_picture_has_no_more_pixels_than_the_film_can_number():
    with pytest.raises(InvalidParameterError, match="width x height must lie between 1 and 2147483647"):
        RenderSettings(65536, 65536)


def test_materials_are_made_of_spectra():
    with pytest.raises(InvalidParameterError, match=r"body_reflectance must be a Spectrum, but is 0\.5"):
        TypeI(0.5)
    with pytest.raises(InvalidParameterError, match="normal_reflectance must be a Spectrum, but is 'gold'"):
        TypeIII.from_normal_reflectance("gold", 0.1)


def test_an_empty_scene_shows_its_world():
    camera = look_at((0, -3, 1), (0, 0, 0), 0.5, 0.5)
    world = World(illuminant("D65"), 0.5)
    result = render(Scene(camera=camera, world=world), RenderSettings(3, 2))
    image = result.tristimulus()
    np.testing.assert_allclose(image[..., 1], 0.5, rtol=FLOAT32_ROUNDING)
    assert result.alpha.max() == 0.0
    assert np.isinf(result.depth).all()
    black = render(Scene(camera=camera), RenderSettings(1, 1)).tristimulus()
    assert np.array_equal(black, np.zeros((1, 1, 3)))


def test_a_lamp_without_luminance_is_refused_before_any_ray():
    dark = Spectrum(np.array([1000.0, 1100.0]), np.array([0.0, 0.0]), name="off")
    scene = Scene(
        [placed(ball(1))],
        three_types()[:1],
        [PointLight((1, 1, 1), 1.0, dark, "lamp")],
        look_at((0, -3, 0), (0, 0, 0), 0.4, 0.4),
    )
    with pytest.raises(InvalidParameterError, match="off"):
        render(scene, RenderSettings(4, 4))


def test_equal_spectra_are_integrated_once():
    scene = still_life(("D65", "D65", "D65"))
    plan = render(scene, RenderSettings(4, 4)).statistics.plan
    # 3 lights x (2 + 2 + 2 components) terms and the world; one lamp spectrum leaves 6 products and the world's
    assert plan.startswith("19 terms (spectra multiplied along a path), 7 distinct products integrated")


def test_lights_that_reach_nothing_are_left_out_or_named():
    scene = still_life()
    key = scene.lights[0]
    away = SpotLight((0.0, 0.0, 30.0), (0.0, 0.0, 1.0), 500.0, illuminant("A"), 0.9, 0.5, "away")
    below = SunLight((0.0, 0.0, -1.0), 1.0, illuminant("A"), "below the floor")
    lit = Scene(scene.instances, scene.materials, [key, away, below], scene.camera, scene.world, scene.material_names)
    made = render(lit, RenderSettings(**SMALL))
    assert "- shadow rays and shading for light 'away': it shines past the whole scene" in made.statistics.plan
    assert made.statistics.lit_points.keys() == {"key", "below the floor"}
    assert made.statistics.lit_points["below the floor"] == 0
    assert "light 'below the floor' reached nothing that is seen" in made.statistics.describe()
    alone = Scene(scene.instances, scene.materials, [key], scene.camera, scene.world, scene.material_names)
    assert np.array_equal(made.tristimulus(), render(alone, RenderSettings(**SMALL)).tristimulus())


@given(st.floats(0.01, 3.1), st.floats(1.0, 50.0), st.floats(0.0, np.pi), st.floats(0.1, 0.9))
def test_a_spot_light_is_left_out_only_if_it_lights_no_point(size, distance, turn, blend):
    mesh = ball(1)
    position = np.array([distance + 1.0, 0.0, 0.0])
    light = SpotLight(position, (-np.cos(turn), np.sin(turn), 0.0), 1.0, illuminant("E"), size, blend, "spot")
    scene = Scene([placed(mesh)], three_types()[:1], [light], look_at((0, -3, 0), (0, 0, 0), 0.4, 0.4))
    if not make_plan(scene, RenderSettings(1, 1)).lights:
        assert light.illuminate(mesh.vertices, np.zeros(3)).irradiance.max() == 0.0
