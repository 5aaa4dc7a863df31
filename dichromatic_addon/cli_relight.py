"""``dichromatic relight RENDER.npz --light Key=FL11 -o OUT.png``: other lamps or paints in a kept render, at once."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from . import cli_spectra
from ._core import core
from .cli_scene import DISPLAY_HELP, display_of

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    parser.add_argument("render", metavar="RENDER.npz", type=Path, help="a render kept by 'dichromatic render --film'")
    parser.add_argument(
        "--light", action="append", default=[], metavar="NAME=LAMP", help=f"new spectrum of a light: {cli_spectra.HELP}"
    )
    parser.add_argument("--power", action="append", default=[], metavar="NAME=W", help="new strength of a light")
    parser.add_argument(
        "--reflectance",
        action="append",
        default=[],
        metavar="MATERIAL:COMPONENT=SPECTRUM",
        help="new body, interface or normal reflectance of a material: a name of the library, a metal, or a file",
    )
    parser.add_argument("--observer", choices=core.OBSERVERS, help="observer (default: the render's)")
    parser.add_argument("--display", metavar="NAME", help=f"{DISPLAY_HELP} (default: the render's)")
    parser.add_argument("--gamut", choices=core.GAMUT_METHODS, help="colours out of gamut (default: the render's)")
    parser.add_argument("--exposure", type=float, metavar="STOPS", help="brightness of a PNG (default: the render's)")
    parser.add_argument("--adaptation", choices=core.ADAPTATIONS, help="chromatic adaptation (default: the render's)")
    parser.add_argument("--white", metavar="LAMP", help="lamp that is to look white (default: the render's)")
    parser.add_argument("--list", action="store_true", help="print the lights and reflectances that can be changed")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="OUT", help="a .png or .exr picture, a spectral .exr (--spectral), or .npz"
    )
    parser.add_argument("--spectral", action="store_true", help="write the spectrum of every pixel to the .exr")


def run(arguments: argparse.Namespace) -> int:
    """Relight and write; raise a DichromaticError with the reason where that is not possible."""
    render, development = core.open_render(arguments.render)
    if arguments.list:
        print(_describe(render))
    if arguments.output is None:
        if not arguments.list:
            raise core.InvalidParameterError("nothing to do: name a file with -o, or ask for --list")
        return 0
    started = time.perf_counter()
    relit = render.relit(_changed(render.spectra, arguments))
    if arguments.observer:
        relit = replace(relit, observer=arguments.observer)
    made = _developed(development, arguments)
    tristimulus = relit.tristimulus()
    seconds = time.perf_counter() - started
    _write(arguments, relit, tristimulus, made)
    print(f"{arguments.output} written; {relit.film.width} x {relit.film.height} pixels relit in {seconds:.3f} s")
    return 0


def _changed(spectra: core.SceneSpectra, arguments: argparse.Namespace) -> core.SceneSpectra:
    for text in arguments.light:
        name, value = cli_spectra.assignment(text)
        spectra = spectra.with_light(name, illuminant=cli_spectra.lamp(value))
    for text in arguments.power:
        name, value = cli_spectra.assignment(text)
        try:
            strength = float(value)
        except ValueError:
            raise core.InvalidParameterError(f"power of light '{name}' must be a number, but is {value!r}") from None
        spectra = spectra.with_light(name, strength=strength)
    for text in arguments.reflectance:
        slot, value = cli_spectra.assignment(text)
        material, _, component = slot.rpartition(":")
        spectra = spectra.with_reflectance(material, component, cli_spectra.reflectance(value))
    return spectra


def _developed(development: core.Development, arguments: argparse.Namespace) -> core.Development:
    changes: dict[str, Any] = {
        name: getattr(arguments, name)
        for name in ("gamut", "exposure", "adaptation")
        if getattr(arguments, name) is not None
    }
    if arguments.display:
        changes["shown"] = display_of(arguments.display)
    if arguments.white:
        changes["adopted_white"] = cli_spectra.lamp(arguments.white)
    return replace(development, **changes)


def _write(arguments: argparse.Namespace, relit: core.Render, tristimulus: np.ndarray, made: core.Development) -> None:
    suffix = arguments.output.suffix.lower()
    if arguments.spectral:
        core.write_spectral_exr(arguments.output, relit)
    elif suffix == ".npz":
        core.save_render(arguments.output, relit, made)
    elif suffix == ".exr":
        linear = core.display("srgb").linear(made.adapted(tristimulus, relit.observer))
        core.write_image(arguments.output, linear.astype(np.float32))
    else:
        picture, mapping = made.picture(tristimulus, relit.observer)
        core.write_image(arguments.output, picture.astype(np.float32))
        print(f"note: {mapping.describe()}")


def _describe(render: core.Render) -> str:
    lines = ["lights:"]
    lines += [f"  {e.name}  {e.illuminant.name or 'unnamed'}, strength {e.strength:g}" for e in render.spectra.emitters]
    lines.append("reflectances:")
    lines += [
        f"  {s.material}:{s.component}  {s.reflectance.name or 'unnamed'}"
        for s in render.spectra.slots
        if not s.is_unit
    ]
    return "\n".join(lines)
