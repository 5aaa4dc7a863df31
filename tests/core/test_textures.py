"""Textures against closed forms: linear ramps, the laws of repetition, and the bounds of reflectances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spectral_core.errors import InvalidParameterError
from spectral_core.rgb_uplift import uplift, uplift_values
from spectral_core.spectra import Spectrum
from spectral_core.texture_mixing import filtered, mixture, uplift_texture
from spectral_core.textured_reflectance import require_plain
from spectral_core.textures import EXTENSIONS, INTERPOLATIONS, ImageTexture
from tests.render.brute_force import read_picture
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING

WAVELENGTHS = np.arange(360.0, 831.0)
RNG = np.random.default_rng(5)
NOISE = RNG.random((4, 7, 3)).astype(np.float32)
OCHRE = Spectrum(np.array([400.0, 600.0, 700.0]), np.array([0.1, 0.5, 0.6]), name="ochre")
SLATE = Spectrum(np.array([400.0, 550.0, 700.0]), np.array([0.3, 0.2, 0.1]), name="slate")


def ramp(width, height):
    """A picture whose red is u and green v at the pixels' centres: both are linear functions."""
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    return np.stack([np.tile(u, (height, 1)), np.tile(v[:, None], (1, width)), np.zeros((height, width))], axis=-1)


def test_bilinear_reading_of_a_linear_picture_is_the_function_itself():
    texture = ImageTexture(ramp(8, 5), extension="extend")
    inside = 0.5 / 5 + RNG.random((200, 2)) * (1 - 1 / 5)
    np.testing.assert_allclose(texture.sample(inside)[:, :2], inside, atol=FLOAT32_ROUNDING)


def test_the_first_row_is_the_bottom():
    pixels = np.zeros((2, 2, 1))
    pixels[0, 1] = 1.0
    texture = ImageTexture(pixels, interpolation="closest")
    np.testing.assert_array_equal(texture.sample([(0.75, 0.25), (0.25, 0.25), (0.75, 0.75)])[:, 0], [1.0, 0.0, 0.0])


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_every_extension_reads_as_one_pixel_after_the_other(extension, interpolation):
    texture = ImageTexture(NOISE, extension, interpolation, [(1.3, -0.4, 0.2), (0.5, 2.0, -0.7)])
    uv = RNG.uniform(-2.5, 3.5, (500, 2))
    expected = np.array([read_picture(texture, at) for at in uv])
    np.testing.assert_allclose(texture.sample(uv), expected, rtol=0, atol=FLOAT64_ROUNDING * 10)


@given(st.integers(-(10**6), 10**6), st.integers(-(10**6), 10**6))
def test_repetition_has_the_period_of_the_picture_and_mirroring_twice_that(columns, rows):
    uv = np.array([(0.3125, 0.71875)])  # exact in binary, so that adding whole numbers loses nothing
    for extension, period in (("repeat", 1), ("mirror", 2)):
        texture = ImageTexture(NOISE, extension)
        moved = texture.sample(uv + period * np.array([columns, rows]))
        np.testing.assert_array_equal(moved, texture.sample(uv))
    turned = ImageTexture(NOISE, "mirror")
    np.testing.assert_allclose(turned.sample(-uv), turned.sample(uv), atol=FLOAT64_ROUNDING)


