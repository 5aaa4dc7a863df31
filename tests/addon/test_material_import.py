"""Importing fitted materials: the nodes say what the file says, keep it in every way a file travels, or say why not."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon import material_notes, panels
from dichromatic_addon.names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE
from dichromatic_addon.nodes.editing import set_surface_node, surface_node_of
from dichromatic_addon.nodes.imported import record_of
from dichromatic_addon.nodes.reading import link_problems, read_material
from dichromatic_addon.presets import PRESETS, apply_preset
from spectral_core import fitting
from spectral_core.reflection import MeasuredMeanReflectance, OpticalMeanReflectance, SchlickMeanReflectance
from tests.addon.fake_layout import FakeLayout
from tests.tolerances import BLENDER_FLOAT, COEFFICIENTS_OF_FLOAT32_PARAMETERS

pytestmark = pytest.mark.bpy

WAVELENGTHS = np.array([400.0, 450.3, 511.7, 600.0, 700.0])
RED = core.Spectrum(WAVELENGTHS, np.array([0.1, 0.12, 1 / 3, 0.61, 0.7]), "red", "lagrange")
PINK = core.Spectrum(WAVELENGTHS, np.array([1.5, 1.1, 0.9, 0.8, 2.0 / 3.0]), "pink")
INCIDENCE = np.radians([10.0, 45.0, 70.0])

MATERIALS = {
    "I": core.TypeI(RED, 4.7, "exponential", 10.1),
    "II": core.TypeII(RED, PINK, "gaussian", 33.3, energy_conserving=True),
    "III schlick": core.TypeIII(RED, SchlickMeanReflectance(0.37), math.radians(7.3)),
    "III table": core.TypeIII(
        RED, MeasuredMeanReflectance(INCIDENCE, np.array([0.4, 0.45, 0.6])), 0.1, 0.23, "surface", True
    ),
    "III optical": core.TypeIII(RED, OpticalMeanReflectance(np.array([0.3, 1.1]), np.array([3.3, 2.2])), 0.11),
}
PROVENANCE = fitting.Provenance(
    "satin.csv",
    "II",
    ("two components hold 99.9 % of the variance",),
    ("S_I is known up to a factor",),
    (fitting.Interval("n", 10.1, 9.8, 10.4, ""), fitting.Interval("beta", 0.1, 0.09, 0.11, "rad")),
    0.95,
    0.012,
)


@pytest.fixture
def material(scene):
    """A material on the active object, as the panel's operators want it."""
    mesh = bpy.data.meshes.new("Tile")
    material = bpy.data.materials.new("Tile")
    mesh.materials.append(material)
    obj = bpy.data.objects.new("Tile", mesh)
    scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return material


def write(tmp_path, kind, name="tile"):
    path = tmp_path / "material.json"
    fitting.write_material_json(path, MATERIALS[kind], name, PROVENANCE)
    return path


def directions(count=200):
    """Unit vectors to lights and viewers above a surface with the normal z."""
    generator = np.random.default_rng(4)
    vectors = generator.normal(size=(2, count, 3))
    vectors[..., 2] = np.abs(vectors[..., 2]) + 0.1
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def assert_same(read, expected):
    """Assert that a material is another to the rounding of the sockets' 32 bits."""
    assert type(read) is type(expected)
    assert read.component_names == expected.component_names
    for mine, theirs in zip(read.reflectances, expected.reflectances, strict=True):
        assert mine.interpolation == theirs.interpolation
        np.testing.assert_array_equal(mine.wavelengths_nm, theirs.wavelengths_nm)
        np.testing.assert_allclose(mine.values, theirs.values, rtol=BLENDER_FLOAT)  # S_I of Type I is a socket
    to_light, to_viewer = directions()
    normal, tangent = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    mine = read.coefficients(normal, to_light, to_viewer, tangent)
    theirs = expected.coefficients(normal, to_light, to_viewer, tangent)
    assert np.ptp(theirs) > 0.1
    np.testing.assert_allclose(mine, theirs, rtol=COEFFICIENTS_OF_FLOAT32_PARAMETERS, atol=1e-12)


@pytest.mark.parametrize("kind", MATERIALS)
def test_nodes_rebuild_the_material(material, tmp_path, kind):
    assert bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, kind))) == {"FINISHED"}
    reading = read_material(material)
    assert reading.notes == ()
    assert_same(reading.material, MATERIALS[kind])
    for spectrum, expected in zip(reading.material.reflectances, MATERIALS[kind].reflectances, strict=True):
        if not expected.is_constant:
            assert spectrum == expected  # to the last bit
            assert spectrum.name == expected.name
    node = surface_node_of(material)
    assert link_problems(node) == []
    assert record_of(node).provenance == PROVENANCE


