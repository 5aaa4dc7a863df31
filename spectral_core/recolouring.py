"""Whether two scenes differ in nothing but spectra and strengths, so that what was traced for one serves the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from .plan import make_plan
from .reflection.material import Material
from .reflection.mean_reflectance import MeanReflectance
from .scene import RenderSettings, Scene
from .spectra import Spectrum
from .textured_reflectance import TexturedReflectance
from .tracing.geometry import Geometry

__all__ = ["differ_in_spectra_only"]

_SPECTRAL = frozenset({"illuminant", "strength", "name"})
_COSINES = np.linspace(0.0, 1.0, 33)  # where the whitening of metals is compared


def differ_in_spectra_only(
    before: Scene,
    after: Scene,
    settings_before: RenderSettings,
    settings_after: RenderSettings,
    geometry: Geometry | None = None,
) -> bool:
    """Whether the film of one scene has the geometric coefficients of the other.

    Parameters
    ----------
    before, after : Scene
        The scenes. Their triangles are taken to be the same: :class:`~spectral_core.AccelerationCache` tells.
    settings_before, settings_after : RenderSettings
        How each is rendered; observer and wavelengths may differ.
    geometry : Geometry, optional
        The scenes' triangles where they have been gathered.

    Returns
    -------
    bool
        True if lights, world, emission and materials are the same but for their spectra and strengths, and no term
        is needed that the first scene's plan leaves out.

    Raises
    ------
    InvalidParameterError
        If the spectra of a scene are invalid.

    References
    ----------
    Own design; the linearity of Tominaga 1996, Eqs. 4 and 7, in the spectra.
    """
    if not _same_settings(settings_before, settings_after):
        return False
    if [i.mask for i in before.instances] != [i.mask for i in after.instances]:
        return False
    lights = _alike(before.lights, after.lights)
    emissions = _alike(before.emissions, after.emissions)
    if not (lights and emissions and _alike([before.world], [after.world])):
        return False
    if len(before.materials) != len(after.materials):
        return False
    if not all(_same_lobes(*pair) for pair in zip(before.materials, after.materials, strict=True)):
        return False
    one, other = make_plan(before, settings_before, geometry), make_plan(after, settings_after, geometry)
    # A lamp that was dark has no terms; one that became dark has terms that weigh nothing.
    return set(other.terms) <= set(one.terms) and (one.monomials, one.exact_depth) == (
        other.monomials,
        other.exact_depth,
    )


def _same_settings(one: RenderSettings, other: RenderSettings) -> bool:
    return all(
        getattr(one, field.name) == getattr(other, field.name)
        for field in fields(one)
        if field.name not in {"observer", "grid"}
    )


def _alike(before: Sequence[Any], after: Sequence[Any]) -> bool:
    """Whether emitters are the same but for what they emit."""
    return len(before) == len(after) and all(
        type(one) is type(other)
        and (
            one is None
            or all(
                _equal(getattr(one, field.name), getattr(other, field.name))
                for field in fields(one)
                if field.name not in _SPECTRAL
            )
        )
        for one, other in zip(before, after, strict=True)
    )


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return one is other or (isinstance(other, np.ndarray) and np.array_equal(one, other))
    if is_dataclass(one) and not isinstance(one, type):  # such as the image of a world
        return type(one) is type(other) and (
            one is other or all(_equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
        )
    return bool(one == other)


def _same_lobes(one: Material, other: Material) -> bool:
    """Whether two materials send light where the other does, whatever its colour."""
    if type(one) is not type(other) or one.component_names != other.component_names:
        return False
    for field in fields(one):  # type: ignore[arg-type]
        if field.name.startswith("_"):
            continue
        values = getattr(one, field.name), getattr(other, field.name)
        if isinstance(values[0], MeanReflectance) and isinstance(values[1], MeanReflectance):
            if not np.array_equal(*(value.interface_weight(_COSINES) for value in values)):
                return False
        elif isinstance(values[0], Spectrum) and isinstance(values[1], Spectrum):
            continue
        elif isinstance(values[0], TexturedReflectance) and isinstance(values[1], TexturedReflectance):
            if not values[0].mixes_like(values[1]):
                return False
        elif field.name == "interface_reflectance" and all(isinstance(value, float | int) for value in values):
            continue  # of Type I: a constant spectrum
        elif not _equal(*values):
            return False
    # The strongest interface decides how much is left for a body that conserves energy, and how much of the light of
    # the world and of surfaces a mirror leaves to the lobe.
    if one.energy_conserving or one.mirror > 0.0:
        return all(
            float(mine.values.max()) == float(theirs.values.max())
            for name, mine, theirs in zip(one.component_names, one.reflectances, other.reflectances, strict=True)
            if name.startswith("interface")
        )
    return True
