"""Meshes, instances and what from_instances makes of them."""

import numpy as np
import pytest

from spectral_core.errors import RenderCancelledError, SceneError
from spectral_core.tracing import Geometry, Instance, Mesh
from tests.render.tracing_meshes import icosphere
from tests.tolerances import FLOAT32_ROUNDING, FLOAT64_ROUNDING

TRIANGLE = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)])


def test_nan_names_mesh_and_vertex():
    vertices = TRIANGLE.copy()
    vertices[2, 1] = np.nan
    with pytest.raises(SceneError, match=r"mesh 'cup': vertex 2 must be finite"):
        Mesh(vertices, [(0, 1, 2)], name="cup")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"triangles": [(0, 1, 3)]}, r"triangle 0 must use vertices 0 to 2, but uses \[0, 1, 3\]"),
        ({"triangles": [(0, 1, -1)]}, "must use vertices"),
        ({"triangles": [(0.5, 1.0, 2.0)]}, "must be integers"),
        ({"triangles": [(0, 1)]}, "must have the shape"),
        ({"triangles": [(0, 1, 2)], "corner_normals": np.zeros((2, 3, 3))}, "corner_normals must have the shape"),
        ({"triangles": [(0, 1, 2)], "corner_normals": np.full((1, 3, 3), np.inf)}, "corner_normals of triangle 0"),
        ({"triangles": [(0, 1, 2)], "uv": np.zeros((1, 3, 3))}, "uv must have the shape"),
        ({"triangles": [(0, 1, 2)], "material_index": [-1]}, r"material_index\[0\] must be at least 0"),
    ],
)
def test_broken_meshes_are_refused(arguments, message):
    with pytest.raises(SceneError, match=message):
        Mesh(vertices=TRIANGLE, **arguments)


def test_broken_matrices_are_refused():
    mesh = Mesh(TRIANGLE, [(0, 1, 2)], name="cup")
    with pytest.raises(SceneError, match="instance 'left': matrix must be finite"):
        Instance(mesh, np.full((4, 4), np.nan), name="left")
    with pytest.raises(SceneError, match="last row"):
        Instance(mesh, np.ones((4, 4)))
    with pytest.raises(SceneError, match="must have the shape"):
        Instance(mesh, np.eye(3))


def smooth_sphere(subdivisions=3):
    vertices, triangles = icosphere(subdivisions)
    return Mesh(vertices, triangles, corner_normals=vertices[triangles], name="sphere")


