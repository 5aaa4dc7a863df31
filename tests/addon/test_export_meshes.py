"""Meshes, instances, materials and visibility flags as they come out of Blender's evaluated scene."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon.operators import render_layers
from tests.addon.building import add_camera, add_mesh, add_plane, small_picture, white_material
from tests.tolerances import FLOAT32_ROUNDING

pytestmark = pytest.mark.bpy


@pytest.fixture
def framed(scene: Any) -> Any:
    add_camera(scene)
    small_picture(scene, 4, 4)
    return scene


def exported(scene: Any) -> Any:
    return render_layers(scene)[0].exported


def test_positions_normals_uv_and_matrix(framed: Any) -> None:
    plane = add_plane(framed, size=2.0)
    layer = plane.data.uv_layers.new(name="UV")
    for corner, uv in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
        layer.uv[corner].vector = uv
    plane.location, plane.scale = (1, 2, 3), (2, 1, 1)
    (instance,) = exported(framed).scene.instances
    mesh = instance.mesh
    assert mesh.triangles.shape == (2, 3)
    np.testing.assert_array_equal(instance.matrix, [[2, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    np.testing.assert_allclose(mesh.corner_normals, np.broadcast_to([0, 0, 1], (2, 3, 3)), atol=FLOAT32_ROUNDING)
    # The corners' texture coordinates belong to the same corners as their positions.
    np.testing.assert_array_equal(mesh.vertices[mesh.triangles][..., :2], 2 * mesh.uv - 1)


def test_smooth_and_flat_faces_have_their_own_normals(framed: Any) -> None:
    # Two faces that meet at a right angle along x = 0.
    corners = [(-1, 0, 0), (0, 0, 0), (0, 1, 0), (-1, 1, 0), (0, 0, -1), (0, 1, -1)]
    roof = add_mesh(framed, "Roof", corners, [(0, 1, 2, 3), (1, 4, 5, 2)])
    flat = exported(framed).scene.instances[0].mesh.corner_normals
    assert {tuple(np.round(n, 5)) for n in flat.reshape(-1, 3)} == {(0, 0, 1), (1, 0, 0)}
    roof.data.shade_smooth()
    smooth = exported(framed).scene.instances[0].mesh
    at_ridge = (
        np.abs(smooth.vertices[smooth.triangles][..., 0]) + np.abs(smooth.vertices[smooth.triangles][..., 2]) == 0
    )
    expected = np.array([1, 0, 1]) / np.sqrt(2)
    np.testing.assert_allclose(
        smooth.corner_normals[at_ridge], np.broadcast_to(expected, (at_ridge.sum(), 3)), atol=FLOAT32_ROUNDING
    )


def test_modifiers_are_evaluated_at_render_level(framed: Any) -> None:
    plane = add_plane(framed)
    subdivision = plane.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 1, 3
    (instance,) = exported(framed).scene.instances
    assert len(instance.mesh.triangles) == 2 * 4**3


def test_linked_copies_and_collection_instances_share_one_mesh(framed: Any) -> None:
    plane = add_plane(framed)
    copy = plane.copy()
    copy.location.x = 20
    collection = bpy.data.collections.new("Group")
    collection.objects.link(copy)
    for place in range(3):
        empty = bpy.data.objects.new("Instancer", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location.y = 10.0 * place
        framed.collection.objects.link(empty)
    instances = exported(framed).scene.instances
    assert len(instances) == 4
    assert len({id(instance.mesh) for instance in instances}) == 1
    places = sorted(tuple(instance.matrix[:3, 3]) for instance in instances)
    assert places == [(0, 0, 0), (20, 0, 0), (20, 10, 0), (20, 20, 0)]


def test_curves_text_surfaces_and_metaballs_come_once(framed: Any) -> None:
    curve = bpy.data.curves.new("Tube", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (0, 0, 0, 1), (1, 0, 0, 1)
    text = bpy.data.curves.new("Text", "FONT")
    text.body = "o"
    ball = bpy.data.metaballs.new("Ball")
    ball.elements.new()
    for data in (curve, text, ball):
        data.materials.append(white_material(data.name))
        framed.collection.objects.link(bpy.data.objects.new(data.name, data))
    scene = exported(framed).scene
    found = {instance.name: instance.mesh for instance in scene.instances}
    assert sorted(found) == ["Ball", "Text", "Tube"]
    assert len(scene.instances) == 3
    for name, mesh in found.items():
        assert len(mesh.triangles) > 10
        assert {scene.material_names[i] for i in np.unique(mesh.material_index)} == {name}


def test_material_slots(framed: Any) -> None:
    first, second, third = (white_material(name) for name in ("First", "Second", "Third"))
    corners = [(x, y, 0) for x in range(4) for y in range(2)]
    faces = [(2 * x, 2 * x + 2, 2 * x + 3, 2 * x + 1) for x in range(3)]
    strip = add_mesh(framed, "Strip", corners, faces, first, second, None)
    for face, slot in enumerate((0, 1, 2)):
        strip.data.polygons[face].material_index = slot
    other = strip.copy()  # the same mesh with a slot that the object itself fills
    other.name = "Other"
    framed.collection.objects.link(other)
    other.material_slots[1].link = "OBJECT"
    other.material_slots[1].material = third
    scene = exported(framed).scene

    def names(instance: Any) -> list[str]:
        return [scene.material_names[i] for i in instance.mesh.material_index[::2]]

    by_name = {instance.name: instance for instance in scene.instances}
    assert names(by_name["Strip"]) == ["First", "Second", "(no material)"]
    assert names(by_name["Other"]) == ["First", "Third", "(no material)"]
    assert by_name["Strip"].mesh.vertices is by_name["Other"].mesh.vertices


def test_index_beyond_the_slots_means_the_last_slot(framed: Any) -> None:
    plane = add_plane(framed, white_material("First"), white_material("Second"))
    plane.data.polygons[0].material_index = 7
    scene = exported(framed).scene
    assert [scene.material_names[i] for i in scene.instances[0].mesh.material_index] == ["Second", "Second"]


def test_view_layer_override_replaces_all_materials(framed: Any) -> None:
    add_plane(framed, white_material("Own"))
    framed.view_layers[0].material_override = white_material("Override")
    scene = exported(framed).scene
    assert scene.material_names == ("Override",)


def test_hidden_objects_and_visibility_flags(framed: Any) -> None:
    for name in ("Seen", "Hidden", "Unseen", "Shadowless", "Neither"):
        add_plane(framed, name=name)
    bpy.data.objects["Hidden"].hide_render = True
    bpy.data.objects["Unseen"].visible_camera = False
    bpy.data.objects["Shadowless"].visible_shadow = False
    bpy.data.objects["Neither"].visible_camera = bpy.data.objects["Neither"].visible_shadow = False
    flags = {i.name: (i.camera_visible, i.shadow_visible) for i in exported(framed).scene.instances}
    assert flags == {"Seen": (True, True), "Unseen": (False, True), "Shadowless": (True, False)}


def test_masks_come_from_objects_collections_and_instancers(framed: Any) -> None:
    add_plane(framed, name="Plain")
    add_plane(framed, name="Catcher").is_shadow_catcher = True
    hole = add_plane(framed, name="Hole")
    hole.is_holdout = hole.is_shadow_catcher = True
    inside = bpy.data.collections.new("Inside")
    framed.collection.children.link(inside)
    held = add_plane(framed, name="Held")
    framed.collection.objects.unlink(held)
    inside.objects.link(held)
    shown = bpy.data.collections.new("Shown")
    member = add_plane(framed, name="Member")
    framed.collection.objects.unlink(member)
    shown.objects.link(member)
    instancer = bpy.data.objects.new("Instancer", None)
    instancer.instance_type, instancer.instance_collection, instancer.is_holdout = "COLLECTION", shown, True
    framed.collection.objects.link(instancer)
    framed.view_layers[0].layer_collection.children["Inside"].holdout = True
    masks = {i.name: i.mask for i in exported(framed).scene.instances}
    assert masks == {
        "Plain": "",
        "Catcher": "shadow_catcher",
        "Hole": "holdout",
        "Held": "holdout",
        "Member": "holdout",
    }


def test_an_indirect_collection_is_hidden_from_the_camera_alone(framed: Any) -> None:
    aside = bpy.data.collections.new("Aside")
    framed.collection.children.link(aside)
    plane = add_plane(framed, name="Aside")
    framed.collection.objects.unlink(plane)
    aside.objects.link(plane)
    framed.view_layers[0].layer_collection.children["Aside"].indirect_only = True
    (instance,) = exported(framed).scene.instances
    assert (instance.camera_visible, instance.shadow_visible) == (False, True)


def test_faceless_meshes_are_left_out(framed: Any) -> None:
    add_mesh(framed, "Wire", [(0, 0, 0), (1, 0, 0)], [])
    add_mesh(framed, "Nothing", [], [])
    assert exported(framed).scene.instances == ()


def test_what_is_not_rendered_is_noted(framed: Any) -> None:
    framed.collection.objects.link(bpy.data.objects.new("Smoke", bpy.data.volumes.new("Smoke")))
    framed.render.use_motion_blur = True
    notes = " / ".join(exported(framed).notes)
    for part in ("'Smoke' is a volume", "motion blur"):
        assert part in notes
