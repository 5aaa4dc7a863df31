"""Share directions out among neighbouring pixels so that each pixel's own are even over the sphere.

Light from all around reaches a pixel from few directions. Together those of a tile of pixels are a Sobol net on the
sphere; which pixel gets which is free, and decides how much neighbours differ.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["MOST_BALANCED", "balanced_groups"]

MOST_BALANCED = 256
"""Directions worth sharing out together: a pixel's part of more is even by itself, and the work grows as the square."""

_ROUNDS = 200  # an end in any case; a tenth of it is the usual
_LEAST_GAIN = 1e-12  # of numbers up to 1; less is rounding


def balanced_groups(directions: NDArray[np.float64]) -> NDArray[np.int64]:
    """Exchange directions between groups until no exchange makes the groups more even.

    What counts is how much the irradiance of an even sky, found with the directions of a group, differs from its true
    value, in the mean square over all groups, all normals of a surface, and all planes that may hide a half of the sky;
    and as much again over those normals and planes that lie along the axes, as floors, walls and boxes mostly do.

    Parameters
    ----------
    directions : ndarray of float64, shape (G, S, 3)
        Unit vectors, S to a group.

    Returns
    -------
    ndarray of int64, shape (G, S)
        Numbers of the directions, counted group by group, that each group has now: all of them, each once.

    Raises
    ------
    ValueError
        By numpy, if a direction has not three coordinates.

    References
    ----------
    Own design. The mean product of two cosines that are 0 behind the surface: Cho and Saul, "Kernel methods for deep
    learning", NIPS (2009), the arc-cosine kernel of degree 1; of two half-spaces, that of degree 0.
    """
    directions = np.ascontiguousarray(directions, np.float64)
    groups, size, _ = directions.shape
    return np.frombuffer(_exchanged(directions.tobytes(), groups, size), np.int64).reshape(groups, size)


@lru_cache(maxsize=32)
def _exchanged(directions: bytes, groups: int, size: int) -> bytes:
    """The same for the same directions, which a sky has in every frame."""
    unit = np.frombuffer(directions, np.float64).reshape(-1, 3)
    alike = _alike(unit)
    group = np.repeat(np.arange(groups), size)
    order = np.arange(groups * size)
    same_group = group[:, None] == group
    for _ in range(_ROUNDS):
        placed = alike[np.ix_(order, order)]
        with_group = placed.reshape(-1, groups, size).sum(axis=2)
        own = with_group[np.arange(len(order)), group]
        # What the group of i has more of when j takes the place of i; and the other way round.
        change = with_group[:, group].T - placed - (own - np.diagonal(placed))[:, None]
        change = change + change.T
        change[same_group] = 0.0
        partner = change.argmin(axis=1)
        gain = change[np.arange(len(order)), partner]
        free = np.ones(groups, bool)  # exchanges between other groups do not touch each other
        for i in np.argsort(gain, kind="stable"):
            j = partner[i]
            if gain[i] > -_LEAST_GAIN:
                break
            if free[group[i]] and free[group[j]]:
                order[[i, j]] = order[[j, i]]
                free[group[[i, j]]] = False
        if free.all():
            break
    return order.tobytes()


def _alike(unit: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean product of the irradiances that two directions give, over surfaces and over what hides a half of the sky."""
    cosine = unit @ unit.T
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    left = np.pi - angle
    anywhere = (np.sin(angle) + left * cosine) / (6.0 * np.pi) * left / (2.0 * np.pi)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    received = np.maximum(unit @ axes.T, 0.0)
    given = [received]
    for k in range(3):  # hidden by a plane across another axis, from either side
        given += [
            received[:, [n for n in range(6) if n % 3 != k]] * (sign * unit[:, k, None] > 0.0) for sign in (1, -1)
        ]
    along_axes = np.concatenate(given, axis=1)
    return np.asarray(anywhere + along_axes @ along_axes.T / along_axes.shape[1], np.float64)
