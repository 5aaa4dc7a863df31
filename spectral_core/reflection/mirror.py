"""Mirror reflection of the scene: the geometric coefficients with which a bounce multiplies what it shows.

The paper's Eqs. 8 to 10 describe lamps; what a glossy surface shows of its surroundings is a documented extension. In
the mirror direction rho = 0, so f(rho) = 1 and the interface term of Types I and II is S_I, here scaled so that its
largest value is 1 and `mirror` is the reflectance there; for metals it is Eq. 13.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..spectra import Spectrum
from .materials import Material, TypeIII

__all__ = ["MIRROR", "mirror_coefficients", "mirror_reflectances", "scaled_to_peak"]

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
