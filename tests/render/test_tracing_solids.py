"""Leaving out the sides of closed meshes that nobody need look at changes no verdict."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spectral_core.tracing import (
    Acceleration,
    AccelerationCache,
    Geometry,
    Instance,
    Mesh,
    PrimaryView,
    Solids,
    offset_origins,
    sight_box,
)
from spectral_core.tracing.ceilings import Ceilings
from tests.benchmarks.scenes import looking
from tests.render.tracing_meshes import geometry_of, icosphere, random_directions, soup

BOX_FACES = np.array(
    [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), *((k, (k + 1) % 4, (k + 1) % 4 + 4) for k in range(4))]
)
BOX_FACES = np.concatenate([BOX_FACES, [(k, (k + 1) % 4 + 4, k + 4) for k in range(4)]])


def box(half=(1.0, 1.0, 1.0), inside_out=False):
    x, y, z = half
    corners = [(-x, -y, -z), (x, -y, -z), (x, y, -z), (-x, y, -z), (-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]
    return Mesh(np.array(corners), BOX_FACES[:, ::-1] if inside_out else BOX_FACES)


def ball(subdivisions=3, squash=1.0, inside_out=False):
    vertices, triangles = icosphere(subdivisions)
    return Mesh(vertices * (1.0, 1.0, squash), triangles[:, ::-1] if inside_out else triangles)


def bowl():
    """A ball without its upper part: open."""
    vertices, triangles = icosphere(3)
    return Mesh(vertices, triangles[vertices[triangles][:, :, 2].max(axis=1) < 0.4])


def twisted():
    """Two balls that cut each other, one of them inside out, as one mesh."""
    vertices, triangles = icosphere(3)
    both = np.concatenate([vertices, 0.8 * vertices + (0.9, 0.1, 0.2)])
    return Mesh(both, np.concatenate([triangles, triangles[:, ::-1] + len(vertices)]))


def placed(mesh, rng, spread, mirrored=False, **visible):
    matrix = np.eye(4)
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix[:3, :3] = q * rng.uniform(0.3, 1.2)
    if (np.linalg.det(q) < 0) != mirrored:
        matrix[:3, 0] *= -1
    matrix[:3, 3] = spread * rng.normal(size=3)
    return Instance(mesh, matrix, **visible)


def random_scene(rng):
    """Closed, open, inverted, mirrored and intersecting meshes, some of which the camera or the lights do not see."""
    meshes = [ball(), ball(2, 0.3), ball(2, inside_out=True), box(), box((1, 0.2, 0.02)), bowl(), twisted()]
    instances = []
    for number in rng.integers(0, len(meshes), rng.integers(2, 8)):
        visible = {} if rng.random() < 0.8 else {"camera_visible": bool(rng.random() < 0.5), "shadow_visible": False}
        instances.append(placed(meshes[number], rng, 1.5, bool(rng.random() < 0.5), **visible))
    if rng.random() < 0.5:
        instances.append(
            Instance(Mesh(np.array([(-9, -9, -3), (9, -9, -3), (9, 9, -3), (-9, 9, -3.0)]), BOX_FACES[:2]))
        )
    if rng.random() < 0.2:
        instances.append(Instance(box((12, 12, 12), inside_out=bool(rng.random() < 0.5))))  # all is in a room
    return Geometry.from_instances(instances)


def seen_points(geometry, camera, light):
    """Points that the camera sees, lifted towards a light that is on their seen side; and their triangles."""
    hits = PrimaryView(geometry, camera, 120, 90).hits()
    own = hits.triangle[hits.hit]
    points = geometry.points(own, hits.u[hits.hit], hits.v[hits.hit])
    flat = geometry.geometric_normals[own]
    away = np.broadcast_to(light, points.shape) if light.ndim == 2 else light - points
    eye = camera.position - geometry.centre
    same = np.einsum("ij,ij->i", flat, away) * np.einsum("ij,ij->i", flat, eye - points) > 0.0
    return offset_origins(points, flat, away, geometry.radius)[same], own[same], away[same]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), st.booleans())
def test_shadows_and_sight_are_the_same_with_fewer_triangles(seed, sun):
    rng = np.random.default_rng(seed)
    geometry = random_scene(rng)
    camera = looking(4.0 * rng.normal(size=3), 0.5 * rng.normal(size=3), 50.0)
    acceleration = Acceleration(geometry)
    whole, part = (
        view.hits() for view in (PrimaryView(geometry, camera, 120, 90), acceleration.primary_view(camera, 120, 90))
    )
    assert np.count_nonzero(whole.triangle != part.triangle) <= 1  # where a front and a back meet
    light = 3.0 * rng.normal(size=(1, 3) if sun else 3)
    points, own, away = seen_points(geometry, camera, light)
    place = {"to_light": light[0]} if sun else {"position": light}
    some = rng.random(int(geometry.instance_index.max()) + 1) < 0.5
    for members in (None, geometry.shadow_visible & some[geometry.instance_index]):
        casting = geometry.shadow_visible if members is None else members
        expected = acceleration.tree(casting).occluded(points, away, None if sun else 1.0, own)
        # Lone triangles have borders, and the meshes here cut each other: a few points may fall on either side.
        for sight in (camera, None):
            found = acceleration.light_view(**place, camera=sight, members=members).occluded(points, own)
            assert np.count_nonzero(found != expected) <= 4


def test_closed_means_closed():
    vertices, triangles = icosphere(2)
    corners = vertices[triangles].reshape(-1, 3)
    alone = np.arange(len(corners)).reshape(-1, 3)  # no two triangles share a vertex number
    for mesh, closed in (
        (Mesh(vertices, triangles), True),
        (Mesh(vertices, triangles[1:]), False),
        (Mesh(vertices, np.concatenate([triangles, triangles[:1]])), False),
        (Mesh(vertices, np.concatenate([triangles[:1, ::-1], triangles[1:]])), False),
        (Mesh(corners, alone), True),
        (Mesh(corners, alone[1:]), False),
        (twisted(), True),
        (bowl(), False),
    ):
        solids = Solids.of(Geometry.from_instances([Instance(mesh)]))
        assert solids.closed.all() == closed
    both = Solids.of(Geometry.from_instances([Instance(bowl()), Instance(ball(inside_out=True)), Instance(box())]))
    assert both.closed.tolist() == [False, True, True]
    assert both.outward.tolist()[1:] == [False, True]
    joined = Solids.of(
        geometry_of(
            np.concatenate([vertices, vertices + 3]), np.concatenate([triangles, triangles[1:] + len(vertices)])
        )
    )
    assert joined.closed.tolist() == [True, False]


def test_a_flipped_coordinate_sign_of_zero_is_the_same_place():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (-0.0, -0.0, -0.0)], float)
    faces = np.array([(0, 2, 1), (4, 1, 3), (0, 3, 2), (1, 2, 3)])
    geometry = geometry_of(corners, faces)
    geometry.vertices[4] = np.copysign(0.0, -1.0)
    geometry.vertices[0] = 0.0
    geometry.vertices[1:4] -= geometry.vertices[1:4].min(axis=0)
    assert Solids.of(geometry).closed.all()


@pytest.mark.parametrize(
    ("eye", "light", "sides"),
    [
        ((0, -5, 0), (0, 0, 5), 1),  # both outside: one side
        ((0, -0.5, 0), (0, 0, 5), 2),  # the camera inside: both
        ((0, -5, 0), (0, 0, 0.5), 2),  # the light inside: both
    ],
)
def test_only_who_is_outside_may_leave_out_a_side(eye, light, sides):
    geometry = geometry_of(*icosphere(2))
    solids = Solids.of(geometry)
    solids = replace(solids, walls=np.full_like(solids.walls, 3))  # a lone ball is all wall
    kept = solids.towards_light(geometry, sight_box(geometry, looking(eye, (0.01, 3, 0))), light)
    assert {int(bits).bit_count() for bits in kept} == {sides}


def test_walls_of_a_room_and_a_tables_top():
    """Nothing lies behind a wall; behind a table's top lies the floor."""
    room, table = box((5, 5, 3)), box((1, 1, 0.05))
    geometry = Geometry.from_instances([Instance(room), Instance(table)])
    walls = Solids.of(geometry).walls
    assert set(walls[:12]) == {1}  # the scene is behind their outsides: from within nothing faces it but insides
    assert set(walls[12:]) == {3}


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from([1, 3, 50, 400]), st.floats(0.001, 2.0))
def test_ceilings_are_above_every_triangle(seed, count, size):
    rng = np.random.default_rng(seed)
    corners = rng.random((count, 1, 3)) + size * rng.normal(size=(count, 3, 3))
    corners[::7, 2] = corners[::7, 0]
    x, y, nearness = (1024.0 * corners).astype(np.float32).transpose(2, 1, 0)
    ends = x.min(axis=0), x.max(axis=0), y.min(axis=0), y.max(axis=0)
    ceilings = Ceilings.of(x, y, nearness, ends, nearness.max(axis=0), 1024.0)
    weights = rng.dirichlet(np.ones(3), (count, 50))
    weights[:, :3] = np.eye(3)
    at = [np.einsum("tpc,ct->tp", weights, values).astype(np.float32).ravel() for values in (x, y, nearness)]
    on_screen = (at[0] >= 0) & (at[0] <= 1024) & (at[1] >= 0) & (at[1] <= 1024)
    below = at[2] - np.float32(1e-3) * (1 + np.abs(at[2]))
    assert np.isin(np.flatnonzero(on_screen), ceilings.below(at[0], at[1], below)).all()
    assert not len(ceilings.below(at[0], at[1], np.full_like(at[2], nearness.max() + 1)))


