"""Mirror bounces: closed forms, the limit between terms and nodes, and mirrors against the paper's equations."""

import math

import numpy as np
import pytest

from spectral_core.colorimetry import observer
from spectral_core.errors import InvalidParameterError
from spectral_core.library import illuminant, optical_constants, reflectance
from spectral_core.lights import SunLight
from spectral_core.plan import make_plan
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.scene_spectra import SceneSpectra, Term
from spectral_core.spectra import Spectrum
from spectral_core.tracing.mesh import Instance, Mesh
from tests.render.render_scenes import ball, floor, look_at, placed, still_life
from tests.tolerances import FILM_AGAINST_BRUTE_FORCE, FLOAT64_ROUNDING, STANDARD_GRID_COLOUR

WAVELENGTHS = np.arange(360.0, 831.0)
GOLD = optical_constants("gold")


def gold_mirror(beta=0.0, mirror=1.0):
    return TypeIII.from_optical_constants(GOLD, beta=beta, mirror=mirror)


def wall(x, facing, material):
    """A large square in the plane x, whose front faces +x or -x."""
    y = 50.0
    corners = np.array([(x, -y, -y), (x, y, -y), (x, y, y), (x, -y, y)])
    if facing < 0:
        corners = corners[::-1]
    return Instance(Mesh(corners, np.array([(0, 1, 2), (0, 2, 3)]), material_index=np.full(2, material), name="wall"))


def fresnel(cosine, constants, wavelengths):
    n = np.interp(wavelengths, constants.wavelengths_nm, constants.n)
    k = np.interp(wavelengths, constants.wavelengths_nm, constants.k)
    index = n + 1j * k
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    rs = (cosine - index * inner) / (cosine + index * inner)
    rp = (index * cosine - inner) / (index * cosine + inner)
    return 0.5 * (abs(rs) ** 2 + abs(rp) ** 2)


def eq_13(cosine, constants):
    band = np.arange(400.0, 701.0, 5.0)
    here, normal = (fresnel(c, constants, band).mean() for c in (cosine, 1.0))
    wavelengths = np.union1d(constants.wavelengths_nm, np.arange(380.0, 781.0, 5.0))
    normal_spectrum = np.interp(WAVELENGTHS, wavelengths, fresnel(1.0, constants, wavelengths))
    return (1.0 - here) / (1.0 - normal) * normal_spectrum + (here - normal) / (1.0 - normal)


def colour(spectrum, lamp="D65"):
    functions = observer("cie_1931_2").matching_functions
    power = illuminant(lamp).at(WAVELENGTHS)
    return (spectrum * power) @ functions / (power @ functions[:, 1])


@pytest.mark.parametrize("bounces", [1, 2, 3, 6])
@pytest.mark.parametrize("spectra", ["terms", "nodes"])
def test_two_facing_mirrors_of_gold_show_the_world_by_the_power_of_their_reflectance(bounces, spectra):
    """A ray between facing mirrors leaves past an edge after `bounces` of them and finds a uniform world."""
    slope = 0.45  # towards the open top
    gap = 1.0
    rise = gap / math.tan(slope)  # per crossing... the ray climbs this much from wall to wall
    top = rise * (bounces - 0.5) + 0.5 * rise
    mirrors = []
    for x, facing in ((0.5 * gap, -1), (-0.5 * gap, 1)):
        corners = np.array([(x, -50.0, -50.0), (x, 50.0, -50.0), (x, 50.0, top), (x, -50.0, top)])
        corners = corners[::-1] if facing < 0 else corners
        mirrors.append(Instance(Mesh(corners, np.array([(0, 1, 2), (0, 2, 3)]), name="mirror")))
    direction = np.array([math.sin(slope), 0.0, math.cos(slope)])
    camera = look_at((0.0, 0.0, 0.0), direction, 1e-6, 1e-6)
    world = World(illuminant("D65"), 1.0)
    settings = RenderSettings(
        1, 1, samples=1, precision="float64", max_bounces=8, bounce_spectra=spectra, bounce_grid="exact"
    )
    result = render(Scene(mirrors, [gold_mirror()], [], camera, world), settings)
    assert result.statistics.mirror_rays == bounces
    expected = colour(eq_13(math.sin(slope), GOLD) ** bounces)
    np.testing.assert_allclose(result.tristimulus()[0, 0], expected, rtol=FILM_AGAINST_BRUTE_FORCE)
    assert result.film.is_relightable == (spectra == "terms")