@pytest.mark.parametrize("mirror", [1.0, -1.0])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_normals_of_a_sheared_ellipsoid(mirror, dtype):
    """Points x of the unit sphere become A x + c; the normal there is A^-T x, the gradient of |A^-1 (p - c)|."""
    linear = np.array([(2.0, 0.4, 0.1), (0.0, 0.5, 0.3), (0.2, 0.0, 3.0)]) @ np.diag([mirror, 1.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, (100.0, -7.0, 3.0)
    geometry = Geometry.from_instances([Instance(smooth_sphere(), matrix)], dtype=dtype)
    count = geometry.triangle_count
    rounding = FLOAT32_ROUNDING if dtype == np.float32 else 1e3 * FLOAT64_ROUNDING
    corner0 = np.zeros(count, dtype)
    normal, geometric, tangent = geometry.shading(np.arange(count), corner0, corner0)
    world = geometry.points(np.arange(count), corner0, corner0) + geometry.centre
    unit = (world - matrix[:3, 3]) @ np.linalg.inv(linear).T
    expected = unit @ np.linalg.inv(linear)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(normal, expected, atol=20 * rounding)
    assert np.all(np.einsum("ij,ij->i", geometric, expected) > 0.8)  # winding turned with the mirror
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, atol=rounding)
    np.testing.assert_allclose(np.einsum("ij,ij->i", tangent, normal), 0.0, atol=rounding)
    corners = geometry.corners.astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(geometric, cross / np.linalg.norm(cross, axis=1, keepdims=True), atol=rounding)


def test_flat_and_zero_normals_fall_back_to_the_triangle():
    flat = Mesh(TRIANGLE, [(0, 1, 2)])
    silent = Mesh(TRIANGLE, [(0, 1, 2)], corner_normals=np.zeros((1, 3, 3)))
    opposed = np.array([[(1.0, 0, 0), (-1.0, 0, 0), (0, 0, 0)]])
    for instances in ([Instance(flat)], [Instance(silent)], [Instance(flat), Instance(smooth_sphere(0))]):
        geometry = Geometry.from_instances(instances)
        normal, geometric, _ = geometry.shading(np.array([0]), np.array([0.3]), np.array([0.3]))
        np.testing.assert_array_equal(normal, [(0, 0, 1)])
        np.testing.assert_array_equal(geometric, [(0, 0, 1)])
    geometry = Geometry.from_instances([Instance(Mesh(TRIANGLE, [(0, 1, 2)], corner_normals=opposed))])
    normal, _, _ = geometry.shading(np.array([0]), np.array([0.5]), np.array([0.0]))
    np.testing.assert_array_equal(normal, [(0, 0, 1)])  # the two corners cancel


def test_tangent_follows_the_texture():
    angle = 0.7
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    uv = (TRIANGLE[:, :2] @ turn)[None]  # u grows along (cos, sin)
    for flip in (1.0, -1.0):
        mesh = Mesh(TRIANGLE, [(0, 1, 2)], uv=uv * (1.0, flip))
        geometry = Geometry.from_instances([Instance(mesh)], dtype=np.float64)
        _, _, tangent = geometry.shading(np.array([0]), np.array([0.2]), np.array([0.2]))
        np.testing.assert_allclose(tangent, [(np.cos(angle), np.sin(angle), 0.0)], atol=FLOAT64_ROUNDING)
        at = geometry.texture_coordinates(np.array([0]), np.array([0.25]), np.array([0.5]))
        np.testing.assert_allclose(at[0], uv[0].T @ (0.25, 0.25, 0.5) * (1.0, flip), atol=FLOAT64_ROUNDING)


def test_tangent_without_a_texture_points_east():
    geometry = Geometry.from_instances([Instance(smooth_sphere(2))], dtype=np.float64)
    triangles = np.arange(geometry.triangle_count)
    third = np.full(len(triangles), 1 / 3)
    normal, _, tangent = geometry.shading(triangles, third, third)
    east = np.cross((0.0, 0.0, 1.0), normal)
    np.testing.assert_allclose(np.einsum("ij,ij->i", tangent, east), np.linalg.norm(east, axis=1), atol=1e-9)
    flat = Geometry.from_instances([Instance(Mesh(TRIANGLE, [(0, 1, 2)]))])
    np.testing.assert_array_equal(flat.shading(np.array([0]), np.array([0.1]), np.array([0.1]))[2], [(1, 0, 0)])


def test_triangles_without_area_are_dropped_and_counted():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (0, 1 + 1e-12, 0)], float)
    mesh = Mesh(vertices, [(0, 1, 2), (0, 1, 3), (0, 0, 1), (0, 3, 4)], material_index=[0, 3, 0, 0])
    single = Geometry.from_instances([Instance(mesh)])
    assert (single.triangle_count, single.dropped) == (1, 3)
    assert single.material_index.tolist() == [3]
    tiny = Geometry.from_instances([Instance(Mesh(TRIANGLE * 1e-30, [(0, 1, 2)]))])
    assert (tiny.triangle_count, tiny.dropped) == (1, 0)


def test_instances_keep_order_flags_and_places():
    sphere, triangle = smooth_sphere(1), Mesh(TRIANGLE, [(0, 1, 2)], material_index=[2])
    moved = np.eye(4)
    moved[:3, 3] = (1e4, 0, 0)
    geometry = Geometry.from_instances(
        [Instance(triangle, camera_visible=False), Instance(sphere, moved, shadow_visible=False), Instance(triangle)]
    )
    assert geometry.instance_index.tolist() == [0] + [1] * 80 + [2]
    assert geometry.material_index.tolist() == [2] + [0] * 80 + [2]
    assert np.flatnonzero(~geometry.camera_visible).tolist() == [0]
    assert np.flatnonzero(~geometry.shadow_visible).tolist() == list(range(1, 81))
    np.testing.assert_array_equal(geometry.recentred(geometry.centre + np.arange(1.0, 4.0)), (1, 2, 3))
    low, high = geometry.corners.min(axis=(0, 1)), geometry.corners.max(axis=(0, 1))
    np.testing.assert_allclose(low, -high, rtol=1e-6)
    np.testing.assert_allclose(geometry.radius, np.linalg.norm(high), rtol=1e-6)


