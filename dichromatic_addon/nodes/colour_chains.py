"""Colours and numbers of shaders that are not ours: chains of Blender's nodes are followed, and varying ones averaged.

A pattern such as noise has no place in our materials. It is followed as a distribution of values, through ramps and
curves to the end of the chain, and the mean of what arrives is taken; a note says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import NormalDist
from typing import Any

import numpy as np

from .._core import core
from ..image_reading import image_problem, mean_color
from ..names import SPECTRUM_NODE, SPECTRUM_NODES
from ..spectrum_sources import working_luminance
from .colour_operations import OPERATIONS, Values
from .images import IMAGE_NODE
from .links import Origin, origin_of

__all__ = ["IMAGE_NODES", "ColourChains", "is_straight"]

IMAGE_NODES = (IMAGE_NODE, "ShaderNodeTexEnvironment")

DEEPEST = 200  # nodes in a row; more is taken for a cycle
QUANTILES = 64  # samples of a pattern's distribution

_SHARES = (np.arange(QUANTILES) + 0.5) / QUANTILES


def _bell(mean: float, deviation: float) -> Values:
    normal = NormalDist(mean, deviation)
    return np.clip([[normal.inv_cdf(share)] for share in _SHARES], 0.0, 1.0)


_UNIFORM: Values = _SHARES[:, None]
_WAVE: Values = 0.5 - 0.5 * np.cos(np.pi * _UNIFORM)
_PATTERNS: dict[str, Values] = {  # means and deviations as Cycles 4.5 renders the textures with their default settings
    "ShaderNodeTexNoise": _bell(0.5, 0.08),
    "ShaderNodeTexMusgrave": _bell(0.5, 0.08),
    "ShaderNodeTexGabor": _bell(0.5, 0.11),
    "ShaderNodeTexVoronoi": _bell(0.53, 0.18),
    "ShaderNodeTexMagic": _bell(0.5, 0.21),
    "ShaderNodeTexWave": _WAVE,
    "ShaderNodeTexGradient": _UNIFORM,
    "ShaderNodeTexWhiteNoise": _UNIFORM,
}
"""Values of a texture's factor over a large surface, in equal shares."""

_CONSTANT_OUTPUTS = {  # what a ray from the camera meets on the front of an ordinary surface
    ("ShaderNodeLightPath", "Is Camera Ray"): 1.0,
    ("ShaderNodeAmbientOcclusion", "AO"): 1.0,
    ("ShaderNodeNewGeometry", "Backfacing"): 0.0,
    ("ShaderNodeNewGeometry", "Pointiness"): 0.5,
    ("ShaderNodeObjectInfo", "Color"): 1.0,
    ("ShaderNodeObjectInfo", "Alpha"): 1.0,
}


