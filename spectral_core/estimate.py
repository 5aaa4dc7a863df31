"""What a render will cost and how far it will be off, from a few rows of it.

Some rows, spread over the picture, are rendered as asked and once more as the reference; their pixels are a fair sample
of the picture's, so the mean colour difference needs no model. Time: the same rows with one sample, and more rows with
one sample, tell apart what is done once, once a sample, and once a row.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import delta_e_2000, lab, observer, white_point
from .development import Development
from .errors import InvalidParameterError
from .renderer import Cancel, render
from .scene import RenderSettings, Scene
from .statistics import RenderStatistics

__all__ = ["ColourError", "Estimate", "colour_error", "estimate", "expected_seconds", "reference_settings"]

REFERENCE_SAMPLES = 16
_SAMPLED_REFERENCE = 8  # least samples of the reference in the rows that are compared
_LEAST_ROWS = 16
_FEW_ROWS = 30  # one row of so many is compared
_TIMED_PART = 16  # the rows that are timed with one sample cost one part in so many of the render


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
        Against the reference; the largest is that of the rows compared, so the picture's may be larger.
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
        (four times as many as asked, if that is more) in every pixel.

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
        adaptive_threshold=0.0,
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


def estimate(
    scene: Scene,
    settings: RenderSettings,
    development: Development | None = None,
    cancel: Cancel | None = None,
) -> Estimate:
    """Estimate error and time of a render from a few rows of it.

    The reference of these rows has twice the samples that are asked, at least 8, instead of the four times and at least
    16 of :func:`reference_settings`. Differences that shrink with the samples come out at most a tenth larger for it.

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
    low = min(settings.height, max(_LEAST_ROWS, settings.height // _FEW_ROWS))
    tall = min(settings.height, max(4 * low, settings.height * settings.samples // _TIMED_PART))
    best = replace(reference_settings(settings), samples=max(_SAMPLED_REFERENCE, 2 * settings.samples))
    once = replace(settings, samples=1)
    asked, reference = (render(scene, s, cancel=cancel, rows=low) for s in (settings, best))
    error = colour_error(asked.tristimulus(), reference.tristimulus(), settings.observer, development)
    timed = [render(scene, once, cancel=cancel, rows=rows).statistics for rows in (tall, low)]
    seconds = expected_seconds([*timed, asked.statistics], settings)
    return Estimate(error, seconds, time.perf_counter() - started)


def expected_seconds(parts: Sequence[RenderStatistics], settings: RenderSettings) -> float:
    """Expect the time of a render from three with fewer rows.

    Parameters
    ----------
    parts : sequence of RenderStatistics, length 3
        Of many rows and of few with one sample each, and of the few with any number of samples.
    settings : RenderSettings
        The render in question.

    Returns
    -------
    float
        Seconds, above 0: preparation + once + samples x (once a sample + rows x once a row), none of them below 0.

    Raises
    ------
    KeyError
        If the statistics lack the times "total" and "geometry".

    References
    ----------
    Own design.
    """
    work = [part.seconds["total"] - part.seconds["geometry"] for part in parts]
    tall, low = parts[0].height, parts[1].height
    # Without two heights, or with times that noise has turned round, all of a sample's time counts as that of its rows.
    per_row = (work[0] - work[1]) / (tall - low) if tall > low else 0.0
    if per_row <= 0.0:
        per_row = max(work[0] / tall, work[1] / low)
    rest = max(work[1] - per_row * low, 0.0)
    more = parts[2].samples - parts[1].samples
    per_sample = min(max((work[2] - work[1]) / more - per_row * low, 0.0), rest) if more else 0.0
    once = rest - per_sample + min(part.seconds["geometry"] for part in parts)
    return once + settings.samples * (per_sample + settings.height * per_row)
