"""A smooth function on [0, 1] kept as cubics on equal intervals: quick to read for millions of rays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["UniformTable"]

Float64 = NDArray[np.float64]


class UniformTable:
    """Piecewise cubic through values at equal steps, with slopes from fourth-order differences.

    Parameters
    ----------
    values : ndarray of float64 (M + 1,)
        The function at 0, 1/M, ..., 1; M >= 5.
    """

    __slots__ = ("_coefficients",)

    def __init__(self, values: Float64) -> None:
        v = np.asarray(values, dtype=np.float64)
        slopes = np.empty_like(v)  # per interval, not per unit of x
        slopes[2:-2] = (v[:-4] - 8.0 * v[1:-3] + 8.0 * v[3:-1] - v[4:]) / 12.0
        for end, step in ((0, 1), (v.size - 1, -1)):
            a = v[end::step][:5]
            slopes[end] = step * (-25.0 * a[0] + 48.0 * a[1] - 36.0 * a[2] + 16.0 * a[3] - 3.0 * a[4]) / 12.0
            slopes[end + step] = step * (-3.0 * a[0] - 10.0 * a[1] + 18.0 * a[2] - 6.0 * a[3] + a[4]) / 12.0
        rise = np.diff(v)
        left, right = slopes[:-1], slopes[1:]
        self._coefficients = np.stack([v[:-1], left, 3.0 * rise - 2.0 * left - right, left + right - 2.0 * rise])

    def read(self, x: Float64) -> Float64:
        """Evaluate the cubics.

        Parameters
        ----------
        x : ndarray of float64
            Arguments from 0 to 1, any shape.

        Returns
        -------
        ndarray of float64
            Values in the shape of `x`.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        constant, linear, square, cube = self._coefficients
        position = x * cube.size
        index = np.minimum(position.astype(np.intp), cube.size - 1)
        u = position - index
        value = cube.take(index)
        for row in (square, linear, constant):
            value *= u
            value += row.take(index)
        return np.asarray(value)
