"""Spectral pictures: the radiance spectrum of every pixel as a spectral EXR in the layout of Fichet et al.

OpenImageIO writes the file; Blender must not open it, since it fails on files with that many channels.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import observer
from .display import display
from .errors import InvalidParameterError, MemoryLimitError
from .image_io import write_image
from .renderer import Render
from .validation import require_in_range

__all__ = ["DEFAULT_WAVELENGTHS_NM", "channel_name", "radiance_image", "write_spectral_exr"]

DEFAULT_WAVELENGTHS_NM: NDArray[np.float64] = np.arange(400.0, 701.0, 5.0)
"""The wavelengths (61,) of the paper, 400 to 700 nm at 5 nm."""
DEFAULT_WAVELENGTHS_NM.flags.writeable = False

LAYOUT_VERSION = "1.0"
UNITS = "W.m^-2.sr^-1"  # the word that the layout's reference writer uses for spectral radiance


def channel_name(wavelength_nm: float) -> str:
    """Name the channel of a wavelength as the layout asks.

    Parameters
    ----------
    wavelength_nm : float
        Wavelength (nm), above 0.

    Returns
    -------
    str
        Such as "S0.555,000000nm": first Stokes component, with a comma for the decimal point.

    Raises
    ------
    InvalidParameterError
        If the wavelength is not above 0.

    References
    ----------
    A. Fichet, R. Pacanowski and A. Wilkie, "An OpenEXR layout for spectral images", JCGT 10(3), 1-18 (2021).
    """
    require_in_range("wavelength_nm", wavelength_nm, 1e-6, unit="nm")
    return f"S0.{wavelength_nm:.6f}nm".replace(".", ",").replace("S0,", "S0.", 1)


def radiance_image(
    render: Render, wavelengths_nm: NDArray[np.float64], memory_limit: int | None = 1 << 31
) -> NDArray[np.float32]:
    """Compute the spectrum of every pixel.

    Parameters
    ----------
    render : Render
        A render that is kept by terms.
    wavelengths_nm : ndarray, shape (W,)
        Where to sample (nm), increasing.
    memory_limit : int, optional
        Bytes that the picture may take; None for no limit.

    Returns
    -------
    ndarray of float32, shape (height, width, W)
        Relative radiance per nm, on the scale on which its sum at 1 nm against the observer gives the render's
        tristimulus values.

    Raises
    ------
    InvalidParameterError
        If the render keeps plain colour.
    MemoryLimitError
        If the picture would be larger than `memory_limit`.

    References
    ----------
    Tominaga 1996, Eqs. 1 and 4.
    """
    if not render.film.is_relightable:
        raise InvalidParameterError("this render keeps plain colour, so its pixels have no spectra")
    needed = render.film.width * render.film.height * len(wavelengths_nm) * 4
    if memory_limit is not None and needed > memory_limit:
        raise MemoryLimitError(
            f"a spectral picture of {render.film.width} x {render.film.height} pixels and {len(wavelengths_nm)} "
            f"wavelengths takes {needed / 2**30:.1f} GiB, more than the {memory_limit / 2**30:.1f} GiB allowed"
        )
    terms = render.film.terms
    table = render.spectra.radiance_table(terms, np.asarray(wavelengths_nm, np.float64), observer(render.observer))
    return np.asarray(render.film.weighted_sum(table, terms, np.float32), np.float32)


def write_spectral_exr(
    path: str | os.PathLike[str], render: Render, wavelengths_nm: NDArray[np.float64] | None = None
) -> None:
    """Write the radiance spectrum of every pixel.

    Parameters
    ----------
    path : path-like
        Ends in ".exr".
    render : Render
        A render that is kept by terms.
    wavelengths_nm : ndarray, shape (W,), optional
        Where to sample (nm); the paper's 400 to 700 nm at 5 nm when left out.

    Raises
    ------
    InvalidParameterError
        If the render keeps plain colour, or the suffix is another.
    MemoryLimitError
        If the picture would be too large.
    MissingDependencyError
        If OpenImageIO is not installed.

    References
    ----------
    Fichet et al. 2021 (see :func:`channel_name`).
    """
    wavelengths_nm = DEFAULT_WAVELENGTHS_NM if wavelengths_nm is None else np.asarray(wavelengths_nm, np.float64)
    if not str(path).lower().endswith(".exr"):
        raise InvalidParameterError(f"a spectral picture is kept in a file that ends in .exr, but the name is {path}")
    spectra = radiance_image(render, wavelengths_nm)
    rgb = _preview(render)
    channels = ["R", "G", "B", *(channel_name(w) for w in wavelengths_nm)]
    metadata: dict[str, Any] = {"spectralLayoutVersion": LAYOUT_VERSION, "emissiveUnits": UNITS}
    write_image(path, np.concatenate([rgb, spectra], axis=2), channels=channels, metadata=metadata)


def _preview(render: Render) -> NDArray[np.float32]:
    """Linear sRGB (H, W, 3), which the layout recommends beside the spectra for viewers that know no others."""
    return display("srgb").linear(render.tristimulus()).astype(np.float32)
