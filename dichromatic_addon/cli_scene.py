"""What the verbs that open a .blend file share: its arguments, and the core's scene with how it is shown."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from ._core import core

__all__ = [
    "DISPLAY_HELP",
    "add_scene_arguments",
    "adjustment",
    "blender_module",
    "development_of",
    "display_of",
    "open_scene",
    "opened_scene",
    "view_layer_name",
]

DISPLAY_HELP = f"display that a PNG is for: {', '.join(core.DISPLAYS)}, or the CSV file of a measured monitor"


def add_scene_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the scene, its frame, size and samples."""
    parser.add_argument("blend", metavar="FILE.blend", type=Path, help="the scene")
    parser.add_argument("--frame", type=int, metavar="N", help="frame to render (default: the file's current frame)")
    parser.add_argument("--size", type=_size, metavar="WxH", help="size in pixels (default: the file's)")
    parser.add_argument("--samples", type=_positive, metavar="N", help="rays a pixel (default: the file's)")
    parser.add_argument(
        "--threads", type=_positive, metavar="N", help="threads that work side by side (default: the file's)"
    )
    parser.add_argument(
        "--adaptive",
        type=_threshold,
        metavar="DE",
        help="take further samples only where the first differ by more than this (CIE 1976 Lab; 1 can just be seen)",
    )
    parser.add_argument("--layer", metavar="NAME", help="view layer (default: the first that is used for rendering)")


def display_of(text: str) -> core.Display:
    """Return the display that a word of the command line means: a standard one, or a measured monitor's file."""
    if text in core.DISPLAYS:
        return core.display(text)
    if not Path(text).is_file():
        raise core.InvalidParameterError(
            f"display must be one of {', '.join(core.DISPLAYS)} or the CSV file of a measured monitor, but is {text!r}"
        )
    return core.read_display(text)


def development_of(scene: Any) -> core.Development:
    """Return how the picture of a Blender scene is made: its white, adaptation, exposure, display and gamut method."""
    from . import output_display

    return output_display.output_development(scene)


@contextmanager
def opened_scene(
    arguments: argparse.Namespace,
) -> Iterator[tuple[core.Scene, core.RenderSettings, core.Development]]:
    """Open the file and give the core's scene, its settings and how it is shown.

    Raises
    ------
    DichromaticError
        With the reason, when the file cannot be opened or something in it cannot be rendered.
    """
    bpy = blender_module(arguments)
    from . import operators, scene_export

    with operators.addon_registered():
        scene = open_scene(bpy, arguments)
        layer = scene.view_layers[view_layer_name(scene, arguments.layer)]
        with bpy.context.temp_override(scene=scene, view_layer=layer):
            exported = scene_export.export_scene(bpy.context.evaluated_depsgraph_get())
        yield exported.scene, adjustment(arguments)(exported.settings), development_of(scene)


def blender_module(arguments: argparse.Namespace) -> Any:
    """Return Blender as a module, once it is clear that there is a file to open."""
    if not arguments.blend.is_file():
        raise core.SceneError(f"there is no file {arguments.blend}")
    try:
        import bpy
    except ImportError as error:
        raise core.MissingDependencyError(
            "rendering a .blend file needs Blender as a Python module: pip install bpy"
        ) from error
    return bpy


def open_scene(bpy: Any, arguments: argparse.Namespace) -> Any:
    """Open the file and return its scene at the size and frame that were asked for."""
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


def view_layer_name(scene: Any, name: str | None) -> str:
    """Return the view layer that was asked for, or the first that is used for rendering."""
    names = [layer.name for layer in scene.view_layers]
    if name is None:
        return next((layer.name for layer in scene.view_layers if layer.use), names[0])
    if name not in names:
        raise core.SceneError(f"scene '{scene.name}' has no view layer '{name}'; it has {', '.join(names)}")
    return name


def adjustment(arguments: argparse.Namespace) -> Any:
    """Return what the arguments change in the settings of the file."""

    def adjust(settings: Any) -> Any:
        changes = {"samples": arguments.samples, "threads": arguments.threads, "adaptive_threshold": arguments.adaptive}
        return replace(settings, **{name: value for name, value in changes.items() if value is not None})

    return adjust


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        size = int(width), int(height)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be like 960x540, but is {text!r}") from None
    if not all(4 <= side <= 65536 for side in size):
        raise argparse.ArgumentTypeError(f"sides must lie between 4 and 65536 pixels, but are {text!r}")
    return size


def _threshold(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 100.0:
        raise argparse.ArgumentTypeError(f"must be a number from 0 to 100, but is {text!r}")
    return value


def _positive(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be an integer of at least 1, but is {text!r}")
    return value
