"""Resampling that does not alias: points where the data are coarser than the grid, averages where they are finer.

Reading 0.4 nm data at every fifth nanometre would keep one sample in twelve, and a lamp's line would appear or vanish
with its position. So where samples stand closer than the grid, each grid point takes the average of the spectrum
under a triangle as wide (at half height) as the step: the band-pass of a spectrometer that scans with that step.
The average is exact for the piecewise polynomial that the spectrum is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError
from .spectra import LARGEST_VALUE, Spectrum
from .validation import require_finite

__all__ = ["Resampling", "resample"]

# Gauss-Legendre on [0, 1], three points: exact to degree 5, and a cubic times the triangle's side has degree 4.
_GAUSS_PLACES = 0.5 + np.array([-0.5, 0.0, 0.5]) * np.sqrt(0.6)
_GAUSS_WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0


@dataclass(frozen=True, slots=True)
class Resampling:
    """A resampled spectrum and the account of how it was made.

    Parameters
    ----------
    spectrum : Spectrum
        The spectrum on the new wavelengths.
    method : {"points", "averages"}
        Whether the source was read at points or averaged under triangles.
    held_below, held_above : int
        How many of the new wavelengths lie below the first and above the last sample of the source and hold its value.
    notes : tuple of str
        The same in words; empty when the data were read at points within their range.
    """

    spectrum: Spectrum
    method: str
    held_below: int
    held_above: int
    notes: tuple[str, ...]


def resample(spectrum: Spectrum, wavelengths_nm: ArrayLike, *, name: str | None = None) -> Resampling:
    """Carry a spectrum to other wavelengths without aliasing, and say what was done beyond its ends.

    Parameters
    ----------
    spectrum : Spectrum
        The source.
    wavelengths_nm : array_like (M,)
        Wavelengths in nm, positive and strictly increasing; M >= 1.
    name : str, optional
        Name of the result; None keeps the source's.

    Returns
    -------
    Resampling
        The spectrum on `wavelengths_nm`, the method, and notes. A constant stays exactly constant, a straight line
        straight (away from the ends of the data); values beyond the data are the end values.

    Raises
    ------
    InvalidParameterError
        If the wavelengths are not finite, positive and strictly increasing.

    References
    ----------
    Triangular band-pass of half-width equal to the step: CIE 15:2004, 7.1; ASTM E308-18, section 7.
    """
    targets = np.atleast_1d(require_finite("wavelengths_nm", wavelengths_nm))
    if targets.ndim != 1 or targets.size == 0 or np.any(np.diff(targets) <= 0.0) or targets[0] <= 0.0:
        raise InvalidParameterError(
            f"wavelengths_nm must be positive and increase strictly, but is {np.array2string(targets, threshold=6)}"
        )
    source = spectrum.wavelengths_nm
    label = spectrum.name or "the spectrum"
    notes: list[str] = []
    step = _steps(targets)
    averaged = not spectrum.is_constant and targets.size > 1 and _is_finer(source, targets, step)
    if averaged:
        values = _triangle_averages(spectrum, targets, step)
        finest, coarsest = float(np.diff(source).min()), float(step.max())
        notes.append(f"{label}: samples as close as {finest:.4g} nm were averaged onto steps of {coarsest:.4g} nm")
    else:
        values = spectrum.at(targets)
    below = above = 0
    if not spectrum.is_constant:
        below = int(np.count_nonzero(targets < source[0]))
        above = int(np.count_nonzero(targets > source[-1]))
    first, last = spectrum.values[[0, -1]]
    if below:
        notes.append(
            f"{label}: data begin at {source[0]:g} nm; from {targets[0]:g} nm on their first value {first:.6g} is held"
        )
    if above:
        notes.append(
            f"{label}: data end at {source[-1]:g} nm; up to {targets[-1]:g} nm their last value {last:.6g} is held"
        )
    values = np.clip(values, -LARGEST_VALUE, LARGEST_VALUE)  # a cubic, or rounding, may pass the largest sample
    result = Spectrum(targets, values, spectrum.name if name is None else name, spectrum.interpolation, spectrum.signed)
    return Resampling(result, "averages" if averaged else "points", below, above, tuple(notes))


def _steps(targets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tell the grid's step at each of its points: half the distance between the two neighbours."""
    if targets.size == 1:
        return np.zeros(1)
    gaps = np.diff(targets)
    return 0.5 * (np.concatenate([gaps[:1], gaps]) + np.concatenate([gaps, gaps[-1:]]))


def _is_finer(source: NDArray[np.float64], targets: NDArray[np.float64], step: NDArray[np.float64]) -> bool:
    """Whether two samples within reach of the grid stand closer together than the grid's step there."""
    gaps = np.diff(source)
    middles = 0.5 * (source[1:] + source[:-1])
    reached = (source[1:] > targets[0] - step[0]) & (source[:-1] < targets[-1] + step[-1])
    return bool(np.any(reached & (gaps < np.interp(middles, targets, step) * (1.0 - 1e-6))))


def _triangle_averages(
    spectrum: Spectrum, targets: NDArray[np.float64], step: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Exact integral of the spectrum times a unit triangle of half-width `step` around each target."""
    low, high = targets - step, targets + step
    source = spectrum.wavelengths_nm
    inside = source[(source > low.min()) & (source < high.max())]
    edges = np.unique(np.concatenate([low, targets, high, inside]))
    start, length = edges[:-1], np.diff(edges)
    places = start[:, None] + length[:, None] * _GAUSS_PLACES
    peak = np.abs(spectrum.values).max()  # in units of the peak neither denormal nor huge values lose anything
    masses = spectrum.at(places) / peak * length[:, None] * _GAUSS_WEIGHTS
    # Every target owns the segments between its two feet: list the pairs (target, segment), then sum per target.
    first = np.searchsorted(edges, low)
    count = np.searchsorted(edges, high) - first
    owner = np.repeat(np.arange(targets.size), count)
    segment = np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
    height = 1.0 - np.abs(places[segment] - targets[owner, None]) / step[owner, None]
    sums = np.bincount(owner, weights=np.sum(masses[segment] * height, axis=1), minlength=targets.size)
    areas = np.bincount(
        owner, weights=np.sum(length[segment, None] * _GAUSS_WEIGHTS * height, axis=1), minlength=targets.size
    )
    return np.asarray(sums / areas * peak)
