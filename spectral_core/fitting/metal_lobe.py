"""The lobe of metals as a model to fit: D with its beta, and the mean reflectance Sa(phi) of Eq. 13.

Sa enters as the weight of the constant term, t = (Sa(phi) - Sa(0)) / (1 - Sa(0)). It may be known, follow Fresnel's
equations for one n and k that stand for all wavelengths, or be one number for each incidence that was measured.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError
from ..reflection.fresnel import absorptance
from ..reflection.microfacet import attenuation_over_cosine, elliptic_facet_distribution
from ..validation import require_choice, require_in_range
from .measurements import MeasurementGeometry, Measurements
from .separable import ModelTerms

__all__ = ["FixedWeight", "FresnelWeight", "MetalLobe", "TableWeight", "WeightModel", "metal_incidence"]

Array = NDArray[np.float64]

_HALF_VALUES = (1.0e-4, 0.5 * np.pi)
_REFRACTION, _EXTINCTION = (0.01, 8.0), (0.3, 15.0)
_TYPICAL = (0.8, 3.5)  # in the middle of the metals: copper, gold and brass near it, silver and aluminium at its sides
_STEP = 1.0e-5  # of the numerical derivative: the error of central differences is about its square


def metal_incidence(geometry: MeasurementGeometry, incidence: str) -> Array:
    """Tell the angles phi of Eq. 13.

    Parameters
    ----------
    geometry : MeasurementGeometry
        Of M measurements.
    incidence : {"facet", "surface"}
        On the facet, half the angle between L and V, or on the surface.

    Returns
    -------
    ndarray (M,)
        Radians.

    Raises
    ------
    InvalidParameterError
        If the choice is unknown.

    References
    ----------
    Tominaga 1996, Eqs. 10 and 13.
    """
    require_choice("incidence", incidence, ("facet", "surface"))
    return geometry.facet_incidence() if incidence == "facet" else geometry.incidence


class WeightModel(Protocol):
    """The weight t as a function of Q parameters."""

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of the parameters, two arrays (Q,)."""

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (K, Q)
            Points to try.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Evaluate the weight.

        Parameters
        ----------
        q : ndarray (Q,)
            Parameters.

        Returns
        -------
        weight : ndarray (M,)
            t.
        slopes : ndarray (Q, M)
            Derivatives.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """


class FixedWeight:
    """A weight that is known.

    Parameters
    ----------
    weight : ndarray (M,)
        t at each geometry.
    """

    def __init__(self, weight: Array) -> None:
        self._weight = weight

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of the parameters.

        Returns
        -------
        tuple of ndarray (0,)
            There are none.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.zeros(0), np.zeros(0)

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (1, 0)
            One empty row.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.zeros((1, 0))

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Evaluate the weight.

        Parameters
        ----------
        q : ndarray (0,)
            Nothing.

        Returns
        -------
        weight : ndarray (M,)
            t.
        slopes : ndarray (0, M)
            No derivatives.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return self._weight, np.zeros((0, self._weight.size))


class FresnelWeight:
    """The weight of a smooth metal with one refractive index n and extinction coefficient k; q = (ln n, ln k).

    Parameters
    ----------
    incidence : ndarray (M,)
        phi in radians.
    """

    def __init__(self, incidence: Array) -> None:
        self._cosine = np.cos(incidence)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of ln n and ln k.

        Returns
        -------
        tuple of ndarray (2,)
            Low and high: n from 0.01 to 8, k from 0.3 to 15, wider than all metals in visible light.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.log([_REFRACTION[0], _EXTINCTION[0]]), np.log([_REFRACTION[1], _EXTINCTION[1]])

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (1, 2)
            ln n and ln k of a typical metal.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.log(np.array([_TYPICAL]))

    def _weight(self, q: Array) -> Array:
        n, k = np.exp(q)
        return np.asarray(1.0 - absorptance(self._cosine, n, k) / absorptance(1.0, n, k))

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Evaluate the weight.

        Parameters
        ----------
        q : ndarray (2,)
            ln n and ln k.

        Returns
        -------
        weight : ndarray (M,)
            t; it may be negative.
        slopes : ndarray (2, M)
            Derivatives, by central differences.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13; Born & Wolf, Principles of Optics, 14.2.
        """
        steps = _STEP * np.eye(2)
        slopes = [(self._weight(q + step) - self._weight(q - step)) / (2.0 * _STEP) for step in steps]
        return self._weight(q), np.array(slopes)


