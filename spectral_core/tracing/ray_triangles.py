"""Testing rays against triangles: the arithmetic that single rays and packets share, so that both find the same."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .rays import Frame, Nearest

__all__ = ["by_ray_and_entry", "edge_functions", "keep_inside"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_GRADE = np.uint32(15)
"""Low bits of a distance that its order does not go by: eight of the exponent and eight of the mantissa are left."""


def by_ray_and_entry(ray: Integers, entry: Array) -> tuple[Integers, Array]:
    """Order pairs by ray, or packet, then by entry distance.

    Parameters
    ----------
    ray : (m,) ndarray of int64
        Numbers below 65536.
    entry : (m,) ndarray
        Distances, at least 0.

    Returns
    -------
    order : (m,) ndarray of int64
        The order; numpy's stable sort of 16 bits counts instead of comparing.
    least : (m,) ndarray of float32
        Rising bounds of the ordered distances from below.

    Raises
    ------
    ValueError
        By numpy, if the lengths differ.

    References
    ----------
    Own design.
    """
    if entry.dtype != np.float32:
        entry = (entry * (1.0 - 1e-7)).astype(np.float32)
    # The bits of non-negative floats grow with their value.
    grade = (entry.view(np.uint32) >> _GRADE).astype(np.uint16)
    order = np.argsort(grade, kind="stable")
    order = np.take(order, np.argsort(np.take(ray.astype(np.uint16), order), kind="stable"))
    return order, (np.take(grade, order).astype(np.uint32) << _GRADE).view(np.float32)


def edge_functions(corners: list[Array], of_ray: list[Array]) -> tuple[Integers, list[Array], list[Array]]:
    """Find the triangles that rays pass through, before or behind their origins.

    Parameters
    ----------
    corners : list of nine ndarray
        Coordinates across x, across y and along of corner 0, then of corners 1 and 2; they may be written to.
    of_ray : list of five ndarray
        The rays' origins in the same order, and their shears; they broadcast with the corners.

    Returns
    -------
    inside : (h,) ndarray of int64
        Where in the flattened arrays a ray passes through a triangle.
    weights : list of three (h,) ndarray
        Edge functions there: barycentric coordinates but for their sum.
    heights : list of three (h,) ndarray
        Coordinates of the corners along the ray's main axis, from its origin.

    Raises
    ------
    ValueError
        By numpy, if the shapes do not broadcast.

    References
    ----------
    Woop, Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2(1), 65-82 (2013).
    """
    ox, oy, oz, shear_x, shear_y = of_ray
    x, y, z = [], [], []
    for k in (0, 3, 6):
        height = corners[k + 2] - oz
        across = corners[k] - ox
        across -= shear_x * height
        x.append(across)
        across = corners[k + 1] - oy
        across -= shear_y * height
        y.append(across)
        z.append(height)
    a = x[2] * y[1]
    a -= y[2] * x[1]
    b = x[0] * y[2]
    b -= y[0] * x[2]
    c = x[1] * y[0]
    c -= y[1] * x[0]
    least, most = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    inside = np.flatnonzero((least >= 0.0) | (most <= 0.0))
    return (
        inside,
        [np.take(weight.ravel(), inside) for weight in (a, b, c)],
        [np.take(height.ravel(), inside) for height in z],
    )


def keep_inside(
    frame: Frame, nearest: Nearest, ray: Integers, triangle: Integers, weights: list[Array], heights: list[Array]
) -> None:
    """Keep the hits that lie before the rays' origins and nearer than what they have met.

    Parameters
    ----------
    frame : Frame
        The rays.
    nearest : Nearest
        What they have met.
    ray, triangle : (h,) ndarray of int64
        Who passes through what.
    weights, heights : list of three (h,) ndarray
        As :func:`edge_functions` gives them.

    Raises
    ------
    IndexError
        By numpy, if a ray's number is out of range.

    References
    ----------
    Woop, Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2(1), 65-82 (2013).
    """
    a, b, c = weights
    total = a + b + c
    height = a * heights[0] + b * heights[1] + c * heights[2]
    distance = height / total * np.take(frame.reciprocal[frame.along], ray)
    # A triangle seen edge on has total 0 and no finite distance.
    good = (distance > 0.0) & (distance < np.inf) & (distance <= np.take(nearest.distance, ray))
    if frame.own is not None:
        good &= triangle != np.take(frame.own, ray)
    kept = np.flatnonzero(good)
    scale = 1.0 / np.take(total, kept)
    nearest.keep(
        np.take(ray, kept),
        np.take(triangle, kept),
        np.take(distance, kept),
        np.take(b, kept) * scale,
        np.take(c, kept) * scale,
    )
