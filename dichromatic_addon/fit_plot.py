"""The plot of a fit: spectra and residuals, the components with their intervals, and the lobe against its angle."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ._core import core
from .plotting import new_figure, save_figure

__all__ = ["draw_fit"]

_SIZE_INCHES = (12.0, 7.5)


def draw_fit(fit: core.fitting.MaterialFit, path: Path) -> None:
    """Draw a fit into a file.

    Parameters
    ----------
    fit : MaterialFit
        The fit.
    path : Path
        A .png, .svg or .pdf file; it is replaced only when everything has been drawn.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    InvalidParameterError
        If the file's suffix is none of these.
    """
    figure = new_figure(path, _SIZE_INCHES)
    (spectra, components), (lobe, residuals) = figure.subplots(2, 2)
    _draw_spectra(spectra, fit)
    _draw_components(components, fit)
    _draw_lobe(lobe, fit)
    _draw_residuals(residuals, fit)
    title = f"{fit.measurements.name or 'measurements'}: Type {fit.material_type}"
    figure.suptitle(f"{title}, {', '.join(p.describe() for p in fit.parameters)}", fontsize="medium")
    save_figure(figure, path)


def _draw_spectra(axes: Any, fit: core.fitting.MaterialFit) -> None:
    wavelengths = fit.measurements.wavelengths_nm
    for measured, fitted in zip(core.fitting.normalised(fit.measurements), fit.fit.fit.fitted, strict=True):
        length = float(np.linalg.norm(fitted))
        line = axes.plot(wavelengths, measured, ".", markersize=3)[0]
        axes.plot(wavelengths, fitted / (length or 1.0), color=line.get_color(), linewidth=0.8)
    axes.set(title="Normalised spectra (points) and fit (lines)", xlabel="wavelength in nm", ylabel="unit length")


def _draw_components(axes: Any, fit: core.fitting.MaterialFit) -> None:
    named = [("interface $S_I$", fit.interface)]
    if fit.body is not None:
        named.append(("body $S_B$", fit.body))
    for name, estimate in named:
        line = axes.plot(estimate.wavelengths_nm, estimate.values, label=name)[0]
        axes.fill_between(estimate.wavelengths_nm, estimate.low, estimate.high, color=line.get_color(), alpha=0.3)
    axes.set(title=f"Components, {100.0 * fit.confidence:g} % intervals", xlabel="wavelength in nm")
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.legend()


def _draw_lobe(axes: Any, fit: core.fitting.MaterialFit) -> None:
    rho = np.degrees(fit.measurements.require_geometry("drawing the lobe").from_mirror())
    measured, fitted = fit.measurements.reflectances.mean(axis=1), fit.fit.fit.fitted.mean(axis=1)
    top = float(measured.max())
    axes.plot(rho, measured / top, "+", label="measured")
    axes.plot(rho, fitted / top, "s", fillstyle="none", markersize=4, label="fitted")
    axes.set(
        title="Averages over wavelength", xlabel="degrees from the mirror direction", ylabel="relative to the largest"
    )
    axes.legend()


def _draw_residuals(axes: Any, fit: core.fitting.MaterialFit) -> None:
    residuals = (fit.measurements.reflectances - fit.fit.fit.fitted) / np.max(np.abs(fit.measurements.reflectances))
    axes.plot(fit.measurements.wavelengths_nm, 100.0 * residuals.T, linewidth=0.6)
    axes.set(
        title=f"Residuals, {100.0 * fit.fit.relative_residual:.3g} % in all",
        xlabel="wavelength in nm",
        ylabel="% of the largest value",
    )