def test_what_is_kept_and_for_how_long():
    cache = AccelerationCache()
    first = [Instance(ball()), Instance(box())]
    one = cache.get(first)
    assert cache.get(first) is one
    assert cache.get([Instance(ball()), Instance(box())]) is one  # equal arrays
    assert cache.get(first, np.float64) is not one
    other = cache.get(first)
    moved = np.eye(4)
    moved[0, 3] = 0.5
    for instances in (
        [first[0]],
        [first[0], Instance(box(), moved)],
        [first[0], Instance(box((1, 1, 2)))],
        [first[0], Instance(box(), shadow_visible=False)],
    ):
        assert cache.get(instances) is not other
        other = cache.get(first)
    cache.clear()
    assert cache.get(first) is not other


def test_trees_and_views_are_made_once():
    acceleration = Acceleration(Geometry.from_instances([Instance(ball()), Instance(box(), shadow_visible=False)]))
    assert acceleration.tree() is acceleration.tree(np.ones(acceleration.geometry.triangle_count, bool))
    assert acceleration.tree(acceleration.geometry.shadow_visible) is not acceleration.tree()
    light = (0.0, 0.0, 5.0)
    kept = acceleration.light_view(position=light, keep=True)
    assert acceleration.light_view(position=light, keep=True) is kept
    assert acceleration.light_view(position=light) is not kept
    assert acceleration.light_view(to_light=light, keep=True) is not kept
    acceleration.forget_lights()
    assert acceleration.light_view(position=light, keep=True) is not kept
    with pytest.raises(TypeError, match="position or to_light"):
        acceleration.light_view()


