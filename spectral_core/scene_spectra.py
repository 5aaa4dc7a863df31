"""The spectral side of a scene: which spectra its light is made of, and what a product of them weighs.

Light on any path is a product of one emitter's spectrum and the reflectances it met. A :class:`Term` names such a
product by the slots it multiplies, not by their values, so the values can be exchanged after the rays were traced.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .colorimetry import Observer, WavelengthGrid, tristimulus_weights
from .errors import InvalidParameterError
from .lights import require_strength
from .reflection.materials import GRAZING, Material, TypeII
from .reflection.mirror import MIRROR, mirror_reflectances, scaled_to_peak
from .resampling import resample
from .rgb_uplift import basis_spectra
from .spectra import Spectrum, require_not_negative
from .textured_reflectance import require_plain

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["IMAGE", "Emitter", "ReflectanceSlot", "SceneSpectra", "Term", "slots_of_image", "slots_of_material"]


IMAGE = "image"
"""What the components of the slots of an image's primaries begin with."""


@dataclass(frozen=True, slots=True, order=True)
class Term:
    """A monomial: one emitter times the reflectances of the slots it met.

    Attributes
    ----------
    emitter : int
        Index into ``SceneSpectra.emitters``.
    slots : tuple of int
        Indices into ``SceneSpectra.slots``, sorted; a slot met twice stands twice.
    """

    emitter: int
    slots: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Emitter:
    """A light's or the world's spectrum and strength, without its geometry.

    Attributes
    ----------
    name : str
        The light's name.
    illuminant : Spectrum
        Relative spectral power distribution.
    strength : float
        Watts, W/m^2 or display whites, as the kind of light has it.
    kind : str
        "lamp" of a scene's light, "world", or "surface" of what a material emits.
    """

    name: str
    illuminant: Spectrum
    strength: float
    kind: str = "lamp"

    def __post_init__(self) -> None:
        if not isinstance(self.illuminant, Spectrum):
            raise InvalidParameterError(f"illuminant of light '{self.name}' must be a Spectrum")
        require_strength(f"strength of light '{self.name}'", self.strength)
        require_not_negative(f"illuminant of light '{self.name}'", self.illuminant)


@dataclass(frozen=True, slots=True)
class ReflectanceSlot:
    """One reflectance spectrum of one material.

    Attributes
    ----------
    material : str
        The material's name.
    component : str
        "body", "interface", or another of the material's ``component_names``.
    reflectance : Spectrum
        The spectrum.
    is_unit : bool
        Whether it is the constant 1 of Eq. 13, which no term needs to name and nothing may change.
    """

    material: str
    component: str
    reflectance: Spectrum
    is_unit: bool = False

    def __post_init__(self) -> None:
        require_not_negative(f"{self.component} reflectance of material '{self.material}'", self.reflectance)


