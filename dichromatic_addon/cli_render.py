"""``dichromatic render FILE.blend -o OUT.png``: a picture from a .blend file, without a window.

The picture is colorimetric: tristimulus values, adapted to the display's white, its primaries and its transfer curve.
Blender's view transform (AgX and others) belongs to F12 and is not applied; the scene's exposure is.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ._core import core
from .cli_scene import (
    DISPLAY_HELP,
    add_scene_arguments,
    adjustment,
    blender_module,
    development_of,
    display_of,
    open_scene,
    view_layer_name,
)
from .progress_bar import ProgressBar

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    add_scene_arguments(parser)
    parser.add_argument(
        "-o", "--output", type=_output, required=True, metavar="OUT", help="a .png or .exr file to write"
    )
    parser.add_argument(
        "--film", type=Path, metavar="RENDER.npz", help="keep the render too, for relight, lamps, metamerism and probe"
    )
    parser.add_argument("--display", default="srgb", metavar="NAME", help=f"{DISPLAY_HELP} (default: srgb)")
    parser.add_argument(
        "--gamut",
        choices=core.GAMUT_METHODS,
        default="clip",
        help="what a PNG does with colours that the display cannot show (default: clip)",
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")


def run(arguments: argparse.Namespace) -> int:
    """Render and write; raise a DichromaticError with the reason where that is not possible."""
    started = time.monotonic()
    for target in (arguments.output, arguments.film):
        if target is not None and not target.parent.is_dir():
            raise core.DichromaticError(f"the folder {target.parent} of the output does not exist")
    display_of(arguments.display)  # a name that is wrong should be said before the render
    bpy = blender_module(arguments)
    from . import operators  # only now: it needs Blender

    with operators.addon_registered():
        scene = open_scene(bpy, arguments)
        bar = ProgressBar(sys.stderr)
        progress = _ignore if arguments.quiet else bar.update
        try:
            finished = operators.render_layers(
                scene, layer=view_layer_name(scene, arguments.layer), progress=progress, adjust=adjustment(arguments)
            )[0]
        finally:
            bar.close()
        notes = _write(arguments, finished, 2.0**scene.view_settings.exposure)
        if arguments.film is not None:
            made = replace(development_of(scene), shown=display_of(arguments.display), gamut=arguments.gamut)
            core.save_render(arguments.film, finished.render, made)
        if not arguments.quiet:
            print(finished.render.statistics.describe())
            for note in notes:
                print(f"note: {note}")
            print(f"{arguments.output} written after {time.monotonic() - started:.1f} s")
    return 0


def _ignore(fraction: float, message: str) -> None:
    """Stand in for a progress bar; with a listener in place, Blender's own status lines are not printed."""


def _output(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in core.IMAGE_SUFFIXES:
        raise argparse.ArgumentTypeError(f"must end in {' or '.join(core.IMAGE_SUFFIXES)}, but is {text!r}")
    return path


def _write(arguments: argparse.Namespace, finished: Any, exposure: float) -> list[str]:
    """Write the picture; return what happened to colours that the display cannot show."""
    path, exported = arguments.output, finished.exported
    xyz = exported.colour.adapted(finished.render.tristimulus().astype(np.float64))
    if path.suffix.lower() == ".exr":
        shown, notes = core.display("srgb"), []
        pixels = shown.linear(xyz)  # linear Rec.709, as EXR readers assume
    else:
        shown = display_of(arguments.display)
        mapping = core.fit_to_gamut(shown.linear(xyz * exposure), shown, arguments.gamut)
        pixels, notes = shown.encode(mapping.linear_rgb), [mapping.describe()]
    if exported.is_transparent:
        pixels = np.concatenate([pixels, finished.render.alpha[..., None]], axis=2)
    try:
        core.write_image(path, pixels.astype(np.float32))
    except core.MissingDependencyError:  # Blender 4.2 and 4.3 carry no OpenImageIO: then Blender itself writes
        from .operators import write_image_with_blender

        write_image_with_blender(path, pixels.astype(np.float32))
    return notes
