"""Make cups.blend: the scene of Tominaga 1996, Fig. 10, a blue and a red plastic cup in the light of a projector lamp.

Run with Blender 4.2 (every later version opens the file)::

    python sample_blends/make_cups.py [OUT.blend]

Both cups are turned from cones, spheres and cylinders, with an even wall, a rounded rim, a foot and a swept handle.
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
    Part,
    add_camera,
    add_note,
    add_object,
    add_point_light,
    add_spot_light,
    empty_file,
    extruded_mesh,
    join_parts,
    new_mesh,
    parallel,
    rounded,
    swept_tube,
    turned_body,
)
from _spectral import plastic, set_constant, set_lamp, set_library, use_dichromatic, write_sample  # noqa: E402

LAMP = "projector-halogen"
WALL = 0.0034
JOINT = 0.0018  # how deep the handle's ends lie in the wall

Corner = tuple[float, float, float]

NOTE = """
TWO PLASTIC CUPS                                            Tominaga 1996, Figure 10

A blue and a red cup of plastic (Type I, an inhomogeneous dielectric whose highlight has
the colour of the lamp), built from cones, spheres and cylinders:

    Y(lambda) = f(rho) S_I E(lambda) + cos(phi) S_B(lambda) E(lambda)        (Eq. 8)

    f(rho)  cos(rho)^11      S_I  5, relative to a white matte surface, as in the paper
    S_B     library, "plastic blue", "plastic red"   E  a tungsten-halogen projector lamp

The key light is a single point, as in the paper. A weaker lamp from the right, one beside
the camera and a spot on the backdrop, all with the same spectrum, stand in for the light
that a studio's walls would throw into the shadows: this renderer has direct light only.
The picture is adapted to the lamp (Bradford), so that the grey ground looks grey.

Render it with F12. Then try:

  * Material tab, red cup: n from 11 to 60 gives a harder gloss; S_I to 1 a satin one;
    Exponential with n = 10 is the curve the paper fitted to measured plastic.
  * Material tab, body spectrum: another name of the library, or a file of your own.
  * Light tab: a fluorescent lamp (FL2, FL11) in place of the projector lamp.
  * Render tab: adaptation None shows how yellow the lamp is; the 10 degree observer;
    a smaller wavelength grid, and what it changes.
"""


def cup_body(wall: list[Corner], segments: int = 128) -> Part:
    """Turn a cup from the corners of its outer wall, foot joint first, rim last."""
    foot, joint = wall[0][:2]
    inside = parallel(wall, WALL)[::-1]
    rim_radius = 0.485 * WALL
    profile = [
        (0.0, 0.0024, 0.0),
        (foot - 0.0045, 0.0024, 0.0008),
        (foot - 0.0035, 0.0, 0.0007),
        (foot - 0.0004, 0.0, 0.0008),
        (foot, joint, 0.0010),
        *wall[1:-1],
        (*wall[-1][:2], rim_radius),
        (*inside[0][:2], rim_radius),
        *inside[1:-1],
        (*inside[-1][:2], 0.0100),
        (0.0, inside[-1][1], 0.0),
    ]
    return turned_body(rounded(profile), segments)


def cup_handle(corners: list[Corner]) -> Part:
    """Handle along a path in the (x, z) plane, widened where it meets the wall."""
    path = rounded(corners).resampled(72).smoothed(34)
    lengths = path.lengths()
    to_wall = np.minimum(lengths, lengths[-1] - lengths) - 0.7 * JOINT
    flare = 0.0022 * np.exp(-np.clip(to_wall, 0.0, None) / 0.0034)
    return swept_tube(path, 0.0056 + flare, 0.0033 + flare, segments=32, squareness=2.4)


def blue_cup() -> bpy.types.Mesh:
    """Make a cone above a sphere, closing towards the rim."""
    wall = [(0.0245, 0.0040, 0.0), (0.0500, 0.0215, 0.0300), (0.0372, 0.0960, 0.0)]

    def radius(z: float) -> float:
        return 0.0500 - (z - 0.0215) / 0.0745 * 0.0128

    handle = [
        (radius(0.0752) - JOINT, 0.0752, 0.0),
        (0.0745, 0.0790, 0.0205),
        (0.0750, 0.0270, 0.0205),
        (0.0478 - JOINT, 0.0330, 0.0),
    ]
    return new_mesh("Blue cup", join_parts([cup_body(wall), cup_handle(handle)]))


def red_cup() -> bpy.types.Mesh:
    """Make a cone that narrows a little towards the rim, its bottom edge a quarter round."""
    wall = [(0.0260, 0.0040, 0.0), (0.0425, 0.0040, 0.0105), (0.0368, 0.0940, 0.0)]

    def radius(z: float) -> float:
        return 0.0425 - (z - 0.0040) / 0.0900 * 0.0057

    handle = [
        (radius(0.0760) - JOINT, 0.0760, 0.0),
        (0.0700, 0.0775, 0.0215),
        (0.0690, 0.0225, 0.0215),
        (radius(0.0285) - JOINT, 0.0285, 0.0),
    ]
    return new_mesh("Red cup", join_parts([cup_body(wall), cup_handle(handle)]))


def build() -> None:
    """Build the scene in the current Blender; the add-on is registered."""
    scene = empty_file()
    scene.name = "Cups"
    blue = plastic("Blue plastic", interface=5.0, attenuation="cosine", n=11.0)
    set_library(blue, "Body Reflectance", "plastic blue")
    red = plastic("Red plastic", interface=5.0, attenuation="cosine", n=11.0)
    set_library(red, "Body Reflectance", "plastic red")
    grey = plastic("Matte grey", interface=0.0, attenuation="cosine", n=11.0)
    set_constant(grey, "Body Reflectance", 0.70)

    add_object("Blue cup", blue_cup(), (-0.062, 0.040, 0.0), (0.0, 0.0, math.radians(188.0)), blue)
    add_object("Red cup", red_cup(), (0.056, -0.022, 0.0), (0.0, 0.0, math.radians(-28.0)), red)
    sweep = rounded([(-1.6, 0.0, 0.0), (0.9, 0.0, 0.6), (0.9, 2.0, 0.0)], tolerance=5.0e-5)
    add_object("Backdrop", new_mesh("Backdrop", extruded_mesh(sweep, 2.0)), material=grey)

    add_camera("Camera", (0.0, -0.80, 0.25), (0.004, 0.0, 0.043), focal_mm=85.0)
    lamps = [
        add_point_light("Key", (-1.05, -0.85, 1.20), 140.0, 0.05),
        add_point_light("Fill from the right", (1.05, -0.75, 1.05), 30.0, 0.30),
        add_point_light("Fill beside the camera", (0.03, -0.82, 0.29), 3.5, 0.02),
        add_spot_light("Backdrop light", (0.0, 0.55, 1.2), (0.0, 0.66, 0.0), 14.0, math.radians(60.0), 1.0, 0.10),
    ]
    for lamp in lamps:
        set_lamp(lamp, LAMP)
    use_dichromatic(scene, adopted_white=LAMP)
    add_note("About the cups", NOTE)


if __name__ == "__main__":
    write_sample(HERE / "cups.blend", build, sys.argv[1:])
