"""Metals (Type III): no body, two interface terms, on a rough surface of microfacets."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..optical_constants import OpticalConstants
from ..spectra import Spectrum, require_not_negative
from ..validation import require_choice, require_in_range
from .angles import within
from .conservation import facet_normalisation
from .fresnel import fresnel_conductor
from .material import Material, Rays
from .mean_reflectance import MEAN_BAND_NM, MeanReflectance, OpticalMeanReflectance, SchlickMeanReflectance
from .microfacet import distribution_of_tilt, elliptic_distribution, geometry_over_cosine

__all__ = ["GRAZING", "INCIDENCES", "TypeIII"]

INCIDENCES = ("facet", "surface")
"""The incidence that Eq. 13 is taken at: on the microfacet, angle(L, H), or on the macroscopic surface, angle(L, N)."""

GRAZING = "grazing"
"""Name of the metals' second component, whose reflectance is the constant 1 of Eq. 13."""


@lru_cache(maxsize=32)
def _mean_of(constants: OpticalConstants) -> OpticalMeanReflectance:
    """Sa(phi) of a metal; its table takes tens of milliseconds, and a scene is read again at every edit."""
    return OpticalMeanReflectance(*constants.at(MEAN_BAND_NM))


@dataclass(frozen=True, slots=True)
class TypeIII(Material):
    """Metal: no body, two interface terms, S = D G / (N.V) * [w(phi) S_I(lambda) + (1 - w(phi))].

    Parameters
    ----------
    normal_reflectance : Spectrum
        S_I, the reflectance at normal incidence, 0 to 1.
    mean_reflectance : MeanReflectance
        Knows w(phi) = (1 - Sa(phi)) / (1 - Sa(0)) of Eq. 13.
    beta : float
        Half-value angle of the facet distribution in radians, 0 to pi/2. Along the tangent, if anisotropic.
    beta_across : float, optional
        Half-value angle across the tangent in radians, 0 to pi/2. None (default): isotropic, the paper's Eq. 11.
        Grooves along the tangent (brushed, spin-finished) scatter across it: beta_across > beta.
    incidence : {"facet", "surface"}
        Which incidence Eq. 13 is taken at. "The spectral reflectance of the surface microfacets" is the facet's.
    energy_conserving : bool
        False (default): the paper's formula exactly. True: the form of docs/energy.md; beta then is at least 1e-6.
    mirror : float
        Share of Eq. 13's reflectance with which the surface mirrors the scene, 0 to 1. 0 (default): the paper's
        formula exactly.
    """

    normal_reflectance: Spectrum
    mean_reflectance: MeanReflectance
    beta: float
    beta_across: float | None = None
    incidence: str = "facet"
    energy_conserving: bool = False
    mirror: float = 0.0
    _scale: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "mirror", float(require_in_range("mirror", self.mirror, 0.0, 1.0)))
        require_not_negative("normal_reflectance", self.normal_reflectance)
        require_in_range("normal_reflectance", self.normal_reflectance.values, 0.0, 1.0)
        if not isinstance(self.mean_reflectance, MeanReflectance):
            raise InvalidParameterError(f"mean_reflectance must be a MeanReflectance, but is {self.mean_reflectance!r}")
        object.__setattr__(self, "beta", float(within("beta", self.beta, 0.0, np.pi / 2)))
        if self.beta_across is not None:
            across = float(within("beta_across", self.beta_across, 0.0, np.pi / 2))
            object.__setattr__(self, "beta_across", across)
        require_choice("incidence", self.incidence, INCIDENCES)
        scale = facet_normalisation(self.beta, self.beta_across) if self.energy_conserving else 1.0
        object.__setattr__(self, "_scale", scale)

    @classmethod
    def from_optical_constants(
        cls,
        constants: OpticalConstants,
        beta: float,
        *,
        beta_across: float | None = None,
        incidence: str = "facet",
        energy_conserving: bool = False,
        mirror: float = 0.0,
    ) -> TypeIII:
        """Make a metal from its refractive index and extinction coefficient.

        Parameters
        ----------
        constants : OpticalConstants
            n and k over wavelength. S_I is the Fresnel reflectance at normal incidence at every wavelength of the
            table and every 5 nm between 380 and 780 nm; Sa(phi) is the mean over 400 to 700 nm at 5 nm.
        beta, beta_across, incidence, energy_conserving, mirror
            As for the class.

        Returns
        -------
        TypeIII
            The metal.

        Raises
        ------
        InvalidParameterError
            If a parameter lies outside its range.

        References
        ----------
        Tominaga 1996, Eq. 13 and the validation of Fig. 9.
        """
        wavelengths = np.union1d(constants.wavelengths_nm, np.arange(380.0, 781.0, 5.0))
        wavelengths = wavelengths[(wavelengths >= 300.0) & (wavelengths <= 900.0)]
        n, k = constants.at(wavelengths)
        reflectance = Spectrum(wavelengths, fresnel_conductor(1.0, n, k), constants.name)
        return cls(reflectance, _mean_of(constants), beta, beta_across, incidence, energy_conserving, mirror)

    @classmethod
    def from_normal_reflectance(
        cls,
        normal_reflectance: Spectrum,
        beta: float,
        *,
        beta_across: float | None = None,
        incidence: str = "facet",
        energy_conserving: bool = False,
        mirror: float = 0.0,
    ) -> TypeIII:
        """Make a metal of which only the reflectance at normal incidence is known; Schlick's law gives Sa(phi).

        Parameters
        ----------
        normal_reflectance : Spectrum
            S_I, 0 to 1. Sa(0) is its mean over 400 to 700 nm at 5 nm.
        beta, beta_across, incidence, energy_conserving, mirror
            As for the class.

        Returns
        -------
        TypeIII
            The metal.

        Raises
        ------
        InvalidParameterError
            If a parameter lies outside its range.

        References
        ----------
        Tominaga 1996, Eq. 13; Schlick (1994).
        """
        require_not_negative("normal_reflectance", normal_reflectance)
        require_in_range("normal_reflectance", normal_reflectance.values, 0.0, 1.0)
        mean = SchlickMeanReflectance(float(np.clip(normal_reflectance.at(MEAN_BAND_NM).mean(), 0.0, 1.0)))
        return cls(normal_reflectance, mean, beta, beta_across, incidence, energy_conserving, mirror)

    @property
    def reflectances(self) -> tuple[Spectrum, ...]:
        """The spectra of the components.

        Returns
        -------
        tuple of Spectrum
            (S_I, constant 1).

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 7.
        """
        return (self.normal_reflectance, Spectrum.constant(1.0, GRAZING))

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the components.

        Returns
        -------
        tuple of str
            ("normal", "grazing").

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 7.
        """
        return ("normal", GRAZING)

    @property
    def needs_tangent(self) -> bool:
        """Whether :meth:`coefficients` needs tangents.

        Returns
        -------
        bool
            True if the metal is anisotropic.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return self.beta_across is not None and self.beta_across != self.beta

    def coefficients(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        tangent: ArrayLike | None = None,
        uv: ArrayLike | None = None,
    ) -> NDArray[Any]:
        """Geometric coefficients D G / (N.V) * w(phi) and D G / (N.V) * (1 - w(phi)).

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        tangent : array_like (N, 3), optional
            Directions along the surface, any length (the part along the normal is removed); needed if anisotropic.
            Where one is parallel to the normal, a fixed direction across the normal takes its place.
        uv : array_like (N, 2), optional
            Not used: metals have no textures.

        Returns
        -------
        ndarray (N, 2)
            0 where N.L <= 0 or N.V <= 0. The second may be negative, where the metal reflects less than at normal
            incidence; their sum is not negative. float32 if the first three vectors are, else float64. Where the true
            value passes the largest float (a light at the horizon) it saturates at 1/256 of that.

        Raises
        ------
        InvalidParameterError
            If a vector is not finite or (tangents aside) not of length 1 (to 5e-4), the shapes do not fit, or tangents
            are missing for an anisotropic metal.

        References
        ----------
        Tominaga 1996, Eqs. 10 to 13.
        """
        anisotropic = self.needs_tangent
        rays = Rays(normal, to_light, to_viewer, tangent if anisotropic else None, 2)
        out = rays.result
        limit = float(np.finfo(out.dtype).max) / 256.0
        for block, geometry in rays.blocks():
            bisector = geometry.bisector()
            if anisotropic and self.beta_across is not None:
                tangent_of = rays.tangent(block)
                facets = elliptic_distribution(geometry.normal, bisector, tangent_of, self.beta, self.beta_across)
            else:
                facets = distribution_of_tilt(bisector.facet_tilt(), self.beta)
            facets *= geometry_over_cosine(bisector)
            facets *= self._scale
            np.minimum(facets, limit, out=facets)
            if self.incidence == "facet":
                cosine = bisector.facet_cosine()
            else:
                cosine = np.clip(geometry.normal_light, 0.0, 1.0)
            coloured = self.mean_reflectance.weight_of_checked(cosine)
            coloured *= facets
            facets -= coloured
            visible = geometry.visible
            np.copyto(out[block, 0], coloured, where=visible, casting="same_kind")
            np.copyto(out[block, 1], facets, where=visible, casting="same_kind")
        return out
