"""What exact colour costs beside RGB and beside 61 samples a pixel: ``python -m tests.benchmarks.colour_cost``.

The same hits, lamps and shadows for all three, at 1280x720 with one sample; only shading is timed, from the visible and
lit points to the picture. All share the geometric part, which is this program's own:

(a) this: coefficients to the film, the film to XYZ by one product a block;
(b) 61 samples: the radiance spectrum of every pixel from 400 to 700 nm at 5 nm, as the paper does, then XYZ;
(c) RGB: three-component colours of lamps and materials multiplied in every pixel, as an RGB renderer does.

Medians of processor time on one thread. The second column leaves the shared geometric part out.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time

import numpy as np

from spectral_core.colorimetry import observer, wavelength_grid
from spectral_core.film import add_rows
from spectral_core.film_builder import Deposits, FilmBuilder
from spectral_core.job import Job
from spectral_core.scene import RenderSettings
from spectral_core.shading import component_coefficients, facing, place_components, surface_points
from tests.benchmarks.cost_scene import seconds_of, ten_balls

WIDTH, HEIGHT = 1280, 720


class Prepared:
    """Everything up to the lit points: the part that no one of the three does differently."""

    def __init__(self):
        self.scene = ten_balls()
        job = Job.prepare(self.scene, RenderSettings(WIDTH, HEIGHT, samples=1, band_samples=WIDTH * HEIGHT))
        self.plan, self.spectra = job.plan, job.spectra
        (task,) = job.tasks(1)
        hits, directions, _ = job.visibility.primary(task.part, np.array([0.5, 0.5]))
        self.points = surface_points(job.geometry, hits, directions)
        self.groups = self.points.groups()
        self.missed = np.flatnonzero(~hits.hit)
        self.illuminations, self.lit = [], []
        for source in job.sources:
            at = source.lamp_point(np.array([0.5, 0.5]), job.geometry.centre)
            illumination = source.illuminate(self.points.position, job.geometry.centre, at)
            candidates = facing(self.points, illumination)
            self.illuminations.append(illumination)
            self.lit.append(
                job.visibility.unoccluded(source, at, self.points, illumination, candidates, is_scattered=False)
            )

    def parts(self):
        """Coefficients (n, Km) of every material under every lamp, and the rows of its points."""
        for number, (illumination, lit) in enumerate(zip(self.illuminations, self.lit, strict=True)):
            for index, part in self.groups:
                rows = lit[np.searchsorted(lit, part.start) : np.searchsorted(lit, part.stop)]
                if len(rows):
                    yield (
                        number,
                        index,
                        part,
                        rows,
                        component_coefficients(self.scene.materials[index], self.points, illumination, rows),
                    )


def by_terms(ready):
    """(a) the film, and the film's colours."""
    sees, grid = observer("cie_1931_2"), wavelength_grid("exact")
    film = FilmBuilder(WIDTH, HEIGHT, ready.spectra, sees, grid)
    found = Deposits(np.arange(WIDTH * HEIGHT), WIDTH, np.dtype(np.float32))
    blocks = {
        index: np.zeros((part.stop - part.start, len(ready.plan.materials[index].terms)), np.float32)
        for index, part in ready.groups
    }
    for number, index, part, rows, values in ready.parts():
        width = values.shape[1]
        place_components(blocks[index], rows - part.start, number * width, values)
    for index, part in ready.groups:
        found.deposit(ready.plan.materials[index].terms, ready.points.ray[part], blocks[index])
    found.deposit((ready.plan.background,), ready.missed, np.ones((len(ready.missed), 1), np.float32))
    film.add(found.merge(1))
    return film.finish().tristimulus(ready.spectra, sees, grid)


def by_vectors(ready, lamps, reflectances, background):
    """(b) and (c): a vector of C components a pixel, C = 61 or 3."""
    image = np.zeros((HEIGHT * WIDTH, len(background)), np.float32)
    for number, index, _, rows, values in ready.parts():
        add_rows(image, ready.points.ray[rows], values @ (reflectances[index] * lamps[number]))
    image[ready.missed] += background
    return image.reshape(HEIGHT, WIDTH, -1)


def tables(ready, to_components):
    """Lamps (L, C), reflectances by material (Km, C) and the background (C) as `to_components` sees them."""
    lamps = [to_components(e.illuminant, True) * e.strength for e in ready.spectra.emitters]
    reflectances = [
        np.array([to_components(r, False) for r in material.reflectances], np.float32)
        for material in ready.scene.materials
    ]
    return [lamp.astype(np.float32) for lamp in lamps[:-1]], reflectances, lamps[-1].astype(np.float32)


def main():
    ready = Prepared()
    sees = observer("cie_1931_2")
    nodes = np.arange(400.0, 701.0, 5.0)
    functions = np.array([np.interp(nodes, sees.wavelengths_nm, f) for f in sees.matching_functions.T]).T
    white = functions.sum(axis=0)[1]

    def at_61(spectrum, is_lamp):
        values = spectrum.at(nodes)
        return values / (values @ functions[:, 1]) if is_lamp else values

    def in_rgb(spectrum, is_lamp):
        values = spectrum.at(nodes)
        xyz = values @ functions / (values @ functions[:, 1] if is_lamp else white)
        return np.maximum(
            np.linalg.solve([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]], xyz), 0.0
        )

    table_61, table_rgb = tables(ready, at_61), tables(ready, in_rgb)
    to_xyz = functions.astype(np.float32)
    calls = {
        "geometric part alone": lambda: [None for _ in ready.parts()],
        "(a) this: terms, 1 nm": lambda: by_terms(ready),
        "(b) 61 samples a pixel": lambda: by_vectors(ready, *table_61) @ to_xyz,
        "(c) RGB triples": lambda: by_vectors(ready, *table_rgb),
    }
    taken = {name: seconds_of(call, time.process_time) for name, call in calls.items()}
    shared = taken["geometric part alone"]
    print(f"shading of {WIDTH} x {HEIGHT} pixels, 3 lamps, 10 materials, one thread, median of 5")
    for name, seconds in taken.items():
        extra = "" if name == "geometric part alone" else f"  without it {seconds - shared:7.3f} s"
        print(f"  {name:<24} {seconds:7.3f} s{extra}")
    a, b, c = (taken[name] for name in list(taken)[1:])
    apart = (b - shared) / (a - shared)
    print(f"  (a)/(c) {a / c:.2f}    (b)/(a) {b / a:.1f}    without the shared part (b)/(a) {apart:.1f}")
    exact, coarse = by_terms(ready), by_vectors(ready, *table_61) @ to_xyz
    print(f"  largest difference in XYZ between (b) and (a), white = 1: {np.abs(exact - coarse).max():.3f}")


if __name__ == "__main__":
    main()
