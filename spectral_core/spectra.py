"""Spectra: samples over wavelength, how they are read between samples, and the formulas that make some.

A :class:`Spectrum` is what every lamp, paint and metal of the package is made of. Its samples may stand at any
strictly increasing wavelengths; what a reader gets beyond the ends is the end value.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import tables
from .errors import InvalidParameterError
from .interpolation import interpolate
from .validation import require_choice, require_finite, require_in_range

__all__ = [
    "LARGEST_VALUE",
    "REFERENCE_WAVELENGTHS_NM",
    "Spectrum",
    "blackbody",
    "daylight",
    "gaussian",
    "require_not_negative",
]

REFERENCE_WAVELENGTHS_NM: NDArray[np.float64] = np.arange(360.0, 831.0)
"""The wavelengths (471,) of the CIE tables, 360 to 830 nm at 1 nm, on which all integrals of the package are done."""
REFERENCE_WAVELENGTHS_NM.flags.writeable = False

LARGEST_VALUE = 1e100
"""The largest size of a value; so that cubic weights and products of three spectra cannot overflow."""

PLANCK_SECOND_CONSTANT_NM_K = 1.438776877e7  # h c / k of the 2019 SI, in nm K


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Spectrum:
    """A spectrum: values at strictly increasing wavelengths, held constant beyond the ends.

    Two spectra are equal when they have the same samples and interpolation (constants: the same value, wherever
    their samples stand); the name does not count.

    Parameters
    ----------
    wavelengths_nm : array_like (W,)
        Wavelengths in nm, finite, positive, strictly increasing; W >= 1.
    values : array_like (W,)
        Values at most 1e100 in size, not negative unless `signed`. Reflectance 0 to 1, relative power, or whatever is
        meant.
    name : str
        For messages and panels.
    interpolation : {"linear", "lagrange"}
        How values between samples are read.
    signed : bool
        Whether negative values are allowed (components of a fit, differences).
    """

    wavelengths_nm: NDArray[np.float64]
    values: NDArray[np.float64]
    name: str = ""
    interpolation: str = "linear"
    signed: bool = False
    _key: bytes = field(init=False, repr=False)

    def __post_init__(self) -> None:
        label = f"spectrum {self.name!r}" if self.name else "spectrum"
        wavelengths = np.array(require_finite(f"wavelengths of {label}", self.wavelengths_nm), ndmin=1)
        values = np.array(require_finite(f"values of {label}", self.values), ndmin=1) + 0.0  # -0.0 becomes 0.0
        require_choice(f"interpolation of {label}", self.interpolation, ("linear", "lagrange"))
        if wavelengths.ndim != 1 or wavelengths.size == 0:
            raise InvalidParameterError(
                f"wavelengths of {label} must be a list of at least one, not {wavelengths.shape}"
            )
        if values.shape != wavelengths.shape:
            raise InvalidParameterError(
                f"values of {label} must be as many as its wavelengths, {wavelengths.size}, but have the shape "
                f"{values.shape}"
            )
        if wavelengths[0] <= 0.0:
            raise InvalidParameterError(f"wavelengths of {label} must be positive, but one is {wavelengths[0]:g} nm")
        falls = np.flatnonzero(np.diff(wavelengths) <= 0.0)
        if falls.size:
            at = int(falls[0])
            raise InvalidParameterError(
                f"wavelengths of {label} must increase strictly: {wavelengths[at + 1]} nm follows {wavelengths[at]} nm"
            )
        if np.abs(values).max() > LARGEST_VALUE:
            at = int(np.argmax(np.abs(values)))
            raise InvalidParameterError(
                f"values of {label} must be at most {LARGEST_VALUE:g} in size, but at {wavelengths[at]:g} nm it is "
                f"{values[at]:.6g}"
            )
        if not self.signed and values.min() < 0.0:
            at = int(np.flatnonzero(values < 0.0)[0])
            raise InvalidParameterError(
                f"values of {label} must not be negative, but at {wavelengths[at]:g} nm it is {values[at]:.6g}"
            )
        wavelengths.flags.writeable = False
        values.flags.writeable = False
        object.__setattr__(self, "wavelengths_nm", wavelengths)
        object.__setattr__(self, "values", values)
        digest = hashlib.blake2b(digest_size=16)
        if np.all(values == values[0]):
            digest.update(b"constant" + values[:1].tobytes())
        else:
            digest.update(self.interpolation.encode() + wavelengths.tobytes() + values.tobytes())
        object.__setattr__(self, "_key", digest.digest())

    @classmethod
    def constant(cls, value: float, name: str = "") -> Spectrum:
        """Make the spectrum that has one value at every wavelength.

        Parameters
        ----------
        value : float
            The value, finite and not negative.
        name : str, optional
            For messages and panels.

        Returns
        -------
        Spectrum
            A spectrum of a single sample at 560 nm, which is held constant everywhere.

        Raises
        ------
        InvalidParameterError
            If the value is negative or not finite.

        References
        ----------
        Own design.
        """
        return cls(np.array([560.0]), np.array([value], dtype=np.float64), name)

    @property
    def key(self) -> bytes:
        """Digest (16 bytes) of the content without the name; equal spectra have equal keys.

        Returns
        -------
        bytes
            The digest.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return self._key

    @property
    def is_constant(self) -> bool:
        """Whether the spectrum has the same value at every wavelength.

        Returns
        -------
        bool
            True when all samples are equal.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return bool(np.all(self.values == self.values[0]))

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        if self.is_constant:
            return f"Spectrum({label}constant {self.values[0]:.6g})"
        first, last = self.wavelengths_nm[[0, -1]]
        return f"Spectrum({label}{self.values.size} samples, {first:g} to {last:g} nm, {self.interpolation})"

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, Spectrum) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def at(self, wavelengths_nm: ArrayLike) -> NDArray[np.float64]:
        """Read the spectrum at wavelengths, as a function of points (see ``resampling.resample`` for averages).

        Parameters
        ----------
        wavelengths_nm : array_like
            Wavelengths in nm, any shape, finite.

        Returns
        -------
        ndarray of float64
            Values, in the shape of `wavelengths_nm`; the end values beyond the samples. Where a cubic passes below
            zero beside a steep flank, a spectrum that is not signed gives 0.

        Raises
        ------
        InvalidParameterError
            If a wavelength is not finite.

        References
        ----------
        CIE 15:2004, 7.2 (interpolation and extrapolation).
        """
        if self.is_constant:  # interpolation weights sum to 1 only within rounding
            return np.full(require_finite("wavelengths_nm", wavelengths_nm).shape, self.values[0])
        values = interpolate(self.wavelengths_nm, self.values, wavelengths_nm, self.interpolation)
        return values if self.signed else np.maximum(values, 0.0)

    def scaled(self, factor: float, name: str | None = None) -> Spectrum:
        """Multiply the spectrum by a number.

        Parameters
        ----------
        factor : float
            Finite; not negative unless the spectrum is signed.
        name : str, optional
            Name of the result; None keeps the name.

        Returns
        -------
        Spectrum
            The same wavelengths with the values times `factor`.

        Raises
        ------
        InvalidParameterError
            If the factor is not finite or makes a value that the spectrum does not allow.

        References
        ----------
        Own design.
        """
        values = self.values * float(require_finite("factor", factor))
        return Spectrum(
            self.wavelengths_nm, values, self.name if name is None else name, self.interpolation, self.signed
        )


def require_not_negative(name: str, spectrum: Spectrum) -> None:
    """Raise when a thing is no spectrum, or holds a negative value, as a signed one may.

    Parameters
    ----------
    name : str
        What the spectrum is called in the error.
    spectrum : Spectrum
        The spectrum.

    Raises
    ------
    InvalidParameterError
        If it is no spectrum, or a value is negative.

    References
    ----------
    Own design.
    """
    if not isinstance(spectrum, Spectrum):
        raise InvalidParameterError(f"{name} must be a Spectrum, but is {spectrum!r}")
    lowest = int(np.argmin(spectrum.values))
    if spectrum.values[lowest] < 0.0:
        raise InvalidParameterError(
            f"{name} must not be negative, but at {spectrum.wavelengths_nm[lowest]:g} nm it is "
            f"{spectrum.values[lowest]:.6g}"
        )


def blackbody(temperature_k: float, name: str = "") -> Spectrum:
    """Relative spectrum of a Planckian radiator.

    Parameters
    ----------
    temperature_k : float
        Absolute temperature in K, at least 1.
    name : str, optional
        Name of the result; by default it tells the temperature.

    Returns
    -------
    Spectrum
        360 to 830 nm at 1 nm, the largest value 1 (a scale that stays finite at every temperature).

    Raises
    ------
    InvalidParameterError
        If the temperature is not finite or below 1 K.

    References
    ----------
    Planck's law with c2 = 1.438776877e-2 m K (CODATA 2018); evaluated in logarithms, so that cold radiators
    neither overflow nor lose digits.
    """
    temperature = float(require_in_range("temperature_k", temperature_k, 1.0, unit="K"))
    wavelengths = REFERENCE_WAVELENGTHS_NM
    x = PLANCK_SECOND_CONSTANT_NM_K / wavelengths / temperature
    logarithm = -5.0 * np.log(wavelengths) - x - np.log(-np.expm1(-x))
    return Spectrum(wavelengths, np.exp(logarithm - logarithm.max()), name or f"blackbody {temperature:g} K")


def daylight(temperature_k: float, name: str = "") -> Spectrum:
    """Relative spectrum of a CIE daylight phase.

    Parameters
    ----------
    temperature_k : float
        Correlated colour temperature in K, 4000 to 25000 on the present temperature scale. The nominal 6500 K of D65
        is 6500 * 1.4388 / 1.4380 = 6503.6 K on it.
    name : str, optional
        Name of the result; by default it tells the temperature.

    Returns
    -------
    Spectrum
        300 to 830 nm at 5 nm, linear between samples as the CIE prescribes, 100 at 560 nm.

    Raises
    ------
    InvalidParameterError
        If the temperature lies outside the range in which daylight phases are defined.

    References
    ----------
    CIE 15:2004, 3.1 and appendix C (components S0, S1, S2; M1 and M2 rounded to three decimals).
    """
    t = float(require_in_range("temperature_k", temperature_k, 4000.0, 25000.0, unit="K"))
    u = 1.0e3 / t
    if t <= 7000.0:
        x = ((-4.6070 * u + 2.9678) * u + 0.09911) * u + 0.244063
    else:
        x = ((-2.0064 * u + 1.9018) * u + 0.24748) * u + 0.237040
    y = (-3.000 * x + 2.870) * x - 0.275
    m = 0.0241 + 0.2562 * x - 0.7341 * y
    m1 = round((-1.3515 - 1.7703 * x + 5.9114 * y) / m, 3)
    m2 = round((0.0300 - 31.4424 * x + 30.0717 * y) / m, 3)
    wavelengths, components = tables.table("daylight/S")
    values = components[0] + m1 * components[1] + m2 * components[2]
    return Spectrum(wavelengths, np.maximum(values, 0.0), name or f"daylight {t:g} K")


def gaussian(centre_nm: float, full_width_nm: float, peak: float = 1.0, base: float = 0.0, name: str = "") -> Spectrum:
    """Gaussian band on a constant base, from a laser line to a broad paint.

    Parameters
    ----------
    centre_nm : float
        Wavelength of the peak in nm, positive.
    full_width_nm : float
        Full width at half maximum in nm, from 1e-3 to 1000.
    peak, base : float
        Value at the centre and far from it, not negative. A base above the peak makes a dip.
    name : str, optional
        Name of the result; by default it tells centre and width.

    Returns
    -------
    Spectrum
        Samples every 1/32 of the width within three widths of the centre, where the band has fallen to 1.5e-11.

    Raises
    ------
    InvalidParameterError
        If a parameter lies outside its range.

    References
    ----------
    Own design.
    """
    centre = float(require_in_range("centre_nm", centre_nm, 1.0, 1.0e5, unit="nm"))
    width = float(require_in_range("full_width_nm", full_width_nm, 1.0e-3, 1.0e3, unit="nm"))
    top = float(require_in_range("peak", peak, 0.0))
    floor = float(require_in_range("base", base, 0.0))
    steps = np.arange(-96, 97) / 32.0
    shape = np.exp(-4.0 * np.log(2.0) * steps * steps)
    shape[[0, -1]] = 0.0
    wavelengths = centre + steps * width
    keep = wavelengths > 0.0
    values = floor + (top - floor) * shape
    return Spectrum(wavelengths[keep], values[keep], name or f"band at {centre:g} nm, {width:g} nm wide")