def test_metal_ball_in_a_uniform_world_shows_eq_13_at_every_angle():
    """In a uniform world a mirror ball's radiance factor is Eq. 13 at the angle of view, over the whole disc."""
    size = 64
    camera = look_at((0.0, -40.0, 0.0), (0.0, 0.0, 0.0), 1.0, 1.0, kind="orthographic")
    scene = Scene([placed(ball(5))], [gold_mirror()], [], camera, World(illuminant("D65"), 1.0))
    got = render(scene, RenderSettings(size, size, samples=1, precision="float64")).tristimulus()
    centre = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    radius = np.hypot(centre[:, None], centre[None, :])
    inside = radius < 0.95  # beyond it the facets' outline and their self-reflection differ from the sphere's
    expected = np.array([colour(eq_13(math.sqrt(1.0 - r * r), GOLD)) for r in radius[inside]])
    # the mesh's normals are 1e-3 rad off at most at this subdivision, to which Eq. 13 is less than proportional
    np.testing.assert_allclose(got[inside], expected, rtol=2e-3)
    mean = got[inside].mean(axis=0) / expected.mean(axis=0)
    np.testing.assert_allclose(mean, 1.0, rtol=1e-4)


def mirrored_still_life(max_bounces=3):
    scene = still_life()
    plastic, cloth, _ = scene.materials
    shiny = TypeI(plastic.body_reflectance, 0.7, "cosine", 60.0, mirror=0.2)
    metal = TypeIII.from_optical_constants(optical_constants("copper"), beta=0.2, mirror=0.8)
    return Scene(scene.instances, [shiny, cloth, metal], scene.lights, scene.camera, scene.world, scene.material_names)


def test_terms_and_exact_nodes_agree():
    """Mirrored light as products of spectra equals the same light carried at every nanometre."""
    scene = mirrored_still_life()
    settings = {"width": 36, "height": 24, "samples": 2, "precision": "float64"}
    terms = render(scene, RenderSettings(**settings, bounce_spectra="terms"))
    nodes = render(scene, RenderSettings(**settings, bounce_spectra="nodes", bounce_grid="exact"))
    assert terms.statistics.mirror_rays == nodes.statistics.mirror_rays > 500
    # the film's fixed colour is float32
    np.testing.assert_allclose(nodes.tristimulus(), terms.tristimulus(), rtol=1e-6)
    standard = render(scene, RenderSettings(**settings, bounce_spectra="nodes", bounce_grid="standard"))
    difference = np.abs(standard.tristimulus() - terms.tristimulus()).max()
    assert 0.0 < difference < STANDARD_GRID_COLOUR


