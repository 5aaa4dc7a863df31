"""From a Blender material to a material of the core: what its nodes say, or the best that can be made of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from .._core import core
from ..compat import node_tree_of
from ..names import METAL_NODE, SPECTRUM_MIX_NODE, SPECTRUM_NODE, SURFACE_NODES
from ..spectrum_store import stored_problem
from .closures import Glow
from .curve import curve_problem
from .fallback import ForeignReading, read_foreign_surface, read_viewport_colour
from .images import Coordinates
from .imported import record_problem, spectrum_problem
from .inputs import InputReader
from .links import Origin, origin_of
from .surfaces import read_surface_node

__all__ = ["MaterialReading", "is_ours", "link_problems", "read_foreign", "read_material", "surface_origin"]

DEEPEST_SUM = 8  # Add Shader nodes in a row; more are taken for foreign
NEUTRAL_GREY = 0.8  # what Blender gives to a surface without a material


@dataclass(frozen=True, slots=True)
class MaterialReading:
    """What was read from one Blender material.

    Attributes
    ----------
    material : Material
        Type I, II or III of the core.
    notes : tuple of str
        What was approximated, for the render statistics; empty where the nodes were ours and their images are read as
        Blender reads them.
    glow : Glow or None
        The light that the surface gives.
    is_invisible : bool
        Whether nothing is to be seen of a surface with this material.
    coordinates : Coordinates or None
        What the material's images are placed by; None without images.
    """

    material: core.Material
    notes: tuple[str, ...] = ()
    glow: Glow | None = None
    is_invisible: bool = False
    coordinates: Coordinates | None = None


def read_material(material: Any, pictures: str = "read") -> MaterialReading:
    """Read a Blender material.

    Parameters
    ----------
    material : bpy.types.Material or None
        Original or evaluated; None stands for an empty material slot.
    pictures : str
        How fresh the pixels of its images must be, see ``image_reading.PICTURES``.

    Returns
    -------
    MaterialReading
        The material of the core, and notes on what was approximated.

    Raises
    ------
    DichromaticError
        If one of our nodes cannot be read; the message names the node, the material and the reason.
    """
    if material is None:
        grey = core.Spectrum.constant(NEUTRAL_GREY, name="neutral grey")
        matte = core.TypeI(body_reflectance=grey, interface_reflectance=0.0, attenuation="cosine", n=1.0)
        return MaterialReading(matte, ("surfaces without a material are matte grey (0.8)",))
    tree = node_tree_of(material)
    if tree is None:
        return _of_foreign(read_viewport_colour(material, "it has no nodes"))
    origin = surface_origin(tree)
    if origin is not None and not origin.is_unlinked and origin.node.bl_idname in SURFACE_NODES:
        reader = InputReader(material.name, pictures)
        made = read_surface_node(origin, reader)
        notes = tuple(f"material '{material.name}': {note}" for note in reader.notes)
        return MaterialReading(made, notes, coordinates=reader.coordinates)
    return _of_foreign(read_foreign(material, pictures))


def is_ours(material: Any) -> bool:
    """Whether a material is one surface node of ours, or that with light added; also where it cannot be read.

    Parameters
    ----------
    material : bpy.types.Material
        Any material.

    Returns
    -------
    bool
        The answer.

    Raises
    ------
    None.
    """
    tree = node_tree_of(material)
    if tree is None:
        return False
    try:
        kinds = _added_kinds(surface_origin(tree))
    except core.DichromaticError:
        return True
    ours = [kind for kind in kinds if kind in SURFACE_NODES]
    return len(ours) == 1 and all(kind == "ShaderNodeEmission" for kind in kinds if kind not in ours)


def _added_kinds(origin: Origin | None, depth: int = 0) -> list[str]:
    """Return the types of the shaders that Add Shader nodes bring together; cheap enough for each redraw."""
    if origin is None or origin.is_unlinked or depth > DEEPEST_SUM:
        return []
    if origin.node.bl_idname != "ShaderNodeAddShader":
        return [origin.node.bl_idname]
    return [kind for item in origin.node.inputs for kind in _added_kinds(origin_of(item, origin.groups), depth + 1)]


def read_foreign(material: Any, pictures: str = "read") -> ForeignReading:
    """Read a material whose Surface is not simply one of our nodes, with the parts that a conversion needs.

    Parameters
    ----------
    material : bpy.types.Material
        With a node tree.
    pictures : str
        As for :func:`read_material`.

    Returns
    -------
    ForeignReading
        The material, its light, and what was approximated.

    Raises
    ------
    DichromaticError
        If one of our nodes among the shaders cannot be read, or the links form a cycle.
    """
    tree = material.node_tree
    origin, output = surface_origin(tree), tree.get_output_node("ALL")
    if origin is None or origin.is_unlinked:
        if output is not None and output.inputs["Volume"].is_linked:
            return read_viewport_colour(material, "a volume is not rendered: left out", is_invisible=True)
        return read_viewport_colour(material, "nothing is linked to its Surface output")
    reading = read_foreign_surface(material, origin, InputReader(material.name, pictures))
    ignored = [name for name in ("Volume", "Displacement") if output.inputs[name].is_linked]
    notes = tuple(f"material '{material.name}': its {name.lower()} is not rendered" for name in ignored)
    return replace(reading, notes=(*reading.notes, *notes))


def _of_foreign(read: ForeignReading) -> MaterialReading:
    return MaterialReading(read.joined.material, read.notes, read.joined.glow, read.is_invisible, read.coordinates)


def surface_origin(tree: Any) -> Origin | None:
    """Find the shader that is linked to the Surface of a tree's active output for all engines.

    Parameters
    ----------
    tree : bpy.types.ShaderNodeTree
        A material's node tree.

    Returns
    -------
    Origin or None
        None when there is no output node, or its chain of links leads to nothing.

    Raises
    ------
    SceneError
        If the links form a cycle.
    """
    output = tree.get_output_node("ALL")
    return None if output is None else origin_of(output.inputs["Surface"])


def link_problems(node: Any) -> list[str]:
    """List why inputs of one of our nodes cannot be read, for its drawing; cheap enough for each redraw.

    Parameters
    ----------
    node : bpy.types.Node
        A surface or Spectrum node.

    Returns
    -------
    list of str
        One line a problem; empty when all is well. Inputs that come from outside a user group are not judged here,
        since one group may be used in several places.

    Raises
    ------
    None.
    """
    reader = InputReader()
    problems = []
    for socket in node.inputs:
        if socket.hide or not socket.is_linked:
            continue
        try:
            origin = origin_of(socket)
        except core.SceneError as error:
            problems.append(str(error))
            continue
        if origin is not None and origin.node.type == "GROUP_INPUT":
            continue
        judge = reader.spectrum_problem if socket.type == "RGBA" else reader.number_problem
        if node.bl_idname == SPECTRUM_MIX_NODE and socket.name == "Factor":
            judge = reader.mask_problem
        problem = judge(origin)
        if problem:
            problems.append(f"{socket.name}: {problem}")
    if node.bl_idname == SPECTRUM_NODE:
        problems += _source_problems(node)
    elif node.node_tree is None:
        problems.append("the hidden node group is missing; add the node anew")
    elif node.bl_idname == METAL_NODE:
        problems += _metal_problems(node)
    return problems


def _metal_problems(node: Any) -> list[str]:
    if node.source == "IMPORTED":
        problem = record_problem(node)
        return [problem] if problem else []
    return [] if node.metal in core.metal_names() else [f"the library has no metal '{node.metal}'"]


def _source_problems(node: Any) -> list[str]:
    if node.source == "STORED":
        problem = spectrum_problem(node)
        return [problem] if problem else []
    if node.source == "CURVE":
        problem = curve_problem(node)
        return [problem] if problem else []
    if node.source == "FILE":
        problem = stored_problem(node, node.filepath)
        return [problem] if problem else []
    known = node.library_name in core.reflectance_names() or node.library_name in core.illuminant_names()
    if node.source == "LIBRARY" and not known:
        return [f"the library has no spectrum '{node.library_name}'"]
    if node.source == "TEMPERATURE" and node.radiator == "DAYLIGHT" and node.temperature < 4000.0:
        return ["daylight is defined from 4000 K on"]
    return []
