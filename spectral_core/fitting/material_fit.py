"""From measured spectra to a material: the type, its spectra and its lobe, with confidence intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError, InvalidParameterError
from ..reflection import (
    ATTENUATIONS,
    MEAN_BAND_NM,
    MeanReflectance,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeII,
    TypeIII,
)
from ..spectra import Spectrum
from ..validation import require_choice, require_in_range
from .dichromatic import Recommendation, is_turned, recommend_type
from .lobes import LARGEST_SPREAD, BodyAndLobe, WeightedFit, fit_weighted
from .measurements import Measurements
from .metal_lobe import FixedWeight, FresnelWeight, MetalLobe, TableWeight, WeightModel, metal_incidence
from .uncertainty import Interval, SpectrumEstimate, log_interval, spectrum_interval

__all__ = ["MATERIAL_TYPES", "MEAN_REFLECTANCES", "FitOptions", "MaterialFit", "fit_material"]

Array = NDArray[np.float64]

MATERIAL_TYPES = ("I", "II", "III")
"""Names of the three types."""

MEAN_REFLECTANCES = ("auto", "schlick", "fresnel", "table")
"""Ways to find the mean reflectance Sa(phi) of a metal."""

_HARDLY_DIFFERENT = 25.0  # of the criterion: noise may turn the order of laws that are no further apart
_SCALE_SPREAD = 0.2  # a scale known no better than this would leave S_I without meaning


@dataclass(frozen=True, slots=True, eq=False)
class FitOptions:
    """What a user may hold or choose instead of leaving it to the data.

    Parameters
    ----------
    material_type : {"I", "II", "III"}, optional
        None takes the recommended type.
    attenuation : {"cosine", "exponential", "gaussian"}, optional
        Types I and II: the law f; None takes the one that fits best.
    n : float, optional
        Types I and II: held sharpness, 0 to 1e8.
    beta, beta_across : float, optional
        Type III: held half-value angles in radians, above 0 to pi/2; `beta_across` only with `beta`.
    anisotropic : bool, optional
        Type III: whether to fit two half-value angles; None lets the data decide.
    mean_reflectance : {"auto", "schlick", "fresnel", "table"} or MeanReflectance
        Type III: Sa(phi) by Schlick's law, by Fresnel's equations with one n and k that are fitted, the better of the
        two ("auto"), as a table fitted at the incidences measured, or known beforehand.
    scale : float, optional
        Type III: the factor of the values over Eq. 10, held; None fits it, where the data determine it.
    incidence : {"facet", "surface"}
        Type III: the angle phi of Eq. 13.
    confidence : float
        Of all intervals, between 0 and 1.
    """

    material_type: str | None = None
    attenuation: str | None = None
    n: float | None = None
    beta: float | None = None
    beta_across: float | None = None
    anisotropic: bool | None = None
    mean_reflectance: str | MeanReflectance = "auto"
    scale: float | None = None
    incidence: str = "facet"
    confidence: float = 0.95

    def __post_init__(self) -> None:
        if self.material_type is not None:
            require_choice("material_type", self.material_type, MATERIAL_TYPES)
        if self.attenuation is not None:
            require_choice("attenuation", self.attenuation, ATTENUATIONS)
        if isinstance(self.mean_reflectance, str):
            require_choice("mean_reflectance", self.mean_reflectance, MEAN_REFLECTANCES)
        for name in ("beta", "beta_across"):
            if getattr(self, name) is not None:
                require_in_range(name, getattr(self, name), 1.0e-6, 0.5 * np.pi, unit="rad")
        if self.beta is None and self.beta_across is not None:
            raise InvalidParameterError("beta_across must be held together with beta, but beta is left to the fit")
        require_in_range("confidence", self.confidence, 0.5, 0.999999)


@dataclass(frozen=True, slots=True, eq=False)
class MaterialFit:
    """A material fitted to measurements.

    Parameters
    ----------
    material : TypeI, TypeII or TypeIII
        The material, ready to render.
    measurements : Measurements
        What it was fitted to.
    recommendation : Recommendation
        The recommended type with its evidence.
    parameters : tuple of Interval
        n, or beta in degrees and the scale; for Type I the interface reflectance.
    interface : SpectrumEstimate
        S_I over the measured wavelengths.
    body : SpectrumEstimate or None
        S_B; None for metals.
    fit : WeightedFit
        Fitted values, noise, residuals.
    confidence : float
        Of the intervals.
    notes : tuple of str
        What was held, clipped or left open.
    """

    material: TypeI | TypeII | TypeIII
    measurements: Measurements
    recommendation: Recommendation
    parameters: tuple[Interval, ...]
    interface: SpectrumEstimate
    body: SpectrumEstimate | None
    fit: WeightedFit
    confidence: float
    notes: tuple[str, ...]

    @property
    def material_type(self) -> str:
        """The type that was fitted.

        Returns
        -------
        str
            "I", "II" or "III".

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996.
        """
        return {TypeI: "I", TypeII: "II", TypeIII: "III"}[type(self.material)]

    def describe(self) -> str:
        """Tell the fit in words.

        Returns
        -------
        str
            Several lines.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        lines = list(self.recommendation.evidence)
        law = "" if isinstance(self.material, TypeIII) else f", f(rho) {self.material.attenuation}"
        lines.append(f"Fitted: Type {self.material_type}{law}.")
        lines += [f"  {p.describe()}" for p in self.parameters]
        largest = float(np.max(np.abs(self.measurements.reflectances)))
        lines.append(
            f"  intervals of {100.0 * self.confidence:g} %; residual {100.0 * self.fit.relative_residual:.3g} %; "
            f"{self.fit.noise.describe(largest)}"
        )
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])


