"""Make texture.blend: one picture, uplifted to spectra pixel by pixel, as the glaze of a mug, a tile and a bowl.

Run with Blender 4.2 (every later version opens the file)::

    python sample_blends/make_texture.py [OUT.blend]

The picture is drawn here: a frieze of 12 by 4 squares, each with a quarter circle, half circle, leaf, ring or triangle
in two of seven glaze colours. It is packed into the file.
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
    add_turned_uv,
    empty_file,
    extruded_mesh,
    join_parts,
    new_mesh,
    parallel,
    rounded,
    rounded_box,
    sphere,
    turned_body,
)
from _spectral import SURFACE, plastic, set_lamp, use_dichromatic, write_sample  # noqa: E402
from make_cups import cup_body, cup_handle  # noqa: E402

LAMP = "D65"
COLUMNS, ROWS, SIDE, FINER = 12, 4, 96, 4  # squares, pixels of a square, and samples of a pixel along each side
RADIUS, RIM, HEIGHT = 0.0440, 0.0400, 0.0960  # of the mug, which narrows a little so that its wall can shine
JOINT = 0.0018

# Glaze colours, sRGB.
IVORY, VERMILION, COBALT, SAFFRON, TEAL, INK, BLUSH = range(7)
PALETTE = ("F6ECDC", "E0402A", "1E49B0", "F4B22E", "12837C", "1B1D2A", "F2B3A0")

NOTE = """
A PICTURE AS A GLAZE                                          one image, three spectra

The mug and the tile wear one picture (Image Editor: "glaze"). Each of its pixels becomes a
reflectance: the smooth spectrum that has the pixel's colour under daylight,

    S_B(lambda) = r R(lambda) + g G(lambda) + b B(lambda)       Mallett and Yuksel, 2019

and the surface is the paper's Type I, a neutral interface over that coloured body. R, G
and B are the same at every pixel, so the picture costs three spectra and not a million,
and everything works as with plain paint: relighting, the pixel probe, metamerism maps,
spectral EXR. Under D65 the colours are those of the picture; under other lamps they are
those that such glazes would have.

How it is linked (Shader Editor, material "Printed glaze"): a standard Image Texture node
goes to Body Reflectance. On the mug a UV Map and a Mapping node wrap it around the wall;
on the tile Texture Coordinate > Generated lays the left third of it flat.

Render it with F12. Then try:

  * Image Editor, Dichromatic tab: another lamp for the kept render. A (light bulb), FL11
    (shop tubes), HP1 (sodium street light, under which the colours fall together).
  * The same tab: a metamerism map between D65 and FL11 shows where the glazes change most.
  * Image Editor: paint on the picture, or open one of your own in the Image Texture node.
  * Mapping node of the mug: another scale or rotation. Extension: Clip, Extend, Mirror.
  * Spectra of your own: put a Mix Spectra node before Body Reflectance, link a black and
    white picture to its Factor and a measured spectrum to A and to B.
"""


# ---- the picture


def linear(code: str) -> np.ndarray:
    """Linear RGB of an sRGB colour in hexadecimal digits."""
    encoded = np.array([int(code[i : i + 2], 16) for i in (0, 2, 4)]) / 255.0
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def motif(kind: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where one square, 0 to 1, shows its second colour (1), and where its third (2)."""
    corner = np.hypot(x, y)
    centre = np.hypot(x - 0.5, y - 0.5)
    if kind == "quarter":
        return (corner < 1.0) * 1
    if kind == "rings":
        return ((corner < 1.0) * 1) + ((corner < 0.64) * 1) - ((corner < 0.32) * 2)
    if kind == "leaf":
        return ((corner < 1.0) & (np.hypot(x - 1.0, y - 1.0) < 1.0)) * 1
    if kind == "half":
        return (np.hypot(x, y - 0.5) < 0.5) * 1
    if kind == "disc":
        return ((centre < 0.36) * 1) + ((centre < 0.15) * 1)
    if kind == "triangle":
        return (x + y < 1.0) * 1
    if kind == "arch":
        return ((np.hypot(x, y - 0.5) < 0.5) * 1) + ((np.hypot(x, y - 0.5) < 0.22) * 1)
    raise ValueError(f"no motif {kind!r}")


