"""Draw the counterparts of the paper's Figures 2, 3, 4, 6, 7 and 9 into docs/figures (``make figures``).

Everything that is drawn is computed by the product; matplotlib only draws. The paper's measurements are not published
as numbers, so the curves are made with the material classes from the library's spectra and optical constants, with
noise where a measurement is imitated. Each figure says so. The same seed gives the same figures.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import matplotlib.ticker
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from spectral_core.colorimetry import observer, tristimulus, white_point, xy  # noqa: E402
from spectral_core.fitting import (  # noqa: E402
    MeasurementGeometry,
    Measurements,
    fit_lobe,
    normalised,
    spectral_tests,
)
from spectral_core.library import illuminant, optical_constants, reflectance  # noqa: E402
from spectral_core.reflection import (  # noqa: E402
    MEAN_BAND_NM,
    OpticalMeanReflectance,
    TypeI,
    TypeII,
    cook_torrance_estimate,
    dichromatic_estimate,
    fresnel_conductor,
    hall_linear_estimate,
)
from spectral_core.spectra import REFERENCE_WAVELENGTHS_NM, Spectrum  # noqa: E402

WAVELENGTHS_NM = np.arange(400.0, 701.0, 5.0)
NOISE = 0.005  # of each value: about that of a good spectrophotometer on a curved sample
SEED = 1996

# Okabe and Ito's palette, which readers with a colour vision deficiency can tell apart.
BLUE, VERMILION, GREEN, ORANGE, GREY = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#6E6E6E"

STYLE = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.4,
    "figure.dpi": 100,
    "savefig.dpi": 200,
}


def measure(material: TypeI | TypeII, geometry: MeasurementGeometry, name: str) -> Measurements:
    """Synthetic measurements of a material relative to a perfect diffuser lit in the same way."""
    values = material.radiance_factor(geometry.normal(), geometry.to_light(), geometry.to_viewer(), WAVELENGTHS_NM)
    noise = 1.0 + NOISE * np.random.default_rng(SEED).standard_normal(values.shape)
    return Measurements(
        WAVELENGTHS_NM, values / np.cos(geometry.incidence)[:, None] * noise, geometry, "diffuser", name
    )


def sampled(name: str) -> Spectrum:
    """A reflectance of the library, read at the wavelengths of the figures."""
    return Spectrum(WAVELENGTHS_NM, reflectance(name).at(WAVELENGTHS_NM), name)


def source(figure: Figure, number: int, text: str) -> None:
    """Say below the figure what was drawn."""
    figure.text(
        0.02,
        0.012,
        text + f"\nCounterpart of Tominaga 1996, Fig. {number}.",
        fontsize=7.5,
        color=GREY,
        ha="left",
        va="bottom",
    )


def wavelength_axis(axes: plt.Axes) -> None:
    axes.set_xlim(400, 700)
    axes.set_xlabel("Wavelength (nm)")


def figure_2() -> Figure:
    """Nine points on a red plastic cup: two components, and a constant in their span."""
    viewing = np.array([45.0, 40.0, 35.0, 30.0, 25.0, 18.0, 10.0, 0.0, -15.0])
    geometry = MeasurementGeometry.from_degrees(np.full(viewing.size, 45.0), viewing)
    data = measure(TypeI(sampled("plastic red"), 5.0, "cosine", 110.0), geometry, "red plastic")
    tests = spectral_tests(data)
    figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    curves = normalised(data)
    for row, curve in enumerate(curves):
        label = "Nine points on the surface" if row == 0 else None
        axes.plot(WAVELENGTHS_NM, curve, color=BLUE, lw=0.8, marker="+", ms=4.5, mew=0.9, markevery=2, label=label)
    line = tests.constant_line * np.sign(tests.constant_line.sum())
    axes.plot(
        WAVELENGTHS_NM,
        line,
        color=VERMILION,
        marker="s",
        ms=3.2,
        markevery=4,
        lw=1.0,
        label="Flattest curve in the span of two components",
    )
    axes.annotate(
        "A (highlight)",
        (405, curves[0][0]),
        xytext=(412, curves[0][0] + 0.035),
        color=BLUE,
        fontsize=9,
        arrowprops={"arrowstyle": "-", "color": BLUE, "lw": 0.6},
    )
    wavelength_axis(axes)
    axes.set_ylim(0, None)
    axes.set_ylabel("Reflectance, normalised to unit length")
    axes.set_title(f"Red plastic: two components hold {share(tests.two_share)} of the variance")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.93))
    figure.get_layout_engine().set(rect=(0.01, 0.07, 0.98, 0.92))
    source(
        figure,
        2,
        "Synthetic: Type I with the library's “plastic red”, S$_I$ = 5, f = cos¹¹⁰ρ, 0.5 % noise.",
    )
    return figure


def ribbons(
    title: str,
    values: np.ndarray,
    angles: np.ndarray,
    angle_label: str,
    value_label: str,
    marks: dict[int, tuple[str, str]],
) -> Figure:
    """Spectra side by side in depth, drawn from back to front; the marked ones in colour."""
    figure = plt.figure(figsize=(7.2, 5.2))
    axes = figure.add_axes((-0.03, 0.07, 1.0, 0.86), projection="3d", computed_zorder=False)

    def curve(row: int, layer: int) -> None:
        colour, label = marks.get(row, ("#46586A", None))
        width = 2.2 if row in marks else 0.8
        level = np.full(WAVELENGTHS_NM.size, angles[row])
        axes.plot(WAVELENGTHS_NM, level, values[row], color=colour, lw=width, label=label, zorder=layer)

    for row in range(angles.size - 2, -1, -1):
        layer = 2 * (angles.size - row)
        w, a = np.meshgrid(WAVELENGTHS_NM, angles[row : row + 2])
        paper = {"color": "#EEF2F6", "linewidth": 0, "antialiased": False, "shade": False}
        axes.plot_surface(w, a, values[row : row + 2], rstride=1, cstride=1, zorder=layer, **paper)
        curve(row + 1, layer + 1)  # after the strip in front of it, which would cover half its width
    curve(0, 2 * angles.size + 2)
    axes.set_xlabel("Wavelength (nm)", labelpad=6)
    axes.set_ylabel(angle_label, labelpad=6)
    axes.set_zlabel(value_label, labelpad=6)
    axes.set_xlim(400, 700)
    axes.set_ylim(angles[0], angles[-1])
    axes.set_zlim(0, None)
    axes.yaxis.set_major_locator(mpl.ticker.MultipleLocator(15 if angles[-1] > 60 else 10))
    axes.view_init(elev=24, azim=-56)
    axes.set_box_aspect((1.25, 1.1, 0.75), zoom=1.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.set_facecolor("white")
        axis.pane.set_edgecolor("#D0D0D0")
        axis._axinfo["grid"].update(color="#E4E4E4", linewidth=0.6)
    axes.tick_params(labelsize=8, pad=1)
    figure.text(0.02, 0.975, title, fontsize=11, ha="left", va="top")
    figure.legend(loc="upper left", bbox_to_anchor=(0.01, 0.935))
    return figure


def share(part: float) -> str:
    """A share of variance in per cent, rounded down, so that no rest is rounded away."""
    return f"{np.floor(part * 1e5) / 1e3:.3f} %"


def figure_3() -> Figure:
    """Cyan ink on art paper: two components, but no constant at any angle."""
    viewing = np.concatenate([np.arange(-8.0, 6.0, 2.0), np.arange(6.0, 11.0, 1.0), np.arange(13.0, 36.0, 2.0)])
    geometry = MeasurementGeometry.from_degrees(np.full(viewing.size, 8.0), viewing)
    cyan = sampled("print cyan")
    bronze = Spectrum(WAVELENGTHS_NM, 0.55 + 0.3 * np.tanh((WAVELENGTHS_NM - 560.0) / 90.0), "bronze")
    data = measure(TypeII(cyan, bronze, "exponential", 10.0), geometry, "cyan print")
    tests = spectral_tests(data)
    mirror = int(np.argmin(np.abs(viewing - 8.0)))
    figure = ribbons(
        f"Cyan ink on art paper: {share(tests.two_share)} in two components, none of them constant",
        normalised(data),
        viewing,
        "Viewing angle (°)",
        "Normalised reflectance",
        {mirror: (VERMILION, "mirror direction, +8°"), viewing.size - 1: (BLUE, "+35°")},
    )
    source(
        figure,
        3,
        "Synthetic: Type II with the library's “print cyan” and a bronzing gloss, "
        "f = exp(−10ρ), incidence 8°, 0.5 % noise.",
    )
    return figure


def figure_4() -> Figure:
    """A plate of copper in the mirror direction: the curve at normal incidence and a constant."""
    angles = np.arange(5.0, 76.0, 5.0)
    n, k = optical_constants("copper").at(WAVELENGTHS_NM)
    values = fresnel_conductor(np.cos(np.radians(angles))[:, None], n, k)
    geometry = MeasurementGeometry.from_degrees(angles, angles)
    data = Measurements(WAVELENGTHS_NM, values, geometry, "beam", "copper")
    rest = spectral_tests(data).normal_rest
    figure = ribbons(
        f"Copper in the mirror direction: the 5° curve and a constant hold {share(1.0 - rest)}",
        normalised(data),
        angles,
        "Angle of incidence (°)",
        "Normalised reflectance",
        {0: (VERMILION, "5°"), angles.size - 1: (BLUE, "75°")},
    )
    source(
        figure,
        4,
        "Library data: Fresnel reflectance from the optical constants of copper (McPeak et al. 2015).",
    )
    return figure


def satin() -> Measurements:
    viewing = np.concatenate([np.arange(5.0, 35.0, 5.0), np.arange(35.0, 46.0, 1.0)])
    geometry = MeasurementGeometry.from_degrees(np.full(viewing.size, 45.0), viewing)
    material = TypeII(sampled("satin green body"), sampled("satin green interface"), "exponential", 10.0)
    return measure(material, geometry, "green satin")


def figure_6() -> Figure:
    """Green rayon satin: the curve at the mirror angle is S_I, the one far from it close to S_B."""
    data = satin()
    viewing = np.degrees(data.geometry.viewing)
    figure = ribbons(
        "Green rayon satin, incidence 45°",
        data.reflectances,
        viewing,
        "Viewing angle (°)",
        "Radiance factor",
        {viewing.size - 1: (VERMILION, "45° (mirror direction): near S$_I$"), 0: (GREEN, "5°: near S$_B$")},
    )
    source(
        figure,
        6,
        "Synthetic: Type II with the library's “satin green” body and interface, f = exp(−10ρ), 0.5 % noise.",
    )
    return figure


def figure_7() -> Figure:
    """The averages over wavelength against rho, and the fitted attenuation."""
    fit = fit_lobe(satin())
    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    rho = np.degrees(fit.rho)
    order = np.argsort(rho)
    axes.plot(rho, fit.averages, "+", color=BLUE, ms=9, mew=1.4, label="Averages of the spectra over wavelength")
    law = {"exponential": "exp(−nρ)", "gaussian": "exp(−nρ²)", "cosine": "cosⁿρ"}[fit.kind]
    axes.plot(
        rho[order],
        fit.fitted[order],
        color=VERMILION,
        marker="s",
        ms=4.5,
        mfc="none",
        lw=1.0,
        label=f"Fit: a {law} + b cos φ,  n = {fit.n.value:.2f} (95 %: {fit.n.low:.2f} to {fit.n.high:.2f})",
    )
    axes.set_xlabel("Angle ρ between viewer and mirror direction (°)")
    axes.set_ylabel("Relative value, peak = 1")
    axes.set_xlim(-1, 41)
    axes.set_ylim(0, 1.05)
    axes.set_title("Attenuation of green satin's interface reflection")
    axes.legend(loc="upper right")
    figure.get_layout_engine().set(rect=(0.01, 0.07, 0.98, 0.92))
    source(figure, 7, "Synthetic: the spectra of Fig. 6, made with f = exp(−10ρ).")
    return figure


def figure_9() -> Figure:
    """Copper's chromaticity against incidence: Fresnel, Eq. 13, Hall and Cook-Torrance."""
    angles = np.arange(0.0, 91.0, 5.0)
    fine = np.concatenate([np.arange(0.0, 85.0, 0.5), np.linspace(85.0, 90.0, 251)])
    constants, light, watcher = optical_constants("copper"), illuminant("D65"), observer("cie_1931_2")
    n, k = constants.at(REFERENCE_WAVELENGTHS_NM)
    mean = OpticalMeanReflectance(*constants.at(MEAN_BAND_NM))
    normal = fresnel_conductor(1.0, n, k)

    def cosine(degrees: float) -> float:
        return float(np.sin(np.radians(90.0 - degrees)))

    methods: dict[str, tuple[Callable[[float], np.ndarray], str, str]] = {
        "Fresnel (n, k)": (lambda d: fresnel_conductor(cosine(d), n, k), "D", "black"),
        "Eq. 13": (lambda d: dichromatic_estimate(normal, mean.at(np.radians(d)), mean.at(0.0)), "+", BLUE),
        "Hall": (lambda d: hall_linear_estimate(normal, np.radians(d)), "s", GREEN),
        "Cook–Torrance": (lambda d: cook_torrance_estimate(normal, cosine(d)), "o", VERMILION),
    }

    def locus(method: Callable[[float], np.ndarray], degrees: np.ndarray) -> np.ndarray:
        curves = [Spectrum(REFERENCE_WAVELENGTHS_NM, method(float(d))) for d in degrees]
        return np.array([xy(tristimulus(curve, light, watcher)) for curve in curves])

    figure, (top, bottom) = plt.subplots(2, 1, figsize=(7.2, 7.6), layout="constrained")
    exact = locus(methods["Fresnel (n, k)"][0], fine)
    for name, (method, marker, colour) in methods.items():
        path, points = locus(method, fine), locus(method, angles)
        top.plot(*path.T, color=colour, lw=0.7)
        top.plot(*points.T, marker, color=colour, ms=8 if marker == "+" else 5, mfc="none", mew=1.1, ls="", label=name)
        if method is not methods["Fresnel (n, k)"][0]:
            bottom.plot(fine, np.linalg.norm(path - exact, axis=1), color=colour, label=name)
    white = xy(white_point(light, watcher))
    top.annotate("90°", white, xytext=(-6, -12), textcoords="offset points", fontsize=9, ha="center")
    top.annotate("0°", exact[0], xytext=(8, -10), textcoords="offset points", fontsize=9, ha="center")
    top.set_aspect("equal")
    top.margins(0.08)
    top.set_xlabel("x")
    top.set_ylabel("y")
    top.set_title("Chromaticity under D65, every 5°")
    top.legend(loc="upper left")
    bottom.set_xlabel("Angle of incidence (°)")
    bottom.set_ylabel("Distance in xy from Fresnel, equal angle")
    bottom.set_xlim(0, 90)
    bottom.set_ylim(0, None)
    bottom.set_xticks(np.arange(0, 91, 15))
    bottom.set_title("How far each estimate is off")
    bottom.legend(loc="upper left")
    figure.get_layout_engine().set(rect=(0.01, 0.07, 0.98, 0.92))
    source(
        figure,
        9,
        "Library data: optical constants of copper (McPeak et al. 2015); CIE 1931 observer.",
    )
    return figure


FIGURES = {
    "figure_2_plastic": figure_2,
    "figure_3_print": figure_3,
    "figure_4_copper": figure_4,
    "figure_6_satin": figure_6,
    "figure_7_attenuation": figure_7,
    "figure_9_copper_locus": figure_9,
}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Draw the counterparts of the paper's figures.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"which ones; default all: {', '.join(FIGURES)}")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "figures", help="folder")
    options = parser.parse_args(arguments)
    unknown = set(options.names) - set(FIGURES)
    if unknown:
        parser.error(f"no such figure: {', '.join(sorted(unknown))}")
    options.output.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        for name in options.names or FIGURES:
            figure = FIGURES[name]()
            path = options.output / f"{name}.png"
            figure.savefig(path, metadata={"Software": None})
            plt.close(figure)
            print(f"wrote {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
