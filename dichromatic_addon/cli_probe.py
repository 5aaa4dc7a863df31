"""``dichromatic probe RENDER.npz X Y``: the spectrum of one pixel of a kept render, split by term."""

from __future__ import annotations

import argparse
from pathlib import Path

from ._core import core
from .plotting import new_figure, save_figure

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    parser.add_argument("render", metavar="RENDER.npz", type=Path, help="a render kept by 'dichromatic render --film'")
    parser.add_argument("column", metavar="X", type=int, help="column of the pixel, from the left, from 0")
    parser.add_argument("row", metavar="Y", type=int, help="row of the pixel, from the top, from 0")
    parser.add_argument("-o", "--output", type=Path, metavar="OUT.csv", help="write wavelengths and spectra")
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the spectrum split by term (or .svg, .pdf)")


def run(arguments: argparse.Namespace) -> int:
    """Print the parts of the pixel; raise a DichromaticError where that is not possible."""
    render, _ = core.open_render(arguments.render)
    probe = core.probe_pixel(render, arguments.column, arguments.row)
    print(probe.describe())
    if arguments.output is not None:
        with core.replacing(arguments.output) as temporary:
            temporary.write_text(probe.csv(), encoding="utf-8")
        print(f"{arguments.output} written")
    if arguments.plot is not None:
        _draw(probe, arguments.plot)
        print(f"{arguments.plot} written")
    return 0


def _draw(probe: core.PixelProbe, path: Path) -> None:
    figure = new_figure(path, (8.0, 4.5))
    axes = figure.add_subplot()
    axes.stackplot(probe.wavelengths_nm, probe.radiance, labels=probe.labels, alpha=0.8)
    axes.plot(probe.wavelengths_nm, probe.radiance.sum(axis=0), color="black", linewidth=1.2, label="total")
    axes.set_xlabel("wavelength (nm)")
    axes.set_ylabel("relative radiance per nm")
    axes.set_title(f"pixel ({probe.column}, {probe.row})")
    axes.margins(x=0.0)
    axes.legend(fontsize="small", frameon=False)
    save_figure(figure, path)