@pytest.mark.parametrize("kind", MATERIALS)
@pytest.mark.parametrize("before", ["nothing", PLASTIC_NODE, CLOTH_NODE, METAL_NODE, "imported", "linked"])
def test_whatever_the_material_was(material, tmp_path, kind, before):
    if before == "imported":
        bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "III table")))
    elif before == "linked":
        apply_preset(material, next(preset for preset in PRESETS if preset.node_type == PLASTIC_NODE))
        node = surface_node_of(material)
        value = material.node_tree.nodes.new("ShaderNodeValue")
        material.node_tree.links.new(value.outputs[0], node.inputs["n"])
        node.inputs["Mirror"].default_value = 0.5
    elif before != "nothing":
        set_surface_node(material, before).inputs["Mirror"].default_value = 0.5
    path = write(tmp_path, kind)
    assert bpy.ops.dichromatic.import_material(filepath=str(path)) == {"FINISHED"}
    assert_same(read_material(material).material, MATERIALS[kind])
    assert read_material(material).material.mirror == 0.0
    ours = [node for node in material.node_tree.nodes if node.bl_idname == "DichromaticNodeSpectrum"]
    assert len(ours) == {"I": 1, "II": 2}.get(kind, 0)  # nothing of the old material is left over


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda content: content.pop("material"), "material is missing"),
        (lambda content: content["material"].update(n=-1.0), "n must"),
        (lambda content: content.update(version=9), "version must lie between"),
        (lambda content: content["material"].update(interface_reflectance=2e6), r"must lie between 0 and 1e\+06"),
    ],
)
def test_a_bad_file_changes_nothing(material, tmp_path, change, reason):
    set_surface_node(material, METAL_NODE).metal = "gold"
    before = sorted(node.name for node in material.node_tree.nodes), read_material(material).material
    path = write(tmp_path, "I")
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    with pytest.raises(RuntimeError, match=reason):
        bpy.ops.dichromatic.import_material(filepath=str(path))
    assert (sorted(node.name for node in material.node_tree.nodes), read_material(material).material) == before


def test_reasons_name_the_file_and_the_material(material, tmp_path):
    with pytest.raises(RuntimeError, match="there is no such file"):
        bpy.ops.dichromatic.import_material(filepath=str(tmp_path / "missing.json"))
    (tmp_path / "text.json").write_text("no json")
    with pytest.raises(RuntimeError, match=r"text\.json: cannot be read as JSON"):
        bpy.ops.dichromatic.import_material(filepath=str(tmp_path / "text.json"))
    with pytest.raises(RuntimeError, match="no material 'Gone'"):
        bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "I")), material_name="Gone")


@pytest.mark.parametrize("kind", ["II", "III table"])
def test_it_travels_with_the_blend(material, tmp_path, kind):
    path = write(tmp_path, kind)
    bpy.ops.dichromatic.import_material(filepath=str(path))
    path.unlink()  # from now on the .blend alone has it
    copy = material.copy()
    copy.name = "Copy"
    blend = str(tmp_path / "scene.blend")
    copy.use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.open_mainfile(filepath=blend)
    for name in ("Tile", "Copy"):
        assert_same(read_material(bpy.data.materials[name]).material, MATERIALS[kind])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for link in (False, True):
        with bpy.data.libraries.load(blend, link=link) as (_, loaded):
            loaded.materials = ["Tile"]
        brought = loaded.materials[0]
        assert_same(read_material(brought).material, MATERIALS[kind])
        assert record_of(surface_node_of(brought)).name == "tile"


def test_another_source_and_back(material, tmp_path):
    bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "I")))
    spectrum = surface_node_of(material).inputs["Body Reflectance"].links[0].from_node
    assert spectrum.draw_label() == "red"
    spectrum.source = "FILE"
    spectrum.filepath = str(tmp_path / "missing.csv")
    spectrum.source = "STORED"
    assert read_material(material).material.body_reflectance == RED
    bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "III table")))
    metal = surface_node_of(material)
    metal.source, metal.metal = "LIBRARY", "silver"
    assert read_material(material).material.normal_reflectance.name == "silver"
    metal.source = "IMPORTED"
    assert_same(read_material(material).material, MATERIALS["III table"])


def test_a_preset_ends_the_import(material, tmp_path):
    bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "III table")))
    apply_preset(material, next(preset for preset in PRESETS if preset.name == "Gold"))
    assert record_of(surface_node_of(material)) is None
    assert read_material(material).material.normal_reflectance.name == "gold"


