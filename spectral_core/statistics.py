"""What a render did and how long it took."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

__all__ = ["RenderStatistics"]


@dataclass(slots=True)
class RenderStatistics:
    """Counts and times of one render.

    Attributes
    ----------
    scene : str
        Name of the scene.
    width, height, samples : int
        Size of the image and rays a pixel.
    triangles, dropped_triangles : int
        Triangles that were traced, and those without area that were left out.
    camera_rays, shadow_rays, mirror_rays : int
        Rays that were followed.
    refined_pixels : int or None
        Pixels that took all samples because their first ones differed; None where every pixel does.
    lit_points : dict of str to int
        Points that each light reached, by its name.
    terms : int
        Monomials that occur in the film.
    film_bytes : int
        Memory of the film.
    is_relightable : bool
        False when the film keeps plain colour: at its memory limit, or from mirrored light carried at nodes.
    seconds : dict of str to float
        Time by kind of work, added up over threads that work side by side; "total" is what the clock on the wall says.
    plan : str
        The plan in words.
    notes : list of str
        What the caller should know: approximations, missing data, colours out of gamut.
    """

    scene: str = ""
    width: int = 0
    height: int = 0
    samples: int = 0
    triangles: int = 0
    dropped_triangles: int = 0
    camera_rays: int = 0
    shadow_rays: int = 0
    mirror_rays: int = 0
    refined_pixels: int | None = None
    lit_points: dict[str, int] = field(default_factory=dict)
    terms: int = 0
    film_bytes: int = 0
    is_relightable: bool = True
    seconds: dict[str, float] = field(default_factory=dict)
    plan: str = ""
    notes: list[str] = field(default_factory=list)

    @contextmanager
    def timed(self, work: str) -> Iterator[None]:
        """Add the time of a block to `seconds`.

        Parameters
        ----------
        work : str
            The kind of work.

        Returns
        -------
        context manager
            Yields nothing.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[work] = self.seconds.get(work, 0.0) + time.perf_counter() - start

    def add(self, part: RenderStatistics) -> None:
        """Add the counts and times of a part of the work.

        Parameters
        ----------
        part : RenderStatistics
            Of the part.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        self.camera_rays += part.camera_rays
        self.shadow_rays += part.shadow_rays
        self.mirror_rays += part.mirror_rays
        for name, count in part.lit_points.items():
            self.lit_points[name] = self.lit_points.get(name, 0) + count
        for work, seconds in part.seconds.items():
            self.seconds[work] = self.seconds.get(work, 0.0) + seconds

    def describe(self) -> str:
        """Say in words what was done.

        Returns
        -------
        str
            A few lines.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        parts = ", ".join(f"{work} {seconds:.2f} s" for work, seconds in self.seconds.items() if work != "total")
        lines = [
            f"{self.scene}: {self.width} x {self.height}, {self.samples} samples a pixel, "
            f"{self.triangles:,} triangles, {self.camera_rays:,} camera rays, {self.shadow_rays:,} shadow rays, "
            f"{self.mirror_rays:,} mirror rays",
            f"{self.seconds.get('total', 0.0):.2f} s ({parts})",
            f"film: {self.terms} terms, {self.film_bytes / 2**20:.1f} MiB"
            + ("" if self.is_relightable else "; keeps plain colour and cannot be relit"),
        ]
        if self.refined_pixels is not None:
            share = self.refined_pixels / max(self.width * self.height, 1)
            lines.append(
                f"{self.refined_pixels:,} pixels ({share:.0%}) took all samples, since their first ones differ"
            )
        if self.dropped_triangles:
            lines.append(f"{self.dropped_triangles:,} triangles without area were left out")
        lines.extend(self.plan.splitlines())
        lines.extend(
            f"light '{name}' reached nothing that is seen" for name, count in self.lit_points.items() if not count
        )
        lines.extend(f"note: {note}" for note in self.notes)
        return "\n".join(lines)
