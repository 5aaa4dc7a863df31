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

__all__ = ["Film", "FilmBlock", "add_rows"]

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
    fixed_parts : dict of (str, int) to ndarray, shape (height, width, 3)
        The same colour by component and emitter, where that was asked for.
    planes : dict of str to ndarray of float32, shape (height, width)
        What else was averaged over the samples of each pixel: "held", the part of them that met a holdout; "occluded",
        the share of the lamps' light that shadows take from what they met.
    """

    width: int
    height: int
    blocks: tuple[FilmBlock, ...]
    coverage: NDArray[np.float32]
    fixed_tristimulus: NDArray[np.float32] | None = None
    planes: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    fixed_parts: dict[tuple[str, int], NDArray[np.float32]] = field(default_factory=dict)

    @property
    def nbytes(self) -> int:
        """Bytes that the film holds."""
        images = [self.coverage, *self.planes.values(), *self.fixed_parts.values()]
        if self.fixed_tristimulus is not None:
            images.append(self.fixed_tristimulus)
        return sum(block.nbytes for block in self.blocks) + sum(image.nbytes for image in images)

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