def test_empty_scenes():
    for instances in ([], [Instance(Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)))], [Instance(Mesh(TRIANGLE, []))]):
        geometry = Geometry.from_instances(instances)
        assert (geometry.triangle_count, geometry.radius, geometry.dropped) == (0, 0.0, 0)
        assert geometry.corners.shape == (0, 3, 3)
        none = np.zeros(0, np.int64)
        assert geometry.shading(none, np.zeros(0), np.zeros(0))[0].shape == (0, 3)


def test_a_distant_scene_keeps_its_small_features():
    """Recentring happens before the cast: at 1e6 a float32 would not even resolve the triangle."""
    matrix = np.eye(4)
    matrix[:3, 3] = 1e6
    geometry = Geometry.from_instances([Instance(Mesh(TRIANGLE * 1e-2, [(0, 1, 2)]), matrix)])
    np.testing.assert_allclose(np.diff(geometry.corners[0], axis=0), np.diff(TRIANGLE * 1e-2, axis=0), atol=1e-9)


def test_an_end_is_asked_for_within_one_large_mesh():
    mesh = big_sheet(200)
    whole = Geometry.from_instances([Instance(mesh)])
    asked = 0

    def count():
        nonlocal asked
        asked += 1

    counted = Geometry.from_instances([Instance(mesh)], stop_if_cancelled=count)
    assert asked == -(-len(mesh.triangles) // 2**14) > 2
    assert np.array_equal(whole.corners, counted.corners)

    def stop():
        raise RenderCancelledError("enough")

    with pytest.raises(RenderCancelledError):
        Geometry.from_instances([Instance(mesh)], stop_if_cancelled=stop)


@pytest.mark.parametrize("sliver", [False, True], ids=["all kept", "one dropped"])
def test_large_meshes_are_placed_as_small_ones_are(sliver):
    """Triangle by triangle as meshes of their own, over more than one run of them; one without area is left out."""
    mesh = big_sheet(100, sliver)
    matrix = np.array([(1.0, 0.2, 0, 3), (0, -2.0, 0.1, 4), (0.3, 0, 1.5, 5), (0, 0, 0, 1)])
    whole = Geometry.from_instances([Instance(mesh, matrix)], np.float64)
    assert whole.dropped == sliver
    probes = (0, 2**14 - 2, 2**14, len(mesh.triangles) - 1)
    for probe in probes:
        alone = Mesh(
            mesh.vertices[mesh.triangles[probe]],
            [(0, 1, 2)],
            corner_normals=mesh.corner_normals[probe : probe + 1],
            uv=mesh.uv[probe : probe + 1],
            material_index=mesh.material_index[probe : probe + 1],
        )
        one = Geometry.from_instances([Instance(alone, matrix)], np.float64)
        at = probe - (sliver and probe > 2**14 - 1)
        for name in ("geometric_normals", "corner_normals", "uv", "material_index"):
            np.testing.assert_allclose(getattr(whole, name)[at], getattr(one, name)[0], atol=FLOAT64_ROUNDING)
        # Coordinates of up to 300, taken from their centre and back.
        np.testing.assert_allclose(
            whole.corners[at] + whole.centre, one.corners[0] + one.centre, atol=300 * FLOAT64_ROUNDING
        )


def big_sheet(side, sliver=False):
    """A wavy sheet of 2 side^2 triangles with all that a mesh may have; one of them without area, if asked."""
    rng = np.random.default_rng(4)
    x, y = (part.ravel() for part in np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0)))
    vertices = np.stack([x, y, np.sin(x)], axis=1)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + side + 1], axis=1),
            np.stack([corner + 1, corner + side + 2, corner + side + 1], axis=1),
        ]
    )
    if sliver:
        triangles[2**14 - 1] = triangles[2**14 - 1, 0]
    normals = rng.normal(size=(len(triangles), 3, 3))
    return Mesh(
        vertices,
        triangles,
        corner_normals=normals / np.linalg.norm(normals, axis=2, keepdims=True),
        uv=rng.random((len(triangles), 3, 2)),
        material_index=rng.integers(0, 4, len(triangles)),
    )
