"""From tristimulus values to what a display is sent: primaries, transfer curve or measured table, and gamut.

A display is a white, three primaries and the way in which a drive value becomes light. Standard displays (sRGB,
Display P3, Rec.2020) have it by formula; a calibrated monitor has it measured, as the paper does: a 3x3 matrix and a
look-up table for each channel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .colorimetry import tristimulus_from_xy
from .errors import InvalidParameterError
from .validation import require_choice, require_finite, require_shape

__all__ = [
    "DISPLAYS",
    "GAMUT_METHODS",
    "SRGB_WHITE",
    "TRANSFERS",
    "Display",
    "GamutMapping",
    "display",
    "fit_to_gamut",
]

DISPLAYS = ("srgb", "display_p3", "rec2020")
"""The displays known by formula."""

TRANSFERS = ("linear", "srgb", "rec2020", "table")
"""How a drive value becomes light."""

GAMUT_METHODS = ("clip", "compress")
"""What is done with colours that a display cannot show."""

_D65 = (0.3127, 0.3290)
_PRIMARIES = {
    # IEC 61966-2-1:1999; ITU-R BT.709-6.
    "srgb": ((0.640, 0.330), (0.300, 0.600), (0.150, 0.060)),
    # SMPTE EG 432-1:2010 primaries with the white and the transfer curve of sRGB.
    "display_p3": ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060)),
    # ITU-R BT.2020-2, table 3.
    "rec2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)),
}
_TRANSFER_OF = {"srgb": "srgb", "display_p3": "srgb", "rec2020": "rec2020"}

# The constants of BT.2020 that make value and slope continuous: the exact solution of its two conditions.
_REC2020_ALPHA = 1.09929682680944
_REC2020_BETA = 0.018053968510807

SRGB_WHITE: NDArray[np.float64] = tristimulus_from_xy(_D65)
"""XYZ (3,) of the white of sRGB, Display P3 and Rec.2020: D65 as x = 0.3127, y = 0.3290, with Y = 1."""
SRGB_WHITE.flags.writeable = False


@dataclass(frozen=True, slots=True, eq=False)
class Display:
    """A display.

    Parameters
    ----------
    name : str
        For messages and panels.
    to_tristimulus : array_like (3, 3)
        XYZ of full red, green and blue in its columns, scaled so that the white has Y = 1; must be invertible.
    transfer : {"linear", "srgb", "rec2020", "table"}
        How drive values 0 to 1 become light 0 to 1.
    drive_table : array_like (D,), optional
        For "table": drive values from 0 to 1, strictly increasing, D >= 2.
    light_table : array_like (D, 3), optional
        For "table": measured light of red, green and blue at the drive values, increasing from 0 to 1.
    """

    name: str
    to_tristimulus: NDArray[np.float64]
    transfer: str = "linear"
    drive_table: NDArray[np.float64] | None = None
    light_table: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        label = f"of display {self.name!r}"
        matrix = np.array(require_finite(f"matrix {label}", self.to_tristimulus))
        require_shape(f"matrix {label}", matrix, (3, 3))
        require_choice(f"transfer {label}", self.transfer, TRANSFERS)
        if not np.linalg.cond(matrix) < 1.0e6:
            raise InvalidParameterError(
                f"matrix {label} must have three independent primaries, but is {matrix.tolist()}"
            )
        matrix.flags.writeable = False
        object.__setattr__(self, "to_tristimulus", matrix)
        if self.transfer != "table":
            if self.drive_table is not None or self.light_table is not None:
                raise InvalidParameterError(
                    f"transfer {label} must be 'table' when tables are given, not {self.transfer!r}"
                )
            return
        if self.drive_table is None or self.light_table is None:
            raise InvalidParameterError(f"transfer 'table' {label} needs drive_table and light_table")
        drive = np.array(require_finite(f"drive table {label}", self.drive_table))
        light = np.array(require_finite(f"light table {label}", self.light_table))
        require_shape(f"drive table {label}", drive, (None,))
        require_shape(f"light table {label}", light, (drive.size, 3))
        if drive.size < 2 or drive[0] != 0.0 or drive[-1] != 1.0 or np.any(np.diff(drive) <= 0.0):
            raise InvalidParameterError(
                f"drive table {label} must increase strictly from 0 to 1, but is {drive.tolist()}"
            )
        if np.any(light[0] != 0.0) or np.any(light[-1] != 1.0) or np.any(np.diff(light, axis=0) <= 0.0):
            raise InvalidParameterError(f"light table {label} must increase strictly from 0 to 1 in each channel")
        drive.flags.writeable = light.flags.writeable = False
        object.__setattr__(self, "drive_table", drive)
        object.__setattr__(self, "light_table", light)

    @classmethod
    def from_primaries(cls, name: str, primaries: ArrayLike, white: ArrayLike, transfer: str = "linear") -> Display:
        """Make a display from the chromaticities of its primaries and its white.

        Parameters
        ----------
        name : str
            For messages and panels.
        primaries : array_like (3, 2)
            x, y of red, green and blue.
        white : array_like (2,)
            x, y of the white.
        transfer : {"linear", "srgb", "rec2020"}
            Transfer curve.

        Returns
        -------
        Display
            The display, its white at Y = 1.

        Raises
        ------
        InvalidParameterError
            If the primaries lie on a line, or a y is 0.

        References
        ----------
        SMPTE RP 177-1993, section 3 (normalised primary matrix).
        """
        chromaticities = require_finite("primaries", primaries)
        require_shape("primaries", chromaticities, (3, 2))
        columns = tristimulus_from_xy(chromaticities).T
        if not np.linalg.cond(columns) < 1.0e6:
            raise InvalidParameterError(f"primaries must span a triangle, but are {chromaticities.tolist()}")
        shares = np.linalg.solve(columns, tristimulus_from_xy(white))
        return cls(name, columns * shares, transfer)

    @property
    def from_tristimulus(self) -> NDArray[np.float64]:
        """Matrix (3, 3) from XYZ to linear RGB.

        Returns
        -------
        ndarray of float64 (3, 3)
            ``xyz @ matrix.T`` is linear RGB; the white gives 1, 1, 1.

        Raises
        ------
        None.

        References
        ----------
        SMPTE RP 177-1993.
        """
        return np.linalg.inv(self.to_tristimulus)

    @property
    def white(self) -> NDArray[np.float64]:
        """XYZ (3,) of the display's white, all channels at full drive.

        Returns
        -------
        ndarray of float64 (3,)
            XYZ.

        Raises
        ------
        None.

        References
        ----------
        SMPTE RP 177-1993.
        """
        return np.asarray(self.to_tristimulus.sum(axis=1))

    def linear(self, xyz: ArrayLike) -> NDArray[np.float64]:
        """Linear RGB of tristimulus values, outside 0 to 1 where the display cannot show them.

        Parameters
        ----------
        xyz : array_like (..., 3)
            Tristimulus values, already adapted to the display's white.

        Returns
        -------
        ndarray of float64 (..., 3)
            Linear RGB.

        Raises
        ------
        InvalidParameterError
            If a value is not finite or the last axis is not of length 3.

        References
        ----------
        SMPTE RP 177-1993.
        """
        return np.asarray(_triples("xyz", xyz) @ self.from_tristimulus.T)

    def tristimulus(self, linear_rgb: ArrayLike) -> NDArray[np.float64]:
        """Tristimulus values of linear RGB.

        Parameters
        ----------
        linear_rgb : array_like (..., 3)
            Linear RGB.

        Returns
        -------
        ndarray of float64 (..., 3)
            XYZ with Y = 1 for the white.

        Raises
        ------
        InvalidParameterError
            If a value is not finite or the last axis is not of length 3.

        References
        ----------
        SMPTE RP 177-1993.
        """
        return np.asarray(_triples("linear_rgb", linear_rgb) @ self.to_tristimulus.T)

    def encode(self, linear_rgb: ArrayLike) -> NDArray[np.float64]:
        """Drive values that make the display emit linear RGB.

        Parameters
        ----------
        linear_rgb : array_like (..., 3)
            Linear RGB; formula curves continue beyond 0 and 1 (odd below 0), measured tables hold their ends.

        Returns
        -------
        ndarray of float64 (..., 3)
            Drive values.

        Raises
        ------
        InvalidParameterError
            If a value is not finite or the last axis is not of length 3.

        References
        ----------
        IEC 61966-2-1:1999 (sRGB); ITU-R BT.2020-2, table 4; Tominaga 1996, Applications (measured table).
        """
        light = _triples("linear_rgb", linear_rgb)
        if self.transfer == "linear":
            return light.copy()
        if self.drive_table is not None and self.light_table is not None:
            channels = [np.interp(light[..., c], self.light_table[:, c], self.drive_table) for c in range(3)]
            return np.stack(channels, axis=-1)
        size = np.abs(light)
        if self.transfer == "srgb":
            drive = np.where(size <= 0.0031308, 12.92 * size, 1.055 * size ** (1.0 / 2.4) - 0.055)
        else:
            curve = _REC2020_ALPHA * size**0.45 - (_REC2020_ALPHA - 1.0)
            drive = np.where(size < _REC2020_BETA, 4.5 * size, curve)
        return np.copysign(drive, light)

    def decode(self, drive: ArrayLike) -> NDArray[np.float64]:
        """Linear RGB that the display emits for drive values.

        Parameters
        ----------
        drive : array_like (..., 3)
            Drive values.

        Returns
        -------
        ndarray of float64 (..., 3)
            Linear RGB, the inverse of :meth:`encode`.

        Raises
        ------
        InvalidParameterError
            If a value is not finite or the last axis is not of length 3.

        References
        ----------
        As :meth:`encode`.
        """
        value = _triples("drive", drive)
        if self.transfer == "linear":
            return value.copy()
        if self.drive_table is not None and self.light_table is not None:
            channels = [np.interp(value[..., c], self.drive_table, self.light_table[:, c]) for c in range(3)]
            return np.stack(channels, axis=-1)
        size = np.abs(value)
        if self.transfer == "srgb":
            light = np.where(size <= 12.92 * 0.0031308, size / 12.92, ((size + 0.055) / 1.055) ** 2.4)
        else:
            curve = ((size + (_REC2020_ALPHA - 1.0)) / _REC2020_ALPHA) ** (1.0 / 0.45)
            light = np.where(size < 4.5 * _REC2020_BETA, size / 4.5, curve)
        return np.copysign(light, value)


@dataclass(frozen=True, slots=True, eq=False)
class GamutMapping:
    """Linear RGB brought into a display's gamut, and how many colours had to be moved.

    Parameters
    ----------
    linear_rgb : ndarray (..., 3)
        Values between 0 and 1.
    method : {"clip", "compress"}
        What was done.
    below : int
        Colours with a negative channel: more saturated than the primaries allow.
    above : int
        Colours with a channel above 1: brighter than the display's white allows.
    total : int
        All colours.
    """

    linear_rgb: NDArray[np.float64]
    method: str
    below: int
    above: int
    total: int

    def describe(self) -> str:
        """Tell the counts in words.

        Returns
        -------
        str
            One sentence for the statistics.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        done = {"clip": "clipped", "compress": "compressed"}[self.method]
        return f"gamut: of {self.total} colours {self.below} were too saturated and {self.above} too bright, and {done}"


