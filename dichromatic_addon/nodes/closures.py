"""What a tree of shaders comes to: weighted parts, each a body, a lobe, a light, or a material of our own nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

from .._core import core
from .links import Origin

__all__ = [
    "Body",
    "Finished",
    "Glow",
    "Lobe",
    "Parts",
    "Tint",
    "lobe_of_finished",
    "lobe_of_roughness",
    "mirrored_share",
]

SMOOTHEST = 0.02  # Blender's roughness below which a lobe would fall between the pixels; a = 4e-4
SHARP_UP_TO = 0.3  # roughness: facets tilt by 5 degrees, and what is mirrored is blurred over 10
BLURRED_FROM = 0.5  # roughness: what is mirrored is a wash of light, better left out than shown sharply


@dataclass(frozen=True, slots=True)
class Tint:
    """A reflectance with where it came from, so that a conversion can link it again.

    Attributes
    ----------
    spectrum : Spectrum
        Not negative.
    colour : tuple of float, optional
        Scene linear RGB of which the spectrum is the uplift.
    source : Origin, optional
        What was linked and can be linked to one of our nodes as it is.
    texture : TexturedReflectance, optional
        Where an image has to do with it: what varies over the surface, of which the spectrum is the average.
    """

    spectrum: Any
    colour: tuple[float, float, float] | None = None
    source: Origin | None = None
    texture: Any = None

    @classmethod
    def of(cls, reflectance: Any, source: Origin | None = None) -> Tint:
        """Make a tint of a plain or textured reflectance of the core."""
        if isinstance(reflectance, core.TexturedReflectance):
            return cls(reflectance.average(), source=source, texture=reflectance)
        return cls(reflectance, source=source)

    @property
    def reflectance(self) -> Any:
        """The texture where there is one, else the spectrum."""
        return self.spectrum if self.texture is None else self.texture


@dataclass(frozen=True, slots=True)
class Body:
    """A matte part, of albedo `weight` times the tint."""

    weight: float
    tint: Tint


@dataclass(frozen=True, slots=True)
class Lobe:
    """A highlight, of albedo `weight` times the tint.

    Attributes
    ----------
    weight : float
        Its share in the material.
    tint : Tint
        Reflectance at normal incidence.
    attenuation, n : str, float
        Its law, as in the core.
    mirror : float
        Reflectance, at the strongest wavelength, with which it mirrors the scene; without the weight.
    is_metal : bool
        Whether it turns white towards grazing angles without a body below.
    """

    weight: float
    tint: Tint
    attenuation: str = "cosine"
    n: float = 10.0
    mirror: float = 0.0
    is_metal: bool = False

    @property
    def sharpness(self) -> float:
        """The g of exp(-g rho^2) that the lobe is closest to; S_I over the albedo, as approximation.py explains."""
        if self.attenuation == "exponential":
            return self.n**2 / math.log(2.0)
        return self.n if self.attenuation == "gaussian" else 0.5 * self.n


@dataclass(frozen=True, slots=True)
class Glow:
    """Light that the surface gives.

    Attributes
    ----------
    strength : float
        Radiance, 1 being as bright as white under a sun of strength pi.
    illuminant : Spectrum
        Its relative spectral power.
    colour : tuple of float, optional
        Scene linear RGB with the strength in it, where the light was given by a colour.
    plain_strength : float
        The strength without what a colour makes of it.
    """

    strength: float
    illuminant: Any
    colour: tuple[float, float, float] | None = None
    plain_strength: float = 0.0


@dataclass(frozen=True, slots=True)
class Finished:
    """A material of one of our surface nodes."""

    weight: float
    material: Any
    node: Any


@dataclass(slots=True)
class Parts:
    """The parts of a material as they are collected.

    Attributes
    ----------
    bodies, lobes, glows, finished : list
        What was found.
    transparent : float
        Share of the material through which what is behind would be seen.
    notes : list of str
        What was approximated, each once.
    """

    bodies: list[Body] = field(default_factory=list)
    lobes: list[Lobe] = field(default_factory=list)
    glows: list[Glow] = field(default_factory=list)
    finished: list[Finished] = field(default_factory=list)
    transparent: float = 0.0
    notes: list[str] = field(default_factory=list)

    def note(self, text: str) -> None:
        """Remember an approximation once."""
        if text not in self.notes:
            self.notes.append(text)

    def opaque(self) -> None:
        """Give what is transparent to the rest, as transparency is not rendered."""
        if not 0.0 < self.transparent < 1.0:
            return
        factor = 1.0 / (1.0 - self.transparent)
        self.bodies = [replace(part, weight=part.weight * factor) for part in self.bodies]
        self.lobes = [replace(part, weight=part.weight * factor) for part in self.lobes]
        self.finished = [replace(part, weight=part.weight * factor) for part in self.finished]


def lobe_of_roughness(
    weight: float, tint: Tint, roughness: float, *, is_metal: bool = False, mirrors: bool = True
) -> Lobe:
    """Return the lobe cos(rho)^n of a microfacet lobe, with its width and its peak near the normal.

    A lobe of width a = roughness^2 has the peak F / (4 a^2) and the width of cos(rho)^n with n = 1 / (2 a^2).

    Parameters
    ----------
    weight : float
        Its share in the material.
    tint : Tint
        F, the reflectance at normal incidence.
    roughness : float
        Blender's, 0 to 1.
    is_metal : bool, optional
        Whether it stands alone, without a body below.
    mirrors : bool, optional
        Whether it may mirror the scene.

    Returns
    -------
    Lobe
        The lobe.

    Raises
    ------
    None.
    """
    roughness = min(max(roughness, SMOOTHEST), 1.0)
    strongest = float(tint.spectrum.values.max())
    mirror = min(strongest, 1.0) * mirrored_share(roughness) if mirrors else 0.0
    return Lobe(weight, tint, "cosine", 0.5 / roughness**4, mirror, is_metal)


def mirrored_share(roughness: float) -> float:
    """Return how much of its surroundings a rough surface shows sharply: all when smooth, nothing when blurred."""
    share = (BLURRED_FROM - roughness) / (BLURRED_FROM - SHARP_UP_TO)
    return min(max(share, 0.0), 1.0)


def lobe_of_finished(finished: Finished) -> Lobe:
    """Return the highlight of a material of ours, of any type, so that it can be mixed with others."""
    material = finished.material
    interface = material.reflectances[0]
    if isinstance(material, core.TypeII):
        interface = Tint.of(material.interface_reflectance).spectrum
    if isinstance(material, core.TypeIII):
        across = material.beta if material.beta_across is None else material.beta_across
        width_squared = max(material.beta * across, SMOOTHEST**4) / math.log(2.0)  # a^2
        mirror = material.mirror * min(float(interface.values.max()), 1.0)
        return Lobe(finished.weight, Tint(interface), "cosine", 0.5 / width_squared, mirror, True)
    lobe = Lobe(finished.weight, Tint(interface), material.attenuation, material.n, material.mirror)
    return replace(lobe, tint=Tint(interface.scaled(1.0 / max(lobe.sharpness, 1e-12), name=interface.name)))
