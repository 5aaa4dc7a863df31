"""The lobes as models to fit: f(rho) with its n for Types I and II, D with its beta for metals.

Each model gives the geometric coefficients of its spectra for the M geometries of a data set, and their derivatives.
The coefficients are those of the material classes; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError
from ..reflection.attenuation import ATTENUATIONS, attenuation_at_angle
from ..reflection.microfacet import attenuation_over_cosine, elliptic_facet_distribution
from ..validation import require_choice, require_in_range
from .measurements import Measurements
from .separable import ModelTerms, SeparableFit, fit_separable, grid_start
from .uncertainty import Interval, NoiseEstimate, estimate_noise, log_interval

__all__ = ["BodyAndLobe", "LobeFit", "MetalLobe", "WeightedFit", "fit_lobe", "fit_weighted"]

Array = NDArray[np.float64]

_EXPONENTS = (1.0e-3, 1.0e7)
_HALF_VALUES = (1.0e-4, 0.5 * np.pi)


class BodyAndLobe:
    """Types I and II: f(rho) times the interface, cos(phi) times the body (Eqs. 8 and 9).

    Parameters
    ----------
    measurements : Measurements
        With geometry.
    kind : {"cosine", "exponential", "gaussian"}
        The law of f.
    constant_interface : bool
        True for Type I: the interface is one number, not a spectrum.
    n : float, optional
        Held at this value; None fits it.
    """

    def __init__(self, measurements: Measurements, kind: str, constant_interface: bool, n: float | None = None) -> None:
        geometry = measurements.require_geometry("fitting the attenuation f")
        self.kind = require_choice("attenuation", kind, ATTENUATIONS)
        self.constant_interface = constant_interface
        self.n = None if n is None else float(require_in_range("n", n, 0.0, 1.0e8))
        self._rho = geometry.from_mirror()
        self._factor = measurements.reference_factor()
        self._body = np.cos(geometry.incidence) * self._factor

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of ln n.

        Returns
        -------
        tuple of ndarray (P,)
            Low and high; empty when n is held.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        if self.n is not None:
            return np.zeros(0), np.zeros(0)
        return np.log(_EXPONENTS[:1]), np.log(_EXPONENTS[1:])

    def candidates(self) -> Array:
        """List starting values of ln n.

        Returns
        -------
        ndarray (K, P)
            A grid; one empty row when n is held.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.zeros((1, 0)) if self.n is not None else np.log(np.geomspace(0.2, 1.0e5, 30))[:, None]

    def __call__(self, p: Array) -> ModelTerms:
        """Evaluate the columns and their derivatives by ln n."""
        n = float(np.exp(p[0])) if self.n is None else self.n
        lobe = attenuation_at_angle(self.kind, n, self._rho) * self._factor
        if self.n is not None:
            slope = np.zeros((0, lobe.size))
        elif self.kind == "cosine":
            cosine = np.cos(self._rho)
            slope = (n * np.log(np.where(cosine > 0.0, cosine, 1.0)) * lobe)[None]
        else:
            slope = (-n * (self._rho if self.kind == "exponential" else self._rho**2) * lobe)[None]
        if self.constant_interface:
            body_slope = np.zeros((slope.shape[0], lobe.size, 1))
            return ModelTerms(self._body[:, None], body_slope, flat=lobe, flat_slopes=slope)
        return ModelTerms(np.stack([lobe, self._body], axis=1), np.stack([slope, np.zeros_like(slope)], axis=2))


