"""Inhomogeneous dielectrics: plastic (Type I), cloth and paper (Type II). An interface lobe over a diffuse body."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..spectra import Spectrum, require_not_negative
from ..validation import require_choice, require_in_range
from .attenuation import ATTENUATIONS, MAX_EXPONENT, attenuation_of_geometry
from .conservation import InterfaceAlbedo
from .material import Material, Rays

__all__ = ["TypeI", "TypeII"]

Float64 = NDArray[np.float64]


class _InterfaceOverBody(Material):
    """What Types I and II share: S = f(rho) S_I + cos(phi) S_B."""

    __slots__ = ()

    body_reflectance: Spectrum
    attenuation: str
    n: float
    _albedo: InterfaceAlbedo | None

    def _check(self, largest_interface: float) -> None:
        require_not_negative("body_reflectance", self.body_reflectance)
        require_choice("attenuation", self.attenuation, ATTENUATIONS)
        object.__setattr__(self, "n", float(require_in_range("n", self.n, 0.0, MAX_EXPONENT)))
        object.__setattr__(self, "mirror", float(require_in_range("mirror", self.mirror, 0.0, 1.0)))
        albedo = InterfaceAlbedo(self.attenuation, self.n, largest_interface) if self.energy_conserving else None
        object.__setattr__(self, "_albedo", albedo)

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the components.

        Returns
        -------
        tuple of str
            ("interface", "body").

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 4.
        """
        return ("interface", "body")

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
        body_scale = 1.0 / max(1.0, float(self.body_reflectance.values.max()))
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


@dataclass(frozen=True, slots=True)
class TypeI(_InterfaceOverBody):
    """Plastic, paint, ceramic, wood: a neutral interface over a coloured body, S = f(rho) S_I + cos(phi) S_B.

    Parameters
    ----------
    body_reflectance : Spectrum
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

    body_reflectance: Spectrum
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

    @property
    def reflectances(self) -> tuple[Spectrum, ...]:
        """The spectra of the components.

        Returns
        -------
        tuple of Spectrum
            (constant S_I, S_B).

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 5.
        """
        return (Spectrum.constant(self.interface_reflectance, "interface"), self.body_reflectance)


@dataclass(frozen=True, slots=True)
class TypeII(_InterfaceOverBody):
    """Cloth and paper: a coloured interface over a coloured body, S = f(rho) S_I(lambda) + cos(phi) S_B(lambda).

    Parameters
    ----------
    body_reflectance : Spectrum
        S_B, not negative.
    interface_reflectance : Spectrum
        S_I, not negative.
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

    body_reflectance: Spectrum
    interface_reflectance: Spectrum
    attenuation: str = "exponential"
    n: float = 10.0
    energy_conserving: bool = False
    mirror: float = 0.0
    _albedo: InterfaceAlbedo | None = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_not_negative("interface_reflectance", self.interface_reflectance)
        self._check(float(self.interface_reflectance.values.max()))

    @property
    def reflectances(self) -> tuple[Spectrum, ...]:
        """The spectra of the components.

        Returns
        -------
        tuple of Spectrum
            (S_I, S_B).

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 6.
        """
        return (self.interface_reflectance, self.body_reflectance)
