"""Pictures for other displays than sRGB: what the pixels hold, what is counted, and what is said when it cannot be."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon import cli, last_render, panels
from dichromatic_addon.names import PLASTIC_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes.editing import set_surface_node
from dichromatic_addon.output_display import monitor_problem
from dichromatic_addon.properties import display_items, gamut_items
from tests.addon.building import add_camera, add_light, add_plane, small_picture
from tests.addon.fake_layout import FakeLayout
from tests.tolerances import FLOAT32_ROUNDING

pytestmark = pytest.mark.bpy

# Primaries and white of a monitor that is bluer than D65, and its light at a few drive values.
PRIMARIES = np.array([[40.0, 21.0, 2.0], [35.0, 70.0, 12.0], [20.0, 9.0, 105.0]])
TABLE = np.array([[0, 0, 0, 0], [64, 4, 3, 5], [128, 20, 18, 24], [192, 55, 50, 58], [255, 100, 100, 100]])


@pytest.fixture
def monitor(tmp_path):
    """The CSV file of the measured monitor."""
    lines = ["channel, X, Y, Z"]
    rows = [*zip(("red", "green", "blue"), PRIMARIES, strict=True), ("white", PRIMARIES.sum(axis=0))]
    lines += [f"{name}, " + ", ".join(map(str, values)) for name, values in rows]
    lines.append("drive, red, green, blue")
    lines += [", ".join(map(str, row)) for row in TABLE]
    path = tmp_path / "studio.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def tiles(scene):
    """A white tile, one of a green that no display shows and one that is too bright, in a row."""
    for index, (peak, base) in enumerate(((0.8, 0.8), (0.9, 0.0), (30.0, 30.0))):
        material = bpy.data.materials.new(f"Tile {index}")
        node = set_surface_node(material, PLASTIC_NODE)
        node.inputs["Interface Reflectance"].default_value = 0.0
        spectrum = material.node_tree.nodes.new(SPECTRUM_NODE)
        spectrum.source = "GAUSSIAN"
        spectrum.centre_nm, spectrum.width_nm, spectrum.peak, spectrum.base = 515.0, 15.0, peak, base
        material.node_tree.links.new(spectrum.outputs[0], node.inputs["Body Reflectance"])
        add_plane(scene, material, size=0.9, name=f"Tile {index}").location.x = index - 1.0
    add_light(scene, "SUN", 2.0)
    camera = add_camera(scene)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4.0
    small_picture(scene, 24, 8)
    scene.view_settings.exposure = 0.5
    scene.dichromatic.samples = 4
    return scene


def image_pixels(name="Dichromatic Render"):
    """Pixels (H, W, 4) of an image, row 0 at the top."""
    image = bpy.data.images[name]
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)[::-1].astype(np.float64)


def tristimulus(scene):
    finished = last_render.kept_render(scene).layer(scene.view_layers[0].name)
    return finished.render.tristimulus().astype(np.float64), finished.render.alpha.astype(np.float64)


def adapted(scene, white):
    """Tristimulus values of the render, D65 brought to a display's white."""
    daylight = core.white_point(core.illuminant("D65"), core.observer("cie_1931_2"))
    return tristimulus(scene)[0] @ core.chromatic_adaptation(daylight, white, "bradford").T


def expected_drive(scene, kind):
    """The drive values that clipping gives, from the definitions: matrix, exposure, curve."""
    if kind == "monitor":
        white = PRIMARIES.sum(axis=0)
        xyz = adapted(scene, white / white[1])
        light = np.clip(2.0**0.5 * xyz @ np.linalg.inv(PRIMARIES.T / white[1]).T, 0.0, 1.0)
        channels = [np.interp(light[..., c], TABLE[:, c + 1] / 100.0, TABLE[:, 0] / 255.0) for c in range(3)]
        return np.stack(channels, axis=-1)
    shown, xyz = core.display(kind), adapted(scene, core.SRGB_WHITE)
    return shown.encode(np.clip(2.0**0.5 * xyz @ np.linalg.inv(shown.to_tristimulus).T, 0.0, 1.0))


def choose(scene, kind, monitor, gamut="clip"):
    scene.dichromatic.display, scene.dichromatic.gamut = kind, gamut
    scene.dichromatic.monitor_file = str(monitor) if kind == "monitor" else ""


