"""Scenes of every size and place, with needles, duplicates and triangles of no area, with one triangle and none."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.errors import SceneError
from spectral_core.tracing import Acceleration, Bvh, Geometry, Instance, LightView, Mesh, PrimaryView, offset_origins
from tests.benchmarks.scenes import scene
from tests.benchmarks.tracing import mirrored
from tests.render.test_tracing_rasterize import camera_at, compare, moved
from tests.render.tracing_meshes import brute_force, geometry_of, icosphere, random_directions, slenderness, soup
from tests.tolerances import TIED_RAYS

scales = st.floats(-3.0, 4.0).map(lambda exponent: 10.0**exponent)
shifts = st.sampled_from([0.0, 1e4, -1e4])
counts = st.sampled_from([0, 1, 2, 40])


def extreme(rng, count, scale, shift):
    """Needles, duplicates and triangles of no area in a scene of any size, and now and then one as large as all."""
    vertices, triangles = soup(rng, count)
    if count > 2 and rng.random() < 0.5:
        vertices[3:6] *= 40.0
    return geometry_of(vertices, triangles, scale, shift)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), counts, scales, shifts)
def test_rays_meet_what_brute_force_finds(seed, count, scale, shift):
    rng = np.random.default_rng(seed)
    geometry = extreme(rng, count, scale, shift)
    size = max(geometry.radius, 1e-300)
    origins = (size * rng.normal(size=(300, 3))).astype(np.float32)
    directions = random_directions(rng, 300).astype(np.float32)
    expected, clear = brute_force(geometry, origins, directions)
    hits = Bvh.build(geometry).closest(origins, directions)
    blocked = Bvh.build(geometry).occluded(origins, directions)
    # Needles of the large triangles' scene are thinner than float32 is fine: their borders are not sure.
    sure = clear > 1e-3
    np.testing.assert_array_equal(hits.hit[sure], expected.hit[sure])
    np.testing.assert_array_equal(blocked, hits.hit)
    both = sure & expected.hit & (hits.triangle == expected.triangle)
    assert np.count_nonzero(sure & expected.hit & ~both) <= 2 + 0.1 * np.count_nonzero(
        sure & expected.hit
    )  # duplicates
    slender = slenderness(geometry)[expected.triangle[both]] if count else np.zeros(0)
    cosine = np.abs(np.einsum("ij,ij->i", geometry.geometric_normals[hits.triangle[both]], directions[both]))
    wrong = np.abs(hits.distance[both] - expected.distance[both])
    assert np.all(wrong <= 1e-6 * np.maximum(slender, 10.0) * (size + expected.distance[both]) / cosine)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), counts, scales, shifts, st.booleans())
def test_pictures_are_those_of_the_rays(seed, count, scale, shift, parallel):
    rng = np.random.default_rng(seed)
    geometry = extreme(rng, count, scale, shift)
    size = geometry.radius if count else scale
    kind = "orthographic" if parallel else "perspective"
    camera = camera_at(rng.normal(size=3) * 2.5, 0.2 * rng.random(3), (-0.9, 1.0, -0.7, 0.8), size, kind, 0.05, 50.0)
    compare(geometry, moved(camera, geometry.centre), 60, 50, offset=tuple(rng.random(2)), holes=3)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), counts, scales, shifts, st.sampled_from(["near", "amid", "far", "in a plane", "sun"]))
def test_shadows_are_those_of_the_rays(seed, count, scale, shift, where):
    rng = np.random.default_rng(seed)
    geometry = extreme(rng, count, scale, shift)
    size = geometry.radius if geometry.triangle_count else scale
    light = {"near": 1.5, "amid": 0.2, "far": 1e3}.get(where, 2.0) * size * rng.normal(size=3)
    if where == "in a plane" and geometry.triangle_count:
        corners = geometry.corners[rng.integers(geometry.triangle_count)].astype(np.float64)
        light = corners[0] + 3.0 * (corners[1] - corners[0]) - 2.0 * (corners[2] - corners[0])
    if not geometry.triangle_count:
        assert not LightView(geometry, position=light).occluded(np.zeros((5, 3), np.float32)).any()
        return
    # Not on needles as thin as float32 is coarse: beside an exact duplicate of theirs either answer is right.
    slender = slenderness(geometry)
    own = rng.choice(np.flatnonzero(slender <= max(1e3, slender.min())), 1500)
    u, v = rng.random(1500), rng.random(1500)
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    points = geometry.points(own, u, v)
    away = np.broadcast_to(light, points.shape) if where == "sun" else light - points
    lifted = offset_origins(points, geometry.geometric_normals[own], away, geometry.radius)
    bvh = Bvh.build(geometry)
    if where == "sun":
        found, expected = LightView(geometry, to_light=light), bvh.occluded(lifted, away, own=own)
    else:
        to_light = light.astype(np.float32) - lifted
        found, expected = LightView(geometry, position=light), bvh.occluded(lifted, to_light, 1.0, own)
    # Lone triangles have borders, and duplicates lie exactly in each other: a few points may fall on either side.
    assert np.count_nonzero(found.occluded(lifted, own) != expected) <= 6


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2), st.integers(0, 2), st.sampled_from([math.nan, math.inf, -math.inf]))
def test_places_that_are_no_numbers_are_refused(vertex, axis, value):
    corners = np.eye(3)
    corners[vertex, axis] = value
    with pytest.raises(SceneError, match=f"mesh 'broken': vertex {vertex} must be finite"):
        Mesh(corners, np.array([(0, 1, 2)]), name="broken")


def test_only_triangles_without_area():
    corners = np.array([(0, 0, 0), (1, 1, 1), (2, 2, 2), (0, 0, 0)], float)
    geometry = Geometry.from_instances([Instance(Mesh(corners, np.array([(0, 1, 2), (0, 0, 0), (0, 3, 1)])))])
    assert geometry.triangle_count == 0
    assert geometry.dropped == 3
    acceleration = Acceleration(geometry)
    origins, directions = np.zeros((3, 3), np.float32), np.ones((3, 3), np.float32)
    assert not acceleration.tree().closest(origins, directions).hit.any()
    assert not acceleration.light_view(position=(0.0, 0.0, 9.0)).occluded(origins).any()
    assert not acceleration.primary_view(camera_at((0, -3, 0), (0, 0, 0), (-1, 1, -1, 1)), 8, 4).hits().hit.any()


@pytest.fixture(scope="module")
def embree():
    """Independent code; only where the benchmarks' requirements are installed."""
    pytest.importorskip("embreex")
    from tests.benchmarks.tracing import Embree

    return Embree


