"""The extension as users get it: a validated zip, installed, enabled, rendering, disabled and enabled again."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytestmark = [
    pytest.mark.bpy,
    pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="needs the bpy module"),
]

ROOT = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT = 64, 36


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The zip, built and validated by Blender's own tool."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, str(ROOT / "tools/package.py"), "--output", str(folder)]
    made = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert made.returncode == 0, made.stdout + made.stderr
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    return folder / f"{manifest['id']}-{manifest['version']}.zip"


@pytest.fixture(scope="module")
def life(package: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    """What was observed during the extension's life, and the folder with its pictures."""
    folder = tmp_path_factory.mktemp("life")
    # Another folder, another environment: nothing but the zip may provide the add-on and the core.
    environment = {
        name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "BLENDER_USER_EXTENSIONS")
    }
    environment["BLENDER_USER_RESOURCES"] = str(folder / "resources")
    script = Path(__file__).with_name("extension_lifecycle.py")
    blend = ROOT / "sample_blends/cups.blend"
    command = [sys.executable, str(script), str(package), str(blend), str(WIDTH), str(HEIGHT), str(folder)]
    run = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=240
    )
    assert run.returncode == 0, run.stdout[-4000:] + run.stderr[-4000:]
    observed = json.loads((folder / "observed.json").read_text(encoding="utf-8"))
    if artifacts := os.environ.get("DICHROMATIC_ARTIFACTS"):  # `make test-matrix` compares the versions' pictures
        shutil.copyfile(folder / "first.npy", Path(artifacts, f"cups-{observed['blender'].split()[0]}.npy"))
    return observed, folder


def picture(life: tuple[dict[str, Any], Path], name: str) -> NDArray[np.float32]:
    pixels = np.load(life[1] / f"{name}.npy")
    assert pixels.shape == (HEIGHT, WIDTH, 3)
    return pixels


def test_zip_holds_the_extension_and_nothing_else(package: Path) -> None:
    with zipfile.ZipFile(package) as archive:
        names = archive.namelist()
    parts = {"blender_manifest.toml", "__init__.py", "LICENSE", "README.md", "dichromatic_addon", "spectral_core"}
    assert {name.split("/")[0] for name in names} == parts
    for file in sorted((ROOT / "spectral_core").rglob("*.py")) + sorted((ROOT / "dichromatic_addon").rglob("*.py")):
        assert file.relative_to(ROOT).as_posix() in names
    assert "spectral_core/LICENSE" in names
    assert any(name.startswith("spectral_core/data/") and name.endswith(".npz") for name in names)
    assert not [name for name in names if "__pycache__" in name or name.endswith((".pyc", ".blend", ".blend1"))]


def test_installing_enables_without_a_policy_warning(life: tuple[dict[str, Any], Path]) -> None:
    observed, _ = life
    assert observed["enabled"]
    assert observed["policy"] == []
    assert "DICHROMATIC" in observed["installed"]["engines"]
    assert "DICHROMATIC" not in observed["before"]["engines"]


def test_core_comes_from_the_extension_under_one_name(life: tuple[dict[str, Any], Path]) -> None:
    loaded = set(life[0]["modules"])
    assert "bl_ext.user_default.dichromatic.spectral_core" in loaded
    assert not {"spectral_core", "dichromatic_addon"} & loaded


def test_rendering_loads_neither_colour_science_nor_scipy(life: tuple[dict[str, Any], Path]) -> None:
    assert not {"colour", "scipy", "matplotlib"} & set(life[0]["modules"])


@pytest.mark.parametrize("what", ["types", "operators", "engines", "properties", "handlers", "compatible", "drawn"])
def test_disabling_leaves_nothing_behind(life: tuple[dict[str, Any], Path], what: str) -> None:
    observed, _ = life
    assert set(observed["installed"][what]) >= set(observed["before"][what])
    assert observed["disabled"][what] == observed["before"][what]


def test_installing_adds_classes_properties_and_panels(life: tuple[dict[str, Any], Path]) -> None:
    """Without this the test above could hold because nothing was ever seen."""
    observed, _ = life
    for what in ("types", "engines", "properties", "compatible"):
        assert set(observed["installed"][what]) > set(observed["before"][what]), what


def test_enabling_again_is_the_same(life: tuple[dict[str, Any], Path]) -> None:
    observed, _ = life
    assert observed["again"] == observed["installed"]
    np.testing.assert_array_equal(picture(life, "second"), picture(life, "first"))


def test_picture_shows_a_blue_and_a_red_cup(life: tuple[dict[str, Any], Path]) -> None:
    pixels = picture(life, "first")
    assert np.isfinite(pixels).all()
    red, _, blue = np.moveaxis(pixels, -1, 0)
    bright = pixels.max(axis=-1) > 0.05
    share_of_blue = np.mean(bright & (blue > 2 * red))
    share_of_red = np.mean(bright & (red > 2 * blue))
    assert share_of_blue > 0.02, f"blue on {share_of_blue:.1%} of the picture"
    assert share_of_red > 0.02, f"red on {share_of_red:.1%} of the picture"
