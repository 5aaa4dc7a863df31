"""The camera's window and the part of the picture that is rendered, exactly as Blender frames it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import core

__all__ = ["Region", "read_lens", "read_region", "view_camera", "window_from_projection"]


@dataclass(frozen=True, slots=True)
class Region:
    """The rectangle of pixels that is rendered.

    Attributes
    ----------
    full_width, full_height : int
        Size of the whole frame after the resolution percentage (pixels).
    left, bottom : int
        First column and lowest row of the rectangle, counted from the frame's lower left corner.
    width, height : int
        Size of the rectangle, at least 1.
    """

    full_width: int
    full_height: int
    left: int
    bottom: int
    width: int
    height: int

    def crop(self, window: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        """Return the part (left, right, bottom, top) of the whole frame's window that the rectangle covers."""
        left, right, bottom, top = window
        across = (right - left) / self.full_width
        up = (top - bottom) / self.full_height
        return (
            left + across * self.left,
            left + across * (self.left + self.width),
            bottom + up * self.bottom,
            bottom + up * (self.bottom + self.height),
        )


def read_region(render: Any) -> Region:
    """Read the resolution, its percentage and the render border from the scene's render settings."""
    scale = render.resolution_percentage / 100.0
    width = max(int(render.resolution_x * scale), 1)
    height = max(int(render.resolution_y * scale), 1)
    if not render.use_border:
        return Region(width, height, 0, 0, width, height)
    # Truncated towards zero in float32, as Blender does, or the result would not have the size it expects.
    left, right = (int(np.float32(v) * np.float32(width)) for v in (render.border_min_x, render.border_max_x))
    bottom, top = (int(np.float32(v) * np.float32(height)) for v in (render.border_min_y, render.border_max_y))
    if right <= left or top <= bottom:
        raise core.SceneError(
            f"the render region must cover at least one pixel, but is {right - left} x {top - bottom} pixels "
            f"of {width} x {height}"
        )
    return Region(width, height, left, bottom, right - left, top - bottom)


def read_lens(camera: Any, depsgraph: Any) -> dict[str, Any]:
    """Return the lens of an evaluated camera object, as arguments of the core's camera; none for a pinhole.

    Units are those of Cycles: the aperture's diameter is the focal length in mm over the f-number, one thousandth of
    that in scene units; the distance to an object in focus counts along the view.
    """
    data = camera.data
    if not data.dof.use_dof or data.type != "PERSP":
        return {}
    dof = data.dof
    distance = float(dof.focus_distance)
    if dof.focus_object is not None:
        target = dof.focus_object.evaluated_get(depsgraph)
        place = target.matrix_world
        if dof.focus_subtarget and target.type == "ARMATURE":
            bone = target.pose.bones.get(dof.focus_subtarget)
            place = place if bone is None else place @ bone.matrix
        eye = np.array(camera.matrix_world, np.float64)
        axis = eye[:3, 2] / np.linalg.norm(eye[:3, 2])
        distance = abs(float((np.array(place, np.float64)[:3, 3] - eye[:3, 3]) @ axis))
    return {
        "lens_radius": 0.5e-3 * float(data.lens) / float(dof.aperture_fstop),
        "focus_distance": max(distance, 1e-6),
        "lens_blades": int(dof.aperture_blades),
        "lens_rotation": float(dof.aperture_rotation),
        "lens_ratio": float(dof.aperture_ratio),
    }


def window_from_projection(projection: NDArray[np.float64], orthographic: bool) -> tuple[float, float, float, float]:
    """Invert an OpenGL projection matrix to its window (left, right, bottom, top).

    For a perspective matrix the window lies on the plane one unit before the eye (tangents), for an orthographic one
    it is in scene units. Reading it off Blender's own matrix keeps sensor fit, lens shift and pixel aspect Blender's.
    """
    sides = []
    for axis in (0, 1):
        scale = projection[axis, axis]
        # Clip coordinate = scale * x + shift (orthographic) or (scale * x - shift * 1) for a point at z = -1.
        shift = projection[axis, 3] if orthographic else -projection[axis, 2]
        sides += [(-1.0 - shift) / scale, (1.0 - shift) / scale]
    return sides[0], sides[1], sides[2], sides[3]


def view_camera(view_matrix: Any, window_matrix: Any) -> Any:
    """Return the camera of a 3D view from its two matrices: camera from world, and OpenGL projection."""
    projection = np.array(window_matrix, dtype=np.float64)
    orthographic = bool(projection[3, 3] == 1.0)
    scale, shift = projection[2, 2], projection[2, 3]
    if orthographic:
        near, far = (1.0 + shift) / scale, (shift - 1.0) / scale
    else:
        near, far = shift / (scale - 1.0), shift / (scale + 1.0)
    return core.Camera(
        matrix=np.linalg.inv(np.array(view_matrix, dtype=np.float64)),
        window=window_from_projection(projection, orthographic),
        kind="orthographic" if orthographic else "perspective",
        clip_start=min(near, far),
        clip_end=max(near, far),
    )
