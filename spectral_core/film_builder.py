"""How a film is made: deposits of samples become parts, parts become the film.

A part is what one sub-picture found, in one go: its samples are merged pixel by pixel, always in the same order, so
that a film does not depend on how the picture was cut up or on who worked on which part.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import Observer, WavelengthGrid
from .errors import InvalidParameterError
from .film import Film, FilmBlock, add_rows
from .light_components import component_of
from .scene_spectra import SceneSpectra, Term

__all__ = ["Deposits", "FilmBuilder", "FilmPart", "joined_parts"]

Terms = tuple[Term, ...]
_MOST_PENDING = 1 << 26  # bytes of deposits that wait to be added up; with many samples there would be no end to them

Label = tuple[str, int] | None  # component and emitter of light that is told apart without its terms


@dataclass(frozen=True, slots=True, eq=False)
class FilmPart:
    """What the samples of some pixels found.

    Attributes
    ----------
    pixels : ndarray of int64, shape (N,)
        Flat indices of the pixels, increasing.
    samples : int
        Samples that each of them took.
    blocks : tuple of FilmBlock
        The light, by lists of terms; the mean over the samples. Pixels are those of the whole picture.
    hits : ndarray of float32, shape (N,)
        Samples that met a surface.
    fixed : dict of Label to ndarray of float64, shape (N, 3)
        Mean colour of the light that is not kept by terms.
    planes : dict of str to ndarray of float32, shape (N,)
        What else was counted, added up over the samples.
    """

    pixels: NDArray[np.int64]
    samples: int
    blocks: tuple[FilmBlock, ...]
    hits: NDArray[np.float32]
    fixed: dict[Label, NDArray[np.float64]]
    planes: dict[str, NDArray[np.float32]] = field(default_factory=dict)

    def tristimulus(self, spectra: SceneSpectra, observer: Observer, grid: WavelengthGrid) -> NDArray[np.floating[Any]]:
        """Colour of the part's pixels.

        Parameters
        ----------
        spectra, observer, grid
            As for :meth:`Film.tristimulus`.

        Returns
        -------
        ndarray, shape (N, 3)
            X, Y, Z.

        Raises
        ------
        InvalidParameterError
            If an illuminant has no luminance for the observer.

        References
        ----------
        As :meth:`Film.tristimulus`.
        """
        return self.as_row().tristimulus(spectra, observer, grid, own_spectra=True)[0]

    def as_row(self) -> Film:
        """Give the part as a film of its own, one row high.

        Returns
        -------
        Film
            Its pixels are numbered from 0, in their order.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        blocks = tuple(
            FilmBlock(block.terms, np.searchsorted(self.pixels, block.pixels).astype(np.int32), block.coefficients)
            for block in self.blocks
        )
        fixed = sum(self.fixed.values())[None].astype(np.float32) if self.fixed else None  # type: ignore[index]
        return Film(len(self.pixels), 1, blocks, self.coverage[None], fixed)

    @property
    def coverage(self) -> NDArray[np.float32]:
        """Share of the samples that met a surface, (N,)."""
        return self.hits / np.float32(self.samples)


