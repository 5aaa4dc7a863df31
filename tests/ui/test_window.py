"""The add-on in a whole Blender: what only a window can tell. `make test-ui` runs these and keeps screenshots."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from .blender_window import NoWindowError, Played, console_errors, play, window_command

pytestmark = pytest.mark.ui


@pytest.fixture(scope="module")
def played() -> Callable[..., Played]:
    """Runs a script of ``inside/`` in a window, and requires that nothing complained in the console."""
    try:
        window_command()
    except NoWindowError as error:
        pytest.skip(f"NOT TESTED IN A WINDOW: {error}")

    def run(script: str, *arguments: str, **how: Any) -> Played:
        result = play(script, *arguments, **how)
        assert console_errors(result.console) == []
        return result

    return run


def test_every_panel_is_drawn_in_every_state(played: Callable[..., Played]) -> None:
    report = played("panels").report
    assert len(report["states"]) > 150
    assert {"DICHROMATIC_PT_material", "DICHROMATIC_PT_light_illuminant", "DICHROMATIC_PT_world"} <= set(
        report["drawn"]
    )


def test_nodes_are_added_linked_undone_saved_and_opened(played: Callable[..., Played]) -> None:
    report = played("nodes").report
    assert {"DichromaticNodePlastic", "DichromaticNodeSpectrum"} <= set(report["nodes"])
    assert report["states"][-1] == "opened again"


def test_rendered_view_is_moved_recoloured_and_edited(played: Callable[..., Played]) -> None:
    report = played("viewport", size=(1000, 620), seconds=600.0).report
    assert 99_000 < report["triangles"] < 101_000
    assert len(report["seen_s"]) == 8
    assert report["preview"]["covered"] > 0.3


def test_f12_and_the_studies_of_the_image_editor(played: Callable[..., Played]) -> None:
    report = played("rendering", simulates=False).report
    assert len(report["states"]) >= 10


def test_escape_ends_renders_that_have_shown_something(played: Callable[..., Played]) -> None:
    report = played("escape", simulates=False, size=(1000, 620)).report
    assert len(report["escape"]) == 3  # each was cancelled before its end, however long that took
    for engines in report["escape"].values():
        (parts,) = engines["DICHROMATIC"]
        assert parts["noticed"] <= parts["engine ended"] <= parts["ended"]
