"""The small pictures of spectra."""

from __future__ import annotations

import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon.nodes import plot

from .fake_layout import FakeLayout

pytestmark = pytest.mark.bpy


def curve_height(pixels):
    """The highest row of each column that is as bright as the line."""
    bright = np.all(pixels[..., :3] >= min(plot.LINE) - 1e-6, axis=-1)
    return bright.shape[0] - 1 - np.argmax(bright[::-1], axis=0)


def test_the_curve_stands_where_the_values_are(addon):
    ramp = core.Spectrum(np.array([380.0, 780.0]), np.array([0.0, 1.0]))
    height = curve_height(plot.plot_pixels(ramp))
    expected = np.linspace(0.0, plot.SIZE - 2, plot.SIZE)
    assert np.all(np.abs(height - expected) <= 2.0)  # the line is two to three pixels thick


def test_values_above_one_are_scaled_to_fit(addon):
    double = curve_height(plot.plot_pixels(core.Spectrum(np.array([380.0, 780.0]), np.array([0.0, 20.0]))))
    assert double[-1] >= plot.SIZE - 2
    assert double[plot.SIZE // 2] == pytest.approx(plot.SIZE / 2, abs=2.0)


def test_the_area_has_the_colours_of_the_light(addon):
    pixels = plot.plot_pixels(core.Spectrum.constant(0.9))
    at = {nm: pixels[10, int((nm - 380.0) / 400.0 * (plot.SIZE - 1)), :3] for nm in (450.0, 530.0, 620.0)}
    assert np.argmax(at[450.0]) == 2
    assert np.argmax(at[530.0]) == 1
    assert np.argmax(at[620.0]) == 0


def test_a_spectrum_is_drawn_once(addon):
    layout = FakeLayout()
    for _ in range(3):
        plot.draw_plot(layout, core.illuminant("FL11"))
    assert len(layout.names("icon")) == 3
    assert list(plot._plots).count(core.illuminant("FL11").key.hex()) == 1


def test_the_number_of_pictures_is_bounded(addon):
    layout = FakeLayout()
    for index in range(plot.MOST_PLOTS + 5):
        plot.draw_plot(layout, core.Spectrum.constant(index / 1000.0))
    assert len(plot._plots) <= plot.MOST_PLOTS
