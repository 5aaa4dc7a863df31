"""Angles between unit vectors, in forms that keep their digits when the angle is small or the light grazes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..validation import require_finite, require_in_range

__all__ = ["angle_between", "chord_squared", "mirror_direction"]

Float64 = NDArray[np.float64]

ANGLE_SLACK = 1.0e-6  # rad; pi/2 in float32 lies 4e-8 beyond pi/2


def floating_type(*arrays: NDArray[Any]) -> np.dtype[Any]:
    """Type of the result for these inputs: float32 if all are at most that precise, else float64."""
    kind = np.result_type(*arrays)
    return np.dtype(np.float32) if kind in (np.float32, np.float16) else np.dtype(np.float64)


def within(name: str, angle: ArrayLike, low: float, high: float) -> Float64:
    """Return angles in float64, or raise; those that a shorter type has rounded out of the range are put back."""
    angle = require_finite(name, angle)
    angle = np.where((angle > high) & (angle <= high + ANGLE_SLACK), high, angle)
    if low < 0.0:
        angle = np.where((angle < low) & (angle >= low - ANGLE_SLACK), low, angle)
    return require_in_range(name, angle, low, high, unit="rad")


def vectors(name: str, value: ArrayLike) -> NDArray[Any]:
    """Return `value` as an array whose last axis has three components, or raise."""
    array = np.asarray(value)
    if array.ndim == 0 or array.shape[-1] != 3 or array.dtype.kind not in "fiu":
        raise InvalidParameterError(
            f"{name} must be real vectors with three components, but has shape {array.shape} and type {array.dtype}"
        )
    return array


def unit_float64(array: NDArray[Any]) -> Float64:
    """Vectors (..., 3) in float64; those of a shorter type lose what rounding left of their length."""
    wide = array.astype(np.float64, copy=False)
    if wide is array:
        return wide
    length = np.sqrt(np.einsum("...i,...i->...", wide, wide))[..., None]
    return np.asarray(wide / np.where(length > 0.0, length, 1.0))


def angle_between(first: ArrayLike, second: ArrayLike) -> NDArray[Any]:
    """Angle between unit vectors.

    Uses 2 atan2(|a - b|, |a + b|), which keeps full relative accuracy at every angle, where the arc cosine of
    the scalar product loses everything below 3e-4 rad in float32 (1e-8 in float64).

    Parameters
    ----------
    first, second : array_like (..., 3)
        Unit vectors; the shapes broadcast.

    Returns
    -------
    ndarray (...)
        Angles in radians, 0 to pi; float32 when both inputs are.

    Raises
    ------
    InvalidParameterError
        If the last axis has not three components.

    References
    ----------
    Kahan, W. (2006), "How futile are mindless assessments of roundoff in floating-point computation?", section 12.
    """
    a, b = vectors("first", first), vectors("second", second)
    kind = floating_type(a, b)
    a, b = unit_float64(a), unit_float64(b)
    difference, total = a - b, a + b
    # hypot, not a sum of squares: components may be so small that their squares vanish.
    apart = np.hypot(np.hypot(difference[..., 0], difference[..., 1]), difference[..., 2])
    along = np.hypot(np.hypot(total[..., 0], total[..., 1]), total[..., 2])
    return np.asarray(2.0 * np.arctan2(apart, along), dtype=kind)


def mirror_direction(normal: ArrayLike, direction: ArrayLike) -> NDArray[Any]:
    """Mirror a direction about the normal: R = 2 (N.L) N - L.

    Parameters
    ----------
    normal, direction : array_like (..., 3)
        Unit vectors that point away from the surface; the shapes broadcast.

    Returns
    -------
    ndarray (..., 3)
        Unit vectors; float32 when both inputs are.

    Raises
    ------
    InvalidParameterError
        If the last axis has not three components.

    References
    ----------
    Tominaga 1996, Fig. 5.
    """
    n, d = vectors("normal", normal), vectors("direction", direction)
    kind = floating_type(n, d)
    n, d = unit_float64(n), unit_float64(d)
    cosine = np.sum(n * d, axis=-1, keepdims=True)
    return np.asarray(2.0 * cosine * n - d, dtype=kind)


def chord_squared(first: ArrayLike, second: ArrayLike) -> NDArray[Any]:
    """Square of the chord between unit vectors, |a - b|^2 = 2 - 2 cos, without its cancellation.

    Parameters
    ----------
    first, second : array_like (..., 3)
        Unit vectors; the shapes broadcast.

    Returns
    -------
    ndarray (...)
        0 to 4, float64 whatever the inputs.

    Raises
    ------
    InvalidParameterError
        If the last axis has not three components.

    References
    ----------
    Own design.
    """
    a, b = vectors("first", first), vectors("second", second)
    difference = unit_float64(a) - unit_float64(b)
    return np.asarray(np.einsum("...i,...i->...", difference, difference))
