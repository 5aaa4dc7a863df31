"""When Blender's window hears of a render: soon at first, and less often the longer it takes.

Whatever a render tells, be it a word in the status line, has Blender draw the window with the picture again, and while
it draws it sees no key. So text, progress and rows go together, at the pace of Cycles, and the rows in between wait.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy
import gpu

__all__ = ["Pace", "WaitingBands", "window_pace"]

_SHORTEST_S, _LONGEST_S = 0.5, 2.0  # between two updates; the latter is that of Cycles
_SHARE = 0.25  # of the time that a render has taken so far: the next update after that
_SOFTWARE_SLOWNESS = 3.0  # drawing without a graphics card takes tenths of a second, in the render's own processors
_REST, _LONGEST_REST_S = 10.0, 10.0  # after an update that took long: so many times as long, and no longer than that


@dataclass(slots=True)
class Pace:
    """Says when the next update is due.

    Attributes
    ----------
    clock : callable
        Tells the time in seconds.
    slowness : float
        How many times as long to wait as where drawing costs little.
    """

    clock: Callable[[], float] = time.monotonic
    slowness: float = 1.0
    _begun: float | None = None
    _next: float = 0.0

    def is_due(self) -> bool:
        """Whether an update is due now; then the next is later. The first is due at once."""
        now = self.clock()
        if self._begun is None:
            self._begun = now
        elif now < self._next:
            return False
        wait = min(max(_SHARE * (now - self._begun), _SHORTEST_S), _LONGEST_S)
        self._next = now + self.slowness * wait
        return True

    def rest_after(self, seconds: float) -> None:
        """Put the next update off in proportion to what one has just taken, waiting for Blender's drawing included."""
        self._next = max(self._next, self.clock() + min(_REST * seconds, _LONGEST_REST_S))


def window_pace() -> Pace:
    """Return the pace for Blender's windows as they are drawn here."""
    if bpy.app.background:  # nothing is drawn, and Blender does not say by what it would be
        return Pace()
    is_software = gpu.platform.device_type_get() == "SOFTWARE"
    return Pace(slowness=_SOFTWARE_SLOWNESS if is_software else 1.0)


@dataclass(slots=True)
class WaitingBands:
    """Bands that were not shown yet, in the order in which they came, without those that later ones cover."""

    _bands: list[Any] = field(default_factory=list)

    def add(self, band: Any) -> None:
        """Have a band wait."""
        first, end = band.first_row, band.first_row + len(band.tristimulus)
        self._bands = [
            other for other in self._bands if other.first_row < first or other.first_row + len(other.tristimulus) > end
        ]
        self._bands.append(band)

    def take(self) -> list[Any]:
        """Give the bands that wait; then none does."""
        bands, self._bands = self._bands, []
        return bands
