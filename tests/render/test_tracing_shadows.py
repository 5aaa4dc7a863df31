"""The light's view of the points against rays from the points to the light."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.tracing import (
    Bvh,
    Geometry,
    Instance,
    LightView,
    Mesh,
    occluded_from_direction,
    occluded_from_point,
    offset_origins,
)
from spectral_core.tracing.sample_grid import SampleGrid
from tests.render.tracing_meshes import geometry_of, icosphere, slenderness, soup
from tests.tolerances import TIED_RAYS

PLACES = [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (1e-3, 1e4), (1.0, 1e4), (1e4, 1e4)]
LIGHTS = {
    "outside": (3.0, 2.0, 5.0),
    "far": (300.0, 200.0, 500.0),
    "between": (1.0, 1.0, 1.0),
    "inside": (0.1, 0.2, 0.05),
}
SUN = np.array((0.3, 0.2, 0.5))


def surface_points(geometry, rng, count, light=None, to_light=None):
    """Random points of random triangles, lifted to the light's side."""
    # Not on needles as thin as float32 is coarse: beside an exact duplicate of theirs either answer is right.
    slender = slenderness(geometry)
    triangle = rng.choice(np.flatnonzero(slender <= max(1e3, slender.min())), count)
    u, v = rng.random(count), rng.random(count)
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    points = geometry.points(triangle, u, v)
    away = np.broadcast_to(to_light, points.shape) if light is None else light - points
    return offset_origins(points, geometry.geometric_normals[triangle], away, geometry.radius), triangle


def assert_same_shadows(geometry, rng, count, light=None, to_light=None, allowed=None):
    points, own = surface_points(geometry, rng, count, light, to_light)
    bvh = Bvh.build(geometry, np.flatnonzero(geometry.shadow_visible))
    if light is None:
        found = occluded_from_direction(geometry, points, own, to_light)
        expected = bvh.occluded(points, np.broadcast_to(to_light, points.shape), own=own)
    else:
        found = occluded_from_point(geometry, points, own, light)
        expected = bvh.occluded(points, light - points, 1.0, own=own)
    assert found.dtype == np.bool_
    assert np.count_nonzero(found != expected) <= (TIED_RAYS * count if allowed is None else allowed)
    return expected


def two_balls(scale, shift, dtype=np.float32):
    vertices, triangles = icosphere(4)
    both = np.concatenate([vertices, 0.3 * vertices + (0.8, 0.9, 1.5)])
    return geometry_of(both, np.concatenate([triangles, triangles + len(vertices)]), scale, shift, dtype)


@pytest.mark.parametrize(("scale", "shift"), PLACES)
@pytest.mark.parametrize("light", LIGHTS)
def test_point_light_equals_rays(scale, shift, light):
    rng = np.random.default_rng(4)
    dark = assert_same_shadows(two_balls(scale, shift), rng, 40_000, light=np.array(LIGHTS[light]) * scale)
    assert 0.3 < dark.mean() < 0.95


@pytest.mark.parametrize(("scale", "shift"), PLACES)
def test_sun_equals_rays(scale, shift):
    assert_same_shadows(two_balls(scale, shift), np.random.default_rng(4), 40_000, to_light=SUN)


def test_reference_precision_has_no_ties():
    geometry = two_balls(1.0, 1e4, np.float64)
    for light in LIGHTS.values():
        assert_same_shadows(geometry, np.random.default_rng(6), 20_000, light=np.array(light), allowed=0)
    assert_same_shadows(geometry, np.random.default_rng(6), 20_000, to_light=SUN, allowed=0)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from([1, 4, 40, 300]), st.sampled_from([*LIGHTS, "sun"]))
def test_soup_equals_rays(seed, count, light):
    rng = np.random.default_rng(seed)
    vertices, triangles = soup(rng, count)
    geometry = geometry_of(vertices, triangles)
    # Lone triangles have borders: a few points may fall on either side.
    place = {"to_light": SUN} if light == "sun" else {"light": np.array(LIGHTS[light])}
    assert_same_shadows(geometry, rng, 4000, **place, allowed=4)


def test_the_lit_side_of_a_convex_body_is_lit():
    geometry = geometry_of(*icosphere(5))
    points, own = surface_points(geometry, np.random.default_rng(1), 200_000, to_light=SUN)
    cosine = geometry.geometric_normals[own] @ SUN
    dark = occluded_from_direction(geometry, points, own, SUN)
    assert np.count_nonzero(dark[cosine > 1e-6]) == 0
    assert np.count_nonzero(~dark[cosine < -1e-6]) == 0


