"""The display that pictures of a scene are for, and its drive values: what leaves Blender's own colour management.

Blender's view knows sRGB and a few others, but no monitor that somebody measured. A picture for another display than
sRGB therefore holds the values that the display is driven with, and is marked as no colour for Blender to convert.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ._core import core
from .properties import MONITOR, read_display

__all__ = ["OutputDisplay", "OutputPicture", "monitor_problem", "output_development", "output_picture", "read_output"]

DRIVE_VALUES = "Non-Color"
LINEAR_SRGB = "Linear Rec.709"


@dataclass(frozen=True, slots=True)
class OutputDisplay:
    """How pictures of a scene leave Blender; a measured monitor's file is not read before it is needed.

    Attributes
    ----------
    scene : str
        Name of the scene, for messages.
    display : str
        One of the core's displays, or "monitor".
    monitor_file : str
        Absolute path of the measured monitor's CSV.
    gamut : str
        "clip" or "compress".
    white : Spectrum
        Adopted white.
    adaptation : str
        "none", "bradford" or "cat16".
    exposure : float
        Stops.
    """

    scene: str
    display: str
    monitor_file: str
    gamut: str
    white: core.Spectrum
    adaptation: str
    exposure: float

    @property
    def keeps_light(self) -> bool:
        """Whether the picture stays linear light without an end, as Blender's view wants it."""
        return self.display == "srgb" and self.gamut == "clip"

    def development(self) -> core.Development:
        """Return how the picture is made.

        Raises
        ------
        SceneError
            If the file of the measured monitor cannot be read; the message gives the reason.
        """
        if self.display != MONITOR:
            shown = core.display(self.display)
        else:
            try:
                shown = _monitor(self.monitor_file)
            except core.DichromaticError as error:
                raise core.SceneError(f"Monitor of scene '{self.scene}': {error}") from error
        return core.Development(shown, self.white, self.adaptation, self.exposure, self.gamut)


@dataclass(frozen=True, slots=True, eq=False)
class OutputPicture:
    """Pixels of an image datablock.

    Attributes
    ----------
    pixels : ndarray of float32, shape (H, W, 4)
        Row 0 is the top; premultiplied.
    colour_space : str
        Blender's name of what the pixels are.
    mapping : GamutMapping or None
        What happened to colours that the display cannot show; None where nobody counted.
    """

    pixels: NDArray[np.float32]
    colour_space: str
    mapping: Any


def _monitor(path: str) -> core.Display:
    if not path:
        raise core.SpectrumFileError("no CSV file of a measured monitor is chosen")
    try:
        found = os.stat(path)
    except OSError:
        raise core.SpectrumFileError(f"{path}: there is no such file") from None
    return _read_monitor(path, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=8)
def _read_monitor(path: str, changed: int, size: int) -> core.Display:
    """Read a monitor once for each state of its file; panels ask at every redraw."""
    return core.read_display(path)


def read_output(scene: Any) -> OutputDisplay:
    """Return how pictures of a scene leave Blender.

    Parameters
    ----------
    scene : bpy.types.Scene
        Original or evaluated.

    Returns
    -------
    OutputDisplay
        Not yet asked for its monitor.

    Raises
    ------
    SceneError
        If the adopted white cannot be had.
    """
    settings, shown = scene.dichromatic, read_display(scene)
    library = getattr(scene, "library", None)
    path = bpy.path.abspath(settings.monitor_file, library=library) if settings.monitor_file else ""
    return OutputDisplay(
        scene=scene.name,
        display=settings.display,
        monitor_file=path,
        gamut=settings.gamut,
        white=shown.white,
        adaptation=shown.adaptation,
        exposure=scene.view_settings.exposure,
    )


def output_development(scene: Any) -> core.Development:
    """Return how the pictures of a scene are made that leave Blender.

    Parameters
    ----------
    scene : bpy.types.Scene
        Original or evaluated.

    Returns
    -------
    Development
        With the display and gamut method that are chosen in the scene.

    Raises
    ------
    SceneError
        If the adopted white or the measured monitor cannot be had.
    """
    return read_output(scene).development()


def monitor_problem(scene: Any) -> str:
    """Say why the measured monitor of a scene cannot be had, for the panel; an empty string when it can."""
    settings = scene.dichromatic
    if settings.display != MONITOR:
        return ""
    try:
        _monitor(bpy.path.abspath(settings.monitor_file) if settings.monitor_file else "")
    except core.DichromaticError as error:
        return str(error)
    return ""


def output_picture(finished: Any, *, counted: bool = True) -> OutputPicture:
    """Make the picture of a finished layer for the display of its scene.

    Parameters
    ----------
    finished : FinishedLayer
        A render with what was exported for it.
    counted : bool, optional
        Whether to count colours out of gamut even where they are left as they are.

    Returns
    -------
    OutputPicture
        sRGB: linear light, beyond 0 to 1 when clipping is left to the view, mapped at the scene's exposure when
        colours are compressed. Other displays: drive values.

    Raises
    ------
    SceneError
        If the measured monitor cannot be had.
    """
    exported, render = finished.exported, finished.render
    output = exported.colour.output
    tristimulus = render.tristimulus()
    alpha = render.alpha[..., None] if exported.is_transparent else np.ones((*tristimulus.shape[:2], 1), np.float32)
    pixels = np.ones((*tristimulus.shape[:2], 4), np.float32)
    pixels[..., 3:] = alpha
    if output is None or output.keeps_light:
        # One product in the render's own precision: a picture that is relit must not wait for its pixels.
        matrix = core.display("srgb").from_tristimulus @ exported.colour.adaptation
        pixels[..., :3] = tristimulus @ matrix.T.astype(tristimulus.dtype)
        mapping = None
        if counted and output is not None:
            mapping = output.development().picture(_straight(tristimulus, alpha), render.observer)[1]
        return OutputPicture(pixels, LINEAR_SRGB, mapping)
    xyz = tristimulus.astype(np.float64)
    made = output.development()
    drive, mapping = made.picture(_straight(xyz, alpha), render.observer)
    if output.display == "srgb":  # Blender's view shows it: light again, and without the view's own exposure
        pixels[..., :3] = mapping.linear_rgb / 2.0**output.exposure * alpha
        return OutputPicture(pixels, LINEAR_SRGB, mapping)
    pixels[..., :3] = drive * alpha
    return OutputPicture(pixels, DRIVE_VALUES, mapping)


def _straight(xyz: NDArray[np.float64], alpha: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Undo premultiplication: transfer curves and gamuts are for the colours of surfaces, not of shares of pixels."""
    return np.asarray(xyz / np.where(alpha > 0.0, alpha, 1.0))
