"""Renders kept with their film: one compressed .npz that opens again without a scene, to be relit and probed."""

from __future__ import annotations

import dataclasses
import json
import os
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .atomic_files import replacing
from .buffers import BUFFERS, SurfaceBuffers
from .development import Development
from .display import Display
from .errors import DichromaticError, InvalidParameterError
from .film import Film, FilmBlock
from .renderer import Render
from .scene_spectra import Emitter, ReflectanceSlot, SceneSpectra, Term
from .spectra import Spectrum
from .statistics import RenderStatistics

__all__ = ["FORMAT_VERSION", "open_render", "save_render"]

FORMAT_VERSION = 2
_FORMAT = "dichromatic-render"


def save_render(path: str | os.PathLike[str], render: Render, development: Development | None = None) -> None:
    """Write a render with its film and spectra.

    Parameters
    ----------
    path : path-like
        Ends in ".npz"; an existing file is replaced only when the new one is complete.
    render : Render
        What to keep.
    development : Development, optional
        How its picture is made.

    Raises
    ------
    InvalidParameterError
        If the suffix is another.
    DichromaticError
        If the file cannot be written.

    References
    ----------
    Own design.
    """
    target = Path(path)
    if target.suffix.lower() != ".npz":
        raise InvalidParameterError(f"a render is kept in a file that ends in .npz, but the name is {target.name}")
    development = development or Development()
    arrays: dict[str, NDArray[Any]] = {"coverage": render.film.coverage}
    arrays |= {f"buffer_{name}": getattr(render.buffers, name) for name in render.buffers.names}
    if render.film.fixed_tristimulus is not None:
        arrays["fixed_tristimulus"] = render.film.fixed_tristimulus
    arrays |= {f"fixed_{number}": image for number, image in enumerate(render.film.fixed_parts.values())}
    arrays |= {f"plane_{name}": plane for name, plane in render.film.planes.items()}
    blocks = []
    for number, block in enumerate(render.film.blocks):
        arrays[f"pixels_{number}"] = block.pixels
        arrays[f"coefficients_{number}"] = block.coefficients
        blocks.append([[term.emitter, *term.slots] for term in block.terms])
    store = _SpectrumStore(arrays)
    header = {
        "format": _FORMAT,
        "version": FORMAT_VERSION,
        "width": render.film.width,
        "height": render.film.height,
        "observer": render.observer,
        "grid": render.grid,
        "blocks": blocks,
        "fixed_parts": [list(label) for label in render.film.fixed_parts],
        "planes": list(render.film.planes),
        "emitters": [
            {"name": e.name, "illuminant": store.add(e.illuminant), "strength": e.strength, "kind": e.kind}
            for e in render.spectra.emitters
        ],
        "slots": [
            {
                "material": s.material,
                "component": s.component,
                "reflectance": store.add(s.reflectance),
                "is_unit": s.is_unit,
            }
            for s in render.spectra.slots
        ],
        "development": {
            "display": _store_display(development.shown, arrays),
            "adopted_white": store.add(development.adopted_white),
            "adaptation": development.adaptation,
            "exposure": development.exposure,
            "gamut": development.gamut,
        },
        "statistics": dataclasses.asdict(render.statistics),
    }
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    with replacing(target) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def _store_display(shown: Display, arrays: dict[str, NDArray[Any]]) -> dict[str, str]:
    arrays["display_matrix"] = shown.to_tristimulus
    if shown.drive_table is not None and shown.light_table is not None:
        arrays["display_drive"], arrays["display_light"] = shown.drive_table, shown.light_table
    return {"name": shown.name, "transfer": shown.transfer}


class _SpectrumStore:
    """Puts each distinct spectrum into the archive once."""

    def __init__(self, arrays: dict[str, NDArray[Any]]) -> None:
        self._arrays = arrays
        self._numbers: dict[tuple[bytes, str], int] = {}

    def add(self, spectrum: Spectrum) -> dict[str, Any]:
        key = (spectrum.key, spectrum.name)
        if key not in self._numbers:
            number = self._numbers[key] = len(self._numbers)
            self._arrays[f"spectrum_{number}"] = np.stack([spectrum.wavelengths_nm, spectrum.values])
        return {
            "array": f"spectrum_{self._numbers[key]}",
            "name": spectrum.name,
            "interpolation": spectrum.interpolation,
        }


def open_render(path: str | os.PathLike[str]) -> tuple[Render, Development]:
    """Read a render that :func:`save_render` wrote.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    render : Render
        With its film, ready to be relit.
    development : Development
        How its picture is made.

    Raises
    ------
    DichromaticError
        If the file cannot be read, is no such render, is damaged, or is of a later version.

    References
    ----------
    Own design.
    """
    arrays = _read_arrays(path)
    try:
        header = json.loads(arrays["header"].tobytes())
    except (KeyError, ValueError) as error:
        raise DichromaticError(f"{path} is no render of this program: it has no header") from error
    if not isinstance(header, dict) or header.get("format") != _FORMAT:
        raise DichromaticError(f"{path} is no render of this program: its header is another format's")
    if header.get("version") != FORMAT_VERSION:
        raise DichromaticError(
            f"{path} has version {header.get('version')!r} of the format; this program reads version {FORMAT_VERSION}"
        )
    try:
        return _build(header, arrays)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise DichromaticError(f"{path} is damaged: {error}") from error


