"""Lamps with a size, the sky and glowing surfaces as light: against closed forms."""

import gc
import math
import weakref
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.display import display
from spectral_core.errors import InvalidParameterError
from spectral_core.library import illuminant
from spectral_core.lights import (
    AreaLight,
    EmittingMesh,
    EnvironmentImage,
    EnvironmentLight,
    PointLight,
    SpotLight,
    SunLight,
    environment,
)
from spectral_core.lights.base import ball_point
from spectral_core.reflection.materials import TypeI
from spectral_core.renderer import render
from spectral_core.scene import Emission, RenderSettings, Scene, World
from spectral_core.spectra import Spectrum
from spectral_core.tracing.camera import Camera
from spectral_core.tracing.geometry import Geometry
from spectral_core.tracing.mesh import Instance, Mesh
from spectral_core.tracing.sampling import sobol_points, square_points
from spectral_core.tracing.solids import Solids
from tests.render.render_scenes import ball, floor, placed
from tests.tolerances import STRATIFIED_SKY

WHITE = illuminant("D65")
MATTE = TypeI(Spectrum.constant(0.5, "grey"), 0.0, "cosine", 1.0)
ORIGIN = np.zeros(3)
UP = np.array([0.0, 0.0, 1.0])


def cube_points(count):
    """Evenly spread points of the unit cube."""
    planar = square_points(count, 1)
    return np.column_stack([planar, (np.arange(count) * 0.8191725133961645 + 0.3) % 1.0])


def irradiance(light, point, normal=UP, count=4096):
    """Mean over the lamp's points of what a surface receives, without any shadow."""
    total = 0.0
    for u in cube_points(count):
        lit = light.illuminate(np.array([point], float), ORIGIN, light.lamp_point(u, ORIGIN))
        total += lit.irradiance[0] * max(float(lit.to_light[0] @ normal), 0.0)
    return total / count


# Lattices of so many points leave an error of about 1 / count in smooth integrands, and about count ** -3/4 where the
# integrand has an edge.
SMOOTH_LATTICE = 4e-3


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_points_of_a_ball_cast_an_even_disk_on_every_plane(seed):
    rng = np.random.default_rng(seed)
    axis, looking = rng.normal(size=(2, 3))
    axis, looking = axis / np.linalg.norm(axis), looking / np.linalg.norm(looking)
    points = np.array([ball_point(u, axis) for u in rng.random((4000, 3))])
    assert np.linalg.norm(points, axis=1).max() <= 1.0 + 1e-12
    across = points - np.outer(points @ looking, looking)
    radius_squared = np.sort(np.sum(across**2, axis=1))
    # Evenly on a disk, the squared radius is uniform: Kolmogorov's distance of 4000 draws is below 0.04 but once in
    # 400 000 trials.
    assert np.abs(radius_squared - (np.arange(4000) + 0.5) / 4000).max() < 0.04


@pytest.mark.parametrize("radius", [1e-3, 0.5, 2.0])
def test_a_sphere_gives_what_a_point_in_its_middle_does(radius):
    light = PointLight((1.0, -2.0, 3.0), 7.0, WHITE, radius=radius)
    offset = light.position
    distance = np.linalg.norm(offset)
    # Howell's catalogue B-38: the whole sphere above the horizon.
    expected = offset[2] / distance / (4.0 * math.pi * distance**2)
    assert irradiance(light, ORIGIN) == pytest.approx(expected, rel=SMOOTH_LATTICE)


def test_a_rectangle_gives_what_its_configuration_factor_says():
    # Howell's catalogue B-3: an element below the corner of a parallel rectangle a x b at the height c.
    a, b, c = 1.5, 0.8, 1.1
    x, y = a / c, b / c
    corner = (
        x / math.sqrt(1 + x * x) * math.atan(y / math.sqrt(1 + x * x))
        + y / math.sqrt(1 + y * y) * math.atan(x / math.sqrt(1 + y * y))
    ) / (2.0 * math.pi)
    light = AreaLight((a / 2, b / 2, c), (a / 2, 0, 0), (0, b / 2, 0), 1.0, WHITE)
    expected = corner / (a * b)  # of one watt: radiance 1 / (pi A), irradiance pi times the factor times it
    assert light.direction == pytest.approx([0, 0, -1])
    assert irradiance(light, ORIGIN) == pytest.approx(expected, rel=SMOOTH_LATTICE)
    assert irradiance(light, (0, 0, 2 * c), -UP) == 0.0


