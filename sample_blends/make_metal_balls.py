"""Make metal_balls.blend: the scene of Tominaga 1996, Fig. 12, a copper and a brass ball with a spun finish.

Run with Blender 4.2 (every later version opens the file)::

    python sample_blends/make_metal_balls.py [OUT.blend]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import bpy  # noqa: E402
from _modelling import (  # noqa: E402
    add_camera,
    add_grey_world,
    add_note,
    add_object,
    add_sun,
    add_turned_uv,
    empty_file,
    extruded_mesh,
    new_mesh,
    rounded,
    rounded_box,
    sphere,
)
from _spectral import metal, plastic, set_constant, set_lamp, use_dichromatic, write_sample  # noqa: E402

LAMP = "D65"
RADIUS = 0.050
SUN_ANGLE = math.radians(7.0)
# White cards beside the camera's view, which the balls mirror: name, place, size and turn about z in degrees.
CARDS = (
    ("Card on the left", (-0.40, -0.10, 0.24), (0.004, 0.30, 0.40), 16.0),
    ("Card on the right", (0.44, -0.06, 0.24), (0.004, 0.22, 0.40), -12.0),
)

NOTE = """
METAL BALLS                                                 Tominaga 1996, Figure 12

A copper ball (left) and a brass ball (right). Metals are Type III: their colour is in the
interface reflection, and turns white towards grazing incidence.

    Y(lambda) = D(alpha) G(N, V, L) / (N.V) S(phi, lambda) E(lambda)          (Eq. 10)

    D  Gaussian facets (Eq. 11) of 5 degrees along the spin and 18 across it: the paper adds
       an anisotropy for the spun finish without giving its formula; this one is elliptic
    G  masking and shadowing (Eq. 12)
    S  from measured n and k by Eq. 13      E  D65, from three directions

The balls also mirror each other and the ground, by the same S. The UV map named Turned runs
around the axis of spin; its U direction is the direction of the grooves.

Render it with F12. Then try:

  * Material tab: Anisotropic off shows the plain model, three small highlights a ball.
  * Material tab: another metal (gold, silver, aluminium), another beta, Mirror 0.
  * Light tab: lamp A for the key light: the metals keep their own colour apart from it.
  * Turn a ball about its own z axis: nothing changes. Tilt it: the streaks follow.
"""


def ball(
    name: str, mesh: bpy.types.Mesh, x: float, y: float, tilt: float, turn: float, material: bpy.types.Material
) -> None:
    """Add a ball on the ground, its axis of spin tilted towards the camera (degrees)."""
    add_object(name, mesh, (x, y, RADIUS), (math.radians(tilt), 0.0, math.radians(turn)), material)


def build() -> None:
    """Build the scene in the current Blender; the add-on is registered."""
    scene = empty_file()
    scene.name = "Metal balls"
    finish = {"beta": math.radians(5.0), "beta_across": math.radians(18.0), "mirror": 0.55}
    mesh = new_mesh("Ball", sphere(RADIUS, 288, 96))
    add_turned_uv(mesh)
    ball("Copper ball", mesh, -0.055, 0.0, 52.0, -14.0, metal("Spun copper", "copper", **finish))
    ball("Brass ball", mesh, 0.055, 0.014, 52.0, 18.0, metal("Spun brass", "brass-70-30", **finish))
    grey = plastic("Dark matte grey", interface=0.0, attenuation="cosine", n=11.0)
    set_constant(grey, "Body Reflectance", 0.04)
    sweep = rounded([(-3.0, 0.0, 0.0), (0.45, 0.0, 0.35), (0.45, 1.0, 0.0)], tolerance=5.0e-5)
    add_object("Backdrop", new_mesh("Backdrop", extruded_mesh(sweep, 3.0)), material=grey)
    add_grey_world(0.06)
    white = plastic("White card", interface=0.0, attenuation="cosine", n=11.0)
    set_constant(white, "Body Reflectance", 0.90)
    for name, place, size, turn in CARDS:
        card = add_object(name, new_mesh(name, rounded_box(*size, 0.001)), place, (0.0, 0.0, math.radians(turn)), white)
        card.visible_shadow = False
    add_camera("Camera", (0.0, -0.75, 0.155), (0.0, 0.0, 0.050), focal_mm=85.0)
    suns = [
        add_sun("Key", (-0.60, -0.70, 1.00), 4.2, SUN_ANGLE),
        add_sun("Right", (0.95, -0.45, 0.80), 3.0, SUN_ANGLE),
        add_sun("Back", (0.10, 0.50, 1.10), 2.6, SUN_ANGLE),
    ]
    for sun in suns:
        set_lamp(sun, LAMP)
    use_dichromatic(scene, adopted_white=LAMP)
    add_note("About the balls", NOTE)


if __name__ == "__main__":
    write_sample(HERE / "metal_balls.blend", build, sys.argv[1:])
