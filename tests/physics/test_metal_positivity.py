"""The film keeps Eq. 13's two terms apart and cannot clip a wavelength: no metal of the library needs it to."""

import numpy as np
import pytest

from spectral_core.library import metal_names, optical_constants
from spectral_core.reflection.materials import TypeIII


@pytest.mark.parametrize("name", metal_names())
def test_eq_13_is_positive_at_every_angle_and_wavelength(name):
    metal = TypeIII.from_optical_constants(optical_constants(name), beta=0.1)
    weight = metal.mean_reflectance.interface_weight(np.linspace(0.0, 1.0, 2001))
    reflectance = weight[:, None] * metal.normal_reflectance.at(np.arange(360.0, 831.0)) + (1.0 - weight)[:, None]
    assert reflectance.min() > 0.0


def test_the_second_term_of_aluminium_is_negative():
    """So the question is not idle: 1 - w reaches about -0.65 at 80 degrees."""
    metal = TypeIII.from_optical_constants(optical_constants("aluminium"), beta=0.1)
    assert metal.mean_reflectance.interface_weight(np.linspace(0.0, 1.0, 2001)).max() > 1.5
