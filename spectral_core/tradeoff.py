"""Error against time for one scene: what each setting costs here, and which settings are worth it."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import GRID_PRESETS
from .development import Development
from .errors import InvalidParameterError
from .estimate import ColourError, colour_error, reference_settings
from .renderer import Cancel, Render, render
from .scene import RenderSettings, Scene
from .validation import require_in_range

__all__ = ["Measurement", "Tradeoff", "measure_tradeoff", "quality_settings"]

SAMPLES = (1, 2, 4, 8, 16)
BOUNCES = (0, 1, 2, 4)
SCALES = (0.25, 0.5)

QUALITIES = {
    "draft": {"samples": 1, "bounce_grid": "draft", "max_bounces": 1},
    "standard": {"samples": 4, "bounce_grid": "standard", "max_bounces": 4},
    "high": {"samples": 16, "bounce_grid": "high", "max_bounces": 6},
    "reference": {"samples": 64, "bounce_grid": "reference", "max_bounces": 8, "precision": "float64"},
}
"""What the presets of the render panel set; the colour side of direct light is exact in all of them, as it is free."""


def quality_settings(name: str, settings: RenderSettings | None = None) -> RenderSettings:
    """Apply one of the presets Draft, Standard, High, Reference.

    Parameters
    ----------
    name : {"draft", "standard", "high", "reference"}
        The preset.
    settings : RenderSettings, optional
        What it is applied to: size, seed and the like stay.

    Returns
    -------
    RenderSettings
        The settings.

    Raises
    ------
    InvalidParameterError
        If there is no such preset.

    References
    ----------
    Own design.
    """
    if name not in QUALITIES:
        raise InvalidParameterError(f"quality must be one of {', '.join(QUALITIES)}, but is {name!r}")
    changes: dict[str, Any] = {"precision": "float32", "grid": "exact", **QUALITIES[name]}
    return replace(settings or RenderSettings(), **changes)


@dataclass(frozen=True, slots=True)
class Measurement:
    """One way to render the scene.

    Attributes
    ----------
    axis : str
        What was varied: "samples", "precision", "wavelengths", "bounces" or "resolution".
    value : str
        To what.
    error : ColourError
        Against the reference.
    seconds : float
        Whole time of the render.
    is_pareto : bool
        Whether nothing measured is both faster and closer.
    """

    axis: str
    value: str
    error: ColourError
    seconds: float
    is_pareto: bool = False


@dataclass(frozen=True, slots=True)
class Tradeoff:
    """What a scene's settings cost.

    Attributes
    ----------
    scene : str
        Its name.
    base : RenderSettings
        What was varied, one setting at a time.
    measurements : tuple of Measurement
        In the order of the axes.
    reference_seconds : float
        Time of the reference.
    """

    scene: str
    base: RenderSettings
    measurements: tuple[Measurement, ...]
    reference_seconds: float

    def choose(self, target: float) -> Measurement | None:
        """Find the fastest measured way that keeps the mean error below a target.

        Parameters
        ----------
        target : float
            Mean Delta E 2000, above 0.

        Returns
        -------
        Measurement or None
            None when nothing measured is that close.

        Raises
        ------
        InvalidParameterError
            If the target is not above 0.

        References
        ----------
        Own design.
        """
        require_in_range("target", target, 1e-12)
        close = [m for m in self.measurements if m.error.mean <= target]
        return min(close, key=lambda m: m.seconds) if close else None

    def advise(self, targets: Sequence[float] = (1.0, 0.5, 0.1)) -> str:
        """Say in one sentence what to choose for some targets.

        Parameters
        ----------
        targets : sequence of float
            Mean Delta E 2000.

        Returns
        -------
        str
            One sentence.

        Raises
        ------
        InvalidParameterError
            If a target is not above 0.

        References
        ----------
        Own design.
        """
        parts = []
        for target in targets:
            chosen = self.choose(target)
            if chosen is None:
                parts.append(f"for {target:g} more than was measured is needed")
            else:
                parts.append(f"for {target:g} take {chosen.axis} {chosen.value} ({chosen.seconds:.2f} s)")
        return "For a mean Delta E 2000: " + "; ".join(parts) + "."

    def table(self) -> str:
        """Lay the measurements out as text.

        Returns
        -------
        str
            A line a measurement; a star marks the Pareto set.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        lines = [f"{'setting':<28} {'mean':>8} {'95 %':>8} {'max':>8} {'seconds':>9}"]
        for m in self.measurements:
            name = f"{m.axis} {m.value}" + (" *" if m.is_pareto else "")
            e = m.error
            lines.append(f"{name:<28} {e.mean:8.3f} {e.percentile_95:8.3f} {e.largest:8.2f} {m.seconds:9.3f}")
        lines.append(f"reference: {self.reference_seconds:.1f} s; * nothing measured is both faster and closer")
        return "\n".join(lines)

    def csv(self) -> str:
        """Write the measurements as comma-separated values.

        Returns
        -------
        str
            With a header line.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["axis", "value", "delta_e_mean", "delta_e_95", "delta_e_max", "seconds", "pareto"])
        for m in self.measurements:
            e = m.error
            writer.writerow(
                [
                    m.axis,
                    m.value,
                    f"{e.mean:.6g}",
                    f"{e.percentile_95:.6g}",
                    f"{e.largest:.6g}",
                    f"{m.seconds:.6g}",
                    int(m.is_pareto),
                ]
            )
        return text.getvalue()


def measure_tradeoff(
    scene: Scene,
    base: RenderSettings,
    development: Development | None = None,
    progress: Callable[[float, str], None] | None = None,
    cancel: Cancel | None = None,
) -> Tradeoff:
    """Render a scene in many ways and compare each with a reference.

    Parameters
    ----------
    scene : Scene
        The scene.
    base : RenderSettings
        Varied one setting at a time.
    development : Development, optional
        How pictures are judged.
    progress : callable, optional
        Called as ``progress(fraction, message)``.
    cancel : callable, optional
        Asked between bands.

    Returns
    -------
    Tradeoff
        All measurements.

    Raises
    ------
    SceneError
        If the scene has no camera.
    RenderCancelledError
        If `cancel` said so.

    References
    ----------
    Own design.
    """
    variants = _variants(scene, base)
    report = progress or (lambda fraction, message: None)
    report(0.0, "rendering the reference")
    wanted = reference_settings(replace(base, samples=max(SAMPLES)))
    reference, reference_seconds = _timed(scene, wanted, cancel)
    target = reference.tristimulus()
    measurements = []
    for number, (axis, value, settings) in enumerate(variants):
        report((number + 1) / (len(variants) + 1), f"{axis} {value}")
        made, seconds = _timed(scene, settings, cancel)
        image = _enlarged(made.tristimulus(), target.shape[0], target.shape[1])
        measurements.append(Measurement(axis, value, colour_error(image, target, base.observer, development), seconds))
    report(1.0, "done")
    return Tradeoff(scene.name, base, _with_pareto(measurements), reference_seconds)


def _variants(scene: Scene, base: RenderSettings) -> list[tuple[str, str, RenderSettings]]:
    found: list[tuple[str, str, RenderSettings]] = [("samples", str(n), replace(base, samples=n)) for n in SAMPLES]
    found += [("precision", p, replace(base, precision=p)) for p in ("float32", "float64")]
    mirrors = any(material.mirror > 0.0 for material in scene.materials)
    spectra = "nodes" if mirrors else base.bounce_spectra
    found += [
        ("wavelengths", grid, replace(base, grid=grid, bounce_grid=grid, bounce_spectra=spectra))
        for grid in GRID_PRESETS
    ]
    if mirrors:
        found += [("bounces", str(n), replace(base, max_bounces=n)) for n in BOUNCES]
    for scale in SCALES:
        width, height = max(1, round(base.width * scale)), max(1, round(base.height * scale))
        found.append(("resolution", f"{width}x{height}", replace(base, width=width, height=height)))
    return found


def _timed(scene: Scene, settings: RenderSettings, cancel: Cancel | None) -> tuple[Render, float]:
    started = time.perf_counter()
    made = render(scene, settings, cancel=cancel)
    made.tristimulus()
    return made, time.perf_counter() - started


def _enlarged(image: NDArray[np.floating[Any]], height: int, width: int) -> NDArray[np.float64]:
    """Bilinear interpolation between pixel centres."""
    out = np.asarray(image, np.float64)
    for axis, size in ((0, height), (1, width)):
        count = out.shape[axis]
        if count == size:
            continue
        position = np.clip((np.arange(size) + 0.5) * count / size - 0.5, 0.0, count - 1.0)
        low = np.minimum(position.astype(int), max(count - 2, 0))
        share = (position - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        high = np.minimum(low + 1, count - 1)
        out = np.take(out, low, axis) * (1.0 - share) + np.take(out, high, axis) * share
    return out


def _with_pareto(measurements: list[Measurement]) -> tuple[Measurement, ...]:
    def beats(other: Measurement, m: Measurement) -> bool:
        costs, bound = (other.seconds, other.error.mean), (m.seconds, m.error.mean)
        return costs != bound and costs[0] <= bound[0] and costs[1] <= bound[1]

    return tuple(replace(m, is_pareto=not any(beats(o, m) for o in measurements)) for m in measurements)