def _read_arrays(path: str | os.PathLike[str]) -> dict[str, NDArray[Any]]:
    # A damaged archive may also name a compression or an encryption that zipfile does not know, or an array whose
    # description numpy cannot parse.
    failures = (
        OSError,
        ValueError,
        EOFError,
        SyntaxError,
        tokenize.TokenError,
        zipfile.BadZipFile,
        zlib.error,
        NotImplementedError,
        RuntimeError,
    )
    try:
        with open(path, "rb") as file:  # numpy leaves the file open when the archive is broken
            archive = np.load(file, allow_pickle=False)
            if isinstance(archive, np.ndarray):
                raise ValueError("it holds a single array")
            with archive:
                return {name: archive[name] for name in archive.files}
    except failures as error:
        raise DichromaticError(f"{path} cannot be read as a render: {error}") from error


def _check_film(film: Film, buffers: SurfaceBuffers, spectra: SceneSpectra) -> None:
    """Raise where the arrays of a film do not fit each other, so that no colour is computed from them."""
    size = film.width * film.height
    shape = (film.height, film.width)
    if film.coverage.shape != shape:
        raise InvalidParameterError(f"coverage must have the shape {shape}")
    for name in buffers.names:
        wanted = (*shape, 3) if name in ("normal", "position") else shape
        if getattr(buffers, name).shape != wanted:
            raise InvalidParameterError(f"{name} must have the shape {wanted}")
    if film.fixed_tristimulus is not None and film.fixed_tristimulus.shape != (*shape, 3):
        raise InvalidParameterError(f"fixed_tristimulus must have the shape {(*shape, 3)}")
    for name, plane in film.planes.items():
        if plane.shape != shape:
            raise InvalidParameterError(f"{name} must have the shape {shape}")
    for (component, emitter), image in film.fixed_parts.items():
        if image.shape != (*shape, 3):
            raise InvalidParameterError(f"the {component} of emitter {emitter} must have the shape {(*shape, 3)}")
        if not 0 <= emitter < len(spectra.emitters):
            raise InvalidParameterError(f"a part of the light names emitter {emitter}, which is not there")
    for number, block in enumerate(film.blocks):
        if block.coefficients.shape != (len(block.pixels), len(block.terms)):
            raise InvalidParameterError(f"block {number} must have a row a pixel and a column a term")
        pixels = block.pixels
        if len(pixels) and (pixels[0] < 0 or pixels[-1] >= size or np.any(pixels[1:] <= pixels[:-1])):
            raise InvalidParameterError(f"the pixels of block {number} must increase from 0 to at most {size - 1}")
        for term in block.terms:
            if not 0 <= term.emitter < len(spectra.emitters):
                raise InvalidParameterError(f"block {number} names emitter {term.emitter}, which is not there")
            if not all(0 <= slot < len(spectra.slots) for slot in term.slots):
                raise InvalidParameterError(f"block {number} names reflectances {term.slots}, not all of them there")


def _build(header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> tuple[Render, Development]:
    def spectrum(entry: dict[str, Any]) -> Spectrum:
        wavelengths_nm, values = arrays[entry["array"]]
        return Spectrum(wavelengths_nm, values, entry["name"], entry["interpolation"])

    blocks = tuple(
        FilmBlock(
            tuple(Term(term[0], tuple(term[1:])) for term in terms),
            arrays[f"pixels_{number}"],
            arrays[f"coefficients_{number}"],
        )
        for number, terms in enumerate(header["blocks"])
    )
    film = Film(
        header["width"],
        header["height"],
        blocks,
        arrays["coverage"],
        arrays.get("fixed_tristimulus"),
        {name: arrays[f"plane_{name}"] for name in header.get("planes", ())},
        {
            (str(component), int(emitter)): arrays[f"fixed_{number}"]
            for number, (component, emitter) in enumerate(header.get("fixed_parts", ()))
        },
    )
    spectra = SceneSpectra(
        tuple(Emitter(e["name"], spectrum(e["illuminant"]), e["strength"], e["kind"]) for e in header["emitters"]),
        tuple(
            ReflectanceSlot(s["material"], s["component"], spectrum(s["reflectance"]), s["is_unit"])
            for s in header["slots"]
        ),
    )
    buffers = SurfaceBuffers(
        **{name: arrays[f"buffer_{name}"] for name in ("depth", *BUFFERS) if f"buffer_{name}" in arrays}
    )
    _check_film(film, buffers, spectra)
    made = header["development"]
    shown = Display(
        made["display"]["name"],
        arrays["display_matrix"],
        made["display"]["transfer"],
        arrays.get("display_drive"),
        arrays.get("display_light"),
    )
    development = Development(
        shown, spectrum(made["adopted_white"]), made["adaptation"], made["exposure"], made["gamut"]
    )
    statistics = RenderStatistics(**header["statistics"])
    return Render(film, spectra, header["observer"], header["grid"], buffers, statistics), development
