"""The mean reflectance Sa(phi) of a metal that Eq. 13 interpolates with, from three kinds of knowledge.

Eq. 13 needs it only as w(phi) = (1 - Sa(phi)) / (1 - Sa(0)), the share of the coloured component; the constant one
gets t = 1 - w. All three classes therefore answer with w, computed from 1 - Sa without cancellation, as a function of
cos(phi), in which it is smooth up to grazing incidence.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..validation import require_in_range
from .angles import within
from .fresnel import MAX_INDEX, absorptance, conductor_absorptance
from .uniform_table import UniformTable

__all__ = [
    "MEAN_BAND_NM",
    "MeanReflectance",
    "MeasuredMeanReflectance",
    "OpticalMeanReflectance",
    "SchlickMeanReflectance",
]

Float64 = NDArray[np.float64]

MEAN_BAND_NM: Float64 = np.arange(400.0, 701.0, 5.0)
"""Wavelengths (61,) over which the paper takes means, 400 to 700 nm at 5 nm."""
MEAN_BAND_NM.flags.writeable = False

TABLE_INTERVALS = 2048
TABLE_TOLERANCE = 1.0e-9  # largest deviation from the exact mean that the table may show at its midpoints
EXACT_BLOCK = 4096


class MeanReflectance(ABC):
    """Sa(phi), the mean over wavelength of a metal's reflectance at incidence phi."""

    __slots__ = ()

    @property
    @abstractmethod
    def normal_absorptance(self) -> float:
        """1 - Sa(0).

        Returns
        -------
        float
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """

    @abstractmethod
    def _ratio(self, cosine: Float64) -> Float64:
        """W for cosines in [0, 1], where 1 - Sa(0) > 0."""

    def interface_weight(self, cos_incidence: ArrayLike) -> NDArray[Any]:
        """Weight of the coloured component in Eq. 13, w = (1 - Sa(phi)) / (1 - Sa(0)).

        Parameters
        ----------
        cos_incidence : array_like
            Cosine of the incidence on the facet, 0 to 1, any shape.

        Returns
        -------
        ndarray of float64
            Not negative; above 1 where the metal reflects less than at normal incidence. 1 everywhere if Sa(0) = 1.

        Raises
        ------
        InvalidParameterError
            If a cosine lies outside its range.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return self.weight_of_checked(require_in_range("cos_incidence", cos_incidence, 0.0, 1.0))

    def weight_of_checked(self, cosine: Float64) -> Float64:
        """Give the weight for cosines that are known to lie between 0 and 1 (the inner loop of shading).

        Parameters
        ----------
        cosine : ndarray of float64
            0 to 1, any shape.

        Returns
        -------
        ndarray of float64
            As :meth:`interface_weight`.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return self._ratio(cosine) if self.normal_absorptance > 0.0 else np.ones_like(cosine)

    def at(self, incidence: ArrayLike) -> NDArray[Any]:
        """Mean reflectance Sa at an incidence.

        Parameters
        ----------
        incidence : array_like
            Angle in radians, 0 to pi/2, any shape.

        Returns
        -------
        ndarray of float64
            0 to 1.

        Raises
        ------
        InvalidParameterError
            If an angle lies outside its range.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        angle = within("incidence", incidence, 0.0, np.pi / 2)
        # sin of the complement: exactly 0 at a right angle, where cos leaves 6e-17.
        weight = self.interface_weight(np.sin(np.pi / 2 - angle))
        return np.clip(1.0 - weight * self.normal_absorptance, 0.0, 1.0)


def _sorted_copy(name: str, value: ArrayLike, low: float, high: float) -> Float64:
    array = np.array(require_in_range(name, value, low, high), ndmin=1)
    array.flags.writeable = False
    return array


def _hermite(nodes: Float64, values: Float64, slopes: Float64, index: NDArray[np.intp], x: Float64) -> Float64:
    """Cubic Hermite interpolation in the given intervals."""
    left = nodes[index]
    width = nodes[index + 1] - left
    u = (x - left) / width
    v = 1.0 - u
    return np.asarray(
        v * v * ((1.0 + 2.0 * u) * values[index] + u * width * slopes[index])
        + u * u * ((1.0 + 2.0 * v) * values[index + 1] - v * width * slopes[index + 1])
    )


@dataclass(frozen=True, slots=True, eq=False)
class OpticalMeanReflectance(MeanReflectance):
    """Sa(phi) from optical constants: the mean of the Fresnel reflectance over the given wavelengths.

    Evaluated from a table in cos(phi) with cubic interpolation, checked against the exact mean when made; where the
    table cannot follow (total reflection has a corner) each value is computed exactly instead.

    Parameters
    ----------
    n, k : array_like (W,)
        Refractive index and extinction coefficient at wavelengths of equal weight, 0 to 1e6, n + k > 0.
    """

    n: Float64
    k: Float64
    _normal: float = field(init=False, repr=False)
    _table: UniformTable | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n, k = _sorted_copy("n", self.n, 0.0, MAX_INDEX), _sorted_copy("k", self.k, 0.0, MAX_INDEX)
        if n.ndim != 1 or n.shape != k.shape:
            raise InvalidParameterError(
                f"n and k must be lists of one length, but have the shapes {n.shape}, {k.shape}"
            )
        object.__setattr__(self, "n", n)
        object.__setattr__(self, "k", k)
        object.__setattr__(self, "_normal", float(np.mean(absorptance(1.0, n, k))))
        object.__setattr__(self, "_table", None)
        if self._normal > 0.0:
            cosines = np.linspace(0.0, 1.0, 2 * TABLE_INTERVALS + 1)
            exact = self._exact(cosines)
            table = UniformTable(exact[::2])
            if np.abs(table.read(cosines[1::2]) - exact[1::2]).max() <= TABLE_TOLERANCE:
                object.__setattr__(self, "_table", table)

    @property
    def normal_absorptance(self) -> float:
        """1 - Sa(0).

        Returns
        -------
        float
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return self._normal

    def _exact(self, cosine: Float64) -> Float64:
        flat = cosine.reshape(-1)
        out = np.empty(flat.shape)
        for start in range(0, flat.size, EXACT_BLOCK):
            part = flat[start : start + EXACT_BLOCK, None]
            out[start : start + EXACT_BLOCK] = conductor_absorptance(part, self.n, self.k).mean(axis=1)
        return out.reshape(cosine.shape) / self._normal

    def _ratio(self, cosine: Float64) -> Float64:
        if self._table is None:
            return self._exact(cosine)
        return np.maximum(self._table.read(cosine), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredMeanReflectance(MeanReflectance):
    """Sa(phi) from a table of measurements at several incidences.

    Between the measurements 1 - Sa is read by a monotone cubic in cos(phi), so that no false maxima appear. The first
    value is held down to normal incidence (reflectance is even in phi, so its slope vanishes there); beyond the last
    one the curve goes on to Sa = 1 at grazing incidence, as every smooth surface does.

    Parameters
    ----------
    incidence : array_like (A,)
        Angles in radians, strictly increasing, 0 to pi/2. A >= 1.
    mean : array_like (A,)
        Mean reflectance over wavelength at those angles, 0 to 1; 1 at pi/2 if that angle is given.
    """

    incidence: Float64
    mean: Float64
    _nodes: Float64 = field(init=False, repr=False)
    _values: Float64 = field(init=False, repr=False)
    _slopes: Float64 = field(init=False, repr=False)

    def __post_init__(self) -> None:
        angle = np.array(within("incidence", self.incidence, 0.0, np.pi / 2), ndmin=1)
        angle.flags.writeable = False
        mean = _sorted_copy("mean", self.mean, 0.0, 1.0)
        if angle.ndim != 1 or angle.shape != mean.shape or angle.size == 0:
            raise InvalidParameterError(
                f"incidence and mean must be lists of one length, but have the shapes {angle.shape}, {mean.shape}"
            )
        if np.any(np.diff(angle) <= 0.0):
            at = int(np.flatnonzero(np.diff(angle) <= 0.0)[0])
            raise InvalidParameterError(
                f"incidence must increase strictly: {angle[at + 1]:g} rad follows {angle[at]:g}"
            )
        cosine = np.sin(np.pi / 2 - angle)
        nodes, absorbed = cosine[::-1], (1.0 - mean)[::-1]
        if nodes[0] > 0.0:
            nodes, absorbed = np.append(0.0, nodes), np.append(0.0, absorbed)
        elif absorbed[0] != 0.0:
            raise InvalidParameterError(f"mean must be 1 at the incidence pi/2, but is {1.0 - absorbed[0]:g}")
        if nodes[-1] < 1.0:
            nodes, absorbed = np.append(nodes, 1.0), np.append(absorbed, absorbed[-1])
        if np.any(np.diff(nodes) <= 0.0):
            raise InvalidParameterError("incidence must be spaced so that the cosines differ (about 1e-8 rad near 0)")
        object.__setattr__(self, "incidence", angle)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "_nodes", nodes)
        object.__setattr__(self, "_values", absorbed)
        object.__setattr__(self, "_slopes", _monotone_slopes(nodes, absorbed))

    @property
    def normal_absorptance(self) -> float:
        """1 - Sa(0).

        Returns
        -------
        float
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return float(self._values[-1])

    def _ratio(self, cosine: Float64) -> Float64:
        index = np.clip(np.searchsorted(self._nodes, cosine, side="right") - 1, 0, self._nodes.size - 2)
        value = _hermite(self._nodes, self._values, self._slopes, index, cosine)
        return np.maximum(value, 0.0) / self.normal_absorptance


def _monotone_slopes(x: Float64, y: Float64) -> Float64:
    """Slopes of a shape-preserving cubic: weighted harmonic means (Fritsch & Butland 1984, SIAM J. Sci. Stat. 5)."""
    h, rise = np.diff(x), np.diff(y) / np.diff(x)
    slopes = np.empty_like(y)
    slopes[0], slopes[-1] = rise[0], rise[-1]
    if x.size > 2:
        left, right = rise[:-1], rise[1:]
        w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
        same = left * right > 0.0
        safe_left, safe_right = np.where(same, left, 1.0), np.where(same, right, 1.0)
        slopes[1:-1] = np.where(same, (w1 + w2) / (w1 / safe_left + w2 / safe_right), 0.0)
    return slopes


@dataclass(frozen=True, slots=True, eq=False)
class SchlickMeanReflectance(MeanReflectance):
    """Sa(phi) when only the reflectance at normal incidence is known: Sa(0) + (1 - Sa(0))(1 - cos phi)^5.

    The weight of Eq. 13 is then w = 1 - (1 - cos phi)^5, whatever Sa(0) below 1.

    Parameters
    ----------
    normal_mean : float
        Sa(0), 0 to 1.
    """

    normal_mean: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal_mean", float(require_in_range("normal_mean", self.normal_mean, 0.0, 1.0)))

    @property
    def normal_absorptance(self) -> float:
        """1 - Sa(0).

        Returns
        -------
        float
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return 1.0 - self.normal_mean

    def _ratio(self, cosine: Float64) -> Float64:
        # 1 - (1 - c)^5 = c (5 - 10 c + 10 c^2 - 5 c^3 + c^4): full relative accuracy at grazing incidence.
        c = cosine
        return np.minimum(c * (5.0 + c * (-10.0 + c * (10.0 + c * (-5.0 + c)))), 1.0)
