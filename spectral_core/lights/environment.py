"""Light from all around: an evenly bright world, or a picture of one."""

from __future__ import annotations

import math
import threading
import weakref
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidParameterError
from ..tracing.columns import dot_rows
from ..validation import require_finite, require_shape
from .base import Floats, Illumination, LampPoint, Vector

__all__ = ["EnvironmentImage", "EnvironmentLight"]

_SPHERE = 4.0 * math.pi


@dataclass(frozen=True, slots=True, eq=False)
class EnvironmentImage:
    """A picture of everything around, in longitude and latitude.

    Attributes
    ----------
    pixels : array_like, shape (H, W, 3)
        Linear Rec.709 radiance, at least 0; row 0 is the zenith. A world direction (x, y, z), turned by `rotation`, is
        found at the column (1/2 - atan2(y, x) / 2 pi) W and the row (1/2 - latitude / pi) H, as in Blender. Copied,
        unless it is float32 and read-only already: images that differ in their rotation share what is known of them.
    rotation : array_like, shape (3, 3), optional
        From world directions to those of the picture; it may turn them over, but not scale them.

    Raises
    ------
    InvalidParameterError
        If a shape is wrong, a value is negative or not finite, or the rotation is none.

    References
    ----------
    Conventions: Blender manual, Environment Texture (equirectangular).
    """

    pixels: NDArray[np.float32]
    rotation: Vector = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        pixels = np.asarray(self.pixels, np.float32)
        if pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
            raise InvalidParameterError(f"environment pixels must have the shape (H, W, 3), but have {pixels.shape}")
        if pixels.flags.writeable:  # nobody may write to what is remembered
            pixels = pixels.copy()
            pixels.flags.writeable = False
        if not _what_is_known(pixels).is_valid:
            raise InvalidParameterError("environment pixels must be finite and at least 0")
        rotation = require_finite("environment rotation", self.rotation)
        require_shape("environment rotation", rotation, (3, 3))
        if not np.allclose(rotation @ rotation.T, np.eye(3), rtol=0.0, atol=1e-6):
            raise InvalidParameterError(
                f"environment rotation must have perpendicular rows of length 1, but is {rotation.tolist()}"
            )
        object.__setattr__(self, "pixels", pixels)
        object.__setattr__(self, "rotation", rotation)

    def radiance(self, directions: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Look up directions, linearly between the middles of pixels.

        Parameters
        ----------
        directions : ndarray, shape (N, 3)
            Unit vectors, in the world.

        Returns
        -------
        ndarray of float32, shape (N, 3)
            Linear Rec.709.

        Raises
        ------
        ValueError
            From numpy if the last axis is not 3 long.

        References
        ----------
        Own design.
        """
        wide = directions.astype(np.float64)
        x, y, z = (dot_rows(wide, axis) for axis in self.rotation)
        height, width, _ = self.pixels.shape
        column = (0.5 - np.arctan2(y, x) / (2.0 * math.pi)) * width - 0.5
        row = (0.5 - np.arctan2(z, np.hypot(x, y)) / math.pi) * height - 0.5
        return np.asarray(_between_pixels(self.pixels, column, row), np.float32)


class _Known:
    """What is found out about the pixels of a picture, once for all images that have them; large ones take a while."""

    def __init__(self, pixels: NDArray[np.float32]) -> None:
        self.is_valid = bool(np.isfinite(pixels).all() and pixels.min() >= 0.0)
        self._chances: tuple[Floats, Vector, Vector] | None = None
        self._lock = threading.Lock()

    def chances(self, pixels: NDArray[np.float32]) -> tuple[Floats, Vector, Vector]:
        """Brightness (H, W) of the pixels times their solid angle, its sums along the rows, and those over the rows."""
        with self._lock:
            if self._chances is None:
                height = pixels.shape[0]
                latitude = math.pi * (0.5 - (np.arange(height) + 0.5) / height)
                brightness = pixels.sum(axis=2, dtype=np.float64) * np.cos(latitude)[:, None]
                # An even part keeps directions between bright pixels from being missed.
                brightness += 0.05 * brightness.mean() * np.cos(latitude)[:, None] + 1e-300
                columns = np.cumsum(brightness, axis=1)
                self._chances = brightness, columns, np.cumsum(columns[:, -1])
            return self._chances


_known: dict[int, tuple[weakref.ref[NDArray[np.float32]], _Known]] = {}
_known_lock = threading.RLock()  # an array may go, and ask to be forgotten, while it is held


def _what_is_known(pixels: NDArray[np.float32]) -> _Known:
    """Give what is known of an array that nobody writes to, for as long as the array lives."""
    key = id(pixels)
    with _known_lock:
        if key in _known and _known[key][0]() is pixels:
            return _known[key][1]
    found = _Known(pixels)
    with _known_lock:
        _known[key] = weakref.ref(pixels, lambda gone: _forget(key, gone)), found
    return found


def _forget(key: int, gone: weakref.ref[NDArray[np.float32]]) -> None:
    with _known_lock:
        if key in _known and _known[key][0] is gone:
            del _known[key]


class EnvironmentLight:
    """The world as a source of light, one direction at a time.

    Parameters
    ----------
    image : EnvironmentImage, optional
        Where it shines from; evenly from everywhere when left out.
    name : str
        Of the world.
    """

    casts_shadow = True
    is_extended = True
    receivers: frozenset[int] | None = None
    blockers: frozenset[int] | None = None

    def __init__(self, image: EnvironmentImage | None = None, name: str = "World") -> None:
        self.image = image
        self.name = name
        self._brightness: Floats | None = None
        self._rows: Vector | None = None
        self._columns: Vector | None = None
        if image is not None:
            self._brightness, self._columns, self._rows = _what_is_known(image.pixels).chances(image.pixels)

    def lamp_point(self, unit_square: Vector, aim: Vector) -> LampPoint:
        """Choose a direction, of a picture with a chance proportional to its brightness.

        Parameters
        ----------
        unit_square : ndarray of float64, shape (3,)
            Random numbers from 0 to 1; the third is not used.
        aim : ndarray of float64, shape (3,)
            Not used.

        Returns
        -------
        LampPoint
            The direction; its factor is the inverse of its probability density over the sphere, and its weights are
            the radiances of the picture's primaries.

        Raises
        ------
        None.

        References
        ----------
        Importance sampling of pictures: Pharr, Jakob and Humphreys, Physically Based Rendering, 3rd ed., 14.2.4. A
        pixel shines as far as the middles of its neighbours, less and less; so points are drawn from it, too.
        """
        u, v = float(unit_square[0]), float(unit_square[1])
        if self.image is None or self._brightness is None or self._rows is None or self._columns is None:
            z, angle = 1.0 - 2.0 * u, 2.0 * math.pi * v
            across = math.sqrt(max(1.0 - z * z, 0.0))
            return LampPoint(to_light=np.array([across * math.cos(angle), across * math.sin(angle), z]), factor=_SPHERE)
        height, width = self._columns.shape
        chosen_row, share = _choose(self._rows, u)
        row = _reflected(chosen_row + _tent(share), height)
        chosen_column, share = _choose(self._columns[chosen_row], v)
        column = chosen_column + _tent(share)
        latitude = math.pi * (0.5 - (row + 0.5) / height)
        longitude = 2.0 * math.pi * (0.5 - (column + 0.5) / width)
        local = np.array(
            [
                math.cos(latitude) * math.cos(longitude),
                math.cos(latitude) * math.sin(longitude),
                math.sin(latitude),
            ]
        )
        direction = self.image.rotation.T @ local
        direction /= np.linalg.norm(direction)
        place = np.array([column]), np.array([row])
        chance = float(_between_pixels(self._brightness[:, :, None], *place)[0, 0]) / self._rows[-1]
        solid_angle = (2.0 * math.pi / width) * (math.pi / height) * max(math.cos(latitude), 1e-12)
        red, green, blue = self.image.radiance(direction[None])[0].tolist()
        return LampPoint(to_light=direction, factor=solid_angle / chance, weights=(red, green, blue))

    def directions(self, unit_squares: Floats) -> Vector:
        """Find the directions that many random numbers choose.

        Parameters
        ----------
        unit_squares : ndarray of float64, shape (..., 3)
            As for :meth:`lamp_point`.

        Returns
        -------
        ndarray of float64, shape (..., 3)
            Unit vectors.

        Raises
        ------
        None.

        References
        ----------
        See :meth:`lamp_point`.
        """
        points = [self.lamp_point(u, np.zeros(3)).to_light for u in unit_squares.reshape(-1, 3)]
        return np.array(points, np.float64).reshape(unit_squares.shape)

    def illuminate(self, points: Floats, centre: Vector, at: LampPoint | None = None) -> Illumination:
        """Direction, distance and irradiance of N points from one direction, for a radiance of 1.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Points relative to `centre` (m), float32 or float64.
        centre : ndarray, shape (3,)
            Not used.
        at : LampPoint
            The direction.

        Returns
        -------
        Illumination
            In the dtype of `points`; the distance is infinite.

        Raises
        ------
        ValueError
            If no direction is given.

        References
        ----------
        Own design.
        """
        if at is None or at.to_light is None:
            raise ValueError("light from all around needs a direction")
        count, dtype = len(points), points.dtype
        direction = np.broadcast_to(at.to_light.astype(dtype), (count, 3))
        return Illumination(direction, np.full(count, np.inf, dtype), np.full(count, at.factor, dtype))


def _between_pixels(picture: Floats, column: Floats, row: Floats) -> Floats:
    """Values (N, C) at places, pixel (0, 0) being the middle of the first: linear, around from right to left."""
    height, width, _ = picture.shape
    row = np.clip(row, 0.0, height - 1.0)
    left, top = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)
    across, down = (column - left)[:, None], (row - top)[:, None]
    below = np.minimum(top + 1, height - 1)
    left, right = left % width, (left + 1) % width
    upper = picture[top, left] * (1.0 - across) + picture[top, right] * across
    lower = picture[below, left] * (1.0 - across) + picture[below, right] * across
    result: Floats = upper * (1.0 - down) + lower * down
    return result


def _tent(u: float) -> float:
    """Place between -1 and 1 with a chance that falls linearly from the middle to both ends."""
    return math.sqrt(2.0 * u) - 1.0 if u < 0.5 else 1.0 - math.sqrt(2.0 * (1.0 - u))


def _reflected(row: float, height: int) -> float:
    """Turn places beyond the poles back, where a picture has no neighbours to shine into."""
    if row < -0.5:
        row = -1.0 - row
    elif row > height - 0.5:
        row = 2.0 * height - 1.0 - row
    return row


def _choose(cumulative: Vector, u: float) -> tuple[int, float]:
    """Index with a chance proportional to its share, and how far through the share `u` is."""
    wanted = u * cumulative[-1]
    index = min(int(np.searchsorted(cumulative, wanted, side="right")), len(cumulative) - 1)
    before = cumulative[index - 1] if index else 0.0
    share = cumulative[index] - before
    return index, float(np.clip((wanted - before) / share, 0.0, 1.0)) if share > 0.0 else 0.5
