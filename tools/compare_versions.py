"""Compare the pictures that the add-on's tests left for each version of Blender; the last step of `make test-matrix`.

    python -m tools.compare_versions FOLDER NUMBER_OF_VERSIONS

Pictures are compared as a display shows them: linear values are clipped and encoded for sRGB.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.tolerances import PICTURE_BETWEEN_VERSIONS


def encode(linear: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the values that an sRGB display gets (IEC 61966-2-1)."""
    clipped = np.clip(linear.astype(np.float64), 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def main(folder: str, expected: int) -> int:
    """Print the largest difference of each pair; 1 when one is not below the tolerance or a picture is missing."""
    pictures = {file.stem: encode(np.load(file)) for file in sorted(Path(folder).glob("cups-*.npy"))}
    if len(pictures) != expected or expected < 2:
        print(f"{folder}: pictures of {sorted(pictures)}, where {expected} are to be compared", file=sys.stderr)
        return 1
    worst = 0.0
    for (one, first), (other, second) in itertools.combinations(pictures.items(), 2):
        difference = float(np.abs(first - second).max())
        worst = max(worst, difference)
        print(f"{one} and {other}: largest difference {255 * difference:.4f} / 255")
    if not worst < PICTURE_BETWEEN_VERSIONS:
        print("The versions do not show the same picture.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    raise SystemExit(main(sys.argv[1], int(sys.argv[2])))
