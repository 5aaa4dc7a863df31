"""The last render and its studies: relighting, maps, sheets, probes, files, quality and panels, in every state."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon import (
    image_view,
    last_render,
    live_relight,
    panels,
    quality,
    render_files,
    studies,
    study_panels,
    study_settings,
)
from dichromatic_addon._core import core
from dichromatic_addon.bitmap_font import draw_text, text_width
from dichromatic_addon.names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE
from dichromatic_addon.nodes.editing import link_spectrum_node, set_surface_node
from dichromatic_addon.operators import IMAGE_NAME
from dichromatic_addon.relighting import settings_differences
from dichromatic_addon.spectrum_plot import PLOT_SIZE, plot_spectra
from tests.addon.building import add_camera, add_light, add_plane, small_picture
from tests.tolerances import FILM_AGAINST_BRUTE_FORCE, FLOAT32_ROUNDING

from .fake_layout import FakeLayout

pytestmark = pytest.mark.bpy

WIDTH, HEIGHT = 40, 24
EIGHT_BITS = 0.5 / 255 + 1e-6  # half a step of the images that keep bytes


def paint(name: str, body: str) -> Any:
    """A plastic whose body is a reflectance of the library."""
    material = bpy.data.materials.new(name)
    node = set_surface_node(material, PLASTIC_NODE)
    spectrum = link_spectrum_node(material.node_tree, node, "Body Reflectance")
    spectrum.source, spectrum.library_name = "LIBRARY", body
    return material


@pytest.fixture
def studio(scene: Any) -> Any:
    """A red plastic sheet over a blue plastic floor, and a copper plate, under two lamps."""
    names = core.reflectance_names()
    add_plane(scene, paint("Blue", names[12]), name="Floor")
    add_plane(scene, paint("Red", names[14]), size=1.5, height=0.5, name="Sheet")
    metal = bpy.data.materials.new("Copper")
    set_surface_node(metal, METAL_NODE).inputs["beta"].default_value = math.radians(25)
    plate = add_plane(scene, metal, size=1.2, height=0.3, name="Plate")
    plate.location.x = 1.6
    add_light(scene, "POINT", 800.0, (2, -3, 4), shadow_soft_size=0.0).data.name = "Key"
    add_light(scene, "SUN", 0.7, (-2, -3, 4), angle=0.0).data.name = "Fill"
    add_camera(scene, (0, -6, 4), (math.radians(55), 0, 0))
    small_picture(scene, WIDTH, HEIGHT)
    scene.dichromatic.samples, scene.dichromatic.precision = 2, "float64"
    return scene


@pytest.fixture
def rendered(studio: Any) -> Any:
    """The same, rendered into its image."""
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    return studio


def pixels_of(name: str) -> np.ndarray:
    """The pixels (H, W, 4) of an image, row 0 at the top."""
    image = bpy.data.images[name]
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)[::-1]


def edited() -> None:
    """Let Blender evaluate the edits and the add-on answer, as the window's event loop and its timer do."""
    bpy.context.view_layer.update()
    live_relight.run_pending()


def assert_like_a_fresh_render(scene: Any) -> None:
    relit = pixels_of(IMAGE_NAME).copy()
    assert relit.max() > 0.1
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    fresh = pixels_of(IMAGE_NAME)
    # The films are the same; what the image stores is float32.
    np.testing.assert_allclose(relit, fresh, atol=FILM_AGAINST_BRUTE_FORCE * fresh.max())


# ---- relighting


def brighter(scene: Any) -> None:
    bpy.data.lights["Key"].energy = 300.0


def from_the_library(scene: Any) -> None:
    settings = bpy.data.lights["Key"].dichromatic
    settings.source, settings.illuminant = "LIBRARY", "FL11"


def warmer(scene: Any) -> None:
    settings = bpy.data.lights["Fill"].dichromatic
    settings.source, settings.temperature = "TEMPERATURE", 2200.0


def other_paint(scene: Any) -> None:
    node = bpy.data.materials["Red"].node_tree.nodes
    spectrum = next(n for n in node if n.bl_idname.endswith("Spectrum"))
    spectrum.library_name = core.reflectance_names()[13]


