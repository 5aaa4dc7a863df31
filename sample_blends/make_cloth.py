"""Make cloth.blend: the scene of Tominaga 1996, Fig. 11, green rayon satin in two views.

Run with Blender 4.2 (every later version opens the file)::

    python sample_blends/make_cloth.py [OUT.blend]

The cloth is a sheet of triangles gathered at one corner: folds that fan out from there, lean over and die away, on slow
waves across them.
"""

from __future__ import annotations

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
    height_field,
    new_mesh,
)
from _spectral import cloth, repeated_picture, set_lamp, set_woven, use_dichromatic, write_sample  # noqa: E402

LAMP = "D65"
THREADS, PIXELS, REPEATS = 5, 12, 84  # of the weave: threads of a repeat, pixels of a thread, repeats along a side
GATHERED_AT = (-0.62, 0.58)  # metres from the middle of the cloth

NOTE = """
GREEN SATIN                                                 Tominaga 1996, Figure 11

Draped rayon satin of many triangles. Cloth is Type II: unlike plastic, its highlight has a
colour of its own, which is neither the lamp's nor the dye's.

    Y(lambda) = f(rho) S_I(lambda) E(lambda) + cos(phi) S_B(lambda) E(lambda)  (Eq. 9)

    f(rho)  exp(-10 |rho|)   S_I, S_B  library, "satin green interface", "satin green body"
    E       D65, a single point; a second, weak one beside the camera opens the shadows

Two cameras look at the cloth from directions at right angles, as in the paper: "Along the
folds" in frame 1 and "Across the folds" in frame 2. The threads are a small picture, packed
into the file, that varies both spectra between the gaps and the crowns of the weave.

Render it with F12. Then try:

  * Material tab: Interface Reflectance from its own spectrum to a neutral one (Constant
    0.5): the satin turns into green plastic.
  * Material tab: n from 10 to 4 for a duller weave, to 25 for silk.
  * Material tab: "satin red body" with "satin red interface".
"""


def drape(half: float = 0.76, count: int = 197) -> bpy.types.Mesh:
    """Make the cloth, `count` vertices a side."""
    line = np.linspace(-half, half, count)
    x, y = np.meshgrid(line, line)
    away_x, away_y = x - GATHERED_AT[0], y - GATHERED_AT[1]
    distance = np.hypot(away_x, away_y)
    direction = np.arctan2(away_y, away_x)
    # Folds fan out from where the cloth is gathered; they wander with the distance, and each leans to one side.
    wander = 0.17 * np.sin(5.1 * distance + 0.6) + 0.05 * np.sin(9.0 * distance - 2.2 * direction)
    phase = 30.0 * (direction + wander * (0.35 + 0.5 * distance))
    phase += 0.8 * np.sin(0.5 * phase + 1.3) + 0.30 * np.sin(phase)
    reach = distance / (0.35 + distance)
    folds = 0.046 * reach * (0.5 + 0.5 * np.cos(phase)) ** 1.15
    folds *= 0.62 + 0.38 * np.sin(5.2 * x - 3.4 * y + 0.9 * np.sin(4.0 * y))
    waves = 0.034 * np.sin(3.1 * x + 4.3 * y + 0.7) + 0.012 * np.sin(8.3 * y - 5.1 * x + 2.0 * np.sin(3.0 * x))
    mesh = new_mesh("Cloth", height_field(line, line, folds + waves))
    layer = mesh.uv_layers.new(name="Weave")
    for corner, loop in zip(layer.uv, mesh.loops, strict=True):
        place = mesh.vertices[loop.vertex_index].co
        corner.vector = ((place.x + half) / (2.0 * half), (place.y + half) / (2.0 * half))
    return mesh


def satin_weave() -> bpy.types.Image:
    """Draw one repeat of a five-thread satin: 0 in the gaps between threads, 1 on their crowns; packed into the file.

    In satin each warp thread floats over four wefts and dips under the fifth, and the dips are spread so that no two
    touch (step 2 of 5), which is why satin shines.
    """
    side = THREADS * PIXELS
    row, column = np.mgrid[0:side, 0:side] + 0.5
    warp, weft = (column / PIXELS).astype(int), (row / PIXELS).astype(int)
    across, along = column / PIXELS - warp - 0.5, row / PIXELS - weft - 0.5
    is_under = (weft - 2 * warp) % THREADS == 0
    of_warp, of_weft = 1.0 - (2.0 * across) ** 4, 1.0 - (2.0 * along) ** 4
    # A float bends down where its thread dips.
    nearest = np.minimum((weft - 2 * warp) % THREADS, (2 * warp - weft) % THREADS)
    bend = np.where(nearest == 1, 0.85, 1.0)
    value = np.where(is_under, 0.45 * of_weft, bend * of_warp)
    image = bpy.data.images.new("satin weave", side, side)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((side, side, 4), np.float32)
    pixels[..., :3] = value[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


def build() -> None:
    """Build the scene in the current Blender; the add-on is registered."""
    scene = empty_file()
    scene.name = "Cloth"
    satin = cloth("Green satin", attenuation="exponential", n=10.0)
    weave = repeated_picture(satin, satin_weave(), "Weave", REPEATS)
    set_woven(satin, "Body Reflectance", "satin green body", (0.80, 1.05), weave)
    set_woven(satin, "Interface Reflectance", "satin green interface", (0.40, 1.15), weave)
    add_object("Cloth", drape(), material=satin)
    views = [
        add_camera("Along the folds", (0.35, -0.84, 0.64), (0.0, -0.015, 0.0), focal_mm=58.0),
        add_camera("Across the folds", (0.84, 0.35, 0.64), (-0.015, 0.0, 0.0), focal_mm=58.0),
    ]
    for frame, view in enumerate(views, 1):
        scene.timeline_markers.new(view.name, frame=frame).camera = view
    scene.frame_start, scene.frame_end = 1, len(views)
    lamps = [
        add_point_light("Key", (-0.24, 0.76, 0.92), 52.0, 0.02),
        add_point_light("Fill", (-0.30, -0.70, 1.00), 6.0, 0.20),
    ]
    for lamp in lamps:
        set_lamp(lamp, LAMP)
    use_dichromatic(scene, adopted_white=LAMP)
    add_note("About the cloth", NOTE)


if __name__ == "__main__":
    write_sample(HERE / "cloth.blend", build, sys.argv[1:])
