"""From Blender's world to the core's: its colour or picture, its strength and its spectrum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import compat
from ._core import core
from .emission_reading import read_emission, surface_of
from .image_reading import environment_pixels, from_working, image_problem, working_pixels
from .light_colours import chosen_illuminant
from .nodes.colour_chains import ColourChains
from .nodes.images import mapping_matrix
from .nodes.links import Origin, origin_of
from .spectrum_sources import luminance, tinted_daylight

__all__ = ["read_world"]

ENVIRONMENT_NODE = "ShaderNodeTexEnvironment"
_LONGEST_MAPPING = 16  # Mapping nodes in a row; more is taken for a cycle
_ROTATION = 1e-5  # how far a matrix of float32 numbers may be from a rotation


@dataclass(frozen=True, slots=True)
class _Sky:
    """What a world's nodes give: a colour with its strength, or a spectrum, and a picture that it is multiplied by."""

    colour: tuple[float, float, float] | None
    strength: float
    illuminant: Any = None
    image: Any = None


def read_world(world: Any, notes: list[str], pictures: str = "read") -> core.World:
    """Convert a world to the core's.

    Parameters
    ----------
    world : bpy.types.World or None
        Original or evaluated.
    notes : list of str
        What is approximated is added.
    pictures : str, optional
        How fresh the pixels of its images must be, see ``image_reading.PICTURES``.

    Returns
    -------
    World
        Black where there is none.

    Raises
    ------
    SceneError
        If its illuminant cannot be had; the message names the world and the reason.
    """
    if world is None:
        return core.World()
    try:
        chosen = chosen_illuminant(world)
        sky = _read_sky(world, notes, pictures)
    except core.DichromaticError as error:
        raise core.SceneError(f"world '{world.name}': {error}") from error
    lights = bool(world.dichromatic.lights_surfaces)
    if sky.image is not None:
        illuminant, strength = chosen or core.illuminant("D65"), sky.strength
    elif sky.colour is not None:
        illuminant, strength = chosen or tinted_daylight(sky.colour), luminance(sky.colour)
    else:
        illuminant, strength = chosen or sky.illuminant, sky.strength
    if not strength > 0.0:
        return core.World(name=world.name)
    return core.World(illuminant, strength, name=world.name, lights_surfaces=lights, image=sky.image)


def _read_sky(world: Any, notes: list[str], pictures: str) -> _Sky:
    tree = compat.node_tree_of(world)
    if tree is None:
        red, green, blue = world.color
        return _Sky((red, green, blue), 1.0)
    owner = f"world '{world.name}'"
    origin = _background(surface_of(tree, "ShaderNodeOutputWorld"), owner, notes)
    if origin is not None and not origin.is_unlinked and origin.node.bl_idname == "ShaderNodeBackground":
        sky = _read_picture(origin, owner, notes, pictures)
        if sky is not None:
            return sky
    glow = read_emission(origin, owner, notes)
    if glow is None:
        return _Sky((0.0, 0.0, 0.0), 0.0)
    return _Sky(glow.colour, glow.strength, glow.illuminant)


def _background(origin: Origin | None, owner: str, notes: list[str]) -> Origin | None:
    """Step over a mixture that shows the camera another background than surfaces see: light is what counts."""
    while origin is not None and not origin.is_unlinked and origin.node.bl_idname == "ShaderNodeMixShader":
        factor = origin_of(origin.node.inputs[0], origin.groups)
        if factor is None or factor.is_unlinked or factor.node.bl_idname != "ShaderNodeLightPath":
            break
        if factor.socket.name != "Is Camera Ray":
            break
        notes.append(f"{owner}: the camera sees the background that lights the surfaces")
        origin = origin_of(origin.node.inputs[1], origin.groups)
    return origin


def _read_picture(origin: Origin, owner: str, notes: list[str], pictures: str) -> _Sky | None:
    """Read a Background whose colour comes from an Environment Texture; None for any other."""
    node, groups = origin.node, origin.groups
    found: list[tuple[Origin, tuple[int, int]]] = []

    def pixels_of(source: Origin) -> NDArray[np.float64] | None:
        if source.node.bl_idname != ENVIRONMENT_NODE or (found and found[0][0].node != source.node):
            return None
        if source.node.projection != "EQUIRECTANGULAR":
            notes.append(f"{owner}: '{source.node.name}' is no equirectangular environment: its mean is used")
            return None
        pixels = working_pixels(source.node.image, straight=False, pictures=pictures)[::-1]  # the zenith first
        found.append((source, (pixels.shape[0], pixels.shape[1])))
        return pixels.reshape(-1, 4).astype(np.float64)

    strength = ColourChains().number(node.inputs["Strength"], groups)
    picture = origin_of(node.inputs["Color"], groups)
    if picture is not None and _is_plain(picture):
        pixels = environment_pixels(picture.node.image, pictures=pictures)
        return _Sky(None, strength, image=core.EnvironmentImage(pixels, _rotation(picture, owner, notes)))
    chains = ColourChains(pixels=pixels_of)
    values = chains.values(node.inputs["Color"], groups)
    if not found:
        return None
    notes.extend(f"{owner}: {note}" for note in chains.notes)
    source, (height, width) = found[0]
    pixels = from_working(np.nan_to_num(values, posinf=0.0, neginf=0.0).astype(np.float32))
    image = core.EnvironmentImage(pixels.reshape(height, width, 3), _rotation(source, owner, notes))
    return _Sky(None, strength, image=image)


def _is_plain(origin: Origin) -> bool:
    """Whether a colour is that of a picture of all around itself, so that it need not be worked out pixel by pixel."""
    if origin.is_unlinked or origin.node.bl_idname != ENVIRONMENT_NODE or origin.socket.name != "Color":
        return False
    return origin.node.projection == "EQUIRECTANGULAR" and not image_problem(origin.node.image)


def _rotation(picture: Origin, owner: str, notes: list[str]) -> NDArray[np.float64]:
    """Follow the Vector input of an Environment Texture: the rotation of its Mapping nodes."""
    matrix = np.eye(4)
    node = picture.node
    origin = origin_of(node.inputs["Vector"], picture.groups)
    for _ in range(_LONGEST_MAPPING):
        if origin is None or origin.is_unlinked or origin.node.bl_idname != "ShaderNodeMapping":
            break
        try:
            matrix = matrix @ mapping_matrix(origin.node, origin.groups)
        except core.SceneError as error:
            notes.append(f"{owner}: '{node.name}' is {error}; it is not turned")
        origin = origin_of(origin.node.inputs["Vector"], origin.groups)
    known = origin is None or (origin.is_unlinked and origin.node == node)
    if not known and origin is not None:
        known = origin.node.bl_idname == "ShaderNodeTexCoord" and origin.socket.name == "Generated"
    if not known:
        notes.append(f"{owner}: the coordinates of '{node.name}' are not understood: directions are used")
    left, sizes, right = np.linalg.svd(matrix[:3, :3])
    turned = left @ right
    if not (np.ptp(sizes) <= _ROTATION * max(float(sizes[0]), 1e-30) and not np.abs(matrix[:3, 3]).max() > 0.0):
        notes.append(f"{owner}: of the mapping of '{node.name}', only its rotation is rendered")
    return np.asarray(turned, np.float64)
