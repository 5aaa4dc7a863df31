"""The pinhole and the orthographic camera: from positions in the picture to rays."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..validation import require_choice, require_finite, require_in_range, require_integer, require_shape
from .columns import dot_rows

__all__ = ["Camera"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A camera that looks along its -Z axis with +Y up.

    Parameters
    ----------
    matrix : (4, 4) array_like of float
        World from camera. Scale is taken out: only directions and position count.
    window : tuple of float
        Left, right, bottom and top of the picture on the plane z = -1: tangents of the half angles for a perspective
        camera, scene units for an orthographic one. Left < right and bottom < top; it need not be centred (shift).
    kind : {"perspective", "orthographic"}
        The projection.
    clip_start, clip_end : float
        Depths along -Z between which things are seen; 0 < clip_start < clip_end for perspective cameras, any
        clip_start < clip_end for orthographic ones.
    lens_radius : float
        Radius of the lens (scene units), for perspective cameras; 0 is a pinhole, for which everything is in focus.
    focus_distance : float
        Depth along -Z of what is in focus, above 0; only a lens asks for it.
    lens_blades : int
        Corners of the aperture; below 3 it is round.
    lens_rotation : float
        Angle by which a cornered aperture is turned (rad).
    lens_ratio : float
        How much higher than wide what is out of focus looks, above 0: the squeeze of an anamorphic lens.

    Raises
    ------
    InvalidParameterError
        If a parameter breaks its rule.

    References
    ----------
    Conventions: Blender manual, Cameras.
    """

    matrix: Floats
    window: tuple[float, float, float, float]
    kind: str = "perspective"
    clip_start: float = 0.1
    clip_end: float = 1000.0
    lens_radius: float = 0.0
    focus_distance: float = math.inf
    lens_blades: int = 0
    lens_rotation: float = 0.0
    lens_ratio: float = 1.0

    def __post_init__(self) -> None:
        matrix = require_finite("camera matrix", self.matrix)
        require_shape("camera matrix", matrix, (4, 4))
        window = require_finite("camera window", self.window)
        require_shape("camera window", window, (4,))
        require_choice("camera kind", self.kind, ("perspective", "orthographic"))
        if not (window[0] < window[1] and window[2] < window[3]):
            raise InvalidParameterError(
                f"camera window must have left < right and bottom < top, but is {window.tolist()}"
            )
        if self.kind == "perspective" and not self.clip_start > 0.0:
            raise InvalidParameterError(f"camera clip_start must be above 0, but is {self.clip_start:g}")
        require_in_range("camera clip_start", self.clip_start)
        require_in_range("camera clip_end", self.clip_end)
        if not self.clip_end > self.clip_start:
            raise InvalidParameterError(
                f"camera clip_end must be above clip_start {self.clip_start:g}, but is {self.clip_end:g}"
            )
        require_in_range("camera lens_radius", self.lens_radius, 0.0)
        if not self.focus_distance > 0.0:
            raise InvalidParameterError(f"camera focus_distance must be above 0, but is {self.focus_distance:g}")
        require_integer("camera lens_blades", self.lens_blades, 0)
        require_in_range("camera lens_rotation", self.lens_rotation)
        if not self.lens_ratio > 0.0:
            raise InvalidParameterError(f"camera lens_ratio must be above 0, but is {self.lens_ratio:g}")
        axes = matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-300)
        if abs(np.linalg.det(axes)) < 1e-6:
            raise InvalidParameterError(f"camera matrix must have three independent axes, but is {matrix.tolist()}")
        rigid = np.eye(4)
        rigid[:3, :3], rigid[:3, 3] = axes, matrix[:3, 3]
        object.__setattr__(self, "matrix", rigid)
        object.__setattr__(self, "window", tuple(window.tolist()))

    @property
    def position(self) -> Floats:
        """The camera's place in the world, (3,)."""
        return self.matrix[:3, 3]

    @property
    def has_lens(self) -> bool:
        """Whether things out of focus are blurred."""
        return self.kind == "perspective" and self.lens_radius > 0.0

    def through_lens(self, point: Floats) -> Camera:
        """Give the pinhole camera that sits at a point of the lens.

        Parameters
        ----------
        point : (2,) ndarray of float64
            On the unit disk or the polygon of the aperture.

        Returns
        -------
        Camera
            It sees what is in focus at the same place of the picture; without a lens it is the camera itself.

        Raises
        ------
        None.

        References
        ----------
        Thin lens: Potmesil and Chakravarty, SIGGRAPH 1981; by shifted pinholes: Haeberli and Akeley, SIGGRAPH 1990.
        """
        if not self.has_lens:
            return self
        c, s = math.cos(self.lens_rotation), math.sin(self.lens_rotation)
        x = self.lens_radius * (c * point[0] - s * point[1]) / self.lens_ratio
        y = self.lens_radius * (s * point[0] + c * point[1])
        matrix = self.matrix.copy()
        matrix[:3, 3] += x * matrix[:3, 0] + y * matrix[:3, 1]
        left, right, bottom, top = self.window
        dx, dy = x / self.focus_distance, y / self.focus_distance
        return replace(self, matrix=matrix, window=(left - dx, right - dx, bottom - dy, top - dy), lens_radius=0.0)

    def sub_window(self, width: int, height: int, step: int, across: int, down: int) -> Camera:
        """Give the camera of the picture that every `step`-th pixel of this one makes.

        Parameters
        ----------
        width, height : int
            Size of this camera's picture in pixels.
        step : int
            From one pixel to the next.
        across, down : int
            Size of the smaller picture.

        Returns
        -------
        Camera
            Position (x, y) of its picture is position (step * x, step * y) of this one's.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        left, right, bottom, top = self.window
        return replace(
            self,
            window=(
                left,
                left + (right - left) * (step * across / width),
                top - (top - bottom) * (step * down / height),
                top,
            ),
        )

    def rays(self, x: ArrayLike, y: ArrayLike, width: int, height: int) -> tuple[Floats, Floats]:
        """Rays through positions in the picture; they start on the near plane.

        Parameters
        ----------
        x, y : (N,) array_like of float
            Positions in pixels: x to the right, y down; pixel i covers [i, i + 1) and row 0 is the top.
        width, height : int
            Size of the picture in pixels.

        Returns
        -------
        origins, directions : (N, 3) ndarray of float64
            In world coordinates and Fortran order; directions have unit length.

        Raises
        ------
        ValueError
            By numpy, if x and y do not broadcast.

        References
        ----------
        Own design.
        """
        left, right, bottom, top = self.window
        px, py = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        wx = left + px * ((right - left) / width)
        wy = top - py * ((top - bottom) / height)
        if self.kind == "perspective":
            towards = self._turned(wx, wy, -1.0)
            origins = towards * self.clip_start + self.position
            directions = towards / np.sqrt(wx * wx + wy * wy + 1.0)[..., None]
        else:
            origins = self._turned(wx, wy, -self.clip_start) + self.position
            directions = np.broadcast_to(-self.matrix[:3, 2], origins.shape).copy(order="F")
        return origins, directions

    def _turned(self, x: Floats, y: Floats, z: float) -> Floats:
        """Vectors (N, 3) along the world's axes, of their components along the camera's."""
        result = np.empty((3, *x.shape))
        for column, (right, up, back) in zip(result, self.matrix[:3, :3], strict=True):
            np.multiply(x, right, out=column)
            column += y * up
            column += z * back
        return np.moveaxis(result, 0, -1)

    def reach(self, directions: Floats) -> Floats:
        """How far the camera sees along its rays, from the near plane where they start to the far one.

        Parameters
        ----------
        directions : (N, 3) ndarray of float64
            Unit directions as :meth:`rays` gave them.

        Returns
        -------
        (N,) ndarray of float64
            Distances in scene units.

        Raises
        ------
        ValueError
            By numpy, if the last axis is not 3 long.

        References
        ----------
        Own design.
        """
        if self.kind == "orthographic":
            return np.full(len(directions), self.clip_end - self.clip_start)
        # Direction along the inverse of the axes: right for sheared matrices too, where columns are not orthogonal.
        cosine = -dot_rows(directions, np.linalg.inv(self.matrix[:3, :3])[2])
        return (self.clip_end - self.clip_start) / np.maximum(cosine, 1e-12)
