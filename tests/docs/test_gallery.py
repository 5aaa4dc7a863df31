"""The gallery shows what `make gallery` makes, at the size it says, and quotes the paper and the scripts."""

from __future__ import annotations

import re
import struct

import pytest

from tests.docs.documents import ROOT
from tools.make_gallery import OF_TUTORIALS, SHEETS, VIEWS

GALLERY = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [*VIEWS, *SHEETS])
def test_picture_is_shown_and_has_its_size(name: str) -> None:
    assert f"(images/{name}.png)" in GALLERY
    width, height = struct.unpack(">II", (ROOT / "docs" / "images" / f"{name}.png").read_bytes()[16:24])
    smallest = (1280, 720)
    assert width >= smallest[0], f"{name} is {width} x {height}"
    assert height >= smallest[1], f"{name} is {width} x {height}"


@pytest.mark.parametrize("name", OF_TUTORIALS)
def test_picture_of_a_tutorial_is_made_by_its_code(name: str) -> None:
    page, file_name = OF_TUTORIALS[name]
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    assert f'"{file_name}"' in text
    assert f"images/{name}.png" in text


@pytest.mark.parametrize(
    ("sample", "in_script", "in_gallery"),
    [
        ("cups", 'attenuation="cosine", n=11.0', "cosine, n = 11"),
        ("cups", "interface=5.0", "Interface Reflectance 5"),
        ("cups", '"Key", (-1.05, -0.85, 1.20), 140.0, 0.05', "5 cm radius at 1.8 m"),
        ("cloth", 'attenuation="exponential", n=10.0', "exponential, n = 10"),
        ("cloth", "(0.80, 1.05)", "(0.80 and 0.40 of them) and crowns (1.05 and 1.15)"),
        ("cloth", "(0.40, 1.15)", "(0.80 and 0.40 of them) and crowns (1.05 and 1.15)"),
        ("cloth", "count: int = 197", f"{2 * 196 * 196:,} triangles"),
        ("cloth", "52.0, 0.02)", "a ball of 2 cm radius"),
        ("metal_balls", "math.radians(5.0)", "beta 5°"),
        ("metal_balls", "math.radians(18.0)", "18° across the spin"),
        ("metal_balls", "SUN_ANGLE = math.radians(7.0)", "an angular diameter of 7°"),
        ("metal_balls", '"mirror": 0.55', "*Mirror* 0.55"),
    ],
)
def test_numbers_are_those_of_the_scripts(sample: str, in_script: str, in_gallery: str) -> None:
    assert in_script in (ROOT / "sample_blends" / f"make_{sample}.py").read_text(encoding="utf-8")
    assert in_gallery in GALLERY


def test_every_sample_is_in_the_gallery() -> None:
    samples = {path.stem for path in (ROOT / "sample_blends").glob("*.blend")}
    assert samples == {sample for sample, _ in [*VIEWS.values(), *SHEETS.values()]}
    for sample in samples:
        assert re.search(rf"\b{sample}\b", GALLERY)
