"""Scenes made for Cycles, rendered here as they are and after a conversion: they resemble Cycles' pictures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

import spectral_core as core
from dichromatic_addon.conversion import convert_all
from dichromatic_addon.scene_export import export_scene
from tests.addon.building import combined
from tests.addon.cycles_scenes import SCENES, build
from tests.tolerances import SIMILAR_TO_CYCLES, SIMILAR_TO_ITSELF

pytestmark = pytest.mark.bpy

APPROXIMATED = {
    "tiled floor": ["were uplifted"],
    "mixed shaders": ["the pattern of 'Noise Texture'", "metal is mixed with a body"],
    "glowing strips": ["were uplifted"],
    "studio sky": ["the coat of 'Principled BSDF'", "'Glass BSDF' lets no light through"],
    "scattered instances": ["were uplifted"],
}


def structural_similarity(one: NDArray[np.floating], other: NDArray[np.floating]) -> float:
    """Mean SSIM of two pictures (H, W) of values from 0 to 1.

    Wang, Bovik, Sheikh and Simoncelli, Image Quality Assessment: From Error Visibility to Structural Similarity, IEEE
    Trans. Image Processing 13 (2004), Eq. 13, with their Gaussian window of 11 x 11 pixels, of a width of 1.5, and
    K1 = 0.01, K2 = 0.03.
    """
    offsets = np.arange(-5, 6)
    window = np.exp(-(offsets**2) / (2.0 * 1.5**2))
    window /= window.sum()

    def mean(picture: NDArray[np.floating]) -> NDArray[np.floating]:
        rows = np.apply_along_axis(np.convolve, 0, picture, window, "valid")
        return np.apply_along_axis(np.convolve, 1, rows, window, "valid")

    a, b = one.astype(np.float64), other.astype(np.float64)
    mean_a, mean_b = mean(a), mean(b)
    variance_a, variance_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    covariance = mean(a * b) - mean_a * mean_b
    first, second = 0.01**2, 0.03**2
    similarity = (2.0 * mean_a * mean_b + first) * (2.0 * covariance + second)
    similarity /= (mean_a**2 + mean_b**2 + first) * (variance_a + variance_b + second)
    return float(similarity.mean())


def shown(scene: Any, engine: str, path: Path, name: str, samples: int = 25) -> NDArray[np.floating]:
    """What sRGB shows of a render; kept as an artefact where a folder for them is named."""
    scene.render.engine = engine
    scene.cycles.samples, scene.cycles.use_denoising, scene.dichromatic.samples = 8 * samples, False, samples
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
    pixels = combined(scene, str(path / f"{engine}.exr"))[..., :3]
    encoded = core.display("srgb").encode(np.clip(pixels, 0.0, 1.0))
    folder = os.environ.get("DICHROMATIC_ARTIFACTS")
    if folder:
        target = Path(folder) / f"cycles scene, {name}, {engine.lower()}, {bpy.app.version_string[:3]}.png"
        core.write_image(target, encoded.astype(np.float32))
    return np.asarray(encoded)


def grey(picture: NDArray[np.floating]) -> NDArray[np.floating]:
    return picture @ np.array([0.2126, 0.7152, 0.0722])


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_scenes_made_for_cycles_resemble_its_pictures(addon: Any, tmp_path: Path, name: str) -> None:
    scene = build(name)
    notes = export_scene(bpy.context.evaluated_depsgraph_get()).notes
    print(f"\n{name}:", *notes, sep="\n  ")
    for words in APPROXIMATED[name]:
        assert any(words in note for note in notes), words
    assert len(set(notes)) == len(notes)
    ours = shown(scene, "DICHROMATIC", tmp_path, name)
    theirs = shown(scene, "CYCLES", tmp_path, name)
    similarity = structural_similarity(grey(ours), grey(theirs))
    print(f"{name}: structural similarity {similarity:.3f}, mean {ours.mean():.3f}, Cycles {theirs.mean():.3f}")
    assert similarity > SIMILAR_TO_CYCLES
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.15)


@pytest.mark.parametrize("name", SCENES)
def test_a_conversion_does_not_change_the_picture(addon: Any, tmp_path: Path, name: str) -> None:
    scene = build(name)
    scene.render.resolution_percentage = 40
    before = shown(scene, "DICHROMATIC", tmp_path, f"{name} before", samples=1)
    converted, _ = convert_all(bpy.data.materials)
    assert converted > 0
    after = shown(scene, "DICHROMATIC", tmp_path, f"{name} after", samples=1)
    np.testing.assert_allclose(after, before, atol=SIMILAR_TO_ITSELF)


def test_the_measure_of_similarity() -> None:
    """1 for equal pictures; by its formula for constant ones; low where the structure is another."""
    rng = np.random.default_rng(1)
    picture = rng.random((32, 40))
    assert structural_similarity(picture, picture) == pytest.approx(1.0)
    flat = structural_similarity(np.full((20, 20), 0.4), np.full((20, 20), 0.6))
    assert flat == pytest.approx((2 * 0.24 + 1e-4) / (0.16 + 0.36 + 1e-4))
    assert structural_similarity(picture, rng.random((32, 40))) < 0.2
