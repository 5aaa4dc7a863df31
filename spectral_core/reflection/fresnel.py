"""Fresnel reflectance of smooth surfaces, and the estimates of it that the paper compares.

The exact laws are written in terms of what is *not* reflected, 1 - R, because Eq. 13 needs that difference and metals
have R near 1. With eta = n + i k, c = cos phi, s2 = 1 - c^2 and eta^2 - s2 = (a + i b)^2, the reflectances are

    R_s = (a^2 + b^2 - 2 a c + c^2) / (a^2 + b^2 + 2 a c + c^2)
    R_p = R_s (c^2 (a^2 + b^2) - 2 a c s2 + s2^2) / (c^2 (a^2 + b^2) + 2 a c s2 + s2^2)

so that t_s = 1 - R_s = 4 a c / (...) and t_p = 1 - R_p / R_s = 4 a c s2 / (...) are sums of positive terms only, and
1 - R = t_s + (1 - t_s) t_p / 2 for unpolarised light.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import require_in_range
from .angles import within

__all__ = [
    "absorptance",
    "cook_torrance_estimate",
    "dichromatic_estimate",
    "fresnel_conductor",
    "fresnel_dielectric",
    "hall_absorbing_estimate",
    "hall_linear_estimate",
    "schlick_estimate",
]

Float64 = NDArray[np.float64]

MAX_INDEX = 1.0e6  # squares of n and k stay far from overflow; no material comes near
SMALLEST_COSINE = 1.0e-120  # squares of smaller ones would vanish; 1 - R is proportional to the cosine long before


def _index(n: ArrayLike, k: ArrayLike) -> tuple[Float64, Float64]:
    refractive = require_in_range("n", n, 0.0, MAX_INDEX)
    extinction = require_in_range("k", k, 0.0, MAX_INDEX)
    require_in_range("n + k", refractive + extinction, float(np.finfo(np.float64).tiny))
    return refractive, extinction


def _cosine(cos_incidence: ArrayLike) -> Float64:
    return require_in_range("cos_incidence", cos_incidence, 0.0, 1.0)


def conductor_absorptance(cosine: Float64, n: Float64, k: Float64) -> Float64:
    """1 - R for checked arguments, see :func:`absorptance`."""
    c = np.where(cosine > 0.0, np.maximum(cosine, SMALLEST_COSINE), 0.0)
    sine_squared = (1.0 - c) * (1.0 + c)
    real = (n - 1.0) * (n + 1.0) + c * c - k * k  # Re(eta^2 - s2), without the cancellation of n^2 - 1 + c^2
    modulus = np.hypot(real, 2.0 * n * k)  # a^2 + b^2
    root = np.sqrt(0.5 * (modulus + np.abs(real)))  # a where real >= 0, b where real < 0
    a = np.where(real < 0.0, n * k / np.where(root > 0.0, root, 1.0), root)
    product = 2.0 * a * c
    below_s = modulus + c * c + product
    across = product * sine_squared
    below_p = c * c * modulus + sine_squared * sine_squared + across
    t_s = 2.0 * product / np.where(below_s > 0.0, below_s, 1.0)
    t_p = 2.0 * across / np.where(below_p > 0.0, below_p, 1.0)
    # t_s may round to just above 1 (index-matched media); t_p never matters then.
    absorbed = np.minimum(t_s + np.maximum(1.0 - t_s, 0.0) * 0.5 * t_p, 1.0)
    # Towards grazing incidence 1 - R is proportional to c, except for the medium that is no medium.
    matched = (n == 1.0) & (k == 0.0)
    return np.where(
        matched, np.where(c > 0.0, 1.0, 0.0), absorbed * np.where(c > 0.0, cosine / np.where(c > 0.0, c, 1.0), 1.0)
    )


def absorptance(cos_incidence: ArrayLike, n: ArrayLike, k: ArrayLike = 0.0) -> NDArray[Any]:
    """Share of unpolarised light that a smooth surface does not reflect, 1 - R, without cancellation.

    Parameters
    ----------
    cos_incidence : array_like
        Cosine of the angle of incidence, 0 to 1.
    n, k : array_like
        Refractive index and extinction coefficient relative to the outside, 0 to 1e6, not both 0; k = 0 is a
        dielectric (with total reflection where n < 1). The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1, full relative accuracy (2e-15) also where R is nearly 1; 0 at grazing incidence.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Born & Wolf, Principles of Optics, 13.2 and 14.2; the form is derived at the head of this module.
    """
    refractive, extinction = _index(n, k)
    return conductor_absorptance(_cosine(cos_incidence), refractive, extinction)


def fresnel_conductor(cos_incidence: ArrayLike, n: ArrayLike, k: ArrayLike) -> NDArray[Any]:
    """Reflectance of a smooth absorbing medium for unpolarised light.

    Parameters
    ----------
    cos_incidence : array_like
        Cosine of the angle of incidence, 0 to 1.
    n, k : array_like
        Refractive index and extinction coefficient, 0 to 1e6, not both 0. The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1; 1 at grazing incidence.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Born & Wolf, Principles of Optics, 14.2; Tominaga 1996, ref. 17.
    """
    return np.asarray(1.0 - absorptance(cos_incidence, n, k))


def fresnel_dielectric(cos_incidence: ArrayLike, n: ArrayLike) -> NDArray[Any]:
    """Reflectance of a smooth transparent medium for unpolarised light.

    Parameters
    ----------
    cos_incidence : array_like
        Cosine of the angle of incidence, 0 to 1.
    n : array_like
        Refractive index of the medium over that of the outside, 1e-6 to 1e6. Below 1 light is totally reflected
        beyond the critical angle. The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1; 1 at grazing incidence. Where n is near 1 the small reflectance keeps its relative accuracy.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Born & Wolf, Principles of Optics, 1.5.2.
    """
    refractive = require_in_range("n", n, 1.0e-6, MAX_INDEX)
    cosine = _cosine(cos_incidence)
    excess = (refractive - 1.0) * (refractive + 1.0)  # n^2 - 1
    c = np.maximum(cosine, SMALLEST_COSINE)
    inside_squared = excess + c * c  # n^2 cos^2 of the refracted ray
    total_reflection = (inside_squared < 0.0) | (cosine == 0.0)
    g = np.where(total_reflection, 1.0, np.sqrt(np.maximum(inside_squared, 0.0)))
    # c - g and n^2 c - g as quotients of n^2 - 1, so that a small reflectance is not a difference of large numbers.
    s_squared = (1.0 - c) * (1.0 + c)
    total = c + g
    r_s = excess / (total * total)
    square = refractive * refractive
    p_total = square * c + g
    # n^4 c^2 - g^2 = (n^2 - 1)(n^2 c^2 - s^2)
    r_p = excess * (square * c * c - s_squared) / (p_total * p_total)
    reflectance = 0.5 * (r_s * r_s + r_p * r_p)
    return np.where(total_reflection, 1.0, np.minimum(reflectance, 1.0))


def dichromatic_estimate(
    normal_reflectance: ArrayLike, mean_at_incidence: ArrayLike, mean_at_normal: ArrayLike
) -> NDArray[Any]:
    """Estimate a metal's spectral reflectance at an incidence from that at normal incidence: Eq. 13.

    Parameters
    ----------
    normal_reflectance : array_like
        S_I, the reflectance at normal incidence, 0 to 1.
    mean_at_incidence : array_like
        Sa(phi), the mean reflectance over wavelength at the incidence, 0 to 1.
    mean_at_normal : array_like
        Sa(0), 0 to 1. The shapes broadcast; put wavelengths last.

    Returns
    -------
    ndarray of float64
        0 to 1. The weight of the constant part may be negative (aluminium: -0.65 at 80 deg) and is not clamped; only
        the result is. Where Sa(0) = 1 the result is S_I.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Tominaga 1996, Eq. 13.
    """
    reflectance = require_in_range("normal_reflectance", normal_reflectance, 0.0, 1.0)
    at_incidence = require_in_range("mean_at_incidence", mean_at_incidence, 0.0, 1.0)
    at_normal = require_in_range("mean_at_normal", mean_at_normal, 0.0, 1.0)
    absorbed = 1.0 - at_normal
    ratio = np.where(absorbed > 0.0, (1.0 - at_incidence) / np.where(absorbed > 0.0, absorbed, 1.0), 1.0)
    return np.asarray(np.clip(1.0 - ratio * (1.0 - reflectance), 0.0, 1.0))


def schlick_estimate(normal_reflectance: ArrayLike, cos_incidence: ArrayLike) -> NDArray[Any]:
    """Estimate the reflectance at an incidence as R + (1 - R)(1 - cos phi)^5.

    Parameters
    ----------
    normal_reflectance : array_like
        Reflectance at normal incidence, 0 to 1.
    cos_incidence : array_like
        Cosine of the angle of incidence, 0 to 1. The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Schlick, C. (1994), "An inexpensive BRDF model for physically-based rendering", Computer Graphics Forum 13, 233.
    """
    reflectance = require_in_range("normal_reflectance", normal_reflectance, 0.0, 1.0)
    return np.asarray(reflectance + (1.0 - reflectance) * (1.0 - _cosine(cos_incidence)) ** 5)


def cook_torrance_estimate(normal_reflectance: ArrayLike, cos_incidence: ArrayLike) -> NDArray[Any]:
    """Estimate the reflectance at an incidence as that of the transparent medium with the same normal reflectance.

    Parameters
    ----------
    normal_reflectance : array_like
        Reflectance at normal incidence, 0 to 1; the index is n = (1 + sqrt R) / (1 - sqrt R), per wavelength.
    cos_incidence : array_like
        Cosine of the angle of incidence, 0 to 1. The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1; 1 where the normal reflectance is 1 (infinite index).

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Cook, R. L. & Torrance, K. E. (1981), "A reflectance model for computer graphics"; Tominaga 1996, Fig. 9.
    """
    reflectance = require_in_range("normal_reflectance", normal_reflectance, 0.0, 1.0)
    root = np.sqrt(reflectance)
    gap = 1.0 - root
    index = np.minimum((1.0 + root) / np.where(gap > 0.0, gap, 1.0), MAX_INDEX)
    estimate = fresnel_dielectric(cos_incidence, np.maximum(index, 1.0))
    return np.where(gap > 0.0, estimate, 1.0)


def hall_linear_estimate(normal_reflectance: ArrayLike, incidence: ArrayLike) -> NDArray[Any]:
    """Estimate the reflectance at an incidence by going linearly in angle from the normal reflectance to 1.

    Parameters
    ----------
    normal_reflectance : array_like
        Reflectance at normal incidence, 0 to 1.
    incidence : array_like
        Angle of incidence in radians, 0 to pi/2. The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Hall, R. (1989), Illumination and Color in Computer Generated Imagery; Tominaga 1996, Fig. 9.
    """
    reflectance = require_in_range("normal_reflectance", normal_reflectance, 0.0, 1.0)
    share = within("incidence", incidence, 0.0, np.pi / 2) / (np.pi / 2)
    return np.asarray(reflectance + share * (1.0 - reflectance))


def hall_absorbing_estimate(
    normal_reflectance: ArrayLike, mean_at_normal: ArrayLike, cos_incidence: ArrayLike
) -> NDArray[Any]:
    """Estimate the reflectance at an incidence with the angular course of a medium of n = 1 and fitted absorption.

    The share of the constant part follows the reflectance F of a medium with n = 1 and the extinction coefficient
    k = 2 sqrt(R / (1 - R)) that gives the mean normal reflectance R: S = S_I + (1 - S_I) max(0, F(phi) - R)/(1 - R).

    Parameters
    ----------
    normal_reflectance : array_like
        S_I, the reflectance at normal incidence, 0 to 1.
    mean_at_normal : array_like
        R, its mean over wavelength, 0 to 1. Where it is 1 the result is S_I.
    cos_incidence : array_like
        Cosine of the angle of incidence, 0 to 1. The shapes broadcast.

    Returns
    -------
    ndarray of float64
        0 to 1.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    Hall, R. (1989), Illumination and Color in Computer Generated Imagery, 4.2; Cook & Torrance 1981 for the k of n = 1.
    """
    reflectance = require_in_range("normal_reflectance", normal_reflectance, 0.0, 1.0)
    mean = require_in_range("mean_at_normal", mean_at_normal, 0.0, 1.0)
    absorbed = 1.0 - mean
    safe = np.where(absorbed > 0.0, absorbed, 1.0)
    extinction = np.minimum(2.0 * np.sqrt(mean / safe), MAX_INDEX)
    ratio = np.minimum(np.where(absorbed > 0.0, absorptance(cos_incidence, 1.0, extinction) / safe, 1.0), 1.0)
    return np.asarray(np.clip(1.0 - ratio * (1.0 - reflectance), 0.0, 1.0))
