"""What the reflection laws need to know of a ray, in forms that keep their digits at small angles and at the horizon.

They are N.L, N.V, the chord between the mirror direction and the viewer, and the bisector of light and viewer. All of
them come from ``S = L + V``:

* its part along the normal is ``N.L + N.V``;
* its part across the normal, ``S_t``, gives the tilt of the bisector, tan(alpha) = |S_t| / (N.L + N.V);
* the chord is |R - V|^2 = |S_t|^2 + (N.V - N.L)^2, because R - V = (R + L) - S and R + L = 2 (N.L) N;
* the facet incidence is cos = V.H = |S| / 2.

Work is done in float64 on blocks that stay in the processor's cache, whatever the type of the vectors: for float32
vectors this is as fast as whole-array float32 arithmetic, and sharp lobes keep their shape. A material asks for what it
needs, and only that is computed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidParameterError

__all__ = ["Bisector", "ReflectionGeometry", "reflection_geometry"]

Float64 = NDArray[np.float64]

BLOCK_ROWS = 8192  # the nine components of the vectors and a few columns more fit a second-level cache of 1 MB
UNIT_TOLERANCE = 1.0e-3  # on |v|^2; float32 normalisation leaves 1e-7, so anything beyond is a caller's mistake
SMALL_BISECTOR = 1.0e-140  # below this |L + V|^2 would leave the normal range of float64


def _dot(first: Float64, second: Float64) -> Float64:
    """Scalar products of vectors (..., 3, B).

    Not einsum: that adds in another order when there is one ray, and a ray must not know of its neighbours.
    """
    total = first[..., 0, :] * second[..., 0, :]
    product = first[..., 1, :] * second[..., 1, :]
    total += product
    np.multiply(first[..., 2, :], second[..., 2, :], out=product)
    total += product
    return np.asarray(total)


def _scale_to_unit_length(vectors: Float64, names: tuple[str, ...]) -> None:
    """Check vectors (K, 3, B), K of them a ray, and take away in place what rounding left of their length."""
    excess = _dot(vectors, vectors)
    excess -= 1.0
    low, high = (excess.min(), excess.max()) if excess.size else (0.0, 0.0)
    if not (low >= -UNIT_TOLERANCE and high <= UNIT_TOLERANCE):  # also true of NaN
        kind, row = np.argwhere(~(np.abs(excess) <= UNIT_TOLERANCE))[0]
        raise InvalidParameterError(
            f"{names[kind]} must be finite vectors of length 1, but one is {vectors[kind, :, row].tolist()}"
        )
    worst = max(-low, high)
    if worst > 1.0e-15:
        # 1/sqrt(1 + e) without a square root or division: to second order exact to 1e-16 for what float32 leaves, to
        # third order exact to 1e-13 for the largest e allowed.
        factor = excess * (0.375 if worst < 1.0e-5 else 0.375 - 0.3125 * excess)
        factor -= 0.5
        factor *= excess
        factor += 1.0
        vectors *= factor[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class Bisector:
    """The sum S = L + V of one block of B rays, in float64.

    Rows where it is nearly zero (light and viewer both grazing, opposite each other) hold everything multiplied by a
    power of two, ``2**exponent``, so that squares stay in range.

    Parameters
    ----------
    normal_light, normal_viewer : ndarray (B,)
        N.L and N.V, times 2**exponent.
    tangential : ndarray (3, B)
        The part of L + V across the normal, times 2**exponent.
    tangential_squared : ndarray (B,)
        Its squared length.
    squared : ndarray (B,)
        |L + V|^2, times 4**exponent.
    exponent : ndarray (B,) of int, or None
        None stands for zero everywhere.
    """

    normal_light: Float64
    normal_viewer: Float64
    tangential: Float64
    tangential_squared: Float64
    squared: Float64
    exponent: NDArray[np.int32] | None

    def facet_cosine(self) -> Float64:
        """Cosine of the incidence on the facets that mirror the light to the viewer, V.H = L.H = |L + V| / 2.

        Returns
        -------
        ndarray (B,)
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 8.
        """
        half = np.sqrt(self.squared)
        half *= 0.5
        if self.exponent is not None:
            half = np.ldexp(half, -self.exponent)
        return np.asarray(np.minimum(half, 1.0, out=half))

    def facet_tilt(self) -> Float64:
        """Angle alpha between the normal and the bisector of light and viewer.

        Returns
        -------
        ndarray (B,)
            Radians, 0 to pi/2 where both stand above the surface.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 8; tan(alpha) = |S_t| / (N.L + N.V).
        """
        tilt = np.sqrt(self.tangential_squared)
        return np.asarray(np.arctan2(tilt, self.normal_light + self.normal_viewer, out=tilt))


@dataclass(frozen=True, slots=True, eq=False)
class ReflectionGeometry:
    """One block of B rays, in float64.

    Parameters
    ----------
    normal : ndarray (3, B)
        Unit normals.
    to_light, to_viewer : ndarray (3, B)
        Unit vectors.
    normal_light, normal_viewer : ndarray (B,)
        N.L and N.V.
    """

    normal: Float64
    to_light: Float64
    to_viewer: Float64
    normal_light: Float64
    normal_viewer: Float64

    @property
    def visible(self) -> NDArray[np.bool_] | bool:
        """Rows where both the light and the viewer stand above the surface.

        Returns
        -------
        ndarray of bool (B,), or True
            True where N.L > 0 and N.V > 0; a single True if that is everywhere.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        rows = self.normal_light > 0.0
        rows &= self.normal_viewer > 0.0
        return True if rows.all() else rows

    def mirror_chord_squared(self) -> Float64:
        """Square of the chord between the mirrored light and the viewer, |R - V|^2.

        Returns
        -------
        ndarray (B,)
            0 to 4.

        Raises
        ------
        None.

        References
        ----------
        Own design: |(L + V)_t|^2 + (N.V - N.L)^2, derived at the head of this module.
        """
        across = self.to_light + self.to_viewer
        across -= (self.normal_light + self.normal_viewer) * self.normal
        along = self.normal_viewer - self.normal_light
        along *= along
        along += _dot(across, across)
        return along

    def mirror_angle(self) -> Float64:
        """Angle rho between the mirrored light and the viewer.

        Returns
        -------
        ndarray (B,)
            Radians, 0 to pi.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 5; 2 atan2(|R - V|, |R + V|), see :func:`.angles.angle_between`. Own design:
        |R + V|^2 = |(V - L)_t|^2 + (N.L + N.V)^2.
        """
        across = self.to_viewer - self.to_light
        across -= (self.normal_viewer - self.normal_light) * self.normal
        along = self.normal_viewer + self.normal_light
        along *= along
        along += _dot(across, across)
        angle = np.sqrt(self.mirror_chord_squared())
        np.arctan2(angle, np.sqrt(along), out=angle)
        angle *= 2.0
        return angle

    def bisector(self) -> Bisector:
        """Add light and viewer.

        Returns
        -------
        Bisector
            What follows from L + V.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 8.
        """
        light, viewer = self.normal_light, self.normal_viewer
        total = light + viewer
        along = total * self.normal
        tangential = self.to_light + self.to_viewer
        tangential -= along
        tangential_squared = _dot(tangential, tangential)
        squared = total * total
        squared += tangential_squared
        exponent: NDArray[np.int32] | None = None
        if squared.size and squared.min() < SMALL_BISECTOR**2:
            small = np.flatnonzero((squared < SMALL_BISECTOR**2) & (light > 0.0) & (viewer > 0.0))
            if small.size:
                # Both graze, opposite each other: scale the bisector to order one (exact, a power of two).
                bisector = self.to_light[:, small] + self.to_viewer[:, small]
                raise_by = -np.frexp(np.maximum(np.abs(bisector).max(axis=0), total[small]))[1]
                exponent = np.zeros(total.shape, np.int32)
                exponent[small] = raise_by
                light, viewer = np.ldexp(light, exponent), np.ldexp(viewer, exponent)
                scaled_total = light[small] + viewer[small]
                part = np.ldexp(bisector, raise_by) - scaled_total * self.normal[:, small]
                tangential[:, small] = part
                tangential_squared[small] = _dot(part, part)
                squared[small] = tangential_squared[small] + scaled_total**2
        return Bisector(light, viewer, tangential, tangential_squared, squared, exponent)


