"""Measure the worst error of the reflection laws over their whole ranges, and write docs/stability.md.

    python -m tools.stability_table [--draws 1000000] [--check]

Every case draws parameters over their range, ends included, rounds them to the type under test, and compares the
product's answer with the law as the paper or the textbook prints it, in extended precision (numpy's longdouble, 64 bits
of mantissa and exponents to 4932 on x86). The laws are evaluated on the rounded numbers, so that what is measured is
the computation and not the rounding of its input. With --check nothing is written and a bound that is passed is an
error; the tests run the same cases with fewer draws.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from spectral_core.reflection import (  # noqa: E402
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeIII,
    absorptance,
    angle_between,
    attenuation,
    attenuation_over_cosine,
    dichromatic_estimate,
    facet_distribution,
    fresnel_dielectric,
    mirror_direction,
)
from spectral_core.spectra import Spectrum  # noqa: E402

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
LN2 = LONG("0.693147180559945309417232121458176568")
BLACK, WHITE = Spectrum.constant(0.0), Spectrum.constant(1.0)
NEGLIGIBLE = 1e-30  # lobes are compared where they are above this; below, they only have to be finite and small

__all__ = ["CASES", "Case", "Outcome", "run"]


@dataclass(frozen=True)
class Outcome:
    """One batch: what was computed, what is true, and how the difference is measured."""

    computed: np.ndarray
    exact: np.ndarray
    floor: float = 0.0  # differences are relative to the exact value, or to this if that is larger
    may_be_negative: bool = False


@dataclass(frozen=True)
class Case:
    """A function over a range of its parameters, with the error bounds that docs/stability.md states."""

    function: str
    range: str
    measure: str
    bounds: dict[str, float]
    batches: Callable[[np.random.Generator, int, type], Iterator[Outcome]]


def log_uniform(rng: np.random.Generator, low: float, high: float, count: int) -> np.ndarray:
    return np.exp(rng.uniform(np.log(low), np.log(high), count))


def cosines(rng: np.random.Generator, count: int, dtype: type) -> np.ndarray:
    """From 1 to the smallest denormal of the type: a third each uniform, over all magnitudes, and at the ends."""
    smallest = float(np.finfo(dtype).smallest_subnormal)
    kind = rng.integers(0, 3, count)
    tiny = np.finfo(dtype).tiny
    ends = rng.choice([1.0, smallest, 2 * smallest, 7 * smallest, float(tiny), 1 - float(np.finfo(dtype).eps)], count)
    decades = np.maximum(10.0 ** rng.uniform(np.log10(smallest), 0.0, count), smallest)
    return np.select([kind == 0, kind == 1], [1.0 - rng.random(count), decades], ends).astype(dtype)


def unit(vectors: np.ndarray) -> np.ndarray:
    wide = vectors.astype(LONG)
    return wide / np.sqrt((wide * wide).sum(axis=-1, keepdims=True))


def random_directions(rng: np.random.Generator, count: int) -> np.ndarray:
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def across(rng: np.random.Generator, direction: np.ndarray) -> np.ndarray:
    """A random unit vector perpendicular to each direction."""
    other = np.cross(direction, random_directions(rng, len(direction)))
    return other / np.linalg.norm(other, axis=1, keepdims=True)


def long_angle(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angle from cross and scalar product, a formula that the product does not use."""
    cross = np.cross(first, second)
    return np.arctan2(np.sqrt((cross * cross).sum(axis=-1)), (first * second).sum(axis=-1))


# --- angles ---------------------------------------------------------------------------------------------------------


def _angles(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    first = random_directions(rng, count)
    angle = np.where(rng.random(count) < 0.5, log_uniform(rng, 1e-4, 3.0, count), PI - log_uniform(rng, 1e-4, 3, count))
    second = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * across(rng, first)
    a, b = first.astype(dtype), second.astype(dtype)
    yield Outcome(angle_between(a, b), long_angle(unit(a), unit(b)))


def _small_angles(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    # Pairs near an axis, where the components themselves resolve the angle.
    angle = log_uniform(rng, 1e-7 if dtype is np.float32 else 1e-12, 1e-3, count)
    turn = rng.uniform(0, 2 * np.pi, count)
    a = np.tile(np.array([0.0, 0.0, 1.0], dtype), (count, 1))
    b = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], axis=1).astype(dtype)
    yield Outcome(angle_between(a, b), long_angle(unit(a), unit(b)))


