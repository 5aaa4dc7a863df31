"""The attenuation f(rho) of the interface reflection of Types I and II.

rho is the angle between the mirror direction and the viewer. The paper offers three laws, all 1 at rho = 0:
``cosine`` (cos rho)^n, ``exponential`` exp(-n |rho|) and ``gaussian`` exp(-n rho^2).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import require_choice, require_in_range
from .angles import chord_squared, floating_type, vectors, within
from .geometry import ReflectionGeometry

__all__ = ["ATTENUATIONS", "MAX_EXPONENT", "attenuation", "attenuation_at_angle", "attenuation_of_geometry"]

Float64 = NDArray[np.float64]

ATTENUATIONS = ("cosine", "exponential", "gaussian")
"""Names of the attenuation laws: (cos rho)^n, exp(-n |rho|), exp(-n rho^2)."""

MAX_EXPONENT = 1.0e8
"""Largest n; the lobe is then 1e-4 rad wide (1e-8 rad for the exponential law), finer than float32 vectors resolve."""


BARELY_ABOVE = -1.0 + 2.0**-53
"""The smallest cosine above zero that 1 - cos can tell, less 1."""


def _cosine_power(n: float, half_chord_squared: Float64) -> Float64:
    """(cos rho)^n from 1 - cos rho; zero where the cosine is not positive."""
    below = half_chord_squared < 1.0
    # log1p keeps what pow(cos, n) loses: at n = 1e8 the lobe lives where cos rho rounds to 1.
    power = np.asarray(np.negative(half_chord_squared))
    np.maximum(power, BARELY_ABOVE, out=power)
    np.log1p(power, out=power)
    power *= n
    np.exp(power, out=power)
    power *= below
    return power


def _of_angle(kind: str, n: float, rho: Float64) -> Float64:
    """The exponential and Gaussian laws at angles that are not negative."""
    power = np.asarray(rho * rho if kind == "gaussian" else rho + 0.0)
    power *= -n
    return np.asarray(np.exp(power, out=power))


def attenuation_of_geometry(kind: str, n: float, geometry: ReflectionGeometry) -> Float64:
    """Evaluate f(rho) for a block of rays.

    Parameters
    ----------
    kind : {"cosine", "exponential", "gaussian"}
        The law.
    n : float
        0 to 1e8.
    geometry : ReflectionGeometry
        Block of B rays.

    Returns
    -------
    ndarray of float64 (B,)
        0 to 1. Rows below the horizon are evaluated like all others.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, text before Eq. 8.
    """
    if kind == "cosine":
        chord_squared = geometry.mirror_chord_squared()
        chord_squared *= 0.5
        return _cosine_power(n, chord_squared)
    return _of_angle(kind, n, geometry.mirror_angle())


def attenuation_at_angle(kind: str, n: float, rho: ArrayLike) -> NDArray[Any]:
    """Evaluate f(rho) at given angles.

    Parameters
    ----------
    kind : {"cosine", "exponential", "gaussian"}
        The law.
    n : float
        0 to 1e8.
    rho : array_like
        Angles in radians, -pi to pi, any shape.

    Returns
    -------
    ndarray of float64
        0 to 1, in the shape of `rho`. The cosine law is 0 where |rho| >= pi/2, for n = 0 too.

    Raises
    ------
    InvalidParameterError
        If the law is unknown, or n or an angle lies outside its range.

    References
    ----------
    Tominaga 1996, text before Eq. 8.
    """
    require_choice("attenuation", kind, ATTENUATIONS)
    n = float(require_in_range("n", n, 0.0, MAX_EXPONENT))
    angle = np.abs(within("rho", rho, -np.pi, np.pi))
    if kind == "cosine":
        return _cosine_power(n, 2.0 * np.square(np.sin(0.5 * angle)))
    return _of_angle(kind, n, angle)


def attenuation(kind: str, n: float, mirror: ArrayLike, to_viewer: ArrayLike) -> NDArray[Any]:
    """Evaluate f(rho) between mirror directions and viewers.

    Parameters
    ----------
    kind : {"cosine", "exponential", "gaussian"}
        The law.
    n : float
        0 to 1e8.
    mirror, to_viewer : array_like (..., 3)
        Unit vectors; the shapes broadcast. The mirror direction is the light mirrored about the normal.

    Returns
    -------
    ndarray (...)
        0 to 1; float32 when both vectors are. The cosine law is 0 where rho >= pi/2, for n = 0 too.

    Raises
    ------
    InvalidParameterError
        If the law is unknown, n lies outside its range, or the last axis has not three components.

    References
    ----------
    Tominaga 1996, text before Eq. 8.
    """
    require_choice("attenuation", kind, ATTENUATIONS)
    n = float(require_in_range("n", n, 0.0, MAX_EXPONENT))
    r, v = vectors("mirror", mirror), vectors("to_viewer", to_viewer)
    result_type = floating_type(r, v)
    apart = chord_squared(r, v)
    if kind == "cosine":
        return _cosine_power(n, 0.5 * apart).astype(result_type)
    rho = 2.0 * np.arctan2(np.sqrt(apart), np.sqrt(chord_squared(r, -v)))
    return _of_angle(kind, n, rho).astype(result_type)
