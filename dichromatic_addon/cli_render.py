"""``dichromatic render FILE.blend -o OUT.png``: a picture from a .blend file, without a window.

The picture is colorimetric: tristimulus values, adapted to the display's white, its primaries and its transfer curve.
Blender's view transform (AgX and others) belongs to F12 and is not applied; the scene's exposure is.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ._core import core
from .progress_bar import ProgressBar

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    parser.add_argument("blend", metavar="FILE.blend", type=Path, help="the scene")
    parser.add_argument(
        "-o", "--output", type=_output, required=True, metavar="OUT", help="a .png or .exr file to write"
    )
    parser.add_argument("--frame", type=int, metavar="N", help="frame to render (default: the file's current frame)")
    parser.add_argument("--size", type=_size, metavar="WxH", help="size in pixels (default: the file's)")
    parser.add_argument("--samples", type=_positive, metavar="N", help="rays a pixel (default: the file's)")
    parser.add_argument("--layer", metavar="NAME", help="view layer (default: the first that is used for rendering)")
    parser.add_argument(
        "--display", choices=core.DISPLAYS, default="srgb", help="display that a PNG is for (default: srgb)"
    )
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
    if not arguments.blend.is_file():
        raise core.SceneError(f"there is no file {arguments.blend}")
    if not arguments.output.parent.is_dir():
        raise core.DichromaticError(f"the folder {arguments.output.parent} of the output does not exist")
    bpy = _blender()
    from . import operators  # only now: it needs Blender

    with operators.addon_registered():
        scene = _open(bpy, arguments)
        bar = ProgressBar(sys.stderr)
        progress = _ignore if arguments.quiet else bar.update
        try:
            finished = operators.render_layers(
                scene, layer=_layer(scene, arguments.layer), progress=progress, adjust=_adjust(arguments)
            )[0]
        finally:
            bar.close()
        notes = _write(arguments, finished, 2.0**scene.view_settings.exposure)
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


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        size = int(width), int(height)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be like 960x540, but is {text!r}") from None
    if not all(4 <= side <= 65536 for side in size):
        raise argparse.ArgumentTypeError(f"sides must lie between 4 and 65536 pixels, but are {text!r}")
    return size


def _positive(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be an integer of at least 1, but is {text!r}")
    return value


def _blender() -> Any:
    try:
        import bpy
    except ImportError as error:
        raise core.MissingDependencyError(
            "rendering a .blend file needs Blender as a Python module: pip install bpy"
        ) from error
    return bpy


def _open(bpy: Any, arguments: argparse.Namespace) -> Any:
    try:
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(arguments.blend), load_ui=False)
    except RuntimeError as error:
        raise core.SceneError(f"{arguments.blend} cannot be opened: {str(error).strip()}") from error
    scene = bpy.context.scene
    if arguments.size is not None:
        scene.render.resolution_x, scene.render.resolution_y = arguments.size
        scene.render.resolution_percentage = 100
    if arguments.frame is not None:
        scene.frame_set(arguments.frame)
    return scene


def _layer(scene: Any, name: str | None) -> str:
    names = [layer.name for layer in scene.view_layers]
    if name is None:
        return next((layer.name for layer in scene.view_layers if layer.use), names[0])
    if name not in names:
        raise core.SceneError(f"scene '{scene.name}' has no view layer '{name}'; it has {', '.join(names)}")
    return name


def _adjust(arguments: argparse.Namespace) -> Any:
    def adjust(settings: Any) -> Any:
        return settings if arguments.samples is None else replace(settings, samples=arguments.samples)

    return adjust


def _write(arguments: argparse.Namespace, finished: Any, exposure: float) -> list[str]:
    """Write the picture; return what happened to colours that the display cannot show."""
    path, exported = arguments.output, finished.exported
    xyz = exported.colour.adapted(finished.render.tristimulus().astype(np.float64))
    if path.suffix.lower() == ".exr":
        shown, notes = core.display("srgb"), []
        pixels = shown.linear(xyz)  # linear Rec.709, as EXR readers assume
    else:
        shown = core.display(arguments.display)
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
