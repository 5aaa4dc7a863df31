"""``dichromatic lamps RENDER.npz D65 A FL11 -o sheet.png``: one kept render under a list of lamps."""

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
    parser.add_argument("lamps", nargs="+", metavar="LAMP", help=cli_spectra.HELP)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.png", help="the picture to write")
    parser.add_argument("--columns", type=int, metavar="N", help="pictures in a row")
    parser.add_argument(
        "--adapt", action="store_true", help="adapt each picture to its own lamp, as an eye that has lived in it"
    )
    parser.add_argument("--only", action="append", metavar="LIGHT", help="change only this light (may be repeated)")


def run(arguments: argparse.Namespace) -> int:
    """Write the sheet; raise a DichromaticError with the reason where that is not possible."""
    render, development = core.open_render(arguments.render)
    lamps = [cli_spectra.lamp(text) for text in arguments.lamps]
    sheet = core.contact_sheet(
        render, lamps, development, columns=arguments.columns, adapt=arguments.adapt, lights=arguments.only
    )
    core.write_image(arguments.output, sheet.picture.astype(np.float32))
    for start in range(0, len(sheet.names), sheet.columns):
        print("  ".join(sheet.names[start : start + sheet.columns]))
    print(f"{arguments.output} written")
    return 0