def reflection_geometry(normal: Float64, to_light: Float64, to_viewer: Float64) -> ReflectionGeometry:
    """Derive the cosines of light and viewer for one block of rays.

    Parameters
    ----------
    normal, to_light, to_viewer : ndarray of float64 (3, B)
        Components of unit vectors that point away from the surface.

    Returns
    -------
    ReflectionGeometry
        The block.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, Figs. 5 and 8.
    """
    return ReflectionGeometry(normal, to_light, to_viewer, _dot(normal, to_light), _dot(normal, to_viewer))


def geometry_blocks(
    normal: NDArray[Any], to_light: NDArray[Any], to_viewer: NDArray[Any]
) -> Iterator[tuple[slice, ReflectionGeometry]]:
    """Split rays (N, 3), already broadcast to one shape, into checked blocks; each is gone when the next is made."""
    named = {"normal": normal, "to_light": to_light, "to_viewer": to_viewer}
    rows = normal.shape[0]
    store = np.empty((len(named), 3, min(rows, BLOCK_ROWS)))
    for start in range(0, rows, BLOCK_ROWS):
        block = slice(start, min(start + BLOCK_ROWS, rows))
        vectors = store[:, :, : block.stop - block.start]
        for components, array in zip(vectors, named.values(), strict=True):
            components[...] = array[block].T
        _scale_to_unit_length(vectors, tuple(named))
        yield block, reflection_geometry(*vectors)
