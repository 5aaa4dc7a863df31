"""When a window hears of a render, and which rows wait until then."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from dichromatic_addon import window_updates
from dichromatic_addon.window_updates import Pace, WaitingBands

pytestmark = pytest.mark.bpy


class Clock:
    now = 1000.0

    def __call__(self) -> float:
        return self.now


def due_at(pace: Pace, clock: Clock, until: float) -> list[float]:
    """The times, in sixteenths of a second from the first question on, at which an update was due."""
    begun, found = clock.now, []
    while clock.now <= begun + until:
        if pace.is_due():
            found.append(clock.now - begun)
        clock.now += 1.0 / 16.0
    return found


def test_updates_come_soon_at_first_and_later_every_two_seconds() -> None:
    clock = Clock()
    times = due_at(Pace(clock), clock, 40.0)
    assert times[:5] == [0.0, 0.5, 1.0, 1.5, 2.0]
    gaps = np.diff(times)
    assert (gaps[1:] >= gaps[:-1]).all()
    assert set(gaps[-12:]) == {2.0}


def test_a_window_without_a_graphics_card_is_told_more_rarely(monkeypatch: pytest.MonkeyPatch) -> None:
    assert window_updates.window_pace().slowness == 1.0  # no window, nothing to draw
    found = {}
    for kind in ("NVIDIA", "SOFTWARE"):
        monkeypatch.setattr(window_updates, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
        platform = SimpleNamespace(device_type_get=lambda kind=kind: kind)
        monkeypatch.setattr(window_updates, "gpu", SimpleNamespace(platform=platform))
        pace, clock = window_updates.window_pace(), Clock()
        pace.clock = clock
        found[kind] = due_at(pace, clock, 60.0)
    assert found["NVIDIA"][1] == 0.5
    assert found["SOFTWARE"][1] == 1.5
    assert 2.0 * len(found["SOFTWARE"]) < len(found["NVIDIA"])


def test_updates_that_take_long_are_rare() -> None:
    clock = Clock()
    pace = Pace(clock)
    assert pace.is_due()
    clock.now += 0.25
    pace.rest_after(0.25)
    assert due_at(pace, clock, 2.5) == [2.5]
    pace.rest_after(100.0)
    assert due_at(pace, clock, 20.0)[0] == pytest.approx(10.0, abs=1.0 / 16.0)
    pace.rest_after(0.001)  # takes nothing off what was due anyway
    assert not pace.is_due()


def band(first: int, end: int) -> SimpleNamespace:
    return SimpleNamespace(first_row=first, tristimulus=np.zeros((end - first, 1, 3)))


def test_later_bands_take_the_place_of_those_they_cover() -> None:
    waiting = WaitingBands()
    bands = [band(0, 4), band(4, 8), band(3, 6), band(3, 9), band(0, 4)]
    for one in bands:
        waiting.add(one)
    # The second and third lie within the fourth, the first is that of the last.
    assert waiting.take() == [bands[3], bands[4]]
    assert waiting.take() == []
