"""Reflectances that vary over a surface: a few spectra, mixed by what textures say at each point.

It is linear in its spectra, so a renderer that keeps geometry and spectra apart needs nothing new: each spectrum is a
component of the material, and the amount of it belongs to the geometry. A colour picture is a mixture of three spectra,
the basis of ``rgb_uplift``; a mask mixes any two.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError
from .spectra import REFERENCE_WAVELENGTHS_NM, Spectrum, require_not_negative
from .textures import ImageTexture
from .validation import require_in_range, require_shape

__all__ = ["TexturedReflectance", "common_wavelengths", "require_plain"]

Float64 = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class TexturedReflectance:
    """A mixture of J spectra whose amounts vary with the texture coordinates.

    Attributes
    ----------
    spectra : tuple of Spectrum, length J
        What is mixed; not negative.
    part_names : tuple of str, length J
        What the spectra are called as components of a material ("body red"), each once.
    textures : tuple of ImageTexture, length X
        Each is read once a point.
    amounts : tuple of ndarray, length X, shapes (C, J)
        How much of each spectrum (column) one unit of each channel of a texture (row) adds.
    base : ndarray, shape (J,)
        How much of each spectrum there is everywhere.
    name : str
        Shown in the plan and in errors.

    Raises
    ------
    InvalidParameterError
        If the numbers of spectra, names and channels do not fit, or a value breaks its rule.

    References
    ----------
    Own design.
    """

    spectra: tuple[Spectrum, ...]
    part_names: tuple[str, ...]
    textures: tuple[ImageTexture, ...]
    amounts: tuple[Float64, ...]
    base: Float64
    name: str = ""
    _key: bytes = field(init=False, repr=False)
    _brightest: Spectrum = field(init=False, repr=False)

    def __post_init__(self) -> None:
        label = f"textured reflectance '{self.name}'" if self.name else "textured reflectance"
        count = len(self.spectra)
        if not count or len(set(self.part_names)) != count or len(self.part_names) != count:
            raise InvalidParameterError(f"{label} must give each of its {count} spectra a name of its own")
        for spectrum, part in zip(self.spectra, self.part_names, strict=True):
            require_not_negative(f"{part} of {label}", spectrum)
        if len(self.textures) != len(self.amounts):
            raise InvalidParameterError(f"{label} has {len(self.textures)} textures but {len(self.amounts)} amounts")
        amounts = []
        for texture, given in zip(self.textures, self.amounts, strict=True):
            array = np.array(require_in_range(f"amounts of {label}", given, -1.0e6, 1.0e6))
            require_shape(f"amounts of {label}", array, (texture.pixels.shape[2], count))
            amounts.append(array)
        base = np.array(require_in_range(f"base of {label}", self.base, 0.0, 1.0e6))
        require_shape(f"base of {label}", base, (count,))
        object.__setattr__(self, "amounts", tuple(amounts))
        object.__setattr__(self, "base", base)
        digest = hashlib.blake2b(repr(self.part_names).encode(), digest_size=16)
        for part_key in [s.key for s in self.spectra] + [t.key for t in self.textures]:
            digest.update(part_key)
        for array in (*amounts, base):
            digest.update(array.tobytes())
        object.__setattr__(self, "_key", digest.digest())
        object.__setattr__(self, "_brightest", self._bound())

    @property
    def key(self) -> bytes:
        """Digest (16 bytes) of the content without the name; equal reflectances have equal keys."""
        return self._key

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, TexturedReflectance) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def mixes_like(self, other: TexturedReflectance) -> bool:
        """Tell whether another differs in nothing but its spectra, so that what was traced for one serves the other.

        Parameters
        ----------
        other : TexturedReflectance
            The other.

        Returns
        -------
        bool
            Whether the amounts of the spectra are the same at every point.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return (
            self.part_names == other.part_names
            and self.textures == other.textures
            and all(np.array_equal(*pair) for pair in zip(self.amounts, other.amounts, strict=True))
            and np.array_equal(self.base, other.base)
        )

    @property
    def brightest(self) -> Spectrum:
        """A reflectance that no point of the surface exceeds at any wavelength; as small as its bounds allow."""
        return self._brightest

    def _bound(self) -> Spectrum:
        """The smaller of two bounds: all channels at their largest at once, or every spectrum at its peak."""
        wavelengths = common_wavelengths(self.spectra)
        table = np.stack([s.at(wavelengths) for s in self.spectra])
        peaks = table.max(axis=1)
        largest, strongest = self.base.copy(), float(self.base @ peaks)
        for texture, amounts in zip(self.textures, self.amounts, strict=True):
            flat = texture.pixels.reshape(-1, texture.pixels.shape[2])
            if texture.extension == "clip":
                flat = np.concatenate([flat, np.zeros_like(flat[:1])])
            low, high = (end[:, None].astype(np.float64) * amounts for end in (flat.min(axis=0), flat.max(axis=0)))
            largest += np.maximum(low, high).sum(axis=0)
            strongest += float((flat @ (amounts @ peaks).astype(np.float32)).max())
        # The products above are rounded to float32, and so may be what lies between two pixels.
        values = np.minimum(np.maximum(largest, 0.0) @ table, strongest * (1.0 + 1.0e-6))
        return Spectrum(wavelengths, np.maximum(values, 0.0), name=self.name)

    def weights(self, uv: ArrayLike) -> NDArray[np.floating[Any]]:
        """Give the amounts of the spectra at texture coordinates.

        Parameters
        ----------
        uv : array_like, shape (N, 2)
            Texture coordinates.

        Returns
        -------
        ndarray, shape (N, J)
            Not negative; float32 if `uv` is, else float64.

        Raises
        ------
        InvalidParameterError
            If a coordinate is not finite, or there are not two.

        References
        ----------
        Own design.
        """
        given = np.asarray(uv)
        total = np.tile(self.base, (len(given), 1))
        for texture, amounts in zip(self.textures, self.amounts, strict=True):
            total += texture.sample(given) @ amounts
        return np.maximum(total, 0.0).astype(np.float32 if given.dtype == np.float32 else np.float64, copy=False)

    def at(self, uv: ArrayLike, wavelengths_nm: ArrayLike) -> NDArray[np.floating[Any]]:
        """Give the reflectances at texture coordinates.

        Parameters
        ----------
        uv : array_like, shape (N, 2)
            Texture coordinates.
        wavelengths_nm : array_like, shape (W,)
            Wavelengths (nm).

        Returns
        -------
        ndarray, shape (N, W)
            Reflectances.

        Raises
        ------
        InvalidParameterError
            If a coordinate or wavelength is not finite.

        References
        ----------
        Own design.
        """
        return np.asarray(self.weights(uv) @ np.stack([s.at(wavelengths_nm) for s in self.spectra]))

    def average(self) -> Spectrum:
        """Average over the whole of every texture: what is seen from too far to tell its pixels apart.

        Returns
        -------
        Spectrum
            One plain reflectance, for models that take no texture.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        amounts = self.base.copy()
        for texture, part in zip(self.textures, self.amounts, strict=True):
            amounts += texture.pixels.mean(axis=(0, 1), dtype=np.float64) @ part
        wavelengths = common_wavelengths(self.spectra)
        values = np.maximum(amounts, 0.0) @ np.stack([s.at(wavelengths) for s in self.spectra])
        return Spectrum(wavelengths, np.maximum(values, 0.0), name=f"{self.name} (average)")

    def scaled(self, factor: float, name: str | None = None) -> TexturedReflectance:
        """Multiply by a number.

        Parameters
        ----------
        factor : float
            Not negative.
        name : str, optional
            Name of the result; the present one when left out.

        Returns
        -------
        TexturedReflectance
            The same spectra in other amounts.

        Raises
        ------
        InvalidParameterError
            If the factor is negative or not finite.

        References
        ----------
        Own design.
        """
        by = float(require_in_range("factor", factor, 0.0))
        amounts = tuple(part * by for part in self.amounts)
        return replace(self, amounts=amounts, base=self.base * by, name=self.name if name is None else name)


def require_plain(name: str, reflectance: Spectrum | TexturedReflectance) -> Spectrum:
    """Return a reflectance that is one spectrum all over, or raise.

    Parameters
    ----------
    name : str
        What the reflectance is called in the error.
    reflectance : Spectrum or TexturedReflectance
        The reflectance.

    Returns
    -------
    Spectrum
        The same.

    Raises
    ------
    InvalidParameterError
        If it is textured.

    References
    ----------
    Own design.
    """
    if isinstance(reflectance, TexturedReflectance):
        raise InvalidParameterError(f"{name} must be a plain spectrum, but is the texture '{reflectance.name}'")
    return reflectance


def common_wavelengths(spectra: Sequence[Spectrum]) -> Float64:
    """Find wavelengths at which products and mixtures of spectra lose nothing to speak of.

    Parameters
    ----------
    spectra : sequence of Spectrum
        At least one.

    Returns
    -------
    ndarray
        The samples of all and every nm from 360 to 830 nm, increasing; one where all are constant.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    if all(s.is_constant for s in spectra):
        return spectra[0].wavelengths_nm[:1]
    return np.unique(np.concatenate([REFERENCE_WAVELENGTHS_NM, *(s.wavelengths_nm for s in spectra)]))
