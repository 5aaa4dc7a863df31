"""The sample files: what they hold, that their scripts still make it, and that what they show can be seen."""

from __future__ import annotations

import importlib
import importlib.util
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.tolerances import FLOAT32_ROUNDING, PAINT_OF_A_FILE

pytestmark = [
    pytest.mark.bpy,
    pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="needs the bpy module"),
]

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
NAMES = ["cups", "metal_balls", "colour_booth", "cloth", "texture"]
LARGEST = 2_000_000  # bytes
SIZE = (192, 108)
LOBE = ("attenuation", "n", "beta", "beta_across", "mirror", "energy_conserving")  # of a material, besides its spectra


@pytest.fixture(autouse=True)
def registered(addon: Any) -> None:
    """The add-on, in every test."""


@pytest.fixture(scope="module", autouse=True)
def closed(addon: Any) -> Iterator[None]:
    """No file left open: as a module, Blender 4.2 crashes at its exit over the pointers in one."""
    import bpy

    yield
    bpy.ops.wm.read_factory_settings(use_empty=True)


def script(name: str) -> ModuleType:
    if str(SAMPLES) not in sys.path:
        sys.path.insert(0, str(SAMPLES))
    return importlib.import_module(f"make_{name}")


def opened(name: str) -> Any:
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{name}.blend"), load_ui=False)
    return bpy.context.scene


def mesh_arrays(mesh: Any) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.float32]]:
    """Positions (V, 3), corner vertices (C,) and corner normals (C, 3)."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    normals = np.empty(3 * len(mesh.loops), np.float32)
    mesh.corner_normals.foreach_get("vector", normals)
    return positions.reshape(-1, 3), corners, normals.reshape(-1, 3)


def described(scene: Any) -> dict[str, Any]:
    """Everything of a scene that makes its picture, in plain values."""
    from dichromatic_addon.nodes.reading import read_material
    from dichromatic_addon.properties import read_display, read_illuminant, read_settings
    from dichromatic_addon.world_reading import read_world

    found: dict[str, Any] = {"settings": read_settings(scene), "white": read_display(scene).white.key}
    found["camera"] = scene.camera.name
    found["world"] = scene.world and (scene.world.dichromatic.lights_surfaces, read_world(scene.world, []).strength)
    for item in scene.objects:
        found[item.name] = {
            "type": item.type,
            "matrix": [tuple(row) for row in item.matrix_basis],
            "parent": item.parent.name if item.parent else None,
        }
        if item.type == "LIGHT":
            light = item.data
            found[item.name] |= {
                "kind": light.type,
                "energy": light.energy,
                "size": light.angle if light.type == "SUN" else light.shadow_soft_size,
                "illuminant": read_illuminant(light).key,
            }
        elif item.type == "CAMERA":
            found[item.name] |= {"lens": item.data.lens, "shift": (item.data.shift_x, item.data.shift_y)}
        elif item.type == "MESH":
            materials = [read_material(slot.material).material for slot in item.material_slots]
            found[item.name] |= {
                "mesh": [array.tobytes() for array in mesh_arrays(item.data)[:2]],
                "materials": [
                    (
                        type(m).__name__,
                        [s.key for s in m.reflectances],
                        [texture and texture.key for texture in m.textures],
                        getattr(m, "attenuation", ""),
                        getattr(m, "n", 0.0),
                    )
                    for m in materials
                ],
            }
    return found


def rendered(scene: Any) -> tuple[NDArray[np.float64], NDArray[np.floating]]:
    """Linear Rec.709 (H, W, 3) of a small picture, adapted as the file says, and its XYZ under the lamp."""
    from dataclasses import replace

    import spectral_core as core
    from dichromatic_addon.operators import render_layers

    finished = render_layers(
        scene, adjust=lambda settings: replace(settings, width=SIZE[0], height=SIZE[1], samples=4)
    )[0]
    xyz = finished.render.tristimulus().astype(np.float64)
    return core.display("srgb").linear(finished.exported.colour.adapted(xyz)), xyz


@pytest.fixture(scope="module")
def picture(addon: Any) -> NDArray[np.float64]:
    """Linear Rec.709 of cups.blend."""
    scene = opened("cups")
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    return rendered(scene)[0]


@pytest.mark.parametrize("name", NAMES)
def test_file_is_small_and_ready_to_render(name: str) -> None:
    import bpy

    assert (SAMPLES / f"{name}.blend").stat().st_size < LARGEST
    scene = opened(name)
    assert scene.render.engine == "DICHROMATIC"
    assert scene.camera is not None
    assert scene.view_settings.view_transform == "Standard"
    assert scene.render.dither_intensity == 0.0
    assert not bpy.data.libraries, "a sample carries everything itself"
    assert all(image.packed_file is not None for image in bpy.data.images), "and so its images"
    note = "".join(text.as_string() for text in bpy.data.texts)
    assert ("Mallett and Yuksel, 2019" if name == "texture" else "Tominaga 1996") in note
    assert "try" in note
    assert max(len(line) for line in note.splitlines()) <= 92, "the note fits a text editor"


@pytest.mark.parametrize("name", NAMES)
def test_file_opens_on_its_picture_and_its_note(name: str) -> None:
    """A newcomer sees the scene from its camera, and the note in the workspace Scripting."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{name}.blend"), load_ui=True)
    spaces = [space for screen in bpy.data.screens for area in screen.areas for space in area.spaces]
    views = [space for space in spaces if space.type == "VIEW_3D"]
    editors = [space for space in spaces if space.type == "TEXT_EDITOR"]
    assert len(views) > 1
    assert {view.region_3d.view_perspective for view in views} == {"CAMERA"}
    assert editors
    assert {editor.text for editor in editors} == {bpy.data.texts[0]}


