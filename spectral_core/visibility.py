"""Who is seen and who is lit: picks the way to find out, so that nothing above it has to know.

Several threads may ask at a time.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .lights import Illumination, LampPoint, LightSource
from .paths import PathBundle
from .shading import SurfacePoints
from .sub_pictures import SubPicture
from .tracing.acceleration import Acceleration
from .tracing.camera import Camera
from .tracing.columns import dot_rows, take_rows
from .tracing.hits import Hits, offset_origins
from .tracing.rasterize import PrimaryView
from .tracing.shadows import LightView

__all__ = ["Visibility"]

_VIEW_BYTES = 1 << 28  # projected triangles that may be kept for the next part of the picture
_BYTES_A_TRIANGLE = 80
_BLOCKER_SETS = 64  # sets of blockers whose triangles are remembered, a byte each
_RAY_PER_TRIANGLE = 4  # what a shadow ray through the tree costs, in triangles that a lamp is looked from over

Made = TypeVar("Made")


class _Store:
    """Things that are made once and kept while memory allows; a thread waits for what another is making.

    Parameters
    ----------
    most : int
        How many things are kept, the last used ones.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._things: OrderedDict[object, Any] = OrderedDict()
        self._making: dict[object, threading.Lock] = {}

    def get(self, key: object, make: Callable[[], Made]) -> Made:
        """Return what is kept under a key, or make it."""
        with self._lock:
            if key in self._things:
                self._things.move_to_end(key)
                return self._things[key]  # type: ignore[no-any-return]
            making = self._making.setdefault(key, threading.Lock())
        with making:
            with self._lock:
                if key in self._things:
                    return self._things[key]  # type: ignore[no-any-return]
            made = make()
            with self._lock:
                self._things[key] = made
                self._making.pop(key, None)
                while len(self._things) > self._most:
                    self._things.popitem(last=False)
            return made


