"""Named spectra: lamps, reflectances and metals that come with the package, each with its source.

Measured and standard tables come from the files in ``data`` (their JSON neighbours tell from where); what is made by
formula says so.
"""

from __future__ import annotations

import difflib
import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import tables
from .errors import InvalidParameterError
from .optical_constants import OpticalConstants
from .spectra import Spectrum, blackbody
from .synthetic_reflectances import SYNTHETIC_REFLECTANCES

__all__ = [
    "illuminant",
    "illuminant_names",
    "metal_names",
    "optical_constants",
    "reflectance",
    "reflectance_names",
    "source_of",
]

_TEST_COLOURS = {
    "munsell light greyish red": "TCS01",
    "munsell dark greyish yellow": "TCS02",
    "munsell strong yellow green": "TCS03",
    "munsell moderate yellowish green": "TCS04",
    "munsell light bluish green": "TCS05",
    "munsell light blue": "TCS06",
    "munsell light violet": "TCS07",
    "munsell light reddish purple": "TCS08",
    "munsell strong red": "TCS09",
    "munsell strong yellow": "TCS10",
    "munsell strong green": "TCS11",
    "munsell strong blue": "TCS12",
    "munsell pale complexion": "TCS13",
    "munsell leaf green": "TCS14",
}
_MADE_HERE = {
    "A": "CIE illuminant A by its defining formula, ISO/CIE 11664-2:2022, 300 to 830 nm at 1 nm",
    "E": "equal-energy illuminant: the constant 1",
    "projector-halogen": (
        "tungsten-halogen lamp of a slide projector: ISO 7589 studio tungsten from 350 to 690 nm, continued to 830 nm "
        "by the Planckian radiator that fits its 500 to 690 nm in least squares of logarithms"
    ),
    "photoflood": (
        "ISO 7589 photoflood from 350 to 690 nm, continued to 830 nm by the Planckian radiator that fits its "
        "500 to 690 nm in least squares of logarithms"
    ),
}
_ISO_7589 = {"projector-halogen": "studio-tungsten", "photoflood": "photoflood"}


def _tabled(group: str) -> tuple[str, ...]:
    return tuple(name.partition("/")[2] for name in tables.table_names(group))


def _unknown(what: str, name: str, known: tuple[str, ...]) -> InvalidParameterError:
    near = difflib.get_close_matches(str(name), known, n=4, cutoff=0.5) or [*known[:6], "..."]
    return InvalidParameterError(
        f"{what} must be one of the library's {len(known)}, but is {name!r}; near: {', '.join(near)}"
    )


@lru_cache(maxsize=1)
def illuminant_names() -> tuple[str, ...]:
    """List the lamps of the library.

    Returns
    -------
    tuple of str
        Standard illuminants first, then the fluorescent, discharge and LED series, then other lamps.

    Raises
    ------
    None.

    References
    ----------
    CIE 15:2018; ISO 7589:2002; the others in ``data/colorimetry.json``.
    """
    tabled = _tabled("illuminant")
    first = ("D65", "D50", "D55", "D75", "A", "E", "projector-halogen", "photoflood")
    return first + tuple(name for name in tabled if name not in first)


@lru_cache(maxsize=128)
def illuminant(name: str) -> Spectrum:
    """Fetch a lamp by name.

    Parameters
    ----------
    name : str
        One of :func:`illuminant_names`, such as "D65", "FL2", "LED-B3" or "projector-halogen".

    Returns
    -------
    Spectrum
        Relative spectral power, linear between its samples; the scale is the table's.

    Raises
    ------
    InvalidParameterError
        If there is no such lamp; the message offers names that are near.

    References
    ----------
    See :func:`source_of`.
    """
    if name == "A":
        wavelengths = np.arange(300.0, 831.0)
        c2_over_t = 1.435e7 / 2848.0  # the constants of the definition, which are not those of today's Planck law
        ratio = np.expm1(c2_over_t / 560.0) / np.expm1(c2_over_t / wavelengths)
        return Spectrum(wavelengths, 100.0 * (560.0 / wavelengths) ** 5 * ratio, name)
    if name == "E":
        return Spectrum.constant(1.0, name)
    if name in _ISO_7589:
        return _continued_by_planck(*tables.table(f"iso7589/{_ISO_7589[name]}"), name)
    if name not in illuminant_names():
        raise _unknown("illuminant", name, illuminant_names())
    return Spectrum(*tables.table(f"illuminant/{name}"), name)