@pytest.mark.parametrize("name", NAMES)
def test_script_makes_what_the_file_holds(name: str) -> None:
    import bpy

    in_file = described(opened(name))
    script(name).build()
    made = described(bpy.context.scene)
    assert made.keys() == in_file.keys()
    for key, value in made.items():
        assert value == in_file[key], key


def test_cups_are_the_paper_s_type_one() -> None:
    import spectral_core as core
    from dichromatic_addon.nodes.reading import read_material
    from dichromatic_addon.properties import read_illuminant

    scene = opened("cups")
    for name, body in (("Blue cup", "plastic blue"), ("Red cup", "plastic red")):
        (slot,) = scene.objects[name].material_slots
        reading = read_material(slot.material)
        assert reading.notes == ()
        material = reading.material
        assert isinstance(material, core.TypeI)
        assert (material.attenuation, material.n, material.interface_reflectance) == ("cosine", 11.0, 5.0)
        assert material.body_reflectance.key == core.reflectance(body).key
    lamps = [item.data for item in scene.objects if item.type == "LIGHT"]
    assert lamps
    for lamp in lamps:
        assert read_illuminant(lamp).key == core.illuminant("projector-halogen").key, lamp.name
    key = scene.objects["Key"]
    reach = math.dist(key.location, scene.objects["Blue cup"].location)
    assert key.data.shadow_soft_size < 0.05 * reach, "the key light is a point but for the lens of a projector"


@pytest.mark.parametrize("name", ["Blue cup", "Red cup"])
def test_cup_is_closed_and_shaded_by_its_own_surface(name: str) -> None:
    mesh = opened("cups").objects[name].data
    positions, corners, normals = mesh_arrays(mesh)
    edges: dict[tuple[int, int], int] = {}
    for polygon in mesh.polygons:
        loop = corners[polygon.loop_start : polygon.loop_start + polygon.loop_total].tolist()
        for pair in zip(loop, loop[1:] + loop[:1], strict=True):
            edges[pair] = edges.get(pair, 0) + 1
    assert all(count == 1 and edges.get(pair[::-1]) == 1 for pair, count in edges.items()), "a closed, oriented surface"
    volume = 0.0
    for polygon in mesh.polygons:
        ring = positions[corners[polygon.loop_start : polygon.loop_start + polygon.loop_total]].astype(np.float64)
        face = np.array(polygon.normal)
        volume += np.sum(np.cross(ring[1:-1], ring[2:]) @ ring[0]) / 6.0
        if polygon.area > 1e-9 and polygon.loop_total <= 4:
            shading = normals[polygon.loop_start : polygon.loop_start + polygon.loop_total]
            assert np.min(shading @ face) > math.cos(math.radians(35.0)), "normals look out of their own face"
    # A wall of 3.4 mm around 0.3 to 0.4 litres, and a handle: 60 to 130 ml of plastic.
    assert 60e-6 < volume < 130e-6


def test_cups_are_framed() -> None:
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    scene = opened("cups")
    for name in ("Blue cup", "Red cup"):
        item = scene.objects[name]
        seen = np.array(
            [world_to_camera_view(scene, scene.camera, item.matrix_world @ Vector(c)) for c in item.bound_box]
        )
        assert np.all(seen[:, :2] > 0.05), name
        assert np.all(seen[:, :2] < 0.95), name
        assert np.ptp(seen[:, 1]) > 0.4, "the cup fills a good part of the picture"