def test_views_do_not_pile_up():
    """A lamp that moves from frame to frame leaves few views behind."""
    acceleration = Acceleration(Geometry.from_instances([Instance(ball(0))]))
    acceleration._most_lights = 3
    places = [(0.0, 0.0, 2.0 + k) for k in range(5)]
    views = [acceleration.light_view(position=place, keep=True) for place in places]
    assert [acceleration.light_view(position=place, keep=True) for place in places[2:]] == views[2:]
    assert acceleration.light_view(position=places[0], keep=True) is not views[0]


def test_sight_begins_in_its_box_from_every_point_of_the_lens():
    rng = np.random.default_rng(3)
    geometry = Geometry.from_instances([Instance(ball(0))])
    placed_camera = looking((1.0, -4.0, 2.0), (0.2, 0.1, 0.0))
    for kind, lens in (("perspective", 0.0), ("perspective", 0.3), ("orthographic", 0.0)):
        camera = replace(placed_camera, kind=kind, lens_radius=lens, focus_distance=3.0, lens_ratio=0.5, clip_start=0.4)
        lower, upper = sight_box(geometry, camera)
        for _ in range(20):
            seen_from = camera.through_lens(random_directions(rng, 1)[0, :2])
            origins, _ = seen_from.rays(*rng.uniform(-2.0, 42.0, (2, 50)), 40, 40)
            assert np.all((origins - geometry.centre >= lower) & (origins - geometry.centre <= upper))


def test_threads_get_what_one_gets():
    """Several threads ask for what none has made yet."""
    rng = np.random.default_rng(9)
    vertices, triangles = soup(rng, 500)
    geometry = geometry_of(vertices, triangles)
    origins = rng.random((4000, 3)).astype(np.float32)
    directions = random_directions(rng, 4000).astype(np.float32)
    light = np.array((0.4, 0.5, 0.6))
    expected = Acceleration(geometry)
    view, hits = expected.light_view(position=light), expected.tree().closest(origins, directions)
    dark = view.occluded(origins)
    shared = Acceleration(geometry)

    def ask(k):
        part = slice(k, k + 500)
        mine = shared.light_view(position=light, keep=True).occluded(origins[part])
        return mine, shared.tree().closest(origins[part], directions[part]).triangle

    with ThreadPoolExecutor(8) as executor:
        answers = list(executor.map(ask, range(0, 4000, 500)))
    np.testing.assert_array_equal(np.concatenate([a for a, _ in answers]), dark)
    np.testing.assert_array_equal(np.concatenate([t for _, t in answers]), hits.triangle)
    assert len(shared._lights) == 1
