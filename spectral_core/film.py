"""The film: per pixel a short list of (term, coefficient), and no colour.

Pixels that see the same material share the same list of terms, so the film is a set of blocks, each with the terms as
columns and its pixels as rows. Anti-aliasing samples of a pixel are merged into one row a block: any filter and any
number of samples keep geometry and spectra apart. Colour is one small matrix product a block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import Observer, WavelengthGrid
from .errors import InvalidParameterError
from .scene_spectra import SceneSpectra, Term
from .validation import require_integer

__all__ = ["Film", "FilmBlock", "FilmBuilder", "add_rows"]

_ROWS_AT_ONCE = 1 << 15  # rows of a block that are turned into colour at once: the intermediates stay in the cache


def add_rows(
    image: NDArray[np.floating[Any]], index: NDArray[np.integer[Any]], rows: NDArray[np.floating[Any]]
) -> None:
    """Add rows to some rows of an array, in place.

    Parameters
    ----------
    image : ndarray, shape (P, C)
        Changed; its rows must lie one behind the other in memory.
    index : ndarray of int, shape (N,)
        Which rows; each at most once, since of two additions to one row only the last would stay.
    rows : ndarray, shape (N, C)
        What is added.

    Raises
    ------
    IndexError
        From numpy if a row is not there.

    References
    ----------
    Own design. The same as ``image[index] += rows``; rows are put back whole, as opaque records, which is three times
    faster than element by element.
    """
    total = image.take(index, axis=0)
    total += rows
    record = np.dtype((np.void, image.shape[1] * image.itemsize))
    image.view(record)[index, 0] = total.view(record)[:, 0]


@dataclass(frozen=True, slots=True)
class FilmBlock:
    """Pixels whose light is made of the same terms.

    Attributes
    ----------
    terms : tuple of Term, length K
        Columns.
    pixels : ndarray of int32, shape (P,)
        Flat pixel indices (row * width + column), increasing, each at most once.
    coefficients : ndarray of float32 or float64, shape (P, K)
        Geometric coefficients, averaged over the pixel's samples.
    """

    terms: tuple[Term, ...]
    pixels: NDArray[np.int32]
    coefficients: NDArray[np.floating[Any]]

    @property
    def nbytes(self) -> int:
        """Bytes that the arrays of the block hold."""
        return self.pixels.nbytes + self.coefficients.nbytes


@dataclass(frozen=True, slots=True)
class Film:
    """A finished render before any colour was computed.

    Attributes
    ----------
    width, height : int
        Size in pixels; row 0 is the top of the picture.
    blocks : tuple of FilmBlock
        The light, by lists of terms.
    coverage : ndarray of float32, shape (height, width)
        Part of each pixel's samples that met a surface, 0 to 1.
    fixed_tristimulus : ndarray, shape (height, width, 3), optional
        Colour that is not kept by terms, because the memory limit was reached or paths were carried at the nodes of a
        wavelength grid; such a film cannot be relit.
    """

    width: int
    height: int
    blocks: tuple[FilmBlock, ...]
    coverage: NDArray[np.float32]
    fixed_tristimulus: NDArray[np.float32] | None = None

    @property
    def nbytes(self) -> int:
        """Bytes that the film holds."""
        fixed = 0 if self.fixed_tristimulus is None else self.fixed_tristimulus.nbytes
        return sum(block.nbytes for block in self.blocks) + self.coverage.nbytes + fixed

    @property
    def terms(self) -> tuple[Term, ...]:
        """All terms that occur, sorted."""
        return tuple(sorted({term for block in self.blocks for term in block.terms}))

    @property
    def is_relightable(self) -> bool:
        """Whether all light is kept by terms."""
        return self.fixed_tristimulus is None

    def tristimulus(
        self,
        spectra: SceneSpectra,
        observer: Observer,
        grid: WavelengthGrid,
        *,
        dtype: type[np.floating[Any]] | None = None,
        own_spectra: bool = False,
    ) -> NDArray[np.floating[Any]]:
        """Colour of every pixel for the given spectra.

        Parameters
        ----------
        spectra : SceneSpectra
            The scene's spectra, or changed ones with the same slots.
        observer : Observer
            Colour-matching functions.
        grid : WavelengthGrid
            Where reflectances are sampled; "exact" is 360-830 nm at 1 nm.
        dtype : numpy dtype, optional
            float32 or float64; that of the coefficients when left out.
        own_spectra : bool
            Whether `spectra` are those that the film was rendered with, so that its fixed colour may be added.

        Returns
        -------
        ndarray, shape (height, width, 3)
            X, Y, Z; Y = 1 for a perfect diffuser under an irradiance of pi from a lamp of strength 1.

        Raises
        ------
        InvalidParameterError
            If the film was not kept by terms (see `fixed_tristimulus`), so that other spectra cannot be applied to it.

        References
        ----------
        Tominaga 1996, Eqs. 4, 7-10, and the linearity of XYZ.
        """
        if not self.is_relightable and not own_spectra:
            raise InvalidParameterError("this film was not kept by terms, so no spectra can be applied to it")
        terms = self.terms
        table = spectra.tristimulus_table(terms, observer, grid)
        image = self.weighted_sum(table, terms, dtype)
        if self.fixed_tristimulus is not None:
            image += self.fixed_tristimulus
        return image

    def weighted_sum(
        self, table: NDArray[np.float64], terms: Sequence[Term], dtype: type[np.floating[Any]] | None = None
    ) -> NDArray[np.floating[Any]]:
        """Sum coefficient times a row of a table, in every pixel; colour is such a sum, and so is a spectrum.

        Parameters
        ----------
        table : ndarray of float64, shape (K, C)
            What each term weighs.
        terms : sequence of Term, length K
            The film's terms.
        dtype : numpy dtype, optional
            float32 or float64; that of the coefficients when left out.

        Returns
        -------
        ndarray, shape (height, width, C)
            The sums.

        Raises
        ------
        KeyError
            If a term of the film is not among `terms`.

        References
        ----------
        Own design.
        """
        if dtype is None:
            dtype = np.float64 if any(b.coefficients.dtype == np.float64 for b in self.blocks) else np.float32
        index = {term: row for row, term in enumerate(terms)}
        image = np.zeros((self.height * self.width, table.shape[1]), dtype)
        for block in self.blocks:
            rows = np.ascontiguousarray(table[[index[term] for term in block.terms]], dtype=dtype)
            for start in range(0, len(block.pixels), _ROWS_AT_ONCE):
                part = slice(start, start + _ROWS_AT_ONCE)
                values = block.coefficients[part].astype(dtype, copy=False)
                add_rows(image, block.pixels[part], np.matmul(values, rows))
        return image.reshape(self.height, self.width, table.shape[1])

    def spectrum_at(
        self, column: int, row: int, spectra: SceneSpectra, wavelengths_nm: NDArray[np.float64], observer: Observer
    ) -> tuple[tuple[Term, ...], NDArray[np.float64]]:
        """Radiance spectrum of one pixel, split by term.

        Parameters
        ----------
        column, row : int
            The pixel; row 0 is the top.
        spectra : SceneSpectra
            The scene's spectra.
        wavelengths_nm : ndarray, shape (W,)
            Where to sample (nm).
        observer : Observer
            Whose luminance brings the illuminants to Y = 1.

        Returns
        -------
        terms : tuple of Term, length K
            The terms that reach the pixel.
        radiance : ndarray of float64, shape (K, W)
            Their spectra; the sum over the first axis is the pixel's spectrum.

        Raises
        ------
        InvalidParameterError
            If the pixel lies outside the image or the film's colour is fixed.

        References
        ----------
        Tominaga 1996, Eq. 1.
        """
        require_integer("column", column, 0, self.width - 1)
        require_integer("row", row, 0, self.height - 1)
        if not self.is_relightable:
            raise InvalidParameterError("this film was not kept by terms, so a pixel has no spectrum")
        pixel = row * self.width + column
        totals: dict[Term, float] = {}
        for block in self.blocks:
            at = int(np.searchsorted(block.pixels, pixel))
            if at < len(block.pixels) and block.pixels[at] == pixel:
                for term, coefficient in zip(block.terms, block.coefficients[at], strict=True):
                    totals[term] = totals.get(term, 0.0) + float(coefficient)
        terms = tuple(sorted(term for term, value in totals.items() if value != 0.0))
        table = spectra.radiance_table(terms, np.asarray(wavelengths_nm, np.float64), observer)
        return terms, table * np.array([totals[term] for term in terms])[:, None]


@dataclass(slots=True)
class _Pending:
    """Deposits of one list of terms in the band that is being worked on."""

    pixels: list[NDArray[np.int64]] = field(default_factory=list)
    coefficients: list[NDArray[np.floating[Any]]] = field(default_factory=list)


class FilmBuilder:
    """Collects deposits band by band and merges the samples of each pixel.

    Parameters
    ----------
    width, height : int
        Size in pixels.
    samples : int
        Samples a pixel; every deposit counts 1 / samples.
    dtype : numpy dtype
        float32 or float64, of the coefficients.
    spectra, observer, grid
        Used only when the memory limit is reached, to turn the film into plain colour.
    memory_limit : int, optional
        Bytes that the blocks may hold; None for no limit.
    """

    def __init__(
        self,
        width: int,
        height: int,
        samples: int,
        dtype: type[np.floating[Any]],
        spectra: SceneSpectra,
        observer: Observer,
        grid: WavelengthGrid,
        memory_limit: int | None = None,
    ) -> None:
        self._width = width
        self._height = height
        self._samples = samples
        self._dtype = dtype
        self._spectra = spectra
        self._observer = observer
        self._grid = grid
        self._limit = memory_limit
        self._pending: dict[tuple[Term, ...], _Pending] = {}
        self._merged: dict[tuple[Term, ...], _Pending] = {}
        self._bytes = 0
        self._hits = np.zeros(width * height, np.float32)
        self._pending_colour = _Pending()
        self._fixed: NDArray[np.float32] | None = None
        self._is_full = False

    def deposit(
        self, terms: tuple[Term, ...], pixels: NDArray[np.int64], coefficients: NDArray[np.floating[Any]]
    ) -> None:
        """Add the light of some samples of the current band.

        Parameters
        ----------
        terms : tuple of Term, length K
            What the columns stand for.
        pixels : ndarray of int, shape (N,)
            Flat pixel index of each sample; a pixel may stand in it many times.
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
            row, column = divmod(int(pixels[at]), self._width)
            raise InvalidParameterError(f"a geometric coefficient of pixel ({column}, {row}) is not finite")
        pending = self._pending.setdefault(terms, _Pending())
        pending.pixels.append(pixels)
        pending.coefficients.append(coefficients)

    def deposit_colour(self, pixels: NDArray[np.int64], tristimulus: NDArray[np.floating[Any]]) -> None:
        """Add light of the current band whose terms are not kept.

        Parameters
        ----------
        pixels : ndarray of int, shape (N,)
            Flat pixel index of each sample; a pixel may stand in it many times.
        tristimulus : ndarray, shape (N, 3)
            X, Y, Z, not yet divided by the number of samples.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        if len(pixels):
            self._pending_colour.pixels.append(pixels)
            self._pending_colour.coefficients.append(tristimulus)

    def count_hits(self, pixels: NDArray[np.int64]) -> None:
        """Note which pixels' samples met a surface.

        Parameters
        ----------
        pixels : ndarray of int, shape (N,)
            Flat pixel index of each such sample, each pixel at most once a call.

        Raises
        ------
        IndexError
            From numpy if a pixel lies outside the image.

        References
        ----------
        Own design.
        """
        self._hits[pixels] += 1.0

    def end_band(self, first_row: int, end_row: int) -> Film:
        """Merge the deposits of the band.

        Parameters
        ----------
        first_row, end_row : int
            The band's first row and the one after its last.

        Returns
        -------
        Film
            Of these rows alone, for showing them.

        Raises
        ------
        IndexError
            If a deposit lies outside the band.

        References
        ----------
        Own design.
        """
        first = first_row * self._width
        blocks = []
        for terms, pending in self._pending.items():
            block = self._merge(terms, pending, first, end_row * self._width)
            blocks.append(FilmBlock(terms, block.pixels - np.int32(first), block.coefficients))
            if self._is_full:
                self._add_fixed(block)
                continue
            kept = self._merged.setdefault(terms, _Pending())
            kept.pixels.append(block.pixels)  # type: ignore[arg-type]
            kept.coefficients.append(block.coefficients)
            self._bytes += block.nbytes
        self._pending.clear()
        fixed = self._merge_colour(first, end_row * self._width)
        if self._limit is not None and not self._is_full and self._bytes > self._limit:
            self._fall_back()
        return Film(self._width, end_row - first_row, tuple(blocks), self.coverage(first_row, end_row), fixed)

    def _merge_colour(self, first: int, end: int) -> NDArray[np.float32] | None:
        pending, self._pending_colour = self._pending_colour, _Pending()
        if not pending.pixels:
            return None
        local = np.concatenate(pending.pixels) - first
        values = np.concatenate(pending.coefficients)
        merged = np.stack([np.bincount(local, values[:, c], end - first) for c in range(3)], axis=1) / self._samples
        colour = merged.astype(np.float32)
        self._fixed_image()[first:end] += colour
        return colour.reshape(-1, self._width, 3)

    def _fixed_image(self) -> NDArray[np.float32]:
        if self._fixed is None:
            self._fixed = np.zeros((self._width * self._height, 3), np.float32)
        return self._fixed

    def finish(self) -> Film:
        """Make the film of all bands.

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
            FilmBlock(terms, _joined(kept.pixels).astype(np.int32, copy=False), _joined(kept.coefficients))
            for terms, kept in sorted(self._merged.items(), key=lambda item: item[0])
        )
        coverage = self.coverage(0, self._height)
        fixed = None if self._fixed is None else self._fixed.reshape(self._height, self._width, 3)
        return Film(self._width, self._height, blocks, coverage, fixed)

    def coverage(self, first_row: int, end_row: int) -> NDArray[np.float32]:
        """Part of the samples that met a surface, in finished rows.

        Parameters
        ----------
        first_row, end_row : int
            The rows.

        Returns
        -------
        ndarray of float32, shape (rows, width)
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        part = self._hits[first_row * self._width : end_row * self._width]
        return (part / np.float32(self._samples)).reshape(-1, self._width)

    def _merge(self, terms: tuple[Term, ...], pending: _Pending, first: int, end: int) -> FilmBlock:
        """Mean over the samples of each pixel, added in float64 in the order of the deposits, whatever the band."""
        if self._samples == 1 and len(pending.pixels) == 1 and _is_increasing(pending.pixels[0]):
            values = pending.coefficients[0].astype(self._dtype, copy=False)
            return FilmBlock(terms, pending.pixels[0].astype(np.int32), values)
        is_lit = np.zeros(end - first, bool)
        for pixels in pending.pixels:
            is_lit[pixels - first] = True
        present = np.flatnonzero(is_lit)
        row_of = np.zeros(end - first, np.int64)
        row_of[present] = np.arange(len(present))
        total = np.zeros((len(present), len(terms)))
        for pixels, values in zip(pending.pixels, pending.coefficients, strict=True):
            rows = row_of[pixels - first]
            if _is_increasing(pixels) or len(np.unique(rows)) == len(rows):
                add_rows(total, rows, values)
            else:
                np.add.at(total, rows, values)
        total /= self._samples
        return FilmBlock(terms, (present + first).astype(np.int32), total.astype(self._dtype, copy=False))

    def _add_fixed(self, block: FilmBlock) -> None:
        table = self._spectra.tristimulus_table(block.terms, self._observer, self._grid)
        add_rows(self._fixed_image(), block.pixels, block.coefficients @ table.astype(self._dtype))

    def _fall_back(self) -> None:
        """Turn what was collected into plain colour, and go on with plain colour."""
        self._is_full = True
        for terms, kept in self._merged.items():
            for pixels, coefficients in zip(kept.pixels, kept.coefficients, strict=True):
                self._add_fixed(FilmBlock(terms, pixels.astype(np.int32), coefficients))
        self._merged.clear()
        self._bytes = 0


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
