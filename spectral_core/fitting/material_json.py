"""The file ``material.json``: a material with its provenance, from which the core's material is rebuilt exactly.

The layout is versioned; ``docs/fitting.md`` describes it. Angles are in radians, so that reading back loses no bit.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DichromaticError, InvalidParameterError, SpectrumFileError
from ..reflection import (
    MeanReflectance,
    MeasuredMeanReflectance,
    OpticalMeanReflectance,
    SchlickMeanReflectance,
    TypeI,
    TypeII,
    TypeIII,
)
from ..spectra import Spectrum
from ..textured_reflectance import require_plain
from .material_fit import MaterialFit
from .measurement_files import write_text_atomically
from .uncertainty import Interval

__all__ = [
    "FORMAT",
    "VERSION",
    "MaterialRecord",
    "Provenance",
    "format_material_json",
    "parse_material_json",
    "provenance_of_fit",
    "read_material_json",
    "write_material_json",
]

FORMAT = "dichromatic-material"
"""What the key ``format`` of the file says."""

VERSION = 1
"""The newest version of the layout that this module writes and reads."""


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a material comes from.

    Parameters
    ----------
    source : str
        Name of the data set or file.
    recommended_type : str
        The type that the data showed; empty if none.
    evidence, notes : tuple of str
        Sentences of the tests and of the fit.
    parameters : tuple of Interval
        Fitted numbers with their intervals.
    confidence : float
        Of the intervals; 0 when there are none.
    relative_residual : float
        Root mean squared residual over that of the data.
    """

    source: str = ""
    recommended_type: str = ""
    evidence: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    parameters: tuple[Interval, ...] = ()
    confidence: float = 0.0
    relative_residual: float = 0.0


@dataclass(frozen=True, slots=True)
class MaterialRecord:
    """What a material file holds.

    Parameters
    ----------
    material : TypeI, TypeII or TypeIII
        The core's material.
    name : str
        Name of the material.
    provenance : Provenance
        Where it comes from.
    """

    material: TypeI | TypeII | TypeIII
    name: str
    provenance: Provenance


