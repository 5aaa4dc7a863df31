"""Reflectances made by formula, for materials of which no free measurement is at hand.

Each is a smooth curve with the typical shape of its kind (a dye's absorption band, a pigment's edge, the slow rise of
undyed fibre), and every one is labelled synthetic. They are presets to start from, not data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .spectra import REFERENCE_WAVELENGTHS_NM, Spectrum

__all__ = ["SYNTHETIC_REFLECTANCES", "SyntheticReflectance"]


@dataclass(frozen=True, slots=True)
class SyntheticReflectance:
    """A floor plus edges and bands: ``floor + sum of height * logistic or Gaussian``.

    Parameters
    ----------
    about : str
        What the curve stands for.
    floor : float
        Reflectance where nothing else is added, 0 to 1.
    edges : tuple of (centre_nm, width_nm, height)
        Logistic steps; the step rises from 27 to 73 % of its height over 2 * `width_nm`; a negative width falls.
    bands : tuple of (centre_nm, width_nm, height)
        Gaussians of standard deviation `width_nm`.
    """

    about: str
    floor: float
    edges: tuple[tuple[float, float, float], ...] = ()
    bands: tuple[tuple[float, float, float], ...] = ()

    def spectrum(self, name: str) -> Spectrum:
        """Evaluate the formula at the reference wavelengths.

        Parameters
        ----------
        name : str
            Name of the result.

        Returns
        -------
        Spectrum
            Reflectance from 360 to 830 nm at 1 nm.

        Raises
        ------
        InvalidParameterError
            If the formula gives a negative reflectance.

        References
        ----------
        Own design.
        """
        wavelengths = REFERENCE_WAVELENGTHS_NM
        values: NDArray[np.float64] = np.full(wavelengths.shape, self.floor)
        for centre, width, height in self.edges:
            values = values + height / (1.0 + np.exp(-(wavelengths - centre) / width))
        for centre, width, height in self.bands:
            values = values + height * np.exp(-0.5 * ((wavelengths - centre) / width) ** 2)
        return Spectrum(wavelengths, values, name)


SYNTHETIC_REFLECTANCES: dict[str, SyntheticReflectance] = {
    "plastic blue": SyntheticReflectance(
        "ultramarine-like blue injection-moulded plastic", 0.035, ((745.0, 22.0, 0.22),), ((455.0, 33.0, 0.47),)
    ),
    "plastic red": SyntheticReflectance(
        "red injection-moulded plastic", 0.035, ((603.0, 9.0, 0.62),), ((420.0, 25.0, 0.015),)
    ),
    "plastic yellow": SyntheticReflectance("yellow moulded plastic", 0.045, ((512.0, 11.0, 0.74),)),
    "plastic green": SyntheticReflectance(
        "green injection-moulded plastic", 0.06, ((740.0, 22.0, 0.20),), ((530.0, 37.0, 0.34),)
    ),
    "plastic orange": SyntheticReflectance("orange moulded plastic", 0.04, ((568.0, 10.0, 0.68),)),
    "plastic white": SyntheticReflectance("white plastic with titanium dioxide", 0.08, ((408.0, 7.0, 0.80),)),
    "plastic black": SyntheticReflectance("carbon-black plastic", 0.042),
    "plastic grey": SyntheticReflectance("neutral grey plastic", 0.06, ((400.0, 8.0, 0.26),)),
    "paint cream": SyntheticReflectance("cream wall paint", 0.10, ((415.0, 9.0, 0.50), (500.0, 25.0, 0.22))),
    "paint signal red": SyntheticReflectance("red enamel", 0.04, ((595.0, 8.0, 0.56),), ((700.0, 60.0, 0.06),)),
    "paint cobalt blue": SyntheticReflectance(
        "cobalt blue paint, with its rise in the far red", 0.05, ((690.0, 9.0, 0.55),), ((458.0, 38.0, 0.50),)
    ),
    "paint viridian": SyntheticReflectance(
        "viridian green paint", 0.07, ((735.0, 18.0, 0.30),), ((512.0, 40.0, 0.27), (410.0, 22.0, 0.05))
    ),
    "paint ochre": SyntheticReflectance(
        "yellow-ochre paint, iron oxide", 0.07, ((553.0, 18.0, 0.40),), ((450.0, 25.0, 0.03), (900.0, 60.0, -0.10))
    ),
    "satin green body": SyntheticReflectance(
        "body of a green rayon satin", 0.04, ((715.0, 16.0, 0.45),), ((527.0, 38.0, 0.24),)
    ),
    "satin green interface": SyntheticReflectance(
        "interface of a green rayon satin: bright and faintly tinted by the dyed fibre",
        0.38,
        ((640.0, 60.0, 0.10),),
        ((525.0, 60.0, 0.12),),
    ),
    "satin red body": SyntheticReflectance("body of a red rayon satin", 0.03, ((612.0, 11.0, 0.52),)),
    "satin red interface": SyntheticReflectance(
        "interface of a red rayon satin: bright and faintly tinted by the dyed fibre", 0.36, ((600.0, 30.0, 0.20),)
    ),
    "satin blue body": SyntheticReflectance(
        "body of a blue rayon satin", 0.03, ((715.0, 14.0, 0.50),), ((452.0, 32.0, 0.34),)
    ),
    "satin blue interface": SyntheticReflectance(
        "interface of a blue rayon satin: bright and faintly tinted by the dyed fibre",
        0.40,
        ((720.0, 30.0, 0.10),),
        ((455.0, 60.0, 0.12),),
    ),
    "cotton white": SyntheticReflectance("bleached cotton", 0.20, ((400.0, 12.0, 0.48), (470.0, 40.0, 0.18))),
    "linen raw": SyntheticReflectance("undyed linen", 0.10, ((420.0, 20.0, 0.16), (560.0, 70.0, 0.36))),
    "denim indigo": SyntheticReflectance("indigo-dyed cotton", 0.035, ((715.0, 12.0, 0.40),), ((440.0, 45.0, 0.13),)),
    "felt navy": SyntheticReflectance("navy wool felt", 0.025, ((735.0, 18.0, 0.35),), ((450.0, 40.0, 0.05),)),
    "paper white": SyntheticReflectance(
        "uncoated paper without brightener", 0.12, ((402.0, 11.0, 0.50), (450.0, 35.0, 0.22))
    ),
    "paper recycled": SyntheticReflectance("recycled paper", 0.15, ((400.0, 15.0, 0.25), (520.0, 60.0, 0.20))),
    "print cyan": SyntheticReflectance(
        "cyan ink on paper", 0.05, ((770.0, 25.0, 0.30),), ((475.0, 48.0, 0.58), (410.0, 20.0, 0.06))
    ),
    "print magenta": SyntheticReflectance("magenta ink on paper", 0.05, ((600.0, 8.0, 0.72),), ((435.0, 28.0, 0.33),)),
    "print yellow": SyntheticReflectance("yellow ink on paper", 0.05, ((497.0, 12.0, 0.78),)),
    "wood oak": SyntheticReflectance("planed oak", 0.08, ((460.0, 30.0, 0.14), (590.0, 50.0, 0.32))),
    "terracotta": SyntheticReflectance("unglazed terracotta", 0.08, ((575.0, 16.0, 0.30),), ((760.0, 60.0, 0.06),)),
    "leather brown": SyntheticReflectance("brown leather", 0.04, ((610.0, 28.0, 0.16), (720.0, 20.0, 0.18))),
    "concrete": SyntheticReflectance("weathered concrete", 0.18, ((420.0, 40.0, 0.10), (560.0, 60.0, 0.06))),
}
"""The formulas by name."""
