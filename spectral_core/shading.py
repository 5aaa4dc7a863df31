"""From hits to geometric coefficients: positions, normals and the dichromatic weights, without any spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lights import Illumination
from .reflection.materials import Material, spread_lobes
from .tracing.columns import dot_rows, take_rows
from .tracing.geometry import Geometry
from .tracing.hits import Hits

__all__ = ["SurfacePoints", "component_coefficients", "facing", "place_components", "spread_textures", "surface_points"]

_GRAZING_COSINE = 1e-4  # an interpolated normal is turned so that the viewer sees its front by at least this


@dataclass(frozen=True, slots=True)
class SurfacePoints:
    """N visible points, sorted by material; vectors are in Fortran order, see :mod:`.tracing.columns`.

    Attributes
    ----------
    geometry : Geometry
        What the points lie on.
    ray : ndarray of int64, shape (N,)
        Which of the rays found the point.
    triangle : ndarray of int64, shape (N,)
        The triangle.
    u, v : ndarray, shape (N,)
        Where on the triangle: weights of its corners 1 and 2.
    material : ndarray of int64, shape (N,)
        Material index, increasing.
    position : ndarray, shape (N, 3)
        Relative to the geometry's centre (m).
    normal, geometric_normal, to_viewer : ndarray, shape (N, 3)
        Unit vectors; both normals are on the viewer's side.
    """

    geometry: Geometry
    ray: NDArray[np.int64]
    triangle: NDArray[np.int64]
    u: NDArray[np.floating[Any]]
    v: NDArray[np.floating[Any]]
    material: NDArray[np.int64]
    position: NDArray[np.floating[Any]]
    normal: NDArray[np.floating[Any]]
    geometric_normal: NDArray[np.floating[Any]]
    to_viewer: NDArray[np.floating[Any]]

    def __len__(self) -> int:
        return len(self.ray)

    def groups(self) -> list[tuple[int, slice]]:
        """Find the runs of equal material.

        Returns
        -------
        list of (int, slice)
            Material index and where its points are.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        if not len(self.material):
            return []
        starts = np.flatnonzero(np.r_[True, np.diff(self.material) != 0])
        ends = np.r_[starts[1:], len(self.material)]
        return [(int(self.material[a]), slice(int(a), int(b))) for a, b in zip(starts, ends, strict=True)]


def surface_points(
    geometry: Geometry,
    hits: Hits,
    directions: NDArray[np.floating[Any]],
) -> SurfacePoints:
    """Points where rays met a surface, with their frames.

    Parameters
    ----------
    geometry : Geometry
        The triangles.
    hits : Hits, N rays
        Where the rays met them; misses are left out of the result.
    directions : ndarray, shape (N, 3)
        Unit directions of the rays; their dtype is that of the result.

    Returns
    -------
    SurfacePoints
        Of the rays that hit, sorted by material, in the order of the rays within a material.

    Raises
    ------
    IndexError
        If a hit names a triangle that is not there.

    References
    ----------
    The turning of interpolated normals that face away from the viewer is common practice; it keeps smooth
    silhouettes from showing black rims where Eq. 8 has no defined value.
    """
    found = _by_material(np.flatnonzero(hits.triangle >= 0), geometry, hits)
    triangle = hits.triangle.take(found)
    u, v = hits.u.take(found), hits.v.take(found)
    to_viewer = -take_rows(directions, found)
    normal, geometric = geometry.normals(triangle, u, v)
    side = np.copysign(geometric.dtype.type(1), dot_rows(geometric, to_viewer))[:, None]
    normal, geometric = normal * side, geometric * side
    normal = _turn_to_viewer(normal, to_viewer)
    return SurfacePoints(
        geometry=geometry,
        ray=found,
        triangle=triangle,
        u=u,
        v=v,
        material=geometry.material_index.take(triangle),
        position=geometry.points(triangle, u, v),
        normal=normal,
        geometric_normal=geometric,
        to_viewer=to_viewer,
    )


def _by_material(rays: NDArray[np.int64], geometry: Geometry, hits: Hits) -> NDArray[np.int64]:
    """Sort rays that hit by material; those of one material keep their order."""
    material = geometry.material_index.take(hits.triangle.take(rays))
    if not len(material) or material.min() == material.max():
        return rays
    if material.max() < 1 << 16:  # numpy sorts 16 bits by radix
        material = material.astype(np.uint16)
    return rays.take(np.argsort(material, kind="stable"))