def test_ground_is_neutral_and_well_exposed(picture: NDArray[np.float64]) -> None:
    edge = np.concatenate([picture[:8].reshape(-1, 3), picture[-8:].reshape(-1, 3)])
    luminance = edge @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(edge, luminance[:, None] * np.ones(3), rtol=FLOAT32_ROUNDING)
    assert 0.4 < np.median(luminance) < 0.9
    assert np.max(luminance) < 1.0, "the ground is not burnt out"
    whole = picture @ [0.2126, 0.7152, 0.0722]
    assert np.mean(whole > 1.0) < 0.02, "only highlights are"
    assert np.max(whole) > 1.0, "and they are"
    assert np.mean(whole < 0.003) < 0.02, "no pitch black shadows"


def test_one_cup_is_blue_and_one_is_red(picture: NDArray[np.float64]) -> None:
    red, green, blue = np.moveaxis(picture, -1, 0)
    half = SIZE[0] // 2
    is_blue = (blue > 2.0 * red) & (blue > 1.5 * green) & (blue > 0.05)
    is_red = (red > 4.0 * green) & (red > 4.0 * blue) & (red > 0.05)
    assert np.mean(is_blue[:, :half]) > 0.08
    assert np.mean(is_red[:, half:]) > 0.08
    assert np.mean(is_blue[:, half:]) < 0.01
    assert np.mean(is_red[:, :half]) < 0.01


def test_balls_are_the_paper_s_type_three() -> None:
    import spectral_core as core
    from dichromatic_addon.nodes.reading import read_material
    from dichromatic_addon.properties import read_illuminant

    scene = opened("metal_balls")
    for name, kind in (("Copper ball", "copper"), ("Brass ball", "brass-70-30")):
        (slot,) = scene.objects[name].material_slots
        reading = read_material(slot.material)
        assert reading.notes == ()
        material = reading.material
        assert isinstance(material, core.TypeIII)
        assert material.beta == pytest.approx(math.radians(5.0), rel=FLOAT32_ROUNDING)
        assert material.beta_across > 2.0 * material.beta, "spun: rougher across the grooves"
        plain = core.TypeIII.from_optical_constants(core.optical_constants(kind), beta=material.beta)
        assert material.normal_reflectance.key == plain.normal_reflectance.key
    suns = [item.data for item in scene.objects if item.type == "LIGHT"]
    assert [sun.type for sun in suns] == ["SUN"] * 3, "three directional lights"
    assert {read_illuminant(sun).key for sun in suns} == {core.illuminant("D65").key}


