"""Mirror reflection of the scene: the geometric coefficients with which a bounce multiplies what it shows.

The paper's Eqs. 8 to 10 describe lamps; what a glossy surface shows of its surroundings is a documented extension. In
the mirror direction rho = 0, so f(rho) = 1 and the interface term of Types I and II is S_I, here scaled so that its
largest value is 1 and `mirror` is the reflectance there; for metals it is Eq. 13.

Glowing surfaces and the world are seen in a mirror, and they light surfaces as well. So that the interface does not
show them twice, its lobe gives only the part of their light that the mirror leaves.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..spectra import Spectrum
from .materials import Material, TypeI, TypeII, TypeIII

__all__ = ["MIRROR", "mirror_coefficients", "mirror_reflectances", "scaled_to_peak", "unmirrored_scales"]

MIRROR = "mirror"
"""Component that a mirroring cloth or paper adds: its interface reflectance, scaled to a largest value of 1."""


def scaled_to_peak(spectrum: Spectrum) -> Spectrum:
    """Scale a spectrum so that its largest value is 1.

    Parameters
    ----------
    spectrum : Spectrum
        Not negative.

    Returns
    -------
    Spectrum
        Scaled; one that is 0 everywhere is returned as it is.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    peak = float(spectrum.values.max())
    return spectrum.scaled(1.0 / peak) if peak > 0.0 else spectrum


def mirror_reflectances(material: Material) -> tuple[Spectrum | None, ...]:
    """Give the spectra that a mirror bounce off a material multiplies by.

    Parameters
    ----------
    material : Material
        Any material.

    Returns
    -------
    tuple of Spectrum or None
        Type III: S_I and None for the constant 1, the two terms of Eq. 13. Type II: S_I scaled to its peak. Type I:
        None, as its interface is neutral. Empty when the material does not mirror.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, Eqs. 7-9.
    """
    if material.mirror == 0.0:
        return ()
    if isinstance(material, TypeIII):
        return (material.reflectances[0], None)
    interface = material.reflectances[0]
    if not interface.values.max() > 0.0:
        return ()
    return (None,) if interface.is_constant else (scaled_to_peak(interface),)


def mirror_coefficients(material: Material, cos_incidence: NDArray[Any]) -> NDArray[Any]:
    """Weights of :func:`mirror_reflectances` for light that arrives from the mirror direction.

    Parameters
    ----------
    material : Material
        Its `mirror` is the strength.
    cos_incidence : ndarray, shape (N,)
        Cosine between the normal and the viewer, 0 to 1.

    Returns
    -------
    ndarray, shape (N, C)
        Radiance leaving towards the viewer over (reflectance spectrum x radiance arriving), in the dtype of
        `cos_incidence`. Types I and II: mirror. Type III: mirror x (w, 1 - w) of Eq. 13.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, Eqs. 8, 9 (rho = 0) and 13.
    """
    out = np.full((len(cos_incidence), len(mirror_reflectances(material))), material.mirror, cos_incidence.dtype)
    if isinstance(material, TypeIII) and out.shape[1]:
        cosine = np.clip(cos_incidence.astype(np.float64), 0.0, 1.0)
        weight = material.mean_reflectance.weight_of_checked(cosine)
        out[:, 0] = material.mirror * weight
        out[:, 1] = material.mirror * (1.0 - weight)
    return out


def unmirrored_scales(material: Material) -> NDArray[np.float64]:
    """Factors on a material's lobes under light from what its mirror shows as well.

    Parameters
    ----------
    material : Material
        Any material.

    Returns
    -------
    ndarray, shape (lobes,)
        For the interface of Types I and II and all of Type III, the part of what the lobe reflects that the mirror does
        not: 1 without a mirror, 0 where the mirror reflects as much or more. 1 for bodies.

    Raises
    ------
    None.

    References
    ----------
    Own design. The lobe's albedo is that for a viewer on the normal, 2 S_I times the integral of f(rho) sin(rho) over
    0 to pi/2.
    """
    if isinstance(material, TypeIII):
        return np.full(2, 1.0 - material.mirror)
    scales = np.ones(2)
    if isinstance(material, TypeI | TypeII) and material.mirror > 0.0:
        albedo = float(material.reflectances[0].values.max()) * _lobe_albedo(material.attenuation, material.n)
        scales[0] = max(1.0 - material.mirror / albedo, 0.0) if albedo > 0.0 else 0.0
    return scales


def _lobe_albedo(attenuation: str, n: float) -> float:
    """Return 2 times the integral of f(rho) sin(rho) over 0 to pi/2."""
    if attenuation == "cosine":
        return 2.0 / (n + 1.0)
    if attenuation == "exponential":
        return 2.0 * (1.0 - n * math.exp(-0.5 * math.pi * n)) / (n * n + 1.0)
    end = min(0.5 * math.pi, 8.0 / math.sqrt(n)) if n > 0.0 else 0.5 * math.pi  # exp(-64) is nothing
    nodes, weights = np.polynomial.legendre.leggauss(64)  # type: ignore[no-untyped-call]
    rho = 0.5 * end * (nodes + 1.0)
    return float(end * (weights @ (np.exp(-n * rho**2) * np.sin(rho))))
