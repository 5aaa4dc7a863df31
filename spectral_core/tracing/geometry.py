"""All triangles of a scene in world space, recentred, ready to be traced and shaded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from .columns import take_rows
from .mesh import Instance, Mesh

__all__ = ["Geometry", "bounding_sphere"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_HITS = 8192
"""Hits that are interpolated at a time: their corners stay in a second-level cache of 1 MB."""

_TRIANGLES = 1 << 14
"""Triangles that are brought into world space at a time, between two questions for the end."""

_SHORT = 1e-12
"""Length below which a sum of unit vectors is scaled before it is squared."""


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """The triangles of all instances of a scene, in world space about a common centre.

    Positions are relative to `centre`: the subtraction happens in float64 before anything is cast to `dtype`, since
    raw float32 coordinates far from the origin leak rays.

    Parameters
    ----------
    centre : (3,) ndarray of float64
        Middle of the bounding box, in world coordinates.
    radius : float
        Half the diagonal of the bounding box; 0 for an empty scene.
    vertices : (V, 3) ndarray
        Vertex positions relative to `centre`, in the working dtype.
    triangles : (T, 3) ndarray of int64
        Vertex numbers of each triangle's corners, counter-clockwise seen from outside.
    corners : (T, 3, 3) ndarray
        ``vertices[triangles]``, kept because it is fetched all the time.
    geometric_normals : (T, 3) ndarray
        Unit normals of the flat triangles.
    corner_normals : (T, 3, 3) ndarray or None
        Unit shading normals; None when every mesh is flat.
    uv : (T, 3, 2) ndarray or None
        Texture coordinates; None when no mesh has any (meshes without hold zeros).
    material_index, instance_index : (T,) ndarray of int64
        Material slot within the triangle's mesh, and which instance it came from.
    camera_visible, shadow_visible : (T,) ndarray of bool
        Whom the camera sees and who casts shadows.
    dropped : int
        How many triangles of zero area were left out.

    References
    ----------
    Own design.
    """

    centre: NDArray[np.float64]
    radius: float
    vertices: Array
    triangles: Integers
    corners: Array
    geometric_normals: Array
    corner_normals: Array | None
    uv: Array | None
    material_index: Integers
    instance_index: Integers
    camera_visible: NDArray[np.bool_]
    shadow_visible: NDArray[np.bool_]
    dropped: int

    @classmethod
    def from_instances(
        cls,
        instances: Sequence[Instance],
        dtype: DTypeLike = np.float32,
        stop_if_cancelled: Callable[[], None] = lambda: None,
    ) -> Geometry:
        """Bring instances into world space.

        Normals are carried by the cofactor matrix (the inverse transpose but for a factor, defined for flattening
        matrices too). A mirroring matrix turns the triangles' winding, so that the outside stays outside. Triangles
        that have no area once cast to `dtype` are dropped and counted.

        Parameters
        ----------
        instances : sequence of Instance
            Any number, none included.
        dtype : dtype, optional
            float32 for speed, float64 for reference runs.
        stop_if_cancelled : callable, optional
            Asked every few hundredths of a second; raises when the caller wants an end.

        Returns
        -------
        Geometry
            The world-space triangles, in the order of the instances and of their meshes' triangles.

        Raises
        ------
        SceneError
            None here: meshes and instances were checked when they were made.

        References
        ----------
        Normals under affine maps: Turkowski, "Properties of surface-normal transformations", Graphics Gems (1990).
        """
        dtype = np.dtype(dtype)
        centre, radius = bounding_sphere(instances)
        smooth = any(i.mesh.corner_normals is not None for i in instances)
        textured = any(i.mesh.uv is not None for i in instances)
        parts = [_place(instance, centre, dtype, smooth, textured, stop_if_cancelled) for instance in instances]
        total = sum(len(i.mesh.triangles) for i in instances)
        kept = [part.count for part in parts]
        before = np.cumsum([0, *(len(part.vertices) for part in parts)])
        triangles = [part.triangles + start for part, start in zip(parts, before[:-1], strict=True)]

        def joined(name: str, shape: tuple[int, ...]) -> Array:
            arrays = [getattr(part, name) for part in parts]
            return np.concatenate(arrays) if arrays else np.zeros((0, *shape), dtype)

        return cls(
            centre=centre,
            radius=radius,
            vertices=joined("vertices", (3,)),
            triangles=np.concatenate(triangles) if parts else np.zeros((0, 3), np.int64),
            corners=joined("corners", (3, 3)),
            geometric_normals=joined("geometric_normals", (3,)),
            corner_normals=joined("corner_normals", (3, 3)) if smooth else None,
            uv=joined("uv", (3, 2)) if textured else None,
            material_index=joined("material_index", ()).astype(np.int64, copy=False),
            instance_index=np.repeat(np.arange(len(parts)), kept),
            camera_visible=np.repeat(np.array([i.camera_visible for i in instances], bool), kept),
            shadow_visible=np.repeat(np.array([i.shadow_visible for i in instances], bool), kept),
            dropped=total - sum(kept),
        )

    @property
    def dtype(self) -> np.dtype[Any]:
        """The working dtype, float32 or float64."""
        return self.corners.dtype

    @property
    def triangle_count(self) -> int:
        """How many triangles there are."""
        return len(self.corners)

    def recentred(self, points: ArrayLike) -> Array:
        """World positions relative to the centre, in the working dtype.

        Parameters
        ----------
        points : (..., 3) array_like of float
            World positions.

        Returns
        -------
        (..., 3) ndarray
            ``points - centre``, subtracted in float64.

        Raises
        ------
        ValueError
            By numpy, if the last axis is not 3 long.

        References
        ----------
        Own design.
        """
        return (np.asarray(points, dtype=np.float64) - self.centre).astype(self.dtype)

    def points(self, triangle: Integers, u: Array, v: Array) -> Array:
        """Positions of hits, from their barycentric coordinates.

        They lie closer to the triangle than ``origin + distance * direction`` does.

        Parameters
        ----------
        triangle : (N,) ndarray of int
            Triangle numbers, at least 0.
        u, v : (N,) ndarray
            Weights of corners 1 and 2.

        Returns
        -------
        (N, 3) ndarray
            Positions relative to the centre.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        return _interpolate(self.corners, triangle, u, v)

    def texture_coordinates(self, triangle: Integers, u: Array, v: Array) -> Array:
        """Texture coordinates of hits; zeros where there are none.

        Parameters
        ----------
        triangle : (N,) ndarray of int
            Triangle numbers, at least 0.
        u, v : (N,) ndarray
            Weights of corners 1 and 2.

        Returns
        -------
        (N, 2) ndarray
            Interpolated coordinates.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        if self.uv is None:
            return np.zeros((len(triangle), 2), self.dtype)
        return _interpolate(self.uv, triangle, u, v)

    def shading(self, triangle: Integers, u: Array, v: Array) -> tuple[Array, Array, Array]:
        """Give normals and tangents of hits.

        The normal is interpolated from the corners and may face away from the viewer: the shader flips it. The tangent
        is the direction in which the texture's first coordinate grows; where there is none it is ``z x normal``, the
        horizontal direction "east", and the x axis where the normal is vertical. It is perpendicular to the normal.

        Parameters
        ----------
        triangle : (N,) ndarray of int
            Triangle numbers, at least 0.
        u, v : (N,) ndarray
            Weights of corners 1 and 2.

        Returns
        -------
        normal, geometric_normal, tangent : (N, 3) ndarray
            Unit vectors.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        normal, geometric = self.normals(triangle, u, v)
        return normal, geometric, self.tangents(triangle, normal)

    def normals(self, triangle: Integers, u: Array, v: Array) -> tuple[Array, Array]:
        """Give the normals of hits: interpolated from the corners, and of the flat triangles.

        Parameters
        ----------
        triangle : (N,) ndarray of int
            Triangle numbers, at least 0.
        u, v : (N,) ndarray
            Weights of corners 1 and 2.

        Returns
        -------
        normal, geometric_normal : (N, 3) ndarray
            Unit vectors in Fortran order; the same array when every mesh is flat.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        geometric = take_rows(self.geometric_normals, triangle)
        if self.corner_normals is None:
            return geometric, geometric
        normal = _interpolate(self.corner_normals, triangle, u, v)
        squared = np.einsum("ij,ij->i", normal, normal)
        short = np.flatnonzero(squared < _SHORT**2)
        if len(short):
            mended = _unit_or(normal[short], geometric[short])
            squared[short] = 1.0
        normal /= np.sqrt(squared)[:, None]
        if len(short):
            normal[short] = mended
        return normal, geometric

    def tangents(self, triangle: Integers, normal: Array) -> Array:
        """Give the tangents of hits, see :meth:`shading`.

        Parameters
        ----------
        triangle : (N,) ndarray of int
            Triangle numbers, at least 0.
        normal : (N, 3) ndarray
            Unit normals of the hits.

        Returns
        -------
        (N, 3) ndarray
            Unit vectors, perpendicular to the normals.

        Raises
        ------
        IndexError
            By numpy, if a triangle number is out of range.

        References
        ----------
        Own design.
        """
        fallback = np.zeros_like(normal)
        fallback[:, 0] = -normal[:, 1]
        fallback[:, 1] = normal[:, 0]
        vertical = np.abs(normal[:, 2]) > 1.0 - 1e-6
        fallback[vertical] = (1.0, 0.0, 0.0)
        fallback = _unit_or(fallback - np.sum(fallback * normal, axis=1, keepdims=True) * normal, fallback)
        if self.uv is None:
            return fallback
        corners, uv = np.take(self.corners, triangle, axis=0), np.take(self.uv, triangle, axis=0)
        edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        d1, d2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        area = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
        tangent = np.sign(area)[:, None] * (edge1 * d2[:, 1:] - edge2 * d1[:, 1:])
        tangent -= np.sum(tangent * normal, axis=1, keepdims=True) * normal
        return _unit_or(tangent, fallback)


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """One instance in world space."""

    vertices: Array
    triangles: Integers
    corners: Array
    geometric_normals: Array
    corner_normals: Array | None
    uv: Array | None
    material_index: Integers

    @property
    def count(self) -> int:
        return len(self.corners)


def bounding_sphere(instances: Sequence[Instance]) -> tuple[NDArray[np.float64], float]:
    """Enclose the triangles of instances in the sphere about their bounding box.

    Parameters
    ----------
    instances : sequence of Instance
        Any number, none included.

    Returns
    -------
    centre : (3,) ndarray of float64
        In world coordinates; the origin for an empty scene.
    radius : float
        Half the diagonal of the box; 0 for an empty scene.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
    for instance in instances:
        if len(instance.mesh.triangles):
            is_used = np.zeros(len(instance.mesh.vertices), bool)
            is_used[instance.mesh.triangles] = True
            world = _world_vertices(instance)[is_used]
            lower, upper = np.minimum(lower, world.min(axis=0)), np.maximum(upper, world.max(axis=0))
    if not np.isfinite(lower).all():
        return np.zeros(3), 0.0
    return 0.5 * (lower + upper), float(0.5 * np.linalg.norm(upper - lower))


