"""Triangle meshes and their instances, as the caller gives them: float64, in their own coordinates."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..validation import require_shape

__all__ = ["MASKS", "Instance", "Mesh"]

MASKS = ("", "holdout", "shadow_catcher")
"""What camera rays may make of an instance: see :class:`Instance`."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A triangle mesh.

    Parameters
    ----------
    vertices : (V, 3) array_like of float
        Positions, finite.
    triangles : (T, 3) array_like of int
        Vertex numbers of each triangle, counter-clockwise seen from outside.
    corner_normals : (T, 3, 3) array_like of float, optional
        A normal for each corner of each triangle, of any length; a zero vector asks for the flat normal there.
        None makes the whole mesh flat.
    uv : (T, 3, 2) array_like of float, optional
        Texture coordinates of each corner; they give shading its tangents.
    material_index : (T,) array_like of int, optional
        Material slot of each triangle, at least 0; None stands for slot 0 throughout.
    name : str, optional
        What the mesh is called in errors.

    Raises
    ------
    SceneError
        If a shape is wrong, a value is not finite (the message names the mesh and the vertex) or an index is out of
        range.

    References
    ----------
    Own design.
    """

    vertices: Floats
    triangles: Integers
    corner_normals: Floats | None = None
    uv: Floats | None = None
    material_index: Integers | None = None
    name: str = ""

    def __post_init__(self) -> None:
        label = f"mesh {self.name!r}"
        vertices = _as_array(f"{label}: vertices", self.vertices, np.float64, (None, 3))
        bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
        if bad.size:
            raise SceneError(f"{label}: vertex {bad[0]} must be finite, but is {tuple(vertices[bad[0]].tolist())}")
        triangles = _as_array(f"{label}: triangles", self.triangles, np.int64, (None, 3))
        count = len(triangles)
        if count and (triangles.min() < 0 or triangles.max() >= len(vertices)):
            row = int(np.flatnonzero(((triangles < 0) | (triangles >= len(vertices))).any(axis=1))[0])
            used = triangles[row].tolist()
            raise SceneError(f"{label}: triangle {row} must use vertices 0 to {len(vertices) - 1}, but uses {used}")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)
        for attribute, shape in (("corner_normals", (count, 3, 3)), ("uv", (count, 3, 2))):
            value = getattr(self, attribute)
            if value is not None:
                array = _as_array(f"{label}: {attribute}", value, np.float64, shape)
                broken = np.flatnonzero(~np.isfinite(array).all(axis=(1, 2)))
                if broken.size:
                    raise SceneError(f"{label}: {attribute} of triangle {broken[0]} must be finite")
                object.__setattr__(self, attribute, array)
        if self.material_index is not None:
            index = _as_array(f"{label}: material_index", self.material_index, np.int64, (count,))
            if count and index.min() < 0:
                row = int(index.argmin())
                raise SceneError(f"{label}: material_index[{row}] must be at least 0, but is {index[row]}")
            object.__setattr__(self, "material_index", index)


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """A mesh placed in the world.

    Parameters
    ----------
    mesh : Mesh
        What is placed.
    matrix : (4, 4) array_like of float, optional
        World from mesh; affine: any rotation, shear, scale or mirroring, and a last row of 0 0 0 1.
    name : str, optional
        What the instance is called in errors.
    camera_visible : bool, optional
        Whether the camera sees it.
    shadow_visible : bool, optional
        Whether it casts shadows.
    mask : str, optional
        What camera rays make of it: "" a surface; "holdout" a hole in the picture, through which nothing is seen;
        "shadow_catcher" the background, darkened where something casts a shadow on it. Mirrors show it as a surface.

    Raises
    ------
    SceneError
        If the matrix has another shape, is not finite or not affine; the message names the instance.

    References
    ----------
    Own design.
    """

    mesh: Mesh
    matrix: Floats = field(default_factory=lambda: np.eye(4))
    name: str = ""
    camera_visible: bool = True
    shadow_visible: bool = True
    mask: str = ""

    def __post_init__(self) -> None:
        label = f"instance {self.name or self.mesh.name!r}: matrix"
        matrix = _as_array(label, self.matrix, np.float64, (4, 4))
        if not np.isfinite(matrix).all():
            raise SceneError(f"{label} must be finite, but is {matrix.tolist()}")
        if not np.array_equal(matrix[3], (0.0, 0.0, 0.0, 1.0)):
            raise SceneError(f"{label} must have the last row (0, 0, 0, 1), but has {tuple(matrix[3].tolist())}")
        object.__setattr__(self, "matrix", matrix)
        if self.mask not in MASKS:
            raise SceneError(
                f"instance {self.name or self.mesh.name!r}: mask must be one of {MASKS}, but is {self.mask!r}"
            )


def _as_array(name: str, value: object, dtype: type, shape: tuple[int | None, ...]) -> NDArray[Any]:
    """Convert to an array of `dtype` and check its shape, in a SceneError's words."""
    try:
        array = np.asarray(value)
        if dtype is np.int64 and array.size and not np.issubdtype(array.dtype, np.integer):
            raise SceneError(f"{name} must be integers, but are {array.dtype}")
        array = np.ascontiguousarray(array, dtype=dtype)
        if array.size == 0:
            array = array.reshape(tuple(0 if n is None else n for n in shape))
        require_shape(name, array, shape)
    except SceneError:
        raise
    except (TypeError, ValueError) as error:
        raise SceneError(str(error) if name in str(error) else f"{name}: {error}") from error
    return array
