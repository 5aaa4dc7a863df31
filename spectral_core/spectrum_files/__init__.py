"""Spectrum files: CSV, TSV, SPD, JCAMP-DX and SPDX read, CSV, TSV and SPD written, n and k from their YAML."""

from __future__ import annotations

from .reading import NEGATIVE_VALUES, SPECTRUM_SUFFIXES, read_spectra, read_spectrum
from .refractive_index import read_optical_constants
from .writing import write_spectrum

__all__ = [
    "NEGATIVE_VALUES",
    "SPECTRUM_SUFFIXES",
    "read_optical_constants",
    "read_spectra",
    "read_spectrum",
    "write_spectrum",
]
