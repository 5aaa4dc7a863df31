"""Cutting triangles at planes, so that cut neighbours still share their edges exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["clip_triangles"]

Array = NDArray[Any]
Integers = NDArray[np.int64]


def clip_triangles(corners: Array, planes: Array) -> tuple[Array, Integers]:
    """Keep the part of each triangle on the positive side of every plane.

    A new point on an edge is computed from the edge's end inside to its end outside, so that both triangles of a
    shared edge get the same point, bit by bit.

    Parameters
    ----------
    corners : (K, 3, 3) ndarray of float64
        Corners of the triangles.
    planes : (P, 4) array_like of float
        Planes (a, b, c, d); a point is inside where ``a x + b y + c z + d >= 0``.

    Returns
    -------
    pieces : (J, 3, 3) ndarray of float64
        Triangles that fan out the remaining polygons.
    source : (J,) ndarray of int64
        Which triangle each piece is of.

    Raises
    ------
    ValueError
        By numpy, if a shape is wrong.

    References
    ----------
    Sutherland and Hodgman, "Reentrant polygon clipping", Comm. ACM 17(1), 32-42 (1974).
    """
    polygons = np.array(corners, np.float64)
    size = np.full(len(polygons), 3)
    source = np.arange(len(polygons))
    for plane in np.asarray(planes, np.float64):
        polygons, size = _clip(polygons, size, plane)
        left = size > 0
        polygons, size, source = polygons[left], size[left], source[left]
    fans = [(polygons[:, [0, k, k + 1]][size > k + 1], source[size > k + 1]) for k in range(1, polygons.shape[1] - 1)]
    return np.concatenate([fan[0] for fan in fans]), np.concatenate([fan[1] for fan in fans])


def _clip(polygons: Array, size: Integers, plane: Array) -> tuple[Array, Integers]:
    """One plane; polygons are (K, M, 3) with `size` corners used."""
    count, corners, _ = polygons.shape
    height = polygons @ plane[:3] + plane[3]
    slot = np.arange(corners)
    used = slot < size[:, None]
    following = np.where(slot + 1 < size[:, None], slot + 1, 0)
    rows = np.arange(count)[:, None]
    inside = height >= 0.0
    leads_out = used & (inside != inside[rows, following])
    # The cut from the inner end, whichever way round the polygon runs.
    first = np.where(inside[..., None], polygons, polygons[rows, following])
    last = np.where(inside[..., None], polygons[rows, following], polygons)
    h_first = np.where(inside, height, height[rows, following])
    h_last = np.where(inside, height[rows, following], height)
    share = h_first / np.where(leads_out, h_first - h_last, 1.0)
    cuts = first + share[..., None] * (last - first)
    # Each corner emits itself if inside, then the cut behind it if its edge crosses.
    emitted = np.stack([polygons, cuts], axis=2).reshape(count, 2 * corners, 3)
    wanted = np.stack([used & inside, leads_out], axis=2).reshape(count, 2 * corners)
    place = np.cumsum(wanted, axis=1) - 1
    result = np.zeros((count, corners + 1, 3))
    row, column = np.nonzero(wanted)
    result[row, place[row, column]] = emitted[row, column]
    return result, wanted.sum(axis=1)
