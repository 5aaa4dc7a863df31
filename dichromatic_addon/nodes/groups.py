"""The hidden node groups inside our nodes: one for each node type, shared by all nodes of that type.

What a group holds is the RGB approximation of the material, which EEVEE, Cycles and the solid viewport render. Our
own engine never looks inside; it reads the node's sockets and properties. A group is found by its tag and not by its
name, since a user may rename it and an appended file brings its own along.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy

__all__ = ["GroupRecipe", "SocketRecipe", "is_hidden_group", "shared_group"]

TAG_KEY = "dichromatic_node_group"
VERSION_KEY = "dichromatic_node_group_version"


@dataclass(frozen=True, slots=True)
class SocketRecipe:
    """One socket of a group's interface, and so of the node.

    Attributes
    ----------
    name : str
        Name of the socket; stored in files.
    kind : str
        "COLOR", "FLOAT" or "SHADER".
    default : float or tuple of float
        Value of a new node.
    low, high : float
        Range of a number.
    subtype : str
        Blender's subtype of a number, such as "ANGLE".
    description : str
        The tooltip.
    hidden : bool
        Whether the socket only carries what the node's properties say into the group.
    """

    name: str
    kind: str
    default: float | tuple[float, float, float, float] = 0.0
    low: float = 0.0
    high: float = 1.0
    subtype: str = "NONE"
    description: str = ""
    hidden: bool = False

    @property
    def socket_type(self) -> str:
        """Blender's identifier of the socket's type."""
        return {"COLOR": "NodeSocketColor", "FLOAT": "NodeSocketFloat", "SHADER": "NodeSocketShader"}[self.kind]


@dataclass(frozen=True, slots=True)
class GroupRecipe:
    """How to make the shared group of a node type.

    Attributes
    ----------
    tag : str
        The node type's identifier, kept as an ID property of the group.
    version : int
        Raised whenever the inside changes; older groups in a file are then built anew.
    name : str
        Name of a new group; the leading dot hides it from the lists of data-blocks.
    inputs : tuple of SocketRecipe
        The node's inputs, in order.
    output : SocketRecipe
        The node's only output.
    build : callable
        ``build(tree, sources, target)`` makes the inside between the group's input sockets, by name, and its output.
    """

    tag: str
    version: int
    name: str
    inputs: tuple[SocketRecipe, ...]
    output: SocketRecipe
    build: Callable[[Any, dict[str, Any], Any], None]


def is_hidden_group(tree: Any) -> bool:
    """Whether a node group is one of ours."""
    return TAG_KEY in tree


def shared_group(recipe: GroupRecipe) -> Any:
    """Find this file's group for a node type, or make it.

    Parameters
    ----------
    recipe : GroupRecipe
        The node type's recipe.

    Returns
    -------
    bpy.types.ShaderNodeTree
        A group of this file (never a linked one) with the recipe's version.
    """
    for tree in bpy.data.node_groups:
        if tree.library is None and tree.get(TAG_KEY) == recipe.tag:
            if tree.get(VERSION_KEY) != recipe.version:
                _fill(tree, recipe)
            return tree
    tree = bpy.data.node_groups.new(recipe.name, "ShaderNodeTree")
    tree[TAG_KEY] = recipe.tag
    _fill(tree, recipe)
    return tree


def _fill(tree: Any, recipe: GroupRecipe) -> None:
    """Bring the interface up to date without touching sockets that exist (links hang on them), and build the inside."""
    tree.nodes.clear()
    existing = {(item.name, item.in_out): item for item in tree.interface.items_tree if item.item_type == "SOCKET"}
    for socket, in_out in [(recipe.output, "OUTPUT"), *((socket, "INPUT") for socket in recipe.inputs)]:
        item = existing.get((socket.name, in_out))
        if item is None:
            item = tree.interface.new_socket(socket.name, in_out=in_out, socket_type=socket.socket_type)
        item.description = socket.description
        item.hide_value = socket.hidden
        if socket.kind == "FLOAT":
            if socket.subtype != "NONE":
                item.subtype = socket.subtype
            item.min_value, item.max_value = socket.low, socket.high
        if socket.kind != "SHADER":
            item.default_value = socket.default
    group_input = tree.nodes.new("NodeGroupInput")
    group_output = tree.nodes.new("NodeGroupOutput")
    group_input.location, group_output.location = (-600, 0), (600, 0)
    sources = {socket.name: group_input.outputs[socket.name] for socket in recipe.inputs}
    recipe.build(tree, sources, group_output.inputs[recipe.output.name])
    tree[VERSION_KEY] = recipe.version
