"""The example of the README does what the README says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

README = Path(__file__).resolve().parents[2] / "README.md"


def test_library_example_makes_two_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    oiio = pytest.importorskip("OpenImageIO")
    (example,) = re.findall(r"^```python\n(.*?)^```", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(compile(example, str(README), "exec"), {})
    halogen, tube = (oiio.ImageBuf(f"{name}.png").get_pixels(oiio.FLOAT) for name in ("halogen", "tube"))
    assert halogen.shape == tube.shape == (480, 480, 3)
    centre = (slice(200, 280), slice(200, 280))
    for picture in (halogen, tube):
        red, _, blue = picture[centre].mean(axis=(0, 1))
        assert blue > red  # the plastic is blue under either lamp
        assert np.ptp(picture) > 0.5  # with a highlight
    # A halogen lamp has the lesser share of blue.
    assert np.divide(*halogen.mean(axis=(0, 1))[[0, 2]]) > np.divide(*tube.mean(axis=(0, 1))[[0, 2]])
