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


def random_scene(seed, balls=14, subdivisions=4):
    """Balls of random sizes, places and materials, some of which mirror, on a floor, under two or three lamps."""
    rng = np.random.default_rng(seed)
    paints = [TypeI(reflectance(name), 1.0, "cosine", rng.uniform(5, 60)) for name in rng.permutation(PAINTS)[:3]]
    mirrors = [
        TypeI(reflectance(PAINTS[int(rng.integers(len(PAINTS)))]), 0.8, "cosine", 60.0, mirror=rng.uniform(0.05, 0.3)),
        TypeIII.from_optical_constants(
            optical_constants(("copper", "gold", "silver")[int(rng.integers(3))]), rng.uniform(0.1, 0.3), mirror=0.8
        ),
    ]
    materials = [*paints, *mirrors, TypeI(reflectance("neutral 6.5"), 0.2, "cosine", 4.0)]
    sizes = rng.uniform(0.15, 0.7, balls)
    places = np.column_stack([rng.uniform(-2.2, 2.2, (balls, 2)), sizes])
    instances = [
        placed(ball(subdivisions, int(rng.integers(5))), place, size) for place, size in zip(places, sizes, strict=True)
    ]
    lamps = rng.permutation(("D65", "A", "FL2", "FL11", "HP1", "LED-B3"))[: int(rng.integers(2, 4))]
    lights = [
        PointLight((*rng.uniform(-4, 4, 2), rng.uniform(3, 6)), 900.0, illuminant(str(name)), f"lamp {number + 1}")
        for number, name in enumerate(lamps)
    ]
    camera = look_at((*rng.uniform(-2, 2, 1), -6.5, rng.uniform(2, 5)), (0.0, 0.0, 0.4), 0.42, 0.42 * 9 / 16)
    return Scene([*instances, placed(floor(40.0, 5))], materials, lights, camera, World(illuminant("D65"), 0.2))


def seconds_of(call, clock, repeats=5):
    """Median time of a call."""
    taken = []
    for _ in range(repeats):
        start = clock()
        call()
        taken.append(clock() - start)
    return float(np.median(taken))