def test_auto_keeps_terms_up_to_the_limit_and_says_so():
    scene = mirrored_still_life()
    small = {"width": 16, "height": 12, "samples": 1, "precision": "float64"}
    exact = render(scene, RenderSettings(**small, term_limit=10_000))
    assert exact.film.is_relightable
    assert "up to 4 deep, kept exactly as products of spectra" in exact.statistics.plan
    longest = max(len(block.terms) for block in exact.film.blocks)
    limited = render(scene, RenderSettings(**small, term_limit=longest // 2, bounce_grid="exact"))
    assert not limited.film.is_relightable
    assert "deeper paths are carried on the 'exact' grid" in limited.statistics.plan
    assert max(len(block.terms) for block in limited.film.blocks) <= longest // 2
    np.testing.assert_allclose(limited.tristimulus(), exact.tristimulus(), rtol=1e-6)


def test_the_limit_holds_where_only_the_world_shines():
    panes = [placed(Mesh(np.eye(3) + 3.0 * i, np.array([(0, 1, 2)]), material_index=np.array([i]))) for i in range(4)]
    metals = [
        TypeIII.from_normal_reflectance(Spectrum([400.0, 700.0], [0.1 * i, 0.9]), 0.1, mirror=1.0) for i in range(4)
    ]
    settings = RenderSettings(max_bounces=12, term_limit=16)
    plan = make_plan(Scene(panes, metals, world=World(strength=1.0)), settings)
    # Bounces off four metals, of two terms each, give 2^depth products of spectra.
    assert plan.exact_depth == 4


def test_relighting_reaches_into_mirrors():
    scene = mirrored_still_life()
    settings = RenderSettings(36, 24, samples=1, precision="float64")
    first = render(scene, settings)
    silver = TypeIII.from_optical_constants(optical_constants("silver"), beta=0.2).reflectances[0]
    spectra = first.spectra.with_light("key", illuminant=illuminant("A")).with_reflectance("copper", "normal", silver)
    relit = first.relit(spectra).tristimulus()
    metal = scene.materials[2]
    changed = TypeIII(silver, metal.mean_reflectance, metal.beta, mirror=metal.mirror)
    key = scene.lights[0]
    lights = [type(key)(key.position, key.strength, illuminant("A"), key.name), *scene.lights[1:]]
    fresh = render(
        Scene(
            scene.instances, [*scene.materials[:2], changed], lights, scene.camera, scene.world, scene.material_names
        ),
        settings,
    ).tristimulus()
    np.testing.assert_allclose(relit, fresh, rtol=10 * FLOAT64_ROUNDING)
    assert np.abs(relit - first.tristimulus()).max() > 0.01


def test_a_mirroring_cloth_is_relit_like_a_fresh_one():
    """What a cloth mirrors with is its interface scaled to its peak: relighting must scale the new one alike."""
    scene = mirrored_still_life()
    plastic, cloth, metal = scene.materials
    strong = Spectrum(np.array([400.0, 700.0]), np.array([2.4, 0.8]), name="strong")
    settings = RenderSettings(36, 24, samples=1, precision="float64")

    def with_cloth(interface):
        changed = TypeII(cloth.body_reflectance, interface, cloth.attenuation, cloth.n, mirror=0.6)
        materials = [plastic, changed, metal]
        return Scene(scene.instances, materials, scene.lights, scene.camera, scene.world, scene.material_names)

    first = render(with_cloth(cloth.interface_reflectance), settings)
    relit = first.relit(first.spectra.with_reflectance("cloth", "interface", strong)).tristimulus()
    np.testing.assert_allclose(relit, render(with_cloth(strong), settings).tristimulus(), rtol=10 * FLOAT64_ROUNDING)
    with pytest.raises(InvalidParameterError, match="no material 'cloth' has a mirror reflectance"):
        first.spectra.with_reflectance("cloth", "mirror", strong)


def test_a_mirroring_plastic_is_relit_like_a_fresh_one():
    """A neutral interface mirrors neutrally, however strong it is."""
    scene = mirrored_still_life()
    plastic, cloth, metal = scene.materials
    settings = RenderSettings(36, 24, samples=1, precision="float64")
    first = render(scene, settings)
    relit = first.relit(first.spectra.with_reflectance("plastic", "interface", Spectrum.constant(3.0))).tristimulus()
    changed = TypeI(plastic.body_reflectance, 3.0, plastic.attenuation, plastic.n, mirror=plastic.mirror)
    fresh = Scene(
        scene.instances, [changed, cloth, metal], scene.lights, scene.camera, scene.world, scene.material_names
    )
    np.testing.assert_allclose(relit, render(fresh, settings).tristimulus(), rtol=10 * FLOAT64_ROUNDING)


def test_the_plan_counts_the_terms_that_mirrors_multiply():
    scene = mirrored_still_life(max_bounces=1)
    settings = RenderSettings(8, 6, samples=1, max_bounces=1)
    plan = make_plan(scene, settings)
    copper = next(i for i, s in enumerate(SceneSpectra.from_scene(scene).slots) if s.component == "normal")
    assert plan.monomials == ((), (copper,))  # the plastic mirrors neutrally
    direct = set(plan.direct_terms)
    longer = {Term(t.emitter, tuple(sorted((*t.slots, copper)))) for t in direct}
    assert set(plan.terms) == direct | longer
    assert set(render(scene, settings).film.terms) <= set(plan.terms)


def test_without_mirrors_or_bounces_no_mirror_ray_is_traced():
    plain = render(still_life(), RenderSettings(16, 12, samples=1))
    assert plain.statistics.mirror_rays == 0
    assert "- mirror bounces: no visible material mirrors the scene" in plain.statistics.plan
    stopped = render(mirrored_still_life(), RenderSettings(16, 12, samples=1, max_bounces=0))
    assert stopped.statistics.mirror_rays == 0
    assert "- mirror bounces: the settings allow none" in stopped.statistics.plan


def test_a_plane_mirror_shows_the_mirror_image():
    """A perfect neutral mirror on the floor shows a ball exactly as a second ball below the floor would look."""
    neutral = TypeI(reflectance("black 2"), 1.0, "cosine", 1e8, mirror=1.0)
    matte = TypeI(reflectance("red"), 0.0, "cosine", 1.0)
    sun = SunLight((0.0, 0.0, 1.0), 3.0, illuminant("D65"), "sun")
    camera = look_at((0.0, -6.0, 4.0), (0.0, 0.0, -0.5), 0.3, 0.2)
    upper = placed(ball(3, 1), (0.0, 0.0, 2.0))
    settings = RenderSettings(40, 28, samples=1, precision="float64")
    got = render(Scene([upper, placed(floor(30.0, 0))], [neutral, matte], [sun], camera), settings)
    # the same seen from below the floor: mirror the camera instead of the world
    flip = np.diag([1.0, 1.0, -1.0, 1.0])
    from spectral_core.tracing.camera import Camera

    below = Camera(flip @ camera.matrix, camera.window, camera.kind, camera.clip_start, camera.clip_end)
    direct = render(Scene([upper], [neutral, matte], [sun], below), settings)
    mirrored = (
        got.tristimulus()
        - render(
            Scene(
                [upper, placed(floor(30.0, 0))],
                [TypeI(reflectance("black 2"), 1.0, "cosine", 1e8), matte],
                [sun],
                camera,
            ),
            settings,
        ).tristimulus()
    )
    seen = (direct.alpha > 0) & (render(Scene([upper], [neutral, matte], [sun], camera), settings).alpha == 0)
    assert seen.sum() > 50
    np.testing.assert_allclose(mirrored[seen], direct.tristimulus()[seen], rtol=1e-7, atol=1e-9)
