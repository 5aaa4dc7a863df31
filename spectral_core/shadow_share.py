"""How much of the lamps' light shadows take from points: for shadow catchers, and as a picture of its own.

It is counted as illuminance, so that a lamp weighs as it looks: the light that reaches a point, over the light that
would reach it if nothing stood in between. Surfaces that face no lamp lose nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lights import Illumination
from .tracing.columns import dot_rows, take_rows

__all__ = ["ShadowTally"]


class ShadowTally:
    """Adds up what lamps give to some points, and what of it arrives.

    Parameters
    ----------
    normal : ndarray, shape (N, 3)
        Unit shading normals of the points.
    """

    def __init__(self, normal: NDArray[np.floating[Any]]) -> None:
        self._normal = normal
        self._sent = np.zeros(len(normal))
        self._arrived = np.zeros(len(normal))

    def add(
        self, illumination: Illumination, facing: NDArray[np.int64], lit: NDArray[np.int64], luminance: float
    ) -> None:
        """Count one point of one lamp.

        Parameters
        ----------
        illumination : Illumination
            What it would give to all points.
        facing : ndarray of int64
            Points that face it, increasing.
        lit : ndarray of int64
            Those of them that it reaches.
        luminance : float
            Weight of the lamp.

        Raises
        ------
        IndexError
            If a point is not there.

        References
        ----------
        Own design.
        """
        cosine = dot_rows(take_rows(self._normal, facing), take_rows(illumination.to_light, facing))
        given = np.zeros(len(self._normal))
        given[facing] = luminance * np.take(illumination.irradiance, facing) * cosine
        self._sent += given
        self._arrived[lit] += given[lit]

    @property
    def occluded(self) -> NDArray[np.float64]:
        """Share of the light that does not arrive, (N,), 0 to 1; 0 where none was sent."""
        sent = np.where(self._sent > 0.0, self._sent, 1.0)
        share: NDArray[np.float64] = np.where(self._sent > 0.0, 1.0 - self._arrived / sent, 0.0)
        return np.clip(share, 0.0, 1.0)
