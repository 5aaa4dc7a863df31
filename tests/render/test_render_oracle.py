"""The film's image against the brute-force sum at every nanometre, and against spheres known in closed form."""

import numpy as np
import pytest

from spectral_core.library import optical_constants
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings
from spectral_core.tracing.sampling import pixel_offsets
from tests.render import brute_force
from tests.render.render_scenes import still_life
from tests.tolerances import FILM_AGAINST_BRUTE_FORCE, PIXELS_THAT_ROUND_ACROSS_AN_EDGE

WIDTH, HEIGHT = 40, 28


@pytest.mark.parametrize(
    ("lamps", "observer"),
    [(("D65", "FL2", "HP1"), "cie_1931_2"), (("A", "FL11", "LED-B3"), "cie_1964_10")],
)
def test_image_equals_the_spectral_sum_in_every_pixel(lamps, observer):
    scene = still_life(lamps)
    settings = RenderSettings(WIDTH, HEIGHT, samples=2, observer=observer, precision="float64", seed=3)
    got = render(scene, settings).tristimulus()
    offsets = pixel_offsets(2, settings.pixel_filter, settings.filter_width, 3)
    expected = brute_force.image(scene, WIDTH, HEIGHT, observer, offsets, (None, None, optical_constants("copper")))
    assert np.ptp(expected[..., 1]) > 0.2  # the picture has something to get wrong
    np.testing.assert_allclose(got, expected, rtol=FILM_AGAINST_BRUTE_FORCE)


def test_float32_differs_only_where_a_ray_falls_on_the_other_side_of_an_edge():
    scene = still_life()
    settings = {"width": 160, "height": 112, "samples": 1}
    reference = render(scene, RenderSettings(**settings, precision="float64")).tristimulus()
    single = render(scene, RenderSettings(**settings)).tristimulus()
    assert single.dtype == np.float32
    relative = np.abs(single - reference) / np.maximum(reference, 1e-3)
    differs = (relative > 2e-4).any(axis=2)  # the metal's narrow lobe carries float32 angles of 1e-7 to this
    assert differs.mean() < PIXELS_THAT_ROUND_ACROSS_AN_EDGE
