"""Blender's Image Texture node as a source of reflectances: its image, and where on the surface it is read.

The coordinates may come from UV maps, or from the object's own space, through Mapping nodes with constant values: what
is an affine function of numbers that a mesh's corners have.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mathutils
import numpy as np
from numpy.typing import NDArray

from .._core import core
from ..image_reading import image_problem, texture_of
from .links import Origin, origin_of

__all__ = [
    "IMAGE_NODE",
    "Coordinates",
    "Layout",
    "interpolation_note",
    "layout_of",
    "mapping_matrix",
    "read_texture",
    "texture_problem",
]

IMAGE_NODE = "ShaderNodeTexImage"

_EXTENSIONS = {"REPEAT": "repeat", "EXTEND": "extend", "CLIP": "clip", "MIRROR": "mirror"}
_INTERPOLATIONS = {"Linear": "linear", "Closest": "closest"}
_LONGEST_MAPPING = 16  # Mapping nodes in a row; more is taken for a cycle


@dataclass(frozen=True, slots=True)
class Coordinates:
    """Which numbers of a mesh's corners place the images of a material.

    Attributes
    ----------
    kind : str
        "UV", "GENERATED" (0 to 1 over the mesh's bounding box) or "OBJECT" (the object's own space, metres).
    uv_map : str
        Name of the UV map; empty for the one that is active for rendering.
    matrix : tuple of tuple of float, shape (2, 4)
        From (x, y, z, 1) to texture coordinates, where they do not come from a UV map.
    """

    kind: str = "UV"
    uv_map: str = ""
    matrix: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Layout:
    """How an image lies on surfaces; two images of the same size and layout cover each other pixel by pixel.

    Attributes
    ----------
    coordinates : Coordinates
        What its coordinates are made from.
    extension, interpolation, transform
        As for the core's ``ImageTexture``.
    """

    coordinates: Coordinates
    extension: str
    interpolation: str
    transform: tuple[tuple[float, ...], ...]


def texture_problem(origin: Origin) -> str:
    """Say why an Image Texture node cannot be read; an empty string when it can; cheap enough for each redraw.

    Parameters
    ----------
    origin : Origin
        An output of the node.

    Returns
    -------
    str
        The reason.
    """
    node = origin.node
    problem = image_problem(node.image)
    if problem:
        return f"linked to '{node.name}', {problem}"
    if node.projection != "FLAT":
        return f"linked to '{node.name}', whose projection is {node.projection.title()}; only Flat is read"
    try:
        _placement(node, origin.groups)
    except core.SceneError as error:
        return f"linked to '{node.name}', {error}"
    return ""


def interpolation_note(node: Any) -> str:
    """Say that an interpolation is replaced by another; an empty string where it is not."""
    kind = node.interpolation
    return "" if kind in _INTERPOLATIONS else f"the {kind.lower()} interpolation of '{node.name}' is read as linear"


def read_texture(origin: Origin, channel: str, pictures: str) -> tuple[core.ImageTexture, Coordinates]:
    """Read an Image Texture node without a :func:`texture_problem`.

    Parameters
    ----------
    origin : Origin
        An output of the node.
    channel : str
        "colour", or as one number "mask" or "alpha".
    pictures : str
        How fresh the pixels must be, see ``image_reading.PICTURES``.

    Returns
    -------
    tuple of (ImageTexture, Coordinates)
        The texture, and what its coordinates are made from.

    Raises
    ------
    DichromaticError
        If the image has no pixels, or one is invalid.
    """
    node = origin.node
    layout = layout_of(origin)
    texture = texture_of(
        node.image,
        channel,
        layout.extension,
        layout.interpolation,
        layout.transform,
        straight=node.outputs["Alpha"].is_linked,
        pictures=pictures,
    )
    return texture, layout.coordinates


def layout_of(origin: Origin) -> Layout:
    """Say how an Image Texture node without a :func:`texture_problem` lays its image on surfaces."""
    node = origin.node
    coordinates, matrix = _placement(node, origin.groups)
    if coordinates.kind == "UV":
        transform = matrix[:2][:, [0, 1, 3]]
    else:
        coordinates = Coordinates(coordinates.kind, matrix=tuple(tuple(row) for row in matrix[:2].tolist()))
        transform = np.eye(2, 3)
    return Layout(
        coordinates,
        _EXTENSIONS[node.extension],
        _INTERPOLATIONS.get(node.interpolation, "linear"),
        tuple(tuple(row) for row in transform.tolist()),
    )


def _placement(node: Any, groups: tuple[Any, ...]) -> tuple[Coordinates, NDArray[np.float64]]:
    """Follow the Vector input: where the coordinates come from, and the affine map (4, 4) that they go through."""
    matrix = _texture_mapping(node)
    origin = origin_of(node.inputs["Vector"], groups)
    if origin is not None and origin.is_unlinked and origin.node == node:
        return Coordinates(), matrix
    for _ in range(_LONGEST_MAPPING):
        if origin is None:
            raise core.SceneError("whose Vector is linked to nothing")
        if origin.is_unlinked:
            raise core.SceneError(
                f"whose coordinates end at '{origin.node.name}' with nothing linked; link a UV Map node"
            )
        if origin.node.bl_idname != "ShaderNodeMapping":
            return _source(origin), matrix
        matrix = matrix @ mapping_matrix(origin.node, origin.groups)
        origin = origin_of(origin.node.inputs["Vector"], origin.groups)
    raise core.SceneError("whose Mapping nodes form a cycle")


def _source(origin: Origin) -> Coordinates:
    node = origin.node
    kind = node.bl_idname
    if getattr(node, "from_instancer", False):
        raise core.SceneError(f"whose coordinates from the instancer ('{node.name}') are not known here")
    if kind == "ShaderNodeUVMap":
        return Coordinates(uv_map=node.uv_map)
    if kind == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY":
        return Coordinates(uv_map=node.attribute_name)
    if kind == "ShaderNodeTexCoord":
        name = origin.socket.name
        if name == "UV":
            return Coordinates()
        if name == "Generated" or (name == "Object" and node.object is None):
            return Coordinates(name.upper())
        what = f"of object '{node.object.name}'" if name == "Object" else f"'{name}'"
        raise core.SceneError(f"whose coordinates {what} are not read; use UV, Generated or Object")
    raise core.SceneError(f"whose coordinates come from '{node.name}', which is not read; use UV Map and Mapping nodes")


def mapping_matrix(node: Any, groups: tuple[Any, ...] = ()) -> NDArray[np.float64]:
    """Return the affine map of a Mapping node.

    Parameters
    ----------
    node : bpy.types.Node
        The node.
    groups : tuple of bpy.types.Node, optional
        The group nodes around it.

    Returns
    -------
    ndarray of float64, shape (4, 4)
        From the coordinates that enter to those that leave.

    Raises
    ------
    SceneError
        If one of its inputs is linked, or it maps normals; the message continues "linked to 'Image Texture', ".
    """
    values = {}
    for name in ("Location", "Rotation", "Scale"):
        socket = node.inputs.get(name)
        if socket is None or not socket.enabled:  # a direction has no location
            values[name] = (0.0, 0.0, 0.0)
            continue
        origin = origin_of(socket, groups)
        if origin is None or not origin.is_unlinked or origin.socket.type != "VECTOR":
            raise core.SceneError(f"placed by '{node.name}', whose {name} is linked; set it in the node")
        values[name] = tuple(origin.socket.default_value)
    return _affine(node.vector_type, values["Location"], values["Rotation"], values["Scale"], node.name)


def _texture_mapping(node: Any) -> NDArray[np.float64]:
    """The mapping in the node's own sidebar, which Blender keeps from its earliest versions."""
    own = node.texture_mapping
    if (own.mapping_x, own.mapping_y, own.mapping_z) != ("X", "Y", "Z") or own.use_min or own.use_max:
        raise core.SceneError("whose texture mapping in the sidebar swaps or limits axes; use a Mapping node")
    return _affine(own.vector_type, tuple(own.translation), tuple(own.rotation), tuple(own.scale), node.name)


def _affine(kind: str, location: Any, rotation: Any, scale: Any, name: str) -> NDArray[np.float64]:
    """The map (4, 4) of a Mapping node, as Cycles has it."""
    if kind == "NORMAL":
        raise core.SceneError(f"placed by '{name}' as a normal, which is for directions; use Point or Texture")
    turn = np.array(mathutils.Euler(rotation, "XYZ").to_matrix(), np.float64)
    result = np.eye(4)
    if kind == "TEXTURE":
        inverse = np.array([1.0 / part if part else 0.0 for part in scale])
        result[:3, :3] = inverse[:, None] * turn.T
        result[:3, 3] = -result[:3, :3] @ np.array(location)
        return result
    result[:3, :3] = turn * np.array(scale)
    if kind == "POINT":
        result[:3, 3] = location
    return result
