"""Mirror reflection of the scene: the geometric coefficients with which a bounce multiplies what it shows.

The paper's Eqs. 8 to 10 describe lamps; what a glossy surface shows of its surroundings is a documented extension. In
the mirror direction rho = 0, so f(rho) = 1 and the interface term of Types I and II is S_I; for metals it is Eq. 13.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .materials import Material, TypeIII

__all__ = ["mirror_coefficients", "mirror_components"]


def mirror_components(material: Material) -> tuple[int, ...]:
    """Name the components of a material that take part in mirror reflection.

    Parameters
    ----------
    material : Material
        Any material.

    Returns
    -------
    tuple of int
        Indices of its reflectances: both terms of Eq. 13 for a metal, the interface for the others; none if it does
        not mirror.

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
        return (0, 1)
    return (0,) if material.reflectances[0].values.max() > 0.0 else ()


def mirror_coefficients(material: Material, cos_incidence: NDArray[Any]) -> NDArray[Any]:
    """Weights of a material's reflectances for light that arrives from the mirror direction.

    Parameters
    ----------
    material : Material
        Its `mirror` is the strength.
    cos_incidence : ndarray, shape (N,)
        Cosine between the normal and the viewer, 0 to 1.

    Returns
    -------
    ndarray, shape (N, C)
        Radiance leaving towards the viewer over (reflectance spectrum x radiance arriving), for the C components of
        :func:`mirror_components`, in the dtype of `cos_incidence`. Types I and II: mirror / max S_I. Type III:
        mirror x (w, 1 - w) of Eq. 13.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, Eqs. 8, 9 (rho = 0) and 13.
    """
    out = np.zeros((len(cos_incidence), len(mirror_components(material))), cos_incidence.dtype)
    if not out.shape[1]:
        return out
    if isinstance(material, TypeIII):
        cosine = np.clip(cos_incidence.astype(np.float64), 0.0, 1.0)
        weight = material.mean_reflectance.weight_of_checked(cosine)
        out[:, 0] = material.mirror * weight
        out[:, 1] = material.mirror * (1.0 - weight)
    else:
        out[:, 0] = material.mirror / float(material.reflectances[0].values.max())
    return out
