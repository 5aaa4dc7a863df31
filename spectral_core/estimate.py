"""What a render will cost and how far it will be off, from strips of it.

Strips of a few rows, spread over the picture at its full resolution, are rendered as asked and once more as the
reference; their pixels are a fair sample of the picture's, so the mean colour difference needs no model. Time is the
preparation, plus a share per band and per row that strips of two heights tell apart.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import delta_e_2000, lab, observer, white_point
from .development import Development
from .errors import InvalidParameterError
from .renderer import Cancel, Render, render
from .scene import RenderSettings, Scene

__all__ = ["ColourError", "Estimate", "colour_error", "estimate", "reference_settings"]

REFERENCE_SAMPLES = 16
_STRIPS = 12
_ROWS = 2  # height of the lower strips; the others are twice as high


@dataclass(frozen=True, slots=True)
class ColourError:
    """Colour differences between two pictures.

    Attributes
    ----------
    mean, percentile_95, largest : float
        CIE Delta E 2000.
    """

    mean: float
    percentile_95: float
    largest: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a render is expected to take.

    Attributes
    ----------
    error : ColourError
        Against :func:`reference_settings`; the largest is that of the strips, so the picture's may be larger.
    seconds : float
        Expected time of the whole render.
    spent : float
        Time that the estimate took (s).
    """

    error: ColourError
    seconds: float
    spent: float

    def describe(self) -> str:
        """Tell the estimate in words.

        Returns
        -------
        str
            One sentence.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return (
            f"about {self.seconds:.2g} s; Delta E 2000 against the reference: mean {self.error.mean:.2g}, "
            f"95 % below {self.error.percentile_95:.2g}"
        )


def reference_settings(settings: RenderSettings) -> RenderSettings:
    """Give the settings that errors are measured against.

    Parameters
    ----------
    settings : RenderSettings
        What is to be judged.

    Returns
    -------
    RenderSettings
        The same picture with float64, the exact grid, 8 bounces kept exactly or at 81 nodes, and at least 16 samples
        (four times as many as asked, if that is more).

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    return replace(
        settings,
        samples=max(REFERENCE_SAMPLES, 4 * settings.samples),
        precision="float64",
        grid="exact",
        bounce_spectra="auto",
        bounce_grid="reference",
        max_bounces=max(8, settings.max_bounces),
        seed=settings.seed + 1,
    )


def colour_error(
    tristimulus: NDArray[np.floating[Any]],
    reference: NDArray[np.floating[Any]],
    observer_name: str,
    development: Development | None = None,
) -> ColourError:
    """Colour differences of two pictures, pixel by pixel, as they would be seen.

    Parameters
    ----------
    tristimulus, reference : ndarray, shape (..., 3)
        X, Y, Z of both.
    observer_name : str
        Observer they were computed for.
    development : Development, optional
        Exposure and adaptation; Lab refers to the display's white, and colours brighter than it count as it.

    Returns
    -------
    ColourError
        Mean, 95th percentile and maximum.

    Raises
    ------
    InvalidParameterError
        If the shapes differ or there is no pixel.

    References
    ----------
    CIE 142-2001 (CIEDE2000).
    """
    if tristimulus.shape != reference.shape or not tristimulus.size:
        raise InvalidParameterError(f"pictures must have one shape, but have {tristimulus.shape} and {reference.shape}")
    development = development or Development()
    white = development.shown.white
    if development.adaptation == "none":
        # Without adaptation the eye is at home under the scene's own white.
        white = white_point(development.adopted_white, observer(observer_name))
    seen = [
        lab(np.clip(development.adapted(image, observer_name), 0.0, white), white) for image in (tristimulus, reference)
    ]
    difference = delta_e_2000(seen[0], seen[1])
    return ColourError(float(difference.mean()), float(np.percentile(difference, 95.0)), float(difference.max()))


def _strips(height: int, rows: int, count: int) -> list[tuple[int, int]]:
    """Runs of rows, one in the middle of each of `count` parts of the picture."""
    count = max(1, min(count, height // rows))
    centres = (np.arange(count) + 0.5) * height / count
    first = np.clip(np.rint(centres - rows / 2).astype(int), 0, max(height - rows, 0))
    return [(int(row), int(min(row + rows, height))) for row in first]


def estimate(
    scene: Scene,
    settings: RenderSettings,
    development: Development | None = None,
    cancel: Cancel | None = None,
) -> Estimate:
    """Estimate error and time of a render from strips of it.

    Parameters
    ----------
    scene : Scene
        What would be rendered.
    settings : RenderSettings
        How.
    development : Development, optional
        How its picture is judged.
    cancel : callable, optional
        Asked between bands; a true answer stops the estimate.

    Returns
    -------
    Estimate
        Error and time.

    Raises
    ------
    SceneError
        If the scene has no camera.
    RenderCancelledError
        If `cancel` said so.

    References
    ----------
    Own design.
    """
    started = time.perf_counter()
    low, high = (_strips(settings.height, rows, _STRIPS) for rows in (_ROWS, 2 * _ROWS))
    thin = render(scene, settings, cancel=cancel, rows=low)
    thick = render(scene, settings, cancel=cancel, rows=high)
    reference = render(scene, reference_settings(settings), cancel=cancel, rows=high)
    chosen = np.concatenate([np.arange(first, last) for first, last in high])
    error = colour_error(thick.tristimulus()[chosen], reference.tristimulus()[chosen], settings.observer, development)
    return Estimate(error, _whole_time(thin, low, thick, high, settings), time.perf_counter() - started)


def _whole_time(
    thin: Render,
    low: list[tuple[int, int]],
    thick: Render,
    high: list[tuple[int, int]],
    settings: RenderSettings,
) -> float:
    """Preparation, plus a share per band and per row from strips of two heights."""
    prepared = min(r.statistics.seconds["geometry"] for r in (thin, thick))
    work = [r.statistics.seconds["total"] - r.statistics.seconds["geometry"] for r in (thin, thick)]
    rows = [sum(last - first for first, last in strips) for strips in (low, high)]
    bands = len(low), len(high)
    height = max(1, settings.band_samples // settings.width)
    whole_bands = -(-settings.height // height)
    per_row = work[1] / rows[1]
    per_band = 0.0
    if bands[0] == bands[1] and rows[1] > rows[0]:
        per_row = np.clip((work[1] - work[0]) / (rows[1] - rows[0]), 0.0, per_row)
        per_band = max(0.0, (work[1] - per_row * rows[1]) / bands[1])
    return float(prepared + per_row * settings.height + per_band * whole_bands)
