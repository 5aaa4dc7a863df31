"""A scene for the benchmarks of colour: ten materials of the three types, three lamps, balls on a floor."""

import math

import numpy as np

from spectral_core.library import illuminant, optical_constants, reflectance
from spectral_core.lights import PointLight
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.scene import Scene, World
from tests.render.render_scenes import ball, floor, look_at, placed

PAINTS = ("plastic blue", "plastic red", "paint viridian", "paint ochre", "plastic white", "terracotta")


def ten_balls(lamps=("D65", "FL11", "A")):
    """Nine balls of nine materials on a floor of the tenth."""
    materials = [TypeI(reflectance(name), 1.0, "cosine", 20.0) for name in PAINTS]
    materials += [
        TypeII(reflectance("satin green body"), reflectance("satin green interface"), "exponential", 10.0),
        TypeII(reflectance("denim indigo"), reflectance("satin blue interface"), "gaussian", 8.0),
        TypeIII.from_optical_constants(optical_constants("copper"), math.radians(15.0)),
        TypeI(reflectance("neutral 6.5"), 0.2, "cosine", 4.0),
    ]
    grid = [(x, y) for y in (-1.0, 0.0, 1.0) for x in (-1.3, 0.0, 1.3)]
    balls = [placed(ball(4, number), (x, y, 0.55), 0.55) for number, (x, y) in enumerate(grid)]
    places = [(3.0, -3.0, 4.0), (-4.0, -2.0, 3.0), (0.5, 4.0, 5.0)]
    lights = [
        PointLight(place, 900.0, illuminant(name), f"lamp {number + 1}")
        for number, (place, name) in enumerate(zip(places, lamps, strict=True))
    ]
    camera = look_at((0.0, -6.5, 4.0), (0.0, 0.0, 0.3), 0.42, 0.42 * 9 / 16)
    return Scene([*balls, placed(floor(40.0, 9))], materials, lights, camera, World(illuminant("D65"), 0.05))


def seconds_of(call, clock, repeats=5):
    """Median time of a call."""
    taken = []
    for _ in range(repeats):
        start = clock()
        call()
        taken.append(clock() - start)
    return float(np.median(taken))
