"""The pinhole and the orthographic camera: from positions in the picture to rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameterError
from ..validation import require_choice, require_finite, require_in_range, require_shape

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
            In world coordinates; directions have unit length.

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
        depth = np.ones_like(wx)
        if self.kind == "perspective":
            towards = np.stack([wx, wy, -depth], axis=-1)
            origins = (towards * self.clip_start) @ self.matrix[:3, :3].T + self.position
            directions = towards / np.linalg.norm(towards, axis=-1, keepdims=True) @ self.matrix[:3, :3].T
        else:
            origins = np.stack([wx, wy, -depth * self.clip_start], axis=-1) @ self.matrix[:3, :3].T + self.position
            directions = np.broadcast_to(-self.matrix[:3, 2], origins.shape).copy()
        return origins, directions

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
        cosine = -(directions @ np.linalg.inv(self.matrix[:3, :3]).T[:, 2])
        return (self.clip_end - self.clip_start) / np.maximum(cosine, 1e-12)