@dataclass(slots=True)
class ColourChains:
    """Follows inputs of nodes of one material to constant colours and numbers.

    Attributes
    ----------
    notes : list of str
        What had to be approximated on the way, in the order in which it was met.
    met : list of bpy.types.Node
        The nodes that were worked out, but for constant ones.
    pixels : callable, optional
        ``pixels(origin)`` gives the samples (N, 4) of an image, all of the same N; patterns are then averaged before
        they meet them. Without it the mean of an image stands for it.
    """

    notes: list[str] = field(default_factory=list)
    met: list[Any] = field(default_factory=list)
    pixels: Callable[[Origin], Values | None] | None = None
    _depth: int = 0

    def colour(self, socket: Any, groups: tuple[Any, ...] = ()) -> tuple[float, float, float]:
        """Return the scene linear colour of an input, or its mean over the surface.

        Parameters
        ----------
        socket : bpy.types.NodeSocket
            An input.
        groups : tuple of bpy.types.Node, optional
            The group nodes around it.

        Returns
        -------
        tuple of float
            Red, green, blue.

        Raises
        ------
        SceneError
            If the links form a cycle.
        """
        values = self.values(socket, groups)
        red, green, blue = np.nan_to_num(values.mean(axis=0), posinf=0.0, neginf=0.0).tolist()
        return red, green, blue

    def values(self, socket: Any, groups: tuple[Any, ...] = ()) -> Values:
        """Return the scene linear colours of an input, for each sample of an image or of what varies.

        Parameters
        ----------
        socket : bpy.types.NodeSocket
            An input.
        groups : tuple of bpy.types.Node, optional
            The group nodes around it.

        Returns
        -------
        ndarray of float64, shape (P, 3)
            Red, green, blue.

        Raises
        ------
        SceneError
            If the links form a cycle.
        """
        return _channels(self._input(socket, groups), socket.type, 3).reshape(-1, 3)

    def number(self, socket: Any, groups: tuple[Any, ...] = ()) -> float:
        """Return the number of an input, or its mean over the surface.

        Parameters
        ----------
        socket : bpy.types.NodeSocket
            An input.
        groups : tuple of bpy.types.Node, optional
            The group nodes around it.

        Returns
        -------
        float
            The number.

        Raises
        ------
        SceneError
            If the links form a cycle.
        """
        return float(np.nan_to_num(_channels(self._input(socket, groups), socket.type, 1)).mean())

    def samples(self, origin: Origin, count: int = 3) -> Values:
        """Return what an output gives for every pixel of its images (N, count), or the one value (count,).

        Parameters
        ----------
        origin : Origin
            An output.
        count : int
            3 for scene linear colours, 1 for numbers.

        Returns
        -------
        ndarray
            The values.

        Raises
        ------
        SceneError
            If the links form a cycle.
        """
        return np.nan_to_num(_channels(self._output(origin), origin.socket.type, count), posinf=0.0, neginf=0.0)

    def note(self, text: str) -> None:
        """Remember an approximation once."""
        if text not in self.notes:
            self.notes.append(text)

    def _input(self, socket: Any, groups: tuple[Any, ...]) -> Values:
        """Return the values of an input in the channels of its own type."""
        origin = origin_of(socket, groups)
        if origin is None:
            return _default(socket)
        if origin.is_unlinked:
            return _converted(_default(origin.socket), origin.socket.type, socket.type)
        return _converted(self._output(origin), origin.socket.type, socket.type)

    def _output(self, origin: Origin) -> Values:
        node, groups, output = origin.node, origin.groups, origin.socket
        if node.bl_idname in ("ShaderNodeRGB", "ShaderNodeValue"):
            return _default(output)
        if self._depth >= DEEPEST:
            raise core.SceneError(f"the links that lead to node '{node.name}' form a cycle")
        self._depth += 1
        try:
            found = self._of_node(node, groups, output)
        finally:
            self._depth -= 1
        if found is not None:
            return found
        self.note(f"'{node.name}' is not understood; a middle value stands for it")
        return np.full(_count(output.type), 0.5)

    def _of_node(self, node: Any, groups: tuple[Any, ...], output: Any) -> Values | None:
        def inputs(key: str | int) -> Values:
            if isinstance(key, int):
                return self._input(node.inputs[key], groups)
            return self._input(next(socket for socket in node.inputs if socket.identifier == key), groups)

        kind = node.bl_idname
        self.met.append(node)
        if kind in OPERATIONS:
            return OPERATIONS[kind](node, inputs, output)
        if kind in SPECTRUM_NODES:
            self.note(f"the spectrum of '{node.name}' was taken for its colour")
            return self._of_spectrum(node, groups)
        constant = _CONSTANT_OUTPUTS.get((kind, output.name), 0.0 if kind == "ShaderNodeLightPath" else None)
        if constant is not None:
            return np.full(_count(output.type), constant)
        if kind == "ShaderNodeAmbientOcclusion":
            return inputs("Color")
        if kind in IMAGE_NODES:
            return self._of_image(Origin(output, groups))
        if kind == "ShaderNodeTexIES":
            self.note(f"the distribution of '{node.name}' is not rendered: it shines evenly")
            return inputs("Strength")
        if kind == "ShaderNodeLightFalloff":
            if output.name != "Quadratic":
                self.note(f"light of '{node.name}' falls off with the square of the distance")
            return inputs("Strength")
        found: Values | None = None
        if kind == "ShaderNodeTexChecker":
            found = _alternating(inputs("Color1"), inputs("Color2"), 0.5, output)
        elif kind == "ShaderNodeTexBrick":
            mortar = _mortar_share(float(inputs("Mortar Size").mean()), node, inputs)
            bricks = np.concatenate([inputs("Color1"), inputs("Color2")]).reshape(-1, 3)
            found = _alternating(bricks.mean(axis=0), inputs("Mortar"), mortar, output)
        elif kind in _PATTERNS:
            found = _PATTERNS[kind] if _count(output.type) == 1 else np.repeat(_PATTERNS[kind], 3, axis=1)
        if found is not None:
            self.note(f"the pattern of '{node.name}' is not rendered: the mean of its colors or values is used")
            if self.pixels is not None and found.ndim > 1:
                return found.mean(axis=0)
        return found

    def _of_image(self, origin: Origin) -> Values | None:
        node, output = origin.node, origin.socket
        values = None if self.pixels is None else self.pixels(origin)
        if values is None and image_problem(node.image):
            return None
        if values is None:
            self.note(f"the image of '{node.name}' is not rendered here: its mean is used")
            values = mean_color(node.image, straight=is_straight(node))
        return values[..., 3:] if output.name == "Alpha" else values[..., :3]

    def _of_spectrum(self, node: Any, groups: tuple[Any, ...]) -> Values:
        """Return the RGB that the node itself shows to other engines."""
        if node.bl_idname != SPECTRUM_NODE:
            factor, a, b = (self._input(node.inputs[name], groups) for name in ("Factor", "A", "B"))
            return (1.0 - factor) * a + factor * (a * b if node.operation == "MULTIPLY" else b)
        name = "Color" if node.source == "COLOR" else "RGB"
        return self._input(node.inputs[name], groups) * self._input(node.inputs["Scale"], groups)


