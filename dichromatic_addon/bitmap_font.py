"""Letters of 5 x 7 pixels, for what is written into pictures.

Blender itself draws text on screens only, and without a window not at all.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["draw_text", "text_width"]

HEIGHT, WIDTH, ADVANCE = 7, 5, 6

# The printable characters of ASCII from the space on; each is seven rows from the top, five bits a row.
_ROWS = (
    "00000000000000040404040400040A0A0A000000000A0A1F0A1F0A0A040F140E051E04181902040813030C12140815120D"
    "0404080000000002040808080402080402020204080004150E1504000004041F040400000000000C04080000001F000000"
    "00000000000C0C000102040810000E11131519110E040C040404040E0E11010204081F1F02040201110E02060A121F0202"
    "1F101E0101110E0608101E11110E1F0102040808080E11110E11110E0E11110F01020C000C0C000C0C00000C0C000C0408"
    "0204081008040200001F001F0000080402010204080E1101020400040E11010D15150E0E1111111F11111E11111E11111E"
    "0E11101010110E1C12111111121C1F10101E10101F1F10101E1010100E11101711110F1111111F1111110E04040404040E"
    "0702020202120C111214181412111010101010101F111B1515111111111119151311110E11111111110E1E11111E101010"
    "0E11111115120D1E11111E1412110F10100E01011E1F0404040404041111111111110E11111111110A041111111515150A"
    "11110A040A11111111110A0404041F01020408101F0E08080808080E001008040201000E02020202020E040A1100000000"
    "0000000000001F0804020000000000000E010F110F1010161911111E00000E1010110E01010D1311110F00000E111F100E"
    "0609081C080808000F11110F010E1010161911111104000C0404040E0200060202120C101012141814120C04040404040E"
    "00001A151511110000161911111100000E1111110E00001E111E101000000D130F01010000161910101000000E100E011E"
    "08081C080809060000111111130D00001111110A040000111115150A0000110A040A11000011110F010E00001F0204081F"
    "02040408040402040404040404040804040204040800000815020000"
)


@cache
def _glyphs() -> NDArray[np.bool_]:
    rows = np.frombuffer(bytes.fromhex(_ROWS), np.uint8).reshape(-1, HEIGHT)
    return (rows[..., None] >> np.arange(WIDTH - 1, -1, -1) & 1).astype(bool)


def text_width(text: str, scale: int = 2) -> int:
    """Return the width of a text in pixels."""
    return max(0, len(text) * ADVANCE - 1) * scale


def draw_text(
    picture: NDArray[np.floating[Any]],
    text: str,
    left: int,
    top: int,
    colour: tuple[float, float, float],
    scale: int = 2,
) -> None:
    """Write a line into a picture, cut off at its edges.

    Parameters
    ----------
    picture : ndarray, shape (H, W, 3)
        Row 0 is the top; changed in place.
    text : str
        Characters outside ASCII appear as question marks.
    left, top : int
        The upper left corner of the first letter.
    colour : tuple of float
        In the picture's own values.
    scale : int
        Pixels that a pixel of the letters takes.
    """
    glyphs = _glyphs()
    for number, character in enumerate(text):
        code = ord(character) - 32
        glyph = glyphs[code if 0 <= code < len(glyphs) else ord("?") - 32]
        rows, columns = np.nonzero(np.kron(glyph, np.ones((scale, scale), bool)))
        rows, columns = rows + top, columns + left + number * ADVANCE * scale
        inside = (rows >= 0) & (rows < picture.shape[0]) & (columns >= 0) & (columns < picture.shape[1])
        picture[rows[inside], columns[inside]] = colour