def test_an_ellipse_that_is_a_disk_gives_what_a_disk_does():
    r, h = 0.7, 1.3
    light = AreaLight((0, 0, h), (r, 0, 0), (0, r, 0), 1.0, WHITE, shape="ellipse")
    expected = (r * r / (r * r + h * h)) / (math.pi * r * r)  # Howell's catalogue B-12
    assert irradiance(light, ORIGIN) == pytest.approx(expected, rel=SMOOTH_LATTICE)


@pytest.mark.parametrize("degrees", [2.0, 40.0, 120.0, 179.0])
def test_a_narrower_spread_keeps_the_power(degrees):
    light = AreaLight((0, 0, 0), (1e-3, 0, 0), (0, 1e-3, 0), 1.0, WHITE, spread=math.radians(degrees))
    edge = 0.5 * math.radians(degrees)
    angle = (np.arange(20_000) + 0.5) / 20_000 * edge
    points = 100.0 * np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    lit = light.illuminate(points, ORIGIN)
    power = np.sum(lit.irradiance * 2.0 * math.pi * np.sin(angle)) * (edge / 20_000) * 100.0**2
    assert power == pytest.approx(1.0, rel=1e-3)  # midpoint rule, and the leading term of tan x - x below 1e-3 rad
    beyond = light.illuminate(100.0 * np.array([[math.sin(edge + 0.01), 0.0, -math.cos(edge + 0.01)]]), ORIGIN)
    assert beyond.irradiance[0] == 0.0 or degrees == 179.0


@pytest.mark.parametrize("degrees", [0.5, 30.0, 120.0])
def test_a_large_sun_shines_as_strongly_as_its_middle(degrees):
    light = SunLight((0.3, 0.2, 1.0), 1.0, WHITE, angle=math.radians(degrees))
    tilted = light.to_light
    assert irradiance(light, ORIGIN, tilted) == pytest.approx(1.0, rel=SMOOTH_LATTICE)


def test_an_even_sky_gives_pi():
    assert irradiance(EnvironmentLight(), ORIGIN) == pytest.approx(math.pi, rel=SMOOTH_LATTICE)


def test_a_picture_of_the_sky_gives_what_its_pixels_do():
    rng = np.random.default_rng(4)
    pixels = rng.random((16, 32, 3)).astype(np.float32) ** 4 * 10.0
    angle = 0.4
    turn = np.array([[math.cos(angle), 0, math.sin(angle)], [0, 1, 0], [-math.sin(angle), 0, math.cos(angle)]])
    image = EnvironmentImage(pixels, turn)
    light = EnvironmentLight(image)
    total, count = np.zeros(3), 20_000
    for u in cube_points(count):
        at = light.lamp_point(u, ORIGIN)
        lit = light.illuminate(np.zeros((1, 3)), ORIGIN, at)
        total += lit.irradiance[0] * max(float(lit.to_light[0] @ UP), 0.0) * np.array(at.weights)
    # The plain sum over directions, at the middles of a fine grid.
    z = (np.arange(400) + 0.5) / 400
    around = (np.arange(800) + 0.5) / 800 * 2.0 * math.pi
    flat = np.sqrt(1 - z**2)
    directions = np.stack(
        [np.outer(flat, np.cos(around)), np.outer(flat, np.sin(around)), np.outer(z, np.ones(800))], axis=-1
    )
    seen = image.radiance(directions.reshape(-1, 3)).reshape(400, 800, 3)
    expected = 2.0 * math.pi * np.mean(seen * z[:, None, None], axis=(0, 1))
    np.testing.assert_allclose(total / count, expected, rtol=0.01)  # the latitude within a pixel is not drawn by


