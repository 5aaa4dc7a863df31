"""Noise of the measured values, as the residuals show it, and intervals for what was fitted.

The standard deviation of a value is taken as ``proportional * sqrt(model^2 + knee^2)``: in proportion to the value
where that is large, even where it is small. Both numbers come from the residuals by maximum likelihood, so that nobody
has to know beforehand which kind of noise an instrument has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidParameterError
from ..validation import require_finite, require_in_range
from .distributions import student_t_quantile

__all__ = ["Interval", "NoiseEstimate", "SpectrumEstimate", "estimate_noise", "log_interval", "spectrum_interval"]

Array = NDArray[np.float64]

_RESOLUTION = 1.0e-7  # differences below this share of the largest value are rounding, not evidence


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimated number with its confidence interval.

    Parameters
    ----------
    name : str
        Name of the number, such as ``"n"``.
    value, low, high : float
        Estimate and ends of the interval.
    unit : str
        Unit of all three, empty for pure numbers.
    """

    name: str
    value: float
    low: float
    high: float
    unit: str = ""

    def __post_init__(self) -> None:
        require_finite(f"{self.name} of the estimate", self.value)
        if not self.low <= self.value <= self.high:
            raise InvalidParameterError(
                f"interval of {self.name} must hold its value {self.value:g}, but runs from {self.low:g} to "
                f"{self.high:g}"
            )

    def describe(self) -> str:
        """Tell the number and its interval in words.

        Returns
        -------
        str
            Such as ``"n = 10.02 (9.87 to 10.17)"``.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.name} = {self.value:.6g}{unit} ({self.low:.6g} to {self.high:.6g})"


@dataclass(frozen=True, slots=True, eq=False)
class SpectrumEstimate:
    """An estimated spectrum with a confidence interval at each wavelength.

    Parameters
    ----------
    wavelengths_nm : ndarray (W,)
        Wavelengths in nm.
    values, low, high : ndarray (W,)
        Estimate and ends of the intervals; noise may leave values below 0.
    """

    wavelengths_nm: Array
    values: Array
    low: Array
    high: Array


@dataclass(frozen=True, slots=True)
class NoiseEstimate:
    """Noise of the measured values.

    Parameters
    ----------
    proportional : float
        Standard deviation as a share of large values.
    knee : float
        Value below which the noise stops falling, in the unit of the data; far above the data the noise is uniform.
    log_likelihood : float
        Of the residuals under this noise, limited where differences are rounding.
    """

    proportional: float
    knee: float
    log_likelihood: float

    def deviation(self, model: Array) -> Array:
        """Tell the standard deviation of values.

        Parameters
        ----------
        model : ndarray
            True values, any shape.

        Returns
        -------
        ndarray
            In the shape of `model`.

        Raises
        ------
        None.

        References
        ----------
        Own design; the variance function of P. Davidian and R. Carroll (1987), J. Am. Stat. Assoc. 82, with power 2.
        """
        return np.asarray(self.proportional * np.hypot(model, self.knee))

    def describe(self, largest: float) -> str:
        """Tell the noise in words.

        Parameters
        ----------
        largest : float
            Largest value of the data.

        Returns
        -------
        str
            Such as ``"noise about 1.02 % of each value"``.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        floor = self.proportional * self.knee
        top = self.proportional * float(np.hypot(largest, self.knee))
        if top < 1.0e-9 * largest:
            return "no noise beyond rounding"
        if self.knee > 2.0 * largest:
            return f"noise about {top:.3g} at every value"
        if floor < 1.0e-3 * top:
            return f"noise about {100.0 * self.proportional:.3g} % of each value"
        return f"noise about {100.0 * self.proportional:.3g} % of each value, and at least {floor:.3g}"