def fit_material(
    measurements: Measurements, options: FitOptions | None = None, recommendation: Recommendation | None = None
) -> MaterialFit:
    """Fit a material to spectra measured at several geometries.

    Parameters
    ----------
    measurements : Measurements
        At least 3 spectra, with angles.
    options : FitOptions, optional
        What to hold or choose; by default all is left to the data.
    recommendation : Recommendation, optional
        Of these measurements, if it has been asked for before; None asks for it here.

    Returns
    -------
    MaterialFit
        The material with intervals and evidence.

    Raises
    ------
    FittingError
        If there are too few spectra or no angles, if the spectra show none of the three types (and none is asked
        for), or if they do not determine n or beta.

    References
    ----------
    Tominaga 1996, Eqs. 8 to 13 and Fig. 7.
    """
    chosen = options or FitOptions()
    measurements.require_geometry("fitting a material")
    recommendation = recommendation or recommend_type(measurements)
    name = chosen.material_type or recommendation.material_type
    if name is None:
        raise FittingError(
            "the spectra show none of the three types, so one must be asked for: " + " ".join(recommendation.evidence)
        )
    if name == "III":
        return _fit_metal(measurements, recommendation, chosen)
    return _fit_dielectric(measurements, recommendation, chosen, name)


def _require_determined(fit: WeightedFit, index: int, what: str, advice: str) -> float:
    """Tell the standard deviation of a fitted logarithm, or raise when it is not determined."""
    variance = float(fit.fit.parameter_covariance[index, index]) * fit.variance
    if not np.isfinite(variance) or variance > LARGEST_SPREAD**2:
        raise FittingError(f"{what} is not determined by these geometries: {advice}")
    return float(np.sqrt(variance))


def _clipped(spectrum: Array, high: float, name: str, notes: list[str]) -> Array:
    inside = np.clip(spectrum, 0.0, high)
    count = int(np.count_nonzero(np.abs(inside - spectrum) > 1.0e-9 * max(float(np.max(np.abs(spectrum))), 1e-300)))
    if count:
        rule = "0" if np.isinf(high) else f"0 to {high:g}"
        notes.append(f"{name} was clipped to {rule} at {count} of {spectrum.size} wavelengths.")
    return np.asarray(inside)


