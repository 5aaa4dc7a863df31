"""The three materials of the paper: plastic (Type I), cloth and paper (Type II), metal (Type III).

Each material splits its radiance factor into geometric coefficients, which know no wavelength, and reflectances,
which know no direction: radiance_factor = coefficients @ reflectances. The radiance that leaves the surface is
radiance_factor * E / pi, where E is the irradiance on a plane that faces the light; the pi is the one that the paper
drops for relative work (Eq. 3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..optical_constants import OpticalConstants
from ..spectra import Spectrum
from ..validation import require_choice, require_in_range
from .angles import ReflectionGeometry, floating_type, geometry_blocks, vectors, within
from .attenuation import ATTENUATIONS, MAX_EXPONENT, attenuation_of_geometry
from .conservation import InterfaceAlbedo, facet_normalisation
from .fresnel import fresnel_conductor
from .mean_reflectance import MEAN_BAND_NM, MeanReflectance, OpticalMeanReflectance, SchlickMeanReflectance
from .microfacet import distribution_of_tilt, elliptic_distribution, geometry_over_cosine

__all__ = ["GRAZING", "INCIDENCES", "Material", "TypeI", "TypeII", "TypeIII"]

Float64 = NDArray[np.float64]

INCIDENCES = ("facet", "surface")
"""The incidence that Eq. 13 is taken at: on the microfacet, angle(L, H), or on the macroscopic surface, angle(L, N)."""

GRAZING = "grazing"
"""Name of the metals' second component, whose reflectance is the constant 1 of Eq. 13."""


