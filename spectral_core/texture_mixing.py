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

__all__ = ["filtered", "mixture", "uplift_texture", "weighted_reflectance"]

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
    return weighted_reflectance([(1.0 - by, first), (by, second)], name)


def weighted_reflectance(
    parts: Sequence[tuple[float, Spectrum | TexturedReflectance]], name: str = ""
) -> TexturedReflectance:
    """Add reflectances, each times its weight.

    Parameters
    ----------
    parts : sequence of tuple of (float, Spectrum or TexturedReflectance)
        At least one; weights are not negative.
    name : str, optional
        Name of the result; by default the names of the parts.

    Returns
    -------
    TexturedReflectance
        The sum at every point and wavelength. Spectra and pictures that several parts share are in it once.

    Raises
    ------
    InvalidParameterError
        If there is no part, or a weight is negative.

    References
    ----------
    Own design.
    """
    spectra: list[Spectrum] = []
    names: list[str] = []
    pictures: dict[ImageTexture, list[tuple[Float64, list[int]]]] = {}
    everywhere: list[tuple[Float64, list[int]]] = []
    for number, (weight, given) in enumerate(parts):
        part = _as_textured(given, chr(ord("A") + number % 26)).scaled(weight)
        places = []
        for spectrum, part_name in zip(part.spectra, part.part_names, strict=True):
            if spectrum not in spectra:
                spectra.append(spectrum)
                names.append(_unused(part_name, names))
            places.append(spectra.index(spectrum))
        everywhere.append((part.base, places))
        for texture, amounts in zip(part.textures, part.amounts, strict=True):
            pictures.setdefault(texture, []).append((amounts, places))
    return TexturedReflectance(
        spectra=tuple(spectra),
        part_names=tuple(names),
        textures=tuple(pictures),
        amounts=tuple(_spread(layers, len(spectra)) for layers in pictures.values()),
        base=_spread(everywhere, len(spectra)),
        name=name or " + ".join(dict.fromkeys(part.name for _, part in parts if part.name)),
    )


def _spread(layers: Sequence[tuple[Float64, list[int]]], count: int) -> Float64:
    """Sum of arrays whose last axes hold the columns that each names."""
    shapes = [amounts.shape[:-1] for amounts, _ in layers]
    total = np.zeros((*shapes[0], count) if shapes else count)
    for amounts, places in layers:
        for column, place in enumerate(places):  # a place may be named twice
            total[..., place] += amounts[..., column]
    return total


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
