"""How long a user waits, measured in Blender's window: ESC until a render ends, a move or an edit until it is seen.

    python -m tests.ui.latencies

The Blender is that of `make test-ui`. In the 3D view a second column gives the time that Blender's main thread was at
work, which tells the wait on a machine that has nothing else to do. For ESC the second engine is Cycles on the
processor, in the same window and in turn with ours; the wait is split where Blender, which draws its windows before it
looks at keys, comes round to the key: what is before that is Blender's, what comes after it the engine's.
"""

from __future__ import annotations

import statistics
from typing import Any

from .blender_window import play

__all__ = ["main"]

WANTED = {"ESC": 0.3, "camera move": 0.15}


def main() -> int:
    view = play("viewport", size=(1000, 620), seconds=900.0).report
    print(f"Blender {view['version']}, view of {view['view'][0]} x {view['view'][1]}, {view['triangles']:,} triangles")
    print(f"{'until it is seen':32} {'median':>8} {'at work':>8}  wanted")
    for name, seconds in view["seen_s"].items():
        _print(name, seconds, view["busy_s"][name])
    _print("first picture of a new view", [view["first_s"]])
    _print("longest step between two looks", [view["longest_slice_s"]])
    _print_escape(play("escape", "compare", size=(1000, 620), seconds=1800.0, simulates=False).report)
    return 0


def _print_escape(report: dict[str, Any]) -> None:
    """The waits after ESC, of both engines."""
    print()
    print(f"{'ESC, seconds':40} {'Dichromatic':>17} {'Cycles':>17}  wanted")
    print(f"{'':40} {'median':>8} {'longest':>8} {'median':>8} {'longest':>8}")
    for size, engines in report["escape"].items():
        ours, theirs = engines["DICHROMATIC"], engines["CYCLES"]
        window = "a window of {} x {}".format(*ours[0]["window"])
        rows = {
            f"{size}, {window}": ("ended", ""),
            "  until Blender sees the key": ("seen", ""),
            "  from then until the render has ended": ("ended", "seen"),
        }
        for name, (end, begin) in rows.items():
            found = []
            for waits in (ours, theirs):
                seconds = [wait[end] - (min(wait[begin], wait[end]) if begin else 0.0) for wait in waits]
                found += [statistics.median(seconds), max(seconds)]
            wanted = "" if name.startswith(" ") else f"{WANTED['ESC']:.2f}"
            print(f"{name:40} {' '.join(f'{value:8.3f}' for value in found)}  {wanted}".rstrip())
        drawing = statistics.median(report["drawing"][size])
        print(f"{'  Blender draws, when nothing is rendered':40} {drawing:7.3f}")


def _print(name: str, seconds: list[float], busy: list[float] | None = None) -> None:
    wanted = next((f"{limit:.2f}" for start, limit in WANTED.items() if name.startswith(start)), "")
    at_work = f"{statistics.median(busy):8.3f}" if busy else " " * 8
    print(f"{name:32} {statistics.median(seconds):8.3f} {at_work}  {wanted}".rstrip())


if __name__ == "__main__":
    raise SystemExit(main())