def test_embree_sees_the_same_of_a_picture(embree):
    """Primary rays and their mirror images: other triangles only at ties, and not a hit for a miss."""
    case = scene("cups")
    geometry, camera = case.geometry, case.camera
    width, height = 640, 360
    x, y = np.tile(np.arange(width) + 0.5, height), np.repeat(np.arange(height) + 0.5, width)
    origins, directions = camera.rays(x, y, width, height)
    peer = embree(geometry.corners)
    hits = PrimaryView(geometry, camera, width, height).hits()
    expected = peer.closest(geometry.recentred(origins), directions.astype(np.float32))
    assert np.count_nonzero(hits.triangle != expected) <= TIED_RAYS * len(expected)
    np.testing.assert_array_equal(hits.hit, expected >= 0)
    seen = np.flatnonzero(hits.hit)
    own, u, v = hits.triangle[seen], hits.u[seen], hits.v[seen]
    start, out = mirrored(geometry, own, u, v, directions[seen].astype(np.float32))
    found, expected = Bvh.build(geometry).closest(start, out, own=own), peer.closest(start, out)
    assert np.count_nonzero(found.triangle != expected) <= TIED_RAYS * len(expected)
    assert np.count_nonzero(found.hit != (expected >= 0)) <= TIED_RAYS * len(expected)  # the ground has borders


def test_embree_sees_the_same_from_inside_a_closed_mesh(embree):
    geometry = geometry_of(*icosphere(5))
    rng = np.random.default_rng(6)
    origins = (random_directions(rng, 200_000) * 0.9 * rng.random((200_000, 1))).astype(np.float32)
    directions = random_directions(rng, 200_000).astype(np.float32)
    found, expected = (
        Bvh.build(geometry).closest(origins, directions),
        embree(geometry.corners).closest(origins, directions),
    )
    assert found.hit.all()
    assert np.all(expected >= 0)
    assert np.count_nonzero(found.triangle != expected) <= TIED_RAYS * len(expected)
