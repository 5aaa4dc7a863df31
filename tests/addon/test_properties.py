"""What scenes, lights and worlds keep, and the spectra and settings that it becomes."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon import compat, preferences, properties, spectrum_sources
from dichromatic_addon.nodes.base import attenuation_items
from dichromatic_addon.properties import (
    illuminant_problem,
    light_luminance,
    read_display,
    read_illuminant,
    read_settings,
    world_illuminant,
)
from tests.tolerances import BLENDER_FLOAT, REC709_ROUND_TRIP

pytestmark = pytest.mark.bpy


@pytest.mark.parametrize(
    ("search", "names"),
    [
        (spectrum_sources.search_illuminants, core.illuminant_names()),
        (spectrum_sources.search_spectra, [*core.reflectance_names(), *core.illuminant_names()]),
        (spectrum_sources.search_metals, core.metal_names()),
    ],
)
@pytest.mark.parametrize("typed", ["", "D65", "nothing has this name"])
def test_a_field_that_is_clicked_lists_the_whole_library(search, names, typed):
    """Blender hands over what the field holds, and looks for what is typed by itself."""
    assert search(None, None, typed) == list(names)


@pytest.fixture
def light(scene):
    return bpy.data.lights.new("Lamp", "POINT")


def linear_rgb(spectrum):
    """Linear Rec.709 of a light itself, its luminance brought to 1."""
    grid = core.wavelength_grid("exact")
    weights = core.tristimulus_weights(core.Spectrum.constant(1.0), core.observer("cie_1931_2"), grid)
    xyz = spectrum.at(grid.wavelengths_nm) @ weights
    return core.display("srgb").linear(xyz / xyz[1])


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"source": "LIBRARY", "illuminant": "projector-halogen"}, lambda: core.illuminant("projector-halogen")),
        ({"source": "TEMPERATURE", "radiator": "BLACKBODY", "temperature": 2856.0}, lambda: core.blackbody(2856.0)),
        ({"source": "TEMPERATURE", "radiator": "DAYLIGHT", "temperature": 5000.0}, lambda: core.daylight(5000.0)),
        ({"source": "COLOR"}, lambda: core.illuminant("D65")),
    ],
)
def test_each_source_of_an_illuminant(light, settings, expected):
    for name, value in settings.items():
        setattr(light.dichromatic, name, value)
    assert read_illuminant(light) == expected()
    assert illuminant_problem(light) == ""


def test_an_own_colour_gives_light_of_that_colour(light):
    light.color = (0.9, 0.4, 0.1)
    seen = linear_rgb(read_illuminant(light))
    # sRGB's white has four digits and differs from the tabled D65 by a few 1e-4.
    np.testing.assert_allclose(seen / seen[0], np.array([0.9, 0.4, 0.1]) / 0.9, atol=2e-3)
    assert light_luminance(light) == pytest.approx(0.2126 * 0.9 + 0.7152 * 0.4 + 0.0722 * 0.1, rel=REC709_ROUND_TRIP)


def test_the_colour_counts_only_where_it_is_the_source(light):
    light.color = (0.5, 0.5, 0.5)
    assert light_luminance(light) == pytest.approx(0.5, rel=BLENDER_FLOAT)
    light.dichromatic.source = "LIBRARY"
    assert light_luminance(light) == 1.0


def test_a_temperature_of_blenders_own_tints_the_colour(light):
    if not hasattr(light, "use_temperature"):
        pytest.skip("lights have no temperature before Blender 4.5")
    light.use_temperature, light.temperature = True, 3000.0
    red, green, blue = linear_rgb(read_illuminant(light))
    assert red > green > blue


def test_samples_of_a_file_stay_with_the_light(light, tmp_path):
    file = tmp_path / "lamp.csv"
    file.write_text("wavelength,value\n400,1\n500,2\n600,4\n", encoding="utf-8")
    light.use_fake_user = True
    light.dichromatic.source = "FILE"
    light.dichromatic.filepath = str(file)
    file.unlink()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    np.testing.assert_array_equal(read_illuminant(bpy.data.lights["Lamp"]).values, [1.0, 2.0, 4.0])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"source": "LIBRARY", "illuminant": "D66"}, "'D66'"),
        ({"source": "FILE"}, "no spectrum file is chosen"),
        ({"source": "FILE", "filepath": "/nowhere/gone.csv"}, "gone.csv"),
        ({"source": "TEMPERATURE", "radiator": "DAYLIGHT", "temperature": 2000.0}, "4000"),
    ],
)
def test_an_illuminant_that_cannot_be_had_is_named(light, settings, message):
    for name, value in settings.items():
        setattr(light.dichromatic, name, value)
    with pytest.raises(core.SceneError, match="Illuminant of light 'Lamp'") as caught:
        read_illuminant(light)
    assert message in str(caught.value)
    assert message in illuminant_problem(light)


def test_a_broken_file_keeps_its_reason(light, tmp_path):
    file = tmp_path / "broken.csv"
    file.write_text("wavelength,value\n500,1\nnonsense,2\n", encoding="utf-8")
    light.dichromatic.source, light.dichromatic.filepath = "FILE", str(file)
    with pytest.raises(core.SceneError, match=r"broken\.csv"):
        read_illuminant(light)


def test_the_world_has_an_illuminant_and_the_luminance_of_its_colour(scene):
    scene.world = bpy.data.worlds.new("Sky")
    illuminant, luminance = world_illuminant(scene, (0.25, 0.25, 0.25))
    assert (illuminant, luminance) == (core.illuminant("D65"), pytest.approx(0.25, rel=1e-12))
    scene.world.dichromatic.source, scene.world.dichromatic.illuminant = "LIBRARY", "A"
    assert world_illuminant(scene, (0.25, 0.25, 0.25))[0] == core.illuminant("A")
    scene.world.dichromatic.illuminant = "no such lamp"
    with pytest.raises(core.SceneError, match="Illuminant of world 'Sky'"):
        world_illuminant(scene, (1.0, 1.0, 1.0))


def test_a_new_scene_has_the_defaults_of_the_core(scene):
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 960, 540, 100
    settings = read_settings(scene)
    for name in core.RenderSettings.__slots__:
        expected = getattr(core.RenderSettings(), name)
        assert getattr(settings, name) == (pytest.approx(expected) if isinstance(expected, float) else expected), name


def test_every_setting_reaches_the_core(scene):
    chosen = {
        "samples": 9,
        "seed": 3,
        "pixel_filter": "box",
        "filter_width": 2.0,
        "observer": "cie_1964_10",
        "grid": "paper",
        "precision": "float64",
        "max_bounces": 7,
        "bounce_spectra": "nodes",
        "bounce_grid": "draft",
    }
    for name, value in chosen.items():
        setattr(scene.dichromatic, name, value)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 100, 50, 50
    settings = read_settings(scene)
    assert {name: getattr(settings, name) for name in chosen} == chosen
    assert (settings.width, settings.height) == (50, 25)


@pytest.mark.parametrize(
    ("items", "name"),
    [
        ("observer_items", "observer"),
        ("grid_items", "grid"),
        ("precision_items", "precision"),
        ("filter_items", "pixel_filter"),
        ("bounce_items", "bounce_spectra"),
    ],
)
def test_the_core_takes_every_choice_of_the_panels(items, name):
    for item in getattr(properties, items):
        core.RenderSettings(**{name: item[0]})


def test_the_panels_offer_every_choice_of_the_core():
    from spectral_core.colorimetry import GRID_PRESETS, OBSERVERS
    from spectral_core.tracing.sampling import PIXEL_FILTERS

    assert {item[0] for item in properties.grid_items} == set(GRID_PRESETS)
    assert {item[0] for item in properties.observer_items} == set(OBSERVERS)
    assert {item[0] for item in properties.filter_items} == set(PIXEL_FILTERS)
    assert tuple(item[0] for item in attenuation_items) == core.ATTENUATIONS


def test_the_adopted_white(scene, light):
    settings = scene.dichromatic
    assert read_display(scene).white == core.illuminant("D65")
    assert read_display(scene).adaptation == "bradford"
    settings.white_source, settings.white_temperature = "TEMPERATURE", 3200.0
    assert read_display(scene).white == core.blackbody(3200.0)
    settings.white_source = "LIGHT"
    with pytest.raises(core.SceneError, match=r"Adopted white of scene .*no light is chosen"):
        read_display(scene)
    light.dichromatic.source, light.dichromatic.illuminant = "LIBRARY", "A"
    settings.white_light = light
    assert read_display(scene).white == core.illuminant("A")
    settings.white_source, settings.white_illuminant = "LIBRARY", "no such lamp"
    with pytest.raises(core.SceneError, match=r"Adopted white of scene .*no such lamp"):
        read_display(scene)


def test_preferences_are_those_of_the_root_package(addon):
    assert compat.root_package() == "dichromatic_addon"
    assert preferences.DichromaticPreferences.bl_idname == "dichromatic_addon"
    assert preferences.preferences() is None  # registered by hand, not enabled as an add-on
