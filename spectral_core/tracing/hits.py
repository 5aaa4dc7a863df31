"""What rays meet, and where the next ray may start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .columns import dot_rows

__all__ = ["Hits", "offset_origins"]

Array = NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """The nearest triangle of each ray.

    Parameters
    ----------
    distance : (N,) ndarray
        In units of the ray's direction; infinite where nothing is met.
    triangle : (N,) ndarray of int64
        Triangle number, -1 where nothing is met.
    u, v : (N,) ndarray
        Weights of corners 1 and 2 (corner 0 has 1 - u - v); 0 where nothing is met.

    References
    ----------
    Own design.
    """

    distance: Array
    triangle: NDArray[np.int64]
    u: Array
    v: Array

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Which rays met something, (N,)."""
        return self.triangle >= 0

    def __len__(self) -> int:
        return len(self.triangle)

    def take(self, index: NDArray[np.int64]) -> Hits:
        """Select rays.

        Parameters
        ----------
        index : (n,) ndarray of int64
            Which.

        Returns
        -------
        Hits
            Theirs.

        Raises
        ------
        IndexError
            By numpy, if a ray is not there.

        References
        ----------
        Own design.
        """
        return Hits(*(np.take(values, index) for values in (self.distance, self.triangle, self.u, self.v)))


def offset_origins(points: Array, geometric_normal: Array, directions: Array, radius: float) -> Array:
    """Lift hit points off their surface, to the side the next ray leaves to.

    Together with leaving out the ray's own triangle this keeps a surface from shadowing or mirroring itself. The step
    is 4 units in the last place of the largest coordinate in play.

    Parameters
    ----------
    points : (N, 3) ndarray
        Positions relative to the geometry's centre.
    geometric_normal : (N, 3) ndarray
        Unit normals of the flat triangles, facing either way.
    directions : (N, 3) ndarray
        Where the next rays go; any length.
    radius : float
        The geometry's radius.

    Returns
    -------
    (N, 3) ndarray
        Ray origins in the dtype of `points`.

    Raises
    ------
    ValueError
        By numpy, if the shapes do not broadcast.

    References
    ----------
    Own design; after Waechter and Binder, "A fast and robust method for avoiding self-intersection", Ray Tracing
    Gems (2019), which scales the step by the coordinates too.
    """
    ulp = np.finfo(points.dtype).eps
    x, y, z = points.T
    step = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.maximum(np.abs(z), radius))
    step *= points.dtype.type(4.0 * ulp)
    leaving = dot_rows(geometric_normal, directions)
    np.copysign(step, leaving, out=step)
    return points + step[:, None] * geometric_normal