def stronger_highlight(scene: Any) -> None:
    node = next(n for n in bpy.data.materials["Blue"].node_tree.nodes if n.bl_idname == PLASTIC_NODE)
    node.inputs["Interface Reflectance"].default_value = 4.0


def larger_field(scene: Any) -> None:
    scene.dichromatic.observer = "cie_1964_10"


def other_white(scene: Any) -> None:
    scene.dichromatic.adaptation, scene.dichromatic.white_illuminant = "cat16", "A"


def lamp_off(scene: Any) -> None:
    bpy.data.lights["Fill"].energy = 0.0


EDITS = [brighter, from_the_library, warmer, other_paint, stronger_highlight, larger_field, other_white, lamp_off]


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit.__name__)
def test_an_edit_relights_the_picture_at_once(rendered: Any, edit: Any) -> None:
    before = pixels_of(IMAGE_NAME).copy()
    edit(rendered)
    edited()
    assert np.abs(pixels_of(IMAGE_NAME) - before).max() > 1e-3
    kept = last_render.kept_render(rendered)
    assert (kept.problem, kept.differences, kept.outdated) == ("", (), {})
    assert_like_a_fresh_render(rendered)


def test_nothing_is_relit_when_the_toggle_is_off(rendered: Any) -> None:
    before = pixels_of(IMAGE_NAME).copy()
    rendered.dichromatic_studies.live_relight = False
    from_the_library(rendered)
    edited()
    assert np.array_equal(pixels_of(IMAGE_NAME), before)
    assert bpy.ops.dichromatic.relight() == {"FINISHED"}
    assert_like_a_fresh_render(rendered)


def test_relighting_there_and_back_gives_the_first_picture(rendered: Any) -> None:
    before = pixels_of(IMAGE_NAME).copy()
    light = bpy.data.lights["Key"]
    energy = light.energy
    for value in (0.0, 20.0, energy):
        light.energy = value
        edited()
    np.testing.assert_allclose(pixels_of(IMAGE_NAME), before, atol=FLOAT32_ROUNDING * before.max())


def test_another_metal_is_relit_and_its_difference_told(rendered: Any) -> None:
    before = pixels_of(IMAGE_NAME).copy()
    node = next(n for n in bpy.data.materials["Copper"].node_tree.nodes if n.bl_idname == METAL_NODE)
    node.metal = "gold"
    edited()
    assert np.abs(pixels_of(IMAGE_NAME) - before).max() > 1e-3
    assert "turns white towards grazing incidence" in " ".join(last_render.kept_render(rendered).differences)


def move(scene: Any) -> str:
    bpy.data.objects["Sheet"].location.x += 0.4
    return "'Sheet' moved"


def move_the_lamp(scene: Any) -> str:
    bpy.data.objects["Point"].location.x += 0.4
    return "'Point' moved"


def reshape(scene: Any) -> str:
    mesh = bpy.data.objects["Sheet"].data
    mesh.vertices[0].co.z += 0.3
    mesh.update()
    return "'Sheet' changed its shape"


def zoom(scene: Any) -> str:
    scene.camera.data.lens = 80.0
    return "camera 'Camera' was changed"


def hide(scene: Any) -> str:
    bpy.data.objects["Sheet"].hide_render = True
    return "objects were added, removed, renamed or hidden"


@pytest.mark.parametrize("edit", [move, move_the_lamp, reshape, zoom, hide], ids=lambda edit: edit.__name__)
def test_a_change_of_geometry_marks_the_picture_and_leaves_it(rendered: Any, edit: Any) -> None:
    before = pixels_of(IMAGE_NAME).copy()
    reason = edit(rendered)
    edited()
    assert reason in last_render.kept_render(rendered).outdated
    assert np.array_equal(pixels_of(IMAGE_NAME), before)
    assert "Out of date" in " ".join(draw(study_panels.DICHROMATIC_PT_studies, rendered).names("label"))
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    assert last_render.kept_render(rendered).outdated == {}


