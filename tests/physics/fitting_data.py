"""Synthetic measurements for the tests of fitting, by the equations as printed (arc cosines, quotients, no core)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spectral_core.fitting import MeasurementGeometry, Measurements

Array = NDArray[np.float64]

WAVELENGTHS = np.arange(400.0, 701.0, 15.0)


def around_mirror(incidence: float = 45.0) -> MeasurementGeometry:
    """A goniometer series at one incidence, dense around the mirror direction, as for the paper's Fig. 6."""
    steps = np.array([-55.0, -40, -25, -15, -9, -6, -4, -2, 0, 2, 4, 6, 9, 14, 20])
    return MeasurementGeometry.from_degrees(np.full(steps.size, incidence), incidence + steps)


def around_several_mirrors(turned: bool = False) -> MeasurementGeometry:
    """Series around the mirror direction at several incidences up to near grazing, for metals."""
    pairs = np.array([(i, i + d) for i in (10.0, 35.0, 55.0, 68.0, 78.0) for d in (-9.0, -5.0, -2.0, 0.0, 4.0)])
    if not turned:
        return MeasurementGeometry.from_degrees(*pairs.T)
    twice = np.concatenate([pairs, pairs])
    rotation = np.repeat([0.0, 90.0], pairs.shape[0])
    return MeasurementGeometry.from_degrees(twice[:, 0], twice[:, 1], rotation=rotation)


def printed_attenuation(kind: str, n: float, rho: Array) -> Array:
    return {
        "cosine": np.maximum(np.cos(rho), 0.0) ** n,
        "exponential": np.exp(-n * np.abs(rho)),
        "gaussian": np.exp(-n * rho**2),
    }[kind]


def angle(a: Array, b: Array) -> Array:
    return np.arccos(np.clip(np.sum(a * b, axis=1), -1.0, 1.0))


def printed_dielectric(
    geometry: MeasurementGeometry, kind: str, n: float, interface: Array | float, body: Array
) -> Array:
    """Eqs. 8 and 9 without E, relative to the irradiance on a plane facing the light."""
    rho = angle(geometry.mirror(), geometry.to_viewer())
    lobe = printed_attenuation(kind, n, rho)
    level = np.broadcast_to(interface, body.shape)
    return lobe[:, None] * level + np.cos(geometry.incidence)[:, None] * body


def printed_metal(
    geometry: MeasurementGeometry, beta: float, beta_across: float, reflectance: Array, weight: Array
) -> Array:
    """Eqs. 10 to 13 without E; `weight` is the share of the constant term at each geometry."""
    normal, light, viewer = geometry.normal(), geometry.to_light(), geometry.to_viewer()
    h = light + viewer
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    alpha = angle(normal, h)
    psi = np.arctan2(h[:, 1], h[:, 0]) - np.arctan2(geometry.tangent()[:, 1], geometry.tangent()[:, 0])
    tilt = alpha**2 * (np.cos(psi) ** 2 / beta**2 + np.sin(psi) ** 2 / beta_across**2)
    nh, nv, nl, vh = (np.sum(a * b, axis=1) for a, b in ((normal, h), (normal, viewer), (normal, light), (viewer, h)))
    g = np.minimum(1.0, np.minimum(2.0 * nh * nv / vh, 2.0 * nh * nl / vh))
    return (np.exp(-np.log(2.0) * tilt) * g / nv)[:, None] * ((1.0 - weight)[:, None] * reflectance + weight[:, None])


def schlick_weight(geometry: MeasurementGeometry) -> Array:
    half = 0.5 * angle(geometry.to_light(), geometry.to_viewer())
    return (1.0 - np.cos(half)) ** 5


@dataclass(frozen=True)
class Truth:
    """A synthetic sample: what it is made of and what a perfect instrument would read."""

    material_type: str
    kind: str
    shape: float
    interface: Array
    body: Array
    geometry: MeasurementGeometry
    values: Array

    def measure(self, noise: str = "none", size: float = 0.01, seed: int = 0, reference: str = "beam") -> Measurements:
        """Read it with noise in proportion to each value, or uniform in proportion to the mean."""
        rng = np.random.default_rng(seed)
        values = self.values if reference == "beam" else self.values / np.cos(self.geometry.incidence)[:, None]
        draw = rng.standard_normal(values.shape) * size
        if noise == "proportional":
            values = values * (1.0 + draw)
        elif noise == "uniform":
            values = values + draw * values.mean()
        return Measurements(WAVELENGTHS, values, self.geometry, reference)


def smooth(rng: np.random.Generator, low: float, high: float, swing: float) -> Array:
    """A random smooth reflectance: two broad bands and a step, within [low, high], at least `swing` from end to end."""
    while True:
        x = (WAVELENGTHS - 550.0) / 150.0
        curve = np.zeros_like(x)
        for _ in range(2):
            curve += rng.uniform(-1, 1) * np.exp(-(((x - rng.uniform(-1, 1)) / rng.uniform(0.3, 0.8)) ** 2))
        curve += rng.uniform(-1, 1) / (1.0 + np.exp(-(x - rng.uniform(-0.7, 0.7)) / 0.12))
        extent = np.ptp(curve)
        if extent > 0.3:
            break
    top = rng.uniform(low + swing, high)
    bottom = rng.uniform(low, top - swing)
    return bottom + (curve - curve.min()) / extent * (top - bottom)


def departure_from_span(curves: Array) -> float:
    """Relative departure from a constant of the flattest curve in the span of two curves (by least squares)."""
    one = np.ones(curves.shape[1])
    coefficients, *_ = np.linalg.lstsq(curves.T, one, rcond=None)
    line = coefficients @ curves
    share = float(np.sum((one - line) ** 2) / one.size)
    return float(np.sqrt(share / max(1.0 - share, 1e-12)))


def random_truth(material_type: str, seed: int) -> Truth:
    """A random sample of a type, of a kind that the type is made for."""
    rng = np.random.default_rng([seed, ord(material_type[-1]), len(material_type)])
    if material_type == "III":
        geometry = around_several_mirrors()
        beta = np.radians(rng.uniform(3.0, 12.0))
        reflectance = smooth(rng, 0.3, 0.97, 0.25)
        values = printed_metal(geometry, beta, beta, reflectance, schlick_weight(geometry))
        return Truth("III", "facets", beta, reflectance, np.zeros_like(reflectance), geometry, values)
    geometry = around_mirror(float(rng.uniform(30.0, 55.0)))
    kind = str(rng.choice(["cosine", "exponential", "gaussian"]))
    n = {"cosine": 10 ** rng.uniform(0.8, 1.8), "exponential": rng.uniform(5, 25), "gaussian": rng.uniform(8, 60)}[kind]
    body = smooth(rng, 0.03, 0.9, 0.3)
    if material_type == "I":
        interface = np.full_like(body, rng.uniform(0.3, 3.0))
    else:
        while True:  # a Type II whose constant does not happen to lie in the span
            interface = smooth(rng, 0.2, 2.0, 0.4)
            if departure_from_span(np.stack([interface, body])) > 0.06:
                break
    values = printed_dielectric(geometry, kind, float(n), interface, body)
    return Truth(material_type, kind, float(n), interface, body, geometry, values)
