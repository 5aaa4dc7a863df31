"""Lamp studies of a finished render: what changes when the lamps do, without tracing a ray."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .colorimetry import delta_e_2000, lab
from .development import Development
from .errors import InvalidParameterError
from .renderer import Render
from .spectra import Spectrum
from .validation import require_in_range, require_integer

__all__ = ["ContactSheet", "MetamerismMap", "contact_sheet", "metamerism_map", "relit_by"]


def relit_by(render: Render, lamp: Spectrum, lights: Sequence[str] | None = None) -> Render:
    """Exchange the spectrum of lights; their strengths, as luminance, stay.

    Parameters
    ----------
    render : Render
        A render that can be relit.
    lamp : Spectrum
        The new relative spectral power distribution.
    lights : sequence of str, optional
        Names of the lights to change; all, the world included, when left out.

    Returns
    -------
    Render
        Shares the film.

    Raises
    ------
    InvalidParameterError
        If the render cannot be relit, or a light is not there.

    References
    ----------
    Own design.
    """
    spectra = render.spectra
    names = dict.fromkeys(emitter.name for emitter in spectra.emitters) if lights is None else lights
    for name in names:
        spectra = spectra.with_light(name, illuminant=lamp)
    return render.relit(spectra)


@dataclass(frozen=True, slots=True)
class MetamerismMap:
    """How far each pixel's colour moves between two lamps.

    Attributes
    ----------
    delta_e : ndarray of float64, shape (height, width)
        CIE Delta E 2000 between the two lamps, each adapted to the display's white.
    first, second : str
        Names of the lamps.
    covered : ndarray of bool, shape (height, width)
        Where the picture shows a surface in at least half of the samples; the statistics count these pixels.
    """

    delta_e: NDArray[np.float64]
    first: str
    second: str
    covered: NDArray[np.bool_]

    def describe(self) -> str:
        """Give mean, 95th percentile and maximum over the covered pixels in words.

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
        values = self.delta_e[self.covered]
        if not values.size:
            return f"Delta E 2000 between {self.first} and {self.second}: the picture shows no surface"
        return (
            f"Delta E 2000 between {self.first} and {self.second}: mean {values.mean():.2f}, "
            f"95 % below {np.percentile(values, 95.0):.2f}, largest {values.max():.2f}"
        )

    def picture(self, largest: float = 10.0) -> NDArray[np.float64]:
        """Draw the map in display values, from black through blue, magenta and orange to white.

        Parameters
        ----------
        largest : float
            Delta E that is drawn white, above 0.

        Returns
        -------
        ndarray of float64, shape (height, width, 3)
            Encoded sRGB, 0 to 1; lightness rises with Delta E.

        Raises
        ------
        InvalidParameterError
            If `largest` is not above 0.

        References
        ----------
        Own design; anchors chosen so that CIE lightness rises evenly.
        """
        require_in_range("largest", largest, 1e-9)
        anchors = np.array(
            [
                (0.0, 0.0, 0.0),
                (0.09, 0.10, 0.42),
                (0.45, 0.13, 0.56),
                (0.82, 0.25, 0.44),
                (0.98, 0.55, 0.26),
                (0.99, 0.84, 0.45),
                (1.0, 1.0, 1.0),
            ]
        )
        position = np.clip(self.delta_e / largest, 0.0, 1.0)
        steps = np.linspace(0.0, 1.0, len(anchors))
        return np.stack([np.interp(position, steps, anchors[:, c]) for c in range(3)], axis=-1)


def metamerism_map(
    render: Render,
    first: Spectrum,
    second: Spectrum,
    development: Development | None = None,
    lights: Sequence[str] | None = None,
) -> MetamerismMap:
    """Colour difference of every pixel between two lamps, after adaptation to each.

    Parameters
    ----------
    render : Render
        A render that can be relit.
    first, second : Spectrum
        The lamps.
    development : Development, optional
        Its display's white, exposure and adaptation are used ("bradford" where it says "none": a comparison across
        lamps without adaptation would measure the lamps).
    lights : sequence of str, optional
        Lights to change; all when left out.

    Returns
    -------
    MetamerismMap
        Delta E 2000 per pixel.

    Raises
    ------
    InvalidParameterError
        If the render cannot be relit.

    References
    ----------
    CIE 15:2018, 9.2 (change of colour with illuminant); CIE 142-2001 (CIEDE2000).
    """
    development = development or Development()
    method = "bradford" if development.adaptation == "none" else development.adaptation
    white = development.shown.white
    images = []
    for lamp in (first, second):
        seen = replace(development, adopted_white=lamp, adaptation=method)
        relit = relit_by(render, lamp, lights)
        # Rounding of float32 coefficients can leave -1e-9 where nothing is seen; Lab is defined from 0 on.
        xyz = np.maximum(seen.adapted(relit.tristimulus(), render.observer), 0.0)
        images.append(lab(xyz, white))
    difference = delta_e_2000(images[0], images[1])
    return MetamerismMap(difference, first.name or "lamp 1", second.name or "lamp 2", render.alpha >= 0.5)


@dataclass(frozen=True, slots=True)
class ContactSheet:
    """One render under several lamps, side by side.

    Attributes
    ----------
    picture : ndarray of float64, shape (H, W, 3)
        Encoded display values.
    names : tuple of str
        The lamps, row by row.
    columns : int
        Pictures in a row.
    """

    picture: NDArray[np.float64]
    names: tuple[str, ...]
    columns: int


def contact_sheet(
    render: Render,
    lamps: Sequence[Spectrum],
    development: Development | None = None,
    *,
    columns: int | None = None,
    adapt: bool = False,
    gap: int = 8,
    lights: Sequence[str] | None = None,
) -> ContactSheet:
    """Develop one render under a list of lamps.

    Parameters
    ----------
    render : Render
        A render that can be relit.
    lamps : sequence of Spectrum
        At least one.
    development : Development, optional
        How the pictures are made.
    columns : int, optional
        Pictures in a row; about as many as rows when left out.
    adapt : bool
        True: each picture is adapted to its own lamp, as an eye that has lived in it sees it. False: all as
        `development` says, so that the lamps' own colours show.
    gap : int
        Pixels between the pictures.
    lights : sequence of str, optional
        Lights to change; all when left out.

    Returns
    -------
    ContactSheet
        The sheet.

    Raises
    ------
    InvalidParameterError
        If there is no lamp or the render cannot be relit.

    References
    ----------
    Own design.
    """
    if not lamps:
        raise InvalidParameterError("a contact sheet needs at least one lamp")
    require_integer("gap", gap, 0)
    development = development or Development()
    columns = int(np.ceil(np.sqrt(len(lamps)))) if columns is None else require_integer("columns", columns, 1)
    columns = min(columns, len(lamps))
    rows = -(-len(lamps) // columns)
    height, width = render.film.height, render.film.width
    sheet = np.zeros((rows * height + (rows - 1) * gap, columns * width + (columns - 1) * gap, 3))
    for number, lamp in enumerate(lamps):
        row, column = divmod(number, columns)
        made = development
        if adapt:
            method = "bradford" if development.adaptation == "none" else development.adaptation
            made = replace(development, adopted_white=lamp, adaptation=method)
        picture, _ = made.picture(relit_by(render, lamp, lights).tristimulus(), render.observer)
        top, left = row * (height + gap), column * (width + gap)
        sheet[top : top + height, left : left + width] = picture
    return ContactSheet(sheet, tuple(lamp.name or f"lamp {i + 1}" for i, lamp in enumerate(lamps)), columns)