def test_what_spectra_cannot_express_is_told(rendered: Any) -> None:
    bpy.data.lights["Key"].shadow_soft_size = 0.5
    node = next(n for n in bpy.data.materials["Blue"].node_tree.nodes if n.bl_idname == PLASTIC_NODE)
    node.inputs["n"].default_value = 40.0
    add_light(rendered, "POINT", 50.0).data.name = "New"
    edited()
    told = " ".join(last_render.kept_render(rendered).differences)
    for part in ("radius of light 'Key'", "n of material 'Blue'", "light 'New' was not there"):
        assert part in told


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (lambda: setattr(bpy.data.lights["Key"], "name", "Other"), "light 'Key' of the kept render is gone"),
        (lambda: setattr(bpy.data.materials["Red"], "name", "Other"), "material 'Red' of the kept render is gone"),
        (lambda: set_surface_node(bpy.data.materials["Red"], METAL_NODE), "'Red' became another kind of material"),
        (lambda: setattr(bpy.data.lights["Key"].dichromatic, "illuminant", "none such"), "no illuminant 'none such'"),
    ],
)
def test_slots_that_do_not_fit_are_named(rendered: Any, edit: Any, reason: str) -> None:
    bpy.data.lights["Key"].dichromatic.source = "LIBRARY"
    before = pixels_of(IMAGE_NAME).copy()
    edit()
    live_relight._pending.add(rendered.name)
    edited()
    assert reason in last_render.kept_render(rendered).problem
    with pytest.raises(RuntimeError, match=reason):
        bpy.ops.dichromatic.relight()
    assert pixels_of(IMAGE_NAME).shape == before.shape
    assert "problem" not in draw(study_panels.DICHROMATIC_PT_studies, rendered).names("label")


def test_a_type_of_dielectric_may_change_where_the_slots_stay(rendered: Any) -> None:
    set_surface_node(bpy.data.materials["Blue"], CLOTH_NODE)
    edited()
    assert last_render.kept_render(rendered).problem == ""


def test_changed_settings_are_named(rendered: Any) -> None:
    finished = last_render.kept_render(rendered).layer("ViewLayer")
    assert settings_differences(rendered, finished) == []
    rendered.dichromatic.samples, rendered.render.resolution_x = 7, 64
    assert settings_differences(rendered, finished) == ["width", "samples"]


def test_plain_colour_keeps_its_spectra_but_not_its_white(studio: Any) -> None:
    for name in ("Blue", "Red"):
        node = next(n for n in bpy.data.materials[name].node_tree.nodes if n.bl_idname == PLASTIC_NODE)
        node.inputs["Mirror"].default_value = 0.5
    studio.dichromatic.bounce_spectra = "nodes"
    bpy.ops.dichromatic.render_image()
    other_white(studio)
    edited()
    assert last_render.kept_render(studio).problem == ""
    assert_like_a_fresh_render(studio)
    brighter(studio)
    edited()
    assert "cannot be relit" in last_render.kept_render(studio).problem
    assert "Mirrored light" in " ".join(draw(study_panels.DICHROMATIC_PT_studies, studio).names("label"))


def test_every_view_layer_is_kept_and_relit(studio: Any) -> None:
    studio.view_layers.new("Second")
    bpy.ops.dichromatic.render_image()
    assert list(last_render.kept_render(studio).layers) == ["ViewLayer", "Second"]
    before = [pixels_of(f"{IMAGE_NAME} {name}").copy() for name in ("ViewLayer", "Second")]
    brighter(studio)
    edited()
    for name, old in zip(("ViewLayer", "Second"), before, strict=True):
        assert np.abs(pixels_of(f"{IMAGE_NAME} {name}") - old).max() > 1e-3


def test_the_last_render_is_let_go(rendered: Any) -> None:
    first = last_render.kept_render(rendered)
    assert not first.layer("ViewLayer").exported.scene.instances
    bpy.ops.render.render()
    second = last_render.kept_render(rendered)
    assert second is not first
    assert bpy.ops.dichromatic.free_render() == {"FINISHED"}
    assert last_render.kept_render(rendered) is None
    bpy.ops.render.render()
    name = rendered.name
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert last_render.kept_render(SimpleNamespace(name=name)) is None
    assert not bpy.ops.dichromatic.relight.poll()


