"""Inhomogeneous dielectrics: plastic (Type I), cloth and paper (Type II). An interface lobe over a diffuse body."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..spectra import Spectrum, require_not_negative
from ..textured_reflectance import TexturedReflectance
from ..validation import require_choice, require_in_range
from .attenuation import ATTENUATIONS, MAX_EXPONENT, attenuation_of_geometry
from .conservation import InterfaceAlbedo
from .material import Material, Rays, spread_lobes

__all__ = ["TypeI", "TypeII"]

Float64 = NDArray[np.float64]
Reflectance = Spectrum | TexturedReflectance


class _InterfaceOverBody(Material):
    """What Types I and II share: S = f(rho) S_I + cos(phi) S_B."""

    __slots__ = ()

    body_reflectance: Reflectance
    interface_reflectance: float | Reflectance
    attenuation: str
    n: float
    _albedo: InterfaceAlbedo | None

    def _check(self, largest_interface: float) -> None:
        if not isinstance(self.body_reflectance, TexturedReflectance):
            require_not_negative("body_reflectance", self.body_reflectance)
        require_choice("attenuation", self.attenuation, ATTENUATIONS)
        object.__setattr__(self, "n", float(require_in_range("n", self.n, 0.0, MAX_EXPONENT)))
        object.__setattr__(self, "mirror", float(require_in_range("mirror", self.mirror, 0.0, 1.0)))
        albedo = InterfaceAlbedo(self.attenuation, self.n, largest_interface) if self.energy_conserving else None
        object.__setattr__(self, "_albedo", albedo)

    @property
    def textures(self) -> tuple[TexturedReflectance | None, ...]:
        """What varies over the surface.

        Returns
        -------
        tuple of TexturedReflectance or None
            Of interface and body; empty when neither is textured.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        both = (self.interface_reflectance, self.body_reflectance)
        textures = tuple(part if isinstance(part, TexturedReflectance) else None for part in both)
        return textures if any(textures) else ()

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the components.

        Returns
        -------
        tuple of str
            ("interface", "body"); a textured one is as many as its texture mixes: "body red", "body green" and so on.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 4.
        """
        return _names("interface", self.interface_reflectance) + _names("body", self.body_reflectance)

    @property
    def reflectances(self) -> tuple[Spectrum, ...]:
        """The spectra of the components.

        Returns
        -------
        tuple of Spectrum
            S_I (of Type I constant), then S_B; a textured one gives the spectra that its texture mixes.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eqs. 5 and 6.
        """
        return _spectra(self.interface_reflectance) + _spectra(self.body_reflectance)

    @property
    def needs_tangent(self) -> bool:
        """Whether :meth:`coefficients` needs tangents.

        Returns
        -------
        bool
            False.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return False

    def coefficients(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        tangent: ArrayLike | None = None,
        uv: ArrayLike | None = None,
    ) -> NDArray[Any]:
        """Geometric coefficients of the components: :meth:`lobes`, times what a texture has of each of its spectra.

        Parameters
        ----------
        normal, to_light, to_viewer, tangent : array_like (N, 3)
            As for :meth:`lobes`.
        uv : array_like (N, 2), optional
            Texture coordinates; needed by a textured material.

        Returns
        -------
        ndarray (N, Km)
            As :meth:`lobes`.

        Raises
        ------
        InvalidParameterError
            As :meth:`lobes`, or if the material is textured and there is no `uv`.

        References
        ----------
        Tominaga 1996, Eqs. 8 and 9; with `energy_conserving` the forms of docs/energy.md.
        """
        return spread_lobes(self, self.lobes(normal, to_light, to_viewer, tangent), uv)

    def untextured(self) -> Self:
        """Put in the place of textures the brightest reflectance that they show anywhere.

        Returns
        -------
        TypeI or TypeII
            A material without textures, at least as bright as this one at every point; itself if it has none.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        parts = {"interface_reflectance": self.interface_reflectance, "body_reflectance": self.body_reflectance}
        plain = {name: part.brightest for name, part in parts.items() if isinstance(part, TexturedReflectance)}
        return replace(self, **plain) if plain else self  # type: ignore[type-var]

    def lobes(
        self, normal: ArrayLike, to_light: ArrayLike, to_viewer: ArrayLike, tangent: ArrayLike | None = None
    ) -> NDArray[Any]:
        """Geometric coefficients c_I = f(rho) and c_B = cos(phi).

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        tangent : array_like (N, 3), optional
            Not used.

        Returns
        -------
        ndarray (N, 2)
            Not negative; 0 where N.L <= 0 or N.V <= 0. float32 if all vectors are, else float64.

        Raises
        ------
        InvalidParameterError
            If a vector is not finite or not of length 1 (to 5e-4), or the shapes do not fit.

        References
        ----------
        Tominaga 1996, Eqs. 8 and 9; with `energy_conserving` the forms of docs/energy.md.
        """
        rays = Rays(normal, to_light, to_viewer, None, 2)
        out = rays.result
        body_scale = 1.0 / max(1.0, _peak(self.body_reflectance))
        for block, geometry in rays.blocks():
            interface = attenuation_of_geometry(self.attenuation, self.n, geometry)
            body: Float64 = geometry.normal_light
            if self._albedo is not None:
                light = np.clip(geometry.normal_light, 0.0, 1.0)
                viewer = np.clip(geometry.normal_viewer, 0.0, 1.0)
                interface = interface * light * self._albedo.interface_scale
                body = body_scale * light * self._albedo.body_share(light, viewer)
            visible = geometry.visible
            np.copyto(out[block, 0], interface, where=visible, casting="same_kind")
            np.copyto(out[block, 1], body, where=visible, casting="same_kind")
        return out


def _spectra(reflectance: float | Reflectance) -> tuple[Spectrum, ...]:
    if isinstance(reflectance, TexturedReflectance):
        return reflectance.spectra
    return (reflectance if isinstance(reflectance, Spectrum) else Spectrum.constant(reflectance, "interface"),)


def _names(lobe: str, reflectance: float | Reflectance) -> tuple[str, ...]:
    if isinstance(reflectance, TexturedReflectance):
        return tuple(f"{lobe} {part}" for part in reflectance.part_names)
    return (lobe,)


def _peak(reflectance: Reflectance) -> float:
    plain = reflectance.brightest if isinstance(reflectance, TexturedReflectance) else reflectance
    return float(plain.values.max())


@dataclass(frozen=True, slots=True)
class TypeI(_InterfaceOverBody):
    """Plastic, paint, ceramic, wood: a neutral interface over a coloured body, S = f(rho) S_I + cos(phi) S_B.

    Parameters
    ----------
    body_reflectance : Spectrum or TexturedReflectance
        S_B, not negative.
    interface_reflectance : float
        S_I, the same at all wavelengths; not negative. The paper's cups use 5 (relative).
    attenuation : {"cosine", "exponential", "gaussian"}
        The law f(rho).
    n : float
        Sharpness of the highlight, 0 to 1e8.
    energy_conserving : bool
        False (default): the paper's formula exactly. True: the form of docs/energy.md.
    mirror : float
        Reflectance, at the strongest wavelength of S_I, with which the interface mirrors the scene, 0 to 1. 0
        (default): the paper's formula exactly.
    """

    body_reflectance: Reflectance
    interface_reflectance: float = 1.0
    attenuation: str = "cosine"
    n: float = 11.0
    energy_conserving: bool = False
    mirror: float = 0.0
    _albedo: InterfaceAlbedo | None = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        level = float(require_in_range("interface_reflectance", self.interface_reflectance, 0.0, 1.0e6))
        object.__setattr__(self, "interface_reflectance", level)
        self._check(level)


@dataclass(frozen=True, slots=True)
class TypeII(_InterfaceOverBody):
    """Cloth and paper: a coloured interface over a coloured body, S = f(rho) S_I(lambda) + cos(phi) S_B(lambda).

    Parameters
    ----------
    body_reflectance : Spectrum or TexturedReflectance
        S_B, not negative.
    interface_reflectance : Spectrum or TexturedReflectance
        S_I, not negative. A textured one does not mirror: `mirror` must be 0.
    attenuation : {"cosine", "exponential", "gaussian"}
        The law f(rho).
    n : float
        Sharpness of the highlight, 0 to 1e8.
    energy_conserving : bool
        False (default): the paper's formula exactly. True: the form of docs/energy.md.
    mirror : float
        Reflectance, at the strongest wavelength of S_I, with which the interface mirrors the scene, 0 to 1. 0
        (default): the paper's formula exactly.
    """

    body_reflectance: Reflectance
    interface_reflectance: Reflectance
    attenuation: str = "exponential"
    n: float = 10.0
    energy_conserving: bool = False
    mirror: float = 0.0
    _albedo: InterfaceAlbedo | None = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if isinstance(self.interface_reflectance, TexturedReflectance):
            if self.mirror != 0.0:
                raise InvalidParameterError(
                    f"mirror must be 0 where the interface reflectance is a texture, but is {self.mirror!r}"
                )
        else:
            require_not_negative("interface_reflectance", self.interface_reflectance)
        self._check(_peak(self.interface_reflectance))
