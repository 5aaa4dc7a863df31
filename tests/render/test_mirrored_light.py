"""The world in mirrors and as light at once: nothing of it is shown twice; and lamps that turn to what they light."""

import math

import numpy as np
import pytest

from spectral_core.library import illuminant
from spectral_core.lights import PointLight, SpotLight
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.reflection.mirror import unmirrored_scales
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from spectral_core.spectra import Spectrum
from spectral_core.tracing.camera import Camera
from spectral_core.tracing.mesh import Instance
from tests.render.render_scenes import floor
from tests.tolerances import STRATIFIED_SKY

WHITE = illuminant("D65")
BODY = Spectrum.constant(0.3, "grey")


def from_above(material, samples=256, lights=(), world=None, **options):
    """Luminance of a floor seen along its normal by an orthographic camera."""
    matrix = np.eye(4)
    matrix[2, 3] = 5.0
    camera = Camera(matrix, (-0.05, 0.05, -0.05, 0.05), kind="orthographic")
    scene = Scene([Instance(floor(100.0))], [material], lights, camera, world or World())
    return float(render(scene, RenderSettings(4, 4, samples=samples, **options)).tristimulus()[..., 1].mean())


def sky(**options):
    return World(WHITE, 1.0, lights_surfaces=True, **options)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_a_metal_shows_an_even_sky_once(share):
    """All of what a lossless lobe and its mirror return of a sky of radiance 1 is the reflectance."""
    metal = TypeIII.from_normal_reflectance(BODY, 0.15, energy_conserving=True, mirror=share)
    assert from_above(metal, 256, world=sky()) == pytest.approx(0.3, rel=STRATIFIED_SKY)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_plastic_shows_an_even_sky_once(share):
    """The lobe cos(rho)^n returns 2 S_I / (n + 1) to a viewer on the normal, of which the mirror takes its part."""
    n, albedo = 30.0, 0.2
    plastic = TypeI(BODY, albedo * (n + 1.0) / 2.0, "cosine", n, mirror=share * albedo)
    assert from_above(plastic, 256, world=sky()) == pytest.approx(0.5, rel=STRATIFIED_SKY)


def test_without_bounces_there_is_no_mirror_to_leave_light_to():
    metal = TypeIII.from_normal_reflectance(BODY, 0.15, energy_conserving=True, mirror=1.0)
    assert from_above(metal, 256, world=sky(), max_bounces=0) == pytest.approx(0.3, rel=STRATIFIED_SKY)


def test_lamps_are_in_no_mirror():
    """So the lobe shows all of them."""
    lamp = [PointLight((0.0, 0.0, 3.0), 100.0, WHITE)]
    plain, mirroring = (TypeI(BODY, 2.0, "cosine", 30.0, mirror=mirror) for mirror in (0.0, 0.9))
    assert from_above(mirroring, 4, lamp) == pytest.approx(from_above(plain, 4, lamp), rel=1e-6)


@pytest.mark.parametrize("attenuation", ["cosine", "exponential", "gaussian"])
@pytest.mark.parametrize("n", [0.5, 11.0, 3000.0])
def test_the_albedo_of_a_lobe_by_a_plain_sum(attenuation, n):
    rho = (np.arange(1_000_000) + 0.5) * (0.5 * math.pi / 1_000_000)
    law = {"cosine": np.cos(rho) ** n, "exponential": np.exp(-n * rho), "gaussian": np.exp(-n * rho**2)}[attenuation]
    albedo = 2.0 * float((law * np.sin(rho)).sum()) * (0.5 * math.pi / 1_000_000)
    material = TypeII(BODY, Spectrum.constant(0.5, "S_I"), attenuation, n, mirror=0.1 * albedo)
    np.testing.assert_allclose(unmirrored_scales(material), [1.0 - 0.2, 1.0], rtol=1e-6)  # the sum's own error


def test_a_strong_mirror_leaves_nothing_and_none_all():
    np.testing.assert_array_equal(unmirrored_scales(TypeI(BODY, 1.0, "cosine", 100.0, mirror=0.5)), [0.0, 1.0])
    np.testing.assert_array_equal(unmirrored_scales(TypeI(BODY, 1.0, "cosine", 100.0)), [1.0, 1.0])


@pytest.mark.parametrize("kind", [PointLight, SpotLight])
def test_a_lamp_that_turns_to_each_point_is_a_disk(kind):
    """A disk of power P that faces a point gives P / (4 pi (c^2 + r^2)): its radiance is P / (4 pi^2 r^2)."""
    matte = TypeI(Spectrum.constant(1.0, "white"), 0.0, "cosine", 1.0)
    place = {"direction": (0.0, 0.0, -1.0), "spot_size": 2.0} if kind is SpotLight else {}
    for soft, expected in ((True, 1.0 / (9.0 + 1.44)), (False, 1.0 / 9.0)):
        lamp = kind((0.0, 0.0, 3.0), strength=100.0, illuminant=WHITE, radius=1.2, soft_falloff=soft, **place)
        seen = from_above(matte, 256, [lamp])
        assert seen == pytest.approx(100.0 / (4.0 * math.pi) * expected / math.pi, rel=STRATIFIED_SKY)
