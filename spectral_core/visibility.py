"""Who is seen and who is lit: picks the way to find out, so that nothing above it has to know."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lights import Illumination, Light, SunLight
from .paths import PathBundle
from .shading import SurfacePoints
from .tracing.bvh import Bvh
from .tracing.camera import Camera
from .tracing.columns import take_rows
from .tracing.geometry import Geometry
from .tracing.hits import Hits, offset_origins
from .tracing.rasterize import PrimaryView
from .tracing.shadows import LightView

__all__ = ["Visibility"]

_VIEW_BYTES = 1 << 28  # projected triangles that may be kept between bands
_BYTES_A_TRIANGLE = 80


class Visibility:
    """Answers the two questions of direct light for one scene and camera.

    Parameters
    ----------
    geometry : Geometry
        The triangles.
    camera : Camera
        The camera.
    width, height : int
        Size of the image in pixels.
    """

    def __init__(self, geometry: Geometry, camera: Camera, width: int, height: int) -> None:
        self._geometry = geometry
        self._camera = camera
        self._width = width
        self._height = height
        self._trees: dict[bytes, Bvh] = {}
        self._views: dict[tuple[float, float], PrimaryView] = {}
        self._light_views: dict[int, LightView] = {}

    def _tree(self, members: NDArray[np.bool_]) -> Bvh:
        """Build the tree of some triangles, once for each distinct set."""
        key = members.tobytes()
        if key not in self._trees:
            everything = bool(members.all())
            self._trees[key] = Bvh.build(self._geometry, None if everything else np.flatnonzero(members))
        return self._trees[key]

    def secondary(self, bundle: PathBundle) -> Hits:
        """Find what mirrored rays meet; things hidden from the camera are seen in mirrors.

        Parameters
        ----------
        bundle : PathBundle
            The rays.

        Returns
        -------
        Hits
            One a ray.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        everything = self._tree(np.ones(self._geometry.triangle_count, bool))
        return everything.closest(bundle.origin, bundle.direction, None, bundle.own)

    def primary(
        self, first_row: int, end_row: int, offset: NDArray[np.float64]
    ) -> tuple[Hits, NDArray[np.floating[Any]], NDArray[np.floating[Any]]]:
        """Find what the camera sees through one sub-pixel position of some rows.

        Parameters
        ----------
        first_row, end_row : int
            The rows; row 0 is the top.
        offset : ndarray, shape (2,)
            Position within each pixel (x, y); (0.5, 0.5) is its centre.

        Returns
        -------
        hits : Hits
            One a pixel, row by row.
        directions : ndarray, shape (N, 3)
            Unit directions of the rays.
        depth : ndarray, shape (N,)
            Distance along the view axis (m); infinite where nothing is met.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        hits = self._view(offset).hits((first_row, end_row))
        x = np.tile(np.arange(self._width) + offset[0], end_row - first_row)
        y = np.repeat(np.arange(first_row, end_row) + offset[1], self._width)
        _, directions = self._camera.rays(x, y, self._width, self._height)
        dtype = self._geometry.dtype
        axis = -self._camera.matrix[:3, 2]
        depth = hits.distance * (directions @ axis).astype(dtype) + dtype.type(self._camera.clip_start)
        return hits, directions.astype(dtype), depth

    def _view(self, offset: NDArray[np.float64]) -> PrimaryView:
        """Project the triangles for one sub-pixel position; kept for the next band while memory allows."""
        key = (float(offset[0]), float(offset[1]))
        if key not in self._views:
            if len(self._views) >= max(1, _VIEW_BYTES // (1 + _BYTES_A_TRIANGLE * self._geometry.triangle_count)):
                self._views.clear()
            self._views[key] = PrimaryView(self._geometry, self._camera, self._width, self._height, key)
        return self._views[key]

    def unoccluded(
        self,
        light: Light,
        points: SurfacePoints,
        illumination: Illumination,
        candidates: NDArray[np.int64],
        *,
        is_scattered: bool,
    ) -> NDArray[np.int64]:
        """Find the points that a light reaches without meeting a surface.

        Parameters
        ----------
        light : Light
            The light.
        points : SurfacePoints
            All points.
        illumination : Illumination
            What the light would give them.
        candidates : ndarray of int64
            Indices of the points that face the light, increasing.
        is_scattered : bool
            Whether the points are few and far between, as behind mirrors; then rays are cast one by one. The many
            points that a camera sees are looked at from the light instead, which finds the same.

        Returns
        -------
        ndarray of int64
            Those of `candidates` that are lit, increasing.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        if not len(candidates):
            return candidates
        directions = take_rows(illumination.to_light, candidates)
        position, normal = take_rows(points.position, candidates), take_rows(points.geometric_normal, candidates)
        origins = offset_origins(position, normal, directions, self._geometry.radius)
        own = points.triangle.take(candidates)
        if not is_scattered:
            blocked = self._light_view(light).occluded(origins, own)
        elif isinstance(light, SunLight):
            blocked = self._tree(self._geometry.shadow_visible).occluded(origins, directions, None, own)
        else:
            # From the lifted origin to the light itself: the ray is as long as what is left.
            target = self._geometry.recentred(light.position)
            blocked = self._tree(self._geometry.shadow_visible).occluded(origins, target - origins, 1.0, own)
        return candidates[~blocked]

    def _light_view(self, light: Light) -> LightView:
        """Project the triangles towards a light, once."""
        if id(light) not in self._light_views:
            if isinstance(light, SunLight):
                view = LightView(self._geometry, to_light=light.to_light)
            else:
                view = LightView(self._geometry, position=light.position - self._geometry.centre)
            self._light_views[id(light)] = view
        return self._light_views[id(light)]
