"""From tristimulus values to the colours of Blender's picture: adaptation, then the file's working space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mathutils
import numpy as np
from numpy.typing import NDArray

from ._core import core
from .output_display import OutputDisplay, read_output
from .properties import read_display

__all__ = ["PictureColour", "picture_colour", "srgb_development", "working_space_from_tristimulus"]


@dataclass(frozen=True, slots=True, eq=False)
class PictureColour:
    """How XYZ becomes scene linear RGB.

    Attributes
    ----------
    adaptation : ndarray of float64, shape (3, 3)
        XYZ under the scene's lamp to XYZ under the display's white, as a matrix for column vectors.
    working_space : ndarray of float64, shape (3, 3)
        XYZ (D65) to the scene linear RGB of the .blend file, as a matrix for column vectors.
    output : OutputDisplay or None
        The display that image datablocks and files are made for; sRGB when None.
    """

    adaptation: NDArray[np.float64]
    working_space: NDArray[np.float64]
    output: OutputDisplay | None = None

    def adapted(self, tristimulus: NDArray[np.floating]) -> NDArray[np.floating]:
        """Return XYZ (..., 3) as seen on a display with a D65 white."""
        return tristimulus @ self.adaptation.T.astype(tristimulus.dtype)

    def rgba(self, tristimulus: NDArray[np.floating], alpha: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Return scene linear RGBA (H, W, 4), premultiplied; opaque where `alpha` is None."""
        matrix = self.working_space @ self.adaptation
        height, width, _ = tristimulus.shape
        pixels = np.ones((height, width, 4), np.float32)
        pixels[..., :3] = tristimulus @ matrix.T.astype(tristimulus.dtype)
        if alpha is not None:
            pixels[..., 3] = alpha
        return pixels


def working_space_from_tristimulus() -> NDArray[np.float64]:
    """Return Blender's own matrix from XYZ (D65) to scene linear RGB: Rec.709, or what the file uses from 5.0 on."""
    columns = [tuple(mathutils.Color(axis).from_xyz_d65_to_scene_linear()) for axis in np.eye(3)]
    return np.array(columns, np.float64).T


def picture_colour(scene: Any) -> PictureColour:
    """Return how a scene's tristimulus values become its picture's colours.

    Parameters
    ----------
    scene : bpy.types.Scene
        Original or evaluated.

    Returns
    -------
    PictureColour
        With the scene's adopted white brought to D65, the white of Blender's displays.

    Raises
    ------
    DichromaticError
        If the adopted white cannot be had.
    """
    shown = read_display(scene)
    white = core.white_point(shown.white, core.observer(scene.dichromatic.observer))
    return PictureColour(
        adaptation=core.chromatic_adaptation(white, core.SRGB_WHITE, shown.adaptation),
        working_space=working_space_from_tristimulus(),
        output=read_output(scene),
    )


def srgb_development(scene: Any) -> core.Development:
    """Return how the picture of a Blender scene is made for sRGB: its adopted white, adaptation and exposure."""
    shown = read_display(scene)
    return core.Development(
        adopted_white=shown.white, adaptation=shown.adaptation, exposure=scene.view_settings.exposure
    )