def test_nothing_imported_is_said(material):
    metal = set_surface_node(material, METAL_NODE)
    metal.source = "IMPORTED"
    assert "no metal has been imported" in link_problems(metal)[0]
    with pytest.raises(core.SceneError, match=r"node 'Dichromatic Metal' in material 'Tile': no metal"):
        read_material(material)
    spectrum = material.node_tree.nodes.new("DichromaticNodeSpectrum")
    spectrum.source = "STORED"
    assert spectrum.draw_label() == "Imported Spectrum"
    assert "no samples have been imported" in link_problems(spectrum)[0]


def test_damaged_samples_are_said(material, tmp_path):
    bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "I")))
    spectrum = surface_node_of(material).inputs["Body Reflectance"].links[0].from_node
    for text in ("[]", "{", '{"wavelengths_nm": [400], "values": ["x"], "name": "", "interpolation": "linear"}'):
        spectrum["dichromatic_imported_spectrum"] = text
        with pytest.raises(core.SceneError, match="samples are damaged"):
            read_material(material)


def test_other_engines_see_the_colour(material, tmp_path):
    bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "III schlick")))
    red, _, blue, _ = surface_node_of(material).inputs["RGB"].default_value
    assert red > 3 * blue


class OpenLayout(FakeLayout):
    """A layout whose panels were all opened."""

    def _sub(self, **_):
        return OpenLayout(self.drawn)

    row = column = box = _sub

    def panel(self, idname, *, default_closed=False):
        return self._sub(), self._sub()


def draw(material, scene):
    """Draw the material panel and return the texts in it."""
    layout = OpenLayout()
    context = SimpleNamespace(
        scene=scene,
        engine="DICHROMATIC",
        preferences=bpy.context.preferences,
        region=SimpleNamespace(width=4000),
        material=material,
    )
    panels.DICHROMATIC_PT_material.draw(SimpleNamespace(layout=layout), context)
    return layout


def test_the_panel_shows_where_it_comes_from(material, tmp_path, scene):
    assert "dichromatic.import_material" in draw(material, scene).names("operator")
    bpy.ops.dichromatic.import_material(filepath=str(write(tmp_path, "III table")))
    layout = draw(material, scene)
    assert "incidence" in layout.names("prop")
    labels = layout.names("label")
    for expected in (
        "Imported: tile",
        "Fitted to satin.csv, residual 0.012 of the data",
        "95% intervals when imported:",
        "n = 10.1 (9.8 to 10.4)",
        "beta = 0.1 rad (0.09 to 0.11)",
        *PROVENANCE.evidence,
        *PROVENANCE.notes,
    ):
        assert expected in labels
    surface_node_of(material)["dichromatic_material_record"] = "{"
    assert any("imported material: cannot be read as JSON" in text for text in draw(material, scene).names("label"))


def test_the_panel_warns_of_created_light(material, scene):
    node = set_surface_node(material, METAL_NODE)
    node.inputs["beta"].default_value = math.radians(40.0)
    found = [text for text in draw(material, scene).names("label") if "times what it receives" in text]
    assert found == list(core.energy_warnings(read_material(material).material))
    node.energy_conserving = True
    assert not [text for text in draw(material, scene).names("label") if "receives" in text]


def test_warnings_are_computed_once_a_material(material, scene, monkeypatch):
    node = set_surface_node(material, METAL_NODE)
    material_notes.unregister()  # forget what other tests drew
    calls = []
    monkeypatch.setattr(core, "energy_warnings", lambda given: calls.append(given) or ())
    for beta in (0.4321, 0.4321, 0.4322):
        node.inputs["beta"].default_value = beta
        draw(material, scene)
    assert len(calls) == 2
    material_notes.unregister()


def test_in_a_window_warnings_wait_until_the_values_rest(material, scene, monkeypatch):
    material_notes.unregister()
    node = set_surface_node(material, METAL_NODE)
    computed = []
    told = core.energy_warnings
    with monkeypatch.context() as patch:
        patch.setattr(core, "energy_warnings", lambda given: computed.append(given) or told(given))
        patch.setattr(material_notes, "bpy", SimpleNamespace(app=WindowedApp(), context=bpy.context))
        for degrees in (40.0, 41.0, 42.0):  # a slider that is dragged
            node.inputs["beta"].default_value = math.radians(degrees)
            assert not [text for text in draw(material, scene).names("label") if "receives" in text]
        assert computed == []
        bpy.app.timers.unregister(material_notes._after_rest)
        material_notes._after_rest()
        assert len(computed) == 1
        assert [text for text in draw(material, scene).names("label") if "beta = 42 deg" in text]
    material_notes.unregister()


class WindowedApp:
    """bpy.app of a Blender with a window."""

    background = False
    timers = bpy.app.timers