def test_copper_is_left_and_redder_than_brass() -> None:
    scene = opened("metal_balls")
    assert scene.objects["Copper ball"].location.x < 0.0 < scene.objects["Brass ball"].location.x
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    picture = rendered(scene)[0]
    halves = picture[:, : SIZE[0] // 2], picture[:, SIZE[0] // 2 :]
    copper, brass = (half[half @ [0.2126, 0.7152, 0.0722] > 0.4].mean(axis=0) for half in halves)
    assert copper[0] > 1.2 * copper[1], "copper highlights are reddish"
    assert brass[0] < 1.2 * brass[1], "brass highlights are yellowish"
    assert brass[2] < 0.75 * brass[1], "brass highlights are yellowish"


def test_booth_s_paints_match_in_daylight_only() -> None:
    import spectral_core as core
    from dichromatic_addon.nodes.reading import read_material

    scene = opened("colour_booth")
    paints = [read_material(scene.objects[f"Tile, {label} paint"].active_material) for label in ("first", "second")]
    assert all(paint.notes == () for paint in paints)
    spectra = [paint.material.body_reflectance for paint in paints]
    assert spectra[0].key != spectra[1].key
    grid = core.wavelength_grid("exact")

    def difference(lamp: str, observer: str = "cie_1931_2") -> float:
        light, eye = core.illuminant(lamp), core.observer(observer)
        weights = core.tristimulus_weights(light, eye, grid)
        first, second = (
            core.lab(spectrum.at(grid.wavelengths_nm) @ weights, core.white_point(light, eye)) for spectrum in spectra
        )
        return float(core.delta_e_2000(first, second))

    assert difference("D65") < PAINT_OF_A_FILE
    assert difference("A") > 3.0
    assert difference("FL11") > 8.0
    assert difference("D65", "cie_1964_10") > 2.0


def test_booth_has_the_whole_chart_and_one_lamp() -> None:
    import spectral_core as core
    from dichromatic_addon.nodes.reading import read_material
    from dichromatic_addon.properties import read_display, read_illuminant

    scene = opened("colour_booth")
    patches = [item for item in scene.objects if item.name.startswith("Patch ")]
    assert len(patches) == 24
    for patch in patches:
        reading = read_material(patch.active_material)
        assert reading.material.body_reflectance.key == core.reflectance(patch.name.removeprefix("Patch ")).key
    (lamp,) = {item.data for item in scene.objects if item.type == "LIGHT"}
    for name in ("A", "FL11"):
        lamp.dichromatic.illuminant = name
        assert read_illuminant(lamp).key == core.illuminant(name).key
        assert read_display(scene).white.key == core.illuminant(name).key, "the picture adapts to the lamp"


def test_cloth_is_the_paper_s_type_two_seen_from_two_sides() -> None:
    import spectral_core as core
    from dichromatic_addon.nodes.reading import read_material

    scene = opened("cloth")
    reading = read_material(scene.objects["Cloth"].active_material)
    assert reading.notes == ()
    material = reading.material
    assert isinstance(material, core.TypeII)
    assert (material.attenuation, material.n) == ("exponential", 10.0)
    # The weave varies each spectrum between its gaps and its threads, in scale and not in shape.
    assert len(material.reflectances) == 4
    for spectrum, name in zip(material.reflectances, 2 * ["interface"] + 2 * ["body"], strict=True):
        measured = core.reflectance(f"satin green {name}")
        scale = spectrum.values / measured.at(spectrum.wavelengths_nm)
        np.testing.assert_allclose(scale, scale[0], rtol=FLOAT32_ROUNDING)
        assert 0.3 < scale[0] < 1.2
    views = [item for item in scene.objects if item.type == "CAMERA"]
    assert len(views) == 2
    first, second = (np.array(view.location)[:2] for view in views)
    angle = math.degrees(math.acos(first @ second / (np.linalg.norm(first) * np.linalg.norm(second))))
    assert angle == pytest.approx(90.0, abs=5.0), "vertical and horizontal"
    pictures = []
    for frame, name in enumerate(("Along the folds", "Across the folds"), 1):
        scene.frame_set(frame)
        assert scene.camera.name == name, "each view has its frame"
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        picture = rendered(scene)[0]
        red, green, blue = np.moveaxis(picture, -1, 0)
        assert np.all((green > red) & (green > blue)), "green cloth fills the picture"
        pictures.append(picture[..., 1])
    assert np.max(pictures[0]) < 1.1
    assert np.max(pictures[0]) > 2.0 * np.median(pictures[0]), "satin has highlights"


def test_texture_shows_its_picture_in_its_own_colours_and_the_lamp_changes_them() -> None:
    from dataclasses import replace

    import spectral_core as core
    from dichromatic_addon.nodes.reading import read_material
    from dichromatic_addon.operators import render_layers

    scene = opened("texture")
    for name, source in (("Mug", "UV"), ("Tile", "GENERATED")):
        reading = read_material(scene.objects[name].material_slots[0].material)
        assert reading.notes == ()
        assert reading.coordinates.kind == source
        assert reading.material.component_names == ("interface", "body red", "body green", "body blue")
    (layer,) = render_layers(scene, adjust=lambda settings: replace(settings, width=SIZE[0], height=SIZE[1], samples=1))

    def chromaticities(lamp: str) -> NDArray[np.float64]:
        """The left part of the picture, where the tile stands, as shares of red, green and blue."""
        xyz = core.relit_by(layer.render, core.illuminant(lamp)).tristimulus().astype(np.float64)
        rgb = np.maximum(core.display("srgb").linear(xyz)[16:78, 24:78].reshape(-1, 3), 0.0)
        return rgb[rgb.sum(axis=1) > 0.05] / rgb[rgb.sum(axis=1) > 0.05].sum(axis=1, keepdims=True)

    made = script("texture")
    in_daylight = chromaticities("D65")
    for code in made.PALETTE:
        colour = made.linear(code)
        nearest = np.abs(in_daylight - colour / colour.sum()).max(axis=1).min()
        assert nearest < 0.01, f"no pixel of the tile shows #{code}"  # a little of the interface whitens all
    sodium = chromaticities("HP1")
    assert sodium.std(axis=0)[2] < 0.5 * in_daylight.std(axis=0)[2], "blue falls out of sodium light"
