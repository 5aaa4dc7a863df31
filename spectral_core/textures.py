"""Images on surfaces: numbers that vary with a surface's texture coordinates, read between the pixels.

A texture knows no spectrum; what its channels are the amounts of is told by ``textured_reflectance``.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError
from .validation import require_choice, require_finite, require_in_range, require_shape

__all__ = ["EXTENSIONS", "INTERPOLATIONS", "ImageTexture"]

EXTENSIONS = ("repeat", "extend", "clip", "mirror")
"""What lies beyond the picture: itself again, its edge pixels, nothing (0), or itself turned over."""

INTERPOLATIONS = ("linear", "closest")
"""Between the pixels' centres: bilinear, or the value of the nearest."""

LARGEST_TRANSFORM = 1.0e6
LARGEST_PIXEL = 1.0e6
_FARTHEST = 1.0e300
_ROWS_AT_ONCE = 1 << 14  # points that are read at once: the intermediates stay in the cache


@dataclass(frozen=True, slots=True, eq=False)
class ImageTexture:
    """A picture over texture coordinates (u, v); it fills the square from 0 to 1.

    Attributes
    ----------
    pixels : ndarray of float32, shape (H, W, C)
        Linear values, not negative; row 0 is the bottom of the picture, at v = 0. For colours three channels of linear
        Rec.709 (sRGB without its transfer curve); for a mask one.
    extension : str
        One of :data:`EXTENSIONS`.
    interpolation : str
        One of :data:`INTERPOLATIONS`.
    transform : ndarray of float64, shape (2, 3)
        Affine map from the surface's (u, v, 1) to the picture's coordinates.
    name : str
        Shown in the plan and in errors.

    Raises
    ------
    InvalidParameterError
        If there is no pixel, one is negative, above 1e6 or not finite, or another value breaks its rule.

    References
    ----------
    Extensions, and the place of pixel centres at (i + 0.5) / size, as in Blender's Cycles.
    """

    pixels: NDArray[np.float32]
    extension: str = "repeat"
    interpolation: str = "linear"
    transform: NDArray[np.float64] = field(default_factory=lambda: np.eye(2, 3))
    name: str = ""
    _key: bytes = field(init=False, repr=False)

    def __post_init__(self) -> None:
        label = f"texture '{self.name}'" if self.name else "texture"
        pixels = np.array(self.pixels, dtype=np.float32, order="C")
        if pixels.ndim != 3 or not pixels.size:
            raise InvalidParameterError(
                f"pixels of {label} must have the shape (H, W, C), none of them 0, but have {pixels.shape}"
            )
        lowest, highest = float(pixels.min()), float(pixels.max())  # NaN is passed on by both
        if not (np.isfinite(lowest) and np.isfinite(highest)):
            raise InvalidParameterError(f"pixels of {label} must be finite, but one is not")
        if lowest < 0.0 or highest > LARGEST_PIXEL:
            raise InvalidParameterError(
                f"pixels of {label} must be 0 to {LARGEST_PIXEL:g}, but lie between {lowest:g} and {highest:g}"
            )
        pixels.flags.writeable = False
        require_choice(f"extension of {label}", self.extension, EXTENSIONS)
        require_choice(f"interpolation of {label}", self.interpolation, INTERPOLATIONS)
        transform = np.array(
            require_in_range(f"transform of {label}", self.transform, -LARGEST_TRANSFORM, LARGEST_TRANSFORM)
        )
        require_shape(f"transform of {label}", transform, (2, 3))
        transform.flags.writeable = False
        object.__setattr__(self, "pixels", pixels)
        object.__setattr__(self, "transform", transform)
        digest = hashlib.blake2b(repr((pixels.shape, self.extension, self.interpolation)).encode(), digest_size=16)
        digest.update(transform.tobytes())
        digest.update(pixels.data)
        object.__setattr__(self, "_key", digest.digest())

    @property
    def key(self) -> bytes:
        """Digest (16 bytes) of the content without the name; equal textures have equal keys."""
        return self._key

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, ImageTexture) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def sample(self, uv: ArrayLike) -> NDArray[np.floating[Any]]:
        """Read the picture at texture coordinates.

        Parameters
        ----------
        uv : array_like, shape (N, 2)
            Texture coordinates of the surface.

        Returns
        -------
        ndarray, shape (N, C)
            The channels; float32 if `uv` is, else float64. Coordinates are worked on in float64, so that a picture
            that is repeated a million times is still read at the right pixel.

        Raises
        ------
        InvalidParameterError
            If a coordinate is not finite, or there are not two.

        References
        ----------
        Bilinear interpolation, as in Blender's Cycles. No levels of detail: a pixel's samples average the picture.
        """
        given = np.asarray(uv)
        dtype = np.float32 if given.dtype == np.float32 else np.float64
        coordinates = require_finite("uv", given)
        require_shape("uv", coordinates, (None, 2))
        if dtype is np.float64:
            coordinates = np.clip(coordinates, -_FARTHEST, _FARTHEST)  # that the transform may multiply
        out: NDArray[np.floating[Any]] = np.empty((len(coordinates), self.pixels.shape[2]), dtype)
        for start in range(0, len(coordinates), _ROWS_AT_ONCE):
            part = slice(start, start + _ROWS_AT_ONCE)
            placed = coordinates[part] @ self.transform[:, :2].T + self.transform[:, 2]
            self._read(placed, out[part])
        return out

    def _read(self, placed: NDArray[np.float64], out: NDArray[np.floating[Any]]) -> None:
        """Read placed coordinates into `out` (n, C): places in float64, values in the type of `out`."""
        height, width, channels = self.pixels.shape
        taps = _nearest if self.interpolation == "closest" else _neighbours
        columns = taps(_folded(placed[:, 0], self.extension), width, self.extension)
        rows = taps(_folded(placed[:, 1], self.extension), height, self.extension)
        flat = self.pixels.reshape(-1, channels)
        out[:] = 0.0
        for row, share_of_row in rows:
            for column, share in columns:
                weight = (share_of_row * share).astype(out.dtype)
                out += weight[:, None] * flat.take(row * width + column, axis=0)


Taps = tuple[tuple[NDArray[np.int64], NDArray[np.float64]], ...]


def _folded(coordinate: NDArray[np.float64], extension: str) -> NDArray[np.float64]:
    """Bring a coordinate near the picture, where it can be counted in pixels without overflow or loss."""
    if extension == "repeat":
        return coordinate - np.floor(coordinate)
    if extension == "mirror":
        return coordinate - 2.0 * np.floor(0.5 * coordinate)
    return np.clip(coordinate, -1.0, 2.0)


def _neighbours(coordinate: NDArray[np.float64], size: int, extension: str) -> Taps:
    """The two pixels around a coordinate along one axis, with their shares."""
    position = coordinate * size - 0.5
    low = np.floor(position)
    share = position - low
    index = low.astype(np.int64)
    return _held(index, 1.0 - share, size, extension), _held(index + 1, share, size, extension)


def _nearest(coordinate: NDArray[np.float64], size: int, extension: str) -> Taps:
    index = np.floor(coordinate * size).astype(np.int64)
    return (_held(index, np.ones(len(index)), size, extension),)


def _held(
    index: NDArray[np.int64], share: NDArray[np.float64], size: int, extension: str
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Replace indices beyond the picture by what the extension shows there."""
    if extension == "repeat":
        return index % size, share
    if extension == "mirror":
        turned = index % (2 * size)
        return np.minimum(turned, 2 * size - 1 - turned), share
    held = np.clip(index, 0, size - 1)
    return held, np.where(held == index, share, 0.0) if extension == "clip" else share