def test_the_image_editor_offers_the_image_that_is_relit(studio: Any) -> None:
    bpy.ops.render.render()
    assert IMAGE_NAME not in bpy.data.images
    space = SimpleNamespace(type="IMAGE_EDITOR", image=None)
    panel = study_panels.DICHROMATIC_PT_image
    assert "dichromatic.show_render" in draw(panel, studio, space).names("operator")
    context = SimpleNamespace(scene=studio, view_layer=studio.view_layers[0], space_data=space)
    assert live_relight.DICHROMATIC_OT_show_render.execute(SimpleNamespace(), context) == {"FINISHED"}
    assert space.image == bpy.data.images[IMAGE_NAME]
    assert "dichromatic.show_render" in draw(panel, studio, space).names("greyed operator")


# ---- studies


def test_the_map_is_the_cores(rendered: Any) -> None:
    assert bpy.ops.dichromatic.metamerism_map(first="D65", second="FL11", largest=4.0) == {"FINISHED"}
    render = last_render.kept_render(rendered).layer("ViewLayer").render
    found = core.metamerism_map(render, core.illuminant("D65"), core.illuminant("FL11"))
    picture = pixels_of(studies.MAP_IMAGE)
    assert picture.shape == (HEIGHT, WIDTH, 4)
    assert found.delta_e.max() > 1.0
    np.testing.assert_allclose(picture[..., :3], found.picture(4.0), atol=EIGHT_BITS)
    assert last_render.kept_render(rendered).map_report == found.describe()
    with pytest.raises(RuntimeError, match="none such"):
        bpy.ops.dichromatic.metamerism_map(first="none such")


@pytest.mark.parametrize("adapt", [False, True])
def test_the_sheet_shows_each_lamp(rendered: Any, adapt: bool) -> None:
    assert bpy.ops.dichromatic.contact_sheet(lamps="D65, A, FL2", adapt=adapt, columns=2) == {"FINISHED"}
    sheet = pixels_of(studies.SHEET_IMAGE)
    assert sheet.shape == (2 * HEIGHT + 8, 2 * WIDTH + 8, 4)
    render = last_render.kept_render(rendered).layer("ViewLayer").render
    made = core.Development(adopted_white=core.illuminant("D65"), adaptation="bradford")
    if adapt:
        made = replace(made, adopted_white=core.illuminant("A"))
    expected, _ = made.picture(core.relit_by(render, core.illuminant("A")).tristimulus(), render.observer)
    np.testing.assert_allclose(sheet[:HEIGHT, WIDTH + 8 :, :3], expected, atol=EIGHT_BITS)


def test_the_sheet_takes_the_lamps_of_the_list(rendered: Any) -> None:
    settings = rendered.dichromatic_studies
    assert study_settings.sheet_lamps(settings) == list(study_settings.STANDARD_LAMPS)
    bpy.ops.dichromatic.study_lamps(action="STANDARD")
    assert len(settings.lamps) == 4
    bpy.ops.dichromatic.study_lamps(action="ADD")
    settings.lamps[4].lamp = "HP1"
    settings.active_lamp = 0
    bpy.ops.dichromatic.study_lamps(action="REMOVE")
    assert study_settings.sheet_lamps(settings) == ["A", "FL2", "FL11", "HP1"]
    assert bpy.ops.dichromatic.contact_sheet() == {"FINISHED"}
    assert tuple(bpy.data.images[studies.SHEET_IMAGE].size) == (2 * WIDTH + 8, 2 * HEIGHT + 8)
    settings.lamps[1].lamp = ""  # by the cross in its row
    assert study_settings.sheet_lamps(settings) == ["A", "FL11", "HP1"]
    for _ in range(4):
        bpy.ops.dichromatic.study_lamps(action="REMOVE")
    assert bpy.ops.dichromatic.study_lamps(action="REMOVE") == {"CANCELLED"}


