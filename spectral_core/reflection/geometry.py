"""What the reflection laws need to know of a ray, in forms that keep their digits at small angles and at the horizon.

The reflection laws need four numbers per ray: ``N.L``, ``N.V``, the chord between the mirror direction and the viewer,
and the bisector of light and viewer. All of them come from ``S = L + V``:

* its part along the normal is ``N.L + N.V``;
* its part across the normal, ``S_t``, gives the tilt of the bisector, tan(alpha) = |S_t| / (N.L + N.V);
* the chord is |R - V|^2 = |S_t|^2 + (N.V - N.L)^2, because R - V = (R + L) - S and R + L = 2 (N.L) N;
* the facet incidence is cos = V.H = |S| / 2.

Work is done in float64 on blocks that stay in the processor's cache, whatever the type of the vectors: for float32
vectors this is as fast as whole-array float32 arithmetic, and sharp lobes keep their shape.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidParameterError

__all__ = ["ReflectionGeometry", "reflection_geometry"]

Float64 = NDArray[np.float64]

BLOCK_ROWS = 8192  # about twenty float64 columns of this length fit a 2 MB second-level cache
UNIT_TOLERANCE = 1.0e-3  # on |v|^2; float32 normalisation leaves 1e-7, so anything beyond is a caller's mistake
SMALL_BISECTOR = 1.0e-140  # below this |L + V|^2 would leave the normal range of float64


def unit_components(name: str, block: NDArray[Any]) -> Float64:
    """Components (3, B) in float64 of the unit vectors (B, 3), with what rounding left of their length removed."""
    components = np.array(block.T, dtype=np.float64, order="C")
    x, y, z = components
    excess = x * x
    excess += y * y
    excess += z * z
    excess -= 1.0
    low, high = (excess.min(), excess.max()) if excess.size else (0.0, 0.0)
    if not (low >= -UNIT_TOLERANCE and high <= UNIT_TOLERANCE):  # also true of NaN
        row = int(np.flatnonzero(~(np.abs(excess) <= UNIT_TOLERANCE))[0])
        raise InvalidParameterError(f"{name} must be finite vectors of length 1, but one is {block[row].tolist()}")
    if max(-low, high) > 1.0e-15:
        # 1/sqrt(1 + e) to third order: exact to 1e-13 for the largest e allowed, without a square root or division.
        components *= 1.0 + excess * (-0.5 + excess * (0.375 - 0.3125 * excess))
    return components


@dataclass(frozen=True, slots=True, eq=False)
class ReflectionGeometry:
    """What the reflection laws need to know of one block of B rays, in float64.

    Rows whose bisector is nearly zero (light and viewer both grazing, opposite each other) hold
    `tangential` and the squares multiplied by a power of two, ``2**exponent``, so that squares stay in range.

    Parameters
    ----------
    normal : ndarray (3, B)
        Unit normals.
    to_light, to_viewer : ndarray (3, B)
        Unit vectors.
    normal_light, normal_viewer : ndarray (B,)
        N.L and N.V.
    tangential : ndarray (3, B)
        The part of L + V across the normal, times 2**exponent.
    tangential_squared : ndarray (B,)
        Its squared length.
    bisector_squared : ndarray (B,)
        |L + V|^2, times 4**exponent.
    exponent : ndarray (B,) of int, or None
        None stands for zero everywhere.
    """

    normal: Float64
    to_light: Float64
    to_viewer: Float64
    normal_light: Float64
    normal_viewer: Float64
    tangential: Float64
    tangential_squared: Float64
    bisector_squared: Float64
    exponent: NDArray[np.int32] | None

    @property
    def visible(self) -> NDArray[np.bool_]:
        """Rows where both the light and the viewer stand above the surface.

        Returns
        -------
        ndarray of bool (B,)
            True where N.L > 0 and N.V > 0.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return (self.normal_light > 0.0) & (self.normal_viewer > 0.0)

    def scaled_cosines(self) -> tuple[Float64, Float64]:
        """Give N.L and N.V with the scale of `bisector_squared`.

        Returns
        -------
        tuple of ndarray (B,)
            2**exponent times N.L and N.V.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        if self.exponent is None:
            return self.normal_light, self.normal_viewer
        return np.ldexp(self.normal_light, self.exponent), np.ldexp(self.normal_viewer, self.exponent)

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
        half = 0.5 * np.sqrt(self.bisector_squared)
        if self.exponent is not None:
            half = np.ldexp(half, -self.exponent)
        return np.minimum(half, 1.0)

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
        light, viewer = self.scaled_cosines()
        return np.arctan2(np.sqrt(self.tangential_squared), light + viewer)

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
        Own design: |S_t|^2 + (N.V - N.L)^2, derived at the head of this module.
        """
        squared = self.tangential_squared
        if self.exponent is not None:
            squared = np.ldexp(squared, -2 * self.exponent)
        difference = self.normal_viewer - self.normal_light
        return np.asarray(squared + difference * difference)

    def mirror_sum_squared(self) -> Float64:
        """Square of the length of the mirrored light plus the viewer, |R + V|^2.

        Returns
        -------
        ndarray (B,)
            0 to 4; together with the chord it gives rho = 2 atan2(|R - V|, |R + V|) at full accuracy.

        Raises
        ------
        None.

        References
        ----------
        Own design: R + V = (N.L + N.V) N + (V - L)_t.
        """
        across = self.to_viewer - self.to_light
        across -= (self.normal_viewer - self.normal_light) * self.normal
        across *= across
        total = self.normal_viewer + self.normal_light
        return np.asarray(across[0] + across[1] + across[2] + total * total)