def _continued_by_planck(wavelengths: NDArray[np.float64], values: NDArray[np.float64], name: str) -> Spectrum:
    """Continue an incandescent lamp to 830 nm with the Planckian that fits its long-wave half."""
    fitted = (wavelengths >= 500.0) & (wavelengths <= 690.0)

    def misfit(temperature: float) -> float:
        model = blackbody(temperature).at(wavelengths[fitted])
        difference = np.log(values[fitted] / model)
        return float(np.sum((difference - difference.mean()) ** 2))

    # Golden section: the misfit has one minimum over the temperatures that tungsten can have.
    low, high = 2000.0, 4000.0
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    while high - low > 0.01:
        left, right = high - golden * (high - low), low + golden * (high - low)
        if misfit(left) < misfit(right):
            high = right
        else:
            low = left
    planck = blackbody(0.5 * (low + high))
    scale = np.exp(np.mean(np.log(values[fitted] / planck.at(wavelengths[fitted]))))
    tail = np.arange(700.0, 831.0, 10.0)
    return Spectrum(np.concatenate([wavelengths, tail]), np.concatenate([values, scale * planck.at(tail)]), name)


@lru_cache(maxsize=1)
def reflectance_names() -> tuple[str, ...]:
    """List the reflectances of the library.

    Returns
    -------
    tuple of str
        Materials by formula (plastics, paints, cloths, papers, prints) first, then the 24 ColorChecker patches, then
        the Munsell papers of CIE 13.3.

    Raises
    ------
    None.

    References
    ----------
    See :func:`source_of`.
    """
    return tuple(SYNTHETIC_REFLECTANCES) + _tabled("reflectance") + tuple(_TEST_COLOURS)


@lru_cache(maxsize=128)
def reflectance(name: str) -> Spectrum:
    """Fetch a reflectance by name.

    Parameters
    ----------
    name : str
        One of :func:`reflectance_names`, such as "plastic blue" or "dark skin".

    Returns
    -------
    Spectrum
        Reflectance, 0 to 1. Measured ones are read by cubic Lagrange interpolation between their 5 nm samples.

    Raises
    ------
    InvalidParameterError
        If there is no such reflectance; the message offers names that are near.

    References
    ----------
    See :func:`source_of`.
    """
    if name in SYNTHETIC_REFLECTANCES:
        return SYNTHETIC_REFLECTANCES[name].spectrum(name)
    if name in _TEST_COLOURS:
        return Spectrum(*tables.table(f"test_colour/{_TEST_COLOURS[name]}"), name, "lagrange")
    if name not in reflectance_names():
        raise _unknown("reflectance", name, reflectance_names())
    return Spectrum(*tables.table(f"reflectance/{name}"), name, "lagrange")


@lru_cache(maxsize=1)
def metal_names() -> tuple[str, ...]:
    """List the metals of the library.

    Returns
    -------
    tuple of str
        "copper", "brass-70-30", "gold", ...; a suffix such as "copper-johnson" names another measurement.

    Raises
    ------
    None.

    References
    ----------
    See :func:`source_of`.
    """
    return _tabled("metal")


@lru_cache(maxsize=32)
def optical_constants(metal: str) -> OpticalConstants:
    """Fetch the optical constants of a metal.

    Parameters
    ----------
    metal : str
        One of :func:`metal_names`.

    Returns
    -------
    OpticalConstants
        n and k with their source and the sample they were measured on.

    Raises
    ------
    InvalidParameterError
        If there is no such metal; the message offers names that are near.

    References
    ----------
    refractiveindex.info database (CC0 1.0); see :func:`source_of`.
    """
    if metal not in metal_names():
        raise _unknown("metal", metal, metal_names())
    wavelengths, curves = tables.table(f"metal/{metal}")
    entry = _provenance()[f"metal/{metal}"]
    return OpticalConstants(wavelengths, curves[0], curves[1], metal, entry["source"], entry["comment"])


@lru_cache(maxsize=1)
def _provenance() -> dict[str, dict[str, Any]]:
    entries: dict[str, dict[str, Any]] = {}
    for path in sorted((Path(__file__).parent / "data").glob("*.json")):
        entries.update(json.loads(path.read_text(encoding="utf-8"))["tables"])
    return entries


def source_of(name: str) -> str:
    """Tell where a spectrum of the library comes from.

    Parameters
    ----------
    name : str
        A name of a lamp, a reflectance or a metal.

    Returns
    -------
    str
        The source; it begins with "synthetic" for curves made by formula.

    Raises
    ------
    InvalidParameterError
        If the library has nothing by that name.

    References
    ----------
    Own design.
    """
    if name in _MADE_HERE:
        return _MADE_HERE[name]
    if name in SYNTHETIC_REFLECTANCES:
        return f"synthetic (smooth curve by formula, not a measurement): {SYNTHETIC_REFLECTANCES[name].about}"
    stored = _TEST_COLOURS.get(name, name)
    for group in ("illuminant", "reflectance", "test_colour", "metal"):
        entry = _provenance().get(f"{group}/{stored}")
        if entry is not None:
            return str(entry["source"])
    raise _unknown("name", name, illuminant_names() + reflectance_names() + metal_names())