def _world_vertices(instance: Instance) -> NDArray[np.float64]:
    return instance.mesh.vertices @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]


def _place(
    instance: Instance,
    centre: Array,
    dtype: np.dtype[Any],
    smooth: bool,
    textured: bool,
    stop_if_cancelled: Callable[[], None],
) -> _Placed:
    # One value per vertex, shared by all its triangles: the cast must not open seams.
    world = (_world_vertices(instance) - centre).astype(dtype)
    parts = []
    for start in range(0, max(len(instance.mesh.triangles), 1), _TRIANGLES):
        stop_if_cancelled()
        parts.append(_place_triangles(instance, slice(start, start + _TRIANGLES), world, smooth, textured))
    if len(parts) == 1:
        return parts[0]
    joined: dict[str, Any] = {}
    for name in (field.name for field in fields(_Placed) if field.name != "vertices"):
        arrays = [getattr(part, name) for part in parts]
        joined[name] = None if arrays[0] is None else np.concatenate(arrays)
    return _Placed(vertices=world, **joined)


def _place_triangles(instance: Instance, part: slice, world: Array, smooth: bool, textured: bool) -> _Placed:
    """Bring some triangles into world space; few at a time, so that what lies between stays in the cache."""
    mesh, linear, dtype = instance.mesh, instance.matrix[:3, :3], world.dtype
    mirrored = np.linalg.det(linear) < 0.0
    turn = [0, 2, 1] if mirrored else [0, 1, 2]
    triangles = mesh.triangles[part][:, turn]
    corners = world[triangles]
    doubled = corners.astype(np.float64)
    # Scaled to the larger edge so that the squares of tiny triangles do not underflow.
    edges = np.stack([doubled[:, 1] - doubled[:, 0], doubled[:, 2] - doubled[:, 0]])
    size = np.abs(edges).max(axis=(0, 2), initial=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = np.cross(edges[0] / size[:, None], edges[1] / size[:, None])
        area = np.linalg.norm(cross, axis=1)
        keep = np.flatnonzero(area > 0.0)
        geometric = cross[keep] / area[keep, None]
    return _Placed(
        vertices=world,
        triangles=triangles[keep],
        corners=corners[keep] if len(keep) < len(corners) else corners,
        geometric_normals=geometric.astype(dtype),
        corner_normals=(
            _world_normals(mesh, linear, mirrored, turn, part, keep, geometric).astype(dtype) if smooth else None
        ),
        uv=_uv(mesh, turn, part, keep).astype(dtype) if textured else None,
        material_index=(
            np.zeros(len(keep), np.int64) if mesh.material_index is None else mesh.material_index[part][keep]
        ),
    )


def _world_normals(
    mesh: Mesh, linear: Array, mirrored: bool, turn: list[int], part: slice, keep: Integers, geometric: Array
) -> NDArray[np.float64]:
    flat = np.repeat(geometric[:, None, :], 3, axis=1)
    if mesh.corner_normals is None:
        return flat
    a, b, c = linear.T
    cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1) * (-1.0 if mirrored else 1.0)
    normals = mesh.corner_normals[part][keep][:, turn] @ cofactor.T
    return _unit_or(normals.reshape(-1, 3), flat.reshape(-1, 3)).reshape(-1, 3, 3)