@pytest.mark.parametrize("kind", ["display_p3", "rec2020", "monitor"])
def test_the_image_holds_what_the_display_is_driven_with(tiles, monitor, kind):
    choose(tiles, kind, monitor)
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    image = bpy.data.images["Dichromatic Render"]
    assert (image.colorspace_settings.name, image.is_float) == ("Non-Color", True)
    pixels = image_pixels()
    expected = expected_drive(tiles, kind)
    assert np.ptp(expected) > 0.9
    np.testing.assert_allclose(pixels[..., :3], expected, atol=FLOAT32_ROUNDING)
    assert np.all(pixels[..., 3] == 1.0)
    notes = last_render.kept_render(tiles).layer("").render.statistics.notes
    counted = [note for note in notes if note.startswith("gamut: of 192 colours")]
    assert len(counted) == 1
    assert " 0 were too saturated" not in counted[0]
    assert "and 0 too bright" not in counted[0]
    assert counted[0].endswith("clipped")


def test_a_white_surface_is_the_monitors_white(tiles, monitor):
    choose(tiles, "monitor", monitor)
    bpy.ops.dichromatic.render_image()
    drive = image_pixels()[4, 5:7, :3]  # inside the white tile
    light = [np.interp(drive[..., c], TABLE[:, 0] / 255.0, TABLE[:, c + 1] / 100.0) for c in range(3)]
    expected = 0.8 * 2.0 / np.pi * 2.0**0.5
    np.testing.assert_allclose(light, expected, rtol=FLOAT32_ROUNDING)


def test_srgb_stays_light_without_an_end(tiles):
    bpy.ops.dichromatic.render_image()
    image = bpy.data.images["Dichromatic Render"]
    assert image.colorspace_settings.name == "Linear Rec.709"
    pixels = image_pixels()
    assert pixels.max() > 10.0  # no exposure, no clipping: the view has both
    assert pixels.min() < 0.0
    expected = core.display("srgb").linear(adapted(tiles, core.SRGB_WHITE))
    np.testing.assert_allclose(pixels[..., :3], expected, rtol=FLOAT32_ROUNDING, atol=FLOAT32_ROUNDING)
    assert any("gamut: of" in note for note in last_render.kept_render(tiles).layer("").render.statistics.notes)


@pytest.mark.parametrize("kind", [item[0] for item in display_items])
def test_compressed_colours_keep_their_luminance(tiles, monitor, kind):
    choose(tiles, kind, monitor, "compress")
    bpy.ops.dichromatic.render_image()
    pixels = image_pixels()[..., :3]
    if kind == "monitor":
        light = [np.interp(pixels[..., c], TABLE[:, 0] / 255.0, TABLE[:, c + 1] / 100.0) for c in range(3)]
        luminance = np.stack(light, axis=-1) @ (PRIMARIES[:, 1] / 100.0)
    else:
        light = pixels * 2.0**0.5 if kind == "srgb" else core.display(kind).decode(pixels)
        luminance = light @ core.display(kind).to_tristimulus[1]
    white = PRIMARIES.sum(axis=0) / PRIMARIES[:, 1].sum() if kind == "monitor" else core.SRGB_WHITE
    expected = 2.0**0.5 * adapted(tiles, white)[4, 10:14, 1]  # of the green tile
    np.testing.assert_allclose(luminance[4, 10:14], expected, rtol=FLOAT32_ROUNDING)
    assert np.all(np.asarray(light) >= -1e-6)
    assert np.all(np.asarray(light) <= 1.0 + 1e-6)


def test_transparent_edges_have_the_colour_of_the_surface(tiles):
    tiles.render.film_transparent = True
    choose(tiles, "display_p3", None)
    bpy.ops.dichromatic.render_image()
    pixels = image_pixels()
    _, alpha = tristimulus(tiles)
    edge = (alpha[4] > 0.05) & (alpha[4] < 0.95) & (np.arange(24) < 8)  # of the white tile
    assert edge.any()
    inside = pixels[4, 5, :3]
    np.testing.assert_allclose(pixels[4, edge, 3], alpha[4, edge], rtol=FLOAT32_ROUNDING)
    np.testing.assert_allclose(pixels[4, edge, :3], inside * alpha[4, edge, None], rtol=FLOAT32_ROUNDING)
    assert np.all(pixels[alpha == 0.0] == 0.0)


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("", "", "no CSV file of a measured monitor is chosen"),
        ("missing.csv", None, "there is no such file"),
        ("bad.csv", "channel, X, Y, Z\nred, 1, 2\n", "must have 4 columns"),
    ],
)
def test_a_monitor_that_cannot_be_had_is_said_before_the_render(tiles, tmp_path, name, content, reason):
    if content:
        (tmp_path / name).write_text(content)
    tiles.dichromatic.display = "monitor"
    tiles.dichromatic.monitor_file = str(tmp_path / name) if name else ""
    assert reason in monitor_problem(tiles)
    started = []
    bpy.app.handlers.render_init.append(started.append)
    try:
        with pytest.raises(RuntimeError, match=f"Monitor of scene 'Scene': .*{reason}"):
            bpy.ops.dichromatic.render_image()
    finally:
        bpy.app.handlers.render_init.remove(started.append)
    assert not started
    assert "Dichromatic Render" not in bpy.data.images
    assert bpy.ops.render.render() == {"FINISHED"}  # F12 does not need the monitor


