"""The tree against every triangle in turn; closed meshes that must not leak; surfaces that must not see themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.errors import RenderCancelledError
from spectral_core.tracing import Acceleration, Bvh, Geometry, Instance, Mesh, intersect, offset_origins
from spectral_core.tracing.clusters import cluster
from spectral_core.tracing.instancing import instanced_tree
from spectral_core.tracing.sah import binary_tree, half_area
from tests.render.tracing_meshes import brute_force, geometry_of, icosphere, random_directions, slenderness, soup
from tests.tolerances import TIED_DISTANCE

LEAK_PLACES = [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (1e-3, 1e4), (1.0, 1e4), (1e4, 1e4)]


def assert_same_hits(geometry, hits, origins, directions, own=None):
    """Every ray meets the triangle that brute force finds, or one at the same distance."""
    expected, _ = brute_force(geometry, origins, directions, own)
    np.testing.assert_array_equal(hits.hit, expected.hit)
    hit = np.flatnonzero(expected.hit)
    allowed = np.zeros(len(hit))
    for triangle in (hits.triangle[hit], expected.triangle[hit]):
        cosine = np.abs(np.einsum("ij,ij->i", geometry.geometric_normals[triangle], directions[hit]))
        allowed = np.maximum(allowed, TIED_DISTANCE * slenderness(geometry)[triangle] / cosine)
    assert np.all(np.abs(hits.distance[hit] - expected.distance[hit]) <= allowed * (1.0 + expected.distance[hit]))
    same = np.flatnonzero(hits.triangle[hit] == expected.triangle[hit])
    number = hit[same]
    for found, right in ((hits.u, expected.u), (hits.v, expected.v)):
        assert np.all(np.abs(found[number] - right[number]) <= 100.0 * allowed[same])  # in a triangle a tenth as large


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from([1, 2, 5, 9, 60, 300]), st.sampled_from([np.float32, np.float64]))
def test_soup_equals_brute_force(seed, count, dtype):
    rng = np.random.default_rng(seed)
    geometry = geometry_of(*soup(rng, count), dtype=dtype)
    bvh = Bvh.build(geometry)
    origins = (rng.normal(size=(400, 3))).astype(dtype)
    directions = random_directions(rng, 400).astype(dtype)
    directions[:40] = np.eye(3, dtype=dtype)[rng.integers(0, 3, 40)]  # along the axes
    expected, clear = brute_force(geometry, origins, directions)
    sure = clear > 1e-4  # closer to a border float32 and float64 may rightly disagree on a lone triangle
    origins, directions = origins[sure], directions[sure]
    assert_same_hits(geometry, bvh.closest(origins, directions), origins, directions)
    limit = 0.7
    decided = np.abs(expected.distance[sure] - limit) > 1e-4
    np.testing.assert_array_equal(
        bvh.occluded(origins, directions, limit)[decided], (expected.distance[sure] < limit)[decided]
    )


def test_left_out_triangle_and_end_of_ray():
    rng = np.random.default_rng(5)
    geometry = geometry_of(*soup(rng, 200))
    bvh = Bvh.build(geometry)
    origins, directions = rng.normal(size=(2000, 3)).astype(np.float32), random_directions(rng, 2000).astype(np.float32)
    first = bvh.closest(origins, directions)
    assert 100 < first.hit.sum() < 1900
    _, clear = brute_force(geometry, origins, directions)
    sure = (clear > 1e-4) & first.hit
    without = bvh.closest(origins[sure], directions[sure], own=first.triangle[sure])
    assert not np.any(without.triangle == first.triangle[sure])
    _, clear = brute_force(geometry, origins[sure], directions[sure], own=first.triangle[sure])
    again = np.flatnonzero(sure)[clear > 1e-4]
    without = bvh.closest(origins[again], directions[again], own=first.triangle[again])
    assert_same_hits(geometry, without, origins[again], directions[again], own=first.triangle[again])
    short = bvh.closest(origins, directions, t_max=0.999 * first.distance)
    assert not np.any(short.hit)
    assert not np.any(bvh.occluded(origins, directions, 0.999 * first.distance))
    assert np.array_equal(bvh.occluded(origins, directions, 1.001 * first.distance), first.hit)


def test_ties_give_the_lower_number():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
    geometry = geometry_of(vertices, np.array([(0, 1, 2)] * 37))
    hits = Bvh.build(geometry).closest(np.array([(-0.2, -0.2, 1.0)]), np.array([(0.0, 0.0, -1.0)]))
    assert hits.triangle.tolist() == [0]


@settings(max_examples=20, deadline=None)
@given(
    st.integers(0, 2**31),
    st.sampled_from([256, 300, 2000]),
    st.floats(0.0, 1.5),
    st.booleans(),
    st.sampled_from([np.float32, np.float64]),
)
def test_packets_find_what_single_rays_find(seed, count, spread, common, dtype):
    """Bit by bit, whether neighbours stay together or not, with ends and with triangles left out."""
    rng = np.random.default_rng(seed)
    geometry = geometry_of(*soup(rng, 400, size=0.1), dtype=dtype)
    bvh = Bvh.build(geometry)
    origins = (rng.normal(size=3) + (0.0 if common else spread) * rng.random((count, 3))).astype(dtype)
    directions = (rng.random(3) - 0.5 - origins + spread * rng.random((count, 3))).astype(dtype)
    directions[::37] = np.eye(3, dtype=dtype)[rng.integers(0, 3, len(directions[::37]))]
    t_max = np.where(rng.random(count) < 0.5, np.inf, 2.0 * rng.random(count))
    own = rng.integers(-1, geometry.triangle_count, count)
    hits, blocked = bvh.closest(origins, directions, t_max, own), bvh.occluded(origins, directions, t_max, own)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("spectral_core.tracing.packets._FEWEST", 10**9)
        alone = bvh.closest(origins, directions, t_max, own)
        np.testing.assert_array_equal(bvh.occluded(origins, directions, t_max, own), blocked)
    for name in ("triangle", "distance", "u", "v"):
        np.testing.assert_array_equal(getattr(hits, name), getattr(alone, name))
    np.testing.assert_array_equal(blocked, hits.hit)
    assert np.all(hits.distance[hits.hit] < t_max[hits.hit])
    assert not np.any(hits.hit & (hits.triangle == own))


def test_packets_are_really_cast(monkeypatch):
    """Parallel rays onto a ball stay together: few are left to be cast one by one."""
    left = []
    cast = intersect.trace_packets

    def counting(bvh, frame, nearest, **options):
        apart = cast(bvh, frame, nearest, **options)
        left.append((len(apart), len(frame)))
        return apart

    monkeypatch.setattr(intersect, "trace_packets", counting)
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-1, 1, 200)] * 2))
    origins = np.stack([x, y, np.full_like(x, 3.0)], axis=1)
    hits = Bvh.build(geometry_of(*icosphere(3))).closest(origins, np.broadcast_to((0.0, 0.0, -1.0), origins.shape))
    assert np.mean(hits.hit) == pytest.approx(np.pi / 4, rel=0.02)  # the polyhedron is smaller
    assert sum(a for a, _ in left) < 0.1 * sum(n for _, n in left)


def test_no_triangles_and_no_rays():
    empty = Geometry.from_instances([])
    bvh = Bvh.build(empty)
    hits = bvh.closest(np.zeros((3, 3)), np.ones((3, 3)))
    assert hits.triangle.tolist() == [-1, -1, -1]
    assert np.isinf(hits.distance).all()
    assert not bvh.occluded(np.zeros((3, 3)), np.ones((3, 3))).any()
    full = Bvh.build(geometry_of(*icosphere(0)))
    assert len(full.closest(np.zeros((0, 3)), np.zeros((0, 3)))) == 0
    assert full.occluded(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)


def test_some_triangles_only():
    geometry = geometry_of(*icosphere(2))
    upper = np.flatnonzero(geometry.corners[:, :, 2].min(axis=1) > 0)
    hits = Bvh.build(geometry, upper).closest(np.zeros((2, 3)), np.array([(0.1, 0.05, 1.0), (0.1, 0.05, -1.0)]))
    assert hits.triangle[0] in upper
    assert hits.triangle[1] == -1


def test_directions_need_no_unit_length_and_far_origins_are_exact():
    rng = np.random.default_rng(3)
    geometry = geometry_of(*icosphere(3))
    bvh = Bvh.build(geometry)
    targets = random_directions(rng, 1000) * rng.random((1000, 1)) * 0.9
    near = bvh.closest(targets - 2.0, np.full((1000, 3), 1.0))
    far = bvh.closest(targets - 1e6, np.full((1000, 3), 1e3))
    assert near.hit.all()
    assert np.mean(near.triangle != far.triangle) < 0.002  # origins rounded apart, at shared edges only
    np.testing.assert_allclose(far.distance, (near.distance - 2.0 + 1e6) / 1e3, rtol=1e-6)


def test_wrong_shapes_are_refused():
    bvh = Bvh.build(geometry_of(*icosphere(0)))
    with pytest.raises(ValueError, match=r"must be \(N, 3\)"):
        bvh.closest(np.zeros((3, 2)), np.zeros((3, 2)))


def leaks(bvh, geometry, rng, count, scale):
    """How many rays leave a closed sphere from inside; a quarter is aimed at vertices, a quarter at edges."""
    origins = random_directions(rng, count) * rng.random((count, 1)) * 0.9 * scale
    targets = random_directions(rng, count) * scale
    corners = geometry.corners[rng.integers(0, geometry.triangle_count, count // 2)].astype(np.float64)
    weight = rng.random((count // 4, 1))
    targets[: count // 4] = corners[: count // 4, 0]
    along_edges = weight * corners[count // 4 :, 0] + (1 - weight) * corners[count // 4 :, 1]
    targets[count // 4 : count // 2] = along_edges
    directions = targets - origins
    hits = bvh.closest(origins, directions / np.linalg.norm(directions, axis=1, keepdims=True))
    return np.count_nonzero(~hits.hit)


@pytest.mark.parametrize(("scale", "shift"), LEAK_PLACES)
def test_closed_sphere_seen_from_inside_never_leaks(scale, shift):
    geometry = geometry_of(*icosphere(4), scale, shift)
    assert leaks(Bvh.build(geometry), geometry, np.random.default_rng(11), 1_000_000, scale) == 0


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_a_hundred_million_rays_do_not_leak():
    geometry = geometry_of(*icosphere(4), 1.0, 1e4)
    bvh, rng = Bvh.build(geometry), np.random.default_rng(17)
    assert sum(leaks(bvh, geometry, rng, 1_000_000, 1.0) for _ in range(100)) == 0


@pytest.mark.parametrize(("scale", "shift"), LEAK_PLACES)
def test_surfaces_do_not_see_themselves(scale, shift):
    """Seen from outside, a convex body neither mirrors nor shadows itself."""
    rng = np.random.default_rng(12)
    geometry = geometry_of(*icosphere(4), scale, shift)
    bvh = Bvh.build(geometry)
    count = 100_000
    triangle = rng.integers(0, geometry.triangle_count, count)
    u, v = rng.random(count), rng.random(count)
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    u[: count // 4] = 0.0  # on edges, shared with a neighbour
    points = geometry.points(triangle, u, v)
    _, outward, _ = geometry.shading(triangle, u, v)
    leaving = random_directions(rng, count)
    cosine = np.einsum("ij,ij->i", leaving, outward)
    leaving = (leaving - (cosine - np.abs(cosine))[:, None] * outward).astype(np.float32)  # to the outside
    origins = offset_origins(points, outward, leaving, geometry.radius)
    assert np.count_nonzero(bvh.closest(origins, leaving, own=triangle).hit) == 0
    assert np.count_nonzero(bvh.occluded(origins, leaving, own=triangle)) == 0


def test_mesh_far_finer_than_its_scene_does_not_leak():
    """Triangles a thousandth of the scene wide, beside one that makes the scene large."""
    vertices, triangles = icosphere(4)
    small = Mesh(vertices * 0.02, triangles)
    large = Mesh(np.array([(-50.0, -50, -30), (50, -50, -30), (0, 50, -30)]), np.array([(0, 1, 2)]))
    place = np.eye(4)
    place[:3, 3] = (40.0, 30.0, 20.0)
    geometry = Geometry.from_instances([Instance(small, place), Instance(large)])
    bvh = Bvh.build(geometry)
    rng = np.random.default_rng(2)
    corners = geometry.corners[rng.integers(0, len(triangles), 200_000)]
    origins = np.broadcast_to(geometry.recentred(place[:3, 3]), (len(corners), 3))
    hits = bvh.closest(origins, corners[:, 0] - origins)
    assert np.all(hits.triangle < len(triangles))
    assert np.all(hits.hit)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_negative_zero_in_a_direction_is_a_zero(dtype):
    geometry = geometry_of(*icosphere(2), dtype=dtype)
    bvh = Bvh.build(geometry)
    origins = np.array([[0.1, -3.0, 0.07]])
    for direction in ([[-0.0, 1.0, -0.0]], [[0.0, 1.0, -0.0]], [[-0.0, 1.0, 0.0]]):
        assert (
            bvh.closest(origins, np.array(direction)).triangle == bvh.closest(origins, [[0.0, 1.0, 0.0]]).triangle >= 0
        )


def test_clustered_tree_finds_the_same_hits(monkeypatch):
    """Above a hundred thousand triangles the tree is built over clusters; here already above fifty."""
    rng = np.random.default_rng(21)
    vertices, triangles = soup(rng, 3000, size=0.01)
    giants, more = soup(rng, 6, size=3.0)
    geometry = geometry_of(np.concatenate([vertices, giants]), np.concatenate([triangles, more + len(vertices)]))
    origins, directions = rng.random((20_000, 3)).astype(np.float32), random_directions(rng, 20_000).astype(np.float32)
    plain = Bvh.build(geometry).closest(origins, directions)
    monkeypatch.setattr("spectral_core.tracing.bvh._CLUSTERED_FROM", 50)
    clustered = Bvh.build(geometry)
    for name in ("triangle", "distance", "u", "v"):
        np.testing.assert_array_equal(getattr(clustered.closest(origins, directions), name), getattr(plain, name))
    held = clustered.leaf_triangles[clustered.leaf_triangles >= 0]
    np.testing.assert_array_equal(np.sort(held), np.arange(geometry.triangle_count))


def crowd(rng):
    """Many copies of two meshes, moved, turned, mirrored and bent, and one mesh of its own."""
    meshes = [Mesh(*icosphere(2)), Mesh(*soup(rng, 90))]
    bent = Mesh(meshes[0].vertices * (1.0 + 0.2 * rng.random((len(meshes[0].vertices), 1))), meshes[0].triangles)
    instances = [Instance(Mesh(*soup(rng, 40)))]
    for number in range(20):
        matrix = np.eye(4)
        matrix[:3, :3] = 0.3 * rng.normal(size=(3, 3))
        matrix[:3, 3] = rng.normal(size=3)
        instances.append(Instance([*meshes, bent][number % 3], matrix))
    return Geometry.from_instances(instances)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**31))
def test_instances_that_share_a_tree_are_hit_alike(seed):
    rng = np.random.default_rng(seed)
    geometry = crowd(rng)
    corners = geometry.corners
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    assert_tree_encloses(instanced_tree(geometry, lower, upper, 4), lower, upper, 4)
    origins, directions = rng.normal(size=(3000, 3)).astype(np.float32), random_directions(rng, 3000).astype(np.float32)
    plain = Bvh.build(geometry).closest(origins, directions)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("spectral_core.tracing.bvh._SHARED_FROM", 10)
        shared = Bvh.build(geometry)
    for name in ("triangle", "distance", "u", "v"):
        np.testing.assert_array_equal(getattr(shared.closest(origins, directions), name), getattr(plain, name))
    held = shared.leaf_triangles[shared.leaf_triangles >= 0]
    np.testing.assert_array_equal(np.sort(held), np.arange(geometry.triangle_count))


def test_trees_are_shared_only_where_meshes_repeat():
    rng = np.random.default_rng(4)
    different = Geometry.from_instances([Instance(Mesh(*soup(rng, 50 + k))) for k in range(6)])
    cubes = Geometry.from_instances([Instance(Mesh(*soup(rng, 3))) for _ in range(9)])
    for geometry in (different, cubes, geometry_of(*icosphere(3)), Geometry.from_instances([])):
        corners = geometry.corners
        assert instanced_tree(geometry, corners.min(axis=1), corners.max(axis=1), 4) is None


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 400), st.integers(1, 8))
def test_clusters_are_small_and_large_boxes_stay_alone(seed, count, size):
    rng = np.random.default_rng(seed)
    lower = rng.random((count, 3))
    edge = np.where(rng.random((count, 1)) < 0.05, 0.9, 1e-3)
    order, first = cluster(lower, lower + edge, size)
    np.testing.assert_array_equal(np.sort(order), np.arange(count))
    members = np.diff(first, append=count)
    assert members.min() >= 1
    assert members.max() <= size
    if np.median(edge) < 0.9:
        assert np.all(members[np.searchsorted(first, np.flatnonzero(edge[order, 0] > 0.5))] == 1)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 500), st.integers(1, 6), st.booleans())
def test_tree_encloses_its_items(seed, count, leaf_size, coincide):
    rng = np.random.default_rng(seed)
    lower = np.zeros((count, 3)) if coincide else rng.normal(size=(count, 3))
    upper = lower + 0.2 * rng.random((count, 3))
    assert_tree_encloses(binary_tree(lower, upper, leaf_size), lower, upper, leaf_size)


def assert_tree_encloses(tree, lower, upper, leaf_size):
    np.testing.assert_array_equal(np.sort(tree.order), np.arange(len(lower)))
    assert tree.count[tree.left < 0].max() <= leaf_size
    for node in range(len(tree.count)):
        items = tree.order[tree.first[node] : tree.first[node] + tree.count[node]]
        np.testing.assert_array_equal(tree.lower[node], lower[items].min(axis=0))
        np.testing.assert_array_equal(tree.upper[node], upper[items].max(axis=0))
        child = tree.left[node]
        if child >= 0:
            assert tree.first[child] == tree.first[node]
            assert tree.first[child + 1] == tree.first[child] + tree.count[child]
            assert tree.count[child] + tree.count[child + 1] == tree.count[node]


def test_half_area_of_a_brick():
    assert half_area(np.zeros(3), np.array((1.0, 2.0, 3.0))) == 11.0
    assert half_area(np.full(3, np.inf), np.full(3, -np.inf)) == 0.0


def test_an_end_is_asked_for_while_a_tree_is_made():
    vertices, triangles = icosphere(5)
    geometry = Geometry.from_instances([Instance(Mesh(vertices, triangles))])
    asked = 0

    def at_the_sixth_time():
        nonlocal asked
        asked += 1
        if asked == 6:
            raise RenderCancelledError("enough")

    acceleration = Acceleration(geometry)
    with pytest.raises(RenderCancelledError):
        acceleration.tree(None, at_the_sixth_time)
    assert asked == 6
    # What was begun is not kept: the next to ask gets a whole tree.
    hits = acceleration.tree().closest(np.array([[0.0, 0, 3]]), np.array([[0.0, 0, -1]]))
    assert hits.distance[0] == pytest.approx(2.0, abs=1e-3)
