"""Writing spectra: whole files or none."""

from __future__ import annotations

from pathlib import Path

from ..atomic_files import replacing
from ..errors import DichromaticError, SpectrumFileError
from ..spectra import Spectrum

__all__ = ["write_spectrum"]


def write_spectrum(path: str | Path, spectrum: Spectrum, comment: str = "") -> None:
    """Write a spectrum as CSV or SPD, atomically: readers see the old file or the new one, never half of it.

    Parameters
    ----------
    path : str or Path
        ``.csv`` (comma, with header), ``.tsv`` (tab, with header) or ``.spd`` (blank, no header).
    spectrum : Spectrum
        What to write. Numbers are written so that reading gives them back to the last bit.
    comment : str, optional
        Text for the head of the file; each line becomes a comment.

    Raises
    ------
    SpectrumFileError
        If the suffix is another, or the file cannot be written; nothing is left behind then.

    References
    ----------
    Own design.
    """
    file = Path(path)
    delimiter = {".csv": ",", ".tsv": "\t", ".spd": " "}.get(file.suffix.lower())
    if delimiter is None:
        raise SpectrumFileError(f"{file.name}: the suffix must be .csv, .tsv or .spd to be written")
    lines = [f"# {line}" for line in comment.splitlines()]
    if spectrum.name:
        lines.append(f"# name: {' '.join(spectrum.name.split())}")
    lines.append(f"# interpolation: {spectrum.interpolation}")
    if delimiter != " ":
        lines.append(f"wavelength_nm{delimiter}value")
    lines += [
        f"{float(wavelength)!r}{delimiter}{float(value)!r}"
        for wavelength, value in zip(spectrum.wavelengths_nm, spectrum.values, strict=True)
    ]
    try:
        with replacing(file) as temporary:
            temporary.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    except DichromaticError as error:
        raise SpectrumFileError(str(error)) from error