@pytest.mark.parametrize("row", [0, 1, 8, 15])
def test_few_points_find_all_of_a_sun_in_a_picture(row):
    """The light of one bright pixel reaches into its neighbours, half of it; seen by few points of each sample."""
    pixels = np.full((16, 32, 3), 0.01, np.float32)
    pixels[row, 31] = 1.0e5
    image = EnvironmentImage(pixels)
    light = EnvironmentLight(image)
    shares = (np.arange(600) + 0.5) / 600
    latitude = math.pi * (0.5 - (row + 2.0 * (2.0 * shares - 1.0) + 0.5) / 16)
    latitude = latitude[np.abs(latitude) < 0.5 * math.pi]
    longitude = 2.0 * math.pi * (0.5 - (31 + 2.0 * (2.0 * shares - 1.0) + 0.5) / 32)
    up = np.sin(latitude)[:, None] * np.ones(600)
    across = np.cos(latitude)[:, None] * np.ones(600)
    directions = np.stack([across * np.cos(longitude), across * np.sin(longitude), up], axis=-1)
    seen = image.radiance(directions.reshape(-1, 3))[:, 0].reshape(up.shape)
    step = (4.0 * math.pi / 16 / 600) * (8.0 * math.pi / 32 / 600)
    normal = UP if row < 8 else -UP
    expected = float(np.sum(seen * across * np.abs(up) * (up * normal[2] > 0.0))) * step
    points = sobol_points(np.arange(64), np.array([1, 2, 3], np.uint32))
    found = 0.0
    for u in points:
        at = light.lamp_point(u, ORIGIN)
        found += at.factor * at.weights[0] * max(float(at.to_light @ normal), 0.0) / len(points)
    assert found == pytest.approx(expected, rel=0.05)  # 64 points; the rest of the sky is a millionth


def test_what_is_known_of_a_picture_is_found_once_and_forgotten_with_it():
    pixels = np.random.default_rng(0).random((16, 32, 3)).astype(np.float32)
    image = EnvironmentImage(pixels)
    kept = image.pixels.copy()
    pixels[:] = 0.0  # of the caller, who may do so
    assert np.array_equal(image.pixels, kept)
    with pytest.raises(ValueError, match="read-only"):
        image.pixels[0] = 1.0
    turned = replace(image, rotation=np.diag([-1.0, -1.0, 1.0]))
    assert turned.pixels is image.pixels
    first, second = EnvironmentLight(image), EnvironmentLight(turned)
    assert second._columns is first._columns
    before = len(environment._known)
    gone = weakref.ref(image.pixels)
    del image, turned, first, second
    gc.collect()
    assert gone() is None
    assert len(environment._known) == before - 1


def test_an_environment_cannot_be_stretched():
    with pytest.raises(InvalidParameterError, match="environment rotation must have perpendicular rows"):
        EnvironmentImage(np.ones((2, 4, 3)), np.diag([1.0, 1.0, 2.0]))


def test_where_a_picture_is_looked_up_is_where_blender_has_it():
    pixels = np.zeros((2, 4, 3), np.float32)
    pixels[0, 1] = 1.0, 2.0, 3.0
    image = EnvironmentImage(pixels)
    longitude, latitude = 2 * math.pi * (0.5 - 1.5 / 4), math.pi * (0.5 - 0.5 / 2)
    direction = [
        math.cos(latitude) * math.cos(longitude),
        math.cos(latitude) * math.sin(longitude),
        math.sin(latitude),
    ]
    np.testing.assert_allclose(image.radiance(np.array([direction])), [[1.0, 2.0, 3.0]], rtol=1e-5)


def glowing(instances):
    """All triangles of some instances as a lamp."""
    geometry = Geometry.from_instances(instances, np.float64)
    return EmittingMesh(geometry, Solids.of(geometry), np.arange(geometry.triangle_count), "glow")


def test_a_glowing_ball_gives_what_its_size_in_the_sky_says():
    shape = ball(4)
    light = glowing([Instance(Mesh(shape.vertices, shape.triangles), _at((0.0, 0.0, 3.0)))])
    assert light.area == pytest.approx(4.0 * math.pi, rel=0.01)  # its facets'; the outer side alone
    # pi L (r / d)^2, of a sphere whose facets lie a little within it: their area tells how much.
    shrunk = light.area / (4.0 * math.pi)
    assert irradiance(light, ORIGIN) == pytest.approx(math.pi / 9.0 * shrunk, rel=2e-2)


def test_each_closed_mesh_shines_outwards_whichever_way_it_is_wound():
    plain = ball(2)
    turned = Mesh(plain.vertices, plain.triangles[:, ::-1])
    light = glowing([placed(plain, (5.0, 0.0, 0.0), 2.0), placed(turned, (-5.0, 0.0, 0.0))])
    for u in cube_points(64):
        at = light.lamp_point(u, ORIGIN)
        middle = np.array([5.0 if at.position[0] > 0.0 else -5.0, 0.0, 0.0])
        assert at.normal @ (at.position - middle) > 0.5


