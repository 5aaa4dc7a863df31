"""What is known about a geometry and can be kept for as long as it does not change."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from .bvh import Bvh
from .camera import Camera
from .geometry import Geometry
from .mesh import Instance
from .rasterize import PrimaryView
from .shadows import LightView
from .solids import Solids, sight_box

__all__ = ["Acceleration", "AccelerationCache"]


_VIEW_BYTES, _BYTES_A_TRIANGLE, _FEWEST_VIEWS = 1 << 29, 64, 8
"""Memory for kept views of lights, what a triangle takes in one, and how many are kept whatever they take."""

_ARRAYS = ("vertices", "triangles", "corner_normals", "uv", "material_index")


class Acceleration:
    """A geometry with its trees, its closed parts and its lights' views, each made when it is first asked for.

    Keep it between frames and relights while the geometry stays the same; :class:`AccelerationCache` tells. Every
    method may be called by several threads at once: what is missing is made by the first, the others wait. The same
    holds for what the methods give, `Bvh`, `PrimaryView` and `LightView`: ask them from any thread.

    Parameters
    ----------
    geometry : Geometry
        The triangles.

    Examples
    --------
    For a frame whose lamps stand still::

        light = acceleration.light_view(position=lamp, camera=camera, keep=True)
        hidden = light.occluded(points, own)

    For a lamp point of its own in each sub-picture, the same without ``keep``: the view goes with its last user, the
    closed parts it is made from stay.
    """

    def __init__(self, geometry: Geometry) -> None:
        self.geometry = geometry
        self._lock = threading.Lock()
        self._solids: Solids | None = None
        self._trees: dict[bytes, Bvh] = {}
        self._lights: OrderedDict[tuple[object, ...], LightView] = OrderedDict()
        self._most_lights = max(_FEWEST_VIEWS, _VIEW_BYTES // (1 + _BYTES_A_TRIANGLE * geometry.triangle_count))

    @property
    def solids(self) -> Solids:
        """The geometry's closed parts."""
        with self._lock:
            if self._solids is None:
                self._solids = Solids.of(self.geometry)
            return self._solids

    def tree(
        self, members: NDArray[np.bool_] | None = None, stop_if_cancelled: Callable[[], None] = lambda: None
    ) -> Bvh:
        """Give the tree of all triangles, or of some.

        Parameters
        ----------
        members : (T,) ndarray of bool, optional
            The triangles to put in, such as ``geometry.shadow_visible``; None for all.
        stop_if_cancelled : callable, optional
            Asked while a tree is made; raises when the caller wants an end.

        Returns
        -------
        Bvh
            The tree, made once for each set.

        Raises
        ------
        IndexError
            By numpy, if the number of members is not that of the triangles.

        References
        ----------
        Own design.
        """
        key = _key(members)
        with self._lock:
            if key not in self._trees:
                chosen = None if members is None or not key else np.flatnonzero(members)
                self._trees[key] = Bvh.build(self.geometry, chosen, stop_if_cancelled)
            return self._trees[key]

    def primary_view(
        self, camera: Camera, width: int, height: int, offset: tuple[float, float] = (0.5, 0.5)
    ) -> PrimaryView:
        """Look through a camera at one sub-pixel position of every pixel.

        Parameters
        ----------
        camera : Camera
            The camera.
        width, height : int
            Size of the picture in pixels.
        offset : tuple of float, optional
            Position of the sample within each pixel.

        Returns
        -------
        PrimaryView
            A new view. It gives the hits of one made without the closed parts, sooner.

        Raises
        ------
        ZeroDivisionError
            If width or height is 0.

        References
        ----------
        Own design.
        """
        return PrimaryView(self.geometry, camera, width, height, offset, self.solids)

    def light_view(
        self,
        position: ArrayLike | None = None,
        to_light: ArrayLike | None = None,
        camera: Camera | None = None,
        members: NDArray[np.bool_] | None = None,
        *,
        keep: bool = False,
    ) -> LightView:
        """Look from a light.

        Parameters
        ----------
        position : (3,) array_like of float, optional
            Where the light stands, in recentred coordinates. Either this or `to_light` is given.
        to_light : (3,) array_like of float, optional
            Direction to a light that is infinitely far, of any length.
        camera : Camera, optional
            Promise that the points the view is asked for are seen by this camera, directly or by way of mirrors, and
            lie on surfaces whose seen side faces the light. Much quicker where meshes are closed, with the same
            verdicts.
        members : (T,) ndarray of bool, optional
            The triangles that may hide the light, all or none of an instance's; None for all that cast shadows.
        keep : bool, optional
            Give the same view again to the next who asks for it, until :meth:`forget_lights` or until memory runs
            short: then that which was not asked for longest goes.

        Returns
        -------
        LightView
            The view.

        Raises
        ------
        TypeError
            Unless either `position` or `to_light` is given.

        References
        ----------
        Own design.
        """
        sight = None if camera is None else sight_box(self.geometry, camera)

        solids = self.solids
        if not keep:
            return LightView(self.geometry, position, to_light, sight, solids, members)
        key = (
            _key(self.geometry.shadow_visible if members is None else members),
            *(
                None if value is None else np.asarray(value, np.float64).tobytes()
                for value in (position, to_light, *(sight or (None, None)))
            ),
        )
        with self._lock:
            view = self._lights.get(key)
            if view is None:
                view = self._lights[key] = LightView(self.geometry, position, to_light, sight, solids, members)
                while len(self._lights) > self._most_lights:
                    self._lights.popitem(last=False)
            else:
                self._lights.move_to_end(key)
        return view

    def forget_lights(self) -> None:
        """Let go of the kept views of lights.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        with self._lock:
            self._lights.clear()


class AccelerationCache:
    """The acceleration of the geometry that was asked for last, for callers that get their scenes anew each frame.

    Instances are compared by their matrices, visibility and meshes, array by array: moving a lamp or the camera, or
    changing a material, keeps it; moving or editing an object does not.

    Parameters
    ----------
    None.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: tuple[tuple[Instance, ...], np.dtype[Any], Acceleration] | None = None

    def get(
        self,
        instances: Sequence[Instance],
        dtype: DTypeLike = np.float32,
        stop_if_cancelled: Callable[[], None] = lambda: None,
    ) -> Acceleration:
        """Give the acceleration of some instances.

        Parameters
        ----------
        instances : sequence of Instance
            What the geometry is made of. Their arrays must not be written to afterwards.
        dtype : dtype, optional
            Working precision.
        stop_if_cancelled : callable, optional
            Asked every few hundredths of a second; raises when the caller wants an end.

        Returns
        -------
        Acceleration
            The kept one if the instances are the same; otherwise a new one, kept from now on.

        Raises
        ------
        SceneError
            None here: meshes and instances were checked when they were made.

        References
        ----------
        Own design.
        """
        dtype = np.dtype(dtype)
        with self._lock:
            if self._kept is not None:
                before, precision, acceleration = self._kept
                if precision == dtype and _same(before, instances):
                    return acceleration
            self._kept = None  # first, so that memory holds one of them
            acceleration = Acceleration(Geometry.from_instances(instances, dtype, stop_if_cancelled))
            self._kept = (tuple(instances), dtype, acceleration)
            return acceleration

    def clear(self) -> None:
        """Let go of what is kept.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        with self._lock:
            self._kept = None


def _key(members: NDArray[np.bool_] | None) -> bytes:
    """Tell sets of triangles apart; empty for all of them."""
    return b"" if members is None or members.all() else np.packbits(members).tobytes()


def _same(before: Sequence[Instance], after: Sequence[Instance]) -> bool:
    if len(before) != len(after):
        return False
    meshes: dict[tuple[int, int], bool] = {}
    for one, other in zip(before, after, strict=True):
        if one is other:
            continue
        if (one.camera_visible, one.shadow_visible) != (other.camera_visible, other.shadow_visible):
            return False
        if not np.array_equal(one.matrix, other.matrix):
            return False
        pair = (id(one.mesh), id(other.mesh))
        if pair not in meshes:
            meshes[pair] = one.mesh is other.mesh or all(
                _equal(getattr(one.mesh, name), getattr(other.mesh, name)) for name in _ARRAYS
            )
        if not meshes[pair]:
            return False
    return True


def _equal(one: NDArray[np.generic] | None, other: NDArray[np.generic] | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one, other)
