"""From RGB to reflectance: three basis spectra whose sum is 1, weighted by linear sRGB.

The uplift is linear, so an image texture costs a renderer three spectra and not one a pixel. A colour inside the sRGB
gamut gets a reflectance between 0 and 1, and under D65 it has exactly the colour asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import tables
from .colorimetry import observer, tristimulus_weights, wavelength_grid
from .display import display
from .errors import InvalidParameterError
from .spectra import REFERENCE_WAVELENGTHS_NM, Spectrum
from .validation import require_finite, require_in_range, require_shape

__all__ = ["BASIS", "BASIS_WAVELENGTHS_NM", "basis_spectra", "uplift", "uplift_values"]


def _corrected_basis() -> NDArray[np.float64]:
    """Make the published basis at 1 nm, with its small colour error under D65 removed.

    Read at 1 nm to 830 nm the published curves (5 nm, 380 to 780 nm) miss their colours by a few 1e-4. A matrix C
    close to the identity turns them into curves whose colours under D65 are the primaries themselves and whose sum is
    1: with A = XYZ of the curves in linear sRGB (3 curves by 3 channels), C = inverse of A. The white of sRGB is D65
    rounded to four places; the curves keep the sum 1, which makes that white the perfect diffuser, by adapting A to it.
    """
    wavelengths, published = tables.table("basis/mallett_2019")
    curves = np.stack(
        [Spectrum(wavelengths, row, interpolation="lagrange").at(REFERENCE_WAVELENGTHS_NM) for row in published]
    )
    curves = curves / curves.sum(axis=0)
    d65 = Spectrum(*tables.table("illuminant/D65"))
    weights = tristimulus_weights(d65, observer("cie_1931_2"), wavelength_grid("exact"))
    colours = curves @ weights @ display("srgb").from_tristimulus.T
    colours = colours / colours.sum(axis=0)
    corrected = np.linalg.solve(colours, curves)
    corrected.flags.writeable = False
    return corrected


BASIS_WAVELENGTHS_NM: NDArray[np.float64] = REFERENCE_WAVELENGTHS_NM
"""Wavelengths (471,) of :data:`BASIS` in nm."""

BASIS: NDArray[np.float64] = _corrected_basis()
"""The three basis reflectances (3, 471) of red, green and blue; positive, and 1 in sum at every wavelength."""


def basis_spectra() -> tuple[Spectrum, Spectrum, Spectrum]:
    """Fetch the three basis reflectances as spectra.

    Returns
    -------
    tuple of Spectrum
        Reflectance of full red, green and blue.

    Raises
    ------
    None.

    References
    ----------
    Mallett and Yuksel, Spectral Primary Decomposition for Rendering with sRGB Reflectance, EGSR 2019.
    """
    red, green, blue = (
        Spectrum(BASIS_WAVELENGTHS_NM, curve, f"basis {colour}")
        for colour, curve in zip(("red", "green", "blue"), BASIS, strict=True)
    )
    return red, green, blue


def uplift_values(rgb_linear: ArrayLike) -> NDArray[np.float64]:
    """Reflectances of linear sRGB colours at the basis wavelengths.

    Parameters
    ----------
    rgb_linear : array_like (..., 3)
        Linear sRGB; 0 to 1 gives reflectances of 0 to 1.

    Returns
    -------
    ndarray of float64 (..., 471)
        Reflectances at :data:`BASIS_WAVELENGTHS_NM`, linear in the colour.

    Raises
    ------
    InvalidParameterError
        If a value is not finite or the last axis is not of length 3.

    References
    ----------
    Mallett and Yuksel 2019, equation 1.
    """
    colours = require_finite("rgb_linear", rgb_linear)
    if colours.shape[-1:] != (3,):
        raise InvalidParameterError(f"rgb_linear must have three values on the last axis, but has {colours.shape}")
    return np.asarray(colours @ BASIS)


def uplift(rgb_linear: ArrayLike, name: str = "") -> Spectrum:
    """Make the reflectance of one linear sRGB colour.

    Parameters
    ----------
    rgb_linear : array_like (3,)
        Linear sRGB, not negative; above 1 the spectrum is above 1 too (a source, not a reflectance). Equal channels
        give an exactly constant spectrum.
    name : str, optional
        Name of the result; by default it tells the colour.

    Returns
    -------
    Spectrum
        360 to 830 nm at 1 nm.

    Raises
    ------
    InvalidParameterError
        If a value is not finite or negative, or there are not three.

    References
    ----------
    Mallett and Yuksel 2019, equation 1.
    """
    colour = require_in_range("rgb_linear", rgb_linear, 0.0)
    require_shape("rgb_linear", colour, (3,))
    label = name or f"sRGB {colour[0]:.3g} {colour[1]:.3g} {colour[2]:.3g}"
    if colour.max() == colour.min():
        return Spectrum.constant(float(colour[0]), label)
    return Spectrum(BASIS_WAVELENGTHS_NM, uplift_values(colour), label)