def test_extend_holds_the_edge_and_clip_shows_nothing():
    far = np.array([(-7.0, 0.5), (1e12, 0.5), (0.5, -3.0), (-1e300, 1e300)])
    held = ImageTexture(NOISE, "extend").sample(far)
    left, right = 0.5 * (NOISE[1, 0] + NOISE[2, 0]), 0.5 * (NOISE[1, -1] + NOISE[2, -1])
    np.testing.assert_allclose(held, [left, right, NOISE[0, 3], NOISE[-1, 0]], rtol=FLOAT32_ROUNDING)
    np.testing.assert_array_equal(ImageTexture(NOISE, "clip").sample(far), 0.0)


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 9, 1), (4, 7, 3)])
def test_extremes_of_coordinates_transforms_and_sizes_give_pixels_of_the_picture(extension, shape):
    pixels = 0.25 + 0.5 * RNG.random(shape)
    ends = [0.0, -0.0, 1.0, 1e-320, -1e-320, 0.5, np.nextafter(1.0, 0.0), -1e16, 3e38, 1.7e308, -1.7e308]
    uv = np.array([(u, v) for u in ends for v in ends])
    low = 0.0 if extension == "clip" else pixels.min()
    for interpolation in INTERPOLATIONS:
        for scale in (1.0, 1e6, 1e-300, 0.0):
            texture = ImageTexture(pixels, extension, interpolation, [(scale, -scale, 1e6), (scale, scale, -1e6)])
            values = texture.sample(uv)
            assert values.min() >= low * (1 - FLOAT32_ROUNDING)
            assert values.max() <= pixels.max() * (1 + FLOAT32_ROUNDING)


def test_precision_follows_the_coordinates():
    texture = ImageTexture(NOISE)
    assert texture.sample(np.zeros((2, 2), np.float32)).dtype == np.float32
    assert texture.sample(np.zeros((0, 2))).shape == (0, 3)


def test_a_constant_picture_is_the_uplifted_spectrum():
    colour = np.array([0.62, 0.11, 0.03], np.float32)
    textured = uplift_texture(ImageTexture(np.tile(colour, (3, 5, 1)), name="flat"))
    got = textured.at(RNG.uniform(-2, 2, (9, 2)), WAVELENGTHS)
    np.testing.assert_allclose(got, np.tile(uplift(colour).at(WAVELENGTHS), (9, 1)), rtol=1e-12)
    np.testing.assert_allclose(textured.average().at(WAVELENGTHS), got[0], rtol=1e-12)
    np.testing.assert_allclose(textured.brightest.at(WAVELENGTHS), got[0], rtol=FLOAT32_ROUNDING)


@given(st.integers(0, 2**32 - 1), st.sampled_from(EXTENSIONS), st.sampled_from(INTERPOLATIONS))
def test_colours_between_0_and_1_give_reflectances_between_0_and_1(seed, extension, interpolation):
    rng = np.random.default_rng(seed)
    pixels = rng.integers(0, 2, (3, 4, 3)).astype(np.float32)  # the corners of the cube of colours
    textured = uplift_texture(ImageTexture(pixels, extension, interpolation))
    values = textured.at(rng.uniform(-3, 3, (64, 2)), WAVELENGTHS)
    assert values.min() >= 0.0
    assert values.max() <= 1.0 + FLOAT64_ROUNDING
    assert (values <= textured.brightest.at(WAVELENGTHS) * (1 + FLOAT64_ROUNDING)).all()


