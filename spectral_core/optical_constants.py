"""Optical constants: the complex refractive index n + ik of a metal or a glass over wavelength."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError
from .interpolation import interpolate
from .validation import require_in_range

__all__ = ["OpticalConstants"]


@dataclass(frozen=True, slots=True, eq=False)
class OpticalConstants:
    """Index of refraction n and extinction coefficient k at strictly increasing wavelengths.

    Parameters
    ----------
    wavelengths_nm : array_like (W,)
        Wavelengths in nm, positive, strictly increasing; W >= 1.
    n : array_like (W,)
        Index of refraction, positive.
    k : array_like (W,)
        Extinction coefficient, not negative; 0 for a transparent material.
    name, source, comment : str
        What it is, who measured it, and on what sample.
    """

    wavelengths_nm: NDArray[np.float64]
    n: NDArray[np.float64]
    k: NDArray[np.float64]
    name: str = ""
    source: str = ""
    comment: str = ""

    def __post_init__(self) -> None:
        label = f"of {self.name!r}" if self.name else "of the optical constants"
        wavelengths = np.array(require_in_range(f"wavelengths {label}", self.wavelengths_nm, 0.0, unit="nm"), ndmin=1)
        n = np.array(require_in_range(f"n {label}", self.n, 0.0), ndmin=1)
        k = np.array(require_in_range(f"k {label}", self.k, 0.0), ndmin=1)
        if wavelengths.ndim != 1 or wavelengths.size == 0 or n.shape != wavelengths.shape or k.shape != n.shape:
            raise InvalidParameterError(
                f"wavelengths, n and k {label} must be lists of one length, but have the shapes "
                f"{wavelengths.shape}, {n.shape} and {k.shape}"
            )
        if np.any(n == 0.0):
            raise InvalidParameterError(f"n {label} must be positive, but one is 0")
        falls = np.flatnonzero(np.diff(wavelengths) <= 0.0)
        if falls.size:
            at = int(falls[0])
            raise InvalidParameterError(
                f"wavelengths {label} must increase strictly: {wavelengths[at + 1]} nm follows {wavelengths[at]} nm"
            )
        for field, array in (("wavelengths_nm", wavelengths), ("n", n), ("k", k)):
            array.flags.writeable = False
            object.__setattr__(self, field, array)

    def at(self, wavelengths_nm: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Read n and k at wavelengths, linearly between samples and held constant beyond the ends.

        Parameters
        ----------
        wavelengths_nm : array_like
            Wavelengths in nm, any shape, finite.

        Returns
        -------
        n, k : ndarray of float64
            In the shape of `wavelengths_nm`.

        Raises
        ------
        InvalidParameterError
            If a wavelength is not finite.

        References
        ----------
        Own design.
        """
        return (
            interpolate(self.wavelengths_nm, self.n, wavelengths_nm),
            interpolate(self.wavelengths_nm, self.k, wavelengths_nm),
        )
