"""The Torrance-Sparrow factors of Type III: facet distribution D and attenuation G, without cancelling divisions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..validation import require_finite, require_in_range
from .angles import within
from .geometry import Bisector

__all__ = [
    "attenuation_over_cosine",
    "elliptic_facet_distribution",
    "facet_distribution",
    "geometrical_attenuation",
]

Float64 = NDArray[np.float64]

LARGEST = float(np.finfo(np.float64).max) / 256.0
"""Where G/(N.V) saturates: its true value, at most 4/sin(elevation of the light), overflows for a denormal N.L."""

COMMON = 2.0**100


SMALLEST = 5.0e-324
"""The smallest number above 0: a divisor where it does not matter what the quotient is."""


def facet_distribution(alpha: ArrayLike, beta: float) -> NDArray[Any]:
    """Relative share of facets tilted by alpha, D = exp(-ln 2 alpha^2 / beta^2).

    Parameters
    ----------
    alpha : array_like
        Angle in radians between the normal and the bisector of light and viewer, -pi/2 to pi/2, any shape.
    beta : float
        Half-value angle in radians, 0 to pi/2: D(beta) = 1/2. For beta = 0 (a mirror) D is 1 at alpha = 0, else 0.

    Returns
    -------
    ndarray of float64
        0 to 1, in the shape of `alpha`.

    Raises
    ------
    InvalidParameterError
        If an angle lies outside its range.

    References
    ----------
    Tominaga 1996, Eq. 11.
    """
    beta = float(within("beta", beta, 0.0, np.pi / 2))
    tilt = within("alpha", alpha, -np.pi / 2, np.pi / 2)
    return distribution_of_tilt(tilt, beta)


def distribution_of_tilt(tilt: Float64, beta: float) -> Float64:
    """D for checked angles, see :func:`facet_distribution`."""
    if beta == 0.0:
        return np.asarray(tilt == 0.0, dtype=np.float64)
    with np.errstate(over="ignore"):  # alpha / beta and its square may pass the largest float: D is then 0
        power = np.asarray(tilt / beta)
        power *= power
    power *= -np.log(2.0)
    return np.asarray(np.exp(power, out=power))


def elliptic_facet_distribution(
    tilt_along: ArrayLike, tilt_across: ArrayLike, beta: float, beta_across: float
) -> NDArray[Any]:
    """Relative share of facets on a brushed or spin-finished surface: a Gaussian with two half-value angles.

    D = exp(-ln 2 (a_t^2 / beta^2 + a_b^2 / beta_across^2)), where a_t = alpha cos(psi) and a_b = alpha sin(psi) are
    the parts of the tilt along and across the tangent (psi is the azimuth of the bisector from the tangent). Grooves
    that run along the tangent scatter across it, so beta_across is then the larger. For equal angles it is Eq. 11.

    Parameters
    ----------
    tilt_along, tilt_across : array_like
        a_t and a_b in radians; the shapes broadcast.
    beta, beta_across : float
        Half-value angles in radians along and across the tangent, 0 to pi/2.

    Returns
    -------
    ndarray of float64
        0 to 1.

    Raises
    ------
    InvalidParameterError
        If a tilt is not finite or a half-value angle lies outside its range.

    References
    ----------
    Extension of Tominaga 1996, Eq. 11, whose Fig. 12 adds an anisotropy without giving it. The elliptic Gaussian
    follows Ward, G. (1992), "Measuring and modeling anisotropic reflection", SIGGRAPH '92, 265-272.
    """
    beta = float(within("beta", beta, 0.0, np.pi / 2))
    beta_across = float(within("beta_across", beta_across, 0.0, np.pi / 2))
    along, across = require_finite("tilt_along", tilt_along), require_finite("tilt_across", tilt_across)
    if beta == beta_across:
        return distribution_of_tilt(np.hypot(along, across), beta)
    return np.asarray(distribution_of_tilt(along, beta) * distribution_of_tilt(across, beta_across))


def elliptic_distribution(n: Float64, bisector: Bisector, tangent: Float64, beta: float, beta_across: float) -> Float64:
    """D for normals and tangents (3, B); where a tangent is useless (parallel to N) a fixed one replaces it."""
    t = tangent - (tangent[0] * n[0] + tangent[1] * n[1] + tangent[2] * n[2]) * n
    squared = t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
    useless = np.flatnonzero(squared < 1.0e-12)
    if useless.size:
        # Cross product of N with the axis it is farthest from: perpendicular, and never short.
        axis = np.argmin(np.abs(n[:, useless]), axis=0)
        t[:, useless] = np.cross(np.eye(3)[axis], n[:, useless].T).T
        squared[useless] = (t[:, useless] ** 2).sum(axis=0)
    s = bisector.tangential
    length = np.sqrt(squared)
    along = (s[0] * t[0] + s[1] * t[1] + s[2] * t[2]) / length
    across = (
        s[0] * (n[1] * t[2] - n[2] * t[1]) + s[1] * (n[2] * t[0] - n[0] * t[2]) + s[2] * (n[0] * t[1] - n[1] * t[0])
    ) / length
    scale = bisector.facet_tilt()
    scale /= np.maximum(np.sqrt(bisector.tangential_squared), SMALLEST)
    return np.asarray(distribution_of_tilt(along * scale, beta) * distribution_of_tilt(across * scale, beta_across))


def _check_cosines(normal_light: ArrayLike, normal_viewer: ArrayLike, bisector_squared: ArrayLike) -> list[Float64]:
    light = require_in_range("normal_light", normal_light, 0.0, 1.0)
    viewer = require_in_range("normal_viewer", normal_viewer, 0.0, 1.0)
    squared = require_in_range("bisector_squared", bisector_squared, 0.0, 4.0)
    out = [np.asarray(a, dtype=np.float64) for a in np.broadcast_arrays(light, viewer, squared)]
    if np.any((out[2] == 0.0) & (out[0] + out[1] > 0.0)):
        raise InvalidParameterError(
            "bisector_squared must be positive where the light or the viewer is above, but is 0"
        )
    return out


def geometrical_attenuation(
    normal_light: ArrayLike, normal_viewer: ArrayLike, bisector_squared: ArrayLike
) -> NDArray[Any]:
    """Masking and shadowing of V-shaped grooves, G of Eq. 12.

    With H = (L + V)/|L + V| the three cases of Eq. 12 are G = min(1, 4 q N.V / s2, 4 q N.L / s2), where
    q = N.L + N.V and s2 = |L + V|^2.

    Parameters
    ----------
    normal_light, normal_viewer : array_like
        N.L and N.V, 0 to 1; the shapes broadcast.
    bisector_squared : array_like
        |L + V|^2, above 0 to 4.

    Returns
    -------
    ndarray of float64
        0 to 1.

    Raises
    ------
    InvalidParameterError
        If a number lies outside its range.

    References
    ----------
    Tominaga 1996, Eq. 12; Blinn, J. F. (1977), "Models of light reflection for computer synthesized pictures".
    """
    light, viewer, squared = _check_cosines(normal_light, normal_viewer, bisector_squared)
    smaller = np.minimum(light, viewer)
    shadow = 4.0 * (light + viewer) * smaller
    return np.asarray(np.where(shadow < squared, shadow / np.where(squared > 0.0, squared, 1.0), 1.0))


def attenuation_over_cosine(
    normal_light: ArrayLike, normal_viewer: ArrayLike, bisector_squared: ArrayLike
) -> NDArray[Any]:
    """Evaluate G / (N.V) of Eq. 10 as one quotient, finite for a viewer at the horizon.

    Parameters
    ----------
    normal_light, normal_viewer : array_like
        N.L and N.V, 0 to 1; the shapes broadcast.
    bisector_squared : array_like
        |L + V|^2, above 0 to 4.

    Returns
    -------
    ndarray of float64
        At most 2 (1 + cos b) / sin b for a light at elevation b; 0 where N.L = 0; saturates at the largest float / 256.

    Raises
    ------
    InvalidParameterError
        If a number lies outside its range.

    References
    ----------
    Tominaga 1996, Eqs. 10 and 12. With lo and hi the smaller and the larger of N.L and N.V, and r = 1 + lo/hi,
    G/(N.V) = min(1/N.V, 4 r N.L / s2) = 4 r N.L / max(4 r N.L N.V, s2).
    """
    return over_cosine(*_check_cosines(normal_light, normal_viewer, bisector_squared))


def over_cosine(light: Float64, viewer: Float64, squared: Float64) -> Float64:
    """G / (N.V) for checked cosines that are not negative; 0 where N.L is 0."""
    ratio = np.asarray(np.minimum(light, viewer))
    ratio /= np.maximum(np.maximum(light, viewer), SMALLEST)
    ratio += 1.0
    # r lies between 1 and 2, so no product loses a small cosine; the common factor keeps denormal ones exact.
    ratio *= 4.0 * COMMON
    ratio *= light
    denominator = np.asarray(ratio * viewer)
    np.maximum(denominator, COMMON * squared, out=denominator)
    np.maximum(denominator, SMALLEST, out=denominator)  # 0 only where the numerator is
    with np.errstate(over="ignore"):  # a denormal denominator: the quotient saturates
        ratio /= denominator
    return np.asarray(np.minimum(ratio, LARGEST, out=ratio))


def geometry_over_cosine(bisector: Bisector) -> Float64:
    """G / (N.V) for a block of rays; rows below the horizon give numbers without meaning."""
    light, viewer = np.maximum(bisector.normal_light, 0.0), np.maximum(bisector.normal_viewer, 0.0)
    value = over_cosine(light, viewer, bisector.squared)
    if bisector.exponent is not None:
        with np.errstate(over="ignore"):  # the scale is put back: the true value may pass the largest float
            value = np.minimum(np.ldexp(value, bisector.exponent), LARGEST)
    return value
