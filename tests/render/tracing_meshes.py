"""Meshes, rays and the slow exact answers that the tracing tests compare with."""

import numpy as np

from spectral_core.tracing import Geometry, Hits, Instance, Mesh


def icosphere(subdivisions):
    """Vertices on the unit sphere and triangles that face outward."""
    t = (1.0 + 5.0**0.5) / 2.0
    ring = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0)]
    vertices = np.array(ring + [(z, x, y) for x, y, z in ring] + [(y, z, x) for x, y, z in ring], float)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    # Faces of the convex hull: triples at the edge length, turned outward.
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=2) < 1.1
    triples = np.array([(i, j, k) for i in range(12) for j in range(i) for k in range(j)])
    i, j, k = triples.T
    faces = triples[near[i, j] & near[j, k] & near[i, k]]
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward][:, ::-1]
    for _ in range(subdivisions):
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        unique, back = np.unique(edges, axis=0, return_inverse=True)
        middle = vertices[unique].sum(axis=1)
        back = back.reshape(3, -1) + len(vertices)
        vertices = np.concatenate([vertices, middle / np.linalg.norm(middle, axis=1, keepdims=True)])
        (a, b, c), (ab, bc, ca) = faces.T, back
        faces = np.concatenate([np.stack(f, axis=1) for f in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return vertices, faces


def soup(rng, count, size=0.3):
    """Random triangles in the unit cube, with needles, duplicates and triangles without area among them."""
    corners = rng.random((count, 1, 3)) + size * rng.normal(size=(count, 3, 3))
    corners[::11, 2] = corners[::11, 1] + 1e-4 * rng.normal(size=corners[::11, 2].shape)  # needles
    corners[5::17] = corners[4::17][: len(corners[5::17])]  # duplicates
    corners[7::23, 2] = corners[7::23, 0]  # no area
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def geometry_of(vertices, triangles, scale=1.0, shift=0.0, dtype=np.float32):
    return Geometry.from_instances([Instance(Mesh(vertices * scale + shift, triangles))], dtype=dtype)


def slenderness(geometry):
    """Square of the longest edge over the area: 2.3 for an equilateral triangle, large for a needle."""
    corners = geometry.corners.astype(np.float64)
    edges = corners - np.roll(corners, 1, axis=1)
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return np.sum(edges * edges, axis=2).max(axis=1) / area


def random_directions(rng, count):
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def brute_force(geometry, origins, directions, own=None):
    """Every ray against every triangle, in float64, by Cramer's rule; the margin tells how clear each verdict was."""
    corners = geometry.corners.astype(np.float64)
    origins, directions = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
    count = len(origins)
    best, which, bu, bv = np.full(count, np.inf), np.full(count, -1), np.zeros(count), np.zeros(count)
    clear = np.full(count, np.inf)  # smallest barycentric distance of any candidate from its triangle's border
    for number, (a, b, c) in enumerate(corners):
        e1, e2 = b - a, c - a
        p = np.cross(directions, e2)
        det = p @ e1
        with np.errstate(divide="ignore", invalid="ignore"):
            s = origins - a
            u = np.einsum("ij,ij->i", s, p) / det
            q = np.cross(s, e1)
            v = np.einsum("ij,ij->i", directions, q) / det
            t = q @ e2 / det
        border = np.minimum(np.minimum(u, v), 1.0 - u - v)
        in_front = np.isfinite(t) & (t > 0.0)
        if own is not None:
            in_front &= own != number
        relevant = in_front & (t < np.maximum(best, 0) * (1 + 1e-5))
        clear = np.where(relevant & (np.abs(border) < clear), np.abs(border), clear)
        hit = in_front & (border >= 0.0) & (t < best)
        best, which = np.where(hit, t, best), np.where(hit, number, which)
        bu, bv = np.where(hit, u, bu), np.where(hit, v, bv)
    return Hits(best, which, bu, bv), clear