class Visibility:
    """Answers the two questions of direct light for one scene and camera.

    Parameters
    ----------
    acceleration : Acceleration
        The triangles, with what is known of them.
    camera : Camera
        The camera.
    width, height : int
        Size of the image in pixels.
    """

    def __init__(self, acceleration: Acceleration, camera: Camera, width: int, height: int) -> None:
        self._acceleration = acceleration
        self._geometry = acceleration.geometry
        self._camera = camera
        self._width = width
        self._height = height
        most = max(1, _VIEW_BYTES // (1 + _BYTES_A_TRIANGLE * self._geometry.triangle_count))
        self._views = _Store(most)
        self._blockers = _Store(_BLOCKER_SETS)

    def secondary(self, bundle: PathBundle, stop_if_cancelled: Callable[[], None] = lambda: None) -> Hits:
        """Find what mirrored rays meet; things hidden from the camera are seen in mirrors.

        Parameters
        ----------
        bundle : PathBundle
            The rays.
        stop_if_cancelled : callable, optional
            Asked while triangles are sorted; raises when the caller wants an end.

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
        return self._acceleration.tree(None, stop_if_cancelled).closest(
            bundle.origin, bundle.direction, None, bundle.own
        )

    def primary(
        self, part: SubPicture, offset: NDArray[np.float64], lens: NDArray[np.float64] | None = None
    ) -> tuple[Hits, NDArray[np.floating[Any]], NDArray[np.floating[Any]]]:
        """Find what the camera sees through one sub-pixel position of some pixels.

        Parameters
        ----------
        part : SubPicture, N pixels
            The pixels.
        offset : ndarray, shape (2,)
            Position within each pixel (x, y); (0.5, 0.5) is its centre.
        lens : ndarray, shape (2,), optional
            Point of the lens; its middle when left out.

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
        camera = self._camera if lens is None else self._camera.through_lens(lens)
        hits = self._view(part, camera, offset).hits((part.first, part.end))
        x, y = np.tile(part.x + offset[0], part.end - part.first), np.repeat(part.y + offset[1], part.width)
        _, directions = camera.rays(x, y, self._width, self._height)
        dtype = self._geometry.dtype
        axis = -camera.matrix[:3, 2]
        depth = hits.distance * dot_rows(directions, axis).astype(dtype) + dtype.type(camera.clip_start)
        return hits, directions.astype(dtype), depth

    def _view(self, part: SubPicture, camera: Camera, offset: NDArray[np.float64]) -> PrimaryView:
        """Project the triangles for one sub-pixel position, as the sub-picture sees them."""
        place = ((part.column + float(offset[0])) / part.step, (part.row + float(offset[1])) / part.step)
        smaller = camera.sub_window(self._width, self._height, part.step, part.width, part.height)

        def project() -> PrimaryView:
            return self._acceleration.primary_view(smaller, part.width, part.height, place)

        return self._views.get((place, part.width, part.height, camera.matrix.tobytes(), camera.window), project)

    def unoccluded(
        self,
        source: LightSource,
        at: LampPoint,
        points: SurfacePoints,
        illumination: Illumination,
        candidates: NDArray[np.int64],
        *,
        is_scattered: bool,
        stop_if_cancelled: Callable[[], None] = lambda: None,
    ) -> NDArray[np.int64]:
        """Find the points that a light reaches without meeting a surface.

        Parameters
        ----------
        source : LightSource
            The light.
        at : LampPoint
            The point of it that is looked from.
        points : SurfacePoints
            All points.
        illumination : Illumination
            What the light would give them from there.
        candidates : ndarray of int64
            Indices of the points that face the light, increasing.
        is_scattered : bool
            Whether the points are few and far between, as behind mirrors; then rays are cast one by one. The many
            points that a camera sees are looked at from the light instead, which finds the same.
        stop_if_cancelled : callable, optional
            Asked while triangles are sorted; raises when the caller wants an end.

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
        if not len(candidates) or not source.casts_shadow:
            return candidates
        directions = take_rows(illumination.to_light, candidates)
        position, normal = take_rows(points.position, candidates), take_rows(points.geometric_normal, candidates)
        origins = offset_origins(position, normal, directions, self._geometry.radius)
        own = points.triangle.take(candidates)
        casting = self._casting(source)
        if not (is_scattered or self._is_view_dear(source)):
            blocked = self._light_view(source, at, casting).occluded(origins, own)
        elif at.position is None:
            blocked = self._acceleration.tree(casting, stop_if_cancelled).occluded(origins, directions, None, own)
        else:
            # From the lifted origin to the light itself: the ray is as long as what is left.
            target = self._geometry.recentred(at.position)
            blocked = self._acceleration.tree(casting, stop_if_cancelled).occluded(origins, target - origins, 1.0, own)
        return candidates[~blocked]

    def _is_view_dear(self, source: LightSource) -> bool:
        """Whether looking from the light costs more than rays: once for each of its points, and many triangles.

        It depends on nothing but the scene and the size of the picture, so that equal pictures come about equally.
        """
        if not source.is_extended:
            return False
        typical = self._width * self._height // 16
        return self._geometry.triangle_count > _RAY_PER_TRIANGLE * typical

    def _casting(self, source: LightSource) -> NDArray[np.bool_]:
        """Find the triangles that may hide a light: what casts shadows, and of that what the light is linked to."""
        geometry, blockers = self._geometry, source.blockers
        if blockers is None:
            return geometry.shadow_visible

        def choose() -> NDArray[np.bool_]:
            chosen: NDArray[np.bool_] = geometry.shadow_visible & np.isin(geometry.instance_index, list(blockers))
            return chosen

        return self._blockers.get(blockers, choose)

    def _light_view(self, source: LightSource, at: LampPoint, casting: NDArray[np.bool_]) -> LightView:
        """Project the triangles towards a point of a light."""
        # Who is asked about is seen by the camera, on the side that faces the light.
        position = None if at.position is None else at.position - self._geometry.centre
        return self._acceleration.light_view(position, at.to_light, self._camera, casting, keep=not source.is_extended)
