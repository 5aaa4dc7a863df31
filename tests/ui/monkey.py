"""Let a monkey loose on the add-on in Blender's window; anything that Python complains of is a failure.

python -m tests.ui.monkey --minutes 60 --seed 7
"""

from __future__ import annotations

import argparse

from .blender_window import play, python_errors

__all__ = ["main"]


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Random clicks, values, nodes and operators in Blender's window.")
    parser.add_argument("--minutes", type=float, default=10.0, help="how long (default: 10)")
    parser.add_argument("--seed", type=int, default=1, help="the same seed does the same things (default: 1)")
    given = parser.parse_args(argv)
    seconds = 60.0 * given.minutes
    played = play("monkey", str(given.seed), str(seconds), size=(1000, 700), seconds=2.0 * seconds + 300.0)
    done = played.report["done"]
    print(f"{sum(done.values())} actions: {', '.join(f'{count} {name}' for name, count in sorted(done.items()))}")
    wrong = [*played.report.get("wrong", []), *python_errors(played.console)]
    for text in wrong:
        print(text)
    print(f"{len(wrong)} Python errors; what was done stands in {played.folder / 'console.txt'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
