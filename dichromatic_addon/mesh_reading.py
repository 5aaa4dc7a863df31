"""From an evaluated Blender mesh to the arrays of the core's mesh, in bulk reads only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .nodes.images import Coordinates

__all__ = ["MeshArrays", "corner_coordinates", "read_mesh"]


@dataclass(frozen=True, slots=True, eq=False)
class MeshArrays:
    """A triangulated mesh in object space.

    Attributes
    ----------
    vertices : ndarray of float64, shape (V, 3)
        Positions.
    triangles : ndarray of int64, shape (T, 3)
        Vertex indices.
    corner_normals : ndarray of float64, shape (T, 3, 3)
        Shading normals as Blender computes them: custom normals, sharp edges and smooth faces are all in them.
    uv : ndarray of float64, shape (T, 3, 2), or None
        The UV map that is active for rendering.
    slot_index : ndarray of int64, shape (T,)
        Material slot of each triangle's polygon.
    loops : ndarray of int32, shape (T, 3)
        The mesh's corners that the triangles' corners are.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    corner_normals: NDArray[np.float64]
    uv: NDArray[np.float64] | None
    slot_index: NDArray[np.int64]
    loops: NDArray[np.int32]


def read_mesh(mesh: Any) -> MeshArrays | None:
    """Read an evaluated mesh, or return None when it has no faces."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    loops = _bulk(mesh.loop_triangles, "loops", 3 * count, np.int32).reshape(count, 3)
    corners = len(mesh.loops)
    corner_vertex = _bulk(mesh.attributes[".corner_vert"].data, "value", corners, np.int32)
    vertices = _bulk(mesh.attributes["position"].data, "vector", 3 * len(mesh.vertices), np.float32).reshape(-1, 3)
    normals = _bulk(mesh.corner_normals, "vector", 3 * corners, np.float32).reshape(-1, 3)
    polygon = _bulk(mesh.loop_triangle_polygons, "value", count, np.int32)
    return MeshArrays(
        vertices=vertices.astype(np.float64),
        triangles=corner_vertex[loops].astype(np.int64),
        corner_normals=normals[loops].astype(np.float64),
        uv=_uv(mesh, loops, ""),
        slot_index=_slot_index(mesh, polygon),
        loops=loops,
    )


def corner_coordinates(mesh: Any, arrays: MeshArrays, source: Coordinates) -> NDArray[np.float64] | None:
    """Texture coordinates (T, 3, 2) of an evaluated mesh's triangles, or None where it has no such UV map."""
    if source.kind == "UV":
        return arrays.uv if not source.uv_map else _uv(mesh, arrays.loops, source.uv_map)
    points = arrays.vertices
    if source.kind == "GENERATED":
        size = np.array(mesh.texspace_size)
        points = 0.5 + 0.5 * (points - np.array(mesh.texspace_location)) / np.where(size == 0.0, 1.0, size)
    matrix = np.array(source.matrix)
    placed: NDArray[np.float64] = points @ matrix[:, :3].T + matrix[:, 3]
    return placed[arrays.triangles]


def _bulk(collection: Any, attribute: str, length: int, dtype: type) -> NDArray[Any]:
    values: NDArray[Any] = np.empty(length, dtype)
    collection.foreach_get(attribute, values)
    return values


def _uv(mesh: Any, loops: NDArray[np.int32], name: str) -> NDArray[np.float64] | None:
    """Read the UV map of a name; without one, that which is active for rendering."""
    layer = next((layer for layer in mesh.uv_layers if (layer.name == name if name else layer.active_render)), None)
    if layer is None or len(layer.uv) == 0:
        return None
    values = _bulk(layer.uv, "vector", 2 * len(mesh.loops), np.float32).reshape(-1, 2)
    return values[loops].astype(np.float64)


def _slot_index(mesh: Any, polygon: NDArray[np.int32]) -> NDArray[np.int64]:
    attribute = mesh.attributes.get("material_index")  # absent while every face uses the first slot
    if attribute is None:
        return np.zeros(len(polygon), np.int64)
    values = _bulk(attribute.data, "value", len(mesh.polygons), np.int32)
    return values[polygon].astype(np.int64)