def slots_of_material(name: str, material: Material) -> tuple[ReflectanceSlot, ...]:
    """List the slots that a material takes.

    Parameters
    ----------
    name : str
        The material's name.
    material : Material
        The material.

    Returns
    -------
    tuple of ReflectanceSlot
        One a component, and one more for what a mirroring cloth or paper mirrors with.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    slots = [
        ReflectanceSlot(name, component, reflectance, component == GRAZING)
        for component, reflectance in zip(material.component_names, material.reflectances, strict=True)
    ]
    if isinstance(material, TypeII) and mirror_reflectances(material):
        interface = require_plain("interface_reflectance of a mirror", material.interface_reflectance)
        slots.append(ReflectanceSlot(name, MIRROR, scaled_to_peak(interface)))
    return tuple(slots)


def slots_of_image(name: str) -> tuple[ReflectanceSlot, ...]:
    """List the slots of an image's primaries, by which its colours are made of the light behind it.

    Parameters
    ----------
    name : str
        What shows the image.

    Returns
    -------
    tuple of ReflectanceSlot
        Red, green and blue.

    Raises
    ------
    None.

    References
    ----------
    Mallett and Yuksel 2019; see :mod:`~spectral_core.rgb_uplift`.
    """
    return tuple(
        ReflectanceSlot(name, f"{IMAGE} {colour}", basis)
        for colour, basis in zip(("red", "green", "blue"), basis_spectra(), strict=True)
    )


@dataclass(frozen=True, slots=True)
class SceneSpectra:
    """All spectra of a scene, and the tristimulus values of their products.

    Attributes
    ----------
    emitters : tuple of Emitter
        The lights in the scene's order, the world, and what materials emit, in the order of those that do.
    slots : tuple of ReflectanceSlot
        The reflectances of all materials, in the scene's order; last the primaries of the world's image, if it has one.
    """

    emitters: tuple[Emitter, ...]
    slots: tuple[ReflectanceSlot, ...]

    @classmethod
    def from_scene(cls, scene: Scene) -> SceneSpectra:
        """Collect the spectra of a scene.

        Parameters
        ----------
        scene : Scene
            The scene.

        Returns
        -------
        SceneSpectra
            With the lights, the world, and the materials that emit; and the materials' reflectances in order.

        Raises
        ------
        InvalidParameterError
            If an emitter is invalid.

        References
        ----------
        Own design.
        """
        emitters = [Emitter(light.name, light.illuminant, light.strength) for light in scene.lights]
        emitters.append(Emitter(scene.world.name, scene.world.illuminant, scene.world.strength, "world"))
        emitters += [Emitter(e.name, e.illuminant, e.strength, "surface") for e in scene.emissions if e is not None]
        slots: list[ReflectanceSlot] = []
        for name, material in zip(scene.material_names, scene.materials, strict=True):
            slots += slots_of_material(name, material)
        if scene.world.image is not None:
            slots += slots_of_image(scene.world.name)
        return cls(tuple(emitters), tuple(slots))

    def with_light(
        self, name: str, *, illuminant: Spectrum | None = None, strength: float | None = None
    ) -> SceneSpectra:
        """Return the spectra with one lamp exchanged or dimmed.

        Parameters
        ----------
        name : str
            The light's name; every light of that name is changed.
        illuminant : Spectrum, optional
            New relative spectral power distribution.
        strength : float, optional
            New strength, at least 0.

        Returns
        -------
        SceneSpectra
            A changed copy.

        Raises
        ------
        InvalidParameterError
            If no light has the name.

        References
        ----------
        Own design.
        """
        found = False
        emitters = []
        for emitter in self.emitters:
            if emitter.name == name:
                found = True
                emitter = replace(
                    emitter,
                    illuminant=emitter.illuminant if illuminant is None else illuminant,
                    strength=emitter.strength if strength is None else strength,
                )
            emitters.append(emitter)
        if not found:
            known = ", ".join(f"'{e.name}'" for e in self.emitters)
            raise InvalidParameterError(f"no light is named '{name}'; the scene has {known}")
        return replace(self, emitters=tuple(emitters))

    def with_reflectance(self, material: str, component: str, reflectance: Spectrum) -> SceneSpectra:
        """Return the spectra with one reflectance of one material exchanged.

        Parameters
        ----------
        material : str
            The material's name.
        component : str
            "body", "interface", or another of the material's components. Of a textured body these are the spectra that
            its picture mixes ("body red"): exchanging one prints the same picture with another ink.
        reflectance : Spectrum
            The new spectrum.

        Returns
        -------
        SceneSpectra
            A changed copy.

        Raises
        ------
        InvalidParameterError
            If no material of that name has such a component, or it is textured.

        References
        ----------
        Own design.
        """
        free = [(i, s) for i, s in enumerate(self.slots) if not s.is_unit and s.component != MIRROR]
        hits = [i for i, s in free if s.material == material and s.component == component]
        if not hits:
            parts = ", ".join(
                f"'{s.component}'"
                for _, s in free
                if s.material == material and s.component.startswith(f"{component} ")
            )
            if component and parts:
                raise InvalidParameterError(
                    f"the {component} of material '{material}' is a texture that mixes {parts}: exchange one of these"
                )
            known = ", ".join(f"'{s.material}' {s.component}" for _, s in free)
            raise InvalidParameterError(
                f"no material '{material}' has a {component} reflectance; the scene has {known}"
            )
        slots = list(self.slots)
        for index in hits:
            slots[index] = replace(slots[index], reflectance=reflectance)
        if component == "interface":  # the mirror of a cloth follows its interface
            for index, slot in enumerate(slots):
                if slot.material == material and slot.component == MIRROR:
                    slots[index] = replace(slot, reflectance=scaled_to_peak(reflectance))
        return replace(self, slots=tuple(slots))

    def tristimulus_table(self, terms: Sequence[Term], observer: Observer, grid: WavelengthGrid) -> NDArray[np.float64]:
        """XYZ of every term for a geometric coefficient of 1.

        Equal spectra are integrated once: each distinct product is one row of work, however many terms share it.

        Parameters
        ----------
        terms : sequence of Term, length K
            The terms.
        observer : Observer
            Colour-matching functions.
        grid : WavelengthGrid
            Where the reflectances are sampled.

        Returns
        -------
        ndarray of float64, shape (K, 3)
            X, Y, Z, scaled so that an emitter of strength 1 on a perfect diffuser has Y = 1.

        Raises
        ------
        InvalidParameterError
            If an illuminant has no luminance for the observer.

        References
        ----------
        Linearity of Tominaga 1996, Eqs. 4 and 7, in the spectra; ASTM E2022 for the weighting tables.
        """
        table = np.zeros((len(terms), 3))
        weights: dict[bytes, NDArray[np.float64]] = {}
        samples: dict[bytes, NDArray[np.float64]] = {}
        products: dict[tuple[bytes, ...], NDArray[np.float64]] = {}
        for row, term in enumerate(terms):
            emitter = self.emitters[term.emitter]
            if emitter.strength == 0.0:
                continue
            lamp = emitter.illuminant.key
            reflectances = [self.slots[slot].reflectance for slot in term.slots]
            key = (lamp, *sorted(r.key for r in reflectances))
            if key not in products:
                if lamp not in weights:
                    weights[lamp] = tristimulus_weights(emitter.illuminant, observer, grid)
                product = np.ones(len(grid.wavelengths_nm))
                for reflectance in reflectances:
                    if reflectance.key not in samples:
                        samples[reflectance.key] = reflectance.at(grid.wavelengths_nm)
                    product = product * samples[reflectance.key]
                products[key] = product @ weights[lamp]
            table[row] = emitter.strength * products[key]
        return table

    def radiance_table(
        self, terms: Sequence[Term], wavelengths_nm: NDArray[np.float64], observer: Observer
    ) -> NDArray[np.float64]:
        """Spectrum of every term for a geometric coefficient of 1.

        Parameters
        ----------
        terms : sequence of Term, length K
            The terms.
        wavelengths_nm : ndarray, shape (W,)
            Where to sample (nm), increasing. Lamps whose data are finer than these steps are averaged over them, so
            that a line between two samples is not lost.
        observer : Observer
            Whose luminance brings the illuminants to Y = 1.

        Returns
        -------
        ndarray of float64, shape (K, W)
            Relative radiance per nm, on the scale on which the sum at 1 nm against the observer gives
            ``tristimulus_table`` of the exact grid.

        Raises
        ------
        InvalidParameterError
            If an illuminant has no luminance for the observer, or the wavelengths do not increase.

        References
        ----------
        Tominaga 1996, Eqs. 1 and 4.
        """
        table = np.zeros((len(terms), len(wavelengths_nm)))
        for row, term in enumerate(terms):
            emitter = self.emitters[term.emitter]
            if emitter.strength == 0.0:
                continue
            luminance = _luminance(emitter.illuminant, observer)
            power = resample(emitter.illuminant, wavelengths_nm).spectrum.values
            lamp = power / luminance * emitter.strength
            table[row] = lamp * self.product_at(term.slots, wavelengths_nm)
        return table

    def product_at(self, slots: Sequence[int], wavelengths_nm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Multiply the reflectances of some slots.

        Parameters
        ----------
        slots : sequence of int
            Indices into `slots`; none gives 1.
        wavelengths_nm : ndarray, shape (W,)
            Where to sample (nm).

        Returns
        -------
        ndarray of float64, shape (W,)
            The product.

        Raises
        ------
        IndexError
            If a slot is not there.

        References
        ----------
        Own design.
        """
        product = np.ones(len(wavelengths_nm))
        for slot in slots:
            product = product * self.slots[slot].reflectance.at(wavelengths_nm)
        return product

    def distinct_products(self, terms: Iterable[Term]) -> int:
        """How many different products of spectra the terms stand for.

        Parameters
        ----------
        terms : iterable of Term
            The terms.

        Returns
        -------
        int
            Their number after equal spectra are merged.

        Raises
        ------
        IndexError
            If a term points outside the spectra.

        References
        ----------
        Own design.
        """
        keys = set()
        for term in terms:
            slots = sorted(self.slots[slot].reflectance.key for slot in term.slots)
            keys.add((self.emitters[term.emitter].illuminant.key, *slots))
        return len(keys)


def _luminance(illuminant: Spectrum, observer: Observer) -> float:
    """Integral of illuminant times the observer's y at 1 nm."""
    y = observer.matching_functions[:, 1]
    total = float(resample(illuminant, observer.wavelengths_nm).spectrum.values @ y)
    if not total > 0.0:
        raise InvalidParameterError(f"illuminant '{illuminant.name}' has no luminance for observer {observer.name}")
    return total
