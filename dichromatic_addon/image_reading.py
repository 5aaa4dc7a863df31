"""From Blender's images to textures of the core: their own pixels, in linear Rec.709, with alpha as Cycles has it.

Blender keeps images of 8 bits encoded in the image's colour space and not multiplied by their alpha, and all others
linear in the working space and multiplied. Here all is done between linear values, as in EEVEE; Cycles interpolates
8-bit images between encoded values, and multiplies the encoded values of files with straight alpha.
"""

from __future__ import annotations

import hashlib
import os
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ._core import core
from .spectrum_sources import rec709_to_working, working_to_rec709

__all__ = [
    "CHANNELS",
    "PICTURES",
    "environment_pixels",
    "forget",
    "from_working",
    "image_problem",
    "mean_color",
    "texture_of",
    "uplifted_texture",
    "working_pixels",
]

CHANNELS = ("colour", "mask", "alpha")
"""Three channels of colour, their luminance as a mask, or the alpha as one."""

PICTURES = ("read", "kept", "none")
"""How fresh pixels must be: read now; as read before, unless the image was painted on, packed or saved since; or plain
white instead."""

_ENCODED = {"sRGB": "srgb", "Display P3": "display_p3"}  # colour spaces of 8-bit images with a transfer curve
_LINEAR = {"Linear Rec.709": "srgb", "Linear Rec.2020": "rec2020"}
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)  # what Blender takes where a colour meets a number
_ALPHA_IGNORED = ("NONE", "CHANNEL_PACKED")
_NOT_READ = {
    "SEQUENCE": "is an image sequence",
    "MOVIE": "is a movie",
    "TILED": "is a set of UDIM tiles",
    "VIEWER": "is a render result",
}
_DIGITS_OF_MATRICES = 1e-4  # Blender's conversion from Rec.709 to Rec.709 is no identity but for five digits
_LARGEST_CACHE = 16  # textures

_textures: dict[tuple[Any, ...], core.ImageTexture] = {}
_reflectances: dict[core.ImageTexture, core.TexturedReflectance] = {}
_environments: dict[tuple[Any, ...], NDArray[np.float32]] = {}  # the last one
_digests: dict[tuple[Any, ...], bytes] = {}  # of the pixels that were read last, by image and settings


def forget() -> None:
    """Drop what was read, with the file it came from."""
    _textures.clear()
    _reflectances.clear()
    _environments.clear()
    _digests.clear()


def image_problem(image: Any) -> str:
    """Say why an image cannot be read; an empty string when it can.

    Parameters
    ----------
    image : bpy.types.Image or None
        What an Image Texture node has chosen.

    Returns
    -------
    str
        The reason, to follow "linked to 'Image Texture', ".
    """
    if image is None:
        return "which has no image yet; open one"
    if image.source in _NOT_READ:
        return f"whose image '{image.name}' {_NOT_READ[image.source]}, which is not read; use a single image"
    if not image.is_float and not _is_data(image) and image.colorspace_settings.name not in {**_ENCODED, **_LINEAR}:
        known = ", ".join((*_ENCODED, *_LINEAR, "Non-Color"))
        return (
            f"whose 8-bit image '{image.name}' is in the color space {image.colorspace_settings.name}, "
            f"which is not understood; use {known}"
        )
    return ""


def texture_of(
    image: Any, channel: str, extension: str, interpolation: str, transform: Any, *, straight: bool, pictures: str
) -> core.ImageTexture:
    """Make a texture of an image.

    Parameters
    ----------
    image : bpy.types.Image
        One without an :func:`image_problem`.
    channel : str
        One of :data:`CHANNELS`.
    extension, interpolation, transform
        As for ``ImageTexture``.
    straight : bool
        Whether colours are wanted as they are behind the alpha; else they are multiplied by it, as Cycles does while
        nothing is linked to the Alpha output.
    pictures : str
        One of :data:`PICTURES`.

    Returns
    -------
    ImageTexture
        The same object for the same pixels and settings.

    Raises
    ------
    SceneError
        If the image has no pixels.
    InvalidParameterError
        If a pixel is not finite or too large.
    """
    placed = (extension, interpolation, np.asarray(transform, np.float64).tobytes())
    if pictures == "none":
        count = 3 if channel == "colour" else 1
        return core.ImageTexture(np.ones((1, 1, count), np.float32), extension, interpolation, transform, image.name)
    content, raw = _content(image, pictures)
    key = (content, channel, straight, placed)
    if key not in _textures:
        if raw is None:
            raw = _raw_pixels(image)
        pixels = _channel(image, raw, channel, straight)
        while len(_textures) >= _LARGEST_CACHE:
            _textures.pop(next(iter(_textures)))
        _textures[key] = core.ImageTexture(pixels, extension, interpolation, transform, image.name)
    return _textures[key]


