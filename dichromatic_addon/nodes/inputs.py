"""What a node's inputs say: numbers and spectra, through links, with reasons where they cannot be had."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .._core import core
from ..names import SPECTRUM_NODE, SPECTRUM_NODES
from ..spectrum_sources import uplifted
from .evaluation import spectrum_of_node
from .links import Origin, origin_of

__all__ = ["InputReader"]


DEEPEST_MIX = 16  # mixtures of mixtures; more is taken for a cycle


@dataclass(slots=True)
class InputReader:
    """Reads inputs of nodes of one material.

    Attributes
    ----------
    material_name : str
        For the messages; empty to leave the material out of them.
    depth : int
        How deep in mixtures of mixtures the reading is.
    """

    material_name: str = ""
    depth: int = 0

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
        """Read a spectrum: of a Spectrum node, or uplifted from a colour, or constant.

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
            If the input is missing, linked to something that is no spectrum, or the spectrum itself is invalid.
        """
        origin = self._origin(node, name, groups)
        problem = self.spectrum_problem(origin)
        if origin is None or problem:
            raise core.SceneError(f"{name} of {self.place(node)}: {problem}")
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

    def of_spectrum_node(self, node: Any, groups: tuple[Any, ...] = ()) -> core.Spectrum:
        """Read the spectrum of a Spectrum node, with what is linked to its inputs.

        Raises
        ------
        SceneError
            If its source is invalid; the message names the node and the reason.
        """
        try:
            scale = self.number(node, "Scale", groups)
            if node.source == "COLOR":
                spectrum = self.spectrum(node, "Color", groups)
                return spectrum if scale == 1.0 else spectrum.scaled(scale)
            return spectrum_of_node(node, scale)
        except core.DichromaticError as error:
            raise core.SceneError(f"Spectrum of {self.place(node)}: {error}") from error

    def of_mix_node(self, node: Any, groups: tuple[Any, ...] = ()) -> core.Spectrum:
        """Read the spectrum that a Mix Spectra node makes, at the samples of both and every nm from 360 to 830 nm.

        Raises
        ------
        SceneError
            If one of its inputs cannot be read; the message names the node, the input and the reason.
        """
        factor = self.number(node, "Factor", groups)
        first, second = self.spectrum(node, "A", groups), self.spectrum(node, "B", groups)
        if first.is_constant and second.is_constant:
            wavelengths = first.wavelengths_nm[:1]
        else:
            ends = (core.REFERENCE_WAVELENGTHS_NM, first.wavelengths_nm, second.wavelengths_nm)
            wavelengths = np.unique(np.concatenate(ends))
        # Lagrange's formula may pass a little below zero between samples.
        a, b = np.maximum(first.at(wavelengths), 0.0), np.maximum(second.at(wavelengths), 0.0)
        if node.operation == "MULTIPLY":
            b = a * b
        return core.Spectrum(wavelengths, (1.0 - factor) * a + factor * b, name=node.draw_label())

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
        return f"linked to '{origin.node.name}', which gives no spectrum; link a Spectrum, RGB or Value node"

    def _origin(self, node: Any, name: str, groups: tuple[Any, ...]) -> Origin | None:
        socket = node.inputs.get(name)
        if socket is None:
            raise core.SceneError(
                f"{self.place(node)} has no input '{name}'; its hidden node group is missing or changed"
            )
        return origin_of(socket, groups)


def _own_value(socket: Any) -> core.Spectrum:
    value = socket.default_value
    if socket.type == "RGBA":
        return uplifted(value)
    return core.Spectrum.constant(float(value), name="constant")