def test_shadow_of_a_square_is_the_square():
    """A unit square halfway between a point light and the ground casts one of twice its size, to the last point."""
    square = np.array([(-0.5, -0.5, 1), (0.5, -0.5, 1), (0.5, 0.5, 1), (-0.5, 0.5, 1)], float)
    ground = np.array([(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], float)
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    geometry = Geometry.from_instances([Instance(Mesh(square, faces)), Instance(Mesh(ground, faces))])
    points = np.random.default_rng(0).uniform(-2.5, 2.5, (100_000, 3)) * (1, 1, 0)
    up = np.zeros_like(points) + np.array((0.0, 0.0, 1.0))
    lifted = offset_origins(geometry.recentred(points), up, up, geometry.radius).astype(np.float32)
    expected = np.abs(points).max(axis=1) < 1.0
    sure = np.abs(np.abs(points).max(axis=1) - 1.0) > 1e-5
    for light in ((0.0, 0.0, 2.0), (0.0, 0.0, 2.0 + 1e-9)):
        dark = occluded_from_point(geometry, lifted, None, geometry.recentred(light))
        np.testing.assert_array_equal(dark[sure], expected[sure])
    dark = occluded_from_direction(geometry, lifted, None, (0.0, 0.0, 7.0))
    sure = np.abs(np.abs(points).max(axis=1) - 0.5) > 1e-5
    np.testing.assert_array_equal(dark[sure], (np.abs(points).max(axis=1) < 0.5)[sure])


def test_one_view_answers_for_any_part_of_the_points():
    geometry = two_balls(1.0, 0.0)
    for arguments in ({"position": LIGHTS["outside"]}, {"position": LIGHTS["inside"]}, {"to_light": SUN}):
        points, own = surface_points(geometry, np.random.default_rng(2), 5000, light=np.array(LIGHTS["outside"]))
        view = LightView(geometry, **arguments)
        whole = view.occluded(points, own)
        parts = [view.occluded(points[k : k + 777], own[k : k + 777]) for k in range(0, 5000, 777)]
        assert np.count_nonzero(np.concatenate(parts) != whole) <= 1  # cells differ, and with them the last bits


def test_what_casts_no_shadow():
    vertices, triangles = icosphere(2)
    ghost = Instance(Mesh(2.0 * vertices, triangles), shadow_visible=False)
    geometry = Geometry.from_instances([ghost, Instance(Mesh(vertices, triangles))])
    dark = assert_same_shadows(geometry, np.random.default_rng(3), 20_000, to_light=SUN)
    assert 0.2 < dark.mean() < 0.4  # half of the inner ball; of the outer one, the part in its shadow


def test_no_triangles_and_no_points():
    empty = Geometry.from_instances([])
    assert not occluded_from_point(empty, np.zeros((3, 3), np.float32), None, (0, 0, 1)).any()
    assert not occluded_from_direction(empty, np.zeros((3, 3), np.float32), None, (0, 0, 1)).any()
    full = geometry_of(*icosphere(1))
    none = np.zeros((0, 3), np.float32)
    assert occluded_from_point(full, none, None, (0, 0, 3)).shape == (0,)
    single = np.array([(0.0, 0.0, 0.9)], np.float32)
    assert occluded_from_point(full, single, None, (0, 0, 3)).tolist() == [True]
    with pytest.raises(TypeError, match="either position or to_light"):
        LightView(full)


def test_points_found_hidden_leave_the_grid(monkeypatch):
    """With many small blocks of triangles points are sorted out several times; nothing else changes."""
    geometry = two_balls(1.0, 0.0)
    for arguments in ({"position": LIGHTS["outside"]}, {"position": LIGHTS["between"]}, {"to_light": SUN}):
        points, own = surface_points(geometry, np.random.default_rng(2), 20_000, light=np.array(LIGHTS["outside"]))
        with monkeypatch.context() as patch:
            patch.setattr("spectral_core.tracing.shadows._HIDDEN_PART", 2.0)
            whole = LightView(geometry, **arguments).occluded(points, own)
            patch.setattr("spectral_core.tracing.shadows._HIDDEN_PART", 0.05)
            patch.setattr("spectral_core.tracing.shadows._TRIANGLES", 128)
            np.testing.assert_array_equal(LightView(geometry, **arguments).occluded(points, own), whole)


def test_crowded_points_get_a_finer_grid():
    rng = np.random.default_rng(5)
    even = rng.random((2, 20_000)).astype(np.float32)
    crowded = np.concatenate([even[:, :200], 0.01 * even[:, 200:]], axis=1)
    grids = [SampleGrid.of(x, y, np.ones(20_000, np.float32)) for x, y in (even, crowded)]
    assert grids[1].columns > 2 * grids[0].columns
    for grid in grids:
        column, row = grid.cells(grid.x, grid.y)
        cell = row.astype(int) * grid.columns + column.astype(int)
        np.testing.assert_array_equal(np.bincount(cell, minlength=grid.rows * grid.columns), np.diff(grid.start))
        rest = grid.without(grid.x > 0.5 * grid.x.max())
        assert rest.start[-1] == len(rest.order) == np.count_nonzero(grid.x <= 0.5 * grid.x.max())
        np.testing.assert_array_equal(np.sort(rest.order), np.sort(grid.order[grid.x <= 0.5 * grid.x.max()]))
