"""From spectra to colour: observers, weighting tables, tristimulus values, chromaticity, Lab and differences.

All integrals are sums at 1 nm from 360 to 830 nm. A renderer that samples reflectance at fewer wavelengths uses a
weighting table: the integral of observer times lamp with every interpolation weight folded in, so that nothing of the
lamp (a mercury line, say) can fall between the samples. Its weights may be negative and are never clipped.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import tables
from .errors import InvalidParameterError
from .interpolation import interpolation_matrix
from .resampling import resample
from .spectra import REFERENCE_WAVELENGTHS_NM, Spectrum
from .validation import require_choice, require_finite, require_shape

__all__ = [
    "ADAPTATIONS",
    "GRID_PRESETS",
    "OBSERVERS",
    "Observer",
    "WavelengthGrid",
    "chromatic_adaptation",
    "delta_e_2000",
    "lab",
    "observer",
    "tristimulus",
    "tristimulus_from_xy",
    "tristimulus_weights",
    "uv",
    "wavelength_grid",
    "white_point",
    "xy",
]

OBSERVERS = ("cie_1931_2", "cie_1964_10")
"""The CIE standard observers: 1931 (2 degrees) and 1964 (10 degrees)."""

GRID_PRESETS = ("exact", "reference", "paper", "high", "standard", "draft")
"""Wavelength grids, from the 471 samples of the integration itself down to 8."""

ADAPTATIONS = ("none", "bradford", "cat16")
"""Chromatic adaptations."""

_STANDARD_NODES = (416, 436, 452, 467, 486, 507, 526, 541, 551, 566, 582, 597, 613, 626, 648, 685)
_DRAFT_NODES = (433, 457, 484, 518, 546, 578, 609, 643)

_CONE_MATRICES = {
    # Lam, Metamerism and Colour Constancy, PhD thesis, University of Bradford, 1985; as given in CIE 159:2004.
    "bradford": ((0.8951, 0.2664, -0.1614), (-0.7502, 1.7135, 0.0367), (0.0389, -0.0685, 1.0296)),
    # Li et al., Comprehensive color solutions: CAM16, CAT16, and CAM16-UCS, Color Res. Appl. 42, 2017.
    "cat16": ((0.401288, 0.650173, -0.051461), (-0.250268, 1.204414, 0.045854), (-0.002079, 0.048952, 0.953127)),
}


@dataclass(frozen=True, slots=True, eq=False)
class Observer:
    """Colour-matching functions of an observer at the reference wavelengths.

    Parameters
    ----------
    name : str
        One of :data:`OBSERVERS`, or any name of one's own.
    wavelengths_nm : ndarray (471,)
        360 to 830 nm at 1 nm.
    matching_functions : ndarray (471, 3)
        The functions x, y, z.
    """

    name: str
    wavelengths_nm: NDArray[np.float64]
    matching_functions: NDArray[np.float64]

    def __post_init__(self) -> None:
        wavelengths = require_finite("wavelengths_nm", self.wavelengths_nm)
        functions = np.array(require_finite("matching_functions", self.matching_functions))
        if not np.array_equal(wavelengths, REFERENCE_WAVELENGTHS_NM):
            raise InvalidParameterError(f"wavelengths_nm of observer {self.name!r} must be 360 to 830 nm at 1 nm")
        require_shape("matching_functions", functions, (wavelengths.size, 3))
        functions.flags.writeable = False
        object.__setattr__(self, "wavelengths_nm", REFERENCE_WAVELENGTHS_NM)
        object.__setattr__(self, "matching_functions", functions)


@dataclass(frozen=True, slots=True, eq=False)
class WavelengthGrid:
    """The wavelengths at which reflectances are sampled, and how they are read between.

    Parameters
    ----------
    name : str
        One of :data:`GRID_PRESETS`, or any name of one's own.
    wavelengths_nm : array_like (W,)
        Wavelengths in nm, strictly increasing, W >= 1.
    method : {"exact", "lagrange", "spline", "linear"}
        Interpolation that the weighting table assumes; "exact" only for the reference wavelengths themselves.
    """

    name: str
    wavelengths_nm: NDArray[np.float64]
    method: str

    def __post_init__(self) -> None:
        require_choice("method", self.method, ("exact", "lagrange", "spline", "linear"))
        nodes = np.array(require_finite("wavelengths_nm", self.wavelengths_nm), ndmin=1)
        if nodes.ndim != 1 or nodes.size == 0 or np.any(np.diff(nodes) <= 0.0):
            raise InvalidParameterError(f"wavelengths_nm of grid {self.name!r} must be a list that increases strictly")
        if self.method == "exact" and not np.array_equal(nodes, REFERENCE_WAVELENGTHS_NM):
            raise InvalidParameterError(f"method 'exact' of grid {self.name!r} needs 360 to 830 nm at 1 nm")
        nodes.flags.writeable = False
        object.__setattr__(self, "wavelengths_nm", nodes)


@lru_cache(maxsize=len(OBSERVERS))
def observer(name: str) -> Observer:
    """Fetch a CIE standard observer.

    Parameters
    ----------
    name : {"cie_1931_2", "cie_1964_10"}
        Which one.

    Returns
    -------
    Observer
        Its matching functions, 360 to 830 nm at 1 nm.

    Raises
    ------
    InvalidParameterError
        If the name is unknown.

    References
    ----------
    ISO/CIE 11664-1:2019.
    """
    require_choice("observer", name, OBSERVERS)
    wavelengths, curves = tables.table(f"observer/{name}")
    return Observer(name, wavelengths, curves.T)


@lru_cache(maxsize=len(GRID_PRESETS))
def wavelength_grid(name: str) -> WavelengthGrid:
    """Fetch a wavelength grid by its preset name.

    Parameters
    ----------
    name : {"exact", "reference", "paper", "high", "standard", "draft"}
        471 samples of 1 nm; 81 samples 380 to 780 nm at 5 nm; 61 samples 400 to 700 nm at 5 nm, as the paper has;
        31 samples 400 to 700 nm at 10 nm; 16 and 8 chosen wavelengths.

    Returns
    -------
    WavelengthGrid
        The grid.

    Raises
    ------
    InvalidParameterError
        If the name is unknown.

    References
    ----------
    Tominaga 1996, Applications (the 61 samples); own optimisation of the 16 and the 8 wavelengths.
    """
    require_choice("grid", name, GRID_PRESETS)
    nodes, method = {
        "exact": (REFERENCE_WAVELENGTHS_NM, "exact"),
        "reference": (np.arange(380.0, 781.0, 5.0), "lagrange"),
        "paper": (np.arange(400.0, 701.0, 5.0), "lagrange"),
        "high": (np.arange(400.0, 701.0, 10.0), "spline"),
        "standard": (np.array(_STANDARD_NODES, dtype=np.float64), "spline"),
        "draft": (np.array(_DRAFT_NODES, dtype=np.float64), "spline"),
    }[name]
    return WavelengthGrid(name, nodes, method)


@lru_cache(maxsize=64)
def _grid_matrix(nodes: bytes, method: str) -> NDArray[np.float64]:
    matrix = interpolation_matrix(np.frombuffer(nodes), REFERENCE_WAVELENGTHS_NM, method)
    matrix.flags.writeable = False
    return matrix


def _weighted_observer(illuminant: Spectrum, watcher: Observer) -> NDArray[np.float64]:
    """Observer times lamp at 1 nm (471, 3), scaled so that the y column sums to 1."""
    power = resample(illuminant, REFERENCE_WAVELENGTHS_NM).spectrum.values
    peak = power.max()
    label = illuminant.name or "the illuminant"
    if not peak > 0.0:
        raise InvalidParameterError(f"illuminant must emit light between 360 and 830 nm, but {label} emits none")
    weighted = watcher.matching_functions * (power / peak)[:, None]  # first to a peak of 1: no over- or underflow
    luminance = weighted[:, 1].sum()
    if not luminance > 0.0:
        raise InvalidParameterError(
            f"illuminant must emit visible light (Y > 0), but the Y of {label} is {luminance:g}"
        )
    return np.asarray(weighted / luminance)


def tristimulus_weights(illuminant: Spectrum, watcher: Observer, grid: WavelengthGrid) -> NDArray[np.float64]:
    """Compute the weighting table that turns sampled reflectances into tristimulus values.

    ``reflectances (..., W) @ weights (W, 3)`` is XYZ, with Y = 1 for the perfect diffuser (reflectance 1).

    Parameters
    ----------
    illuminant : Spectrum
        The lamp; any scale. Data finer than 1 nm are averaged, so that the narrowest line counts in full.
    watcher : Observer
        The observer.
    grid : WavelengthGrid
        Where reflectances are sampled.

    Returns
    -------
    ndarray of float64 (W, 3)
        The weights; negative ones are rightful and must not be clipped. The second column sums to 1.

    Raises
    ------
    InvalidParameterError
        If the illuminant emits no visible light.

    References
    ----------
    ASTM E2022-11 and ASTM E308-18 (weights as integrals of interpolation coefficients); CIE 15:2004, 7.1.
    """
    weighted = _weighted_observer(illuminant, watcher)
    if grid.method == "exact":
        return weighted
    return np.asarray(_grid_matrix(grid.wavelengths_nm.tobytes(), grid.method).T @ weighted)


def tristimulus(reflectance: Spectrum, illuminant: Spectrum, watcher: Observer) -> NDArray[np.float64]:
    """Tristimulus values of a surface under a lamp, summed at 1 nm.

    Parameters
    ----------
    reflectance : Spectrum
        Reflectance or radiance factor.
    illuminant : Spectrum
        The lamp; any scale.
    watcher : Observer
        The observer.

    Returns
    -------
    ndarray of float64 (3,)
        XYZ with Y = 1 for the perfect diffuser.

    Raises
    ------
    InvalidParameterError
        If the illuminant emits no visible light.

    References
    ----------
    CIE 15:2004, 7.1.
    """
    values = resample(reflectance, REFERENCE_WAVELENGTHS_NM).spectrum.values
    return np.asarray(values @ _weighted_observer(illuminant, watcher))


def white_point(illuminant: Spectrum, watcher: Observer) -> NDArray[np.float64]:
    """Tristimulus values of the perfect diffuser under a lamp.

    Parameters
    ----------
    illuminant : Spectrum
        The lamp; any scale.
    watcher : Observer
        The observer.

    Returns
    -------
    ndarray of float64 (3,)
        XYZ with Y = 1.

    Raises
    ------
    InvalidParameterError
        If the illuminant emits no visible light.

    References
    ----------
    CIE 15:2004, 7.1.
    """
    return np.asarray(_weighted_observer(illuminant, watcher).sum(axis=0))


def _triples(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = require_finite(name, value)
    if array.shape[-1:] != (3,):
        raise InvalidParameterError(f"{name} must have three values on the last axis, but has the shape {array.shape}")
    return array


def _ratio(numerator: NDArray[np.float64], denominator: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quotient that is NaN, without a warning, where black has no chromaticity."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(denominator == 0.0, np.nan, numerator / denominator)


def xy(xyz: ArrayLike) -> NDArray[np.float64]:
    """CIE 1931 chromaticity (or 1964, after the observer).

    Parameters
    ----------
    xyz : array_like (..., 3)
        Tristimulus values of any scale.

    Returns
    -------
    ndarray of float64 (..., 2)
        x and y; NaN where X + Y + Z is 0, for black has no chromaticity.

    Raises
    ------
    InvalidParameterError
        If a value is not finite or the last axis is not of length 3.

    References
    ----------
    CIE 15:2004, 7.3.
    """
    values = _triples("xyz", xyz)
    return _ratio(values[..., :2], values.sum(axis=-1, keepdims=True))


def uv(xyz: ArrayLike) -> NDArray[np.float64]:
    """CIE 1976 uniform chromaticity u', v'.

    Parameters
    ----------
    xyz : array_like (..., 3)
        Tristimulus values of any scale.

    Returns
    -------
    ndarray of float64 (..., 2)
        u' and v'; NaN where X + 15 Y + 3 Z is 0.

    Raises
    ------
    InvalidParameterError
        If a value is not finite or the last axis is not of length 3.

    References
    ----------
    CIE 15:2004, 8.1.
    """
    values = _triples("xyz", xyz)
    denominator = values @ np.array([1.0, 15.0, 3.0])
    return _ratio(values[..., :2] * np.array([4.0, 9.0]), denominator[..., None])


def tristimulus_from_xy(chromaticity: ArrayLike, luminance: ArrayLike = 1.0) -> NDArray[np.float64]:
    """Tristimulus values of a chromaticity at a luminance.

    Parameters
    ----------
    chromaticity : array_like (..., 2)
        x and y, with y not 0.
    luminance : array_like (...), optional
        Y.

    Returns
    -------
    ndarray of float64 (..., 3)
        XYZ.

    Raises
    ------
    InvalidParameterError
        If a value is not finite, the last axis is not of length 2, or y is 0.

    References
    ----------
    CIE 15:2004, 7.3.
    """
    values = require_finite("chromaticity", chromaticity)
    if values.shape[-1:] != (2,):
        raise InvalidParameterError(f"chromaticity must have two values on the last axis, but has {values.shape}")
    x, y = values[..., 0], values[..., 1]
    if np.any(y == 0.0):
        raise InvalidParameterError("chromaticity must have y other than 0, but one is 0")
    scale = require_finite("luminance", luminance) / y
    return np.stack([x * scale, y * scale, (1.0 - x - y) * scale], axis=-1)


def chromatic_adaptation(
    source_white: ArrayLike, target_white: ArrayLike, method: str = "bradford"
) -> NDArray[np.float64]:
    """Matrix that carries tristimulus values from one white to another.

    Parameters
    ----------
    source_white, target_white : array_like (3,)
        XYZ of the two whites; cone responses must be positive.
    method : {"none", "bradford", "cat16"}
        The cone space in which channels are scaled; "none" gives the identity.

    Returns
    -------
    ndarray of float64 (3, 3)
        ``xyz @ matrix.T`` is adapted; the source white becomes the target white.

    Raises
    ------
    InvalidParameterError
        If the method is unknown, a white is not finite or not three values, or a cone response is not positive.

    References
    ----------
    Lam 1985 as in CIE 159:2004 (linear Bradford); Li et al. 2017 (CAT16); both with full adaptation.
    """
    require_choice("adaptation", method, ADAPTATIONS)
    source, target = _triples("source_white", source_white), _triples("target_white", target_white)
    require_shape("source_white", source, (3,))
    require_shape("target_white", target, (3,))
    if method == "none":
        return np.eye(3)
    cone = np.array(_CONE_MATRICES[method])
    responses = np.stack([cone @ source, cone @ target])
    if np.any(responses <= 0.0):
        raise InvalidParameterError(
            f"whites must have positive {method} cone responses, but {source} and {target} give {responses.tolist()}; "
            "choose another adaptation for so coloured a light"
        )
    return np.linalg.solve(cone, (responses[1] / responses[0])[:, None] * cone)


def lab(xyz: ArrayLike, white: ArrayLike) -> NDArray[np.float64]:
    """CIE 1976 L*, a*, b*.

    Parameters
    ----------
    xyz : array_like (..., 3)
        Tristimulus values; slightly negative ones (out of the spectral locus by interpolation) are continued straight.
    white : array_like (3,)
        XYZ of the white in the same scale, all positive.

    Returns
    -------
    ndarray of float64 (..., 3)
        L* (0 to 100 for a reflectance), a*, b*.

    Raises
    ------
    InvalidParameterError
        If a value is not finite, the last axis is not of length 3, or the white is not positive.

    References
    ----------
    CIE 15:2004, 8.2.1 (with the exact fractions 6/29 instead of rounded constants).
    """
    values, reference = _triples("xyz", xyz), _triples("white", white)
    if np.any(reference <= 0.0):
        raise InvalidParameterError(f"white must be positive, but is {reference}")
    ratio = values / reference
    edge = 6.0 / 29.0
    f = np.where(ratio > edge**3, np.cbrt(ratio), ratio / (3.0 * edge * edge) + 4.0 / 29.0)
    return np.stack(
        [116.0 * f[..., 1] - 16.0, 500.0 * (f[..., 0] - f[..., 1]), 200.0 * (f[..., 1] - f[..., 2])], axis=-1
    )


_FULL_CHROMA = 1.0e6  # from here on C^7 / (C^7 + 25^7) is 1 in float64; the power of a larger one would overflow


def delta_e_2000(first: ArrayLike, second: ArrayLike) -> NDArray[np.float64]:
    """CIE Delta E 2000 between Lab colours.

    Parameters
    ----------
    first, second : array_like (..., 3)
        L*, a*, b*; shapes broadcast.

    Returns
    -------
    ndarray of float64 (...)
        Colour difference, parametric factors 1.

    Raises
    ------
    InvalidParameterError
        If a value is not finite or the last axis is not of length 3.

    References
    ----------
    ISO/CIE 11664-6:2014; Sharma, Wu and Dalal, Color Res. Appl. 30, 2005 (hue of greys, branch of the mean hue).
    """
    one, two = np.broadcast_arrays(_triples("first", first), _triples("second", second))
    l1, a1, b1 = np.moveaxis(one, -1, 0)
    l2, a2, b2 = np.moveaxis(two, -1, 0)
    mean_chroma_7 = np.minimum(0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2)), _FULL_CHROMA) ** 7
    g = 0.5 * (1.0 - np.sqrt(mean_chroma_7 / (mean_chroma_7 + 25.0**7)))
    a1, a2 = (1.0 + g) * a1, (1.0 + g) * a2
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360.0, np.degrees(np.arctan2(b2, a2)) % 360.0
    coloured = c1 * c2 > 0.0
    turn = h2 - h1
    # More than half a turn apart, told by the sign of the cross product: it is exactly 0 for opposite hues, where the
    # difference of two rounded angles may fall on either side of 180 degrees and pick another mean hue.
    apart = (np.abs(turn) > 90.0) & (turn * (a1 * b2 - b1 * a2) < 0.0)
    turn = np.where(apart, turn - np.copysign(360.0, turn), turn)
    delta_hue = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(np.where(coloured, turn, 0.0)) / 2.0)
    mean_l, mean_c = 0.5 * (l1 + l2), 0.5 * (c1 + c2)
    total = h1 + h2
    mean_h = 0.5 * np.where(apart, np.where(total < 360.0, total + 360.0, total - 360.0), total)
    mean_h = np.where(coloured, mean_h, total)
    t = (
        1.0
        - 0.17 * np.cos(np.radians(mean_h - 30.0))
        + 0.24 * np.cos(np.radians(2.0 * mean_h))
        + 0.32 * np.cos(np.radians(3.0 * mean_h + 6.0))
        - 0.20 * np.cos(np.radians(4.0 * mean_h - 63.0))
    )
    from_50 = (mean_l - 50.0) ** 2
    s_l = 1.0 + 0.015 * from_50 / np.sqrt(20.0 + from_50)
    s_c = 1.0 + 0.045 * mean_c
    s_h = 1.0 + 0.015 * mean_c * t
    mean_c_7 = np.minimum(mean_c, _FULL_CHROMA) ** 7
    rotation = (
        -2.0
        * np.sqrt(mean_c_7 / (mean_c_7 + 25.0**7))
        * np.sin(np.radians(60.0 * np.exp(-(((mean_h - 275.0) / 25.0) ** 2))))
    )
    dl, dc, dh = (l2 - l1) / s_l, (c2 - c1) / s_c, delta_hue / s_h
    return np.asarray(np.sqrt(np.maximum(dl * dl + dc * dc + dh * dh + rotation * dc * dh, 0.0)))
