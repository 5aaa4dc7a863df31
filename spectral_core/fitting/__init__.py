"""Fitting: from measured spectra at several geometries to a material with confidence intervals."""

from __future__ import annotations

from .components import Components, component_weights, extreme_components
from .dichromatic import Candidate, Recommendation, SpectralTests, normalised, recommend_type, spectral_tests
from .lobes import LobeFit, fit_lobe
from .material_fit import MATERIAL_TYPES, MEAN_REFLECTANCES, FitOptions, MaterialFit, fit_material
from .material_json import (
    MaterialRecord,
    Provenance,
    format_material_json,
    parse_material_json,
    provenance_of_fit,
    read_material_json,
    write_material_json,
)
from .measurement_files import read_measurements, write_measurements
from .measurements import REFERENCES, MeasurementGeometry, Measurements
from .uncertainty import Interval, NoiseEstimate, SpectrumEstimate

__all__ = [
    "MATERIAL_TYPES",
    "MEAN_REFLECTANCES",
    "REFERENCES",
    "Candidate",
    "Components",
    "FitOptions",
    "Interval",
    "LobeFit",
    "MaterialFit",
    "MaterialRecord",
    "MeasurementGeometry",
    "Measurements",
    "NoiseEstimate",
    "Provenance",
    "Recommendation",
    "SpectralTests",
    "SpectrumEstimate",
    "component_weights",
    "extreme_components",
    "fit_lobe",
    "fit_material",
    "format_material_json",
    "normalised",
    "parse_material_json",
    "provenance_of_fit",
    "read_material_json",
    "read_measurements",
    "recommend_type",
    "spectral_tests",
    "write_material_json",
    "write_measurements",
]