# --- attenuation ----------------------------------------------------------------------------------------------------


def _lobe(kind: str, n: float, rho: np.ndarray) -> np.ndarray:
    if kind == "cosine":
        below = rho < PI / 2
        # cos^n through 1 - cos = 2 sin^2(rho/2): in extended precision either form would do.
        return np.where(below, np.exp(LONG(n) * np.log1p(-2 * np.sin(np.where(below, rho, 0) / 2) ** 2)), 0)
    return np.exp(-LONG(n) * rho) if kind == "exponential" else np.exp(-LONG(n) * rho * rho)


def _lobe_width(kind: str, n: float) -> float:
    return 1.0 / max(n, 0.3) if kind == "exponential" else 1.0 / np.sqrt(max(n, 0.3))


def _exponents(rng: np.random.Generator, low: float, high: float, number: int) -> np.ndarray:
    return np.concatenate([[low, high], log_uniform(rng, max(low, 1e-3), high, number - 2)])


def _attenuation(kind: str, low: float, high: float) -> Callable[[np.random.Generator, int, type], Iterator[Outcome]]:
    def batches(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
        number = 25
        for n in _exponents(rng, low, high, number):
            size = count // number
            mirror = random_directions(rng, size)
            rho = np.minimum(_lobe_width(kind, n) * log_uniform(rng, 1e-3, 30.0, size), np.pi)
            viewer = np.cos(rho)[:, None] * mirror + np.sin(rho)[:, None] * across(rng, mirror)
            r, v = mirror.astype(dtype), viewer.astype(dtype)
            exact = _lobe(kind, float(n), long_angle(unit(r), unit(v)))
            yield Outcome(attenuation(kind, float(n), r, v), exact, NEGLIGIBLE)

    return batches


def _type_one(kind: str, low: float, high: float) -> Callable[[np.random.Generator, int, type], Iterator[Outcome]]:
    """f(rho) as a material computes it, from normal, light and viewer."""

    def batches(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
        number = 25
        for n in _exponents(rng, low, high, number):
            size = count // number
            normal = random_directions(rng, size)
            tilt = np.arccos(rng.uniform(0.05, 1.0, size))
            light = np.cos(tilt)[:, None] * normal + np.sin(tilt)[:, None] * across(rng, normal)
            mirror = np.asarray(mirror_direction(normal, light))
            rho = np.minimum(_lobe_width(kind, n) * log_uniform(rng, 1e-3, 30.0, size), np.pi)
            viewer = np.cos(rho)[:, None] * mirror + np.sin(rho)[:, None] * across(rng, mirror)
            keep = ((viewer * normal).sum(axis=1) > 1e-3) & ((light * normal).sum(axis=1) > 1e-3)
            vectors = [a[keep].astype(dtype) for a in (normal, light, viewer)]
            computed = TypeI(BLACK, 1.0, kind, float(n)).coefficients(*vectors)
            wide_n, wide_l, wide_v = (unit(a) for a in vectors)
            cosine = (wide_n * wide_l).sum(axis=1)
            exact = _lobe(kind, float(n), long_angle(2 * cosine[:, None] * wide_n - wide_l, wide_v))
            yield Outcome(computed[:, 0], exact, NEGLIGIBLE)
            yield Outcome(computed[:, 1], cosine)

    return batches


# --- microfacets ----------------------------------------------------------------------------------------------------


def _blinn_over_cosine(light: np.ndarray, viewer: np.ndarray, squared: np.ndarray) -> np.ndarray:
    """Eq. 12 as printed, over N.V, with H = (L + V)/|L + V|, N.H = (N.L + N.V)/|L + V| and V.H = |L + V|/2."""
    length = np.sqrt(squared)
    normal_half, viewer_half = (light + viewer) / length, length / 2
    shadow = 2 * normal_half * viewer / viewer_half
    mask = 2 * normal_half * light / viewer_half
    return np.minimum(1, np.minimum(shadow, mask)) / viewer


def _over_cosine(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    light, viewer = cosines(rng, count, dtype), cosines(rng, count, dtype)
    wide_l, wide_v = light.astype(LONG), viewer.astype(LONG)
    # |L + V|^2 for all azimuths between light and viewer; 1 + cos of the azimuth goes down to 0.
    turn = LONG(2) * 10.0 ** rng.uniform(-40, 0, count).astype(LONG)
    flat_l, flat_v = np.sqrt(1 - wide_l**2), np.sqrt(1 - wide_v**2)
    difference = (wide_v**2 - wide_l**2) / np.where(flat_l + flat_v > 0, flat_l + flat_v, 1)
    squared = np.clip((wide_l + wide_v) ** 2 + difference**2 + flat_l * flat_v * turn, 0, 4).astype(np.float64)
    possible = squared > np.finfo(np.float64).tiny  # a vanished square has lost the geometry before we see it
    light, viewer, squared = light[possible], viewer[possible], squared[possible]
    exact = _blinn_over_cosine(light.astype(LONG), viewer.astype(LONG), squared.astype(LONG))
    computed = attenuation_over_cosine(light, viewer, squared)
    yield Outcome(
        computed, np.minimum(exact, LONG(np.finfo(np.float64).max) / 256), float(np.finfo(np.float64).tiny) * 2.0**52
    )


def _distribution(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    number = 40
    betas = np.concatenate([[np.pi / 2, 1e-12], log_uniform(rng, 1e-12, np.pi / 2, number - 2)])
    for beta in betas:
        alpha = np.minimum(beta * log_uniform(rng, 1e-4, 10.0, count // number), 1.5707).astype(dtype)
        exact = np.exp(-LN2 * (alpha.astype(LONG) / LONG(beta)) ** 2)
        yield Outcome(facet_distribution(alpha, float(beta)), exact, NEGLIGIBLE)


def _metal(low: float, number: int = 25) -> Callable[[np.random.Generator, int, type], Iterator[Outcome]]:
    """D G / (N.V) from vectors in any orientation, light and viewer not below 3 deg."""

    def batches(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
        for beta in np.concatenate([[low, np.pi / 2], log_uniform(rng, low, np.pi / 2, number - 2)]):
            size = count // number
            normal = random_directions(rng, size)
            tilt = np.arccos(rng.uniform(0.05, 1.0, size))
            light = np.cos(tilt)[:, None] * normal + np.sin(tilt)[:, None] * across(rng, normal)
            alpha = np.minimum(beta * log_uniform(rng, 1e-3, 8.0, size), np.pi / 2)
            half = np.cos(alpha)[:, None] * normal + np.sin(alpha)[:, None] * across(rng, normal)
            viewer = np.asarray(mirror_direction(half, light))
            keep = ((viewer * normal).sum(axis=1) > 0.05) & ((light * half).sum(axis=1) > 1e-3)
            vectors = [a[keep].astype(dtype) for a in (normal, light, viewer)]
            yield _metal_outcome(vectors, float(beta), dtype)

    return batches


def _metal_at_horizon(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    """The same with N = z and N.L, N.V down to the smallest denormal."""
    number = 25
    for beta in np.concatenate([[0.0, np.pi / 2], log_uniform(rng, 1e-3, np.pi / 2, number - 2)]):
        size = count // number
        light_z, viewer_z = cosines(rng, size, dtype), cosines(rng, size, dtype)
        azimuth = rng.choice([0.0, 1.0], size) * log_uniform(rng, 1e-30, np.pi, size)
        wide_l, wide_v = light_z.astype(LONG), viewer_z.astype(LONG)
        flat_l, flat_v = np.sqrt((1 - wide_l) * (1 + wide_l)), np.sqrt((1 - wide_v) * (1 + wide_v))
        zero = np.zeros(size)
        light = np.stack([flat_l, zero, wide_l], axis=1).astype(dtype)
        viewer = np.stack([-flat_v * np.cos(azimuth), flat_v * np.sin(azimuth), wide_v], axis=1).astype(dtype)
        normal = np.tile(np.array([0.0, 0.0, 1.0], dtype), (size, 1))
        yield _metal_outcome([normal, light, viewer], float(beta), dtype)


def _metal_outcome(vectors: list[np.ndarray], beta: float, dtype: type) -> Outcome:
    coefficients = TypeIII(WHITE, SchlickMeanReflectance(0.5), beta).coefficients(*vectors)
    normal, light, viewer = (unit(a) for a in vectors)
    normal_light, normal_viewer = (normal * light).sum(axis=1), (normal * viewer).sum(axis=1)
    bisector = light + viewer
    squared = (bisector * bisector).sum(axis=1)
    alpha = long_angle(normal, bisector)
    facets = (alpha == 0).astype(LONG) if beta == 0 else np.exp(-LN2 * (alpha / LONG(beta)) ** 2)
    exact = facets * _blinn_over_cosine(normal_light, normal_viewer, squared)
    limit = np.finfo(dtype).max / LONG(256)
    floor = max(NEGLIGIBLE, float(np.finfo(dtype).tiny) * 2.0**24)
    return Outcome(coefficients.sum(axis=1), np.minimum(exact, limit), floor)


def _brushed_metal(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    """The elliptic distribution: azimuth and tilt of the bisector from the tangent, in extended precision."""
    number = 25
    for along, across_ in zip(
        log_uniform(rng, 1e-3, np.pi / 2, number), log_uniform(rng, 1e-3, np.pi / 2, number), strict=True
    ):
        size = count // number
        normal = random_directions(rng, size)
        tangent = across(rng, normal)
        alpha = np.minimum(max(along, across_) * log_uniform(rng, 1e-3, 5.0, size), 0.7)
        turn = rng.uniform(0, 2 * np.pi, size)
        sideways = np.cos(turn)[:, None] * tangent + np.sin(turn)[:, None] * np.cross(normal, tangent)
        half = np.cos(alpha)[:, None] * normal + np.sin(alpha)[:, None] * sideways
        light = np.asarray(mirror_direction(half, normal))  # the viewer along the normal
        keep = (light * normal).sum(axis=1) > 0.05
        n, tan, light = (a[keep].astype(dtype) for a in (normal, tangent, light))
        metal = TypeIII(WHITE, SchlickMeanReflectance(0.5), float(along), float(across_))
        computed = metal.coefficients(n, light, n, tan).sum(axis=1)
        wide_n, wide_l, wide_t = unit(n), unit(light), tan.astype(LONG)
        bisector = wide_n + wide_l
        tilt = long_angle(wide_n, bisector)
        wide_t = unit(wide_t - (wide_t * wide_n).sum(axis=1, keepdims=True) * wide_n)
        flat = unit(bisector - (bisector * wide_n).sum(axis=1, keepdims=True) * wide_n)
        psi = np.arctan2((flat * np.cross(wide_n, wide_t)).sum(axis=1), (flat * wide_t).sum(axis=1))
        exponent = (tilt * np.cos(psi) / LONG(along)) ** 2 + (tilt * np.sin(psi) / LONG(across_)) ** 2
        cosine = (wide_n * wide_l).sum(axis=1)
        exact = np.exp(-LN2 * exponent) * _blinn_over_cosine(cosine, LONG(1), (bisector * bisector).sum(axis=1))
        yield Outcome(computed, exact, NEGLIGIBLE)


# --- Fresnel and Eq. 13 ---------------------------------------------------------------------------------------------


def long_absorptance(cosine: np.ndarray, n: np.ndarray, k: np.ndarray) -> np.ndarray:
    """1 - R from complex amplitudes: 1 - |r|^2 = 4 c Re(...) / |...|^2 for each polarisation, in extended precision."""
    index = n.astype(LONG) + 1j * k.astype(LONG)
    c = cosine.astype(LONG)
    inner = np.sqrt(index * index - (1 - c) * (1 + c))
    inner = np.where(inner.imag < 0, -inner, inner)
    square = index * index
    s = 4 * c * inner.real / np.abs(c + inner) ** 2
    p = 4 * c * (square * np.conj(inner)).real / np.abs(square * c + inner) ** 2
    return (s + p) / 2


def _index_pairs(rng: np.random.Generator, count: int, dtype: type) -> tuple[np.ndarray, np.ndarray]:
    n = np.where(rng.random(count) < 0.1, rng.choice([0.05, 0.5, 1.5, 20.0], count), log_uniform(rng, 0.02, 20, count))
    k = np.where(rng.random(count) < 0.1, 20.0, log_uniform(rng, 0.01, 20.0, count))
    return n.astype(dtype), k.astype(dtype)


def _absorptance(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    n, k = _index_pairs(rng, count, dtype)
    c = cosines(rng, count, dtype)
    yield Outcome(absorptance(c, n, k).astype(dtype), long_absorptance(c, n, k), float(np.finfo(dtype).tiny) * 2.0**24)


def _dielectric(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    n = log_uniform(rng, 0.05, 20.0, count).astype(dtype)
    c = cosines(rng, count, dtype)
    index, cosine = n.astype(LONG), c.astype(LONG)
    inside = np.sqrt(np.asarray(index * index - (1 - cosine) * (1 + cosine)).astype(np.clongdouble))
    s = np.abs((cosine - inside) / (cosine + inside)) ** 2
    p = np.abs((index**2 * cosine - inside) / (index**2 * cosine + inside)) ** 2
    yield Outcome(fresnel_dielectric(c, n).astype(dtype), (s + p) / 2, 1e-6)


def _transparent(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    """With k = 0 through the conductor's formula, n < 1 (total reflection) included; not within 1e-4 of its corner."""
    n = log_uniform(rng, 0.05, 20.0, count).astype(dtype)
    c = cosines(rng, count, dtype)
    corner = np.abs(n.astype(np.float64) ** 2 - (1 - c.astype(np.float64) ** 2)) > 1e-4
    n, c = n[corner], c[corner]
    index, cosine = n.astype(LONG), c.astype(LONG)
    inside = np.sqrt(np.maximum(index * index - (1 - cosine) * (1 + cosine), 0))
    s = 4 * cosine * inside / (cosine + inside) ** 2
    p = 4 * cosine * inside * index**2 / (index**2 * cosine + inside) ** 2
    exact = np.where(inside > 0, (s + p) / 2, 0)
    yield Outcome(absorptance(c, n, 0.0).astype(dtype), exact, float(np.finfo(dtype).tiny) * 2.0**24)


def _table(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    number = 10
    for _ in range(number):
        n = log_uniform(rng, 0.05, 5.0, 61)
        k = log_uniform(rng, 1.0, 20.0, 61)
        c = rng.random(count // number).astype(dtype)
        part = slice(0, 2000)
        exact = long_absorptance(c[part, None], n[None], k[None]).mean(axis=1)
        at_normal = long_absorptance(np.ones(1), n, k).mean()
        weight = OpticalMeanReflectance(n, k).interface_weight(c)
        yield Outcome(weight[part].astype(dtype), exact / at_normal, 1.0)


def _estimate(rng: np.random.Generator, count: int, dtype: type) -> Iterator[Outcome]:
    def level() -> np.ndarray:
        return np.where(rng.random(count) < 0.2, rng.choice([0.0, 0.5, 1.0], count), rng.random(count)).astype(dtype)

    reflectance, at_incidence = level(), level()
    at_normal = np.where(rng.random(count) < 0.2, 1.0, rng.random(count)).astype(dtype)
    ratio = np.where(
        at_normal < 1, (1 - at_incidence.astype(LONG)) / np.where(at_normal < 1, 1 - at_normal.astype(LONG), 1), 1
    )
    exact = np.clip(ratio * reflectance.astype(LONG) + (1 - ratio), 0, 1)
    # Eq. 13 subtracts terms as large as 1/(1 - Sa(0)); the error is measured against the largest of them.
    scale = np.maximum(1, ratio)
    computed = dichromatic_estimate(reflectance, at_incidence, at_normal).astype(dtype)
    yield Outcome(computed / scale, exact / scale, 1.0)


RELATIVE = "relative"
OF_PEAK = "relative, above 1e-30"
OF_ONE = "absolute"


def _case(
    function: str,
    range_: str,
    measure: str,
    single: float,
    double: float,
    batches: Callable[[np.random.Generator, int, type], Iterator[Outcome]],
) -> Case:
    return Case(function, range_, measure, {"float32": single, "float64": double}, batches)


CASES: tuple[Case, ...] = (
    _case("angle_between", "1e-4 to pi - 1e-4 rad, any orientation", RELATIVE, 2e-7, 1e-14, _angles),
    _case("angle_between", "1e-7 (float64: 1e-12) to 1e-3 rad, near an axis", RELATIVE, 2e-7, 1e-14, _small_angles),
    *(
        _case(f"attenuation, {kind}", f"n {low:g} to {high:g}", OF_PEAK, single, double, _attenuation(kind, low, high))
        for kind, low, high, single, double in (
            ("cosine", 0.0, 1e2, 2e-7, 1e-9),
            ("cosine", 1e2, 1e8, 2e-7, 1e-10),
            ("exponential", 0.0, 1e2, 2e-7, 1e-12),
            ("exponential", 1e2, 1e5, 2e-7, 1e-9),
            ("exponential", 1e5, 1e8, 2e-6, 1e-6),
            ("gaussian", 0.0, 1e2, 2e-7, 1e-12),
            ("gaussian", 1e2, 1e8, 2e-7, 1e-10),
        )
    ),
    *(
        _case(
            f"TypeI.coefficients, {kind}", f"n {low:g} to {high:g}", OF_PEAK, single, double, _type_one(kind, low, high)
        )
        for kind, low, high, single, double in (
            ("cosine", 0.0, 1e8, 2e-7, 1e-10),
            ("exponential", 0.0, 1e5, 2e-7, 1e-9),
            ("exponential", 1e5, 1e8, 2e-6, 1e-6),
            ("gaussian", 0.0, 1e8, 2e-7, 1e-10),
        )
    ),
    _case("attenuation_over_cosine", "N.L, N.V from 1 to the smallest denormal", RELATIVE, 5e-15, 5e-15, _over_cosine),
    _case("facet_distribution", "beta 1e-12 to pi/2, alpha to 10 beta", OF_PEAK, 2e-13, 2e-13, _distribution),
    _case("TypeIII.coefficients", "beta 0.06 to 90 deg, 3 deg above the horizon", OF_PEAK, 2e-7, 1e-9, _metal(1e-3)),
    _case("TypeIII.coefficients", "beta 6e-5 to 90 deg, 3 deg above the horizon", OF_PEAK, 2e-7, 1e-6, _metal(1e-6)),
    _case(
        "TypeIII.coefficients",
        "beta 0 and 0.06 to 90 deg, N.L and N.V from 1 to the smallest denormal",
        OF_PEAK,
        2e-7,
        1e-9,
        _metal_at_horizon,
    ),
    _case(
        "TypeIII.coefficients, elliptic",
        "both angles 0.06 to 90 deg, any tangent",
        OF_PEAK,
        2e-7,
        1e-8,
        _brushed_metal,
    ),
    _case(
        "absorptance",
        "n 0.02 to 20, k 0.01 to 20, cos from 1 to the smallest denormal",
        RELATIVE,
        1e-7,
        1e-12,
        _absorptance,
    ),
    _case("absorptance", "n 0.05 to 20, k 0, cos from 1 to the smallest denormal", RELATIVE, 1e-7, 1e-11, _transparent),
    _case("fresnel_dielectric", "n 0.05 to 20, cos from 1 to the smallest denormal", OF_ONE, 1e-7, 1e-8, _dielectric),
    _case("OpticalMeanReflectance", "n 0.05 to 5, k 1 to 20, table of Sa", OF_ONE, 1e-7, 2e-9, _table),
    _case("dichromatic_estimate", "S_I, Sa(phi) and Sa(0) from 0 to 1", OF_ONE, 1e-7, 1e-15, _estimate),
)


@dataclass(frozen=True)
class Worst:
    """The largest error of a case, the number of draws, and whether all values were finite and not negative."""

    error: float
    draws: int
    sound: bool


def run(case: Case, dtype: type, draws: int, seed: int = 1996) -> Worst:
    """Evaluate a case on at least `draws` combinations."""
    rng = np.random.default_rng(seed)
    worst, done, sound = 0.0, 0, True
    while done < draws:
        for outcome in case.batches(rng, min(draws, 100_000), dtype):
            computed = np.asarray(outcome.computed)
            sound &= bool(np.isfinite(computed).all() and (outcome.may_be_negative or (computed >= 0).all()))
            scale = np.maximum(np.abs(outcome.exact), LONG(outcome.floor))
            scale = np.where(scale > 0, scale, 1)
            difference = np.abs(computed.astype(LONG) - outcome.exact) / scale
            above = np.abs(outcome.exact) >= outcome.floor if case.measure == OF_PEAK else np.ones(len(scale), bool)
            if above.any():
                worst = max(worst, float(difference[above].max()))
            done += computed.size
    return Worst(worst, done, sound)


HEADER = """# Numerical stability of the reflection laws

Made by `make stability`; do not edit. Each row compares a function with the law as printed in the
paper or the textbook, evaluated in extended precision on the same (rounded) input, over at least {draws:,} random
combinations that include the ends of the range. "bound" is what the tests hold, "worst" what was found. All values
were finite and, where the quantity cannot be negative, not negative.

- *relative*: error over the exact value, for values in the normal range of the type.
- *relative, above 1e-30*: the same for lobe values above 1e-30 of the peak; smaller ones only have to be finite.
- *absolute*: error against 1, the scale of a reflectance.

Inside, everything is computed in float64, float32 vectors after removing what rounding left of their length. So the
float32 column is little more than the rounding of the result, however sharp the lobe. What grows with sharpness in the
float64 column is the resolution of the unit vectors themselves: a direction in float64 is known to 1e-16 rad, which an
exponential lobe of n = 1e8 magnifies to 1e-8.

| function | range | error | float32 worst | float32 bound | float64 worst | float64 bound |
| --- | --- | --- | --- | --- | --- | --- |
"""

FOOTER = """
## What happens at the ends

| where | what |
| --- | --- |
| N.L <= 0 or N.V <= 0 | all coefficients are 0 |
| rho >= pi/2, cosine law | f = 0, for n = 0 too |
| n = 0, exponential and gaussian law | f = 1 everywhere |
| beta = 0 | D is 1 where the bisector is the normal exactly, else 0 |
| N.V = 0+ | G/(N.V) stays finite: at most 2 (1 + cos b)/sin b for a light at elevation b |
| N.L and N.V denormal, opposite | the bisector is rescaled; the result saturates at the largest float / 256 |
| Sa(0) = 1 | Eq. 13 gives S_I at every incidence |
| 1 - w < 0 (aluminium: -0.65 at 80 deg) | kept; only the resulting reflectance is clamped, at 0 |
| k = 0, n < 1 | total reflection beyond the critical angle; Sa is computed for each ray, not read from a table |
| vectors not finite, or off unit length by more than 5e-4 | `InvalidParameterError` |
"""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Measure the errors of the reflection laws; write docs/stability.md.")
    parser.add_argument("--draws", type=int, default=1_000_000, help="combinations per row and type")
    parser.add_argument("--check", action="store_true", help="write nothing")
    options = parser.parse_args(arguments)
    rows, failed = [], 0
    for case in CASES:
        cells = []
        for dtype in (np.float32, np.float64):
            bound = case.bounds[dtype.__name__]
            worst = run(case, dtype, options.draws)
            good = worst.sound and worst.error <= bound
            failed += not good
            cells += [f"{worst.error:.1e}", f"{bound:.0e}"]
            print(
                f"{'ok  ' if good else 'FAIL'} {case.function:34} {case.range:66} {dtype.__name__} "
                f"{worst.error:.2e} of {bound:.0e}{'' if worst.sound else ', not finite or negative'}",
                flush=True,
            )
        rows.append(f"| `{case.function}` | {case.range} | {case.measure} | " + " | ".join(cells) + " |\n")
    if failed:
        print(f"{failed} bounds are passed; docs/stability.md is left as it was", file=sys.stderr)
        return 1
    if not options.check:
        path = ROOT / "docs" / "stability.md"
        path.parent.mkdir(exist_ok=True)
        path.write_text(HEADER.format(draws=options.draws) + "".join(rows) + FOOTER, encoding="utf-8")
        print(f"wrote {path.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
