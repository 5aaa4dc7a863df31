"""The parts that a picture is worked off in: bands of rows, or sub-pictures of every fourth pixel.

Where light comes from more than one point (a lamp with a size, a lens, the sky), neighbouring pixels look at different
points of it. The pixels that share their points are every K-th of a row and of a column, K x K of them make up the
picture, and each is a small picture of its own, so that whole pictures are still drawn from one eye and lit from one
point: interleaved sampling (Keller and Heidrich, EGRW 2001).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SubPicture", "refinement", "spread", "sub_pictures", "tile_places"]


@dataclass(frozen=True, slots=True)
class SubPicture:
    """Some rows of the pixels that share their points of lamps and lens.

    Attributes
    ----------
    number : int
        Which of the K x K sub-pictures, 0 to K * K - 1, in the order they are rendered.
    column, row : int
        Place of its first pixel in the K x K tile.
    step : int
        K: pixels of the picture from one of its pixels to the next.
    width : int
        Its pixels in a row.
    height : int
        Rows of the whole sub-picture.
    first, end : int
        Rows of it that are meant: the first, and the one behind the last.
    full_width : int
        Width of the picture.
    """

    number: int
    column: int
    row: int
    step: int
    width: int
    height: int
    first: int
    end: int
    full_width: int

    def __len__(self) -> int:
        return self.width * (self.end - self.first)

    @property
    def x(self) -> NDArray[np.int64]:
        """Columns of its pixels in the picture, (width,)."""
        return self.column + self.step * np.arange(self.width)

    @property
    def y(self) -> NDArray[np.int64]:
        """Rows of its rows in the picture, (end - first,)."""
        return self.row + self.step * np.arange(self.first, self.end)

    @property
    def pixels(self) -> NDArray[np.int64]:
        """Flat indices of its pixels in the picture, row by row, (N,)."""
        return (self.y[:, None] * self.full_width + self.x[None, :]).ravel()


def _tile_order(step: int) -> list[tuple[int, int, int]]:
    """Places (column, row) in a K x K tile, coarse to fine, each with the side of the square that it stands for."""
    order, side = [(0, 0, step)], step
    while side > 1:
        half = side // 2
        corners = [(x, y) for y in range(0, step, half) for x in range(0, step, half) if (x % side, y % side) != (0, 0)]
        # Diagonal neighbours first: they are farthest from what is there.
        corners.sort(key=lambda place: (place[0] % side == 0) + (place[1] % side == 0))
        order += [(x, y, half) for x, y in corners]
        side = half
    return order


def tile_places(step: int) -> list[tuple[int, int]]:
    """Where the first pixels of the sub-pictures lie.

    Parameters
    ----------
    step : int
        K, a power of 2.

    Returns
    -------
    list of (int, int)
        Column and row in the K x K tile, by number of the sub-picture.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    return [(column, row) for column, row, _ in _tile_order(step)]


def refinement(step: int, number: int) -> int:
    """How large the squares are that a sub-picture's pixels stand for until the others come.

    Parameters
    ----------
    step : int
        K, a power of 2.
    number : int
        Which sub-picture.

    Returns
    -------
    int
        Side of the square in pixels; a square lies to the right of and below its pixel.

    Raises
    ------
    IndexError
        If there is no such sub-picture.

    References
    ----------
    Own design, after the order of interlaced PNG.
    """
    return _tile_order(step)[number][2]


def spread(part: SubPicture, side: int, image: NDArray[Any], values: NDArray[Any]) -> None:
    """Put values of a part's pixels into the picture, each in the square that it stands for.

    Parameters
    ----------
    part : SubPicture
        The pixels.
    side : int
        Side of the square, to the right of and below each pixel.
    image : ndarray, shape (height, width, ...)
        The picture; changed.
    values : ndarray, shape (N, ...)
        One for each pixel of the part.

    Raises
    ------
    ValueError
        By numpy, if there are not as many values as pixels.

    References
    ----------
    Own design.
    """
    rows = values.reshape(part.end - part.first, part.width, *values.shape[1:])
    top, bottom = part.row + part.step * part.first, part.row + part.step * (part.end - 1)
    for dy in range(side):
        for dx in range(side):
            place = image[top + dy : bottom + dy + 1 : part.step, part.column + dx :: part.step]
            place[...] = rows[: len(place), : place.shape[1]]


def sub_pictures(width: int, height: int, step: int, most_pixels: int) -> Iterator[SubPicture]:
    """Cut a picture into parts.

    Parameters
    ----------
    width, height : int
        Size of the picture in pixels.
    step : int
        K, a power of 2; with 1 the parts are bands of rows.
    most_pixels : int
        Pixels that a part may have; it has one row at least.

    Yields
    ------
    SubPicture
        From the top down, one sub-picture after the other, coarse to fine.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    for number, (column, row, _) in enumerate(_tile_order(step)):
        across, down = -(-(width - column) // step), -(-(height - row) // step)
        if across <= 0 or down <= 0:
            continue
        rows = max(1, most_pixels // across)
        for first in range(0, down, rows):
            yield SubPicture(number, column, row, step, across, down, first, min(first + rows, down), width)
