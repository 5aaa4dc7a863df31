"""Textured surfaces: against the brute-force sum in every pixel, and through everything that happens to a film."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_core.errors import InvalidParameterError
from spectral_core.library import illuminant, optical_constants, reflectance
from spectral_core.light_groups import LIGHT_COMPONENTS, LightPart, split_light
from spectral_core.lights import AreaLight, EnvironmentImage, PointLight, SunLight
from spectral_core.plan import make_plan
from spectral_core.probe import probe_pixel
from spectral_core.recolouring import differ_in_spectra_only
from spectral_core.reflection.energy import energy_warnings
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.render_file import open_render, save_render
from spectral_core.renderer import render
from spectral_core.rgb_uplift import uplift
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.scene_spectra import SceneSpectra
from spectral_core.spectra import Spectrum
from spectral_core.texture_mixing import mixture, uplift_texture
from spectral_core.textures import ImageTexture
from spectral_core.tracing.mesh import Instance, Mesh
from spectral_core.tracing.sampling import pixel_offsets
from tests.render import brute_force
from tests.render.render_scenes import SHEEN, look_at
from tests.tolerances import FILM_AGAINST_BRUTE_FORCE, FLOAT32_ROUNDING, FLOAT64_ROUNDING

WIDTH, HEIGHT = 36, 24
RNG = np.random.default_rng(11)
PICTURE = ImageTexture(RNG.random((5, 6, 3)), "mirror", "linear", [(2.1, 0.3, 0.1), (-0.2, 1.7, 0.4)], name="noise")
MASK = ImageTexture(RNG.random((4, 4, 1)), "clip", "closest", name="mask")
COPPER = optical_constants("copper")
SETTINGS = RenderSettings(WIDTH, HEIGHT, samples=2, precision="float64", seed=3)


def quad(corners, material, uv=((0, 0), (1, 0), (1, 1), (0, 1)), matrix=None):
    triangles = np.array([(0, 1, 2), (0, 2, 3)])
    coordinates = None if uv is None else np.array(uv, float)[triangles]
    mesh = Mesh(np.array(corners, float), triangles, uv=coordinates, material_index=np.full(2, material))
    return Instance(mesh, np.eye(4) if matrix is None else np.array(matrix, float))


FLOOR = ((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0))
WALL = ((-2, 1.5, 0), (2, 1.5, 0), (2, 1.5, 2.5), (-2, 1.5, 2.5))
SKEWED = ((-1.9, -1.9, 0.4), (-0.4, -1.9, 0.2), (-0.2, -0.4, 0.6), (-1.5, -0.6, 0.5))
TURNED = [(-1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]  # x mirrored: the winding is turned with it


def gallery(body=None, mirror=0.7):
    """A floor of coloured noise, a copper mirror that shows it, and a masked cloth, placed by a mirroring matrix."""
    tiles = uplift_texture(PICTURE)
    cloth = TypeII(
        mixture(reflectance("red"), tiles, 0.3), mixture(SHEEN, reflectance("blue"), MASK), "gaussian", n=9.0
    )
    return Scene(
        instances=[quad(FLOOR, 0), quad(WALL, 1, None), quad(SKEWED, 2, ((0, 0), (1.4, 0), (1, 1), (0, 0.8)), TURNED)],
        materials=[
            TypeI(body or tiles, 0.5, "cosine", 9.0),
            TypeIII.from_optical_constants(COPPER, beta=0.3, mirror=mirror),
            cloth,
        ],
        lights=[
            PointLight((1.0, -2.5, 3.0), 300.0, illuminant("FL11"), "key"),
            SunLight((-0.5, -0.7, 1.0), 1.0, illuminant("A"), "sun"),
        ],
        camera=look_at((0.3, -5.0, 2.4), (0.0, 0.0, 0.7), 0.5, 0.34),
        world=World(illuminant("D50"), 0.1),
        material_names=("floor", "mirror", "cloth"),
    )


def test_image_equals_the_spectral_sum_in_every_pixel():
    scene = gallery()
    got = render(scene, replace(SETTINGS, max_bounces=1)).tristimulus()
    offsets = pixel_offsets(2, SETTINGS.pixel_filter, SETTINGS.filter_width, 3)
    expected = brute_force.image(scene, WIDTH, HEIGHT, SETTINGS.observer, offsets, (None, COPPER, None), bounces=1)
    assert np.ptp(expected[..., 0] / np.maximum(expected[..., 1], 1e-9)) > 0.3  # the picture is a coloured one
    np.testing.assert_allclose(got, expected, rtol=FILM_AGAINST_BRUTE_FORCE)


def test_light_at_nodes_reads_textures_too():
    scene = gallery()
    exact = render(scene, replace(SETTINGS, max_bounces=1)).tristimulus()
    nodes = replace(SETTINGS, max_bounces=1, bounce_spectra="nodes", bounce_grid="exact")
    np.testing.assert_allclose(render(scene, nodes).tristimulus(), exact, rtol=1e-6)  # colour is kept in float32


def test_a_constant_picture_looks_like_its_uplifted_colour():
    colour = np.array([0.7, 0.2, 0.05], np.float32)
    flat = uplift_texture(ImageTexture(np.tile(colour, (2, 2, 1))))
    textured, plain = (render(gallery(body, 0.0), SETTINGS).tristimulus() for body in (flat, uplift(colour)))
    np.testing.assert_allclose(textured, plain, rtol=1e-10)


def test_lamps_with_a_size_the_world_and_mirrors_take_a_picture_for_its_colour():
    colour = np.array([0.7, 0.2, 0.05], np.float32)
    flat = uplift_texture(ImageTexture(np.tile(colour, (2, 2, 1))))
    sky = EnvironmentImage(RNG.random((4, 8, 3)))

    def picture(body):
        made = gallery()
        lamp = AreaLight((1.0, -2.0, 3.0), (0.5, 0, 0), (0, 0.3, 0), 200.0, illuminant("FL11"), name="softbox")
        floor = TypeI(body, 0.5, "cosine", 9.0, mirror=0.3, energy_conserving=True)
        world = World(illuminant("D50"), 0.6, lights_surfaces=True, image=sky)
        return replace(made, materials=[floor, *made.materials[1:]], lights=[lamp], world=world)

    settings = replace(SETTINGS, samples=4, max_bounces=2)
    textured, plain = (render(picture(body), settings) for body in (flat, uplift(colour)))
    np.testing.assert_allclose(textured.tristimulus(), plain.tristimulus(), rtol=1e-9)
    for part in LIGHT_COMPONENTS:
        pictures = [split_light(made, [LightPart(part)])[0] for made in (textured, plain)]
        np.testing.assert_allclose(*pictures, rtol=1e-9, atol=1e-12)


def test_float32_reads_the_same_picture():
    single = render(gallery(), replace(SETTINGS, precision="float32")).tristimulus()
    double = render(gallery(), SETTINGS).tristimulus()
    # Coordinates in float32 move within a picture whose values change by about 10 over a unit of u.
    np.testing.assert_allclose(single, double, rtol=2e-4, atol=1e-5)


def test_a_surface_without_coordinates_shows_the_colour_at_the_origin():
    scene = gallery(mirror=0.0)
    bare = replace(scene, instances=[quad(FLOOR, 0, None)])
    at_origin = uplift(brute_force.read_picture(PICTURE, (0.0, 0.0)))
    plain = replace(bare, materials=[TypeI(at_origin, 0.5, "cosine", 9.0), *scene.materials[1:]])
    np.testing.assert_allclose(render(bare, SETTINGS).tristimulus(), render(plain, SETTINGS).tristimulus(), rtol=1e-10)


def test_energy_conserving_form_reflects_no_more_with_a_picture():
    rays = RNG.normal(size=(2, 50, 3))
    light, viewer = rays / np.linalg.norm(rays, axis=2, keepdims=True)
    light[:, 2], viewer[:, 2] = np.abs(light[:, 2]), np.abs(viewer[:, 2])
    bright = uplift_texture(ImageTexture(3.0 * PICTURE.pixels))
    textured = TypeI(bright, 1.0, energy_conserving=True)
    normal, uv = np.array([0.0, 0.0, 1.0]), RNG.random((50, 2))
    body = textured.radiance_factor(normal, light, viewer, [550.0], uv=uv)
    bound = textured.untextured().radiance_factor(normal, light, viewer, [550.0])
    assert (body <= bound * (1 + FLOAT32_ROUNDING)).all()
    assert not energy_warnings(textured)
    assert any("body reflectance" in text for text in energy_warnings(TypeI(bright, 0.0)))


def test_relit_picture_is_a_fresh_render():
    kept = render(gallery(), SETTINGS)
    lamps = kept.spectra.with_light("key", illuminant=illuminant("D65")).with_light("sun", strength=2.0)
    fresh = gallery()
    fresh = replace(
        fresh, lights=[replace(fresh.lights[0], illuminant=illuminant("D65")), replace(fresh.lights[1], strength=2.0)]
    )
    np.testing.assert_allclose(
        kept.relit(lamps).tristimulus(), render(fresh, SETTINGS).tristimulus(), rtol=FLOAT64_ROUNDING * 100
    )


def test_an_ink_of_a_picture_can_be_exchanged():
    kept = render(gallery(mirror=0.0), SETTINGS)
    gold = Spectrum(np.array([400.0, 700.0]), np.array([0.1, 0.8]), name="gold")
    relit = kept.relit(kept.spectra.with_reflectance("floor", "body red", gold))
    printed = uplift_texture(PICTURE)
    fresh = gallery(replace(printed, spectra=(gold, *printed.spectra[1:])), mirror=0.0)
    np.testing.assert_allclose(relit.tristimulus(), render(fresh, SETTINGS).tristimulus(), rtol=FLOAT64_ROUNDING * 100)


def test_only_another_ink_leaves_what_was_traced_as_it_is():
    def scene(**changes):
        made = gallery()
        cloth = made.materials[2]
        interface = replace(cloth.interface_reflectance, **changes)
        return replace(made, materials=[*made.materials[:2], replace(cloth, interface_reflectance=interface)])

    again = mixture(SHEEN, reflectance("blue"), MASK)  # equal, but of arrays of its own
    for changes, is_same in (
        ({"amounts": again.amounts, "base": again.base}, True),
        ({"spectra": (SHEEN, reflectance("green"))}, True),
        ({"amounts": (0.5 * again.amounts[0],)}, False),
        ({"base": np.array([0.5, 0.0])}, False),
        ({"textures": (replace(MASK, extension="repeat"),)}, False),
    ):
        assert differ_in_spectra_only(gallery(), scene(**changes), SETTINGS, SETTINGS) is is_same, changes


def test_exchanging_the_whole_of_a_picture_says_what_there_is_instead():
    spectra = SceneSpectra.from_scene(gallery())
    with pytest.raises(InvalidParameterError, match="body of material 'floor' is a texture that mixes 'body red', 'bo"):
        spectra.with_reflectance("floor", "body", SHEEN)
    with pytest.raises(InvalidParameterError, match="no material 'floor' has a varnish reflectance"):
        spectra.with_reflectance("floor", "varnish", SHEEN)


def test_probe_and_file_know_the_parts_by_name(tmp_path):
    kept = render(gallery(mirror=0.0), SETTINGS)
    labels = probe_pixel(kept, WIDTH // 2, HEIGHT - 6).labels
    assert {"key x floor body red", "key x floor body green", "sun x floor body blue"} <= set(labels)
    save_render(tmp_path / "kept.npz", kept)
    opened, _ = open_render(tmp_path / "kept.npz")
    np.testing.assert_array_equal(opened.tristimulus(), kept.tristimulus())


def test_the_plan_names_what_is_read_and_what_is_not():
    text = make_plan(gallery(), SETTINGS).describe()
    assert "+ texture coordinates: 'floor' reads 'noise' (6 x 5); 'cloth' reads 'mask' (4 x 4);" in text
    plain = replace(gallery(), materials=[TypeI(SHEEN)] * 3)
    assert "- texture coordinates: no visible material has a texture" in make_plan(plain, SETTINGS).describe()


def test_a_textured_interface_does_not_mirror():
    with pytest.raises(InvalidParameterError, match="mirror must be 0 where the interface reflectance is a texture"):
        TypeII(SHEEN, uplift_texture(PICTURE), mirror=0.5)


def test_coefficients_of_a_textured_material_need_coordinates():
    material = TypeI(uplift_texture(PICTURE))
    up = np.array([0.0, 0.0, 1.0])
    with pytest.raises(InvalidParameterError, match="uv must be given"):
        material.coefficients(up, up, up)
    assert material.coefficients(up, up, up, uv=[(0.2, 0.3)]).shape == (1, 4)
