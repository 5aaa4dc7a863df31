"""How long a user waits, measured in Blender's window: ESC until a render ends, a move or an edit until it is seen.

    python -m tests.ui.latencies

The Blender is that of `make test-ui`. A second column gives the time that Blender's main thread was at work, which
tells the wait on a machine that has nothing else to do.
"""

from __future__ import annotations

import statistics

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
    report = play("rendering", "cancel", size=(1000, 620), seconds=900.0, simulates=False).report
    for name, seconds in report["cancel_s"].items():
        parts = report["cancel_parts_s"][name]
        _print(f"ESC, {name}", [seconds])
        _print("  from when Blender noticed it", [parts["engine ended"] - parts["noticed"]])
    return 0


def _print(name: str, seconds: list[float], busy: list[float] | None = None) -> None:
    wanted = next((f"{limit:.2f}" for start, limit in WANTED.items() if name.startswith(start)), "")
    at_work = f"{statistics.median(busy):8.3f}" if busy else " " * 8
    print(f"{name:32} {statistics.median(seconds):8.3f} {at_work}  {wanted}".rstrip())


if __name__ == "__main__":
    raise SystemExit(main())
