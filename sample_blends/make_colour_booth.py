"""Make colour_booth.blend: a viewing booth with a ColorChecker and two paints that match in daylight only.

Run with Blender 4.2 (every later version opens the file)::

    python sample_blends/make_colour_booth.py [OUT.blend]

The second paint of the pair is computed here: three narrow bands on a floor, weighted so that its
tristimulus values under D65 are those of the first (a 3 x 3 system, Wyszecki and Stiles 1982, 3.8.2). It is written
beside this script as metameric_paint.csv, and its samples are kept in the .blend.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import bpy  # noqa: E402
from _modelling import (  # noqa: E402
    add_camera,
    add_note,
    add_object,
    add_point_light,
    empty_file,
    new_mesh,
    rounded_box,
)
from _spectral import plastic, set_constant, set_file, set_lamp, set_library, use_dichromatic, write_sample  # noqa: E402
from make_cups import red_cup  # noqa: E402

import spectral_core as core  # noqa: E402

LAMP = "D65"
FIRST_PAINT = "munsell light bluish green"
SECOND_PAINT = "metameric_paint.csv"
BANDS_NM = (448.0, 537.0, 612.0)
BAND_WIDTH_NM = 17.0
FLOOR = 0.045

ROWS = (
    ("dark skin", "light skin", "blue sky", "foliage", "blue flower", "bluish green"),
    ("orange", "purplish blue", "moderate red", "purple", "yellow green", "orange yellow"),
    ("blue", "green", "red", "yellow", "magenta", "cyan"),
    ("white 9.5", "neutral 8", "neutral 6.5", "neutral 5", "neutral 3.5", "black 2"),
)
PITCH, PATCH = 0.046, 0.040
MUG_SCALE = 0.72

NOTE = """
COLOUR BOOTH

A viewing booth with a ColorChecker (24 measured reflectances) and two teal paints, each on
a tile and on a mug. Under daylight the paints are the same colour; under most other lamps
they part, although nothing of them has changed: they are metamers.

All four objects of the ceiling lamp share one light. The picture is adapted to that light
(the adopted white is "Light"), as your eyes would be in the booth.