def is_straight(node: Any) -> bool:
    """Whether an image node gives colours as they are behind the alpha, since its Alpha output is used."""
    alpha = node.outputs.get("Alpha")
    return alpha is not None and bool(alpha.is_linked)


def _mortar_share(size: float, node: Any, inputs: Any) -> float:
    """Return the part of a brick texture that is mortar, which runs along all four sides of each brick."""
    width, height = float(inputs("Brick Width").mean()), float(inputs("Row Height").mean())
    bare = max(width - 2.0 * size, 0.0) * max(height - 2.0 * size, 0.0)
    return 1.0 - bare / max(width * height, 1e-12)


def _alternating(first: Values, second: Values, share: float, output: Any) -> Values:
    """Return samples of two colours, or of the factors 0 and 1, of which the second takes a share of the surface."""
    is_second = (1.0 - share <= _UNIFORM).astype(np.float64)
    if _count(output.type) == 1:
        return is_second
    mean = [np.asarray(colour).reshape(-1, 3).mean(axis=0) for colour in (first, second)]
    return (1.0 - is_second) * mean[0] + is_second * mean[1]


def _count(socket_type: str) -> int:
    return 1 if socket_type in ("VALUE", "INT", "BOOLEAN") else 3


def _default(socket: Any) -> Values:
    value: Any = getattr(socket, "default_value", 0.0)
    return np.array(tuple(value)[:3] if hasattr(value, "__len__") else (value,), np.float64)


def _converted(values: Values, source_type: str, target_type: str) -> Values:
    return _channels(values, source_type, _count(target_type))


def _channels(values: Values, source_type: str, count: int) -> Values:
    """Convert between numbers, colours and vectors as Blender's links do."""
    if values.shape[-1] == count:
        return values
    if count == 3:
        return np.repeat(values, 3, axis=-1)
    return working_luminance(values)[..., None] if source_type == "RGBA" else values.mean(axis=-1, keepdims=True)
