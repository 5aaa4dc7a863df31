"""How much light a material sends on: directional albedo, white furnace, and warnings where it exceeds what arrives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..validation import require_in_range
from .conservation import facet_normalisation, gauss_legendre, interface_lobe_albedo, mirror_nodes, visible_arc
from .materials import Material, TypeI, TypeII, TypeIII

__all__ = ["AngularResponse", "directional_albedo", "energy_warnings", "furnace_response"]

Float64 = NDArray[np.float64]

LEVELS = ((6, 8), (8, 16), (12, 32), (20, 64), (32, 128), (48, 192))
"""Radial points per panel and azimuth points of the successive refinements."""

LARGEST_ANGLE = np.pi / 2 - 1.0e-6  # the paper's interface term diverges at the horizon itself
GRAZING_OF_NOTE = np.radians(1.0)  # warnings about lights lower than this would name every glossy material
BALANCE = 1.0 + 1.0e-9  # more than this is light created; less is rounding
_NO_FRACTION = 2.0  # fluorescence and glossy white standards stay below it; percent of all but black lie above


@dataclass(frozen=True, slots=True, eq=False)
class AngularResponse:
    """Reflected over received light for several directions.

    Parameters
    ----------
    angle : ndarray (A,)
        Angles from the normal in radians.
    wavelengths_nm : ndarray (W,)
        Wavelengths in nm.
    values : ndarray (A, W)
        1 means that as much is sent on as is received.
    error : ndarray (A, W)
        Estimate of the integration error of `values`: the larger of the changes in the last two refinements.
    """

    angle: Float64
    wavelengths_nm: Float64
    values: Float64
    error: Float64


def _directions(angle: float, azimuth: float, rho: Float64, psi: Float64) -> Float64:
    """Unit vectors (..., 3) at distance rho and azimuth psi about the mirror image of the given direction (N = z)."""
    sine, cosine = np.sin(angle), np.cos(angle)
    mirror = np.array([-sine * np.cos(azimuth), -sine * np.sin(azimuth), cosine])
    upward = np.array([cosine * np.cos(azimuth), cosine * np.sin(azimuth), sine])
    sideways = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    radius = np.sin(rho)[..., None]
    return np.asarray(
        np.cos(rho)[..., None] * mirror + radius * (np.cos(psi)[..., None] * upward + np.sin(psi)[..., None] * sideways)
    )


def _integral(material: Material, angle: float, azimuth: float, level: tuple[int, int], seen: bool) -> Float64:
    """Integrals (Km,) over the hemisphere of the coefficients (seen), or of the coefficients times N.V (not seen)."""
    radial, around = level
    theta = np.array([angle])
    rho, weight = (a[0] for a in mirror_nodes(theta, radial))
    arc = visible_arc(rho, theta)
    points, shares = gauss_legendre(around)
    psi = arc[:, None] * points  # both sides of the plane of incidence: they differ for anisotropic metals
    directions = _directions(angle, azimuth, np.broadcast_to(rho[:, None], psi.shape), psi).reshape(-1, 3)
    measure = ((weight * np.sin(rho) * arc)[:, None] * shares).reshape(-1)
    normal = np.array([0.0, 0.0, 1.0])
    fixed = np.array([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)])
    tangent = np.array([1.0, 0.0, 0.0]) if material.needs_tangent else None
    if seen:
        coefficients = material.coefficients(normal, directions, fixed, tangent)
    else:
        coefficients = material.coefficients(normal, fixed, directions, tangent)
        measure = measure * np.maximum(directions[:, 2], 0.0)
    return np.asarray(measure @ coefficients)


def _response(
    material: Material,
    angle: ArrayLike,
    wavelengths_nm: ArrayLike | None,
    azimuth: float,
    tolerance: float,
    seen: bool,
) -> AngularResponse:
    angles = np.atleast_1d(require_in_range("angle", angle, 0.0, LARGEST_ANGLE, unit="rad"))
    if angles.ndim != 1:
        raise InvalidParameterError(f"angle must be a list, but has the shape {angles.shape}")
    azimuth = float(require_in_range("azimuth", azimuth, -2.0 * np.pi, 2.0 * np.pi, unit="rad"))
    tolerance = float(require_in_range("tolerance", tolerance, 1.0e-12, 1.0))
    spectra = material.reflectances
    if wavelengths_nm is None:
        coloured = [s for s in spectra if not s.is_constant] or spectra[:1]
        wavelengths = np.unique(np.concatenate([s.wavelengths_nm for s in coloured]))
    else:
        wavelengths = np.atleast_1d(require_in_range("wavelengths_nm", wavelengths_nm, 1.0, unit="nm"))
    reflectances = np.stack([s.at(wavelengths) for s in spectra])
    values = np.empty((angles.size, wavelengths.size))
    error = np.empty_like(values)
    for row, at in enumerate(angles):
        divisor = np.pi if seen else np.pi * np.cos(at)
        results = [_integral(material, at, azimuth, level, seen) @ reflectances / divisor for level in LEVELS[:2]]
        # One small change may be chance, where the edges of G cross the nodes; two in a row are taken for convergence.
        for level in LEVELS[2:]:
            results.append(_integral(material, at, azimuth, level, seen) @ reflectances / divisor)
            changes = np.abs(np.diff(results[-3:], axis=0)).max(axis=0)
            if changes.max() <= tolerance:
                break
        values[row], error[row] = results[-1], changes
    return AngularResponse(angles, wavelengths, values, error)


def directional_albedo(
    material: Material,
    incidence: ArrayLike,
    wavelengths_nm: ArrayLike | None = None,
    *,
    azimuth: float = 0.0,
    tolerance: float = 1.0e-5,
) -> AngularResponse:
    """Share of the light from one direction that a material sends on in all directions.

    Parameters
    ----------
    material : TypeI, TypeII or TypeIII
        The material.
    incidence : array_like (A,)
        Angles of incidence in radians, 0 to pi/2 - 1e-6. The paper's Types I and II diverge at the horizon.
    wavelengths_nm : array_like (W,), optional
        Wavelengths in nm; None takes those of the material's spectra, constants aside.
    azimuth : float
        Direction of the light about the normal, from the tangent, in radians; matters to anisotropic metals only.
    tolerance : float
        The integration is refined until two changes in a row are below this, at most five times.

    Returns
    -------
    AngularResponse
        1/(pi cos incidence) times the integral of radiance_factor * (N.V) over the hemisphere, with its error.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    docs/energy.md. Quadrature in polar coordinates about the mirror direction, panels halved towards it and towards
    the circles that touch the horizon; negative reflectances of Eq. 13 are not clamped in the integral.
    """
    return _response(material, incidence, wavelengths_nm, azimuth, tolerance, seen=False)


def furnace_response(
    material: Material,
    viewing_angle: ArrayLike,
    wavelengths_nm: ArrayLike | None = None,
    *,
    azimuth: float = 0.0,
    tolerance: float = 1.0e-5,
) -> AngularResponse:
    """Radiance that a material shows in a white furnace, a surround of radiance 1 from all directions.

    Parameters
    ----------
    material : TypeI, TypeII or TypeIII
        The material.
    viewing_angle : array_like (A,)
        Angles between normal and viewer in radians, 0 to pi/2 - 1e-6.
    wavelengths_nm : array_like (W,), optional
        Wavelengths in nm; None takes those of the material's spectra, constants aside.
    azimuth : float
        Direction of the viewer about the normal, from the tangent, in radians; matters to anisotropic metals only.
    tolerance : float
        The integration is refined until two changes in a row are below this, at most five times.

    Returns
    -------
    AngularResponse
        1/pi times the integral of radiance_factor over the directions of light, with its error. A perfect diffuser
        shows 1, and so does any lossless surface.

    Raises
    ------
    InvalidParameterError
        If an argument lies outside its range.

    References
    ----------
    docs/energy.md.
    """
    return _response(material, viewing_angle, wavelengths_nm, azimuth, tolerance, seen=True)


def _first_angle_above_one(albedo: Callable[[float], float]) -> float | None:
    """Smallest angle at which a rising albedo passes 1; None if it does not before the horizon."""
    low, high = 0.0, LARGEST_ANGLE
    if albedo(low) > BALANCE:
        return low
    if albedo(high) <= BALANCE:
        return None
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if albedo(middle) > BALANCE else (middle, high)
    return high


def _lobe_warnings(material: TypeI | TypeII) -> list[str]:
    interface, body = material.reflectances
    wavelengths = np.union1d(interface.wavelengths_nm, body.wavelengths_nm)
    glossy, matte = interface.at(wavelengths), body.at(wavelengths)
    found = []
    if matte.max() > BALANCE:
        found.append(f"the body reflectance reaches {matte.max():.3g}: above 1 the body alone creates light")
        if matte.max() > _NO_FRACTION:
            found[-1] += "; if these are percent, say % in the title of the file's column, or set a scale of 0.01"
    lobe = f"{material.attenuation} attenuation with n = {material.n:g} and interface reflectance {glossy.max():.3g}"
    shown = furnace_response(material, 0.0, wavelengths).values.max()
    if shown > BALANCE:
        found.append(f"{lobe}: seen along the normal in a uniform surround it shows {shown:.3g} times that light")

    def albedo(angle: float) -> float:
        share = interface_lobe_albedo(material.attenuation, material.n, angle) / np.cos(angle)
        return float((glossy * share + matte).max())

    limit = _first_angle_above_one(albedo)
    if limit == 0.0:
        found.append(f"{lobe}: from a light at the normal, and from any other, it reflects more than it receives")
    elif limit is not None and np.pi / 2 - limit >= GRAZING_OF_NOTE:
        found.append(
            f"{lobe}: from lights beyond {np.degrees(limit):.1f} deg of incidence it reflects more than it receives"
        )
    return found


def energy_warnings(material: Material) -> tuple[str, ...]:
    """Tell at which of its parameter values a material creates light.

    Parameters
    ----------
    material : TypeI, TypeII or TypeIII
        The material.

    Returns
    -------
    tuple of str
        One sentence per finding, with the parameter's value and how much light is created; empty if none is, and
        always empty for materials made with ``energy_conserving=True``. A textured material is judged where it is
        brightest. Lights within 1 deg of the horizon are not
        reported: there the interface of every Type I and II material reflects more than it receives.

    Raises
    ------
    InvalidParameterError
        If the material is none of the three types.

    References
    ----------
    docs/energy.md.
    """
    if not isinstance(material, (TypeI, TypeII, TypeIII)):
        raise InvalidParameterError(f"material must be of Type I, II or III, but is {material!r}")
    if material.energy_conserving:
        return ()
    if isinstance(material, TypeIII):
        across = material.beta if material.beta_across is None else material.beta_across
        if min(material.beta, across) < 1.0e-6:
            return ()  # a mirror: its lobe holds next to no light
        worst = 1.0 / facet_normalisation(material.beta, across)
        if worst <= BALANCE:
            return ()
        angles = f"beta = {np.degrees(material.beta):.3g} deg"
        if across != material.beta:
            angles += f" along and {np.degrees(across):.3g} deg across the tangent"
        return (f"{angles}: the rough surface reflects up to {worst:.4g} times what it receives, towards grazing",)
    return tuple(_lobe_warnings(material.untextured()))
