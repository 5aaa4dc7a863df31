"""Spectral rendering with Tominaga's three dichromatic reflection models, in pure numpy.

Light along any path is a product of spectra with a geometric coefficient. The renderer keeps the two apart: the film
holds coefficients, the spectra are integrated once per scene, and a lamp or a paint can be exchanged after the render.
"""

from __future__ import annotations

from . import fitting
from .colorimetry import chromatic_adaptation, delta_e_2000, lab, observer, wavelength_grid, white_point
from .errors import DichromaticError
from .library import illuminant, metal_names, optical_constants, reflectance
from .lights import PointLight, SpotLight, SunLight
from .reflection.materials import TypeI, TypeII, TypeIII
from .renderer import Render, render
from .scene import RenderSettings, Scene, World
from .spectra import Spectrum, blackbody, daylight
from .tracing import Camera, Instance, Mesh

__version__ = "0.1.0"

__all__ = [
    "Camera",
    "DichromaticError",
    "Instance",
    "Mesh",
    "PointLight",
    "Render",
    "RenderSettings",
    "Scene",
    "Spectrum",
    "SpotLight",
    "SunLight",
    "TypeI",
    "TypeII",
    "TypeIII",
    "World",
    "__version__",
    "blackbody",
    "chromatic_adaptation",
    "daylight",
    "delta_e_2000",
    "fitting",
    "illuminant",
    "lab",
    "metal_names",
    "observer",
    "optical_constants",
    "reflectance",
    "render",
    "wavelength_grid",
    "white_point",
]
