"""Which point of the pixel, of the lens and of each lamp a sample takes.

A pixel's points of a lamp are a run of Sobol's sequence, so that a few cover the ground; those of two by two
neighbours are a longer run of the same, and those of four by four a longer one still, so that neighbours together
cover it more finely. The points within the pixel are the same everywhere. Directions to surroundings are then
exchanged among the pixels of a tile, so that each has even ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .scene import RenderSettings
from .sub_pictures import tile_places
from .tracing.balance import MOST_BALANCED, balanced_groups
from .tracing.sampling import disk_points, pixel_offsets, polygon_points, sobol_points

__all__ = ["SamplePattern", "interleaving"]

_SPARSE = 16  # samples below which neighbouring pixels must help each other out


def interleaving(settings: RenderSettings, is_sampled: bool) -> int:
    """Find how many sub-pictures a side the picture is cut into.

    Parameters
    ----------
    settings : RenderSettings
        The samples a pixel.
    is_sampled : bool
        Whether a lamp, the sky or the lens takes many points.

    Returns
    -------
    int
        1, 2 or 4.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    if not is_sampled:
        return 1
    return 4 if settings.samples < _SPARSE else 2


@dataclass(frozen=True, slots=True, eq=False)
class SamplePattern:
    """The points of all samples of a render.

    Attributes
    ----------
    offsets : ndarray of float64, shape (S, 2)
        Within each pixel (x, y); (0.5, 0.5) is its centre. The first `first_samples` of them are spread evenly, too.
    lens : ndarray of float64, shape (K * K, S, 2)
        On the unit disk, by sub-picture and sample; zeros where the lens is a point.
    lamps : tuple of ndarray of float64, each of shape (K * K, S, J, 3)
        Random numbers from 0 to 1, for each source of light, by sub-picture, sample and point of the lamp.
    """

    offsets: NDArray[np.float64]
    lens: NDArray[np.float64]
    lamps: tuple[NDArray[np.float64], ...]

    @classmethod
    def make(
        cls,
        settings: RenderSettings,
        step: int,
        lamp_points: tuple[int, ...],
        lens_blades: int = 0,
        thinness: float = 1.0,
    ) -> SamplePattern:
        """Draw the points.

        Parameters
        ----------
        settings : RenderSettings
            Samples, filter and seed.
        step : int
            K.
        lamp_points : tuple of int
            For each source of light, the points that a sample takes of it.
        lens_blades : int
            Corners of the aperture; below 3 it is round.
        thinness : float
            Height of what a row shows, in its distance to the next.

        Returns
        -------
        SamplePattern
            The same for equal arguments.

        Raises
        ------
        None.

        References
        ----------
        Sobol, see :func:`~spectral_core.tracing.sampling.sobol_points`.
        """
        samples, first = settings.samples, first_samples(settings)
        rng = np.random.default_rng((settings.seed, 0))
        # The place in the pixel must not go with the point of a lamp: shuffled, but the first samples stay the first.
        order = _nested_order(samples, first)[_shuffled(samples, first, rng)]
        offsets = pixel_offsets(samples, settings.pixel_filter, settings.filter_width, settings.seed)[order]
        offsets[:, 1] = 0.5 + (offsets[:, 1] - 0.5) * thinness
        shape = disk_points if lens_blades < 3 else (lambda points: polygon_points(points, lens_blades))
        lens = shape(_points(step, samples, 1, rng)[:, :, 0, :2])
        # Nor the point of the lens with that of a lamp.
        lens = np.stack([row[_shuffled(samples, first, rng)] for row in lens])
        return cls(offsets, lens, tuple(_points(step, samples, count, rng) for count in lamp_points))

    def balanced(
        self, source: int, directions: Callable[[NDArray[np.float64]], NDArray[np.float64]], seed: int
    ) -> SamplePattern:
        """Exchange a source's points between sub-pictures, so that each looks evenly around.

        Parameters
        ----------
        source : int
            Number of the source in `lamps`.
        directions : callable
            Gives the unit vectors (..., 3) to which its numbers (..., 3) lead.
        seed : int
            Of the settings.

        Returns
        -------
        SamplePattern
            With the same points for a tile; in the mean over all seeds those of a pixel are spread as they were.
            This one where there is a single sub-picture, or more than 256 points.

        Raises
        ------
        ValueError
            By numpy, if the shapes do not fit together.

        References
        ----------
        See :func:`~spectral_core.tracing.balance.balanced_groups`.
        """
        numbers = self.lamps[source]
        places, samples, count, _ = numbers.shape
        if places == 1 or places * samples * count > MOST_BALANCED:
            return self
        chosen = balanced_groups(directions(numbers).reshape(places, samples * count, 3))
        # Which pixel gets which group must not hang on how they were found. Squares of pixels stay together.
        rank = np.array([_run_number(column, row) for column, row in tile_places(math.isqrt(places))])
        moved = rank ^ np.random.default_rng((seed, 1, source)).integers(places)
        chosen = chosen[np.argsort(rank)[moved]]
        lamps = list(self.lamps)
        lamps[source] = np.take(numbers.reshape(-1, 3), chosen, axis=0).reshape(numbers.shape)
        return replace(self, lamps=tuple(lamps))


def first_samples(settings: RenderSettings) -> int:
    """How many samples every pixel takes before it is decided whether it needs the others.

    Parameters
    ----------
    settings : RenderSettings
        The settings.

    Returns
    -------
    int
        An even number, or all samples where they are not adaptive or too few for it.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    wanted = settings.min_samples + settings.min_samples % 2
    return wanted if settings.adaptive_threshold > 0.0 and wanted < settings.samples else settings.samples


def _nested_order(samples: int, first: int) -> NDArray[np.int64]:
    """Order in which the first few points of a lattice are spread evenly over all of it."""
    if first >= samples:
        return np.arange(samples)
    chosen = np.arange(first) * samples // first
    return np.concatenate([chosen, np.setdiff1d(np.arange(samples), chosen)])


def _shuffled(samples: int, first: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """A random order of samples in which the first few stay before the others."""
    return np.concatenate([rng.permutation(first), first + rng.permutation(samples - first)])


def _points(step: int, samples: int, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Points (K * K, S, J, 3) of one lamp, for each sub-picture, sample and point that a sample takes."""
    run = samples * count  # without gaps between the runs of two pixels: what falls into them would be seen by none
    place = np.array([_run_number(column, row) for column, row in tile_places(step)])
    index = place[:, None] * run + np.arange(run)
    scramble = rng.integers(0, 1 << 32, 3, np.uint32)
    points = sobol_points(index, scramble)
    # The third number chooses a triangle. It stays in its interval, but is random there: even steps may keep pace with
    # how a mesh's triangles follow each other.
    intervals = 1 << (index.size - 1).bit_length()
    within = np.random.default_rng(scramble).random(index.shape)
    points[..., 2] = (np.floor(points[..., 2] * intervals) + within) / intervals
    return points.reshape(step * step, samples, count, 3)


def _run_number(column: int, row: int) -> int:
    """Number of a place in the tile, with the bits of its column and row in turn: squares of places are runs of it."""
    return sum((column >> bit & 1) << 2 * bit | (row >> bit & 1) << 2 * bit + 1 for bit in range(8))
