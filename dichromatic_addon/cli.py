"""The command line: ``dichromatic VERB ...``, and the same verbs as ``blender --command dichromatic VERB ...``.

Verbs are modules, named in `VERBS` and imported only when they are asked for: each has `add_arguments(parser)` and
`run(arguments) -> int`. Blender is imported by the verbs that need it, so that the others and ``--help`` start at once.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ._core import core

__all__ = ["CLASSES", "VERBS", "Verb", "main", "parse_arguments", "register", "unregister"]

CLASSES = ()
EXIT_FAILURE = 1
EXIT_USAGE = 2
EXIT_CANCELLED = 130  # what shells report after Ctrl-C


@dataclass(frozen=True, slots=True)
class Verb:
    """A sub-command.

    Attributes
    ----------
    name : str
        What is typed.
    module : str
        Module of this package with `add_arguments(parser)` and `run(arguments) -> int`.
    summary : str
        One line for ``--help``.
    """

    name: str
    module: str
    summary: str


VERBS: tuple[Verb, ...] = (
    Verb("render", "cli_render", "render a .blend file to a PNG or EXR picture"),
    Verb("plan", "cli_plan", "say what a .blend file requires, without rendering it"),
    Verb("tradeoff", "cli_tradeoff", "measure what accuracy costs in a .blend file"),
    Verb("relight", "cli_relight", "change lamps, paints or the display of a kept render, without tracing"),
    Verb("lamps", "cli_lamps", "show a kept render under a list of lamps, side by side"),
    Verb("metamerism", "cli_metamerism", "measure how colours move between two lamps, pixel by pixel"),
    Verb("probe", "cli_probe", "take the spectrum of one pixel of a kept render apart"),
    Verb("convert", "cli_convert", "turn the materials of a Cycles scene into dichromatic ones, for good"),
    Verb("fit", "cli_fit", "fit a material to spectra measured at several geometries"),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process when left out.

    Returns
    -------
    int
        0 on success, 1 on failure, 2 when the arguments are wrong, 130 when it was interrupted. The reason of a failure
        is printed to the standard error.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        options = parse_arguments(arguments)
    except SystemExit as end:  # argparse has printed its help or its complaint
        return int(end.code or 0)
    try:
        return int(_module(options.verb).run(options))
    except KeyboardInterrupt:
        print("dichromatic: interrupted, nothing was written", file=sys.stderr)
        return EXIT_CANCELLED
    except core.RenderCancelledError:
        print("dichromatic: cancelled, nothing was written", file=sys.stderr)
        return EXIT_CANCELLED
    except MemoryError as error:
        print(f"dichromatic: not enough memory: {error or 'ask for a smaller picture'}", file=sys.stderr)
        return EXIT_FAILURE
    except (core.DichromaticError, OSError) as error:
        print(f"dichromatic: {error}", file=sys.stderr)
        return EXIT_FAILURE


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    """Read the words behind the program's name; argparse ends with SystemExit where they are wrong, or ask for help."""
    parser = argparse.ArgumentParser(
        prog="dichromatic", description="Spectral rendering with the dichromatic reflection models."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    asked = next((word for word in arguments if not word.startswith("-")), None)
    for verb in VERBS:
        sub = verbs.add_parser(verb.name, help=verb.summary, description=f"{verb.summary.capitalize()}.")
        if verb.name == asked:  # the others need not be imported to be listed
            _module(verb.name).add_arguments(sub)
    return parser.parse_args(arguments)


def _module(name: str) -> Any:
    verb = next(verb for verb in VERBS if verb.name == name)
    return importlib.import_module(f".{verb.module}", __package__)


_handles: list[Any] = []


def register() -> None:
    """Offer the verbs as ``blender --command dichromatic``."""
    import bpy

    _handles.append(bpy.utils.register_cli_command("dichromatic", main))


def unregister() -> None:
    """Take the command out of Blender again."""
    import bpy

    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