def provenance_of_fit(fit: MaterialFit, source: str) -> Provenance:
    """Gather the provenance of a fitted material.

    Parameters
    ----------
    fit : MaterialFit
        The fit.
    source : str
        Name of the file that was fitted.

    Returns
    -------
    Provenance
        Evidence, intervals and residual of the fit.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    return Provenance(
        source,
        fit.recommendation.material_type or "",
        fit.recommendation.evidence,
        fit.notes,
        fit.parameters,
        fit.confidence,
        fit.fit.relative_residual,
    )


def _spectrum_to_json(spectrum: Spectrum) -> dict[str, Any]:
    return {
        "name": spectrum.name,
        "interpolation": spectrum.interpolation,
        "wavelengths_nm": spectrum.wavelengths_nm.tolist(),
        "values": spectrum.values.tolist(),
    }


def _mean_to_json(mean: MeanReflectance) -> dict[str, Any]:
    if isinstance(mean, SchlickMeanReflectance):
        return {"kind": "schlick", "normal_mean": mean.normal_mean}
    if isinstance(mean, MeasuredMeanReflectance):
        return {"kind": "table", "incidence_rad": mean.incidence.tolist(), "mean": mean.mean.tolist()}
    if isinstance(mean, OpticalMeanReflectance):
        return {"kind": "optical", "n": mean.n.tolist(), "k": mean.k.tolist()}
    raise InvalidParameterError(f"mean_reflectance of type {type(mean).__name__} cannot be written to a material file")


def _material_to_json(material: TypeI | TypeII | TypeIII) -> dict[str, Any]:
    if isinstance(material, TypeIII):
        return {
            "type": "III",
            "normal_reflectance": _spectrum_to_json(material.normal_reflectance),
            "mean_reflectance": _mean_to_json(material.mean_reflectance),
            "beta_rad": material.beta,
            "beta_across_rad": material.beta_across,
            "incidence": material.incidence,
            "energy_conserving": material.energy_conserving,
        }
    interface: Any = material.interface_reflectance
    if isinstance(material, TypeII):
        interface = _spectrum_to_json(require_plain("interface_reflectance", material.interface_reflectance))
    return {
        "type": "I" if isinstance(material, TypeI) else "II",
        "body_reflectance": _spectrum_to_json(require_plain("body_reflectance", material.body_reflectance)),
        "interface_reflectance": interface,
        "attenuation": material.attenuation,
        "n": material.n,
        "energy_conserving": material.energy_conserving,
    }


def format_material_json(
    material: TypeI | TypeII | TypeIII, name: str = "", provenance: Provenance | None = None
) -> str:
    """Put a material with its provenance into the text of a material file.

    Parameters
    ----------
    material : TypeI, TypeII or TypeIII
        The material.
    name : str, optional
        Name of the material.
    provenance : Provenance, optional
        Where it comes from.

    Returns
    -------
    str
        JSON, from which :func:`parse_material_json` rebuilds the material without loss of a bit.

    Raises
    ------
    InvalidParameterError
        If the material is of another type.

    References
    ----------
    Own design; the layout is described in docs/fitting.md.
    """
    if not isinstance(material, (TypeI, TypeII, TypeIII)):
        raise InvalidParameterError(f"material must be of Type I, II or III, but is {type(material).__name__}")
    origin = provenance or Provenance()
    content = {
        "format": FORMAT,
        "version": VERSION,
        "name": name,
        "material": _material_to_json(material),
        "provenance": {
            "source": origin.source,
            "recommended_type": origin.recommended_type,
            "evidence": list(origin.evidence),
            "notes": list(origin.notes),
            "confidence": origin.confidence,
            "relative_residual": origin.relative_residual,
            "parameters": [
                {"name": p.name, "value": p.value, "low": p.low, "high": p.high, "unit": p.unit}
                for p in origin.parameters
            ],
        },
    }
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def write_material_json(
    path: str | os.PathLike[str],
    material: TypeI | TypeII | TypeIII,
    name: str = "",
    provenance: Provenance | None = None,
) -> None:
    """Write a material with its provenance.

    Parameters
    ----------
    path : path-like
        The file; it is replaced only when everything has been written.
    material : TypeI, TypeII or TypeIII
        The material.
    name : str, optional
        Name of the material.
    provenance : Provenance, optional
        Where it comes from.

    Raises
    ------
    InvalidParameterError
        If the material is of another type.
    DichromaticError
        If the file cannot be written.

    References
    ----------
    Own design; the layout is described in docs/fitting.md.
    """
    write_text_atomically(path, format_material_json(material, name, provenance))


class _Node:
    """An object of the file, read key by key with errors that name the key."""

    def __init__(self, file: str, where: str, content: Any) -> None:
        if not isinstance(content, dict):
            raise SpectrumFileError(f"{file}: {where or 'the file'} must be an object, but is {type(content).__name__}")
        self._file, self._where, self._content = file, where, content

    def _path(self, key: str) -> str:
        return f"{self._where}.{key}" if self._where else key

    def fail(self, key: str, rule: str) -> SpectrumFileError:
        return SpectrumFileError(f"{self._file}: {self._path(key)} {rule}")

    def raw(self, key: str) -> Any:
        if key not in self._content:
            raise self.fail(key, "is missing")
        return self._content[key]

    def child(self, key: str) -> _Node:
        return _Node(self._file, self._path(key), self.raw(key))

    def children(self, key: str) -> list[_Node]:
        value = self.raw(key)
        if not isinstance(value, list):
            raise self.fail(key, f"must be a list, but is {type(value).__name__}")
        return [_Node(self._file, f"{self._path(key)}[{i}]", item) for i, item in enumerate(value)]

    def text(self, key: str) -> str:
        value = self.raw(key)
        if not isinstance(value, str):
            raise self.fail(key, f"must be text, but is {value!r}")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        value = self.raw(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.fail(key, "must be a list of texts")
        return tuple(value)

    def flag(self, key: str) -> bool:
        value = self.raw(key)
        if not isinstance(value, bool):
            raise self.fail(key, f"must be true or false, but is {value!r}")
        return value

    def number(self, key: str) -> float:
        value = self.raw(key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
            raise self.fail(key, f"must be a finite number, but is {value!r}")
        return float(value)

    def numbers(self, key: str) -> list[float]:
        value = self.raw(key)
        if not isinstance(value, list) or any(
            isinstance(v, bool) or not isinstance(v, (int, float)) or not np.isfinite(v) for v in value
        ):
            raise self.fail(key, "must be a list of finite numbers")
        return [float(v) for v in value]

    def is_object(self, key: str) -> bool:
        return isinstance(self.raw(key), dict)


def _spectrum(node: _Node) -> Spectrum:
    return Spectrum(
        np.array(node.numbers("wavelengths_nm")),
        np.array(node.numbers("values")),
        node.text("name"),
        node.text("interpolation"),
    )


def _mean(node: _Node) -> MeanReflectance:
    kind = node.text("kind")
    if kind == "schlick":
        return SchlickMeanReflectance(node.number("normal_mean"))
    if kind == "table":
        return MeasuredMeanReflectance(np.array(node.numbers("incidence_rad")), np.array(node.numbers("mean")))
    if kind == "optical":
        return OpticalMeanReflectance(np.array(node.numbers("n")), np.array(node.numbers("k")))
    raise node.fail("kind", f"must be schlick, table or optical, but is {kind!r}")


def _material(node: _Node) -> TypeI | TypeII | TypeIII:
    name = node.text("type")
    conserving = node.flag("energy_conserving")
    if name == "III":
        across = None if node.raw("beta_across_rad") is None else node.number("beta_across_rad")
        return TypeIII(
            _spectrum(node.child("normal_reflectance")),
            _mean(node.child("mean_reflectance")),
            node.number("beta_rad"),
            across,
            node.text("incidence"),
            conserving,
        )
    if name not in ("I", "II"):
        raise node.fail("type", f"must be I, II or III, but is {name!r}")
    body = _spectrum(node.child("body_reflectance"))
    attenuation, n = node.text("attenuation"), node.number("n")
    if name == "I":
        return TypeI(body, node.number("interface_reflectance"), attenuation, n, conserving)
    return TypeII(body, _spectrum(node.child("interface_reflectance")), attenuation, n, conserving)


def _provenance(node: _Node) -> Provenance:
    parameters = tuple(
        Interval(p.text("name"), p.number("value"), p.number("low"), p.number("high"), p.text("unit"))
        for p in node.children("parameters")
    )
    return Provenance(
        node.text("source"),
        node.text("recommended_type"),
        node.texts("evidence"),
        node.texts("notes"),
        parameters,
        node.number("confidence"),
        node.number("relative_residual"),
    )


def read_material_json(path: str | os.PathLike[str]) -> MaterialRecord:
    """Read a material file.

    Parameters
    ----------
    path : path-like
        A file written by :func:`write_material_json`, or by hand to its layout.

    Returns
    -------
    MaterialRecord
        The core's material, its name, and its provenance.

    Raises
    ------
    SpectrumFileError
        If the file cannot be read, is no material file, is of a newer version, or a key is missing or breaks a rule;
        the message names the file, the key and the rule.

    References
    ----------
    Own design; the layout is described in docs/fitting.md.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise SpectrumFileError(f"{file}: there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SpectrumFileError(f"{file}: cannot be read as JSON ({error})") from error
    return parse_material_json(text, file.name)


def parse_material_json(text: str, source: str = "material") -> MaterialRecord:
    """Rebuild a material from the text of a material file.

    Parameters
    ----------
    text : str
        JSON as :func:`format_material_json` makes it.
    source : str, optional
        Name of the file or place that the text comes from, for the messages.

    Returns
    -------
    MaterialRecord
        The core's material, its name, and its provenance.

    Raises
    ------
    SpectrumFileError
        If the text is no JSON or no material, is of a newer version, or a key is missing or breaks a rule; the message
        names the source, the key and the rule.

    References
    ----------
    Own design; the layout is described in docs/fitting.md.
    """
    try:
        content = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise SpectrumFileError(f"{source}: cannot be read as JSON ({error})") from error
    root = _Node(source, "", content)
    if root.text("format") != FORMAT:
        raise root.fail("format", f"must be {FORMAT!r}, but is {root.text('format')!r}")
    version = root.number("version")
    if not 1 <= version <= VERSION:
        raise root.fail("version", f"must lie between 1 and {VERSION}, but is {version:g}: a newer program wrote it")
    try:
        return MaterialRecord(
            _material(root.child("material")), root.text("name"), _provenance(root.child("provenance"))
        )
    except SpectrumFileError:
        raise
    except DichromaticError as error:
        raise SpectrumFileError(f"{source}: {error}") from error