def _fit_dielectric(
    measurements: Measurements, recommendation: Recommendation, options: FitOptions, name: str
) -> MaterialFit:
    notes: list[str] = []
    kinds = ATTENUATIONS if options.attenuation is None else (options.attenuation,)
    tried = {
        kind: fit_weighted(BodyAndLobe(measurements, kind, name == "I", options.n), measurements.reflectances)
        for kind in kinds
    }
    kind = min(tried, key=lambda k: tried[k].criterion)
    best = tried[kind]
    near = [k for k in tried if k != kind and tried[k].criterion - best.criterion < _HARDLY_DIFFERENT]
    if near:
        notes.append(f"f may as well be {' or '.join(near)}: the residuals hardly differ.")
    solution, variance, freedom = best.fit, best.variance, float(best.degrees_of_freedom)
    parameters: list[Interval] = []
    if options.n is None:
        deviation = _require_determined(best, 0, "n", "measure around the mirror direction, or hold n")
        n = float(np.exp(solution.parameters[0]))
        parameters.append(log_interval("n", float(solution.parameters[0]), deviation, freedom, options.confidence))
    else:
        n = float(options.n)
        parameters.append(Interval("n (held)", n, n, n))
    wavelengths = measurements.wavelengths_nm
    spread = np.sqrt(solution.spectrum_variance * variance)
    body_row = solution.spectra.shape[0] - 1
    body = spectrum_interval(wavelengths, solution.spectra[body_row], spread[body_row], freedom, options.confidence)
    body_spectrum = Spectrum(wavelengths, _clipped(body.values, np.inf, "S_B", notes), "body")
    if name == "I":
        width = wavelengths.size
        if not np.isfinite(solution.level_variance):
            raise FittingError("the interface reflectance is not determined: no spectrum shows the highlight")
        interface = spectrum_interval(
            wavelengths,
            np.full(width, solution.level),
            np.full(width, np.sqrt(solution.level_variance * variance)),
            freedom,
            options.confidence,
        )
        parameters.append(
            Interval("interface_reflectance", solution.level, float(interface.low[0]), float(interface.high[0]))
        )
        level = float(_clipped(np.array([solution.level]), np.inf, "S_I", notes)[0])
        material: TypeI | TypeII = TypeI(body_spectrum, level, kind, n)
    else:
        interface = spectrum_interval(wavelengths, solution.spectra[0], spread[0], freedom, options.confidence)
        interface_spectrum = Spectrum(wavelengths, _clipped(interface.values, np.inf, "S_I", notes), "interface")
        material = TypeII(body_spectrum, interface_spectrum, kind, n)
    return MaterialFit(
        material,
        measurements,
        recommendation,
        tuple(parameters),
        interface,
        body,
        best,
        options.confidence,
        tuple(notes),
    )


def _weight_models(measurements: Measurements, options: FitOptions) -> list[WeightModel]:
    """List the mean reflectances to try."""
    geometry = measurements.require_geometry("fitting a metal")
    angle = metal_incidence(geometry, options.incidence)
    if isinstance(options.mean_reflectance, MeanReflectance):
        return [FixedWeight(np.asarray(1.0 - options.mean_reflectance.interface_weight(np.cos(angle))))]
    if options.mean_reflectance == "table":
        return [TableWeight(angle, several_each=not np.all(geometry.from_mirror() < 1.0e-6))]
    schlick, fresnel = FixedWeight((1.0 - np.cos(angle)) ** 5), FresnelWeight(angle)
    models: dict[str, list[WeightModel]] = {"schlick": [schlick], "fresnel": [fresnel], "auto": [schlick, fresnel]}
    return models[options.mean_reflectance]


def _best_metal(measurements: Measurements, options: FitOptions, scale: float | None) -> tuple[MetalLobe, WeightedFit]:
    """Fit the lobes and mean reflectances that are asked for, and take the best."""
    geometry = measurements.require_geometry("fitting a metal")
    held = None if options.beta is None else (options.beta, options.beta_across or options.beta)
    if held is not None:
        shapes = [options.beta_across is not None]
    elif options.anisotropic is None:
        shapes = [False, True] if is_turned(geometry) else [False]
    else:
        shapes = [options.anisotropic]
    models = [
        MetalLobe(measurements, weight, shape, held, scale)
        for weight in _weight_models(measurements, options)
        for shape in shapes
    ]
    return min(((m, fit_weighted(m, measurements.reflectances)) for m in models), key=lambda pair: pair[1].criterion)


