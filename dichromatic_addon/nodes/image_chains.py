"""Images behind Blender's colour nodes: the nodes are worked out for every pixel, and the result is the texture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core import core
from ..image_reading import from_working, working_pixels
from .colour_chains import ColourChains
from .colour_operations import OPERATIONS
from .images import IMAGE_NODE, Layout, layout_of, texture_problem
from .links import Origin

if TYPE_CHECKING:
    from .inputs import InputReader

__all__ = ["ImageChain", "is_chained"]

_PIXELS_AT_ONCE = 1 << 18
_LARGEST = 1.0e6  # of a pixel, as the core has it
_EXACT = (OPERATIONS.keys() | {IMAGE_NODE}) - {"ShaderNodeFresnel", "ShaderNodeLayerWeight"}


def is_chained(origin: Origin) -> bool:
    """Whether an output is that of a colour node, to be worked out."""
    return bool(origin.socket.is_output and origin.node.bl_idname in OPERATIONS)


class ImageChain:
    """What leads to an input through colour nodes: images, as far as they go together, or a constant.

    Images that go together have the same size and lie on surfaces alike; of others the mean is taken.

    Parameters
    ----------
    origin : Origin
        The output at the end of the chain.
    """

    def __init__(self, origin: Origin) -> None:
        self._origin = origin
        self._images: dict[tuple[int, ...], Origin] = {}
        self._layout: Layout | None = None
        self._size: tuple[int, ...] = ()
        self._problem = ""
        self.notes: list[str] = []
        self._survey = ColourChains(pixels=self._meet)
        self._survey.samples(origin)

    @property
    def has_image(self) -> bool:
        """Whether there is an image that can be rendered."""
        return bool(self._images)

    @property
    def problem(self) -> str:
        """Why the chain can be followed by approximation only; empty when it is exact."""
        other = next((node for node in self._survey.met if node.bl_idname not in _EXACT), None)
        if other is not None:
            return f"behind which '{other.name}' gives neither an image nor a constant color"
        return self._problem or "".join(self._survey.notes[:1])

    def _meet(self, origin: Origin) -> NDArray[np.float64]:
        """Take an image in if it goes with the first, and give one white sample for the survey."""
        problem = texture_problem(origin)
        if problem:
            problem = f"behind which something is {problem}"
        else:
            layout, size = layout_of(origin), tuple(origin.node.image.size)
            if self._layout is None:
                self._layout, self._size = layout, size
            if (layout, size) == (self._layout, self._size):
                self._images[_key(origin)] = origin
            else:
                problem = f"behind which the image of '{origin.node.name}' has another size or place than the first"
        self._problem = self._problem or problem
        return np.ones((1, 4))

    def colour(self) -> tuple[float, float, float]:
        """Give the scene linear colour of a chain without images."""
        red, green, blue = self._survey.samples(self._origin).reshape(-1, 3).mean(axis=0).tolist()
        return red, green, blue

    def number(self) -> float:
        """Give the number of a chain without images, 0 to 1."""
        return float(np.clip(self._survey.samples(self._origin, 1).mean(), 0.0, 1.0))

    def texture(self, reader: InputReader, node: Any, name: str, channel: str = "colour") -> core.ImageTexture:
        """Work the nodes out for every pixel; `notes` then has what was approximated.

        Parameters
        ----------
        reader : InputReader
            Says how fresh pixels must be, and remembers what they are placed by.
        node : bpy.types.Node
            The node at the end, for messages.
        name : str
            Its input.
        channel : str
            "colour" for linear Rec.709, or "mask" for a number of 0 to 1.

        Returns
        -------
        ImageTexture
            Three channels or one.

        Raises
        ------
        SceneError
            If an image has no pixels, or another of the material is placed by something else.
        """
        assert self._layout is not None
        pixels = {}
        for key, image in self._images.items():
            straight = image.node.outputs["Alpha"].is_linked
            pixels[key] = working_pixels(image.node.image, straight=straight, pictures=reader.pictures)
            reader.place_image(node, name, image, self._layout.coordinates)
        height, width = next(iter(pixels.values())).shape[:2]
        flat = {key: array.reshape(-1, 4) for key, array in pixels.items()}
        count = 3 if channel == "colour" else 1
        result = np.empty((height * width, count), np.float32)
        for start in range(0, len(result), _PIXELS_AT_ONCE):
            part = slice(start, start + _PIXELS_AT_ONCE)
            chains = ColourChains(pixels=lambda met, part=part: _block(flat, met, part))  # type: ignore[misc]
            result[part] = np.clip(chains.samples(self._origin, count), -_LARGEST, _LARGEST)
            self.notes = chains.notes
        shown = np.minimum(from_working(result), _LARGEST) if channel == "colour" else np.clip(result, 0.0, 1.0)
        return core.ImageTexture(
            shown.reshape(height, width, count),
            self._layout.extension,
            self._layout.interpolation,
            np.array(self._layout.transform),
            " + ".join(dict.fromkeys(image.node.image.name for image in self._images.values())),
        )


def _key(origin: Origin) -> tuple[int, ...]:
    return (origin.node.as_pointer(), *(group.as_pointer() for group in origin.groups))


def _block(flat: dict[tuple[int, ...], NDArray[np.float32]], origin: Origin, part: slice) -> NDArray[np.float64] | None:
    pixels = flat.get(_key(origin))
    return None if pixels is None else pixels[part].astype(np.float64)
