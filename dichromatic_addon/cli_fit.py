"""``dichromatic fit DATA.csv -o material.json``: a material from spectra measured at several geometries.

Needs neither Blender nor a window. What was found, and why, is printed; ``--plot`` draws it.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from ._core import core
from .fit_plot import draw_fit

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the verb."""
    parser.add_argument(
        "data", metavar="DATA.csv", type=Path, help="measured spectra, laid out as docs/fitting.md tells"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="material.json", help="where to write the material")
    parser.add_argument(
        "--plot", type=Path, metavar="OUT.png", help="where to draw data, fit and spectra (or .svg, .pdf)"
    )
    parser.add_argument("--name", metavar="NAME", help="name of the material (default: that of the file)")
    parser.add_argument(
        "--reference",
        choices=core.fitting.REFERENCES,
        help="what the values are relative to: a perfect diffuser lit in the same way, or the irradiance on a plane "
        "facing the light (default: what the file says, else the diffuser)",
    )
    parser.add_argument(
        "--type", choices=core.fitting.MATERIAL_TYPES, help="fit this type (default: the recommended one)"
    )
    parser.add_argument("--confidence", type=float, default=0.95, metavar="P", help="of the intervals (default: 0.95)")
    lobe = parser.add_argument_group("plastic, cloth and paper (Types I and II)")
    lobe.add_argument("--attenuation", choices=core.reflection.ATTENUATIONS, help="law of f (default: the best)")
    lobe.add_argument("--n", type=float, metavar="N", help="hold n at this value")
    metal = parser.add_argument_group("metal (Type III)")
    metal.add_argument("--beta", type=_degrees, metavar="DEG", help="hold the half-value angle at this value")
    metal.add_argument("--beta-across", type=_degrees, metavar="DEG", help="hold that across the grain at this value")
    metal.add_argument(
        "--isotropic", action="store_true", help="fit one half-value angle (default: two, where the data show them)"
    )
    metal.add_argument(
        "--mean-reflectance",
        default="auto",
        metavar="SOURCE",
        help="Sa(phi) of Eq. 13: schlick, fresnel (one n and k, fitted), auto (the better of the two), table (fitted "
        f"at the incidences measured), or a metal of the library: {', '.join(core.metal_names())} (default: auto)",
    )
    metal.add_argument("--scale", type=float, metavar="K", help="hold the factor of the values over Eq. 10")


def run(arguments: argparse.Namespace) -> int:
    """Fit, print, write; raise a DichromaticError with the reason where that is not possible."""
    fitting = core.fitting
    for target in (arguments.output, arguments.plot):
        if target is not None and not target.parent.is_dir():
            raise core.errors.DichromaticError(f"the folder {target.parent} of the output does not exist")
    measurements = fitting.read_measurements(arguments.data, arguments.reference)
    if measurements.geometry is None:
        return _report_tests(arguments, measurements)
    fit = fitting.fit_material(measurements, _options(arguments))
    print(fit.describe())
    if arguments.output is not None:
        name = arguments.name or measurements.name
        provenance = fitting.provenance_of_fit(fit, arguments.data.name)
        fitting.write_material_json(arguments.output, fit.material, name, provenance)
        print(f"{arguments.output} written")
    if arguments.plot is not None:
        draw_fit(fit, arguments.plot)
        print(f"{arguments.plot} written")
    return 0


def _report_tests(arguments: argparse.Namespace, measurements: core.fitting.Measurements) -> int:
    """Tell what the spectra show without angles: the tests and the two extreme curves, but no material."""
    recommendation = core.fitting.recommend_type(measurements)
    print("\n".join(recommendation.evidence))
    if arguments.output is not None or arguments.plot is not None:
        raise core.errors.FittingError(
            f"{arguments.data.name} must state incidence and viewing angles for a material to be fitted, but has none"
        )
    return 0


def _options(arguments: argparse.Namespace) -> core.fitting.FitOptions:
    mean = arguments.mean_reflectance
    if mean not in core.fitting.MEAN_REFLECTANCES:
        mean = core.TypeIII.from_optical_constants(core.optical_constants(mean), 0.1).mean_reflectance
    return core.fitting.FitOptions(
        material_type=arguments.type,
        attenuation=arguments.attenuation,
        n=arguments.n,
        beta=_radians(arguments.beta),
        beta_across=_radians(arguments.beta_across),
        anisotropic=False if arguments.isotropic else None,
        mean_reflectance=mean,
        scale=arguments.scale,
        confidence=arguments.confidence,
    )


def _degrees(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value <= 90.0:
        raise argparse.ArgumentTypeError(f"must lie between 0 and 90 degrees, but is {text!r}")
    return value


def _radians(degrees: float | None) -> float | None:
    return None if degrees is None else math.radians(degrees)
