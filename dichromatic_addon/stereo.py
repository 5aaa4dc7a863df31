"""Blender's stereoscopy: which views a scene has, and how the window of an eye lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

__all__ = ["StereoEye", "eye_window", "stereo_views"]


@dataclass(frozen=True, slots=True, eq=False)
class StereoEye:
    """Where one eye looks from, as Blender has worked it out.

    Attributes
    ----------
    matrix : mathutils.Matrix
        World from camera.
    shift_x : float
        Lens shift, the camera's own included; in widths of the sensor.
    """

    matrix: Any
    shift_x: float


def stereo_views(scene: Any) -> tuple[str, ...]:
    """Return the names of a scene's views; none without stereoscopy."""
    render = scene.render
    if not render.use_multiview:
        return ()
    views = render.stereo_views if render.views_format == "STEREO_3D" else render.views
    return tuple(view.name for view in views if view.use)


def eye_window(
    window: tuple[float, float, float, float], camera: Any, eye: StereoEye
) -> tuple[float, float, float, float]:
    """Shift a camera's window (left, right, bottom, top) to that of an eye.

    Parameters
    ----------
    window : tuple of float
        With the camera's own shift: tangents, or scene units for an orthographic camera.
    camera : bpy.types.Camera
        The camera's data.
    eye : StereoEye
        The eye.

    Returns
    -------
    tuple of float
        The same size, elsewhere.

    Raises
    ------
    None.

    References
    ----------
    Blender's BKE_camera_params_compute_viewplane: a shift of 1 is the size of the sensor, by its fit.
    """
    if camera.type == "ORTHO":
        unit = camera.ortho_scale
    else:
        unit = (camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width) / camera.lens
    across = (eye.shift_x - camera.shift_x) * unit
    left, right, bottom, top = window
    return left + across, right + across, bottom, top
