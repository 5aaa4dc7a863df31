"""Find which of the three types measured spectra show.

The tests are the paper's: the curves are normalised to unit length and decomposed; two components must hold nearly all
of the variance, and a constant curve either lies in their span (Type I) or does not (Type II). For metals the span must
be that of the constant and the curve at normal incidence (Eq. 7); a metal differs from a plastic in how the two change
with the angles, so the lobes of Eqs. 8 to 10 are fitted and compared. Each test knows what noise alone would do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError
from ..reflection.attenuation import ATTENUATIONS
from .distributions import f_quantile
from .lobes import BodyAndLobe, WeightedFit, fit_weighted
from .measurements import MeasurementGeometry, Measurements
from .metal_lobe import FixedWeight, FresnelWeight, MetalLobe, TableWeight, WeightModel

__all__ = ["Candidate", "Recommendation", "SpectralTests", "normalised", "recommend_type", "spectral_tests"]

Array = NDArray[np.float64]

TWO_COMPONENT_SHARE = 0.999
"""Share of variance that two components must hold (Tominaga 1996, Fig. 2)."""

CONSTANT_TOLERANCE = 0.02
"""Root mean square departure, relative to the mean, up to which a curve passes as constant."""

_SIGNAL_TO_NOISE = 10.0  # weaker spectra have no shape to test once they are normalised
_SIGNIFICANCE = 0.9999
_CONTENDER = 2.0  # Schlick's law alone may leave a metal this much worse than a plastic, and Fresnel's set it right
_NOISE_MARGIN = 3.0  # noise is known from the few values of each curve, so its share of a rest is known to a factor


def normalised(measurements: Measurements) -> Array:
    """Bring every spectrum to unit length.

    Parameters
    ----------
    measurements : Measurements
        M spectra over W wavelengths.

    Returns
    -------
    ndarray (M, W)
        Curves of unit length; a spectrum that is zero everywhere stays zero.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, Fig. 2.
    """
    length = np.linalg.norm(measurements.reflectances, axis=1, keepdims=True)
    return np.asarray(measurements.reflectances / np.where(length > 0.0, length, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class SpectralTests:
    """What the spectra alone tell.

    Parameters
    ----------
    used : ndarray of bool (M,)
        Spectra strong enough to have a shape.
    singular_values : ndarray (min(M', W),)
        Of the normalised curves.
    components : ndarray (2, W)
        First two principal curves, unit length.
    one_share, two_share : float
        Shares of variance in one and in two components.
    noise_share : float
        Share of variance that noise alone accounts for.
    one_dimensional, two_dimensional : bool
        Whether all curves are proportional; whether two components are enough.
    constant_deviation : float
        Relative root mean square departure from a constant of the flattest curve in the span.
    constant_noise : float
        Departure up to which noise can explain it.
    constant_line : ndarray (W,)
        That flattest curve, unit length.
    normal_index : int
        The spectrum nearest normal incidence (without angles: the least flat).
    normal_rest : float
        Share of variance outside the span of the constant and that spectrum.
    constant_plus_normal : bool
        Whether that rest is as small as two components leave, or as noise would make it.
    """

    used: NDArray[np.bool_]
    singular_values: Array
    components: Array
    one_share: float
    two_share: float
    noise_share: float
    one_dimensional: bool
    two_dimensional: bool
    constant_deviation: float
    constant_noise: float
    constant_line: Array
    normal_index: int
    normal_rest: float
    constant_plus_normal: bool

    @property
    def constant_in_span(self) -> bool:
        """Whether a constant interface curve explains the spectra.

        Returns
        -------
        bool
            True when the departure is below the tolerance or within what noise explains.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 2 (the straight line).
        """
        return self.constant_deviation <= max(CONSTANT_TOLERANCE, self.constant_noise)


def _difference_noise(values: Array) -> Array:
    """Variance (M,) of white noise on smooth curves, from fourth differences (Gasser, Sroka and Jennen 1986)."""
    if values.shape[1] < 10:
        return np.zeros(values.shape[0])
    differences = np.diff(values, n=4, axis=1)
    return np.asarray(np.median(differences**2, axis=1) / 0.4549 / 70.0)  # 70 = 1 + 16 + 36 + 16 + 1


def _select(measurements: Measurements) -> tuple[NDArray[np.bool_], Array]:
    """Choose the spectra worth testing, and tell the variance of their noise after normalisation."""
    if measurements.count < 3:
        raise FittingError(
            f"two components need at least 3 spectra to be tested, but {measurements.name or 'the measurements'} "
            f"has {measurements.count}"
        )
    power = np.sum(measurements.reflectances**2, axis=1)
    noise = _difference_noise(measurements.reflectances)
    width = measurements.wavelengths_nm.size
    used = (power > 0.0) & (power > noise * width * _SIGNAL_TO_NOISE**2)
    if used.sum() < 3:
        raise FittingError(
            f"only {int(used.sum())} of {measurements.count} spectra stand {_SIGNAL_TO_NOISE:g} times above their "
            "noise, but 3 are needed"
        )
    return used, noise[used] / power[used]


def spectral_tests(measurements: Measurements) -> SpectralTests:
    """Test the spectra for two-dimensionality and for a constant interface curve.

    Parameters
    ----------
    measurements : Measurements
        At least 3 spectra; angles only serve to find the one nearest normal incidence.

    Returns
    -------
    SpectralTests
        The figures and what they decide.

    Raises
    ------
    FittingError
        If there are fewer than 3 spectra that stand above their noise.

    References
    ----------
    Tominaga 1996, Figs. 2 to 4 and Eqs. 5 to 7; the effect of noise on the span by first-order perturbation of the
    singular vectors (Stewart and Sun, Matrix Perturbation Theory, V.4).
    """
    used, noise = _select(measurements)
    curves = normalised(measurements)[used]
    count, width = curves.shape
    left, sizes, right = np.linalg.svd(curves, full_matrices=False)
    total = float(np.sum(sizes**2))
    rest = float(np.sum(sizes[2:] ** 2))
    expected_rest = float(noise.mean()) * (count - 2) * max(width - 2, 1)
    one_dimensional = bool(
        sizes[1] ** 2 < 1.5 * float(noise.mean()) * (np.sqrt(count) + np.sqrt(width)) ** 2
        or sizes[1] < 1.0e-9 * sizes[0]
    )
    constant = np.full(width, 1.0 / np.sqrt(width))
    shares = right[:2] @ constant
    line = shares @ right[:2]
    outside = max(float(np.sum((constant - line) ** 2)), 0.0)
    pattern = noise if noise.any() else np.ones(count)
    leverage = np.sum(left[:, :2] ** 2, axis=1)
    freedom = (count - 2) * max(width - 2, 1)
    budget = float(np.sum(pattern * (1.0 - leverage))) * max(width - 2, 1)
    level = rest / budget if budget > 0.0 else 0.0
    # Noise lengthens the singular values; without it the weaker one would be shorter and its direction less certain.
    powers = np.maximum(sizes[:2] ** 2 - level * float(pattern.mean()) * width, 0.1 * sizes[:2] ** 2)
    mixing = left[:, :2] @ (shares * sizes[:2] / np.maximum(powers, 1.0e-24 * sizes[0] ** 2))
    critical = f_quantile(_SIGNIFICANCE, max(width - 2, 1), freedom)
    allowance = level * float(np.sum(pattern * mixing**2)) * max(width - 2, 1) * critical
    index, normal_rest, from_normal = _normal_test(measurements, used, curves, noise)
    length = float(np.linalg.norm(line))
    return SpectralTests(
        used,
        sizes,
        right[:2],
        float(sizes[0] ** 2) / total,
        1.0 - rest / total,
        expected_rest / total,
        one_dimensional,
        1.0 - rest / total >= TWO_COMPONENT_SHARE or rest <= _NOISE_MARGIN * expected_rest,
        float(np.sqrt(outside / max(1.0 - outside, 1.0e-12))),
        float(np.sqrt(allowance / max(1.0 - allowance, 1.0e-12))),
        line / length if length > 0.0 else line,
        index,
        normal_rest,
        from_normal,
    )


def _normal_test(
    measurements: Measurements, used: NDArray[np.bool_], curves: Array, noise: Array
) -> tuple[int, float, bool]:
    """Share of variance outside the span of the constant and the curve at normal incidence."""
    constant = np.full(curves.shape[1], 1.0 / np.sqrt(curves.shape[1]))
    departure = np.linalg.norm(curves - np.outer(curves @ constant, constant), axis=1)
    if measurements.geometry is not None:
        incidence = measurements.geometry.facet_incidence()[used]
        near = np.flatnonzero(incidence <= incidence.min() + np.radians(1.0))
        power = np.linalg.norm(measurements.reflectances[used], axis=1)
        chosen = int(near[np.argmax(power[near])])
    else:
        chosen = int(np.argmax(departure))
    across = curves[chosen] - (curves[chosen] @ constant) * constant
    length = float(np.linalg.norm(across))
    across = across / length if length > 1.0e-12 else np.zeros_like(across)
    rest = curves - np.outer(curves @ constant, constant) - np.outer(curves @ across, across)
    share = float(np.sum(rest**2)) / curves.shape[0]
    gain = (curves @ across) / length if length > 1.0e-12 else np.zeros(curves.shape[0])
    by_noise = float(np.sum(noise + gain**2 * noise[chosen])) * curves.shape[1] / curves.shape[0]
    index = int(np.flatnonzero(used)[chosen])
    return index, share, share <= max(1.0 - TWO_COMPONENT_SHARE, _NOISE_MARGIN * by_noise)


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One model fitted for comparison.

    Parameters
    ----------
    material_type : {"I", "II", "III"}
        The type.
    lobe : str
        The law of f, or "facets" and "elliptic facets" for Type III.
    fit : WeightedFit
        The fit.
    """

    material_type: str
    lobe: str
    fit: WeightedFit


@dataclass(frozen=True, slots=True, eq=False)
class Recommendation:
    """The type that measured spectra show, and why.

    Parameters
    ----------
    material_type : {"I", "II", "III"} or None
        None when the spectra show none of the three.
    decisive : bool
        Whether the evidence excludes the other types.
    evidence : tuple of str
        Sentences, in the order of the tests.
    tests : SpectralTests
        The figures.
    candidates : tuple of Candidate
        The models that were fitted, best first; empty without angles.
    """

    material_type: str | None
    decisive: bool
    evidence: tuple[str, ...]
    tests: SpectralTests
    candidates: tuple[Candidate, ...]


def is_turned(geometry: MeasurementGeometry) -> bool:
    """Whether the bisectors tilt both along and across the grain, so that an anisotropy could be seen."""
    bisector = geometry.to_light() + geometry.to_viewer()
    tangent = geometry.tangent()
    along = bisector[:, 0] * tangent[:, 0] + bisector[:, 1] * tangent[:, 1]
    across = bisector[:, 1] * tangent[:, 0] - bisector[:, 0] * tangent[:, 1]
    return bool(np.sum(np.abs(along) > 1.0e-3) >= 2 and np.sum(np.abs(across) > 1.0e-3) >= 2)


def compare_models(measurements: Measurements, metal_allowed: bool) -> tuple[Candidate, ...]:
    """Fit every type and lobe, best first by Bayes' information criterion; refine metals where they are in the run."""
    geometry = measurements.require_geometry("comparing the lobes of the types")
    data = measurements.reflectances
    candidates = [
        Candidate(name, kind, fit_weighted(BodyAndLobe(measurements, kind, name == "I"), data))
        for name in ("I", "II")
        for kind in ATTENUATIONS
    ]
    incidence = geometry.facet_incidence()
    weights: list[WeightModel] = [FixedWeight((1.0 - np.cos(incidence)) ** 5)]
    plastic = min(c.fit.relative_residual for c in candidates)
    metal = fit_weighted(MetalLobe(measurements, weights[0]), data).relative_residual
    if metal_allowed and (metal < _CONTENDER * plastic or is_turned(geometry)):
        weights.append(FresnelWeight(incidence))
    if data.shape[0] > 3 and np.all(geometry.from_mirror() < 1.0e-6):
        # A mirror series, as in Fig. 4: the mean reflectance at each incidence can be read from the spectra.
        weights.append(TableWeight(incidence, several_each=False))
    for weight in weights:
        candidates.append(Candidate("III", "facets", fit_weighted(MetalLobe(measurements, weight), data)))
        if is_turned(geometry):
            model = MetalLobe(measurements, weight, anisotropic=True)
            candidates.append(Candidate("III", "elliptic facets", fit_weighted(model, data)))
    return tuple(sorted(candidates, key=lambda c: c.fit.criterion))


def _spectral_evidence(measurements: Measurements, tests: SpectralTests) -> list[str]:
    said = [f"{measurements.count} spectra at {measurements.wavelengths_nm.size} wavelengths."]
    dropped = measurements.count - int(tests.used.sum())
    if dropped:
        said.append(
            f"{dropped} of them are too weak against their noise to have a shape, and were left out of the tests."
        )
    said.append(
        f"Two components hold {100.0 * tests.two_share:.4f} % of the variance, "
        f"one alone {100.0 * tests.one_share:.4f} %."
    )
    if tests.one_dimensional:
        said.append("All curves are proportional within their noise: only one component is seen.")
    elif not tests.two_dimensional:
        said.append(
            f"That is less than {100.0 * TWO_COMPONENT_SHARE:g} %, and more than noise leaves over: not dichromatic."
        )
    else:
        comparison = "is" if tests.constant_in_span else "is not"
        said.append(
            f"The flattest curve in their span departs from a constant by {100.0 * tests.constant_deviation:.2g} % "
            f"(tolerance {100.0 * CONSTANT_TOLERANCE:g} %, noise explains up to {100.0 * tests.constant_noise:.2g} %): "
            f"a constant interface {comparison} in the span."
        )
        verdict = "what Eq. 7 asks of a metal, though a plastic may show it too"
        said.append(
            f"The constant and the curve nearest normal incidence leave {100.0 * tests.normal_rest:.2g} % of the "
            f"variance: {verdict if tests.constant_plus_normal else 'not a metal'}."
        )
    return said


def recommend_type(measurements: Measurements) -> Recommendation:
    """Recommend Type I, II or III for measured spectra, with the evidence in words.

    Parameters
    ----------
    measurements : Measurements
        At least 3 spectra. Without angles metals cannot be told from plastics.

    Returns
    -------
    Recommendation
        Type, evidence, and the models that were compared.

    Raises
    ------
    FittingError
        If there are fewer than 3 spectra that stand above their noise.

    References
    ----------
    Tominaga 1996, Eqs. 5 to 10; models compared by G. Schwarz (1978), Ann. Stat. 6, 461.
    """
    tests = spectral_tests(measurements)
    evidence = _spectral_evidence(measurements, tests)
    spread = not tests.one_dimensional
    if spread and not tests.two_dimensional:
        return Recommendation(None, False, tuple(evidence), tests, ())
    if measurements.geometry is None:
        if not spread:
            evidence.append("Without angles nothing tells the interface from the body.")
            return Recommendation(None, False, tuple(evidence), tests, ())
        chosen = "I" if tests.constant_in_span else "II"
        evidence.append(f"Recommended: Type {chosen}. Without angles a metal (Type III) cannot be told from a plastic.")
        return Recommendation(chosen, chosen == "II", tuple(evidence), tests, ())
    metal_allowed = tests.one_dimensional or tests.constant_plus_normal
    candidates = compare_models(measurements, metal_allowed)
    best = {name: next(c for c in candidates if c.material_type == name) for name in ("I", "II", "III")}
    for name in ("I", "II", "III"):
        fit = best[name].fit
        evidence.append(
            f"Type {name} ({best[name].lobe}) leaves a residual of {100.0 * fit.relative_residual:.3g} %, "
            f"criterion {fit.criterion:.0f}."
        )
    if metal_allowed and candidates[0].material_type == "III":
        chosen = "III"
        rivals = min(best["I"].fit.criterion, best["II"].fit.criterion)
    elif not spread:
        chosen = "I" if best["I"].fit.criterion < best["II"].fit.criterion else "II"
        rivals = min(c.fit.criterion for n, c in best.items() if n != chosen)
    else:
        chosen = "I" if tests.constant_in_span else "II"
        rivals = best["III"].fit.criterion if metal_allowed else np.inf
    decisive = rivals - best[chosen].fit.criterion > 10.0
    if spread and chosen == "I" and tests.constant_noise > 5.0 * CONSTANT_TOLERANCE:
        decisive = False
        evidence.append("The noise would hide a coloured interface; the simpler Type I is taken.")
    evidence.append(f"Recommended: Type {chosen}{'' if decisive else ', though the data do not exclude another type'}.")
    return Recommendation(chosen, decisive, tuple(evidence), tests, candidates)