def test_names_are_written_where_there_is_room(rendered: Any) -> None:
    small_picture(rendered, 160, 90)
    rendered.dichromatic.samples = 1
    bpy.ops.render.render()
    bpy.ops.dichromatic.contact_sheet(lamps="D65, A", columns=1)
    sheet = pixels_of(studies.SHEET_IMAGE)[..., :3]
    for bottom in (90, 188):
        corner = sheet[bottom - 26 : bottom, : text_width("A") + 16]
        assert (corner.min(axis=-1) > 0.99).sum() >= 30  # the letter
        assert corner[0].max() <= 0.26  # on a darkened ground


def test_a_probed_pixel_adds_up_to_its_colour(rendered: Any) -> None:
    x, y = 20, 5
    assert bpy.ops.dichromatic.probe_pixel(x=x, y=y) == {"FINISHED"}
    render = last_render.kept_render(rendered).layer("ViewLayer").render
    table = np.array([line.split(",") for line in _csv_rows()], float)
    assert table.shape[0] == 471
    np.testing.assert_allclose(table[:, 2:].sum(axis=1), table[:, 1], atol=1e-8 * table[:, 1].max())  # 9 digits
    xyz = table[:, 1] @ core.observer(render.observer).matching_functions
    np.testing.assert_allclose(xyz, render.tristimulus()[HEIGHT - 1 - y, x], rtol=FILM_AGAINST_BRUTE_FORCE)
    report = last_render.kept_render(rendered).probe_report
    assert report.startswith(f"pixel ({x}, {y}): Y {xyz[1]:.4f}")
    assert "Key x" in report
    assert tuple(bpy.data.images[studies.PROBE_IMAGE].size) == PLOT_SIZE
    with pytest.raises(RuntimeError, match="must lie within the picture of 40 x 24 pixels"):
        bpy.ops.dichromatic.probe_pixel(x=WIDTH, y=0)


def test_lamps_that_share_their_data_are_told_apart_by_their_objects(studio: Any) -> None:
    key = bpy.data.lights["Key"]
    owner = next(obj for obj in studio.objects if obj.data == key)
    owner.name = "Left"
    other = bpy.data.objects.new("Right", key)
    other.location = (-2.0, -3.0, 4.0)
    studio.collection.objects.link(other)
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    assert bpy.ops.dichromatic.probe_pixel(x=20, y=5) == {"FINISHED"}
    report = last_render.kept_render(studio).probe_report
    for name in ("Left x", "Right x", "Fill x"):
        assert name in report
    assert "Key" not in report


def test_the_parts_of_a_pixel_stand_beside_their_shares(rendered: Any) -> None:
    assert bpy.ops.dichromatic.probe_pixel(x=20, y=5) == {"FINISHED"}
    total, *parts = last_render.kept_render(rendered).probe_report.splitlines()
    labels = draw(study_panels.DICHROMATIC_PT_image_probe, rendered).names("label")
    assert "".join(labels).startswith("Pixel (20, 5): Y")
    shares = [label for label in labels if label.endswith(" %")]
    assert shares == [part.split("%")[0].strip() + " %" for part in parts]
    assert "Key x" in " ".join(labels)
    assert total.startswith("pixel")


def _csv_rows() -> list[str]:
    return bpy.data.texts[studies.PROBE_TEXT].as_string().splitlines()[1:]


def test_reports_are_of_the_present_colours(rendered: Any) -> None:
    bpy.ops.dichromatic.probe_pixel(x=20, y=5)
    bpy.ops.dichromatic.metamerism_map()
    edited()
    kept = last_render.kept_render(rendered)
    assert kept.probe_report
    assert kept.map_report
    from_the_library(rendered)
    edited()
    assert (kept.probe_report, kept.map_report) == ("", "")


