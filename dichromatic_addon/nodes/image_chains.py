"""Images behind Blender's colour nodes: the nodes are worked out for every pixel, and the result is the texture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import core
from ..image_reading import from_working, working_pixels
from .colour_chains import ColourChains
from .images import Layout, layout_of, texture_problem
from .inputs import InputReader
from .links import Origin

__all__ = ["ImageChain"]

_PIXELS_AT_ONCE = 1 << 18
_LARGEST = 1.0e6  # of a pixel, as the core has it


class ImageChain:
    """What leads to a colour input, as far as images have to do with it.

    The images that are met must have the same size and lie on the surface alike; of others the mean is taken.

    Parameters
    ----------
    node : bpy.types.Node
        A shader.
    name : str
        One of its colour inputs.
    groups : tuple of bpy.types.Node
        The group nodes around it.
    """

    def __init__(self, node: Any, name: str, groups: tuple[Any, ...]) -> None:
        self._node, self._name, self._groups = node, name, groups
        self._origins: dict[tuple[int, ...], Origin] = {}
        self._layout: Layout | None = None
        self._size: tuple[int, ...] = ()
        self.notes: list[str] = []
        survey = ColourChains(pixels=self._meet)
        survey.samples(node.inputs[name], groups)

    @property
    def has_image(self) -> bool:
        """Whether there is an image that can be rendered."""
        return bool(self._origins)

    def _meet(self, origin: Origin) -> NDArray[np.float64] | None:
        """Take an image in if it goes with the first, and give one white sample for the survey."""
        if texture_problem(origin):
            return None
        layout, size = layout_of(origin), tuple(origin.node.image.size)
        if self._layout is None:
            self._layout, self._size = layout, size
        if (layout, size) != (self._layout, self._size):
            return None
        self._origins[_key(origin)] = origin
        return np.ones((1, 4))

    def reflectance(self, reader: InputReader) -> core.TexturedReflectance:
        """Work the nodes out for every pixel.

        Parameters
        ----------
        reader : InputReader
            Says how fresh pixels must be, and remembers what they are placed by.

        Returns
        -------
        TexturedReflectance
            The uplifted colours.

        Raises
        ------
        SceneError
            If an image has no pixels, or another of the material is placed by something else.
        """
        assert self._layout is not None
        pixels = {}
        for key, origin in self._origins.items():
            straight = origin.node.outputs["Alpha"].is_linked
            pixels[key] = working_pixels(origin.node.image, straight=straight, pictures=reader.pictures)
            reader.place_image(self._node, self._name, origin, self._layout.coordinates)
        height, width = next(iter(pixels.values())).shape[:2]
        flat = {key: array.reshape(-1, 4) for key, array in pixels.items()}
        result = np.empty((height * width, 3), np.float32)
        for start in range(0, len(result), _PIXELS_AT_ONCE):
            part = slice(start, start + _PIXELS_AT_ONCE)
            chains = ColourChains(pixels=lambda origin, part=part: _block(flat, origin, part))  # type: ignore[misc]
            result[part] = np.clip(chains.samples(self._node.inputs[self._name], self._groups), -_LARGEST, _LARGEST)
            self.notes = chains.notes
        texture = core.ImageTexture(
            np.minimum(from_working(result), _LARGEST).reshape(height, width, 3),
            self._layout.extension,
            self._layout.interpolation,
            np.array(self._layout.transform),
            " + ".join(dict.fromkeys(origin.node.image.name for origin in self._origins.values())),
        )
        return core.uplift_texture(texture)


def _key(origin: Origin) -> tuple[int, ...]:
    return (origin.node.as_pointer(), *(group.as_pointer() for group in origin.groups))


def _block(flat: dict[tuple[int, ...], NDArray[np.float32]], origin: Origin, part: slice) -> NDArray[np.float64] | None:
    pixels = flat.get(_key(origin))
    return None if pixels is None else pixels[part].astype(np.float64)