class MetalLobe:
    """Type III: D G / (N.V) times the reflectance of Eq. 13, up to a common scale of the measurement.

    The unknown spectrum is scale * S_I, the flat term scale * 1. The weight t = (Sa(phi) - Sa(0)) / (1 - Sa(0)) is
    given, or one unknown for each incidence but the smallest, where it is 0 (a measured table is held from there down
    to normal incidence).

    Parameters
    ----------
    measurements : Measurements
        With geometry.
    weight : ndarray (M,) or None
        t at each geometry; None fits it at each distinct incidence.
    anisotropic : bool
        Two half-value angles, along and across the grain.
    beta : tuple of float, optional
        Half-value angles along and across, held; None fits them.
    scale : float, optional
        Held at this value; None fits it.
    incidence : {"facet", "surface"}
        The angle phi: on the facet (half of that between L and V), or on the surface.
    """

    def __init__(
        self,
        measurements: Measurements,
        weight: Array | None,
        anisotropic: bool = False,
        beta: tuple[float, float] | None = None,
        scale: float | None = None,
        incidence: str = "facet",
    ) -> None:
        geometry = measurements.require_geometry("fitting the facet distribution D")
        require_choice("incidence", incidence, ("facet", "surface"))
        self.beta = beta
        self.scale = None if scale is None else float(require_in_range("scale", scale, 1.0e-12))
        self._angles = 0 if beta is not None else 1 + int(anisotropic)
        to_light, viewer, tangent = geometry.to_light(), geometry.to_viewer(), geometry.tangent()
        bisector = to_light + viewer
        sine = np.hypot(bisector[:, 0], bisector[:, 1])
        ratio = np.arctan2(sine, bisector[:, 2]) / np.where(sine > 0.0, sine, 1.0)
        self._along = ratio * (bisector[:, 0] * tangent[:, 0] + bisector[:, 1] * tangent[:, 1])
        self._across = ratio * (bisector[:, 1] * tangent[:, 0] - bisector[:, 0] * tangent[:, 1])
        self._masking = measurements.reference_factor() * attenuation_over_cosine(
            np.cos(geometry.incidence), np.cos(geometry.viewing), np.sum(bisector**2, axis=1)
        )
        angles = geometry.facet_incidence() if incidence == "facet" else geometry.incidence
        self.knots, self._knot = np.unique(np.round(angles, 6), return_inverse=True)
        self._schlick = (1.0 - np.cos(self.knots)) ** 5
        self._weight = weight
        if weight is None and self.knots.size > geometry.count // 2 and self.knots.size > 1 and not self._mirror_only():
            raise FittingError(
                f"a table of the mean reflectance has {self.knots.size} distinct incidences for {geometry.count} "
                "spectra: measure several spectra at each, or use another mean reflectance"
            )

    def _mirror_only(self) -> bool:
        return bool(np.all(np.hypot(self._along, self._across) < 1.0e-6))

    @property
    def table_size(self) -> int:
        """Number of unknown weights t.

        Returns
        -------
        int
            0 when the weights are given.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return 0 if self._weight is not None else self.knots.size - 1

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of ln beta (and ln beta across), then of the weights.

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
        low = [np.log(_HALF_VALUES[0])] * self._angles + [-20.0] * self.table_size
        high = [np.log(_HALF_VALUES[1])] * self._angles + [1.0] * self.table_size
        return np.array(low), np.array(high)

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (K, P)
            A grid in ln beta; the weights begin at Schlick's law.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        steps = np.log(np.radians(np.geomspace(0.3, 75.0, 24 if self._angles == 1 else 12)))
        grid = np.stack(np.meshgrid(*[steps] * self._angles, indexing="ij"), axis=-1).reshape(-1, self._angles)
        if self._angles == 0:
            grid = np.zeros((1, 0))
        table = np.tile(self._schlick[1:] if self.table_size else np.zeros(0), (grid.shape[0], 1))
        return np.concatenate([grid, table], axis=1)

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

    def weights(self, p: Array) -> Array:
        """Tell the weights t of a fitted table.

        Parameters
        ----------
        p : ndarray (P,)
            Parameters.

        Returns
        -------
        ndarray (K,)
            t at each of `knots`.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Eq. 13.
        """
        return np.concatenate([[0.0], p[self._angles :]])

    def __call__(self, p: Array) -> ModelTerms:
        """Evaluate the columns and their derivatives."""
        along, across = self.half_values(p)
        lobe = elliptic_facet_distribution(self._along, self._across, along, across) * self._masking
        slopes = [
            2.0 * np.log(2.0) * (tilt / beta) ** 2 * lobe
            for tilt, beta in ((self._along, along), (self._across, across))
        ]
        if self._angles == 1:
            slopes = [slopes[0] + slopes[1]]
        lobe_slopes = np.array(slopes[: self._angles]).reshape(self._angles, lobe.size)
        t = self._weight if self._weight is not None else self.weights(p)[self._knot]
        moves = np.zeros((self.table_size, lobe.size))
        if self.table_size:
            moves[:] = (self._knot[None, :] == np.arange(1, self.knots.size)[:, None]) * lobe
        free_slopes = np.concatenate([lobe_slopes * (1.0 - t), -moves])[:, :, None]
        constant, constant_slopes = lobe * t, np.concatenate([lobe_slopes * t, moves])
        free = (lobe * (1.0 - t))[:, None]
        if self.scale is None:
            return ModelTerms(free, free_slopes, flat=constant, flat_slopes=constant_slopes)
        return ModelTerms(free, free_slopes, fixed=self.scale * constant, fixed_slopes=self.scale * constant_slopes)


@dataclass(frozen=True, slots=True, eq=False)
class WeightedFit:
    """A fit with the noise that its own residuals show.

    Parameters
    ----------
    fit : SeparableFit
        The solution under the weights of that noise.
    noise : NoiseEstimate
        The noise.
    variance : float
        Of a value of unit weight.
    degrees_of_freedom : int
        Values minus unknowns.
    relative_residual : float
        Root of the mean squared residual over that of the data.
    criterion : float
        Bayes' information criterion; smaller is better.
    """

    fit: SeparableFit
    noise: NoiseEstimate
    variance: float
    degrees_of_freedom: int
    relative_residual: float
    criterion: float


def fit_weighted(model: BodyAndLobe | MetalLobe, data: Array, rounds: int = 4) -> WeightedFit:
    """Fit a model, estimate the noise from the residuals, weigh by it, and repeat.

    Parameters
    ----------
    model : BodyAndLobe or MetalLobe
        The model.
    data : ndarray (M, W)
        Measured values.
    rounds : int
        Most repetitions.

    Returns
    -------
    WeightedFit
        The last fit.

    Raises
    ------
    FittingError
        If there are fewer values than unknowns.

    References
    ----------
    Carroll and Ruppert, Transformation and Weighting in Regression, chapter 2 (generalised least squares).
    """
    largest = float(np.max(np.abs(data)))
    root = np.full(data.shape, 1.0 / largest)
    start = grid_start(model, model.candidates(), data, root)
    knee = 0.0
    for _ in range(rounds):
        fit = fit_separable(model, start, model.bounds, data, root)
        noise = estimate_noise(data - fit.fitted, fit.fitted, fit.leverage, largest)
        if noise.proportional * max(noise.knee, largest) < 1.0e-10 * largest or 0.95 < knee / noise.knee < 1.05:
            break
        knee, start = noise.knee, fit.parameters
        root = 1.0 / np.hypot(fit.fitted, knee)
    freedom = data.size - fit.unknowns
    return WeightedFit(
        fit,
        noise,
        fit.cost / freedom,
        freedom,
        float(np.linalg.norm(data - fit.fitted) / np.linalg.norm(data)),
        fit.unknowns * float(np.log(data.size)) - 2.0 * noise.log_likelihood,
    )


@dataclass(frozen=True, slots=True, eq=False)
class LobeFit:
    """The attenuation f fitted to the averages over wavelength, the counterpart of the paper's Fig. 7.

    Parameters
    ----------
    kind : str
        The law that fits best.
    n : Interval
        Its n.
    rho : ndarray (M,)
        Angles from the mirror direction, radians.
    averages, fitted : ndarray (M,)
        Averages of the spectra (relative to the irradiance facing the light) and the fit, the largest average 1.
    residuals : tuple of (str, float)
        Each law tried, with its root mean squared residual on that scale.
    """

    kind: str
    n: Interval
    rho: Array
    averages: Array
    fitted: Array
    residuals: tuple[tuple[str, float], ...]


def fit_lobe(measurements: Measurements, kinds: Iterable[str] = ATTENUATIONS, confidence: float = 0.95) -> LobeFit:
    """Find f's kind and n from the angle-resolved averages of the spectra.

    Parameters
    ----------
    measurements : Measurements
        With geometry; spectra at four or more angles from the mirror direction.
    kinds : iterable of str, optional
        The laws to try.
    confidence : float, optional
        Of the interval of n, between 0 and 1.

    Returns
    -------
    LobeFit
        The law with the smallest residual: a f(rho) + b cos(phi).

    Raises
    ------
    FittingError
        If there is no geometry, or the averages do not determine n.
    InvalidParameterError
        If a kind is unknown.

    References
    ----------
    Tominaga 1996, Fig. 7; the body is kept, where the figure shows the highlight alone.
    """
    averages = measurements.reflectances.mean(axis=1) / measurements.reference_factor()
    top = float(np.max(np.abs(averages)))
    if top == 0.0:
        raise FittingError("averages of the spectra must not all be zero")
    flat = Measurements(
        np.array([400.0, 550.0, 700.0]), np.tile((averages / top)[:, None], (1, 3)), measurements.geometry, "beam"
    )
    root = np.ones((measurements.count, 1))
    data = flat.reflectances[:, :1]
    fits: dict[str, SeparableFit] = {}
    for kind in kinds:
        model = BodyAndLobe(flat, kind, constant_interface=False)
        fits[kind] = fit_separable(model, grid_start(model, model.candidates(), data, root), model.bounds, data, root)
    if not fits:
        raise FittingError("kinds must name at least one attenuation")
    kind = min(fits, key=lambda name: fits[name].cost)
    fit = fits[kind]
    freedom = data.size - fit.unknowns
    deviation = float(np.sqrt(fit.parameter_covariance[0, 0] * fit.cost / freedom))
    if not np.isfinite(fit.parameter_covariance[0, 0]):
        raise FittingError("n cannot be found: the averages do not change with the angle from the mirror direction")
    return LobeFit(
        kind,
        log_interval("n", float(fit.parameters[0]), deviation, freedom, confidence),
        flat.require_geometry("the lobe").from_mirror(),
        averages / top,
        fit.fitted[:, 0],
        tuple((name, float(np.sqrt(f.cost / data.size))) for name, f in fits.items()),
    )