def environment_pixels(image: Any, *, pictures: str) -> NDArray[np.float32]:
    """Give an image of all around as the core takes it.

    Parameters
    ----------
    image : bpy.types.Image
        One without an :func:`image_problem`.
    pictures : str
        One of :data:`PICTURES`.

    Returns
    -------
    ndarray of float32, shape (H, W, 3)
        Linear Rec.709, row 0 the zenith; read-only. The same array for the same pixels, as long as no other is asked
        for.

    Raises
    ------
    SceneError
        If the image has no pixels.
    """
    if pictures == "none":
        return np.ones((1, 1, 3), np.float32)
    content, raw = _content(image, pictures)
    if content not in _environments:
        colours = _channel(image, _raw_pixels(image) if raw is None else raw, "colour", straight=False)
        pixels = np.nan_to_num(colours[::-1], posinf=0.0, neginf=0.0)
        pixels.flags.writeable = False
        _environments.clear()  # they are large
        _environments[content] = pixels
    return _environments[content]


def _content(image: Any, pictures: str) -> tuple[tuple[Any, ...], NDArray[np.float32] | None]:
    """What tells an image's pixels from others, and the pixels as Blender keeps them if they had to be read for it."""
    settings = (
        image.name_full,
        tuple(image.size),
        image.is_float,
        image.colorspace_settings.name,
        image.alpha_mode,
        image.filepath,
        image.source,
        _stamp(image),
        working_to_rec709((1.0, 0.0, 0.0)),
    )
    digest = _digests.get(settings) if pictures == "kept" and not image.is_dirty else None
    if digest is not None:
        return (settings, digest), None
    raw = _raw_pixels(image)
    _digests[settings] = hashlib.sha1(raw.data, usedforsecurity=False).digest()
    return (settings, _digests[settings]), raw


def uplifted_texture(texture: core.ImageTexture) -> core.TexturedReflectance:
    """Uplift a texture, which looks at every pixel for the brightest, once."""
    if texture not in _reflectances:
        while len(_reflectances) >= _LARGEST_CACHE:
            _reflectances.pop(next(iter(_reflectances)))
        _reflectances[texture] = core.uplift_texture(texture)
    return _reflectances[texture]


def working_pixels(image: Any, *, straight: bool, pictures: str) -> NDArray[np.float32]:
    """Give an image as Blender's colour nodes see it: scene linear in the working space, and its alpha.

    Parameters
    ----------
    image : bpy.types.Image
        One without an :func:`image_problem`.
    straight : bool
        As for :func:`texture_of`.
    pictures : str
        "none" for one white pixel; else it is read.

    Returns
    -------
    ndarray of float32, shape (H, W, 4)
        Row 0 is the bottom.

    Raises
    ------
    SceneError
        If the image has no pixels.
    """
    if pictures == "none":
        return np.ones((1, 1, 4), np.float32)
    raw = _raw_pixels(image)
    alpha = _channel(image, raw, "alpha", straight)
    colours = _linear(image, raw, alpha if image.alpha_mode != "NONE" else np.ones_like(alpha), straight)
    if image.is_float or _is_data(image):
        return np.concatenate([colours, alpha], axis=2)
    matrix = np.array([rec709_to_working(axis) for axis in np.eye(3).tolist()], np.float32)
    return np.concatenate([_times(colours, matrix), alpha], axis=2)


