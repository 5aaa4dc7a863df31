"""``dichromatic plan FILE.blend``: what the scene requires, without rendering it."""

from __future__ import annotations

import argparse

from . import cli_scene
from ._core import core

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    cli_scene.add_scene_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the plan; raise a DichromaticError where that is not possible."""
    with cli_scene.opened_scene(arguments) as (scene, settings, _):
        print(core.make_plan(scene, settings).describe())
    return 0