def test_both_sides_of_an_open_surface_glow():
    light = glowing([Instance(floor(0.5), _at((0.0, 0.0, 2.0)))])
    assert light.area == pytest.approx(2.0)
    above, below = irradiance(light, (0, 0, 4.0), -UP), irradiance(light, (0, 0, 0.0), UP)
    assert above == pytest.approx(below, rel=0.02)
    x = 0.5 / 2.0
    factor = 4.0 * 2.0 * x / math.sqrt(1 + x * x) * math.atan(x / math.sqrt(1 + x * x)) / (2.0 * math.pi)
    assert below == pytest.approx(math.pi * factor, rel=0.02)  # half of 4096 points on either side


def test_an_open_surface_beside_a_closed_one_glows_on_both_sides():
    """Each part is taken for itself: the sheet's lower side is not lost, the ball's inner one not asked for."""
    sheet, lamp = Instance(floor(0.5), _at((0.0, 0.0, 2.0))), placed(ball(3), (9.0, 0.0, 2.0))
    alone = glowing([sheet]).area + glowing([lamp]).area
    assert glowing([sheet, lamp]).area == pytest.approx(alone)


@pytest.mark.parametrize("turn", [1, -1])
def test_a_glowing_dome_lights_what_stands_in_it(turn):
    """As an even sky of its radiance, by its inner side, whichever way it is wound."""
    shape = ball(4)
    glow = np.ones(len(shape.triangles), np.int64)
    dome = Instance(Mesh(shape.vertices * 50.0, shape.triangles[:, ::turn], material_index=glow))
    ground = Instance(floor(1.0))
    camera = Camera(_at((0.0, 0.0, 5.0)), (-0.1, 0.1, -0.1, 0.1), kind="orthographic")
    white = TypeI(Spectrum.constant(1.0, "white"), 0.0, "cosine", 1.0)
    scene = Scene([ground, dome], [white, white], [], camera, emissions=[None, Emission(WHITE, 1.0)])
    seen = render(scene, RenderSettings(2, 2, samples=512)).tristimulus()[..., 1].mean()
    assert seen == pytest.approx(1.0, rel=STRATIFIED_SKY)


def _at(place):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


# ---- pictures


def looking_down(half_width, height=10.0):
    """A camera above the floor that sees a square of so half a width."""
    matrix = np.eye(4)
    matrix[:3, 3] = 0.0, 0.0, height
    return Camera(matrix, (-half_width, half_width, -half_width, half_width), "orthographic", 0.01, 100.0)


def edge_scene(light, **extra):
    """A floor under a half plane x < 0 at the height 1, which the camera does not see."""
    curtain = Mesh(np.array([(-20.0, -20, 1), (0, -20, 1), (0, 20, 1), (-20, 20, 1)]), np.array([(0, 1, 2), (0, 2, 3)]))
    return Scene(
        [Instance(floor(8.0)), Instance(curtain, camera_visible=False)],
        [MATTE],
        [light],
        looking_down(1.0),
        **extra,
    )