@dataclass(slots=True)
class _Pending:
    """Deposits of one list of terms, or of one label: the sum of earlier ones, and those that wait."""

    pixels: list[NDArray[np.int64]] = field(default_factory=list)
    coefficients: list[NDArray[np.floating[Any]]] = field(default_factory=list)
    present: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    total: NDArray[np.float64] | None = None

    def add_up(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Pixels (n,) of `count` that have light, and its sum (n, K), in float64 in the order of the deposits.

        The order is that of the deposits however often it is asked for, so that sums are the same to the last bit.
        """
        if not self.pixels and self.total is not None:
            return self.present, self.total
        is_lit = np.zeros(count, bool)
        is_lit[self.present] = True
        for pixels in self.pixels:
            is_lit[pixels] = True
        present = np.flatnonzero(is_lit)
        row_of = np.zeros(count, np.int64)
        row_of[present] = np.arange(len(present))
        total = np.zeros((len(present), self.coefficients[0].shape[1]))
        if self.total is not None:
            total[row_of[self.present]] = self.total
        for pixels, values in zip(self.pixels, self.coefficients, strict=True):
            rows = row_of[pixels]
            if _is_increasing(pixels) or len(np.unique(rows)) == len(rows):
                add_rows(total, rows, values)
            else:
                np.add.at(total, rows, values)
        self.pixels.clear()
        self.coefficients.clear()
        self.present, self.total = present, total
        return present, total


class Deposits:
    """Collects what the samples of a sub-picture find, and merges them.

    Parameters
    ----------
    pixels : ndarray of int64, shape (N,)
        Flat indices of its pixels in the picture, increasing. Deposits name pixels by their place among these.
    full_width : int
        Width of the picture, for messages.
    dtype : numpy dtype
        float32 or float64, of the merged coefficients.
    """

    def __init__(self, pixels: NDArray[np.int64], full_width: int, dtype: np.dtype[Any]) -> None:
        self._pixels = pixels
        self._full_width = full_width
        self._dtype = dtype
        self._pending: dict[Terms, _Pending] = {}
        self._colour: dict[Label, _Pending] = {}
        self._waiting = 0  # bytes
        self._hits = np.zeros(len(pixels), np.float32)
        self._planes: dict[str, NDArray[np.float32]] = {}

    def deposit(self, terms: Terms, pixels: NDArray[np.int64], coefficients: NDArray[np.floating[Any]]) -> None:
        """Add the light of some samples.

        Parameters
        ----------
        terms : tuple of Term, length K
            What the columns stand for.
        pixels : ndarray of int, shape (N,)
            Which of the sub-picture's pixels each sample belongs to; a pixel may stand in it many times.
        coefficients : ndarray, shape (N, K)
            Geometric coefficients, not yet divided by the number of samples; kept, so not to be changed afterwards.

        Raises
        ------
        InvalidParameterError
            If a coefficient is not finite: a non-finite value would spoil the pixel for every lamp.

        References
        ----------
        Own design.
        """
        if not len(pixels):
            return
        if not _is_finite(coefficients):
            at = int(np.argwhere(~np.isfinite(coefficients))[0][0])
            row, column = divmod(int(self._pixels[pixels[at]]), self._full_width)
            raise InvalidParameterError(f"a geometric coefficient of pixel ({column}, {row}) is not finite")
        self._keep(self._pending.setdefault(terms, _Pending()), pixels, coefficients)

    def deposit_colour(
        self, pixels: NDArray[np.int64], tristimulus: NDArray[np.floating[Any]], label: Label = None
    ) -> None:
        """Add light whose terms are not kept.

        Parameters
        ----------
        pixels : ndarray of int, shape (N,)
            Which of the sub-picture's pixels each sample belongs to; a pixel may stand in it many times.
        tristimulus : ndarray, shape (N, 3)
            X, Y, Z, not yet divided by the number of samples.
        label : tuple of (str, int), optional
            Component and emitter that it is to be told apart by.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        if len(pixels):
            self._keep(self._colour.setdefault(label, _Pending()), pixels, tristimulus)

    def _keep(self, pending: _Pending, pixels: NDArray[np.int64], values: NDArray[np.floating[Any]]) -> None:
        pending.pixels.append(pixels)
        pending.coefficients.append(values)
        self._waiting += pixels.nbytes + values.nbytes
        if self._waiting > _MOST_PENDING:
            for some in (*self._pending.values(), *self._colour.values()):
                some.add_up(len(self._pixels))
            self._waiting = 0

    def count_hits(self, pixels: NDArray[np.int64], share: NDArray[np.floating[Any]] | float = 1.0) -> None:
        """Note which pixels' samples met a surface.

        Parameters
        ----------
        pixels : ndarray of int, shape (N,)
            Which of the sub-picture's pixels, each at most once a call.
        share : ndarray, shape (N,), or float
            How much of the background each of them hides.

        Raises
        ------
        IndexError
            From numpy if a pixel is not there.

        References
        ----------
        Own design.
        """
        self._hits[pixels] += np.asarray(share, np.float32)

    def count(self, plane: str, pixels: NDArray[np.int64], values: NDArray[np.floating[Any]] | float = 1.0) -> None:
        """Add to what is averaged besides light.

        Parameters
        ----------
        plane : str
            One of ``Film.planes``.
        pixels : ndarray of int, shape (N,)
            Which of the sub-picture's pixels, each at most once a call.
        values : ndarray, shape (N,), or float
            What their samples met.

        Raises
        ------
        IndexError
            If a pixel is not there.

        References
        ----------
        Own design.
        """
        array = self._planes.setdefault(plane, np.zeros(len(self._pixels), np.float32))
        array[pixels] += np.asarray(values, np.float32)

    def merge(self, samples: int) -> FilmPart:
        """Take the mean over the samples of each pixel.

        Parameters
        ----------
        samples : int
            How many each pixel took.

        Returns
        -------
        FilmPart
            All that was deposited.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        blocks = tuple(self._merged(terms, pending, samples) for terms, pending in self._pending.items())
        fixed: dict[Label, NDArray[np.float64]] = {}
        for label, pending in self._colour.items():
            present, total = pending.add_up(len(self._pixels))
            fixed[label] = np.zeros((len(self._pixels), 3))
            fixed[label][present] = total / samples
        return FilmPart(self._pixels, samples, blocks, self._hits, fixed, self._planes)

    def _merged(self, terms: Terms, pending: _Pending, samples: int) -> FilmBlock:
        """Mean over the samples of each pixel, added in float64 in the order of the deposits."""
        is_alone = pending.total is None and len(pending.pixels) == 1
        if samples == 1 and is_alone and _is_increasing(pending.pixels[0]):
            values = pending.coefficients[0].astype(self._dtype, copy=False)
            return FilmBlock(terms, np.take(self._pixels, pending.pixels[0]).astype(np.int32), values)
        present, total = pending.add_up(len(self._pixels))
        values = (total / samples).astype(self._dtype, copy=False)
        return FilmBlock(terms, np.take(self._pixels, present).astype(np.int32), values)


class FilmBuilder:
    """Puts the parts of a picture together.

    Parameters
    ----------
    width, height : int
        Size in pixels.
    spectra, observer, grid
        Used only when the memory limit is reached, to turn the film into plain colour.
    memory_limit : int, optional
        Bytes that the blocks may hold; None for no limit.
    is_split : bool, optional
        Whether light that is not kept by terms is kept apart by component and emitter.
    """

    def __init__(
        self,
        width: int,
        height: int,
        spectra: SceneSpectra,
        observer: Observer,
        grid: WavelengthGrid,
        memory_limit: int | None = None,
        is_split: bool = False,
    ) -> None:
        self._width = width
        self._height = height
        self._spectra = spectra
        self._observer = observer
        self._grid = grid
        self._limit = memory_limit
        self._is_split = is_split
        # Weights are samples: where pixels took different numbers, means of parts are weighed by them.
        self._kept: dict[Terms, list[tuple[int, FilmBlock]]] = {}
        self._bytes = 0
        self._samples = np.zeros(width * height, np.int32)
        self._hits = np.zeros(width * height, np.float32)
        self._planes: dict[str, NDArray[np.float32]] = {}
        self._fixed: dict[tuple[int, Label], NDArray[np.float32]] = {}
        self._is_full = False

    def add(self, part: FilmPart) -> None:
        """Take a part in. Parts that share pixels are further samples of these.

        Parameters
        ----------
        part : FilmPart
            The part; always in the same order for equal films.

        Raises
        ------
        IndexError
            If a pixel lies outside the picture.

        References
        ----------
        Own design.
        """
        self._samples[part.pixels] += part.samples
        self._hits[part.pixels] += part.hits
        for name, values in part.planes.items():
            self._planes.setdefault(name, np.zeros_like(self._hits))[part.pixels] += values
        for label, colour in part.fixed.items():
            self._fixed_image(part.samples, label)[part.pixels] += colour.astype(np.float32)
        for block in part.blocks:
            if self._is_full:
                self._add_fixed(part.samples, block)
                continue
            self._kept.setdefault(block.terms, []).append((part.samples, block))
            self._bytes += block.nbytes
        if self._limit is not None and not self._is_full and self._bytes > self._limit:
            self._fall_back()

    def finish(self) -> Film:
        """Make the film of all parts.

        Returns
        -------
        Film
            The film.

        Raises
        ------
        MemoryError
            From numpy when the blocks cannot be joined.

        References
        ----------
        Own design.
        """
        blocks = tuple(
            self._joined(terms, kept) for terms, kept in sorted(self._kept.items(), key=lambda item: item[0])
        )
        shape = (self._height, self._width)
        taken = np.maximum(self._samples, 1).astype(np.float32)
        coverage = (self._hits / taken).reshape(shape)
        planes = {name: (values / taken).reshape(shape) for name, values in self._planes.items()}
        fixed = None
        parts: dict[tuple[str, int], NDArray[np.float32]] = {}
        for (samples, label), image in self._fixed.items():
            weighed = image * self._share(samples, slice(None))[:, None]
            fixed = weighed if fixed is None else fixed + weighed
            if label is not None:
                weighed = weighed.reshape(*shape, 3)
                parts[label] = parts[label] + weighed if label in parts else weighed
        colour = None if fixed is None else fixed.reshape(*shape, 3)
        return Film(self._width, self._height, blocks, coverage, colour, planes, parts)

    def _share(self, samples: int, pixels: NDArray[np.int32] | slice) -> NDArray[np.float32]:
        """Weight of a mean over so many samples in that over all samples of a pixel."""
        return np.float32(samples) / np.maximum(self._samples[pixels], 1).astype(np.float32)

    def _joined(self, terms: Terms, kept: list[tuple[int, FilmBlock]]) -> FilmBlock:
        return _joined_blocks(terms, [_weighed(block, self._share(samples, block.pixels)) for samples, block in kept])

    def _fixed_image(self, samples: int, label: Label) -> NDArray[np.float32]:
        key = samples, label
        if key not in self._fixed:
            self._fixed[key] = np.zeros((self._width * self._height, 3), np.float32)
        return self._fixed[key]

    def _add_fixed(self, samples: int, block: FilmBlock) -> None:
        table = self._spectra.tristimulus_table(block.terms, self._observer, self._grid)
        table = table.astype(block.coefficients.dtype)
        columns: dict[Label, list[int]] = {}
        for column, term in enumerate(block.terms):
            label = (component_of(term, self._spectra), term.emitter) if self._is_split else None
            columns.setdefault(label, []).append(column)
        for label, some in columns.items():
            add_rows(self._fixed_image(samples, label), block.pixels, block.coefficients[:, some] @ table[some])

    def _fall_back(self) -> None:
        """Turn what was collected into plain colour, and go on with plain colour."""
        self._is_full = True
        for kept in self._kept.values():
            for samples, block in kept:
                self._add_fixed(samples, block)
        self._kept.clear()
        self._bytes = 0


def joined_parts(parts: list[FilmPart]) -> FilmPart:
    """Make one part of several with the same pixels.

    Parameters
    ----------
    parts : list of FilmPart
        Further and further samples of the pixels, at least one.

    Returns
    -------
    FilmPart
        The mean over all samples.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    if len(parts) == 1:
        return parts[0]
    samples = sum(part.samples for part in parts)
    kept: dict[Terms, list[FilmBlock]] = {}
    fixed: dict[Label, NDArray[np.float64]] = {}
    for part in parts:
        share = np.float32(part.samples / samples)
        for block in part.blocks:
            kept.setdefault(block.terms, []).append(_weighed(block, np.full(len(block.pixels), share)))
        for label, colour in part.fixed.items():
            weighed = colour * share
            fixed[label] = fixed[label] + weighed if label in fixed else weighed
    blocks = tuple(_joined_blocks(terms, alike) for terms, alike in kept.items())
    hits = np.sum([part.hits for part in parts], axis=0, dtype=np.float32)
    planes: dict[str, NDArray[np.float32]] = {}
    for part in parts:
        for name, values in part.planes.items():
            planes[name] = planes[name] + values if name in planes else values
    return FilmPart(parts[0].pixels, samples, blocks, hits, fixed, planes)


def _weighed(block: FilmBlock, share: NDArray[np.float32]) -> FilmBlock:
    if (share == 1.0).all():
        return block
    weight = share[:, None].astype(block.coefficients.dtype)
    return FilmBlock(block.terms, block.pixels, block.coefficients * weight)


def _joined_blocks(terms: Terms, blocks: list[FilmBlock]) -> FilmBlock:
    """One block of several; rows of the same pixel are added."""
    pixels = _joined([block.pixels for block in blocks])
    values = _joined([block.coefficients for block in blocks])
    if _is_increasing(pixels):
        return FilmBlock(terms, pixels, values)
    order = np.argsort(pixels, kind="stable")
    pixels, values = np.take(pixels, order), np.take(values, order, axis=0)
    start = np.flatnonzero(np.diff(pixels, prepend=-1))
    if len(start) < len(pixels):
        pixels, values = pixels[start], np.add.reduceat(values, start, axis=0)
    return FilmBlock(terms, pixels, values)


def _is_finite(values: NDArray[np.floating[Any]]) -> bool:
    """Whether all values are; their sum tells, unless it overflows by itself."""
    with np.errstate(invalid="ignore", over="ignore"):
        if np.isfinite(values.sum()):
            return True
    return bool(np.isfinite(values).all())


def _is_increasing(values: NDArray[np.integer[Any]]) -> bool:
    return bool((values[1:] > values[:-1]).all())


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """Concatenate; one part is not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