def estimate_noise(residuals: Array, model: Array, leverage: Array, largest: float) -> NoiseEstimate:
    """Estimate the noise from the residuals of a fit.

    Parameters
    ----------
    residuals, model : ndarray (M, W)
        Measured minus fitted, and fitted values.
    leverage : ndarray (M, W)
        Share of each value's noise that the fit took up, 0 to 1.
    largest : float
        Largest measured value, positive; the scale of what counts as rounding.

    Returns
    -------
    NoiseEstimate
        The noise with the largest likelihood.

    Raises
    ------
    InvalidParameterError
        If a number is not finite.

    References
    ----------
    Own design: restricted likelihood with each value counted by 1 - leverage; the knee by golden section in its
    logarithm, after a scan.
    """
    squares = require_finite("residuals", residuals).ravel() ** 2
    values = require_finite("model", model).ravel()
    counts = np.clip(1.0 - leverage.ravel(), 0.0, 1.0)
    number = max(float(counts.sum()), 1.0)

    def evaluate(log_knee: float) -> tuple[float, float]:
        variance = values**2 + (largest * np.exp(log_knee)) ** 2
        proportional = float(np.sum(squares / variance)) / number
        total = proportional * variance + (_RESOLUTION * largest) ** 2
        likelihood = -0.5 * float(np.sum(counts * np.log(2.0 * np.pi * total)) + np.sum(squares / total))
        return likelihood, proportional

    knees = np.linspace(np.log(1.0e-8), np.log(1.0e3), 52)
    scores = [evaluate(k)[0] for k in knees]
    best = int(np.argmax(scores))
    low, high = knees[max(best - 1, 0)], knees[min(best + 1, knees.size - 1)]
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(30):
        left, right = high - golden * (high - low), low + golden * (high - low)
        if evaluate(left)[0] >= evaluate(right)[0]:
            high = right
        else:
            low = left
    knee = 0.5 * (low + high)
    likelihood, proportional = evaluate(knee)
    if likelihood < scores[best]:
        knee = knees[best]
        likelihood, proportional = evaluate(knee)
    return NoiseEstimate(float(np.sqrt(proportional)), float(largest * np.exp(knee)), likelihood)


def log_interval(
    name: str, log_value: float, log_deviation: float, degrees_of_freedom: float, confidence: float, unit: str = ""
) -> Interval:
    """Interval of a positive number that was fitted by its logarithm.

    Parameters
    ----------
    name : str
        Name of the number.
    log_value, log_deviation : float
        Estimate and standard deviation of its natural logarithm.
    degrees_of_freedom : float
        Of the residuals, at least 1.
    confidence : float
        Between 0 and 1, such as 0.95.
    unit : str, optional
        Unit of the number.

    Returns
    -------
    Interval
        Symmetric in the logarithm.

    Raises
    ------
    InvalidParameterError
        If a number lies outside its range.

    References
    ----------
    Seber and Wild, Nonlinear Regression, 5.1 (linear approximation, here in the logarithm).
    """
    require_in_range("confidence", confidence, 1.0e-6, 1.0 - 1.0e-6)
    reach = student_t_quantile(0.5 + 0.5 * confidence, degrees_of_freedom) * log_deviation
    value, low, high = (float(v) for v in np.exp([log_value, log_value - reach, log_value + reach]))
    return Interval(name, value, low, high, unit)


def spectrum_interval(
    wavelengths_nm: Array, values: Array, deviation: Array, degrees_of_freedom: float, confidence: float
) -> SpectrumEstimate:
    """Intervals of a spectrum, each wavelength by itself.

    Parameters
    ----------
    wavelengths_nm, values, deviation : ndarray (W,)
        Wavelengths in nm, estimate and its standard deviation.
    degrees_of_freedom : float
        Of the residuals, at least 1.
    confidence : float
        Between 0 and 1, such as 0.95.

    Returns
    -------
    SpectrumEstimate
        Symmetric intervals.

    Raises
    ------
    InvalidParameterError
        If a number lies outside its range.

    References
    ----------
    Seber and Wild, Nonlinear Regression, 5.1.
    """
    require_in_range("confidence", confidence, 1.0e-6, 1.0 - 1.0e-6)
    reach = student_t_quantile(0.5 + 0.5 * confidence, degrees_of_freedom) * deviation
    return SpectrumEstimate(wavelengths_nm, values, values - reach, values + reach)
