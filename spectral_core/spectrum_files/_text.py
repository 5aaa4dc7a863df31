"""What all readers share: opening text, numbers with their line, and the checks that name file and line."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

from ..errors import SpectrumFileError
from ..spectra import LARGEST_VALUE

__all__ = ["Sample", "fail", "number", "ordered", "read_text", "wavelength_factor"]

_LARGEST_FILE = 64 * 1024 * 1024  # bytes; a million samples in text take less than half of it


@dataclass(frozen=True, slots=True)
class Sample:
    """A wavelength in nm, the values that stand beside it, and the line of the file."""

    wavelength_nm: float
    values: tuple[float, ...]
    line: int


def fail(path: Path, line: int | None, reason: str) -> SpectrumFileError:
    """Make the error that names the file, the line and the reason.

    Parameters
    ----------
    path : Path
        The file.
    line : int or None
        The line, from 1; None when the whole file is meant.
    reason : str
        What is wrong.

    Returns
    -------
    SpectrumFileError
        To be raised.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    where = path.name if line is None else f"{path.name} line {line}"
    return SpectrumFileError(f"{where}: {reason}")


def read_text(path: Path) -> str:
    """Read a text file as UTF-8 (with or without mark), or as Latin-1 where that fails.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        Its text.

    Raises
    ------
    SpectrumFileError
        If the file cannot be read, is longer than 64 MiB, or is not text.

    References
    ----------
    Own design.
    """
    try:
        size = path.stat().st_size
        if size > _LARGEST_FILE:
            raise fail(
                path, None, f"is {size / 2**20:.0f} MiB long; spectra are read up to {_LARGEST_FILE // 2**20} MiB"
            )
        content = path.read_bytes()
    except OSError as error:
        raise SpectrumFileError(f"{path} cannot be read: {error.strerror or error}") from error
    if b"\0" in content:
        raise fail(path, None, "is not a text file")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def number(path: Path, line: int, token: str, what: str, *, comma: bool = False, factor: str = "1") -> float:
    """Parse a finite number; scaling in decimal keeps 0.57 um exactly 570 nm.

    Parameters
    ----------
    path : Path
        The file, for the error.
    line : int
        The line, for the error.
    token : str
        The number as it stands.
    what : str
        What the number is, for the error.
    comma : bool
        Whether the decimal mark is a comma.
    factor : str
        A decimal number by which to multiply.

    Returns
    -------
    float
        The number.

    Raises
    ------
    SpectrumFileError
        If the token is empty, no number, or not finite.

    References
    ----------
    Own design.
    """
    text = token.strip().strip('"')
    try:
        value = float(Decimal(text.replace(",", ".") if comma else text) * Decimal(factor))
    except ArithmeticError:  # no number, or one beyond what decimals hold
        shown = f"{text!r} is not a number" if text else "is missing"
        raise fail(path, line, f"the {what} {shown}") from None
    if not math.isfinite(value):
        raise fail(path, line, f"the {what} must be finite, but is {text}")
    return value


def ordered(path: Path, samples: list[Sample]) -> list[Sample]:
    """Return the samples with rising wavelengths, or raise where their order breaks.

    A file that runs from long to short waves throughout, as scanning instruments write it, is turned around.

    Parameters
    ----------
    path : Path
        The file, for the error.
    samples : list of Sample
        In file order.

    Returns
    -------
    list of Sample
        In rising order.

    Raises
    ------
    SpectrumFileError
        If a wavelength is not positive, or breaks the order; with the line's number.

    References
    ----------
    Own design.
    """
    for sample in samples:
        if not 0.0 < sample.wavelength_nm < math.inf:
            raise fail(path, sample.line, f"wavelengths must be positive, but this is {sample.wavelength_nm} nm")
        if not all(abs(value) <= LARGEST_VALUE for value in sample.values):
            raise fail(path, sample.line, f"the value is too large; {LARGEST_VALUE:g} is the most that is read")
    falls = sum(after.wavelength_nm < before.wavelength_nm for before, after in itertools.pairwise(samples))
    falling = 2 * falls > len(samples) - 1  # most of the steps tell the direction that is meant
    for before, after in itertools.pairwise(samples):
        right = after.wavelength_nm < before.wavelength_nm if falling else after.wavelength_nm > before.wavelength_nm
        if not right:
            direction = "decrease strictly, as they mostly do" if falling else "increase strictly"
            raise SpectrumFileError(
                f"wavelengths must {direction}: {after.wavelength_nm} nm follows {before.wavelength_nm} nm "
                f"in {path.name} line {after.line}"
            )
    return samples[::-1] if falling else samples


_FACTORS = {
    "nm": "1",
    "nanometer": "1",
    "nanometers": "1",
    "nanometre": "1",
    "nanometres": "1",
    "um": "1000",
    "µm": "1000",
    "μm": "1000",
    "micron": "1000",
    "microns": "1000",
    "micrometer": "1000",
    "micrometers": "1000",
    "micrometre": "1000",
    "micrometres": "1000",
    "å": "0.1",
    "angstrom": "0.1",
    "angstroms": "0.1",
}


def wavelength_factor(unit: str) -> str | None:
    """Tell the decimal factor from a unit of length to nm.

    Parameters
    ----------
    unit : str
        "nm", "um", "micrometers", "angstrom" and the like, in any case.

    Returns
    -------
    str or None
        The factor as a decimal number, or None where the word is no unit that is known.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    return _FACTORS.get(unit.strip().lower())
