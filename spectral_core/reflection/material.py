"""What all materials share: the split of the radiance factor, and the walk over many rays.

Each material splits its radiance factor into geometric coefficients, which know no wavelength, and reflectances,
which know no direction: radiance_factor = coefficients @ reflectances. The radiance that leaves the surface is
radiance_factor * E / pi, where E is the irradiance on a plane that faces the light; the pi is the one that the paper
drops for relative work (Eq. 3).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..spectra import Spectrum
from ..textured_reflectance import TexturedReflectance
from .angles import floating_type, vectors
from .geometry import ReflectionGeometry, geometry_blocks

__all__ = ["Material", "spread_lobes"]

Float64 = NDArray[np.float64]


class Material(ABC):
    """A surface of one of the paper's three types."""

    __slots__ = ()

    energy_conserving: bool
    mirror: float

    @property
    @abstractmethod
    def reflectances(self) -> tuple[Spectrum, ...]:
        """The Km spectra of the components.

        Returns
        -------
        tuple of Spectrum
            Body and interface, or the two interface terms of a metal.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eqs. 4 and 7.
        """

    @property
    @abstractmethod
    def component_names(self) -> tuple[str, ...]:
        """Names of the Km components.

        Returns
        -------
        tuple of str
            In the order of `reflectances`.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eqs. 4 and 7.
        """

    @property
    @abstractmethod
    def needs_tangent(self) -> bool:
        """Whether :meth:`coefficients` needs tangents.

        Returns
        -------
        bool
            True for anisotropic metals.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """

    @property
    def textures(self) -> tuple[TexturedReflectance | None, ...]:
        """What varies over the surface, lobe by lobe.

        A lobe (body, interface) whose reflectance is textured is as many components as the texture mixes spectra.

        Returns
        -------
        tuple of TexturedReflectance or None
            One entry a lobe; empty when nothing varies, and then each component is a lobe.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return ()

    def lobes(
        self, normal: ArrayLike, to_light: ArrayLike, to_viewer: ArrayLike, tangent: ArrayLike | None = None
    ) -> NDArray[Any]:
        """Geometric coefficients before textures are read; :func:`spread_lobes` makes those of the components of them.

        Parameters
        ----------
        normal, to_light, to_viewer, tangent : array_like (N, 3)
            As for :meth:`coefficients`.

        Returns
        -------
        ndarray (N, lobes)
            As :meth:`coefficients`; the same where nothing is textured.

        Raises
        ------
        InvalidParameterError
            As :meth:`coefficients`.

        References
        ----------
        Tominaga 1996, Eqs. 4 and 7.
        """
        return self.coefficients(normal, to_light, to_viewer, tangent)

    @abstractmethod
    def coefficients(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        tangent: ArrayLike | None = None,
        uv: ArrayLike | None = None,
    ) -> NDArray[Any]:
        """Geometric coefficients, which know no wavelength.

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        tangent : array_like (N, 3), optional
            Directions along the surface, for materials that need them.
        uv : array_like (N, 2), optional
            Texture coordinates, for materials with `textures`.

        Returns
        -------
        ndarray (N, Km)
            0 where N.L <= 0 or N.V <= 0. float32 if the first three are, else float64.

        Raises
        ------
        InvalidParameterError
            If a vector is not finite or not of length 1, or the shapes do not fit.

        References
        ----------
        Tominaga 1996, Eqs. 4 and 7.
        """

    def radiance_factor(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        wavelengths_nm: ArrayLike,
        tangent: ArrayLike | None = None,
        uv: ArrayLike | None = None,
    ) -> NDArray[Any]:
        """Spectral radiance factor; times E / pi it is the radiance, E the irradiance on a plane facing the light.

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        wavelengths_nm : array_like (W,)
            Wavelengths in nm.
        tangent : array_like (N, 3), optional
            As for :meth:`coefficients`.
        uv : array_like (N, 2), optional
            As for :meth:`coefficients`.

        Returns
        -------
        ndarray (N, W)
            In the type of :meth:`coefficients`. Where Eq. 13 falls below 0 at a wavelength, the reflectance is 0.

        Raises
        ------
        InvalidParameterError
            As :meth:`coefficients`, or if a wavelength is not finite.

        References
        ----------
        Tominaga 1996, Eqs. 3, 8, 9 and 10.
        """
        coefficients = self.coefficients(normal, to_light, to_viewer, tangent, uv)
        spectra = np.stack([s.at(wavelengths_nm) for s in self.reflectances]).astype(coefficients.dtype)
        if spectra.ndim != 2:
            raise InvalidParameterError(f"wavelengths_nm must be a list, but has the shape {spectra.shape[1:]}")
        product = coefficients @ spectra
        return np.asarray(np.maximum(product, 0.0, out=product))


def spread_lobes(material: Material, lobes: NDArray[Any], uv: ArrayLike | None) -> NDArray[Any]:
    """Turn coefficients of lobes into those of components, by what a material's textures say.

    Parameters
    ----------
    material : Material
        The material.
    lobes : ndarray (N, L * lobes)
        What :meth:`Material.lobes` gives, for one light or for several one beside the other.
    uv : array_like (N, 2) or None
        Texture coordinates; not needed by a material without textures.

    Returns
    -------
    ndarray (N, L * Km)
        In the type of `lobes`; `lobes` itself where nothing is textured.

    Raises
    ------
    InvalidParameterError
        If the material is textured and there are no coordinates, or one is not finite.

    References
    ----------
    Own design. Textures are read once a point, however many lights there are.
    """
    textures = material.textures
    if not textures:
        return lobes
    if uv is None:
        raise InvalidParameterError("uv must be given for a material with a texture, but is None")
    shares = [None if texture is None else texture.weights(uv) for texture in textures]
    columns = []
    for first in range(0, lobes.shape[1], len(textures)):
        for number, share in enumerate(shares):
            lobe = lobes[:, first + number, None]
            columns.append(lobe if share is None else lobe * share)
    return np.concatenate(columns, axis=1).astype(lobes.dtype, copy=False)


class Rays:
    """Directions broadcast to one shape (N, 3), walked in blocks, with the result to fill."""

    __slots__ = ("_light", "_normal", "_tangent", "_viewer", "result")

    def __init__(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        tangent: ArrayLike | None,
        components: int,
    ) -> None:
        named = {"normal": normal, "to_light": to_light, "to_viewer": to_viewer}
        if tangent is not None:
            named["tangent"] = tangent
        arrays = [vectors(name, value) for name, value in named.items()]
        try:
            shape = np.broadcast_shapes(*(a.shape for a in arrays))
        except ValueError as error:
            shapes = ", ".join(f"{name} {a.shape}" for name, a in zip(named, arrays, strict=True))
            raise InvalidParameterError(f"directions must have one shape (N, 3), but have: {shapes}") from error
        if len(shape) > 2:
            raise InvalidParameterError(f"directions must have the shape (N, 3), but have {shape}")
        rows = shape[0] if len(shape) == 2 else 1
        spread = [np.broadcast_to(a, (rows, 3)) for a in arrays]
        self._normal, self._light, self._viewer = spread[:3]
        self._tangent = spread[3] if tangent is not None else None
        self.result: NDArray[Any] = np.zeros((rows, components), dtype=floating_type(*arrays[:3]), order="F")

    def blocks(self) -> Iterator[tuple[slice, ReflectionGeometry]]:
        return geometry_blocks(self._normal, self._light, self._viewer)

    def tangent(self, block: slice) -> Float64:
        if self._tangent is None:
            raise InvalidParameterError("tangent must be given for an anisotropic material, but is None")
        components = np.array(self._tangent[block].T, dtype=np.float64, order="C")
        if not np.isfinite(components).all():
            raise InvalidParameterError("tangent must be finite, but one is not")
        return components