class Material(Protocol):
    """What every material offers to a renderer."""

    @property
    def reflectances(self) -> tuple[Spectrum, ...]:
        """The Km spectra of the components."""

    @property
    def component_names(self) -> tuple[str, ...]:
        """Names of the Km components."""

    @property
    def energy_conserving(self) -> bool:
        """Whether the paper's formulas are replaced by the conserving ones of docs/energy.md."""

    @property
    def needs_tangent(self) -> bool:
        """Whether `coefficients` needs tangents."""

    @property
    def mirror(self) -> float:
        """How strongly the surface mirrors the scene, 0 to 1."""

    def coefficients(
        self, normal: ArrayLike, to_light: ArrayLike, to_viewer: ArrayLike, tangent: ArrayLike | None = None
    ) -> NDArray[Any]:
        """Geometric coefficients, which know no wavelength.

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        tangent : array_like (N, 3), optional
            Directions along the surface, for materials that need them.

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
    ) -> NDArray[Any]:
        """Spectral radiance factor, coefficients @ reflectances.

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        wavelengths_nm : array_like (W,)
            Wavelengths in nm.
        tangent : array_like (N, 3), optional
            Directions along the surface, for materials that need them.

        Returns
        -------
        ndarray (N, W)
            Not negative.

        Raises
        ------
        InvalidParameterError
            As :meth:`coefficients`, or if a wavelength is not finite.

        References
        ----------
        Tominaga 1996, Eq. 3.
        """


class _Rays:
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
        self.result: NDArray[Any] = np.zeros((rows, components), dtype=floating_type(*arrays[:3]))

    def blocks(self) -> Iterator[tuple[slice, ReflectionGeometry]]:
        return geometry_blocks(self._normal, self._light, self._viewer)

    def tangent(self, block: slice) -> Float64:
        if self._tangent is None:
            raise InvalidParameterError("tangent must be given for an anisotropic material, but is None")
        components = np.array(self._tangent[block].T, dtype=np.float64, order="C")
        if not np.isfinite(components).all():
            raise InvalidParameterError("tangent must be finite, but one is not")
        return components


def _radiance_factor(
    coefficients: NDArray[Any], reflectances: tuple[Spectrum, ...], wavelengths_nm: ArrayLike
) -> NDArray[Any]:
    spectra = np.stack([s.at(wavelengths_nm) for s in reflectances]).astype(coefficients.dtype)
    if spectra.ndim != 2:
        raise InvalidParameterError(f"wavelengths_nm must be a list, but has the shape {spectra.shape[1:]}")
    product = coefficients @ spectra
    return np.asarray(np.maximum(product, 0.0, out=product))


def _interface_and_body(
    rays: _Rays, attenuation: str, n: float, conserving: InterfaceAlbedo | None, body_scale: float
) -> NDArray[Any]:
    """f(rho) and cos(phi) of Eqs. 8 and 9, or their conserving forms."""
    out = rays.result
    for block, geometry in rays.blocks():
        interface = attenuation_of_geometry(attenuation, n, geometry)
        body: Float64 = geometry.normal_light
        if conserving is not None:
            light = np.clip(geometry.normal_light, 0.0, 1.0)
            viewer = np.clip(geometry.normal_viewer, 0.0, 1.0)
            interface = interface * light * conserving.interface_scale
            body = body_scale * light * conserving.body_share(light, viewer)
        visible = geometry.visible
        np.copyto(out[block, 0], interface, where=visible, casting="same_kind")
        np.copyto(out[block, 1], body, where=visible, casting="same_kind")
    return out


def _conserving(material: TypeI | TypeII, largest_interface: float) -> InterfaceAlbedo | None:
    if not material.energy_conserving:
        return None
    return InterfaceAlbedo(material.attenuation, material.n, largest_interface)


def _body_scale(body: Spectrum) -> float:
    return 1.0 / max(1.0, float(body.values.max()))


@dataclass(frozen=True, slots=True)
class TypeI:
    """Plastic, paint, ceramic, wood: a neutral interface over a coloured body, S = f(rho) S_I + cos(phi) S_B.

    Parameters
    ----------
    body_reflectance : Spectrum
        S_B.
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
        object.__setattr__(self, "mirror", float(require_in_range("mirror", self.mirror, 0.0, 1.0)))
        level = float(require_in_range("interface_reflectance", self.interface_reflectance, 0.0, 1.0e6))
        object.__setattr__(self, "interface_reflectance", level)
        require_choice("attenuation", self.attenuation, ATTENUATIONS)
        object.__setattr__(self, "n", float(require_in_range("n", self.n, 0.0, MAX_EXPONENT)))
        object.__setattr__(self, "_albedo", _conserving(self, level))

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
        Tominaga 1996, Eq. 8.
        """
        rays = _Rays(normal, to_light, to_viewer, None, 2)
        return _interface_and_body(rays, self.attenuation, self.n, self._albedo, _body_scale(self.body_reflectance))

    def radiance_factor(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        wavelengths_nm: ArrayLike,
        tangent: ArrayLike | None = None,
    ) -> NDArray[Any]:
        """Spectral radiance factor; times E / pi it is the radiance, E the irradiance on a plane facing the light.

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        wavelengths_nm : array_like (W,)
            Wavelengths in nm.
        tangent : array_like (N, 3), optional
            Not used.

        Returns
        -------
        ndarray (N, W)
            Not negative, in the type of :meth:`coefficients`.

        Raises
        ------
        InvalidParameterError
            As :meth:`coefficients`, or if a wavelength is not finite.

        References
        ----------
        Tominaga 1996, Eqs. 3 and 8.
        """
        return _radiance_factor(
            self.coefficients(normal, to_light, to_viewer, tangent), self.reflectances, wavelengths_nm
        )


@dataclass(frozen=True, slots=True)
class TypeII:
    """Cloth and paper: a coloured interface over a coloured body, S = f(rho) S_I(lambda) + cos(phi) S_B(lambda).

    Parameters
    ----------
    body_reflectance : Spectrum
        S_B.
    interface_reflectance : Spectrum
        S_I.
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
        object.__setattr__(self, "mirror", float(require_in_range("mirror", self.mirror, 0.0, 1.0)))
        require_choice("attenuation", self.attenuation, ATTENUATIONS)
        object.__setattr__(self, "n", float(require_in_range("n", self.n, 0.0, MAX_EXPONENT)))
        object.__setattr__(self, "_albedo", _conserving(self, float(self.interface_reflectance.values.max())))

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
        Tominaga 1996, Eq. 6.
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
        Tominaga 1996, Eq. 9.
        """
        rays = _Rays(normal, to_light, to_viewer, None, 2)
        return _interface_and_body(rays, self.attenuation, self.n, self._albedo, _body_scale(self.body_reflectance))

    def radiance_factor(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        wavelengths_nm: ArrayLike,
        tangent: ArrayLike | None = None,
    ) -> NDArray[Any]:
        """Spectral radiance factor; times E / pi it is the radiance, E the irradiance on a plane facing the light.

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        wavelengths_nm : array_like (W,)
            Wavelengths in nm.
        tangent : array_like (N, 3), optional
            Not used.

        Returns
        -------
        ndarray (N, W)
            Not negative, in the type of :meth:`coefficients`.

        Raises
        ------
        InvalidParameterError
            As :meth:`coefficients`, or if a wavelength is not finite.

        References
        ----------
        Tominaga 1996, Eqs. 3 and 9.
        """
        return _radiance_factor(
            self.coefficients(normal, to_light, to_viewer, tangent), self.reflectances, wavelengths_nm
        )


@dataclass(frozen=True, slots=True)
class TypeIII:
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
        mean = OpticalMeanReflectance(*constants.at(MEAN_BAND_NM))
        return cls(reflectance, mean, beta, beta_across, incidence, energy_conserving, mirror)

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
        self, normal: ArrayLike, to_light: ArrayLike, to_viewer: ArrayLike, tangent: ArrayLike | None = None
    ) -> NDArray[Any]:
        """Geometric coefficients D G / (N.V) * w(phi) and D G / (N.V) * (1 - w(phi)).

        Parameters
        ----------
        normal, to_light, to_viewer : array_like (N, 3)
            Unit vectors that point away from the surface; a single vector serves all rows.
        tangent : array_like (N, 3), optional
            Directions along the surface, any length (the part along the normal is removed); needed if anisotropic.
            Where one is parallel to the normal, a fixed direction across the normal takes its place.

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
        rays = _Rays(normal, to_light, to_viewer, tangent if anisotropic else None, 2)
        out = rays.result
        limit = float(np.finfo(out.dtype).max) / 256.0
        for block, geometry in rays.blocks():
            if anisotropic and self.beta_across is not None:
                facets = elliptic_distribution(geometry, rays.tangent(block), self.beta, self.beta_across)
            else:
                facets = distribution_of_tilt(geometry.facet_tilt(), self.beta)
            facets *= geometry_over_cosine(geometry)
            facets *= self._scale
            np.minimum(facets, limit, out=facets)
            if self.incidence == "facet":
                cosine = geometry.facet_cosine()
            else:
                cosine = np.clip(geometry.normal_light, 0.0, 1.0)
            weight = self.mean_reflectance.weight_of_checked(cosine)
            visible = geometry.visible
            coloured = facets * weight
            np.copyto(out[block, 0], coloured, where=visible, casting="same_kind")
            np.copyto(out[block, 1], facets - coloured, where=visible, casting="same_kind")
        return out

    def radiance_factor(
        self,
        normal: ArrayLike,
        to_light: ArrayLike,
        to_viewer: ArrayLike,
        wavelengths_nm: ArrayLike,
        tangent: ArrayLike | None = None,
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
        Tominaga 1996, Eqs. 3 and 10.
        """
        return _radiance_factor(
            self.coefficients(normal, to_light, to_viewer, tangent), self.reflectances, wavelengths_nm
        )