def fit_to_gamut(linear_rgb: ArrayLike, shown: Display, method: str = "clip") -> GamutMapping:
    """Bring linear RGB into the range from 0 to 1 of a display and count what was outside.

    Parameters
    ----------
    linear_rgb : array_like (..., 3)
        Linear RGB of the display.
    shown : Display
        The display; its matrix tells the luminance of a colour.
    method : {"clip", "compress"}
        "clip" cuts each channel. "compress" desaturates too saturated colours towards the grey of the same luminance
        until no channel is negative, keeping luminance and hue line, then scales down too bright ones as a whole,
        keeping chromaticity.

    Returns
    -------
    GamutMapping
        The result and the counts; colours inside are returned unchanged.

    Raises
    ------
    InvalidParameterError
        If a value is not finite, the last axis is not of length 3, or the method is unknown.

    References
    ----------
    Own design (straight lines to the achromatic axis, as in CIE 156:2004's reference algorithms).
    """
    require_choice("gamut method", method, GAMUT_METHODS)
    values = _triples("linear_rgb", linear_rgb)
    # Rounding of a matrix product leaves primaries and white a few ulp outside; that is no colour out of gamut.
    slack = 1.0e-9
    below = (values < -slack).any(axis=-1)
    above = (values > 1.0 + slack).any(axis=-1)
    if method == "compress":
        lowest = values.min(axis=-1)
        grey = np.maximum(values @ shown.to_tristimulus[1], 0.0)
        # grey + share * (values - grey) has its lowest channel at 0 for share = grey / (grey - lowest).
        share = np.where(lowest < 0.0, grey / np.maximum(grey - lowest, np.finfo(np.float64).tiny), 1.0)
        desaturated = grey[..., None] + share[..., None] * (values - grey[..., None])
        values = np.where((lowest < 0.0)[..., None], desaturated, values)
        highest = values.max(axis=-1, keepdims=True)
        values = np.where(highest > 1.0, values / np.maximum(highest, 1.0), values)
    fitted = np.clip(values, 0.0, 1.0)
    total = int(np.prod(values.shape[:-1], dtype=np.int64))
    return GamutMapping(fitted, method, int(np.count_nonzero(below)), int(np.count_nonzero(above)), total)


def display(name: str) -> Display:
    """Fetch a display by name.

    Parameters
    ----------
    name : {"srgb", "display_p3", "rec2020"}
        Which one.

    Returns
    -------
    Display
        Matrix from its primaries at full precision, transfer curve of its standard.

    Raises
    ------
    InvalidParameterError
        If the name is unknown.

    References
    ----------
    IEC 61966-2-1:1999; SMPTE EG 432-1:2010; ITU-R BT.2020-2.
    """
    require_choice("display", name, DISPLAYS)
    return Display.from_primaries(name, _PRIMARIES[name], _D65, _TRANSFER_OF[name])


def _triples(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = require_finite(name, value)
    if array.shape[-1:] != (3,):
        raise InvalidParameterError(f"{name} must have three values on the last axis, but has the shape {array.shape}")
    return array
