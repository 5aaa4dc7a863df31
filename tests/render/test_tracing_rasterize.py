"""Rasterised visibility against the ray caster and brute force, ray by ray."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.tracing import Bvh, Camera, Geometry, Instance, Mesh, PrimaryView, primary_hits
from spectral_core.tracing.clipping import clip_triangles
from tests.benchmarks.scenes import looking
from tests.render.tracing_meshes import brute_force, geometry_of, icosphere, soup
from tests.tolerances import TIED_RAYS

PLACES = [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (1e-3, 1e4), (1.0, 1e4), (1e4, 1e4)]


def camera_at(eye, target, window, scale=1.0, kind="perspective", start=1e-3, end=1e3):
    placed = looking(np.asarray(eye, float) * scale, np.asarray(target, float) * scale)
    window = tuple(np.array(window) * (scale if kind == "orthographic" else 1.0))
    return Camera(placed.matrix, window, kind, start * scale, end * scale)


def moved(camera, shift):
    matrix = camera.matrix.copy()
    matrix[:3, 3] += shift
    return Camera(matrix, camera.window, camera.kind, camera.clip_start, camera.clip_end)


def picture_rays(geometry, camera, width, height, rows, offset):
    x = np.tile(np.arange(width) + offset[0], rows[1] - rows[0])
    y = np.repeat(np.arange(*rows) + offset[1], width)
    origins, directions = camera.rays(x, y, width, height)
    return origins - geometry.centre, directions, camera.reach(directions)


def compare(geometry, camera, width=200, height=150, rows=None, offset=(0.5, 0.5), holes=0, caster=None):
    """The same triangle but for ties, and the same place on it; `holes` rays may hit for one and miss for the other."""
    rows = rows or (0, height)
    origins, directions, reach = picture_rays(geometry, camera, width, height, rows, offset)
    expected = (caster or Bvh.build(geometry, np.flatnonzero(geometry.camera_visible))).closest(
        origins, directions, reach
    )
    hits = primary_hits(geometry, camera, width, height, rows, offset)
    assert len(hits) == len(expected) == width * (rows[1] - rows[0])
    assert np.count_nonzero(hits.hit != expected.hit) <= holes
    different = hits.triangle != expected.triangle
    assert np.count_nonzero(different) <= max(TIED_RAYS * len(hits), holes)
    size = np.maximum(geometry.radius, np.abs(origins).max())
    both = hits.hit & expected.hit
    points = geometry.points(hits.triangle[both], hits.u[both], hits.v[both])
    on_ray = origins[both] + hits.distance[both, None] * directions[both]
    # Rays beside a triangle by a rounding are given its border's nearest point, which may be far along a grazing ray.
    off_ray = np.abs(points - on_ray).max(axis=1, initial=0.0)
    assert np.count_nonzero(off_ray > 1e-5 * size) <= max(TIED_RAYS * len(hits), holes)
    there = geometry.points(expected.triangle[both], expected.u[both], expected.v[both])
    apart = np.abs(points - there).max(axis=1, initial=0.0)
    assert np.count_nonzero(apart > 1e-5 * size) <= max(TIED_RAYS * len(hits), holes)
    assert np.isinf(hits.distance[~hits.hit]).all()
    return hits


@pytest.mark.parametrize(("scale", "shift"), PLACES)
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("eye", [(0.1, -4.0, 1.5), (0.1, 0.2, 0.15)])
def test_closed_sphere_from_outside_and_inside(scale, shift, kind, eye):
    geometry = geometry_of(*icosphere(4), scale, shift)
    window = (-0.6, 0.6, -0.4, 0.5) if kind == "perspective" else (-1.1, 0.8, -0.9, 1.2)
    camera = moved(camera_at(eye, (0.0, 0.0, 0.05), window, scale, kind), shift)
    hits = compare(geometry, camera)
    if eye[1] > 0 and kind == "perspective":
        assert hits.hit.all()  # nothing leaks


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from([1, 4, 40, 300]), st.booleans(), st.booleans())
def test_soup_equals_the_ray_caster(seed, count, within, parallel):
    """Triangles that cross the near plane, the far plane and every side of the picture."""
    rng = np.random.default_rng(seed)
    geometry = geometry_of(*soup(rng, count))
    eye = rng.random(3) if within else rng.normal(size=3) * 2.0
    kind = "orthographic" if parallel else "perspective"
    camera = camera_at(eye, rng.random(3), (-0.9, 1.0, -0.7, 0.8), kind=kind, start=0.05, end=1.5)
    # Lone triangles have borders where a ray may fall on either side: a handful of rays.
    compare(geometry, camera, 90, 80, offset=tuple(rng.random(2)), holes=3)


def test_brute_force_agrees():
    rng = np.random.default_rng(8)
    geometry = geometry_of(*soup(rng, 60), dtype=np.float64)
    camera = camera_at((0.5, -2.0, 0.4), (0.5, 0.5, 0.5), (-0.5, 0.5, -0.5, 0.5), start=0.01)
    origins, directions, _ = picture_rays(geometry, camera, 60, 60, (0, 60), (0.5, 0.5))
    expected, clear = brute_force(geometry, origins, directions)
    hits = primary_hits(geometry, camera, 60, 60)
    sure = clear > 1e-6
    np.testing.assert_array_equal(hits.triangle[sure], expected.triangle[sure])
    for name in ("distance", "u", "v"):
        np.testing.assert_allclose(getattr(hits, name)[sure], getattr(expected, name)[sure], atol=1e-8)


def test_reference_precision_has_no_ties():
    geometry = geometry_of(*icosphere(4), dtype=np.float64)
    camera = camera_at((0.1, -4.0, 1.5), (0, 0, 0), (-0.6, 0.6, -0.4, 0.5))
    bvh = Bvh.build(geometry)
    origins, directions, reach = picture_rays(geometry, camera, 200, 150, (0, 150), (0.5, 0.5))
    hits, expected = primary_hits(geometry, camera, 200, 150), bvh.closest(origins, directions, reach)
    np.testing.assert_array_equal(hits.triangle, expected.triangle)
    np.testing.assert_allclose(hits.distance, expected.distance, rtol=1e-11)
    np.testing.assert_allclose(hits.u, expected.u, atol=1e-9)


def test_bands_of_rows_are_parts_of_the_picture():
    geometry = geometry_of(*icosphere(3))
    camera = camera_at((0.1, -3.0, 1.5), (0, 0, 0), (-0.6, 0.6, -0.4, 0.5))
    view = PrimaryView(geometry, camera, 64, 50, (0.2, 0.9))
    whole = view.hits()
    for height in (1, 7, 50):
        bands = [view.hits((k, min(k + height, 50))) for k in range(0, 50, height)]
        for name in ("triangle", "u", "v", "distance"):
            np.testing.assert_array_equal(np.concatenate([getattr(b, name) for b in bands]), getattr(whole, name))


def test_sub_pixel_offset_shifts_the_sample():
    """Every offset finds what a picture of four times the pixels finds at that place."""
    geometry = geometry_of(*icosphere(2))
    camera = camera_at((0.1, -3.0, 1.5), (0, 0, 0), (-0.6, 0.6, -0.4, 0.5))
    fine = primary_hits(geometry, camera, 160, 120).triangle.reshape(120, 160)
    for i in range(4):
        for j in range(4):
            coarse = primary_hits(geometry, camera, 40, 30, offset=((i + 0.5) / 4, (j + 0.5) / 4)).triangle
            assert np.count_nonzero(coarse.reshape(30, 40) != fine[j::4, i::4]) <= 1


def test_hidden_from_the_camera():
    vertices, triangles = icosphere(2)
    hidden = Instance(Mesh(2.0 * vertices, triangles), camera_visible=False)
    geometry = Geometry.from_instances([hidden, Instance(Mesh(vertices, triangles))])
    camera = camera_at((0.1, -6.0, 1.5), (0, 0, 0), (-0.6, 0.6, -0.4, 0.5))
    hits = compare(geometry, camera)
    assert hits.triangle[hits.hit].min() >= len(triangles)


def test_ties_give_the_lower_number():
    vertices = np.array([(-1, 0, -1), (1, 0, -1), (0, 0, 1)], float)
    geometry = geometry_of(vertices, np.array([(0, 1, 2), (1, 2, 0), (0, 1, 2)]))
    hits = primary_hits(geometry, camera_at((0, -3, 0), (0, 0, 0), (-0.5, 0.5, -0.5, 0.5)), 50, 50)
    assert (
        np.mean(hits.triangle[hits.hit] == 0) > 0.9
    )  # 1 computes its plane from other corners and may win by rounding
    assert not np.any(hits.triangle == 2)


def test_no_triangles():
    camera = camera_at((0, -3, 0), (0, 0, 0), (-0.5, 0.5, -0.5, 0.5))
    hits = primary_hits(Geometry.from_instances([]), camera, 8, 4)
    assert hits.triangle.tolist() == [-1] * 32
    vertices, triangles = icosphere(1)
    behind = geometry_of(vertices - (0, 30, 0), triangles)
    assert not primary_hits(behind, camera, 8, 4).hit.any()


def test_ground_to_the_horizon():
    """One quad a million times larger than the camera's height above it: the horizon lies in the middle row."""
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float) * 1e6
    geometry = geometry_of(corners, np.array([(0, 1, 2), (0, 2, 3)]))
    camera = camera_at((0, 0, 1), (0, 1, 1), (-1, 1, -1, 1), end=1e7, start=1e-3)
    hits = primary_hits(geometry, camera, 100, 100).hit.reshape(100, 100)
    assert hits[51:].all()
    assert not hits[:50].any()


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31))
def test_clipping_keeps_what_is_inside(seed):
    """Pieces make up the polygon that is left, checked by sampling the plane; the cuts of neighbours agree."""
    rng = np.random.default_rng(seed)
    square = rng.normal(size=(4, 3)) * (1, 1, 0)
    corners = np.stack([square[[0, 1, 2]], square[[2, 1, 3]]])  # share the edge 1-2, run opposite ways
    planes = np.array([(1, 0, 0, 0.3), (-1, 0, 0, 0.6), (0.3, 1, 0, 0.5)], float)
    pieces, source = clip_triangles(corners, planes)
    heights = pieces @ planes[:, :3].T + planes[:, 3]
    assert heights.min(initial=0.0) >= -1e-12
    points = rng.random((4000, 2)) * 6 - 3
    inside_planes = np.all(points @ planes[:, :2].T + planes[:, 3] >= 0, axis=1)
    for number in (0, 1):
        covered = sum((_covers(piece, points) for piece in pieces[source == number]), start=np.zeros(4000, int)) > 0
        assert np.count_nonzero(covered != (_covers(corners[number], points) & inside_planes)) <= 1
    on_shared = [
        {tuple(p) for p in pieces[source == k].reshape(-1, 3) if _on_line(p, square[1], square[2])} for k in (0, 1)
    ]
    if len(pieces[source == 0]) and len(pieces[source == 1]):
        assert on_shared[0] == on_shared[1]


def _covers(triangle, points):
    signs = [
        np.sign((b[0] - a[0]) * (points[:, 1] - a[1]) - (b[1] - a[1]) * (points[:, 0] - a[0]))
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)
    ]
    return (np.min(signs, axis=0) >= 0) | (np.max(signs, axis=0) <= 0)


def _on_line(point, a, b):
    (dx, dy), (px, py) = b[:2] - a[:2], point[:2] - a[:2]
    return abs(dx * py - dy * px) < 1e-12 * max(1.0, np.abs(b - a).max())
