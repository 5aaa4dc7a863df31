"""One pixel in full: which products of spectra reach it, and how much of each."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .colorimetry import observer, xy
from .errors import InvalidParameterError
from .renderer import Render
from .scene_spectra import SceneSpectra, Term

__all__ = ["PixelProbe", "probe_pixel"]


@dataclass(frozen=True, slots=True)
class PixelProbe:
    """The light of one pixel.

    Attributes
    ----------
    column, row : int
        The pixel; row 0 is the top.
    wavelengths_nm : ndarray, shape (W,)
        Wavelengths (nm).
    labels : tuple of str, length K
        What each part is a product of, such as "Key x red plastic body".
    radiance : ndarray, shape (K, W)
        Relative radiance per nm of each part.
    tristimulus : ndarray, shape (K, 3)
        X, Y, Z of each part at 1 nm.
    """

    column: int
    row: int
    wavelengths_nm: NDArray[np.float64]
    labels: tuple[str, ...]
    radiance: NDArray[np.float64]
    tristimulus: NDArray[np.float64]

    def describe(self) -> str:
        """Tell the parts and their share of the luminance in words.

        Returns
        -------
        str
            A line a part, the brightest first, and the total with its chromaticity.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        total = self.tristimulus.sum(axis=0)
        if not total[1] > 0.0:
            return f"pixel ({self.column}, {self.row}) is black"
        x, y = xy(total)
        lines = [f"pixel ({self.column}, {self.row}): Y {total[1]:.4f}, x {x:.4f}, y {y:.4f}"]
        for part in np.argsort(-self.tristimulus[:, 1], kind="stable"):
            share = self.tristimulus[part, 1] / total[1]
            lines.append(f"  {100.0 * share:5.1f} %  {self.labels[part]}")
        return "\n".join(lines)

    def csv(self) -> str:
        """Give the spectra as comma-separated values.

        Returns
        -------
        str
            A header, then a row a wavelength: nm, the pixel's spectrum, and each part's.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        table = io.StringIO()
        writer = csv.writer(table, lineterminator="\n")
        writer.writerow(["wavelength_nm", "total", *self.labels])
        total = self.radiance.sum(axis=0)
        for wavelength, whole, parts in zip(self.wavelengths_nm, total, self.radiance.T, strict=True):
            writer.writerow([f"{value:.9g}" for value in (wavelength, whole, *parts)])
        return table.getvalue()


def probe_pixel(
    render: Render,
    column: int,
    row: int,
    wavelengths_nm: ArrayLike | None = None,
    *,
    emitter_names: Sequence[str] | None = None,
) -> PixelProbe:
    """Take the light of one pixel apart.

    Parameters
    ----------
    render : Render
        A render that is kept by terms.
    column, row : int
        The pixel; row 0 is the top.
    wavelengths_nm : array_like, shape (W,), optional
        Where to sample (nm); 360 to 830 nm at 1 nm when left out.
    emitter_names : sequence of str, optional
        What to call the render's emitters, in their order; their own names when left out. Those that share a name are
        numbered.

    Returns
    -------
    PixelProbe
        The parts.

    Raises
    ------
    InvalidParameterError
        If the pixel lies outside the picture, the render keeps plain colour, or there are not as many names as
        emitters.

    References
    ----------
    Tominaga 1996, Eqs. 1 and 4.
    """
    sees = observer(render.observer)
    wavelengths = sees.wavelengths_nm if wavelengths_nm is None else np.asarray(wavelengths_nm, np.float64)
    terms, radiance = render.film.spectrum_at(column, row, render.spectra, wavelengths, sees)
    _, full = render.film.spectrum_at(column, row, render.spectra, sees.wavelengths_nm, sees)
    names = _distinct([e.name for e in render.spectra.emitters] if emitter_names is None else emitter_names)
    if len(names) != len(render.spectra.emitters):
        raise InvalidParameterError(
            f"emitter_names must hold a name for each of the {len(render.spectra.emitters)} emitters, "
            f"but holds {len(names)}"
        )
    labels = tuple(_label(term, names, render.spectra) for term in terms)
    return PixelProbe(column, row, wavelengths, labels, radiance, full @ sees.matching_functions)


def _distinct(names: Sequence[str]) -> list[str]:
    """Number the names that several emitters have."""
    count, seen = Counter(names), Counter[str]()
    told = []
    for name in names:
        seen[name] += 1
        told.append(name if count[name] == 1 else f"{name} ({seen[name]} of {count[name]})")
    return told


def _label(term: Term, names: Sequence[str], spectra: SceneSpectra) -> str:
    slots = [spectra.slots[slot] for slot in term.slots]
    return " x ".join([names[term.emitter], *(f"{s.material} {s.component}" for s in slots)])