class TableWeight:
    """One weight for each distinct incidence, 0 at the smallest: tables are held from there to normal incidence.

    Parameters
    ----------
    incidence : ndarray (M,)
        phi in radians; angles that agree to 1e-6 are one.
    several_each : bool
        Whether two spectra at each incidence are needed (away from the mirror direction, where D is unknown too).

    Raises
    ------
    FittingError
        If there are too many distinct incidences.
    """

    def __init__(self, incidence: Array, several_each: bool) -> None:
        self.knots, self._knot = np.unique(np.round(incidence, 6), return_inverse=True)
        if several_each and self.knots.size > max(1, incidence.size // 2):
            raise FittingError(
                f"a table of the mean reflectance has {self.knots.size} distinct incidences for {incidence.size} "
                "spectra: measure several spectra at each, or use another mean reflectance"
            )

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of the weights.

        Returns
        -------
        tuple of ndarray (K - 1,)
            Low and high.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.full(self.knots.size - 1, -20.0), np.ones(self.knots.size - 1)

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (1, K - 1)
            Schlick's weights.

        Raises
        ------
        None.

        References
        ----------
        Schlick (1994), "An inexpensive BRDF model for physically-based rendering".
        """
        return ((1.0 - np.cos(self.knots[1:])) ** 5)[None]

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Evaluate the weight.

        Parameters
        ----------
        q : ndarray (K - 1,)
            t at each of `knots` but the first.

        Returns
        -------
        weight : ndarray (M,)
            t.
        slopes : ndarray (K - 1, M)
            Derivatives.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        weight = np.concatenate([[0.0], q])[self._knot]
        return weight, (self._knot[None, :] == np.arange(1, self.knots.size)[:, None]).astype(np.float64)


class MetalLobe:
    """Type III: D G / (N.V) times the reflectance of Eq. 13, up to a common scale of the measurement.

    The unknown spectrum is scale * S_I, the flat term scale * 1. The parameters are ln beta (then ln beta across), then
    those of the weight.

    Parameters
    ----------
    measurements : Measurements
        With geometry.
    weight : WeightModel
        The weight t at each geometry.
    anisotropic : bool
        Two half-value angles, along and across the grain.
    beta : tuple of float, optional
        Half-value angles along and across, held; None fits them.
    scale : float, optional
        Held at this value; None fits it.
    """

    def __init__(
        self,
        measurements: Measurements,
        weight: WeightModel,
        anisotropic: bool = False,
        beta: tuple[float, float] | None = None,
        scale: float | None = None,
    ) -> None:
        geometry = measurements.require_geometry("fitting the facet distribution D")
        self.beta = beta
        self.weight = weight
        self.anisotropic = anisotropic
        self.scale = None if scale is None else float(require_in_range("scale", scale, 1.0e-12))
        self._angles = 0 if beta is not None else 1 + int(anisotropic)
        bisector, tangent = geometry.to_light() + geometry.to_viewer(), geometry.tangent()
        sine = np.hypot(bisector[:, 0], bisector[:, 1])
        ratio = np.arctan2(sine, bisector[:, 2]) / np.where(sine > 0.0, sine, 1.0)
        self._along = ratio * (bisector[:, 0] * tangent[:, 0] + bisector[:, 1] * tangent[:, 1])
        self._across = ratio * (bisector[:, 1] * tangent[:, 0] - bisector[:, 0] * tangent[:, 1])
        self._masking = measurements.reference_factor() * attenuation_over_cosine(
            np.cos(geometry.incidence), np.cos(geometry.viewing), np.minimum(np.sum(bisector**2, axis=1), 4.0)
        )

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of the parameters.

        Returns
        -------
        tuple of ndarray (P,)
            Low and high.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        low, high = self.weight.bounds
        return (
            np.concatenate([np.full(self._angles, np.log(_HALF_VALUES[0])), low]),
            np.concatenate([np.full(self._angles, np.log(_HALF_VALUES[1])), high]),
        )

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (K, P)
            A grid in ln beta, with each start of the weight.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        steps = np.log(np.radians(np.geomspace(0.3, 75.0, 24 if self._angles == 1 else 12)))
        grid = np.stack(np.meshgrid(*[steps] * self._angles, indexing="ij"), axis=-1) if self._angles else np.zeros(0)
        grid = grid.reshape(-1, self._angles) if self._angles else np.zeros((1, 0))
        starts = self.weight.candidates()
        return np.concatenate([np.repeat(grid, starts.shape[0], axis=0), np.tile(starts, (grid.shape[0], 1))], axis=1)

    def half_values(self, p: Array) -> tuple[float, float]:
        """Tell the half-value angles along and across the grain.

        Parameters
        ----------
        p : ndarray (P,)
            Parameters.

        Returns
        -------
        tuple of float
            Radians.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 11.
        """
        if self.beta is not None:
            return self.beta
        beta = np.exp(p[: self._angles])
        return float(beta[0]), float(beta[-1])

    def weight_parameters(self, p: Array) -> Array:
        """Pick the parameters of the weight.

        Parameters
        ----------
        p : ndarray (P,)
            Parameters.

        Returns
        -------
        ndarray (Q,)
            The last Q of them.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return p[self._angles :]

    def __call__(self, p: Array) -> ModelTerms:
        """Evaluate the columns and their derivatives."""
        along, across = self.half_values(p)
        lobe = elliptic_facet_distribution(self._along, self._across, along, across) * self._masking
        slopes = np.array(
            [
                2.0 * np.log(2.0) * (tilt / beta) ** 2 * lobe
                for tilt, beta in ((self._along, along), (self._across, across))
            ]
        )
        lobe_slopes = slopes.sum(axis=0)[None] if self._angles == 1 else slopes[: self._angles]
        t, t_slopes = self.weight.evaluate(self.weight_parameters(p))
        free_slopes = np.concatenate([lobe_slopes * (1.0 - t), -lobe * t_slopes])[:, :, None]
        constant, constant_slopes = lobe * t, np.concatenate([lobe_slopes * t, lobe * t_slopes])
        free = (lobe * (1.0 - t))[:, None]
        if self.scale is None:
            return ModelTerms(free, free_slopes, flat=constant, flat_slopes=constant_slopes)
        return ModelTerms(free, free_slopes, fixed=self.scale * constant, fixed_slopes=self.scale * constant_slopes)