# Every square: motif, quarter turns, and three colours. Four rows, the top first; the frieze runs around the mug.
KINDS = ("quarter", "rings", "leaf", "half", "disc", "triangle", "arch")
PAIRS = (
    (IVORY, COBALT, SAFFRON),
    (VERMILION, IVORY, INK),
    (SAFFRON, INK, IVORY),
    (TEAL, IVORY, VERMILION),
    (COBALT, BLUSH, IVORY),
    (IVORY, VERMILION, COBALT),
    (INK, SAFFRON, VERMILION),
    (BLUSH, TEAL, IVORY),
    (IVORY, INK, VERMILION),
    (COBALT, SAFFRON, IVORY),
)


def frieze(seed: int) -> list[list[tuple[str, int, tuple[int, int, int]]]]:
    """Deal motifs and colours so that no neighbours share either, around the seam as well."""
    rng = np.random.default_rng(seed)
    rows: list[list[tuple[str, int, tuple[int, int, int]]]] = []
    for r in range(ROWS):
        row: list[tuple[str, int, tuple[int, int, int]]] = []
        for c in range(COLUMNS):
            near = [row[c - 1]] if c else []
            near += [rows[r - 1][c]] if r else []
            near += [row[0]] if c == COLUMNS - 1 else []
            kinds = [kind for kind in KINDS if kind not in {item[0] for item in near}]
            grounds = {item[2][0] for item in near}
            pairs = [pair for pair in PAIRS if pair[0] not in grounds]
            kind = kinds[rng.integers(len(kinds))]
            row.append((kind, int(rng.integers(4)), pairs[rng.integers(len(pairs))]))
        rows.append(row)
    return rows


def glaze_pixels() -> np.ndarray:
    """Draw the picture (H, W, 4), sRGB, row 0 at the bottom; edges are averaged in linear light."""
    steps = (np.arange(SIDE * FINER) + 0.5) / (SIDE * FINER)
    x, y = np.meshgrid(steps, steps)
    colours = np.array([linear(code) for code in PALETTE])
    fine = np.empty((ROWS * SIDE, COLUMNS * SIDE, 3))
    for r, row in enumerate(frieze(SEED)[::-1]):
        for c, (kind, turns, trio) in enumerate(row):
            index = np.rot90(motif(kind, x, y), turns)
            square = colours[np.array(trio)][index]
            square = square.reshape(SIDE, FINER, SIDE, FINER, 3).mean(axis=(1, 3))
            fine[r * SIDE : (r + 1) * SIDE, c * SIDE : (c + 1) * SIDE] = square
    encoded = np.where(fine <= 0.0031308, 12.92 * fine, 1.055 * fine ** (1.0 / 2.4) - 0.055)
    return np.concatenate([encoded, np.ones((*fine.shape[:2], 1))], axis=2).astype(np.float32)


SEED = 12


def glaze_image() -> bpy.types.Image:
    """Put the picture into the file, packed."""
    pixels = glaze_pixels()
    image = bpy.data.images.new("glaze", pixels.shape[1], pixels.shape[0])
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


# ---- things


def ceramic(name: str, mirror: float = 0.04) -> bpy.types.Material:
    """Make a glazed material: a glassy interface that mirrors its surroundings a little."""
    material = plastic(name, interface=5.0, attenuation="cosine", n=240.0)
    material.node_tree.nodes[SURFACE].inputs["Mirror"].default_value = mirror
    return material