def test_a_picked_place_is_the_pixel_under_it(rendered: Any) -> None:
    said: list[str] = []
    operator = SimpleNamespace(report=lambda kind, text: said.append(text))
    pick = studies.DICHROMATIC_OT_pick_pixel.pick
    assert pick(operator, bpy.context, 0.51, 0.99) == {"FINISHED"}
    settings = rendered.dichromatic_studies
    assert (settings.probe_x, settings.probe_y) == (20, HEIGHT - 1)
    assert pick(operator, bpy.context, 1.01, 0.5) == {"CANCELLED"}
    assert said == ["that place lies outside the picture"]
    assert not bpy.ops.dichromatic.pick_pixel.poll()  # no Image Editor without a window


def test_a_pixel_picked_on_the_contact_sheet_is_that_of_its_picture(rendered: Any) -> None:
    """Four pictures in two rows: the same place in each is the same pixel of the render."""
    assert bpy.ops.dichromatic.contact_sheet(lamps="D65, A, FL2, FL11") == {"FINISHED"}
    sheet = bpy.data.images[studies.SHEET_IMAGE]
    gap = sheet.size[0] - 2 * WIDTH
    assert tuple(sheet.size) == (2 * WIDTH + gap, 2 * HEIGHT + gap)
    said: list[str] = []
    operator = SimpleNamespace(report=lambda kind, text: said.append(text))
    context = SimpleNamespace(
        scene=rendered, view_layer=bpy.context.view_layer, space_data=SimpleNamespace(image=sheet)
    )
    pick = studies.DICHROMATIC_OT_pick_pixel.pick
    settings = rendered.dichromatic_studies
    for left in (0, WIDTH + gap):
        for bottom in (0, HEIGHT + gap):
            settings.probe_x = settings.probe_y = 0
            place = (left + 31.5) / sheet.size[0], (bottom + 5.5) / sheet.size[1]
            assert pick(operator, context, *place) == {"FINISHED"}
            assert (settings.probe_x, settings.probe_y) == (31, 5)
    assert pick(operator, context, 0.5, 0.1) == {"CANCELLED"}
    context.space_data.image = bpy.data.images[studies.PROBE_IMAGE]
    assert pick(operator, context, 0.5, 0.5) == {"CANCELLED"}
    assert said == [
        "that place lies between the pictures",
        "'Dichromatic Probe' is a plot: pick a pixel in a picture of the render",
    ]


@pytest.mark.parametrize("side", ["right", "left", "beside", "hidden", "whole"])
@pytest.mark.parametrize("size", [(968, 548), (300, 200), (400, 3000)])
def test_a_sheet_is_shown_whole_where_nothing_lies_over_it(side: str, size: tuple[int, int]) -> None:
    """The editor shows the picture's pixel p at (p - middle - pan) zoom from the middle of its window."""
    window = SimpleNamespace(type="WINDOW", x=100, y=0, width=1322, height=849)
    sidebar = SimpleNamespace(type="UI", x=1131, y=0, width=291, height=849)
    free = (0, 1031)
    if side == "left":
        sidebar.x, free = 100, (291, 1322)
    elif side == "beside":  # without Blender's Region Overlap it takes from the window's width
        sidebar.x, free = 1422, (0, 1322)
    elif side == "hidden":
        sidebar.x, sidebar.width, free = 1421, 1, (0, 1322)
    elif side == "whole":  # nothing is free: as if it were not there
        sidebar.x, sidebar.width, free = 100, 1322, (0, 1322)
    span = image_view.free_span(window, [sidebar, window])
    assert span == free
    zoom, pan = image_view.whole_view(size, window.height, window.width, span)
    assert zoom <= 1.0
    corners = [
        [0.5 * length + (end - 0.5 * own - moved) * zoom for end in (0, own)]
        for length, own, moved in zip((window.width, window.height), size, pan, strict=True)
    ]
    room = [(free[0], free[1]), (0, window.height)]
    for (low, high), (first, last) in zip(corners, room, strict=True):
        assert first <= low < high <= last
        assert low - first == pytest.approx(last - high)  # in the middle
    assert zoom == 1.0 or min(low - first for (low, _), (first, _) in zip(corners, room, strict=True)) < 10.0


def test_a_black_pixel_can_be_probed(rendered: Any) -> None:
    rendered.camera.rotation_euler.x = math.radians(85)
    bpy.ops.render.render()
    assert bpy.ops.dichromatic.probe_pixel(x=0, y=HEIGHT - 1) == {"FINISHED"}
    assert "is black" in last_render.kept_render(rendered).probe_report


