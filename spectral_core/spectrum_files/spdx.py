"""Spectra in SPDX, the XML of ANSI/IES TM-27."""

from __future__ import annotations

from pathlib import Path
from xml.parsers import expat

from ..errors import SpectrumFileError
from ._text import Sample, fail, number, read_text

__all__ = ["read_spdx"]


class _Handler:
    """Collects the samples while expat walks through the file, so that each keeps its line."""

    def __init__(self, path: Path, parser: expat.XMLParserType) -> None:
        self.path = path
        self.parser = parser
        self.samples: list[Sample] = []
        self.remarks: dict[str, str] = {}
        self.text = ""
        self.wavelength: float | None = None
        self.line = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.text = ""
        self.line = self.parser.CurrentLineNumber
        if _local(tag) == "SpectralData":
            self.wavelength = number(self.path, self.line, attributes.get("wavelength", ""), "attribute wavelength")

    def characters(self, text: str) -> None:
        self.text += text

    def end(self, tag: str) -> None:
        if _local(tag) == "SpectralData" and self.wavelength is not None:
            value = number(self.path, self.line, self.text, "value")
            self.samples.append(Sample(self.wavelength, (value,), self.line))
        elif self.text.strip():
            self.remarks.setdefault(_local(tag), self.text.strip())
        self.text = ""

    def doctype(self, *_: object) -> None:
        line = self.parser.CurrentLineNumber
        raise fail(
            self.path, line, "document type declarations are not allowed (their entities can grow without limit)"
        )


def _local(tag: str) -> str:
    """Name of an element without its namespace prefix."""
    return tag.rpartition(":")[2]


def read_spdx(path: Path) -> tuple[list[Sample], dict[str, str]]:
    """Read an SPDX file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    samples : list of Sample
        One value each, wavelengths in nm, in file order.
    remarks : dict of str to str
        Texts of the header by element (Description, SpectralQuantity, Manufacturer, ...).

    Raises
    ------
    SpectrumFileError
        If the XML is broken, a document type is declared, or there is no spectral data; with the line's number.

    References
    ----------
    ANSI/IES TM-27-20, Standard Format for the Electronic Transfer of Spectral Data.
    """
    text = read_text(path)
    parser = expat.ParserCreate("utf-8")  # the text is decoded already, whatever the declaration says
    parser.buffer_text = True
    handler = _Handler(path, parser)
    parser.StartElementHandler = handler.start
    parser.EndElementHandler = handler.end
    parser.CharacterDataHandler = handler.characters
    parser.StartDoctypeDeclHandler = handler.doctype
    try:
        parser.Parse(text.encode("utf-8"), True)
    except expat.ExpatError as error:
        raise SpectrumFileError(f"{path.name} line {error.lineno}: {expat.ErrorString(error.code)}") from error
    if not handler.samples:
        raise fail(path, None, "holds no SpectralData element")
    return handler.samples, handler.remarks
