"""``dichromatic tradeoff FILE.blend``: what accuracy costs in this scene, as a table, a CSV file and a plot."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import cli_scene
from ._core import core
from .plotting import new_figure, require_plot, save_figure
from .progress_bar import ProgressBar

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    cli_scene.add_scene_arguments(parser)
    parser.add_argument("--csv", type=Path, metavar="OUT.csv", help="write the measurements")
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw error against time (or .svg, .pdf)")


def run(arguments: argparse.Namespace) -> int:
    """Measure, print, write; raise a DichromaticError where that is not possible."""
    require_plot(arguments.plot)
    with cli_scene.opened_scene(arguments) as (scene, settings, development):
        bar = ProgressBar(sys.stderr)
        try:
            found = core.measure_tradeoff(scene, settings, development, progress=bar.update)
        finally:
            bar.close()
    print(f"{found.scene}, {settings.width} x {settings.height}, {settings.samples} samples a pixel; Delta E 2000:")
    print(found.table())
    print(found.advise())
    if arguments.csv is not None:
        with core.replacing(arguments.csv) as temporary:
            temporary.write_text(found.csv(), encoding="utf-8")
        print(f"{arguments.csv} written")
    if arguments.plot is not None:
        _draw(found, arguments.plot)
        print(f"{arguments.plot} written")
    return 0


def _draw(found: core.Tradeoff, path: Path) -> None:
    figure = new_figure(path, (8.0, 5.0))
    axes = figure.add_subplot()
    smallest = min((m.error.mean for m in found.measurements if m.error.mean > 0.0), default=1e-3)
    for axis in dict.fromkeys(m.axis for m in found.measurements):
        those = [m for m in found.measurements if m.axis == axis]
        axes.plot([m.seconds for m in those], [max(m.error.mean, smallest) for m in those], "o", label=axis, alpha=0.8)
    _label(axes, found.measurements, smallest)
    best = sorted((m.seconds, max(m.error.mean, smallest)) for m in found.measurements if m.is_pareto)
    axes.step(*zip(*best, strict=True), where="post", color="black", linewidth=0.8, label="Pareto set")
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks = _round_numbers(*axes.get_xlim())
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("seconds")
    axes.set_ylabel("mean Delta E 2000")
    axes.set_title(f"{found.scene}: error against time")
    axes.legend(fontsize="small", frameon=False)
    save_figure(figure, path)


def _round_numbers(low: float, high: float) -> list[float]:
    """1, 2 and 5 of every decade between two numbers."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [n * 10.0**decade for decade in decades for n in (1, 2, 5) if low <= n * 10.0**decade <= high]


def _label(axes: Any, measurements: Sequence[core.Measurement], smallest: float) -> None:
    """Name the points, the Pareto set first, as far as the names do not cover one another."""
    places = {m: (math.log(m.seconds), math.log(max(m.error.mean, smallest))) for m in measurements}
    spans = [max(max(p[k] for p in places.values()) - min(p[k] for p in places.values()), 1e-9) for k in (0, 1)]
    named: list[tuple[float, float]] = []
    for m in sorted(measurements, key=lambda m: not m.is_pareto):
        x, y = places[m][0] / spans[0], places[m][1] / spans[1]
        if any(abs(x - a) < 0.11 and abs(y - b) < 0.05 for a, b in named):
            continue
        named.append((x, y))
        place = (m.seconds, max(m.error.mean, smallest))
        axes.annotate(f"{m.axis} {m.value}", place, xytext=(5, 4), textcoords="offset points", fontsize="x-small")
