"""The lobe f(rho) of Types I and II as a model to fit, and how any lobe is fitted (metals: ``metal_lobe``).

A model gives the geometric coefficients of its spectra for the M geometries of a data set, and their derivatives. The
coefficients are those of the material classes; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError
from ..reflection.attenuation import ATTENUATIONS, attenuation_at_angle
from ..validation import require_choice, require_in_range
from .measurements import Measurements
from .separable import ModelTerms, SeparableFit, fit_separable, grid_start
from .uncertainty import Interval, NoiseEstimate, estimate_noise, log_interval

__all__ = ["BodyAndLobe", "LobeFit", "LobeModel", "WeightedFit", "fit_lobe", "fit_weighted"]

Array = NDArray[np.float64]

LARGEST_SPREAD = 1.0  # a standard deviation of ln n or ln beta beyond this tells nothing about n or beta
_EXPONENTS = (1.0e-3, 1.0e7)


class LobeModel(Protocol):
    """What :func:`fit_weighted` needs to know of a model."""

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of the parameters, two arrays (P,)."""

    def candidates(self) -> Array:
        """List starting values.

        Returns
        -------
        ndarray (K, P)
            Points to try.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """

    def __call__(self, p: Array) -> ModelTerms:
        """Evaluate the columns and their derivatives."""


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


def fit_weighted(model: LobeModel, data: Array, rounds: int = 4) -> WeightedFit:
    """Fit a model, estimate the noise from the residuals, weigh by it, and repeat.

    Parameters
    ----------
    model : LobeModel
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
    unit_variance = float(fit.parameter_covariance[0, 0])
    if not np.isfinite(unit_variance) or unit_variance * fit.cost / freedom > LARGEST_SPREAD**2:
        raise FittingError("n cannot be found: the averages do not tell how they fall with the angle from the mirror")
    deviation = float(np.sqrt(unit_variance * fit.cost / freedom))
    return LobeFit(
        kind,
        log_interval("n", float(fit.parameters[0]), deviation, freedom, confidence),
        flat.require_geometry("the lobe").from_mirror(),
        averages / top,
        fit.fitted[:, 0],
        tuple((name, float(np.sqrt(f.cost / data.size))) for name, f in fits.items()),
    )
