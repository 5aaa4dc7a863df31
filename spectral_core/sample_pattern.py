"""Which point of the pixel, of the lens and of each lamp a sample takes.

Within a pixel they are a lattice, so that a few cover the ground; from one sub-picture to the next the lattice is
shifted, so that neighbours together cover it more finely. The pixel's own points are the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scene import RenderSettings
from .tracing.sampling import disk_points, pixel_offsets, polygon_points, square_points

__all__ = ["SamplePattern", "interleaving"]

_SPARSE = 16  # samples below which neighbouring pixels must help each other out

_THIRD = 0.8191725133961645  # 1 over the root of x^4 = x + 1: an additive sequence that goes with no other


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
        Lattices: Sloan and Joe 1994; shifts: Cranley and Patterson 1976.
        """
        samples, tiles = settings.samples, step * step
        order = _nested_order(samples, first_samples(settings))
        offsets = pixel_offsets(samples, settings.pixel_filter, settings.filter_width, settings.seed)[order]
        offsets[:, 1] = 0.5 + (offsets[:, 1] - 0.5) * thinness
        shape = disk_points if lens_blades < 3 else (lambda points: polygon_points(points, lens_blades))
        lens = shape(_shifted(samples, tiles, settings.seed, 1)[..., :2].reshape(-1, 2)).reshape(tiles, samples, 2)
        lamps = tuple(
            _shifted(samples * count, tiles, settings.seed, 2 + number).reshape(tiles, samples, count, 3)
            for number, count in enumerate(lamp_points)
        )
        return cls(offsets, lens[:, order], tuple(lamp[:, order] for lamp in lamps))


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


def _shifted(count: int, tiles: int, seed: int, stream: int) -> NDArray[np.float64]:
    """Lattices (tiles, count, 3) in the unit cube, one shifted against the next by a lattice of shifts."""
    rng = np.random.default_rng((seed, stream))
    start = rng.random(3)
    index = np.arange(count)
    planar = square_points(count, 0) if count > 1 else np.zeros((1, 2))
    lattice = np.column_stack([planar, index * _THIRD])
    between = square_points(tiles, 0) if tiles > 1 else np.zeros((1, 2))
    # A tile's neighbours come far behind it in the lattice of shifts when both are shuffled.
    shifts = np.column_stack([between, np.arange(tiles) * _THIRD / max(count, 1)])[rng.permutation(tiles)]
    return np.asarray((start + lattice[None] + shifts[:, None]) % 1.0)