def _fit_metal(measurements: Measurements, recommendation: Recommendation, options: FitOptions) -> MaterialFit:
    notes: list[str] = []
    model, best = _best_metal(measurements, options, options.scale)
    scale = options.scale
    if scale is None:
        level, unit_variance = best.fit.level, best.fit.level_variance
        seen = np.isfinite(unit_variance) and unit_variance * best.variance < (_SCALE_SPREAD * level) ** 2
        if not (seen and level > 0.0):
            scale = max(1.0, float(best.fit.spectra[0].max()) * (1.0 + 1.0e-9))
            notes.append(
                "The data do not determine the scale over Eq. 10 (no spectrum near grazing incidence): "
                f"held at {scale:.6g}."
            )
            # Without that scale nothing can be said of how the reflectance rises either.
            simple = replace(options, mean_reflectance="schlick") if options.mean_reflectance == "auto" else options
            model, best = _best_metal(measurements, simple, scale)
    parameters = _half_value_intervals(model, best, options)
    solution, freedom, confidence = best.fit, float(best.degrees_of_freedom), options.confidence
    if scale is None:
        unit = solution.level
        relative = float(np.sqrt(solution.level_variance * best.variance)) / unit
        parameters.append(log_interval("scale", float(np.log(unit)), relative, freedom, confidence))
        # S_I = A / k, where A is the free spectrum and k the level: first-order error of the quotient.
        reflectance = solution.spectra[0] / unit
        spread_squared = (
            solution.spectrum_variance[0]
            - 2.0 * reflectance * solution.spectrum_level_covariance[0]
            + reflectance**2 * solution.level_variance
        ) / unit**2
    else:
        parameters.append(Interval("scale (held)", scale, scale, scale))
        reflectance = solution.spectra[0] / scale
        spread_squared = solution.spectrum_variance[0] / scale**2
    wavelengths = measurements.wavelengths_nm
    interface = spectrum_interval(
        wavelengths, reflectance, np.sqrt(np.maximum(spread_squared * best.variance, 0.0)), freedom, confidence
    )
    normal = Spectrum(wavelengths, _clipped(reflectance, 1.0, "S_I", notes), "normal reflectance")
    mean = _mean_reflectance(model, solution.parameters, normal, options, notes)
    along, across = model.half_values(solution.parameters)
    material = TypeIII(normal, mean, along, across if model.anisotropic else None, options.incidence)
    return MaterialFit(
        material, measurements, recommendation, tuple(parameters), interface, None, best, confidence, tuple(notes)
    )


def _half_value_intervals(model: MetalLobe, best: WeightedFit, options: FitOptions) -> list[Interval]:
    """Intervals of beta, or beta and beta across, in degrees."""
    found = []
    values = model.half_values(best.fit.parameters)
    for index, name in enumerate(("beta", "beta_across") if model.anisotropic else ("beta",)):
        if options.beta is not None:
            value = float(np.degrees(values[index]))
            found.append(Interval(f"{name} (held)", value, value, value, "deg"))
            continue
        spread = _require_determined(best, index, name, "measure away from the mirror direction, or hold beta")
        logarithm = float(best.fit.parameters[index] + np.log(np.degrees(1.0)))
        freedom = float(best.degrees_of_freedom)
        found.append(log_interval(name, logarithm, spread, freedom, options.confidence, "deg"))
    return found


def _mean_reflectance(
    model: MetalLobe, p: Array, normal: Spectrum, options: FitOptions, notes: list[str]
) -> MeanReflectance:
    if isinstance(options.mean_reflectance, MeanReflectance):
        return options.mean_reflectance
    at_normal = float(np.clip(normal.at(MEAN_BAND_NM).mean(), 0.0, 1.0))
    q = model.weight_parameters(p)
    if isinstance(model.weight, FresnelWeight):
        n, k = np.exp(q)
        notes.append(f"Sa(phi) follows Fresnel's equations with n = {n:.3g} and k = {k:.3g} at all wavelengths.")
        return OpticalMeanReflectance(np.array([n]), np.array([k]))
    if isinstance(model.weight, TableWeight):
        mean = 1.0 - (1.0 - np.concatenate([[0.0], q])) * (1.0 - at_normal)
        notes.append(f"Sa(phi) is a table of {mean.size} incidences.")
        return MeasuredMeanReflectance(model.weight.knots, np.clip(mean, 0.0, 1.0))
    notes.append("Sa(phi) follows Schlick's law.")
    return SchlickMeanReflectance(at_normal)