def matte(name: str, code: str) -> bpy.types.Material:
    """Make a matte paint of an sRGB colour."""
    material = plastic(name, interface=0.0, attenuation="cosine", n=11.0)
    material.node_tree.nodes[SURFACE].inputs["Body Reflectance"].default_value = (*linear(code).tolist(), 1.0)
    return material


def coloured(name: str, code: str) -> bpy.types.Material:
    """Make a glaze of one sRGB colour."""
    material = ceramic(name)
    material.node_tree.nodes[SURFACE].inputs["Body Reflectance"].default_value = (*linear(code).tolist(), 1.0)
    return material


def printed(
    name: str, image: bpy.types.Image, source: str, location: tuple[float, ...], scale: tuple[float, ...]
) -> bpy.types.Material:
    """Make a glaze of a picture, placed by a Mapping node; `source` is a UV map, or "Generated"."""
    material = ceramic(name)
    tree = material.node_tree
    surface = tree.nodes[SURFACE]
    texture, mapping = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMapping")
    texture.image = image
    texture.location, mapping.location = (-340.0, 0.0), (-560.0, 0.0)
    mapping.inputs["Location"].default_value = location
    mapping.inputs["Scale"].default_value = scale
    if source == "Generated":
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        output = coordinates.outputs["Generated"]
    else:
        coordinates = tree.nodes.new("ShaderNodeUVMap")
        coordinates.uv_map = source
        output = coordinates.outputs["UV"]
    coordinates.location = (-780.0, 0.0)
    tree.links.new(output, mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], surface.inputs["Body Reflectance"])
    return material


def mug() -> bpy.types.Mesh:
    """Make a cylinder with a handle; slot 0 is the printed wall, slot 1 the inside, rim and foot, slot 2 the handle."""
    body = cup_body([(0.0340, 0.0038, 0.0), (RADIUS, 0.0038, 0.0085), (RIM, HEIGHT, 0.0)], 160)

    def radius_at(z: float) -> float:
        return RADIUS + (RIM - RADIUS) * (z - 0.0038) / (HEIGHT - 0.0038)

    corners = [
        (radius_at(0.0770) - JOINT, 0.0770, 0.0),
        (0.0750, 0.0785, 0.0200),
        (0.0755, 0.0230, 0.0200),
        (radius_at(0.0245) - JOINT, 0.0245, 0.0),
    ]
    mesh = new_mesh("Mug", join_parts([body, cup_handle(corners)]))
    add_turned_uv(mesh)
    faces_of_body = len(body[1])
    for number, polygon in enumerate(mesh.polygons):
        centre = polygon.center
        radius = math.hypot(centre.x, centre.y)
        on_wall = radius > radius_at(centre.z) - 0.0012 and 0.0040 < centre.z < HEIGHT - 0.0012
        polygon.material_index = 2 if number >= faces_of_body else 0 if on_wall else 1
    return mesh


def bowl() -> bpy.types.Mesh:
    """Make a shallow bowl; slot 0 is outside, slot 1 inside."""
    wall = [(0.0260, 0.0030, 0.0), (0.0480, 0.0100, 0.0240), (0.0640, 0.0460, 0.0)]
    inside = parallel(wall, 0.0036)[::-1]
    profile = [
        (0.0, 0.0016, 0.0),
        (0.0215, 0.0016, 0.0008),
        (0.0230, 0.0, 0.0007),
        (0.0256, 0.0, 0.0008),
        (0.0260, 0.0030, 0.0008),
        *wall[1:-1],
        (*wall[-1][:2], 0.00172),
        (*inside[0][:2], 0.00172),
        *inside[1:-1],
        (0.0, inside[-1][1], 0.0),
    ]
    mesh = new_mesh("Bowl", turned_body(rounded(profile), 160))
    for polygon in mesh.polygons:
        outward = polygon.normal.x * polygon.center.x + polygon.normal.y * polygon.center.y
        polygon.material_index = 0 if outward > 0.0 or polygon.normal.z < -0.1 else 1
    return mesh