def test_brightest_is_no_looser_than_the_picture_demands():
    red_and_blue = np.array([[(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]])
    bound = uplift_texture(ImageTexture(red_and_blue)).brightest.at(WAVELENGTHS)
    np.testing.assert_allclose(bound, uplift_values([1.0, 0.0, 1.0]).clip(max=1.0), rtol=0.05)
    mask = ImageTexture(np.linspace(0.0, 1.0, 16).reshape(4, 4, 1))
    assert mixture(OCHRE, SLATE, mask).brightest.values.max() == pytest.approx(0.6, rel=1e-5)


def test_a_mask_mixes_two_spectra_at_every_wavelength():
    mask = ImageTexture(NOISE[..., :1], "clip", name="mask")
    uv = RNG.uniform(-0.3, 1.3, (50, 2))
    share = mask.sample(uv)
    mixed = mixture(OCHRE, SLATE, mask)
    assert mixed.part_names == ("ochre", "slate")
    expected = (1 - share) * OCHRE.at(WAVELENGTHS) + share * SLATE.at(WAVELENGTHS)
    np.testing.assert_allclose(mixed.at(uv, WAVELENGTHS), expected, rtol=1e-12)


def test_an_even_mixture_with_a_picture_reads_each_picture_once():
    picture = uplift_texture(ImageTexture(NOISE, name="noise"))
    other = uplift_texture(ImageTexture(NOISE[::-1], name="turned"))
    uv = RNG.random((40, 2))
    mixed = mixture(mixture(picture, OCHRE, 0.25), mixture(picture, other, 0.5), 0.4)
    assert len(mixed.textures) == 2
    assert mixed.part_names == ("red", "green", "blue", "ochre")
    first = 0.75 * picture.at(uv, WAVELENGTHS) + 0.25 * OCHRE.at(WAVELENGTHS)
    second = 0.5 * (picture.at(uv, WAVELENGTHS) + other.at(uv, WAVELENGTHS))
    np.testing.assert_allclose(mixed.at(uv, WAVELENGTHS), 0.6 * first + 0.4 * second, rtol=1e-12)


def test_a_filter_multiplies_every_pixel():
    picture = uplift_texture(ImageTexture(NOISE))
    uv = RNG.random((40, 2))
    expected = picture.at(uv, WAVELENGTHS) * OCHRE.at(WAVELENGTHS)
    np.testing.assert_allclose(filtered(picture, OCHRE).at(uv, WAVELENGTHS), expected, rtol=1e-12)
    np.testing.assert_allclose(picture.scaled(0.3).at(uv, WAVELENGTHS), 0.3 * picture.at(uv, WAVELENGTHS), rtol=1e-12)


def test_equal_content_is_equal_and_hashes_alike():
    one, same = ImageTexture(NOISE, name="a"), ImageTexture(NOISE.copy(), name="b")
    assert one == same
    assert hash(one) == hash(same)
    assert one != ImageTexture(NOISE, "clip")
    assert uplift_texture(one) == uplift_texture(same)
    assert uplift_texture(one) != uplift_texture(one).scaled(0.5)


def test_pixels_cannot_be_changed_behind_the_key():
    pixels = NOISE.copy()
    texture = ImageTexture(pixels)
    pixels[:] = 0.0
    assert texture.pixels.max() > 0.0
    with pytest.raises(ValueError, match="read-only"):
        texture.pixels[0] = 1.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((0, 3, 3)),), "shape"),
        ((np.zeros((3, 3)),), "shape"),
        ((np.full((1, 1, 3), np.nan),), "finite"),
        ((np.full((1, 1, 3), -0.1),), "between -0.1"),
        ((np.full((1, 1, 3), 1e7),), "0 to 1e"),
        ((NOISE, "tile"), "extension"),
        ((NOISE, "repeat", "cubic"), "interpolation"),
        ((NOISE, "repeat", "linear", np.eye(3)), "transform"),
        ((NOISE, "repeat", "linear", np.full((2, 3), np.inf)), "transform"),
    ],
)
def test_bad_textures_are_refused_by_name(arguments, message):
    with pytest.raises(InvalidParameterError, match=message):
        ImageTexture(*arguments)


def test_bad_reflectances_are_refused_by_name():
    picture = uplift_texture(ImageTexture(NOISE, name="noise"))
    mask = ImageTexture(NOISE[..., :1], name="mask")
    with pytest.raises(InvalidParameterError, match="3 channels"):
        uplift_texture(mask)
    with pytest.raises(InvalidParameterError, match="1 channel, but has 3"):
        mixture(OCHRE, SLATE, ImageTexture(NOISE))
    with pytest.raises(InvalidParameterError, match="two plain spectra"):
        mixture(OCHRE, picture, mask)
    with pytest.raises(InvalidParameterError, match="mask"):
        mixture(OCHRE, SLATE, ImageTexture(2 * np.ones((1, 1, 1)), name="mask"))
    with pytest.raises(InvalidParameterError, match="share"):
        mixture(OCHRE, SLATE, 1.5)
    with pytest.raises(InvalidParameterError, match="uv must be finite"):
        picture.weights([(0.0, np.nan)])
    with pytest.raises(InvalidParameterError, match=r"interface.*'noise'"):
        require_plain("interface", picture)
    assert require_plain("interface", OCHRE) is OCHRE
