"""A progress bar for terminals; silent where the output is no terminal."""

from __future__ import annotations

import shutil
import time
from typing import TextIO

__all__ = ["ProgressBar", "format_duration"]

_INTERVAL_S = 0.1  # between two drawings: more often is not seen and slows a terminal down


def format_duration(seconds: float) -> str:
    """Write a duration as m:ss, or as h:mm:ss from one hour on."""
    whole = max(int(seconds + 0.5), 0)
    hours, rest = divmod(whole, 3600)
    minutes, second = divmod(rest, 60)
    return f"{hours}:{minutes:02d}:{second:02d}" if hours else f"{minutes}:{second:02d}"


class ProgressBar:
    """One line that is drawn over itself: part done, bar, time used and time left.

    Parameters
    ----------
    stream : text file
        Where to draw; nothing is drawn when it is no terminal.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._visible = stream.isatty()
        self._start = time.monotonic()
        self._last = float("-inf")

    def update(self, fraction: float, message: str = "") -> None:
        """Draw the state: `fraction` from 0 to 1 is done."""
        now = time.monotonic()
        if not self._visible or (now - self._last < _INTERVAL_S and fraction < 1.0):
            return
        self._last = now
        self._stream.write("\r" + self.line(fraction, message, now - self._start) + "\x1b[K")
        self._stream.flush()

    def line(self, fraction: float, message: str, elapsed: float) -> str:
        """Return the text of the line after `elapsed` seconds, no wider than the terminal."""
        fraction = min(max(fraction, 0.0), 1.0)
        columns = shutil.get_terminal_size().columns
        left = f", {format_duration(elapsed * (1.0 - fraction) / fraction)} left" if 0.0 < fraction < 1.0 else ""
        tail = f" {format_duration(elapsed)}{left}  {message}"
        width = max(min(40, columns - len(tail) - 8), 4)
        filled = round(width * fraction)
        return f"{fraction:4.0%} [{'#' * filled}{'.' * (width - filled)}]{tail}"[: columns - 1]

    def close(self) -> None:
        """End the line, so that what is printed next starts on its own."""
        if self._visible and self._last > float("-inf"):
            self._stream.write("\n")
            self._stream.flush()
