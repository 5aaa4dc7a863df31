"""Lamp studies, kept renders and spectral pictures, from one small render."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest

from spectral_core.colorimetry import observer
from spectral_core.development import Development
from spectral_core.display import Display, display
from spectral_core.errors import DichromaticError, InvalidParameterError, MemoryLimitError
from spectral_core.library import illuminant
from spectral_core.light_groups import LightPart, split_light
from spectral_core.lights import SunLight
from spectral_core.probe import probe_pixel
from spectral_core.reflection.materials import TypeI, TypeII
from spectral_core.render_file import open_render, save_render
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.spectra import Spectrum, gaussian
from spectral_core.spectral_exr import channel_name, radiance_image, write_spectral_exr
from spectral_core.studies import contact_sheet, metamerism_map, relit_by
from tests.render.render_scenes import floor, look_at, placed, still_life
from tests.tolerances import FLOAT32_ROUNDING

SETTINGS = RenderSettings(32, 22, samples=2, seed=1)


@pytest.fixture(scope="module")
def finished():
    return render(still_life(), SETTINGS)


def test_a_kept_render_opens_as_it_was(finished, tmp_path):
    path = tmp_path / "render.npz"
    made = Development(adopted_white=illuminant("A"), adaptation="cat16", exposure=0.5, gamut="compress")
    save_render(path, finished, made)
    opened, development = open_render(path)
    assert np.array_equal(opened.tristimulus(), finished.tristimulus())
    assert np.array_equal(opened.depth, finished.depth)
    assert opened.spectra == finished.spectra
    assert opened.statistics.plan == finished.statistics.plan
    assert (development.adaptation, development.exposure, development.gamut) == ("cat16", 0.5, "compress")
    assert development.adopted_white == illuminant("A")
    relit = relit_by(opened, illuminant("FL11"), ["key"]).tristimulus()
    assert np.array_equal(relit, relit_by(finished, illuminant("FL11"), ["key"]).tristimulus())
    assert [p.name for p in tmp_path.iterdir()] == ["render.npz"]


def test_shares_and_parts_of_the_light_are_kept_with_the_render(tmp_path):
    scene = still_life()
    scene = replace(scene, instances=[replace(scene.instances[0], mask="holdout"), *scene.instances[1:]])
    made = render(scene, replace(SETTINGS, film_bytes=0, split_light=True, shadow_share=True))
    path = tmp_path / "render.npz"
    save_render(path, made)
    opened, _ = open_render(path)
    for name in ("held", "occluded"):
        assert np.ptp(made.film.planes[name]) > 0.5
        np.testing.assert_array_equal(opened.film.planes[name], made.film.planes[name])
    parts = [LightPart("body", ("key",)), LightPart("interface")]
    for one, other in zip(split_light(opened, parts), split_light(made, parts), strict=True):
        assert one.max() > 0.1
        np.testing.assert_array_equal(one, other)
    assert opened.film.nbytes == made.film.nbytes
    assert made.film.nbytes == made.statistics.film_bytes > 10 * made.film.coverage.nbytes  # the lamps' parts count
    with np.load(path) as archive:
        arrays = dict(archive)
    for name in ("plane_held", "fixed_0"):
        np.savez(path, **{**arrays, name: arrays[name][1:]})
        with pytest.raises(DichromaticError, match="must have the shape"):
            open_render(path)


def test_a_measured_monitor_is_kept_with_the_render(finished, tmp_path):
    drive = np.linspace(0.0, 1.0, 5)
    light = np.stack([drive**1.8, drive**2.0, drive**2.4], axis=1)
    monitor = Display("lab CRT", display("srgb").to_tristimulus, "table", drive, light)
    path = tmp_path / "render.npz"
    save_render(path, finished, Development(monitor))
    opened, development = open_render(path)
    expected, _ = Development(monitor).picture(finished.tristimulus(), finished.observer)
    assert np.array_equal(development.picture(opened.tristimulus(), opened.observer)[0], expected)
    assert development.shown.name == "lab CRT"


def test_a_file_that_is_no_render_is_named(finished, tmp_path):
    text = tmp_path / "text.npz"
    text.write_text("no archive")
    with pytest.raises(DichromaticError, match="cannot be read as a render"):
        open_render(text)
    foreign = tmp_path / "foreign.npz"
    np.savez(foreign, a=np.ones(3))
    with pytest.raises(DichromaticError, match="no render of this program"):
        open_render(foreign)
    later = tmp_path / "later.npz"
    header = json.dumps({"format": "dichromatic-render", "version": 99})
    np.savez(later, header=np.frombuffer(header.encode(), np.uint8))
    with pytest.raises(DichromaticError, match="version 99"):
        open_render(later)
    with pytest.raises(InvalidParameterError, match=r"ends in \.npz"):
        save_render(tmp_path / "render.exr", finished)
    with pytest.raises(DichromaticError, match="cannot be written"):
        save_render(tmp_path / "missing" / "render.npz", finished)


def metameric_pair():
    """Two reflectances that match under E and part under narrow lamps: a black in the CIE sense is added to one."""
    sees = observer("cie_1931_2")
    wavelengths, functions = sees.wavelengths_nm, sees.matching_functions
    wave = 0.25 * np.sin(wavelengths / 17.0)
    black = wave - functions @ np.linalg.lstsq(functions, wave, rcond=None)[0]
    return Spectrum(wavelengths, np.full(len(wavelengths), 0.5)), Spectrum(wavelengths, 0.5 + black)


@pytest.mark.parametrize(
    ("name", "spoil", "reason"),
    [
        ("pixels_0", lambda a: a + 10_000, "pixels of block 0"),
        ("pixels_0", lambda a: a[::-1], "pixels of block 0"),
        ("coefficients_0", lambda a: a[:, :1], "block 0 must have a row a pixel and a column a term"),
        ("coverage", lambda a: a[1:], "coverage must have"),
        ("spectrum_0", lambda a: a[0], "damaged"),
        ("spectrum_0", lambda a: -a, "damaged"),
    ],
)
def test_arrays_that_do_not_fit_are_told_when_the_file_is_opened(finished, tmp_path, name, spoil, reason):
    path = tmp_path / "render.npz"
    save_render(path, finished)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **{**arrays, name: spoil(arrays[name])})
    with pytest.raises(DichromaticError, match=rf"render.npz.*{reason}"):
        open_render(path)


def test_no_flipped_bit_ends_in_anything_but_a_named_error(finished, tmp_path):
    path = tmp_path / "render.npz"
    save_render(path, finished)
    whole = path.read_bytes()
    generator = np.random.default_rng(7)
    refused = 0
    for _ in range(120):
        spoilt = bytearray(whole)
        spoilt[generator.integers(len(spoilt))] ^= 1 << int(generator.integers(8))
        path.write_bytes(spoilt)
        try:
            open_render(path)[0].tristimulus()
        except DichromaticError:
            refused += 1
    assert refused > 60  # most bytes are compressed arrays, which carry a checksum


def test_other_things_than_renders_are_named(tmp_path):
    single = tmp_path / "single.npz"
    with single.open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(DichromaticError, match="single array"):
        open_render(single)
    listed = tmp_path / "listed.npz"
    np.savez(listed, header=np.frombuffer(b"[1, 2]", np.uint8))
    with pytest.raises(DichromaticError, match="no render of this program"):
        open_render(listed)


@pytest.mark.parametrize("width_nm", [0.01, 0.3, 3.0])
def test_lines_narrower_than_the_samples_keep_their_light_in_spectra(width_nm):
    lamp = gaussian(589.3, width_nm)
    camera = look_at((0.3, -0.5, 3.0), (0.0, 0.0, 0.0), 0.2, 0.2)
    scene = Scene([placed(floor())], [TypeI(Spectrum.constant(0.5), 0.0)], [SunLight((0, 0, 1), 3.0, lamp)], camera)
    seen = render(scene, RenderSettings(2, 2, samples=1, precision="float64"))
    xyz = seen.tristimulus()[0, 0]
    np.testing.assert_allclose(probe_pixel(seen, 0, 0).tristimulus.sum(axis=0), xyz, rtol=FLOAT32_ROUNDING)
    # On steps of 5 nm the line is averaged: its power is there in full, wherever it falls between the samples.
    wavelengths = np.arange(400.0, 701.0, 5.0)
    power = 5.0 * radiance_image(seen, wavelengths)[0, 0].sum()
    fine = np.arange(360.0, 831.0)
    expected = radiance_image(seen, fine)[0, 0].sum()
    np.testing.assert_allclose(power, expected, rtol=10 * FLOAT32_ROUNDING)


def test_lamps_of_one_name_are_told_apart():
    lamps = [SunLight((0, 0, 1), strength, illuminant("D65"), name="Lamp") for strength in (1.0, 3.0)]
    camera = look_at((0.3, -0.5, 3.0), (0.0, 0.0, 0.0), 0.2, 0.2)
    scene = Scene([placed(floor())], [TypeI(Spectrum.constant(0.5), 0.0)], lamps, camera)
    seen = render(scene, RenderSettings(2, 2, samples=1, precision="float64"))
    probe = probe_pixel(seen, 0, 0)
    shares = dict(zip([label.partition(" x ")[0] for label in probe.labels], probe.tristimulus[:, 1], strict=True))
    assert set(shares) == {"Lamp (1 of 2)", "Lamp (2 of 2)"}
    assert shares["Lamp (2 of 2)"] == pytest.approx(3.0 * shares["Lamp (1 of 2)"])
    named = probe_pixel(seen, 0, 0, emitter_names=["Left", "Right", "World"])
    assert {label.partition(" x ")[0] for label in named.labels} == {"Left", "Right"}
    with pytest.raises(InvalidParameterError, match="each of the 3 emitters, but holds 1"):
        probe_pixel(seen, 0, 0, emitter_names=["Left"])


def test_a_light_that_was_dark_cannot_be_turned_on_unseen():
    lit = still_life()
    dark = replace(lit, lights=[replace(lit.lights[0], strength=0.0), *lit.lights[1:]])
    finished = render(dark, SETTINGS)
    name = lit.lights[0].name
    with pytest.raises(InvalidParameterError, match=f"holds no light of '{name}'"):
        finished.relit(finished.spectra.with_light(name, strength=5.0))
    # Dimmed after the rays were traced, it can.
    traced = render(lit, SETTINGS)
    dimmed = traced.relit(traced.spectra.with_light(name, strength=0.0))
    again = dimmed.relit(dimmed.spectra.with_light(name, strength=lit.lights[0].strength))
    assert np.array_equal(again.tristimulus(), traced.tristimulus())


@pytest.mark.parametrize("strength", [-1.0, 1e31, float("nan"), [1.0, 2.0], "bright"])
def test_strengths_that_no_light_has_are_named(finished, strength):
    with pytest.raises(InvalidParameterError, match="strength of light 'Sun'"):
        SunLight((0, 0, 1), strength, illuminant("D65"))
    with pytest.raises(InvalidParameterError, match="strength of world 'World'"):
        World(strength=strength)
    name = finished.spectra.emitters[0].name
    with pytest.raises(InvalidParameterError, match=f"strength of light '{name}'"):
        finished.spectra.with_light(name, strength=strength)


def test_the_strongest_light_stays_finite(finished):
    name = finished.spectra.emitters[0].name
    bright = finished.relit(finished.spectra.with_light(name, strength=1e30))
    assert np.isfinite(bright.tristimulus()).all()


def test_exposure_has_a_range():
    with pytest.raises(InvalidParameterError, match="exposure must lie between -100 and 100 stops"):
        Development(exposure=5000.0)


def test_negative_spectra_make_no_lamp_and_no_paint(finished):
    signed = Spectrum([400.0, 700.0], [-0.1, 1.0], "difference", signed=True)
    with pytest.raises(InvalidParameterError, match="illuminant of light 'Sun' must not be negative, but at 400 nm"):
        SunLight((0, 0, 1), 1.0, signed)
    with pytest.raises(InvalidParameterError, match="body_reflectance must not be negative"):
        TypeI(signed)
    with pytest.raises(InvalidParameterError, match="interface_reflectance must not be negative"):
        TypeII(Spectrum.constant(0.5), signed)
    name = finished.spectra.emitters[0].name
    with pytest.raises(InvalidParameterError, match=f"illuminant of light '{name}'"):
        finished.spectra.with_light(name, illuminant=signed)
    slot = finished.spectra.slots[0]
    with pytest.raises(InvalidParameterError, match="must not be negative"):
        finished.spectra.with_reflectance(slot.material, slot.component, signed)


def test_metamers_part_only_under_the_other_lamp():
    first, second = metameric_pair()
    halves = [placed(floor(3.0, 0), (-3.0, 0.0, 0.0)), placed(floor(3.0, 1), (3.0, 0.0, 0.0))]
    sun = SunLight((0.0, 0.0, 1.0), np.pi, illuminant("E"), "lamp")
    camera = look_at((0.0, -0.1, 10.0), (0.0, 0.0, 0.0), 0.3, 0.2)
    scene = Scene(halves, [TypeI(s, 0.0) for s in (first, second)], [sun], camera)
    made = render(scene, RenderSettings(8, 4, samples=1, pixel_filter="box", precision="float64"))
    image = made.tristimulus()
    np.testing.assert_allclose(image[:, 0], image[:, -1], rtol=1e-12)  # rounding of 471 products
    found = metamerism_map(made, illuminant("E"), illuminant("FL11"))
    assert found.delta_e[:, 0].max() < 0.5  # a flat grey stays grey under any lamp once adapted
    assert found.delta_e[:, -1].min() > 3.0
    assert "between E and FL11: mean" in found.describe()
    picture = found.picture(largest=found.delta_e.max())
    assert picture.shape == (4, 8, 3)
    assert picture[0, 0].sum() < picture[0, -1].sum()


def test_contact_sheet_holds_each_lamps_picture(finished):
    lamps = [illuminant(name) for name in ("D65", "A", "FL11")]
    sheet = contact_sheet(finished, lamps, columns=2, gap=3)
    assert sheet.picture.shape == (2 * 22 + 3, 2 * 32 + 3, 3)
    expected, _ = Development().picture(relit_by(finished, lamps[2]).tristimulus(), finished.observer)
    assert np.array_equal(sheet.picture[25:, :32], expected)
    assert sheet.names == ("D65", "A", "FL11")
    adapted = contact_sheet(finished, lamps, columns=3, adapt=True)
    warm = sheet.picture[:22, 35:].mean(axis=(0, 1))
    neutral = adapted.picture[:, 40:72].mean(axis=(0, 1))
    assert warm[0] / warm[2] > 1.5 * neutral[0] / neutral[2]
    with pytest.raises(InvalidParameterError, match="at least one lamp"):
        contact_sheet(finished, [])


def test_radiance_sums_to_the_tristimulus_values(finished):
    sees = observer(finished.observer)
    spectra = radiance_image(finished, sees.wavelengths_nm)
    expected = finished.tristimulus()
    # 471 float32 values a pixel are summed in float32
    np.testing.assert_allclose(spectra @ sees.matching_functions, expected, rtol=10 * FLOAT32_ROUNDING, atol=1e-7)
    with pytest.raises(MemoryLimitError, match=r"more than the 0\.0 GiB allowed"):
        radiance_image(finished, sees.wavelengths_nm, memory_limit=1000)


def test_spectral_exr_is_read_back_by_colour_science(finished, tmp_path):
    pytest.importorskip("OpenImageIO")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # colour-science warns of optional packages when it is imported
        colour = pytest.importorskip("colour")
    path = tmp_path / "picture.exr"
    write_spectral_exr(path, finished)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        components = colour.read_spectral_image_Fichet2021(str(path))
    wavelengths, values = components["S0"]
    np.testing.assert_allclose(wavelengths, np.arange(400.0, 701.0, 5.0))
    expected = radiance_image(finished, np.arange(400.0, 701.0, 5.0))
    assert np.array_equal(np.asarray(values, np.float32), expected)


def test_channel_names_follow_the_layout():
    assert channel_name(555.0) == "S0.555,000000nm"
    assert channel_name(400.25) == "S0.400,250000nm"