def reflection_geometry(normal: Float64, to_light: Float64, to_viewer: Float64) -> ReflectionGeometry:
    """Derive the numbers of the reflection laws for one block of rays.

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
    n, light, viewer = normal, to_light, to_viewer
    normal_light = n[0] * light[0] + n[1] * light[1] + n[2] * light[2]
    normal_viewer = n[0] * viewer[0] + n[1] * viewer[1] + n[2] * viewer[2]
    total = normal_light + normal_viewer
    bisector = light + viewer
    tangential = bisector - total * n
    tangential_squared = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    bisector_squared = tangential_squared + total * total
    exponent: NDArray[np.int32] | None = None
    small = np.flatnonzero((bisector_squared < SMALL_BISECTOR**2) & (normal_light > 0.0) & (normal_viewer > 0.0))
    if small.size:
        # Both graze, opposite each other: scale the bisector to order one (exact, a power of two).
        largest = np.abs(bisector[:, small]).max(axis=0)
        raise_by = -np.frexp(np.maximum(largest, total[small]))[1]
        exponent = np.zeros(total.shape, np.int32)
        exponent[small] = raise_by
        scaled_total = np.ldexp(normal_light[small], raise_by) + np.ldexp(normal_viewer[small], raise_by)
        part = np.ldexp(bisector[:, small], raise_by) - scaled_total * n[:, small]
        squared = part[0] ** 2 + part[1] ** 2 + part[2] ** 2
        tangential[:, small] = part
        tangential_squared[small] = squared
        bisector_squared[small] = squared + scaled_total**2
    return ReflectionGeometry(
        n, light, viewer, normal_light, normal_viewer, tangential, tangential_squared, bisector_squared, exponent
    )


def geometry_blocks(
    normal: NDArray[Any], to_light: NDArray[Any], to_viewer: NDArray[Any]
) -> Iterator[tuple[slice, ReflectionGeometry]]:
    """Split rays (N, 3), already broadcast to one shape, into checked blocks."""
    rows = normal.shape[0]
    for start in range(0, rows, BLOCK_ROWS):
        block = slice(start, min(start + BLOCK_ROWS, rows))
        yield (
            block,
            reflection_geometry(
                unit_components("normal", normal[block]),
                unit_components("to_light", to_light[block]),
                unit_components("to_viewer", to_viewer[block]),
            ),
        )
