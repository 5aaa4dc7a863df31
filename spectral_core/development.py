"""From tristimulus values to a picture for a display: exposure, adaptation to its white, gamut and transfer curve."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import ADAPTATIONS, chromatic_adaptation, observer, white_point
from .display import GAMUT_METHODS, Display, GamutMapping, display, fit_to_gamut
from .spectra import Spectrum
from .validation import require_choice, require_in_range

__all__ = ["Development"]


@dataclass(frozen=True, slots=True)
class Development:
    """How a render becomes a picture.

    Attributes
    ----------
    shown : Display
        What the picture is for.
    adopted_white : Spectrum
        Lamp under which a perfect diffuser is to look white.
    adaptation : str
        "none" (default: the paper's direct way from XYZ to the display), "bradford" or "cat16".
    exposure : float
        Stops by which the picture is brightened, -100 to 100.
    gamut : str
        "clip" or "compress", for colours that the display cannot show.
    """

    shown: Display = field(default_factory=lambda: display("srgb"))
    adopted_white: Spectrum = field(default_factory=lambda: Spectrum.constant(1.0, "E"))
    adaptation: str = "none"
    exposure: float = 0.0
    gamut: str = "clip"

    def __post_init__(self) -> None:
        require_choice("adaptation", self.adaptation, ADAPTATIONS)
        require_choice("gamut", self.gamut, GAMUT_METHODS)
        require_in_range("exposure", self.exposure, -100.0, 100.0, unit="stops")

    def adapted(self, tristimulus: NDArray[np.floating[Any]], observer_name: str) -> NDArray[np.float64]:
        """Bring tristimulus values to the display's white.

        Parameters
        ----------
        tristimulus : ndarray, shape (..., 3)
            X, Y, Z.
        observer_name : str
            Observer they were computed for.

        Returns
        -------
        ndarray of float64, shape (..., 3)
            With exposure and adaptation applied.

        Raises
        ------
        InvalidParameterError
            If the adopted white has no luminance.

        References
        ----------
        CIE 160:2004, chromatic adaptation.
        """
        white = white_point(self.adopted_white, observer(observer_name))
        matrix = chromatic_adaptation(white, self.shown.white, self.adaptation)
        scaled = 2.0**self.exposure * matrix.T
        return np.asarray(np.asarray(tristimulus, np.float64) @ scaled)

    def picture(
        self, tristimulus: NDArray[np.floating[Any]], observer_name: str
    ) -> tuple[NDArray[np.float64], GamutMapping]:
        """Make display values.

        Parameters
        ----------
        tristimulus : ndarray, shape (..., 3)
            X, Y, Z.
        observer_name : str
            Observer they were computed for.

        Returns
        -------
        encoded : ndarray of float64, shape (..., 3)
            What the display is driven with, 0 to 1.
        mapping : GamutMapping
            What happened to colours out of gamut.

        Raises
        ------
        InvalidParameterError
            If the adopted white has no luminance.

        References
        ----------
        Tominaga 1996, Applications: XYZ to monitor RGB by a matrix, then the transfer curve.
        """
        mapping = fit_to_gamut(self.shown.linear(self.adapted(tristimulus, observer_name)), self.shown, self.gamut)
        return self.shown.encode(mapping.linear_rgb), mapping
