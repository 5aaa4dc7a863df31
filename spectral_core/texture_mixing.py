"""Textured reflectances from pictures and spectra: the uplift of colours, mixtures, masks and filters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .errors import InvalidParameterError
from .rgb_uplift import basis_spectra
from .spectra import Spectrum, require_not_negative
from .textured_reflectance import TexturedReflectance, common_wavelengths
from .textures import ImageTexture
from .validation import require_in_range

__all__ = ["filtered", "mixture", "uplift_texture"]

Float64 = NDArray[np.float64]


def uplift_texture(texture: ImageTexture, name: str = "") -> TexturedReflectance:
    """Make the reflectances of a colour picture: each pixel the smooth spectrum that has its colour under D65.

    Parameters
    ----------
    texture : ImageTexture
        Three channels of linear Rec.709; 0 to 1 gives reflectances of 0 to 1.
    name : str, optional
        By default the texture's.

    Returns
    -------
    TexturedReflectance
        A mixture of the spectra "red", "green" and "blue" of ``rgb_uplift.basis_spectra``.

    Raises
    ------
    InvalidParameterError
        If the texture has not three channels.

    References
    ----------
    Mallett and Yuksel, Spectral Primary Decomposition for Rendering with sRGB Reflectance, EGSR 2019.
    """
    channels = texture.pixels.shape[2]
    if channels != 3:
        raise InvalidParameterError(f"texture '{texture.name}' must have 3 channels to be uplifted, but has {channels}")
    return TexturedReflectance(
        spectra=basis_spectra(),
        part_names=("red", "green", "blue"),
        textures=(texture,),
        amounts=(np.eye(3),),
        base=np.zeros(3),
        name=name or texture.name,
    )


def mixture(
    first: Spectrum | TexturedReflectance,
    second: Spectrum | TexturedReflectance,
    share: float | ImageTexture,
    name: str = "",
) -> TexturedReflectance:
    """Mix two reflectances, evenly or by a mask.

    Parameters
    ----------
    first, second : Spectrum or TexturedReflectance
        What is mixed. By a mask only plain spectra are: a product of two pictures is no mixture of few spectra.
    share : float or ImageTexture
        Share of `second`, 0 to 1; as a picture, one channel.
    name : str, optional
        Name of the result.

    Returns
    -------
    TexturedReflectance
        ``(1 - share) first + share second`` at every point and wavelength.

    Raises
    ------
    InvalidParameterError
        If the share lies outside 0 to 1, the mask has more than one channel, or a textured reflectance is to be mixed
        by a mask.

    References
    ----------
    Own design.
    """
    if isinstance(share, ImageTexture):
        return _masked(first, second, share, name)
    by = float(require_in_range("share", share, 0.0, 1.0))
    a, b = _as_textured(first, "A").scaled(1.0 - by), _as_textured(second, "B").scaled(by)
    spectra, names = list(a.spectra), list(a.part_names)
    places = []  # where each spectrum of b goes; equal ones are shared
    for spectrum, part in zip(b.spectra, b.part_names, strict=True):
        if spectrum in spectra:
            places.append(spectra.index(spectrum))
            continue
        places.append(len(spectra))
        spectra.append(spectrum)
        names.append(_unused(part, names))
    moved = np.zeros((len(b.spectra), len(spectra)))
    moved[np.arange(len(places)), places] = 1.0
    padded = np.eye(len(a.spectra), len(spectra))
    layers: dict[ImageTexture, Float64] = {}
    for part_of, onto in ((a, padded), (b, moved)):
        for texture, amounts in zip(part_of.textures, part_of.amounts, strict=True):
            layers[texture] = layers.get(texture, 0.0) + amounts @ onto
    return TexturedReflectance(
        spectra=tuple(spectra),
        part_names=tuple(names),
        textures=tuple(layers),
        amounts=tuple(layers.values()),
        base=a.base @ padded + b.base @ moved,
        name=name,
    )


def _masked(
    first: Spectrum | TexturedReflectance, second: Spectrum | TexturedReflectance, mask: ImageTexture, name: str
) -> TexturedReflectance:
    if not (isinstance(first, Spectrum) and isinstance(second, Spectrum)):
        raise InvalidParameterError(
            f"the mask '{mask.name}' must mix two plain spectra, but one of them is a picture itself"
        )
    if mask.pixels.shape[2] != 1:
        raise InvalidParameterError(f"the mask '{mask.name}' must have 1 channel, but has {mask.pixels.shape[2]}")
    require_in_range(f"the mask '{mask.name}'", float(mask.pixels.max()), 0.0, 1.0)
    names = [first.name or "A"]
    names.append(_unused(second.name or "B", names))
    return TexturedReflectance(
        spectra=(first, second),
        part_names=tuple(names),
        textures=(mask,),
        amounts=(np.array([[-1.0, 1.0]]),),
        base=np.array([1.0, 0.0]),
        name=name or mask.name,
    )


def filtered(reflectance: TexturedReflectance, spectrum: Spectrum, name: str = "") -> TexturedReflectance:
    """Multiply by a plain spectrum, as a filter in front of a picture does.

    Parameters
    ----------
    reflectance : TexturedReflectance
        The picture.
    spectrum : Spectrum
        The filter; not negative.
    name : str, optional
        Name of the result; the picture's when left out.

    Returns
    -------
    TexturedReflectance
        The same amounts of filtered spectra.

    Raises
    ------
    InvalidParameterError
        If the filter is negative somewhere.

    References
    ----------
    Own design.
    """
    require_not_negative("filter", spectrum)
    made = []
    for part in reflectance.spectra:
        wavelengths = common_wavelengths((part, spectrum))
        # Lagrange's formula may pass a little below zero between samples.
        values = np.maximum(part.at(wavelengths), 0.0) * np.maximum(spectrum.at(wavelengths), 0.0)
        made.append(Spectrum(wavelengths, values, name=f"{part.name} x {spectrum.name}"))
    return replace(reflectance, spectra=tuple(made), name=name or reflectance.name)


def _as_textured(reflectance: Spectrum | TexturedReflectance, otherwise: str) -> TexturedReflectance:
    if isinstance(reflectance, TexturedReflectance):
        return reflectance
    return TexturedReflectance((reflectance,), (reflectance.name or otherwise,), (), (), np.ones(1), reflectance.name)


def _unused(name: str, taken: Sequence[str]) -> str:
    candidate, number = name, 2
    while candidate in taken:
        candidate, number = f"{name} {number}", number + 1
    return candidate
