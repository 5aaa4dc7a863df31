"""Reading and writing pictures through OpenImageIO, which is imported only here and only when a file is touched.

Every file is written to a temporary name in the same folder and moved into place, so that a failure leaves neither a
half-written file nor a damaged old one.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .atomic_files import replacing
from .errors import DichromaticError, InvalidParameterError, MissingDependencyError

__all__ = ["IMAGE_SUFFIXES", "read_image", "write_image"]

IMAGE_SUFFIXES = (".png", ".exr")


def _openimageio() -> ModuleType:
    try:
        import OpenImageIO
    except ImportError:
        # Blender's own Python carries OpenImageIO in a folder that is not on the path when bpy is used as a module.
        bpy = sys.modules.get("bpy")
        if bpy is not None:
            found = sorted(Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/python3*/site-packages/OpenImageIO"))
            if found:
                sys.path.append(str(found[-1].parent))
        try:
            import OpenImageIO
        except ImportError as error:
            raise MissingDependencyError(
                "pictures are read and written with OpenImageIO, which is not installed: pip install OpenImageIO"
            ) from error
    module: ModuleType = OpenImageIO
    return module


def write_image(
    path: str | os.PathLike[str],
    pixels: NDArray[np.floating[Any]],
    *,
    channels: Sequence[str] | None = None,
    metadata: Mapping[str, str | float | int] | None = None,
    dither_seed: int | None = None,
) -> None:
    """Write a picture: PNG with 8 bits a channel, or EXR in float32.

    Parameters
    ----------
    path : path-like
        Ends in ".png" or ".exr".
    pixels : ndarray, shape (H, W, C)
        Row 0 is the top. PNG: display values, encoded, 0 to 1 (values outside are clipped); EXR: linear light.
    channels : sequence of str, length C, optional
        Channel names; "R", "G", "B" (and "A") when left out.
    metadata : mapping, optional
        Attributes of the file's header.
    dither_seed : int, optional
        Seed of a dither of up to half a step that keeps dark gradients of a PNG from banding; plain rounding when left
        out.

    Raises
    ------
    InvalidParameterError
        If the suffix or the shape does not fit.
    MissingDependencyError
        If OpenImageIO is not installed.
    DichromaticError
        If the file cannot be written; nothing is left behind.

    References
    ----------
    Own design.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in IMAGE_SUFFIXES:
        raise InvalidParameterError(f"an image file must end in {' or '.join(IMAGE_SUFFIXES)}, but is {target.name}")
    if pixels.ndim != 3 or 0 in pixels.shape:
        raise InvalidParameterError(f"pixels must have the shape (H, W, C) without a zero, but have {pixels.shape}")
    if channels is None:
        channels = ("R", "G", "B", "A")[: pixels.shape[2]]
    if len(channels) != pixels.shape[2]:
        raise InvalidParameterError(f"{pixels.shape[2]} channels need as many names, but {len(channels)} were given")
    oiio = _openimageio()
    height, width, count = pixels.shape
    if suffix == ".png":
        data: NDArray[np.generic] = quantise(pixels, dither_seed)
        spec = oiio.ImageSpec(width, height, count, oiio.UINT8)
    else:
        data = np.ascontiguousarray(pixels, dtype=np.float32)
        spec = oiio.ImageSpec(width, height, count, oiio.FLOAT)
        spec.attribute("compression", "zip")
    spec.channelnames = tuple(channels)
    for name, value in (metadata or {}).items():
        spec.attribute(name, value)
    _write(oiio, target, spec, data)


def quantise(pixels: NDArray[np.floating[Any]], dither_seed: int | None) -> NDArray[np.uint8]:
    """Round display values 0 to 1 to 8 bits, with half a step of triangular dither if a seed is given."""
    scaled = np.clip(np.asarray(pixels, np.float32), 0, 1) * np.float32(255)
    if dither_seed is not None:
        generator = np.random.default_rng(dither_seed)
        noise = generator.random(scaled.shape, np.float32) - generator.random(scaled.shape, np.float32)
        # pure black and white stay exact, so that a flat background does not sparkle
        scaled = np.where((scaled > 0) & (scaled < 255), scaled + np.float32(0.5) * noise, scaled)
    result: NDArray[np.uint8] = np.clip(np.rint(scaled), 0, 255).astype(np.uint8)
    return result


def _write(oiio: ModuleType, target: Path, spec: object, data: NDArray[np.generic]) -> None:
    with replacing(target) as temporary:
        output = oiio.ImageOutput.create(str(temporary))
        if output is None:
            raise DichromaticError(f"{target} cannot be written: {oiio.geterror()}")
        try:
            if not output.open(str(temporary), spec) or not output.write_image(data):
                raise DichromaticError(f"{target} cannot be written: {output.geterror()}")
        finally:
            output.close()


def read_image(path: str | os.PathLike[str]) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Read a picture as float32.

    Parameters
    ----------
    path : path-like
        Any file that OpenImageIO reads.

    Returns
    -------
    pixels : ndarray of float32, shape (H, W, C)
        Row 0 is the top; integer formats are scaled to 0 to 1, and stay encoded.
    channels : tuple of str, length C
        Channel names.

    Raises
    ------
    MissingDependencyError
        If OpenImageIO is not installed.
    DichromaticError
        If the file cannot be read.

    References
    ----------
    Own design.
    """
    oiio = _openimageio()
    source = oiio.ImageInput.open(os.fspath(path))
    if source is None:
        raise DichromaticError(f"{path} cannot be read: {oiio.geterror()}")
    try:
        spec = source.spec()
        pixels = source.read_image(oiio.FLOAT)
        if pixels is None:
            raise DichromaticError(f"{path} cannot be read: {source.geterror()}")
        shape = (spec.height, spec.width, spec.nchannels)
        return np.asarray(pixels, np.float32).reshape(shape), tuple(spec.channelnames)
    finally:
        source.close()
