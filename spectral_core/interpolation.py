"""Interpolation between samples as explicit linear weights.

Every way of reading a spectrum between its samples is linear in the samples, so each is written here as weights:
a sparse stencil for one-off reading, and a dense matrix where the weights themselves are wanted (weighting tables).
Beyond the first and the last node the value is held constant.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError
from .validation import require_choice, require_finite

__all__ = ["INTERPOLATIONS", "interpolate", "interpolation_matrix"]

INTERPOLATIONS = ("linear", "lagrange", "spline")
"""What :func:`interpolation_matrix` knows: piecewise linear, local cubic Lagrange, natural cubic spline."""


def _checked_nodes(nodes: ArrayLike) -> NDArray[np.float64]:
    x = require_finite("nodes", nodes)
    if x.ndim != 1 or x.size == 0:
        raise InvalidParameterError(f"nodes must be a list of at least one number, but has the shape {x.shape}")
    if np.any(np.diff(x) <= 0):
        at = int(np.flatnonzero(np.diff(x) <= 0)[0])
        raise InvalidParameterError(f"nodes must increase strictly, but {x[at + 1]:g} follows {x[at]:g}")
    return x


def _stencil(
    x: NDArray[np.float64], targets: NDArray[np.float64], method: str
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Find the nodes (M, P) that each target reads and their weights (M, P), P <= 4."""
    n = x.size
    t = np.clip(targets, x[0], x[-1])
    if n == 1:
        return np.zeros((t.size, 1), np.int64), np.ones((t.size, 1))
    left = np.clip(np.searchsorted(x, t, side="right") - 1, 0, n - 2)
    if method == "linear" or n == 2:
        share = (t - x[left]) / (x[left + 1] - x[left])
        return np.stack([left, left + 1], axis=1), np.stack([1.0 - share, share], axis=1)
    # Four nodes around the target; in the first and the last interval the three nearest (ASTM E2022 does the same),
    # expressed as a fourth node of weight zero so that all rows have one shape.
    first = np.clip(left - 1, 0, max(n - 4, 0))
    width = min(n, 4)
    index = first[:, None] + np.arange(width)
    used = np.ones(index.shape, dtype=bool)
    if n >= 4:
        used[left == 0, 3] = False
        used[left == n - 2, 0] = False
    weights = np.ones(index.shape)
    for i in range(width):
        for j in range(width):
            if i != j:
                factor = (t - x[index[:, j]]) / (x[index[:, i]] - x[index[:, j]])
                weights[:, i] *= np.where(used[:, j], factor, 1.0)
    weights[~used] = 0.0
    return index, weights


def interpolate(nodes: ArrayLike, values: ArrayLike, targets: ArrayLike, method: str = "linear") -> NDArray[np.float64]:
    """Read a function known at nodes at other places, held constant beyond the ends.

    Parameters
    ----------
    nodes : array_like (W,)
        Strictly increasing places, usually wavelengths in nm; W >= 1.
    values : array_like (..., W)
        The function at the nodes.
    targets : array_like
        Places to read, any shape.
    method : {"linear", "lagrange"}
        Piecewise linear, or the cubic through the two nodes on each side (three nodes in an end interval).

    Returns
    -------
    ndarray of float64 (..., *targets.shape)
        The function at the targets; exactly the given values at the nodes.

    Raises
    ------
    InvalidParameterError
        If the nodes do not increase strictly, a number is not finite, shapes do not match, or the method is unknown.

    References
    ----------
    ASTM E2022-11, section 5 (Lagrange coefficients); CIE 15:2004, 7.2.1.
    """
    require_choice("method", method, ("linear", "lagrange"))
    x = _checked_nodes(nodes)
    y = require_finite("values", values)
    if y.shape[-1:] != x.shape:
        raise InvalidParameterError(f"values must have {x.size} samples on the last axis, but has {y.shape}")
    where = require_finite("targets", targets)
    index, weights = _stencil(x, where.ravel(), method)
    read = np.einsum("...mp,mp->...m", y[..., index], weights)
    return np.asarray(read).reshape(y.shape[:-1] + where.shape)


def interpolation_matrix(nodes: ArrayLike, targets: ArrayLike, method: str = "lagrange") -> NDArray[np.float64]:
    """Weights that carry values at the nodes to the targets: ``matrix @ values``.

    Parameters
    ----------
    nodes : array_like (W,)
        Strictly increasing places, usually wavelengths in nm; W >= 1.
    targets : array_like (M,)
        Places to read.
    method : {"linear", "lagrange", "spline"}
        Piecewise linear, local cubic Lagrange (three nodes in an end interval), or natural cubic spline.

    Returns
    -------
    ndarray of float64 (M, W)
        Each row sums to 1. Weights may be negative; they are never clipped. Targets beyond the nodes read the end node.

    Raises
    ------
    InvalidParameterError
        If the nodes do not increase strictly, a number is not finite, or the method is unknown.

    References
    ----------
    ASTM E2022-11, section 5; natural cubic spline: C. de Boor, A Practical Guide to Splines, chapter IV.
    """
    require_choice("method", method, INTERPOLATIONS)
    x = _checked_nodes(nodes)
    t = require_finite("targets", targets)
    if t.ndim != 1:
        raise InvalidParameterError(f"targets must be a list of numbers, but has the shape {t.shape}")
    if method == "spline" and x.size > 2:
        return _spline_matrix(x, t)
    index, weights = _stencil(x, t, "linear" if method == "spline" else method)
    matrix = np.zeros((t.size, x.size))
    np.add.at(matrix, (np.arange(t.size)[:, None], index), weights)
    return matrix


def _spline_matrix(x: NDArray[np.float64], targets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Natural cubic spline: solve for the second derivatives of every unit vector, then evaluate (de Boor, IV)."""
    n = x.size
    h = np.diff(x)
    system = np.eye(n)
    right = np.zeros((n, n))
    for i in range(1, n - 1):
        system[i, i - 1 : i + 2] = h[i - 1] / 6.0, (h[i - 1] + h[i]) / 3.0, h[i] / 6.0
        right[i, i - 1 : i + 2] = 1.0 / h[i - 1], -1.0 / h[i - 1] - 1.0 / h[i], 1.0 / h[i]
    curvature = np.linalg.solve(system, right)
    t = np.clip(targets, x[0], x[-1])
    left = np.clip(np.searchsorted(x, t, side="right") - 1, 0, n - 2)
    step = h[left]
    b = (t - x[left]) / step
    a = 1.0 - b
    rows = np.arange(t.size)
    matrix = np.zeros((t.size, n))
    matrix[rows, left] += a
    matrix[rows, left + 1] += b
    square = step * step / 6.0
    matrix += ((a * a * a - a) * square)[:, None] * curvature[left]
    matrix += ((b * b * b - b) * square)[:, None] * curvature[left + 1]
    return matrix