def _turn_to_viewer(
    normal: NDArray[np.floating[Any]], to_viewer: NDArray[np.floating[Any]]
) -> NDArray[np.floating[Any]]:
    cosine = dot_rows(normal, to_viewer)
    averted = np.flatnonzero(cosine < _GRAZING_COSINE)
    if len(averted):
        turned = normal[averted] + (_GRAZING_COSINE - cosine[averted])[:, None] * to_viewer[averted]
        length = np.sqrt(dot_rows(turned, turned))
        # A normal that points straight away from the viewer has no nearest visible neighbour but the view itself.
        straight = length < _GRAZING_COSINE
        turned = np.where(straight[:, None], to_viewer[averted], turned / np.where(straight, 1, length)[:, None])
        normal = normal.copy(order="K")
        normal[averted] = turned
    return normal


def facing(points: SurfacePoints, illumination: Illumination) -> NDArray[np.int64]:
    """Which points can receive light: those whose surface and shading normal both face it.

    Parameters
    ----------
    points : SurfacePoints, N points
        The points.
    illumination : Illumination, N points
        What the light would give them.

    Returns
    -------
    ndarray of int64
        Their indices, increasing.

    Raises
    ------
    ValueError
        From numpy if the lengths differ.

    References
    ----------
    Own design.
    """
    lit = dot_rows(points.normal, illumination.to_light) > 0
    lit &= dot_rows(points.geometric_normal, illumination.to_light) > 0
    lit &= illumination.irradiance > 0
    return np.flatnonzero(lit)


def component_coefficients(
    material: Material, points: SurfacePoints, illumination: Illumination, index: NDArray[np.int64]
) -> NDArray[np.floating[Any]]:
    """Geometric coefficients of a material's lobes under one light of unit strength.

    Parameters
    ----------
    material : Material
        The material of all the points at `index`.
    points : SurfacePoints
        The points.
    illumination : Illumination
        What the light gives to all points.
    index : ndarray of int64, shape (n,)
        Which points to evaluate.

    Returns
    -------
    ndarray, shape (n, lobes)
        Radiance over (reflectance spectrum x illuminant spectrum), one column a component; a textured component is one
        lobe until :func:`spread_textures`.

    Raises
    ------
    InvalidParameterError
        If the material's parameters are invalid.

    References
    ----------
    Tominaga 1996, Eqs. 3 and 8-10: radiance = radiance factor x irradiance / pi.
    """
    normal = take_rows(points.normal, index)
    coefficients = material.lobes(
        normal,
        take_rows(illumination.to_light, index),
        take_rows(points.to_viewer, index),
        points.geometry.tangents(points.triangle.take(index), normal) if material.needs_tangent else None,
    )
    scale = illumination.irradiance.take(index) / points.position.dtype.type(math.pi)
    result: NDArray[np.floating[Any]] = coefficients * scale[:, None]
    return result


def place_components(
    target: NDArray[np.floating[Any]],
    rows: NDArray[np.int64],
    first_column: int,
    coefficients: NDArray[np.floating[Any]],
    *,
    is_first: bool = True,
) -> None:
    """Write the coefficients of one light into the table of all lights.

    Parameters
    ----------
    target : ndarray, shape (N, L * lobes)
        Changed; a row a point of one material, the lobes of each light in turn.
    rows : ndarray of int64, shape (n,)
        The lit points, increasing, each at most once.
    first_column : int
        Where the light's lobes begin.
    coefficients : ndarray, shape (n, lobes)
        Theirs.
    is_first : bool
        Whether they replace what is there; else they are added to it.

    Raises
    ------
    IndexError
        From numpy if a point is not there.

    References
    ----------
    Own design. Column by column: numpy scatters scalars several times faster than short rows.
    """
    if len(rows) == len(target):
        part = target[:, first_column : first_column + coefficients.shape[1]]
        part[...] = coefficients if is_first else part + coefficients
        return
    for column in range(coefficients.shape[1]):
        part = target[:, first_column + column]
        part[rows] = coefficients[:, column] if is_first else part[rows] + coefficients[:, column]


def spread_textures(
    material: Material,
    points: SurfacePoints,
    part: slice,
    coefficients: NDArray[np.floating[Any]],
) -> NDArray[np.floating[Any]]:
    """Turn the coefficients of a material's lobes into those of its components; textures are read here and only here.

    Parameters
    ----------
    material : Material
        The material of the points.
    points : SurfacePoints
        The points. Where a mesh has no texture coordinates they are (0, 0).
    part : slice
        Which of them.
    coefficients : ndarray, shape (n, L * lobes)
        Of all lights, as :func:`place_components` fills it.

    Returns
    -------
    ndarray, shape (n, L * Km)
        The components of each light in turn; `coefficients` itself where nothing is textured.

    Raises
    ------
    InvalidParameterError
        If a texture coordinate is not finite.

    References
    ----------
    Own design.
    """
    if not material.textures:
        return coefficients
    uv = points.geometry.texture_coordinates(points.triangle[part], points.u[part], points.v[part])
    return spread_lobes(material, coefficients, uv)
