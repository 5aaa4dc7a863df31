"""The light that the shader nodes of a lamp or a world give."""

from __future__ import annotations

from typing import Any

from .nodes.closures import Glow
from .nodes.foreign_shaders import ShaderReader
from .nodes.inputs import InputReader
from .nodes.joining import add_glows
from .nodes.links import Origin, origin_of

__all__ = ["read_emission", "surface_of"]


def surface_of(tree: Any, output_kind: str) -> Origin | None:
    """Find the shader that is linked to the Surface of a tree's active output.

    Parameters
    ----------
    tree : bpy.types.ShaderNodeTree
        The tree of a light or world.
    output_kind : str
        Type of its output node.

    Returns
    -------
    Origin or None
        None where there is no output, or its links lead to nothing.

    Raises
    ------
    SceneError
        If the links form a cycle.
    """
    outputs = [node for node in tree.nodes if node.bl_idname == output_kind]
    output = next((node for node in outputs if node.is_active_output), outputs[0] if outputs else None)
    return None if output is None else origin_of(output.inputs["Surface"])


def read_emission(origin: Origin | None, owner: str, notes: list[str]) -> Glow | None:
    """Read the light that a shader gives.

    Parameters
    ----------
    origin : Origin or None
        What is linked to the Surface output of a light or world.
    owner : str
        "light 'Key'", for the notes.
    notes : list of str
        What is approximated is added.

    Returns
    -------
    Glow or None
        All light together; None where there is none.

    Raises
    ------
    DichromaticError
        If one of our nodes in the tree cannot be read, or the links form a cycle.
    """
    shaders = ShaderReader(InputReader())
    shaders.read(origin)
    glow = add_glows(shaders.parts)
    notes.extend(f"{owner}: {note}" for note in shaders.parts.notes)
    return glow
