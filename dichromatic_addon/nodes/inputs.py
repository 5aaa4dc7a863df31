"""What a node's inputs say: numbers and spectra, through links, with reasons where they cannot be had."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._core import core
from ..image_reading import uplifted_texture
from ..names import SPECTRUM_NODE, SPECTRUM_NODES
from ..spectrum_sources import uplifted
from .evaluation import spectrum_of_node
from .image_chains import ImageChain, is_chained
from .images import IMAGE_NODE, Coordinates, interpolation_note, read_texture, texture_problem
from .links import Origin, origin_of

__all__ = ["InputReader", "Reflectance"]

Reflectance = core.Spectrum | core.TexturedReflectance

DEEPEST_MIX = 16  # mixtures of mixtures; more is taken for a cycle


@dataclass(slots=True)
class InputReader:
    """Reads inputs of nodes of one material.

    Attributes
    ----------
    material_name : str
        For the messages; empty to leave the material out of them.
    pictures : str
        How fresh the pixels of images must be, see ``image_reading.PICTURES``.
    coordinates : Coordinates or None
        What the images that were read are placed by; None while there were none.
    notes : list of str
        What was approximated.
    depth : int
        How deep in mixtures of mixtures the reading is.
    """

    material_name: str = ""
    pictures: str = "read"
    coordinates: Coordinates | None = field(default=None, init=False)
    notes: list[str] = field(default_factory=list, init=False)
    depth: int = field(default=0, init=False)

    def place(self, node: Any) -> str:
        """Say where a node is, for messages."""
        where = f" in material '{self.material_name}'" if self.material_name else ""
        return f"node '{node.name}'{where}"

    def number(self, node: Any, name: str, groups: tuple[Any, ...] = ()) -> float:
        """Read a number: the input's own, or that of a Value node.

        Parameters
        ----------
        node : bpy.types.Node
            The node.
        name : str
            The input's name.
        groups : tuple of bpy.types.Node, optional
            The group nodes around the node.

        Returns
        -------
        float
            The number.

        Raises
        ------
        SceneError
            If the input is missing, or linked to something that is no constant.
        """
        origin = self._origin(node, name, groups)
        problem = self.number_problem(origin)
        if origin is None or problem:
            raise core.SceneError(f"{name} of {self.place(node)}: {problem}")
        return float(origin.socket.default_value)

    def spectrum(self, node: Any, name: str, groups: tuple[Any, ...] = ()) -> core.Spectrum:
        """Read an input that takes one spectrum for the whole surface.

        Parameters
        ----------
        node : bpy.types.Node
            The node.
        name : str
            The input's name.
        groups : tuple of bpy.types.Node, optional
            The group nodes around the node.

        Returns
        -------
        Spectrum
            The spectrum.

        Raises
        ------
        SceneError
            As :meth:`reflectance`, or if an image is linked.
        """
        found = self.reflectance(node, name, groups)
        if isinstance(found, core.TexturedReflectance):
            raise core.SceneError(
                f"{name} of {self.place(node)}: the image '{found.name}' is linked, but one spectrum is needed here"
            )
        return found

    def reflectance(self, node: Any, name: str, groups: tuple[Any, ...] = ()) -> Reflectance:
        """Read a reflectance: of a Spectrum node, an image, uplifted from a colour, or constant.

        Parameters
        ----------
        node : bpy.types.Node
            The node.
        name : str
            The input's name.
        groups : tuple of bpy.types.Node, optional
            The group nodes around the node.

        Returns
        -------
        Spectrum or TexturedReflectance
            The latter where an image has to do with it.

        Raises
        ------
        SceneError
            If the input is missing, linked to something that is no spectrum, or the spectrum itself is invalid.
        """
        origin = self._origin(node, name, groups)
        problem = self.spectrum_problem(origin)
        if origin is None or problem:
            raise core.SceneError(f"{name} of {self.place(node)}: {problem}")
        if origin.socket.is_output and origin.node.bl_idname == IMAGE_NODE:
            return uplifted_texture(self._texture(node, name, origin, "colour"))
        if is_chained(origin):
            chain = ImageChain(origin)
            if chain.has_image:
                return core.uplift_texture(self._chained(chain, node, name, "colour"))
            return uplifted(chain.colour())
        if origin.socket.is_output and origin.node.bl_idname in SPECTRUM_NODES:
            if self.depth >= DEEPEST_MIX:
                raise core.SceneError(f"{name} of {self.place(node)}: spectra are mixed in a cycle, or too deeply")
            self.depth += 1
            read = self.of_spectrum_node if origin.node.bl_idname == SPECTRUM_NODE else self.of_mix_node
            try:
                return read(origin.node, origin.groups)
            finally:
                self.depth -= 1
        return _own_value(origin.socket)

    def _chained(self, chain: ImageChain, node: Any, name: str, channel: str) -> core.ImageTexture:
        try:
            return chain.texture(self, node, name, channel)
        except core.InvalidParameterError as error:
            raise core.SceneError(f"{name} of {self.place(node)}: {error}") from error

    def _texture(self, node: Any, name: str, origin: Origin, channel: str) -> core.ImageTexture:
        try:
            texture, coordinates = read_texture(origin, channel, self.pictures)
        except core.DichromaticError as error:
            raise core.SceneError(f"{name} of {self.place(node)}: {error}") from error
        self.place_image(node, name, origin, coordinates)
        return texture

    def place_image(self, node: Any, name: str, origin: Origin, coordinates: Coordinates) -> None:
        """Remember what an image is placed by, and what of its node was approximated.

        Raises
        ------
        SceneError
            If another image of the material is placed by something else.
        """
        if self.coordinates not in (None, coordinates):
            raise core.SceneError(
                f"{name} of {self.place(node)}: the images of one material must use the same UV map, and the same "
                "mapping where they use other coordinates"
            )
        self.coordinates = coordinates
        note = interpolation_note(origin.node)
        if note and note not in self.notes:
            self.notes.append(note)

    def of_spectrum_node(self, node: Any, groups: tuple[Any, ...] = ()) -> Reflectance:
        """Read the spectrum of a Spectrum node, with what is linked to its inputs.

        Raises
        ------
        SceneError
            If its source is invalid; the message names the node and the reason.
        """
        try:
            scale = self.number(node, "Scale", groups)
            if node.source == "COLOR":
                spectrum = self.reflectance(node, "Color", groups)
                return spectrum if scale == 1.0 else spectrum.scaled(scale)
            return spectrum_of_node(node, scale)
        except core.DichromaticError as error:
            raise core.SceneError(f"Spectrum of {self.place(node)}: {error}") from error

    def of_mix_node(self, node: Any, groups: tuple[Any, ...] = ()) -> Reflectance:
        """Read what a Mix Spectra node makes; its factor may be an image, and then both spectra are plain.

        Raises
        ------
        SceneError
            If one of its inputs cannot be read; the message names the node, the input and the reason.
        """
        first, second = self.reflectance(node, "A", groups), self.reflectance(node, "B", groups)
        name = node.draw_label()
        try:
            factor = self._factor(node, groups)
            if node.operation == "MULTIPLY":
                return _multiplied(first, second, factor, name)
            return _mixed(first, second, factor, name)
        except core.InvalidParameterError as error:
            raise core.SceneError(f"{self.place(node)}: {error}") from error

    def _factor(self, node: Any, groups: tuple[Any, ...]) -> float | core.ImageTexture:
        origin = self._origin(node, "Factor", groups)
        problem = self.mask_problem(origin)
        if origin is None or problem:
            raise core.SceneError(f"Factor of {self.place(node)}: {problem}")
        if is_chained(origin):
            chain = ImageChain(origin)
            return self._chained(chain, node, "Factor", "mask") if chain.has_image else chain.number()
        if origin.is_unlinked or origin.node.bl_idname != IMAGE_NODE:
            return self.number(node, "Factor", groups)
        return self._texture(node, "Factor", origin, "alpha" if origin.socket.name == "Alpha" else "mask")

    def number_problem(self, origin: Origin | None) -> str:
        """Say why an origin gives no number; an empty string when it does."""
        if origin is None:
            return "the chain of links leads to nothing"
        if origin.is_unlinked or origin.node.bl_idname == "ShaderNodeValue":
            return "" if origin.socket.type in ("VALUE", "INT") else "a number is needed, not a colour"
        return f"linked to '{origin.node.name}', which is no constant number; link a Value node or set it here"

    def spectrum_problem(self, origin: Origin | None) -> str:
        """Say why an origin gives no spectrum; an empty string when it does."""
        if origin is None:
            return "the chain of links leads to nothing"
        if origin.is_unlinked or origin.node.bl_idname in ("ShaderNodeRGB", "ShaderNodeValue"):
            return "" if origin.socket.type in ("RGBA", "VALUE") else "a spectrum, a colour or a value is needed"
        if origin.node.bl_idname in SPECTRUM_NODES:
            return ""
        if origin.node.bl_idname == IMAGE_NODE:
            if origin.socket.type != "RGBA":
                return f"linked to {origin.socket.name} of '{origin.node.name}', which is a number; link its Color"
            return texture_problem(origin)
        if is_chained(origin):
            return _chain_problem(origin)
        return f"linked to '{origin.node.name}', which gives no spectrum; link a Spectrum, Image Texture, RGB or Value"

    def mask_problem(self, origin: Origin | None) -> str:
        """Say why an origin gives neither a number nor a mask; an empty string when it does."""
        if origin is not None and not origin.is_unlinked and origin.node.bl_idname == IMAGE_NODE:
            return texture_problem(origin)
        if origin is not None and is_chained(origin):
            return _chain_problem(origin)
        return self.number_problem(origin)

    def _origin(self, node: Any, name: str, groups: tuple[Any, ...]) -> Origin | None:
        socket = node.inputs.get(name)
        if socket is None:
            raise core.SceneError(
                f"{self.place(node)} has no input '{name}'; its hidden node group is missing or changed"
            )
        return origin_of(socket, groups)


def _chain_problem(origin: Origin) -> str:
    problem = ImageChain(origin).problem
    return f"linked to '{origin.node.name}', {problem}" if problem else ""


def _own_value(socket: Any) -> core.Spectrum:
    value = socket.default_value
    if socket.type == "RGBA":
        return uplifted(value)
    return core.Spectrum.constant(float(value), name="constant")


def _samples(spectra: tuple[core.Spectrum, ...]) -> Any:
    """Wavelengths of all, and every nm from 360 to 830 nm; a row of values for each."""
    if all(spectrum.is_constant for spectrum in spectra):
        wavelengths = spectra[0].wavelengths_nm[:1]
    else:
        wavelengths = np.unique(np.concatenate([core.REFERENCE_WAVELENGTHS_NM, *(s.wavelengths_nm for s in spectra)]))
    # Lagrange's formula may pass a little below zero between samples.
    return wavelengths, [np.maximum(spectrum.at(wavelengths), 0.0) for spectrum in spectra]


def _mixed(first: Reflectance, second: Reflectance, factor: float | core.ImageTexture, name: str) -> Reflectance:
    if not isinstance(factor, float) or not (isinstance(first, core.Spectrum) and isinstance(second, core.Spectrum)):
        return core.mixture(first, second, factor, name)
    wavelengths, (a, b) = _samples((first, second))
    return core.Spectrum(wavelengths, (1.0 - factor) * a + factor * b, name=name)


def _multiplied(first: Reflectance, second: Reflectance, factor: float | core.ImageTexture, name: str) -> Reflectance:
    """The first, with the second as a filter of the strength `factor` before it."""
    if isinstance(first, core.TexturedReflectance) and isinstance(second, core.TexturedReflectance):
        raise core.InvalidParameterError("an image cannot be multiplied by another; mix them instead")
    if isinstance(second, core.TexturedReflectance):
        return core.mixture(first, core.filtered(second, core.require_plain("A", first)), factor, name)
    if not isinstance(first, core.TexturedReflectance):
        wavelengths, (a, b) = _samples((first, second))
        return _mixed(first, core.Spectrum(wavelengths, a * b, name=f"{first.name} x {second.name}"), factor, name)
    if isinstance(factor, core.ImageTexture):
        raise core.InvalidParameterError(f"the mask '{factor.name}' must act on plain spectra, but A is an image")
    wavelengths, (b,) = _samples((second,))
    return core.filtered(first, core.Spectrum(wavelengths, 1.0 - factor + factor * b, second.name), name)
