"""From a Blender material to a material of the core: what its nodes say, or the best that can be made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .._core import core
from ..compat import node_tree_of
from ..names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE, SURFACE_NODES
from ..spectrum_store import stored_problem
from .fallback import dominant_shader, read_foreign_shader, read_viewport_colour
from .imported import imported_metal, record_problem, spectrum_problem
from .inputs import InputReader
from .links import Origin, origin_of

__all__ = ["MaterialReading", "link_problems", "read_material", "surface_origin"]

NEUTRAL_GREY = 0.8  # what Blender gives to a surface without a material


@dataclass(frozen=True, slots=True)
class MaterialReading:
    """What was read from one Blender material.

    Attributes
    ----------
    material : Material
        Type I, II or III of the core.
    notes : tuple of str
        What was approximated, for the render statistics; empty where the nodes were ours.
    """

    material: core.Material
    notes: tuple[str, ...] = ()


def read_material(material: Any) -> MaterialReading:
    """Read a Blender material.

    Parameters
    ----------
    material : bpy.types.Material or None
        Original or evaluated; None stands for an empty material slot.

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
    reader = InputReader(material.name)
    tree = node_tree_of(material)
    if tree is None:
        return _noted(read_viewport_colour(material, "it has no nodes"))
    origin, left_out = dominant_shader(surface_origin(tree), reader)
    notes = (f"material '{material.name}': {left_out}",) if left_out else ()
    if origin is None or origin.is_unlinked:
        return _noted(read_viewport_colour(material, "nothing is linked to its Surface output"), *notes)
    if origin.node.bl_idname in SURFACE_NODES:
        return MaterialReading(_read_surface_node(origin, reader), notes)
    return _noted(read_foreign_shader(material, origin, reader), *notes)


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
    if node.source == "FILE":
        problem = stored_problem(node, node.filepath)
        return [problem] if problem else []
    known = node.library_name in core.reflectance_names() or node.library_name in core.illuminant_names()
    if node.source == "LIBRARY" and not known:
        return [f"the library has no spectrum '{node.library_name}'"]
    if node.source == "TEMPERATURE" and node.radiator == "DAYLIGHT" and node.temperature < 4000.0:
        return ["daylight is defined from 4000 K on"]
    return []


def _noted(read: tuple[core.Material, str], *earlier: str) -> MaterialReading:
    material, note = read
    return MaterialReading(material, (*earlier, note))


def _read_surface_node(origin: Origin, reader: InputReader) -> core.Material:
    node, groups = origin.node, origin.groups
    try:
        if node.bl_idname == PLASTIC_NODE:
            return core.TypeI(
                body_reflectance=reader.spectrum(node, "Body Reflectance", groups),
                interface_reflectance=reader.number(node, "Interface Reflectance", groups),
                attenuation=node.attenuation,
                n=reader.number(node, "n", groups),
                mirror=reader.number(node, "Mirror", groups),
                energy_conserving=node.energy_conserving,
            )
        if node.bl_idname == CLOTH_NODE:
            return core.TypeII(
                body_reflectance=reader.spectrum(node, "Body Reflectance", groups),
                interface_reflectance=reader.spectrum(node, "Interface Reflectance", groups),
                attenuation=node.attenuation,
                n=reader.number(node, "n", groups),
                mirror=reader.number(node, "Mirror", groups),
                energy_conserving=node.energy_conserving,
            )
        return _read_metal(origin, reader)
    except core.SceneError:
        raise  # names the node already
    except core.DichromaticError as error:
        raise core.SceneError(f"{reader.place(node)}: {error}") from error


def _read_metal(origin: Origin, reader: InputReader) -> core.TypeIII:
    node, groups = origin.node, origin.groups
    numbers: dict[str, Any] = {
        "beta": reader.number(node, "beta", groups),
        "beta_across": reader.number(node, "beta across", groups) if node.anisotropic else None,
        "incidence": node.incidence,
        "energy_conserving": node.energy_conserving,
        "mirror": reader.number(node, "Mirror", groups),
    }
    if node.source == "IMPORTED":
        metal = imported_metal(node)
        return core.TypeIII(metal.normal_reflectance, metal.mean_reflectance, **numbers)
    return core.TypeIII.from_optical_constants(core.optical_constants(node.metal), **numbers)
