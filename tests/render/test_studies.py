"""Lamp studies, kept renders and spectral pictures, from one small render."""

import json
import warnings

import numpy as np
import pytest

from spectral_core.colorimetry import observer
from spectral_core.development import Development
from spectral_core.display import Display, display
from spectral_core.errors import DichromaticError, InvalidParameterError, MemoryLimitError
from spectral_core.library import illuminant
from spectral_core.lights import SunLight
from spectral_core.reflection.materials import TypeI
from spectral_core.render_file import open_render, save_render
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene
from spectral_core.spectra import Spectrum
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