def mean_color(image: Any, *, straight: bool) -> NDArray[np.float64]:
    """Average an image: red, green, blue of the working space and alpha; white where it has no pixels."""
    try:
        return working_pixels(image, straight=straight, pictures="read").mean(axis=(0, 1), dtype=np.float64)
    except core.SceneError:
        return np.ones(4)


def from_working(colours: NDArray[np.float32]) -> NDArray[np.float32]:
    """Convert colours (..., 3) of the working space to linear Rec.709, parts outside it cut off."""
    matrix = np.array([working_to_rec709(axis) for axis in np.eye(3).tolist()], np.float32)
    return np.maximum(_times(colours, matrix), 0.0)


def _times(colours: NDArray[np.float32], matrix: NDArray[np.float32]) -> NDArray[np.float32]:
    is_identity = np.abs(matrix - np.eye(3)).max() < _DIGITS_OF_MATRICES  # the working space is Rec.709
    return colours if is_identity else colours @ matrix


def _stamp(image: Any) -> tuple[int, ...]:
    """What changes when an image is packed again, or its file is written again."""
    if image.packed_file is not None:
        return (image.packed_file.size,)
    try:
        found = os.stat(bpy.path.abspath(image.filepath)) if image.filepath else None
    except OSError:
        return ()
    return () if found is None else (found.st_mtime_ns, found.st_size)


def _is_data(image: Any) -> bool:
    return bool(image.colorspace_settings.is_data)


def _raw_pixels(image: Any) -> NDArray[np.float32]:
    """Pixels (H, W, channels) as Blender keeps them, row 0 at the bottom."""
    width, height = image.size  # loads the file
    if not (width and height and image.channels):
        where = f": the file '{bpy.path.abspath(image.filepath)}' cannot be read" if image.filepath else ""
        raise core.SceneError(f"image '{image.name}' has no pixels{where}")
    raw = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(raw)
    return raw.reshape(height, width, image.channels)


def _channel(image: Any, raw: NDArray[np.float32], channel: str, straight: bool) -> NDArray[np.float32]:
    alpha = raw[..., 3:4] if raw.shape[2] == 4 and image.alpha_mode != "NONE" else np.ones_like(raw[..., :1])
    if channel == "alpha":
        return np.clip(alpha, 0.0, 1.0)
    linear = _linear(image, raw, alpha, straight)
    rec709 = from_working(linear) if image.is_float or _is_data(image) else np.maximum(linear, 0.0)
    return np.clip(rec709 @ _LUMINANCE, 0.0, 1.0)[..., None] if channel == "mask" else rec709


def _linear(image: Any, raw: NDArray[np.float32], alpha: NDArray[np.float32], straight: bool) -> NDArray[np.float32]:
    """Colours with what their alpha does to them: of 8-bit images in Rec.709, of others in the working space."""
    colours = raw[..., :3] if raw.shape[2] >= 3 else np.repeat(raw[..., :1], 3, axis=2)
    linear = colours if image.is_float or _is_data(image) else _decoded(image, colours)
    if image.alpha_mode in _ALPHA_IGNORED or _is_data(image):
        return linear
    if straight and image.is_float:
        return np.divide(linear, alpha, out=np.zeros_like(linear), where=alpha > 0.0)
    return linear if straight or image.is_float else linear * alpha


def _decoded(image: Any, colours: NDArray[np.float32]) -> NDArray[np.float32]:
    """Linear Rec.709 of the bytes of an image."""
    space = image.colorspace_settings.name
    steps = np.arange(256) / 255.0
    if space in _ENCODED:
        shown = core.display(_ENCODED[space])
        steps = shown.decode(np.repeat(steps[:, None], 3, axis=1))[:, 0]
    else:
        shown = core.display(_LINEAR[space])
    linear = steps.astype(np.float32)[np.rint(255.0 * colours).astype(np.uint8)]
    srgb = core.display("srgb")
    if shown == srgb:
        return linear
    return np.asarray(srgb.linear(shown.tristimulus(linear)), np.float32)
