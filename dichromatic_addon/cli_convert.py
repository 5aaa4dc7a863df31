"""``dichromatic convert IN.blend -o OUT.blend``: foreign materials become ours for good, without a window."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ._core import core
from .cli_scene import blender_module

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    parser.add_argument("blend", metavar="IN.blend", type=Path, help="the scene, made for Cycles or EEVEE")
    parser.add_argument(
        "-o", "--output", type=_output, required=True, metavar="OUT.blend", help="the file to write; IN itself will do"
    )
    parser.add_argument("--keep-engine", action="store_true", help="leave the scenes' render engine as it is")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")


def run(arguments: argparse.Namespace) -> int:
    """Convert and write; raise a DichromaticError with the reason where that is not possible."""
    if not arguments.output.parent.is_dir():
        raise core.DichromaticError(f"the folder {arguments.output.parent} of the output does not exist")
    bpy = blender_module(arguments)
    from . import conversion, operators
    from .names import ENGINE_ID

    with operators.addon_registered():
        try:
            bpy.ops.wm.open_mainfile(filepath=os.path.abspath(arguments.blend), load_ui=False)
        except RuntimeError as error:
            raise core.SceneError(f"{arguments.blend} cannot be opened: {str(error).strip()}") from error
        count, lines = conversion.convert_all(bpy.data.materials)
        conversion.write_report(f"{count} materials were converted", lines)
        if not arguments.keep_engine:
            for scene in bpy.data.scenes:
                scene.render.engine = ENGINE_ID
        try:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(arguments.output), copy=True, relative_remap=True)
        except RuntimeError as error:
            raise core.SceneError(f"{arguments.output} cannot be written: {str(error).strip()}") from error
        if not arguments.quiet:
            print("\n".join([*lines, f"{count} materials were converted; {arguments.output} written"]))
    return 0


def _output(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() != ".blend":
        raise argparse.ArgumentTypeError(f"must end in .blend, but is {text!r}")
    return path
