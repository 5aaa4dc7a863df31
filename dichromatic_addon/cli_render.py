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
from .process_pool import process_pool
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
    parser.add_argument(
        "--processes", type=int, default=0, metavar="N", help="work in so many processes instead of threads"
    )
    parser.add_argument("--display", metavar="NAME", help=f"{DISPLAY_HELP} (default: the file's)")
    parser.add_argument(
        "--gamut",
        choices=core.GAMUT_METHODS,
        help="what a PNG does with colours that the display cannot show (default: the file's)",
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")


def run(arguments: argparse.Namespace) -> int:
    """Render and write; raise a DichromaticError with the reason where that is not possible."""
    started = time.monotonic()
    for target in (arguments.output, arguments.film):
        if target is not None and not target.parent.is_dir():
            raise core.DichromaticError(f"the folder {target.parent} of the output does not exist")
    shown = display_of(arguments.display) if arguments.display else None  # errors are said before the render
    bpy = blender_module(arguments)
    from . import operators  # only now: it needs Blender

    with operators.addon_registered():
        scene = open_scene(bpy, arguments)
        made = _development(scene, shown, arguments.gamut)
        bar = ProgressBar(sys.stderr)
        progress = _ignore if arguments.quiet else bar.update
        try:
            with process_pool(arguments.processes) as pool:
                finished = operators.render_layers(
                    scene,
                    layer=view_layer_name(scene, arguments.layer),
                    progress=progress,
                    adjust=adjustment(arguments),
                    executor=pool,
                )[0]
        finally:
            bar.close()
        _write(arguments.output, finished, made)
        if arguments.film is not None:
            core.save_render(arguments.film, finished.render, made)
        if not arguments.quiet:
            print(finished.render.statistics.describe())
            print(f"{arguments.output} written after {time.monotonic() - started:.1f} s")
    return 0


def _ignore(fraction: float, message: str) -> None:
    """Stand in for a progress bar; with a listener in place, Blender's own status lines are not printed."""


def _output(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in core.IMAGE_SUFFIXES:
        raise argparse.ArgumentTypeError(f"must end in {' or '.join(core.IMAGE_SUFFIXES)}, but is {text!r}")
    return path


def _development(scene: Any, shown: core.Display | None, gamut: str | None) -> core.Development:
    """Return how the picture is made: as the file says, unless the command line says otherwise."""
    if shown is None:
        made = development_of(scene)
    else:  # then the file's own display need not be there
        from .picture import srgb_development

        made = replace(srgb_development(scene), shown=shown, gamut=scene.dichromatic.gamut)
    return made if gamut is None else replace(made, gamut=gamut)


def _write(path: Path, finished: Any, made: core.Development) -> None:
    """Write the picture; the statistics tell what happened to colours that the display cannot show."""
    exported, render = finished.exported, finished.render
    tristimulus = render.tristimulus().astype(np.float64)
    if path.suffix.lower() == ".exr":
        pixels = core.display("srgb").linear(exported.colour.adapted(tristimulus))  # Rec.709, as EXR readers assume
    else:
        pixels, mapping = made.picture(tristimulus, render.observer)
        render.statistics.notes.append(mapping.describe())
    if exported.is_transparent:
        pixels = np.concatenate([pixels, render.alpha[..., None]], axis=2)
    try:
        core.write_image(path, pixels.astype(np.float32))
    except core.MissingDependencyError:  # Blender 4.2 and 4.3 carry no OpenImageIO: then Blender itself writes
        from .operators import write_image_with_blender

        write_image_with_blender(path, pixels.astype(np.float32))