def test_the_plot_follows_the_values() -> None:
    wavelengths = np.linspace(400.0, 700.0, 61)
    ramp = np.linspace(0.0, 1.0, 61)[None]
    picture = plot_spectra(wavelengths, ramp, ("ramp",), "title")
    assert picture.shape == (PLOT_SIZE[1], PLOT_SIZE[0], 3)
    ink = (picture < 0.2).all(axis=-1)
    left, right, top, bottom = 96, PLOT_SIZE[0] - 25, 48, PLOT_SIZE[1] - 65
    for part in (0.25, 0.5):
        column = round(left + part * (right - left))
        rows = np.flatnonzero(ink[top : bottom - 3, column]) + top
        assert abs(rows.mean() - (bottom - part * (bottom - top))) <= 2.0
    many = plot_spectra(wavelengths, np.repeat(ramp, 12, axis=0), tuple("abcdefghijkl"), "title")
    assert many.shape == picture.shape


def test_letters_stay_inside_the_picture() -> None:
    picture = np.zeros((20, 30, 3))
    draw_text(picture, "W\N{GREEK SMALL LETTER BETA}", -3, 15, (1.0, 0.5, 0.0))
    assert picture[..., 0].sum() > 0
    assert set(np.unique(picture[..., 1])) == {0.0, 0.5}
    one = np.zeros((7, 5, 3))
    draw_text(one, "I", 0, 0, (1.0, 1.0, 1.0), scale=1)
    assert one[:, 2, 0].all()


@pytest.mark.parametrize("operator", ["metamerism_map", "contact_sheet", "probe_pixel", "save_render", "relight"])
def test_studies_need_a_render(studio: Any, operator: str) -> None:
    assert not getattr(bpy.ops.dichromatic, operator).poll()


# ---- files


def test_a_render_is_saved_and_opened(rendered: Any, tmp_path: Path) -> None:
    path = tmp_path / "kept.npz"
    assert bpy.ops.dichromatic.save_render(filepath=str(path)) == {"FINISHED"}
    before = pixels_of(IMAGE_NAME).copy()
    bpy.ops.dichromatic.free_render()
    bpy.data.images.remove(bpy.data.images[IMAGE_NAME])
    assert bpy.ops.dichromatic.open_render(filepath=str(path)) == {"FINISHED"}
    np.testing.assert_allclose(pixels_of(IMAGE_NAME), before, atol=FLOAT32_ROUNDING * before.max())
    assert last_render.kept_render(rendered).source == "kept.npz"
    assert "kept.npz" in draw(study_panels.DICHROMATIC_PT_studies, rendered).names("label")
    from_the_library(rendered)
    edited()
    assert_like_a_fresh_render(rendered)


def test_files_that_cannot_be_read_or_written_are_reported(rendered: Any, tmp_path: Path) -> None:
    (tmp_path / "no.npz").write_text("no render")
    with pytest.raises(RuntimeError, match="cannot be read as a render"):
        bpy.ops.dichromatic.open_render(filepath=str(tmp_path / "no.npz"))
    with pytest.raises(RuntimeError, match=r"must be|ends in \.npz"):
        bpy.ops.dichromatic.save_render(filepath=str(tmp_path / "kept.txt"))
    with pytest.raises(RuntimeError, match=r"ends in \.exr"):
        bpy.ops.dichromatic.write_spectral_exr(filepath=str(tmp_path / "kept.txt"))


def test_a_spectral_picture_is_written(rendered: Any, tmp_path: Path) -> None:
    pytest.importorskip("OpenImageIO")
    path = tmp_path / "spectra.exr"
    assert bpy.ops.dichromatic.write_spectral_exr(filepath=str(path)) == {"FINISHED"}
    assert path.stat().st_size > 61 * WIDTH * HEIGHT * 4 // 20


# ---- quality