def test_a_monitor_that_was_measured_again_is_read_again(tiles, monitor):
    choose(tiles, "monitor", monitor)
    assert monitor_problem(tiles) == ""
    text = monitor.read_text()
    monitor.write_text(text.replace("drive, red", "drive, grey"))
    assert "columns after drive" in monitor_problem(tiles)
    monitor.write_text(text)
    assert monitor_problem(tiles) == ""


def test_relighting_stays_with_the_display(tiles, monitor):
    choose(tiles, "monitor", monitor)
    bpy.ops.dichromatic.render_image()
    before = image_pixels()
    bpy.data.lights[0].energy = 0.5
    bpy.ops.dichromatic.relight()
    image = bpy.data.images["Dichromatic Render"]
    assert image.colorspace_settings.name == "Non-Color"
    assert image_pixels()[4, 5, 0] < before[4, 5, 0]
    np.testing.assert_allclose(image_pixels()[..., :3], expected_drive(tiles, "monitor"), atol=FLOAT32_ROUNDING)
    monitor.unlink()
    with pytest.raises(RuntimeError, match="there is no such file"):
        bpy.ops.dichromatic.relight()
    choose(tiles, "srgb", None)
    bpy.ops.dichromatic.relight()
    assert image.colorspace_settings.name == "Linear Rec.709"


@pytest.mark.parametrize("gamut", [item[0] for item in gamut_items])
@pytest.mark.parametrize("kind", [item[0] for item in display_items])
def test_the_panel_offers_it(tiles, kind, gamut):
    choose(tiles, kind, "", gamut)
    layout = FakeLayout()
    region = SimpleNamespace(width=4000)
    context = SimpleNamespace(scene=tiles, preferences=bpy.context.preferences, region=region)
    panels.DICHROMATIC_PT_output.draw(SimpleNamespace(layout=layout), context)
    assert {"display", "gamut"} <= set(layout.names("prop"))
    assert ("monitor_file" in layout.names("prop")) == (kind == "monitor")
    assert ("no CSV file of a measured monitor is chosen" in layout.names("label")) == (kind == "monitor")


@pytest.fixture
def blend(tiles, monitor, tmp_path):
    """The tiles in a file whose display is the measured monitor, by a path relative to it."""
    tiles.dichromatic.display, tiles.dichromatic.gamut = "monitor", "compress"
    path = tmp_path / "tiles.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    tiles.dichromatic.monitor_file = "//studio.csv"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def shown_by(path: Path):
    """Display values of a PNG as they stand in it."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    return image_pixels(image.name)[..., :3]


def test_the_command_line_takes_the_files_display(blend, tmp_path, capsys):
    png, film = tmp_path / "tiles.png", tmp_path / "tiles.npz"
    assert cli.main(["render", str(blend), "-o", str(png), "--film", str(film)]) == 0
    assert "gamut: of 192 colours" in (said := capsys.readouterr().out)
    assert "and compressed" in said
    _, development = core.open_render(film)
    assert (development.shown.name, development.gamut) == ("studio", "compress")
    assert cli.main(["render", str(blend), "-o", str(png), "--gamut", "clip"]) == 0
    assert "and clipped" in capsys.readouterr().out
    expected = expected_drive(bpy.context.scene, "monitor")
    np.testing.assert_allclose(shown_by(png), expected, atol=1.0 / 255)  # half a step of rounding, half of dither


def test_the_command_lines_display_comes_first(blend, monitor, tmp_path, capsys):
    png = tmp_path / "tiles.png"
    monitor.unlink()
    assert cli.main(["render", str(blend), "-o", str(png)]) != 0
    assert "Monitor of scene" in capsys.readouterr().err
    assert not png.exists()
    assert cli.main(["render", str(blend), "-o", str(png), "--display", "rec2020", "--gamut", "clip"]) == 0
    np.testing.assert_allclose(shown_by(png), expected_drive(bpy.context.scene, "rec2020"), atol=1.0 / 255)


def test_a_saved_render_knows_its_display(tiles, monitor, tmp_path):
    choose(tiles, "monitor", monitor, "compress")
    bpy.ops.dichromatic.render_image()
    film = tmp_path / "tiles.npz"
    assert bpy.ops.dichromatic.save_render(filepath=str(film)) == {"FINISHED"}
    _, development = core.open_render(film)
    assert (development.shown.name, development.gamut, development.exposure) == ("studio", "compress", 0.5)