Render it with F12. Then try:

  * Light tab: change Lamp from D65 to A (a bulb) or FL11 (a shop's fluorescent tube) and
    render again: the greys of the chart stay grey, the two paints do not.
  * Relight the finished picture instead, without rendering again.
  * Render tab: the 10 degree observer: the pair matches for the 2 degree observer only.
  * Render tab: Adaptation None: the colour of the lamp itself.

The reflection models are those of Tominaga 1996 (Type I).
"""


def metameric_paint() -> core.Spectrum:
    """Compute the paint whose colour under D65 is that of the first."""
    wavelengths = core.REFERENCE_WAVELENGTHS_NM
    weights = core.tristimulus_weights(
        core.illuminant(LAMP), core.observer("cie_1931_2"), core.wavelength_grid("exact")
    )
    bands = np.exp(-0.5 * ((wavelengths - np.array(BANDS_NM)[:, None]) / BAND_WIDTH_NM) ** 2)
    wanted = (core.reflectance(FIRST_PAINT).at(wavelengths) - FLOOR) @ weights
    amounts = np.linalg.solve((bands @ weights).T, wanted)
    return core.Spectrum(wavelengths, FLOOR + amounts @ bands, name="metameric paint")


def paint(name: str, reflectance: str, interface: float = 0.0) -> bpy.types.Material:
    """Make a matte paint of the library, or one with a gloss."""
    material = plastic(name, interface=interface, attenuation="cosine", n=40.0)
    set_library(material, "Body Reflectance", reflectance)
    return material


def add_chart(x: float, y: float, lean: float) -> None:
    """Stand the chart on the booth's floor, leaning backwards (radians)."""
    width, height, depth = 6 * PITCH + 0.012, 4 * PITCH + 0.012, 0.008
    tilt = (math.radians(90.0) - lean, 0.0, 0.0)
    board = add_object("Chart", new_mesh("Board", rounded_box(width, height, depth, 0.003)), rotation=tilt)
    board.location = (x, y, 0.5 * height * math.cos(lean) + 0.5 * depth * math.sin(lean))
    board.data.materials.append(paint("Chart frame", "black 2"))
    patch = new_mesh("Patch", rounded_box(PATCH, PATCH, 0.003, 0.001))
    for row, names in enumerate(ROWS):
        for column, name in enumerate(names):
            place = ((column - 2.5) * PITCH, (1.5 - row) * PITCH, 0.5 * depth + 0.0010)
            add_object(f"Patch {name}", patch, place, material=paint(name.capitalize(), name)).parent = board


def add_pair(x: float, y: float, lean: float) -> None:
    """Stand the two tiles edge to edge, and a mug of either paint before them."""
    size, depth = 0.120, 0.008
    tile = new_mesh("Tile", rounded_box(size, size, depth, 0.0012))
    mug = red_cup()
    mug.name = "Mug"
    height = 0.5 * size * math.cos(lean) + 0.5 * depth * math.sin(lean)
    for side, label in ((-1.0, "first"), (1.0, "second")):
        matte = plastic(f"Matte teal, {label} paint", interface=0.0, attenuation="cosine", n=40.0)
        gloss = plastic(f"Glossy teal, {label} paint", interface=1.0, attenuation="cosine", n=40.0)
        for material in (matte, gloss):
            if label == "first":
                set_library(material, "Body Reflectance", FIRST_PAINT)
            else:
                set_file(material, "Body Reflectance", HERE / SECOND_PAINT)
        tilt = (math.radians(90.0) - lean, 0.0, 0.0)
        add_object(f"Tile, {label} paint", tile, (x + 0.5 * side * size, y, height), tilt, matte)
        turn = math.radians(-28.0 if side > 0.0 else 208.0)
        mug_of_paint = add_object(f"Mug, {label} paint", mug, (x + 0.046 * side, y - 0.100, 0.0), (0, 0, turn), gloss)
        mug_of_paint.scale = (MUG_SCALE,) * 3


def add_booth(width: float, depth: float, height: float) -> None:
    """Build the booth of five boards, open to the front (-y)."""
    grey = plastic("Booth grey", interface=0.0, attenuation="cosine", n=40.0)
    set_constant(grey, "Body Reflectance", 0.42)
    thick = 0.02
    sunk = 0.5 * height - 0.5 * thick  # the walls stand in the floor, so that no rounded edge leaves a gap
    boards = {
        "Floor": ((width + 2 * thick, depth + 2 * thick, thick), (0.0, 0.0, -0.5 * thick)),
        "Back": ((width + thick, thick, height), (0.0, 0.5 * (depth + thick), sunk)),
        "Left wall": ((thick, depth + thick, height), (-0.5 * (width + thick), 0.0, sunk)),
        "Right wall": ((thick, depth + thick, height), (0.5 * (width + thick), 0.0, sunk)),
    }
    for name, (size, place) in boards.items():
        add_object(name, new_mesh(name, rounded_box(*size, 0.002)), place, material=grey)


def build() -> None:
    """Build the scene in the current Blender; the add-on is registered."""
    scene = empty_file()
    scene.name = "Colour booth"
    add_booth(0.86, 0.50, 0.56)
    add_chart(-0.135, 0.040, math.radians(22.0))
    add_pair(0.175, 0.070, math.radians(22.0))
    lamp = add_point_light("Ceiling lamp, middle", (0.0, -0.22, 0.60), 6.8, 0.05)
    lamp.data.name = "Ceiling lamp"
    add_object("Ceiling lamp, left", lamp.data, (-0.30, -0.22, 0.60))
    add_object("Ceiling lamp, right", lamp.data, (0.30, -0.22, 0.60))
    add_object("Ceiling lamp, front", lamp.data, (0.0, -0.80, 0.56))
    set_lamp(lamp, LAMP)
    add_camera("Camera", (-0.10, -1.28, 0.36), (0.006, 0.0, 0.098), focal_mm=76.0)
    use_dichromatic(scene, adopted_white=LAMP)
    scene.dichromatic.white_source = "LIGHT"
    scene.dichromatic.white_light = lamp.data
    add_note("About the booth", NOTE)


if __name__ == "__main__":
    core.write_spectrum(HERE / SECOND_PAINT, metameric_paint())
    write_sample(HERE / "colour_booth.blend", build, sys.argv[1:])