def test_the_penumbra_of_a_sun_is_the_part_of_its_disk_that_is_seen():
    light = SunLight((0.0, 0.0, 1.0), math.pi, WHITE, angle=math.radians(40.0))
    size = 64
    result = render(edge_scene(light), RenderSettings(size, size, samples=64, filter_width=1e-3))
    x = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    # Seen from x, the curtain's edge cuts the disk of radius tan 20 deg at -x / 1.
    t = np.clip(x / math.tan(math.radians(20.0)), -1.0, 1.0)
    part = 0.5 + (t * np.sqrt(1 - t * t) + np.arcsin(t)) / math.pi
    seen = result.tristimulus()[..., 1].reshape(size // 2, 2, size).mean(axis=(0, 1)) / 0.5
    # An edge through a lattice of 256 points (64 samples, 2 x 2 sub-pictures): count ** -3/4.
    np.testing.assert_allclose(seen, part, atol=256**-0.75)
    assert seen[0] == 0.0
    assert result.statistics.plan.count("soft shadows") == 1


@pytest.mark.parametrize("kind", ["sphere", "area", "spot", "world", "image", "emission"])
def test_lamps_with_a_size_light_a_floor_as_their_closed_form_says(kind):
    extra = {}
    lights = []
    instances = [Instance(floor(40.0))]
    materials, emissions = [MATTE], ()
    if kind == "sphere":
        lights = [PointLight((0, 0, 5.0), 100.0, WHITE, radius=1.0)]
        expected = 100.0 / (4 * math.pi * 25.0) / math.pi
    elif kind == "spot":
        lights = [SpotLight((0, 0, 5.0), (0, 0, -1), 100.0, WHITE, math.radians(90), 0.1, radius=0.5)]
        expected = 100.0 / (4 * math.pi * 25.0) / math.pi
    elif kind == "area":
        lights = [AreaLight((0, 0, 5.0), (1, 0, 0), (0, 1, 0), 100.0, WHITE, "ellipse")]
        expected = 100.0 / (math.pi * 26.0) / math.pi
    elif kind in ("world", "image"):
        image = EnvironmentImage(np.full((4, 8, 3), 1.0)) if kind == "image" else None
        extra["world"] = World(WHITE, 0.7, lights_surfaces=True, image=image)
        expected = 0.7
    else:
        lamp = ball(3)
        instances.append(
            Instance(
                Mesh(lamp.vertices, lamp.triangles, material_index=np.full(len(lamp.triangles), 1)),
                _at((0, 0, 5.0)),
                camera_visible=False,
            )
        )
        materials, emissions = [MATTE, MATTE], (None, Emission(WHITE, 40.0))
        expected = 40.0 / 25.0
    scene = Scene(instances, materials, lights, looking_down(0.05), emissions=emissions, **extra)
    result = render(scene, RenderSettings(16, 16, samples=256 if kind == "emission" else 16))
    y = result.tristimulus()[..., 1]
    # 64 points of a lamp, 256 of the sky, 1024 of the ball, of which half face away; its facets are 1 % smaller.
    tolerance = {"emission": 0.04, "world": 0.03, "image": 0.03}.get(kind, 0.02)
    assert y.mean() == pytest.approx(0.5 * expected, rel=tolerance)


def test_a_glowing_surface_is_seen_in_its_own_colour():
    red = illuminant("HP1")
    scene = Scene([Instance(floor(8.0))], [MATTE], [], looking_down(1.0), emissions=[Emission(red, 3.0, "glow")])
    result = render(scene, RenderSettings(8, 8, samples=1))
    expected = render(Scene((), (), (), looking_down(1.0), World(red, 3.0)), RenderSettings(8, 8, samples=1))
    np.testing.assert_allclose(result.tristimulus(), expected.tristimulus(), rtol=1e-6)
    relit = result.relit(result.spectra.with_light("glow", strength=1.0)).tristimulus()
    np.testing.assert_allclose(relit, result.tristimulus() / 3.0, rtol=1e-6)


def test_a_picture_behind_the_scene_is_seen_in_its_colours():
    pixels = np.broadcast_to(np.array([0.8, 0.3, 0.1], np.float32), (4, 8, 3))
    scene = Scene((), (), (), looking_down(1.0), World(WHITE, 2.0, image=EnvironmentImage(pixels)))
    colour = render(scene, RenderSettings(4, 4, samples=1)).tristimulus()[0, 0]
    np.testing.assert_allclose(
        colour @ display("srgb").from_tristimulus.T, [1.6, 0.6, 0.2], rtol=3e-4
    )  # D65 to 4 places


def test_only_its_receivers_see_a_light_and_one_without_shadows_shines_through():
    one, other = placed(floor(0.4), (-0.5, 0, 0)), placed(floor(0.4), (0.5, 0, 0))
    roof = Instance(floor(9.0), _at((0, 0, 2.0)), camera_visible=False)
    lamp = {"to_light": (0, 0, 1.0), "strength": math.pi, "illuminant": WHITE}

    def brightness(**options):
        scene = Scene([one, other, roof], [MATTE], [SunLight(**lamp, **options)], looking_down(1.0))
        y = render(scene, RenderSettings(8, 8, samples=1)).tristimulus()[..., 1]
        return y[4, 2], y[4, 5]

    assert brightness() == (0.0, 0.0)
    assert brightness(casts_shadow=False) == pytest.approx((0.5, 0.5))
    assert brightness(casts_shadow=False, receivers=frozenset({1})) == pytest.approx((0.0, 0.5))


@pytest.mark.parametrize(
    "lamp",
    [
        SunLight((0, 0, 1.0), math.pi, WHITE),
        SunLight((0, 0, 1.0), math.pi, WHITE, angle=0.05),
        PointLight((0, 0, 500.0), 4.0 * math.pi**2 * 500.0**2, WHITE),
        AreaLight((0, 0, 500.0), (0.5, 0, 0), (0, 0.5, 0), math.pi**2 * 500.0**2, WHITE),
    ],
    ids=lambda lamp: f"{lamp.name} {lamp.is_extended}",
)
@pytest.mark.parametrize(("blockers", "lit"), [(None, (0, 0)), ({2}, (0, 1)), ({0, 1, 3}, (1, 0)), (set(), (1, 1))])
def test_only_its_blockers_hide_a_light(lamp, blockers, lit):
    """Lamps without a size look at so many triangles themselves; for those with one rays are cast."""
    planes = [placed(floor(0.4), (x, 0, 0)) for x in (-0.5, 0.5)]
    roofs = [Instance(ball(1), _at((x, 0, 1.5)), camera_visible=False) for x in (-0.7, 0.7)]
    lamp = replace(lamp, blockers=None if blockers is None else frozenset(blockers))
    scene = Scene([*planes, *roofs], [MATTE], [lamp], looking_down(1.0))
    y = render(scene, RenderSettings(8, 8, samples=1)).tristimulus()[..., 1]
    assert (y[4, 2] / 0.5, y[4, 5] / 0.5) == pytest.approx(lit, abs=2e-3)  # the lamps' size and distance


def test_what_no_lamp_can_be_is_named():
    with pytest.raises(InvalidParameterError, match="axis_x and axis_y of light 'Area' must span an area"):
        AreaLight((0, 0, 0), (1, 0, 0), (2, 0, 0), 1.0, WHITE)
    for what in ("receivers", "blockers"):
        for numbers in ({1, 2}, frozenset({-1}), frozenset({"Roof"})):
            with pytest.raises(InvalidParameterError, match=f"{what} of light 'Sun' must be a frozenset of numbers"):
                SunLight((0, 0, 1), 1.0, WHITE, **{what: numbers})
    with pytest.raises(InvalidParameterError, match="shape of light 'Area'"):
        AreaLight((0, 0, 0), (1, 0, 0), (0, 2, 0), 1.0, WHITE, shape="star")
    with pytest.raises(InvalidParameterError, match=r"shape \(H, W, 3\)"):
        EnvironmentImage(np.zeros((3, 3)))
    with pytest.raises(InvalidParameterError, match="finite and at least 0"):
        EnvironmentImage(np.full((3, 3, 3), -1.0))


def test_points_near_a_lamp_and_within_it_receive_finite_light():
    light = PointLight((0, 0, 0), 1.0, WHITE, radius=0.5)
    points = np.array([(0, 0, 0), (0, 0, 0.1), (0.5, 0, 0), (1e-30, 0, 0)], np.float32)
    for u in cube_points(16):
        lit = light.illuminate(points, ORIGIN, light.lamp_point(u, ORIGIN))
        assert np.isfinite(lit.irradiance).all()
        assert lit.irradiance.max() < 1.0 / (4 * math.pi) / 0.25 * 2.001  # twice what its rim receives


def test_doubles_and_singles_agree_on_lamps():
    light = AreaLight((0.3, 0.1, 2.0), (0.5, 0.1, 0), (0, 0.4, 0.2), 5.0, WHITE, spread=2.0)
    points = np.random.default_rng(0).normal(size=(100, 3))
    at = light.lamp_point(np.array([0.2, 0.7, 0.5]), ORIGIN)
    fine, coarse = (light.illuminate(points.astype(t), ORIGIN, at).irradiance for t in (np.float64, np.float32))
    np.testing.assert_allclose(coarse, fine, rtol=1e-4, atol=1e-6)  # single rounding, where the cosine is small
    assert fine.max() > 0.1


def test_a_world_that_the_camera_does_not_see_still_lights():
    world = World(WHITE, 1.0, lights_surfaces=True, camera_visible=False)
    scene = Scene([Instance(floor(0.5))], [MATTE], [], looking_down(1.0), world)
    y = render(scene, RenderSettings(16, 16, samples=4, filter_width=1e-3)).tristimulus()[..., 1]
    assert y[0, 0] == 0.0
    assert y[4:12, 4:12].mean() == pytest.approx(0.5, rel=0.05)  # 256 directions, a cosine
