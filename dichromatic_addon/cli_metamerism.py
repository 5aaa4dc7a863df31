"""``dichromatic metamerism RENDER.npz D65 A -o map.png``: how far each pixel's colour moves between two lamps."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from . import cli_spectra
from ._core import core

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    parser.add_argument("render", metavar="RENDER.npz", type=Path, help="a render kept by 'dichromatic render --film'")
    parser.add_argument("first", metavar="LAMP", help=cli_spectra.HELP)
    parser.add_argument("second", metavar="LAMP", help="the other lamp")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="OUT", help="a .png map, or an .exr with Delta E in a channel"
    )
    parser.add_argument("--largest", type=float, default=10.0, metavar="DE", help="Delta E drawn white (default: 10)")
    parser.add_argument("--only", action="append", metavar="LIGHT", help="change only this light (may be repeated)")


def run(arguments: argparse.Namespace) -> int:
    """Print the figures and write the map; raise a DichromaticError where that is not possible."""
    render, development = core.open_render(arguments.render)
    first, second = cli_spectra.lamp(arguments.first), cli_spectra.lamp(arguments.second)
    found = core.metamerism_map(render, first, second, development, arguments.only)
    print(found.describe())
    if arguments.output is not None:
        if arguments.output.suffix.lower() == ".exr":
            core.write_image(arguments.output, found.delta_e[..., None].astype(np.float32), channels=["deltaE2000"])
        else:
            core.write_image(arguments.output, found.picture(arguments.largest).astype(np.float32))
        print(f"{arguments.output} written")
    return 0