def plinth(radius: float, height: float) -> Part:
    """Make a round block with softened edges."""
    profile = [(0.0, 0.0, 0.0), (radius, 0.0, 0.0012), (radius, height, 0.0026), (0.0, height, 0.0)]
    return turned_body(rounded(profile), 192)


def with_materials(item: bpy.types.Object, *materials: bpy.types.Material) -> None:
    """Give an object's mesh its materials, slot by slot."""
    for material in materials:
        item.data.materials.append(material)


def build() -> None:
    """Build the scene in the current Blender; the add-on is registered."""
    scene = empty_file()
    scene.name = "Texture"
    image = glaze_image()
    wall = (HEIGHT - 0.0015 - 0.0070) / HEIGHT  # the printed part of the mug's height
    print_on_mug = printed(
        "Printed glaze", image, "Turned", (0.0, -0.0070 / HEIGHT / wall, 0.0), (1.0, 1.0 / wall, 1.0)
    )
    print_on_tile = printed("Printed tile", image, "Generated", (0.0, 0.0, 0.0), (ROWS / COLUMNS, 1.0, 1.0))
    ivory, cobalt = coloured("Ivory glaze", PALETTE[IVORY]), coloured("Cobalt glaze", PALETTE[COBALT])
    vermilion, saffron = coloured("Vermilion glaze", PALETTE[VERMILION]), coloured("Saffron glaze", PALETTE[SAFFRON])

    with_materials(
        add_object("Mug", mug(), (0.040, -0.015, 0.036), (0.0, 0.0, math.radians(-24.0))),
        print_on_mug,
        ivory,
        vermilion,
    )
    tile = new_mesh("Tile", rounded_box(0.150, 0.150, 0.009, 0.0016))
    lean = math.radians(79.0)
    add_object("Tile", tile, (-0.083, 0.105, 0.0750), (lean, 0.0, math.radians(10.0)), print_on_tile)
    with_materials(add_object("Bowl", bowl(), (0.158, 0.045, 0.020)), cobalt, saffron)
    rose, sage = matte("Rose plaster", "D98E7E"), matte("Sage plaster", "8FA89B")
    add_object("Plinth", new_mesh("Plinth", plinth(0.074, 0.036)), (0.040, -0.015, 0.0), material=rose)
    add_object("Step", new_mesh("Step", plinth(0.090, 0.020)), (0.158, 0.045, 0.0), material=sage)
    add_object("Ball", new_mesh("Ball", sphere(0.018, 96, 48)), (-0.072, -0.060, 0.018), material=saffron)
    sweep = rounded([(-1.6, 0.0, 0.0), (0.55, 0.0, 0.30), (0.55, 2.0, 0.0)], tolerance=5.0e-5)
    add_object("Backdrop", new_mesh("Backdrop", extruded_mesh(sweep, 2.5)), material=matte("Blush paper", "E9CFC2"))

    add_camera("Camera", (0.02, -1.10, 0.235), (0.022, 0.0, 0.070), focal_mm=90.0)
    lamps = [
        (add_point_light("Key", (-0.95, -0.60, 0.95), 84.0), 0.14),
        (add_point_light("Window", (1.05, -0.85, 0.60), 11.0), 0.30),
        (add_point_light("Low strip", (-0.46, -0.66, 0.045), 4.0), 0.035),
        (add_point_light("Top", (0.15, 0.10, 1.40), 20.0), 0.45),
    ]
    for lamp, radius in lamps:
        lamp.data.shadow_soft_size = radius
        set_lamp(lamp, LAMP)
    use_dichromatic(scene, adopted_white=LAMP, samples=16)
    scene.dichromatic.max_bounces = 1  # what is mirrored in what is mirrored has a thousandth of the light
    add_note("About the glaze", NOTE)


if __name__ == "__main__":
    write_sample(HERE / "texture.blend", build, sys.argv[1:])
