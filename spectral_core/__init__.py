"""Spectral rendering with Tominaga's three dichromatic reflection models, in pure numpy.

Light along any path is a product of spectra with a geometric coefficient. The renderer keeps the two apart: the film
holds coefficients, the spectra are integrated once per scene, and a lamp or a paint can be exchanged after the render.
"""

from __future__ import annotations

from . import fitting
from .atomic_files import replacing
from .buffers import BUFFERS, SurfaceBuffers
from .colorimetry import (
    ADAPTATIONS,
    GRID_PRESETS,
    OBSERVERS,
    WavelengthGrid,
    chromatic_adaptation,
    delta_e_2000,
    lab,
    observer,
    tristimulus_weights,
    wavelength_grid,
    white_point,
)
from .development import Development
from .display import DISPLAYS, GAMUT_METHODS, SRGB_WHITE, Display, display, fit_to_gamut
from .display_files import read_display
from .errors import (
    DichromaticError,
    FittingError,
    InvalidParameterError,
    MissingDependencyError,
    RenderCancelledError,
    SceneError,
    SpectrumFileError,
)
from .estimate import estimate
from .image_io import IMAGE_SUFFIXES, write_image
from .library import (
    illuminant,
    illuminant_names,
    metal_names,
    optical_constants,
    reflectance,
    reflectance_names,
    source_of,
)
from .light_groups import LIGHT_COMPONENTS, LightPart, split_light
from .lights import AREA_SHAPES, AreaLight, EnvironmentImage, PointLight, SpotLight, SunLight
from .plan import make_plan
from .probe import PixelProbe, probe_pixel
from .progressive import ProgressiveRender
from .recolouring import differ_in_spectra_only
from .reflection.attenuation import ATTENUATIONS
from .reflection.energy import energy_warnings
from .reflection.materials import Material, TypeI, TypeII, TypeIII
from .reflection.mirror import MIRROR
from .render_file import open_render, save_render
from .renderer import Band, Render, render
from .resampling import resample
from .rgb_uplift import uplift
from .scene import Emission, RenderSettings, Scene, World
from .scene_spectra import IMAGE, SceneSpectra, slots_of_material
from .spectra import REFERENCE_WAVELENGTHS_NM, Spectrum, blackbody, daylight, gaussian
from .spectral_exr import write_spectral_exr
from .spectrum_files import read_optical_constants, read_spectra, read_spectrum, write_spectrum
from .studies import contact_sheet, metamerism_map, relit_by
from .texture_mixing import filtered, mixture, uplift_texture, weighted_reflectance
from .textured_reflectance import TexturedReflectance, require_plain
from .textures import EXTENSIONS, INTERPOLATIONS, ImageTexture
from .tracing import Acceleration, AccelerationCache, Camera, Geometry, Instance, Mesh
from .tradeoff import QUALITIES, Measurement, Tradeoff, measure_tradeoff, quality_settings

__version__ = "0.1.0"

__all__ = [
    "ADAPTATIONS",
    "AREA_SHAPES",
    "ATTENUATIONS",
    "BUFFERS",
    "DISPLAYS",
    "EXTENSIONS",
    "GAMUT_METHODS",
    "GRID_PRESETS",
    "IMAGE",
    "IMAGE_SUFFIXES",
    "INTERPOLATIONS",
    "LIGHT_COMPONENTS",
    "MIRROR",
    "OBSERVERS",
    "QUALITIES",
    "REFERENCE_WAVELENGTHS_NM",
    "SRGB_WHITE",
    "Acceleration",
    "AccelerationCache",
    "AreaLight",
    "Band",
    "Camera",
    "Development",
    "DichromaticError",
    "Display",
    "Emission",
    "EnvironmentImage",
    "FittingError",
    "Geometry",
    "ImageTexture",
    "Instance",
    "InvalidParameterError",
    "LightPart",
    "Material",
    "Measurement",
    "Mesh",
    "MissingDependencyError",
    "PixelProbe",
    "PointLight",
    "ProgressiveRender",
    "Render",
    "RenderCancelledError",
    "RenderSettings",
    "Scene",
    "SceneError",
    "SceneSpectra",
    "Spectrum",
    "SpectrumFileError",
    "SpotLight",
    "SunLight",
    "SurfaceBuffers",
    "TexturedReflectance",
    "Tradeoff",
    "TypeI",
    "TypeII",
    "TypeIII",
    "WavelengthGrid",
    "World",
    "__version__",
    "blackbody",
    "chromatic_adaptation",
    "contact_sheet",
    "daylight",
    "delta_e_2000",
    "differ_in_spectra_only",
    "display",
    "energy_warnings",
    "estimate",
    "filtered",
    "fit_to_gamut",
    "fitting",
    "gaussian",
    "illuminant",
    "illuminant_names",
    "lab",
    "make_plan",
    "measure_tradeoff",
    "metal_names",
    "metamerism_map",
    "mixture",
    "observer",
    "open_render",
    "optical_constants",
    "probe_pixel",
    "quality_settings",
    "read_display",
    "read_optical_constants",
    "read_spectra",
    "read_spectrum",
    "reflectance",
    "reflectance_names",
    "relit_by",
    "render",
    "replacing",
    "require_plain",
    "resample",
    "save_render",
    "slots_of_material",
    "source_of",
    "split_light",
    "tristimulus_weights",
    "uplift",
    "uplift_texture",
    "wavelength_grid",
    "weighted_reflectance",
    "white_point",
    "write_image",
    "write_spectral_exr",
    "write_spectrum",
]
