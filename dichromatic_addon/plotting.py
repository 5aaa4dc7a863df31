"""The door to matplotlib, which is optional: figures without a window, and files that appear whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ._core import core

__all__ = ["PLOT_SUFFIXES", "new_figure", "require_plot", "save_figure"]

PLOT_SUFFIXES = (".png", ".svg", ".pdf")
_DOTS_PER_INCH = 120


def require_plot(path: Path | None) -> None:
    """Find out whether a plot can be drawn before minutes are spent on what it shows.

    Parameters
    ----------
    path : Path or None
        Where it will be saved; None: nowhere, and nothing is asked.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    InvalidParameterError
        If the file's suffix is none of those that can be drawn, or its folder does not exist.
    """
    if path is None:
        return
    new_figure(path, (1.0, 1.0))
    if not path.parent.is_dir():
        raise core.InvalidParameterError(f"the folder {path.parent} of the plot does not exist")


def new_figure(path: Path, size_inches: tuple[float, float]) -> Any:
    """Make an empty figure for a file.

    Parameters
    ----------
    path : Path
        Where it will be saved: a .png, .svg or .pdf file.
    size_inches : tuple of float
        Width and height.

    Returns
    -------
    matplotlib.figure.Figure
        With constrained layout.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    InvalidParameterError
        If the file's suffix is none of these.
    """
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise core.InvalidParameterError(f"plot must end in .png, .svg or .pdf, but is {path.name!r}")
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise core.MissingDependencyError(
            "drawing a plot needs matplotlib: pip install matplotlib (or leave --plot out)"
        ) from error
    figure = Figure(figsize=size_inches, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Any, path: Path) -> None:
    """Save a figure; the file is replaced only when everything has been drawn.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    path : Path
        The file.

    Raises
    ------
    DichromaticError
        If the file cannot be written.
    """
    with core.replacing(path) as temporary:
        figure.savefig(temporary, dpi=_DOTS_PER_INCH, format=path.suffix[1:].lower())
