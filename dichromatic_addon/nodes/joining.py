"""From the parts of a foreign material to one material of the core: bodies are averaged, lobes combined."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .._core import core
from ..spectrum_sources import luminance, tinted_daylight, uplifted
from .closures import Body, Glow, Lobe, Parts, Tint, lobe_of_finished

__all__ = ["Joined", "add_glows", "join", "weighted_sum"]

SAME_SHARPNESS = 4.0  # ratio of g within which two lobes become one; a factor of 1.4 in Blender's roughness
LARGEST_NEUTRAL = 1.0e6  # S_I of Type I; stronger ones are Type II
METALLIC = 0.15  # reflectance from which a glossy part is no mere highlight of plastic
NOTHING = 1e-6  # albedo below which a part is not there


@dataclass(frozen=True, slots=True)
class Joined:
    """One material and the light that it gives.

    Attributes
    ----------
    material : Material
        Of the core.
    body : Tint
        Its body (black for metals), to be linked again by a conversion.
    lobe : Lobe or None
        Its highlight.
    glow : Glow or None
        Its light.
    only_glows : bool
        Whether it gives light and reflects none.
    """

    material: core.Material
    body: Tint
    lobe: Lobe | None
    glow: Glow | None
    only_glows: bool = False


def weighted_sum(tints: Sequence[tuple[float, Tint]]) -> Tint:
    """Add reflectances; a single one with the weight 1 is kept as it is, and so are colours.

    Parameters
    ----------
    tints : sequence of tuple of (float, Tint)
        Weights and reflectances.

    Returns
    -------
    Tint
        Their sum; black when there are none. The uplift of colours is linear, so that the sum of the spectra of
        colours is the spectrum of the sum of the colours.

    Raises
    ------
    None.
    """
    present = [(weight, tint) for weight, tint in tints if weight > 0.0]
    if len(present) == 1 and math.isclose(present[0][0], 1.0, abs_tol=NOTHING):
        return present[0][1]
    if any(tint.texture is not None for _, tint in present):
        return Tint.of(core.weighted_reflectance([(weight, tint.reflectance) for weight, tint in present]))
    colours = [tint.colour for _, tint in present]
    if all(colour is not None for colour in colours):
        weights = [weight for weight, _ in present]
        red, green, blue = np.asarray(weights) @ np.reshape(np.array(colours, np.float64), (-1, 3))
        total = (float(red), float(green), float(blue))
        return Tint(uplifted(total), total)
    spectra = [tint.spectrum for _, tint in present]
    if all(spectrum.is_constant for spectrum in spectra):
        wavelengths = spectra[0].wavelengths_nm[:1]
    else:
        wavelengths = np.unique(np.concatenate([core.REFERENCE_WAVELENGTHS_NM, *(s.wavelengths_nm for s in spectra)]))
    values = sum(weight * np.maximum(tint.spectrum.at(wavelengths), 0.0) for weight, tint in present)
    return Tint(core.Spectrum(wavelengths, values, name=" + ".join(dict.fromkeys(s.name for s in spectra if s.name))))


def join(parts: Parts) -> Joined:
    """Make one material of the parts; what that changes is added to their notes.

    Parameters
    ----------
    parts : Parts
        What a material's shaders came to.

    Returns
    -------
    Joined
        A material of Type III where everything is metal, else of Type I, or of Type II where the highlight is coloured.

    Raises
    ------
    DichromaticError
        If a number is invalid.
    """
    parts.opaque()
    glow = add_glows(parts)
    others = [*parts.bodies, *parts.lobes]
    if len(parts.finished) == 1 and not others and math.isclose(parts.finished[0].weight, 1.0, abs_tol=NOTHING):
        material = parts.finished[0].material
        body = material.reflectances[-1] if isinstance(material, core.TypeIII) else material.body_reflectance
        return Joined(material, Tint.of(body), None, glow)
    bodies, lobes = list(parts.bodies), list(parts.lobes)
    for finished in parts.finished:
        lobes.append(lobe_of_finished(finished))
        if not isinstance(finished.material, core.TypeIII):
            bodies.append(Body(finished.weight, Tint.of(finished.material.body_reflectance)))
    lobes = [lobe for lobe in lobes if lobe.weight * lobe.tint.spectrum.values.max() > NOTHING]
    if any(lobe.tint.texture is not None for lobe in lobes):
        parts.note("the image of a highlight is not rendered: the mean of its colors is used")
    lobe, broad = _one_lobe(lobes, parts)
    body = weighted_sum([(part.weight, part.tint) for part in (*bodies, *broad)])
    if lobe is not None and lobe.is_metal and not body.spectrum.values.max() > NOTHING:
        return Joined(_metal(lobe), body, lobe, glow)
    if lobe is not None and lobe.is_metal and lobe.weight * lobe.tint.spectrum.values.max() > METALLIC:
        parts.note("metal is mixed with a body: it is rendered as a colored highlight over the body")
    only_glows = glow is not None and lobe is None and not (bodies or parts.finished)
    return Joined(_dielectric(body, lobe), body, lobe, glow, only_glows=only_glows)


def _one_lobe(lobes: list[Lobe], parts: Parts) -> tuple[Lobe | None, list[Body]]:
    """Combine highlights into one; broad ones beside a sharp one become part of the body."""
    if not lobes:
        return None, []

    def importance(lobe: Lobe) -> float:
        return lobe.weight * float(lobe.tint.spectrum.values.max()) * math.sqrt(lobe.sharpness)

    main = max(lobes, key=importance)
    near = [lobe for lobe in lobes if 1 / SAME_SHARPNESS <= lobe.sharpness / main.sharpness <= SAME_SHARPNESS]
    far = [lobe for lobe in lobes if not any(lobe is other for other in near)]
    if far:
        parts.note("highlights of very different sharpness are mixed: the strongest is rendered")
    broad = [Body(lobe.weight, lobe.tint) for lobe in far if lobe.sharpness < main.sharpness]
    if len(near) == 1 and not far:
        return main, []
    weights = np.array([lobe.weight * float(lobe.tint.spectrum.values.mean()) for lobe in near])
    same_law = all(lobe.attenuation == main.attenuation and math.isclose(lobe.n, main.n) for lobe in near)
    if same_law:
        attenuation, n = main.attenuation, main.n
    else:
        parts.note("highlights of different sharpness are mixed: one of their mean sharpness is rendered")
        logs = np.log([lobe.sharpness for lobe in near])
        attenuation, n = "cosine", 2.0 * math.exp(float(weights @ logs / weights.sum()))
    total = weighted_sum([(lobe.weight, lobe.tint) for lobe in near])
    mirror = sum(lobe.weight * lobe.mirror for lobe in near)
    combined = Lobe(1.0, total, attenuation, n, min(mirror, 1.0), all(lobe.is_metal for lobe in near))
    return combined, broad


def _metal(lobe: Lobe) -> core.TypeIII:
    """Make a metal; exp(-ln 2 alpha^2 / beta^2) has the width a = beta / sqrt(ln 2)."""
    reflectance = lobe.tint.spectrum.scaled(min(lobe.weight, 1.0), name=lobe.tint.spectrum.name)
    clipped = core.Spectrum(reflectance.wavelengths_nm, np.clip(reflectance.values, 0.0, 1.0), reflectance.name)
    beta = math.sqrt(math.log(2.0) * 0.25 / lobe.sharpness)
    strongest = min(float(lobe.tint.spectrum.values.max()), 1.0)
    share = min(lobe.mirror / strongest, 1.0) if strongest > 0.0 else 0.0
    return core.TypeIII.from_normal_reflectance(clipped, min(beta, 0.5 * math.pi), energy_conserving=True, mirror=share)


def _dielectric(body: Tint, lobe: Lobe | None) -> core.TypeI | core.TypeII:
    if lobe is None:
        return core.TypeI(body_reflectance=body.reflectance, interface_reflectance=0.0, attenuation="cosine", n=1.0)
    reflectance = lobe.tint.spectrum
    scale = lobe.weight * lobe.sharpness
    mirror = min(lobe.weight * lobe.mirror, 1.0)
    if reflectance.is_constant and float(reflectance.values[0]) * scale <= LARGEST_NEUTRAL:
        level = float(reflectance.values[0]) * scale
        return core.TypeI(body.reflectance, level, lobe.attenuation, lobe.n, mirror=mirror)
    interface = reflectance.scaled(scale, name=reflectance.name)
    return core.TypeII(body.reflectance, interface, lobe.attenuation, lobe.n, mirror=mirror)


def add_glows(parts: Parts) -> Glow | None:
    """Add up the light that shaders give.

    Parameters
    ----------
    parts : Parts
        What a tree of shaders came to.

    Returns
    -------
    Glow or None
        One light; None where there is none.

    Raises
    ------
    None.
    """
    glows = parts.glows
    if not glows:
        return None
    colours = [glow.colour for glow in glows]
    if len(glows) > 1 and all(colour is not None for colour in colours):
        red, green, blue = np.sum(np.array(colours, np.float64), axis=0).tolist()
        total = (red, green, blue)
        strength = sum(glow.plain_strength for glow in glows)
        return Glow(luminance(total), tinted_daylight(total), total, strength)
    brightest = max(glows, key=lambda glow: glow.strength)
    if len(glows) > 1:
        parts.note("lights of different spectra are added: that of the brightest is rendered")
        total_strength = sum(glow.strength for glow in glows)
        return replace(brightest, strength=total_strength, plain_strength=total_strength, colour=None)
    return brightest