def _uv(mesh: Mesh, turn: list[int], part: slice, keep: Integers) -> NDArray[np.float64]:
    return np.zeros((len(keep), 3, 2)) if mesh.uv is None else mesh.uv[part][keep][:, turn]


def _interpolate(values: Array, triangle: Integers, u: Array, v: Array) -> Array:
    """Weigh the three corners' values: (T, 3, K) at (N,) barycentrics to (N, K), in Fortran order."""
    result = np.empty((values.shape[2], len(triangle)), values.dtype)
    u, v = u.astype(values.dtype, copy=False), v.astype(values.dtype, copy=False)
    for first in range(0, len(triangle), _HITS):
        part = slice(first, first + _HITS)
        corners = values.take(triangle[part], axis=0)
        for column, of in enumerate(result[:, part]):
            start = corners[:, 0, column]
            np.subtract(corners[:, 1, column], start, out=of)
            of *= u[part]
            of += start
            across = corners[:, 2, column] - start
            across *= v[part]
            of += across
    return result.T


def _unit_or(vectors: Array, otherwise: Array) -> Array:
    """Vectors scaled to unit length; those with no direction are replaced by `otherwise`."""
    largest = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    good = largest > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = vectors / largest  # so that short vectors do not underflow when squared
        unit = scaled / np.sqrt(np.sum(scaled * scaled, axis=1, keepdims=True))
    return np.where(good, unit, otherwise)