@pytest.mark.parametrize("name", list(core.QUALITIES))
def test_a_quality_sets_what_the_core_says(studio: Any, name: str) -> None:
    settings = studio.dichromatic
    settings.quality = name
    assert settings.quality == name
    from dichromatic_addon.properties import read_settings

    wanted = core.quality_settings(name)
    used = read_settings(studio)
    for part in ("samples", "precision", "grid", "bounce_grid", "max_bounces"):
        assert getattr(used, part) == getattr(wanted, part)
    settings.samples += 1
    assert settings.quality == "custom"
    settings.quality = "custom"
    assert settings.samples == wanted.samples + 1


def test_a_new_file_has_standard_quality(scene: Any) -> None:
    assert scene.dichromatic.quality == "standard"
    assert {item[0] for item in quality.quality_items} == {*core.QUALITIES, "custom"}


def test_the_limit_of_products_reaches_the_core(studio: Any) -> None:
    from dichromatic_addon.properties import read_settings

    assert read_settings(studio).term_limit == core.RenderSettings().term_limit
    studio.dichromatic.term_limit = 9
    assert read_settings(studio).term_limit == 9


def test_the_estimate_is_shown_until_the_settings_change(studio: Any) -> None:
    assert bpy.ops.dichromatic.estimate() == {"FINISHED"}
    lines = draw(panels.DICHROMATIC_PT_sampling, studio).names("label")
    assert any(line.startswith("About ") for line in lines)
    assert any("mean" in line for line in lines)
    studio.dichromatic.samples = 3
    lines = draw(panels.DICHROMATIC_PT_sampling, studio).names("label")
    assert lines == ["Settings changed since the estimate"]
    studio.camera = None
    assert not bpy.ops.dichromatic.estimate.poll()


# ---- panels


def draw(panel: Any, scene: Any, space: Any = None) -> FakeLayout:
    """Draw a panel on a fake layout and return what it asked for."""
    layout = FakeLayout()
    context = SimpleNamespace(
        scene=scene,
        engine=scene.render.engine,
        view_layer=scene.view_layers[0],
        preferences=bpy.context.preferences,
        region=SimpleNamespace(width=400),
        space_data=space,
    )
    assert panel.poll(context)
    drawer = SimpleNamespace(layout=layout, bl_space_type=panel.bl_space_type)
    panel.draw(drawer, context)
    return layout


PANELS = [cls for cls in study_panels.CLASSES if "_PT_" in cls.__name__]


@pytest.mark.parametrize("panel", PANELS, ids=lambda panel: panel.__name__)
def test_panels_in_every_state(rendered: Any, panel: Any) -> None:
    draw(panel, rendered)
    bpy.ops.dichromatic.metamerism_map()
    bpy.ops.dichromatic.probe_pixel(x=3, y=3)
    bpy.ops.dichromatic.study_lamps(action="STANDARD")
    last_render.kept_render(rendered).problem = "a lamp is gone"
    layout = draw(panel, rendered)
    assert layout.names("operator")
    bpy.ops.dichromatic.free_render()
    if panel.bl_label in ("Studies", "Last Render"):
        assert layout.names("prop") == ["live_relight"]
        assert "dichromatic.open_render" in draw(panel, rendered).names("operator")
    else:
        context = SimpleNamespace(scene=rendered, engine=rendered.render.engine)
        assert not panel.poll(context)


def test_the_image_editor_shows_a_kept_render_with_any_engine(rendered: Any) -> None:
    rendered.render.engine = "BLENDER_WORKBENCH"
    draw(study_panels.DICHROMATIC_PT_image, rendered)
    bpy.ops.dichromatic.free_render()
    context = SimpleNamespace(scene=rendered, engine=rendered.render.engine)
    assert not study_panels.DICHROMATIC_PT_image.poll(context)


def test_settings_of_studies_have_tooltips(addon: Any) -> None:
    for cls in study_settings.CLASSES:
        for known in cls.bl_rna.properties:
            assert known.identifier in ("rna_type", "name") or known.description, known.identifier
    for cls in (*studies.CLASSES, *render_files.CLASSES, *live_relight.CLASSES):
        assert cls.bl_description
