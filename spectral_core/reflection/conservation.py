"""Factors that keep the reflection laws from creating light; the derivations are in docs/energy.md.

Types I and II: the interface lobe f(rho) (N.L) has the directional albedo

    a(theta) = 1/pi * integral over the hemisphere of f(rho) (N.V) dV
             = 1/pi * integral of f(rho) sin(rho) J(rho, theta) d rho,

where J, the integral of max(N.V, 0) around the circle of radius rho about the mirror direction, has a closed form; so
only one dimension is left to numerical integration. Type III: D G / (N.V) times pi / (4 * integral of D cos(alpha)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import require_choice, require_in_range
from .angles import within
from .attenuation import ATTENUATIONS, MAX_EXPONENT, attenuation_at_angle
from .uniform_table import UniformTable

__all__ = ["InterfaceAlbedo", "facet_normalisation", "interface_lobe_albedo"]

Float64 = NDArray[np.float64]


def gauss_legendre(count: int) -> tuple[Float64, Float64]:
    """Nodes and weights (count,) on [-1, 1]."""
    points, weights = np.polynomial.legendre.leggauss(count)  # type: ignore[no-untyped-call]
    return points, weights


PANEL_POINTS = 10
SHARPEST = 40  # halvings of the first panel: 2**-40 rad is far inside the sharpest lobe, 1e-8 rad
TABLE_INTERVALS = 512
TABLE_BLOCK = 64


def graded_nodes(
    low: Float64, high: Float64, left: int, right: int, points: int = PANEL_POINTS
) -> tuple[Float64, Float64]:
    """Gauss-Legendre nodes and weights (..., P) on [low, high]; panels halve `left`, `right` times to the ends."""
    steps = np.concatenate([[0.0], 0.5 ** np.arange(left + 1, 0, -1), 1.0 - 0.5 ** np.arange(2, right + 2), [1.0]])
    width = np.diff(steps)
    nodes, weights = gauss_legendre(points)
    unit = (steps[:-1, None] + 0.5 * width[:, None] * (nodes + 1.0)).reshape(-1)
    weight = (0.5 * width[:, None] * weights).reshape(-1)
    span = (high - low)[..., None]
    return low[..., None] + span * unit, span * weight


def mirror_nodes(incidence: Float64, points: int = PANEL_POINTS) -> tuple[Float64, Float64]:
    """Nodes and weights (A, P) in rho for lobes about the mirror direction of a light at `incidence` (A,).

    The integrand has corners where the circle of radius rho touches the horizon (pi/2 - incidence and
    pi/2 + incidence) and where the cosine law ends (pi/2).
    """
    touch = np.pi / 2 - incidence
    zero, right_angle, end = np.zeros_like(incidence), np.full_like(incidence, np.pi / 2), np.pi / 2 + incidence
    parts = [
        graded_nodes(zero, touch, SHARPEST, 8, points),
        graded_nodes(touch, right_angle, SHARPEST, 24, points),
        graded_nodes(right_angle, end, 12, 12, points),
    ]
    return np.concatenate([p[0] for p in parts], axis=-1), np.concatenate([p[1] for p in parts], axis=-1)


def visible_arc(rho: Float64, incidence: Float64) -> Float64:
    """Half the azimuth range, 0 to pi, in which the circle of radius rho stands above the horizon."""
    along, across = np.cos(incidence) * np.cos(rho), np.sin(incidence) * np.sin(rho)
    return np.where(along >= across, np.pi, np.arccos(np.clip(-along / np.where(across > 0.0, across, 1.0), -1.0, 1.0)))


def interface_lobe_albedo(kind: str, n: float, incidence: ArrayLike) -> Float64:
    """Directional albedo of the lobe f(rho) (N.L) with unit reflectance, a(theta) of docs/energy.md.

    Parameters
    ----------
    kind : {"cosine", "exponential", "gaussian"}
        The attenuation law.
    n : float
        0 to 1e8.
    incidence : array_like
        Angles in radians, 0 to pi/2, any shape.

    Returns
    -------
    ndarray of float64
        0 to 1, largest at normal incidence. Dividing by cos(incidence) gives the albedo of the paper's own lobe,
        which has no N.L. Relative error below 1e-9.

    Raises
    ------
    InvalidParameterError
        If the law is unknown, or n or an angle lies outside its range.

    References
    ----------
    Own derivation, docs/energy.md. For the cosine law at normal incidence it is 2 / (n + 2).
    """
    require_choice("attenuation", kind, ATTENUATIONS)
    n = float(require_in_range("n", n, 0.0, MAX_EXPONENT))
    angle = within("incidence", incidence, 0.0, np.pi / 2)
    flat = angle.reshape(-1)
    out = np.empty(flat.shape)
    for start in range(0, flat.size, TABLE_BLOCK):
        theta = flat[start : start + TABLE_BLOCK]
        rho, weight = mirror_nodes(theta)
        arc = visible_arc(rho, theta[:, None])
        along = np.cos(theta)[:, None] * np.cos(rho)
        across = np.sin(theta)[:, None] * np.sin(rho)
        circle = 2.0 * (along * arc + across * np.sin(arc))
        lobe = attenuation_at_angle(kind, n, np.minimum(rho, np.pi)) * np.sin(rho)
        out[start : start + TABLE_BLOCK] = np.sum(weight * lobe * circle, axis=-1) / np.pi
    return out.reshape(angle.shape)


class InterfaceAlbedo:
    """Table of a(theta) of one lobe, and what the conserving form of Types I and II derives from it.

    Parameters
    ----------
    kind : {"cosine", "exponential", "gaussian"}
        The attenuation law.
    n : float
        0 to 1e8.
    largest_reflectance : float
        Largest value of S_I over wavelength, not negative.
    """

    __slots__ = ("_level", "_mean", "_scale", "_table")

    def __init__(self, kind: str, n: float, largest_reflectance: float) -> None:
        cosine = np.linspace(0.0, 1.0, TABLE_INTERVALS + 1)
        albedo = interface_lobe_albedo(kind, n, np.arccos(cosine))
        points, weights = gauss_legendre(64)
        u = 0.5 * (points + 1.0)
        mean = float(np.sum(weights * u * interface_lobe_albedo(kind, n, np.arccos(u))))
        largest = float(albedo[-1])
        self._table = UniformTable(albedo)
        # Limit the lobe so that it never reflects more than it gets.
        self._level = min(largest_reflectance, 1.0 / largest)
        self._scale = self._level / largest_reflectance if largest_reflectance > 0.0 else 1.0
        self._mean = mean

    @property
    def interface_scale(self) -> float:
        """Factor of the interface coefficient, 1 unless the lobe alone would create light.

        Returns
        -------
        float
            Above 0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Own derivation, docs/energy.md.
        """
        return self._scale

    def body_share(self, normal_light: Float64, normal_viewer: Float64) -> Float64:
        """Share of the light that reaches the body and gets out again, reciprocal in light and viewer.

        Parameters
        ----------
        normal_light, normal_viewer : ndarray of float64
            N.L and N.V, 0 to 1.

        Returns
        -------
        ndarray of float64
            (1 - S a(L)) (1 - S a(V)) / (1 - S a_mean), not negative.

        Raises
        ------
        None.

        References
        ----------
        Kelemen, C. & Szirmay-Kalos, L. (2001), "A microfacet based coupled specular-matte BRDF model", Eurographics.
        """
        left = 1.0 - self._level * self._mean
        if left <= 1.0e-12:  # the interface reflects everything at all angles (n = 0): nothing reaches the body
            return np.zeros_like(normal_light)
        into = np.maximum(1.0 - self._level * self._table.read(normal_light), 0.0)
        out = np.maximum(1.0 - self._level * self._table.read(normal_viewer), 0.0)
        return np.asarray(into * out / left)


def facet_normalisation(beta: float, beta_across: float | None = None) -> float:
    """Factor pi / (4 * integral of D cos(alpha) d omega) that makes D G / (N.V) conserve energy.

    Parameters
    ----------
    beta : float
        Half-value angle in radians, 1e-6 to pi/2.
    beta_across : float, optional
        Half-value angle across the tangent, 1e-6 to pi/2; None for an isotropic surface.

    Returns
    -------
    float
        For small angles ln 2 / (4 beta beta_across); 1 at 26.4 deg, below 1 for rougher surfaces. Its reciprocal is
        the albedo of the paper's D G / (N.V) towards grazing incidence, where it is largest.

    Raises
    ------
    InvalidParameterError
        If an angle lies outside its range: a perfect mirror has no finite radiance factor.

    References
    ----------
    Own derivation, docs/energy.md.
    """
    along = float(within("beta", require_in_range("beta", beta, 1.0e-6, unit="rad"), 0.0, np.pi / 2))
    across = along if beta_across is None else beta_across
    across = float(within("beta_across", require_in_range("beta_across", across, 1.0e-6, unit="rad"), 0.0, np.pi / 2))
    # Over azimuth, with the mean exponent p and half the difference q of the two axes, the Gaussian integrates to
    # 2 pi exp(-p) I0(q); the Bessel function is done by the trapezoidal rule, which is exact for periodic integrands.
    low, high = sorted((np.log(2.0) / along**2, np.log(2.0) / across**2))
    alpha, weight = graded_nodes(np.zeros(1), np.full(1, np.pi / 2), SHARPEST, 2)
    alpha, weight = alpha[0], weight[0]
    if low == high:
        ring = 2.0 * np.pi * np.exp(-low * alpha**2)
    else:
        # Substitution psi = atan(r tan u), r = sqrt(low / high), spreads the nodes evenly over a narrow ellipse.
        u = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
        r = np.sqrt(low / high)
        sine = (r * np.sin(u)) ** 2 / (np.cos(u) ** 2 + (r * np.sin(u)) ** 2)
        jacobian = r / (np.cos(u) ** 2 + (r * np.sin(u)) ** 2)
        exponent = -(low + (high - low) * sine) * (alpha**2)[:, None]
        ring = 2.0 * np.pi * np.mean(np.exp(exponent) * jacobian, axis=1)
    return float(np.pi / (4.0 * np.sum(weight * ring * np.cos(alpha) * np.sin(alpha))))
