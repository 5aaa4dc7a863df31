"""The calibrated monitor: a measurement made up from a known monitor must give that monitor back."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from spectral_core.display import display
from spectral_core.display_files import read_display
from spectral_core.errors import SpectrumFileError
from tests.tolerances import FLOAT64_ROUNDING

PRIMARIES = display("srgb").to_tristimulus * 100.0  # cd/m2
DRIVES = np.arange(0, 256, 15)


def measured(gammas=(2.2, 2.3, 2.4), black=0.1, scale=(1.0, 1.0, 1.0)) -> str:
    lines = ["# a monitor that was made up", "channel, X, Y, Z"]
    for channel, column, factor in zip(("red", "green", "blue"), PRIMARIES.T, scale, strict=True):
        lines.append(f"{channel}, " + ", ".join(repr(float(v * factor)) for v in column))
    lines.append("white, " + ", ".join(repr(float(v)) for v in PRIMARIES.sum(axis=1)))
    lines.append("drive, red, green, blue  # luminance in cd/m2")
    for drive in DRIVES:
        light = [black + 70.0 * (drive / 255.0) ** gamma for gamma in gammas]
        lines.append(f"{drive}, " + ", ".join(map(repr, light)))
    return "\n".join(lines) + "\n"


def write(tmp_path, text):
    path = tmp_path / "studio.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_known_monitor_comes_back(tmp_path):
    shown = read_display(write(tmp_path, measured()))
    assert shown.name == "studio"
    assert shown.transfer == "table"
    np.testing.assert_allclose(shown.to_tristimulus, display("srgb").to_tristimulus, rtol=1e2 * FLOAT64_ROUNDING)
    drive = np.repeat((DRIVES / 255.0)[:, None], 3, axis=1)
    light = drive ** np.array([2.2, 2.3, 2.4])
    np.testing.assert_allclose(shown.decode(drive), light, rtol=0, atol=1e-13)  # black level added and taken away
    np.testing.assert_allclose(shown.encode(light), drive, rtol=0, atol=1e-13)
    middle = np.random.default_rng(4).uniform(0.0, 1.0, (50, 3))
    np.testing.assert_allclose(shown.decode(shown.encode(middle)), middle, rtol=0, atol=1e-13)
    assert shown.encode([-0.5, 2.0, 0.0]).tolist() == [0.0, 1.0, 0.0]


def test_primaries_are_scaled_to_the_measured_white(tmp_path):
    shown = read_display(write(tmp_path, measured(scale=(1.05, 0.98, 1.1))), "mine")
    assert shown.name == "mine"
    np.testing.assert_allclose(shown.to_tristimulus, display("srgb").to_tristimulus, rtol=1e3 * FLOAT64_ROUNDING)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda t: t.replace("white,", "grey,"), "line 6: the channel must be red, green, blue or white"),
        (lambda t: "\n".join(line for line in t.splitlines() if not line.startswith("white")), "no row for white"),
        (lambda t: t.replace("white,", "red,"), "line 6: the channel red stands here a second time"),
        (lambda t: t.replace("\n0, ", "\n5, "), "line 8: the first drive value must be 0, but is 5"),
        (lambda t: t.replace("\n30, ", "\n15, "), "line 10: drive must increase strictly: 15 follows 15"),
        (lambda t: t + "270, 1, 80, 80\n", "line 26: red must increase strictly: 1 follows 70.1"),
        (lambda t: t + "270, abc, 80, 80\n", "line 26: the value 'abc' is not a number"),
        (lambda t: t + "270, 80, 80\n", "line 26: must have 4 columns, but has 3"),
        (lambda t: t.replace("drive, red, green", "drive, green, red"), "columns after drive must be red, green, blue"),
        (lambda t: t.split("drive")[0], "no table of at least two drive values"),
        (lambda t: measured(scale=(1.5, 1.0, 1.0)), "must add up to the white within 25 %"),
    ],
)  # fmt: skip
def test_bad_measurements_are_refused_with_their_line(tmp_path, change, reason):
    with pytest.raises(SpectrumFileError, match=r"studio.csv") as caught:
        read_display(write(tmp_path, change(measured())))
    assert reason in str(caught.value)


def test_flat_primaries_and_negative_light_are_refused(tmp_path):
    text = measured().splitlines()
    text[3] = text[2].replace("red", "green")
    with pytest.raises(SpectrumFileError, match="do not span a triangle"):
        read_display(write(tmp_path, "\n".join(text)))
    text[3] = "green, -1, 2, 3"
    with pytest.raises(SpectrumFileError, match="line 4: XYZ of green must not be negative"):
        read_display(write(tmp_path, "\n".join(text)))
    with pytest.raises(SpectrumFileError, match="cannot be read"):
        read_display(tmp_path / "gone.csv")


def test_the_example_of_the_documentation_can_be_read(tmp_path):
    page = (Path(__file__).resolve().parents[2] / "docs" / "colour.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```text\n(channel,.*?)^```", page, re.MULTILINE | re.DOTALL)
    shown = read_display(write(tmp_path, example))
    assert shown.drive_table.tolist() == [0.0, 128 / 255, 1.0]
    np.testing.assert_allclose(shown.white, [0.95, 1.0, 1.088], rtol=1e2 * FLOAT64_ROUNDING)
