"""How surfaces reflect: the paper's three material types, their laws, and the exact laws they approximate."""

from __future__ import annotations

from .angles import angle_between, mirror_direction
from .attenuation import ATTENUATIONS, attenuation, attenuation_at_angle
from .energy import AngularResponse, directional_albedo, energy_warnings, furnace_response
from .fresnel import (
    absorptance,
    cook_torrance_estimate,
    dichromatic_estimate,
    fresnel_conductor,
    fresnel_dielectric,
    hall_absorbing_estimate,
    hall_linear_estimate,
    schlick_estimate,
)
from .materials import INCIDENCES, Material, TypeI, TypeII, TypeIII
from .mean_reflectance import (
    MEAN_BAND_NM,
    MeanReflectance,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
)
from .microfacet import (
    attenuation_over_cosine,
    elliptic_facet_distribution,
    facet_distribution,
    geometrical_attenuation,
)

__all__ = [
    "ATTENUATIONS",
    "INCIDENCES",
    "MEAN_BAND_NM",
    "AngularResponse",
    "Material",
    "MeanReflectance",
    "MeasuredMeanReflectance",
    "OpticalMeanReflectance",
    "SchlickMeanReflectance",
    "TypeI",
    "TypeII",
    "TypeIII",
    "absorptance",
    "angle_between",
    "attenuation",
    "attenuation_at_angle",
    "attenuation_over_cosine",
    "cook_torrance_estimate",
    "dichromatic_estimate",
    "directional_albedo",
    "elliptic_facet_distribution",
    "energy_warnings",
    "facet_distribution",
    "fresnel_conductor",
    "fresnel_dielectric",
    "furnace_response",
    "geometrical_attenuation",
    "hall_absorbing_estimate",
    "hall_linear_estimate",
    "mirror_direction",
    "schlick_estimate",
]
