"""Where the value of a node socket comes from: through reroutes, muted nodes, muted links and user groups."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .._core import core

__all__ = ["Origin", "origin_of"]

LONGEST_CHAIN = 10_000  # a chain of more links is a cycle, which Blender allows to draw


@dataclass(frozen=True, slots=True)
class Origin:
    """The end of a chain of links.

    Attributes
    ----------
    socket : bpy.types.NodeSocket
        The output socket that gives the value, or the unlinked input socket whose own value counts.
    groups : tuple of bpy.types.Node
        The group nodes around `socket`, outermost first.
    """

    socket: Any
    groups: tuple[Any, ...] = ()

    @property
    def node(self) -> Any:
        """The node of the socket."""
        return self.socket.node

    @property
    def is_unlinked(self) -> bool:
        """Whether the chain ends at an input that nothing is linked to."""
        return not self.socket.is_output


def origin_of(socket: Any, groups: tuple[Any, ...] = ()) -> Origin | None:
    """Follow an input socket to where its value comes from.

    Parameters
    ----------
    socket : bpy.types.NodeSocket
        An input socket.
    groups : tuple of bpy.types.Node, optional
        The group nodes around the socket, outermost first.

    Returns
    -------
    Origin or None
        None where the chain ends in nothing: a muted node without a way through, or an empty group.

    Raises
    ------
    SceneError
        If the links form a cycle.
    """
    for _ in range(LONGEST_CHAIN):
        link = next((link for link in socket.links if not link.is_muted), None)
        if link is None:
            return Origin(socket, groups)
        source, node = link.from_socket, link.from_node
        step = _step_back(source, node, groups)
        if step is None:
            return None
        socket, groups = step
        if socket.is_output:
            return Origin(socket, groups)
    raise core.SceneError(f"the links that lead to input '{socket.name}' of node '{socket.node.name}' form a cycle")


def _step_back(source: Any, node: Any, groups: tuple[Any, ...]) -> tuple[Any, tuple[Any, ...]] | None:
    """From an output socket to the input socket that it passes on; to itself where it is the origin."""
    if node.mute:
        passed = [link.from_socket for link in node.internal_links if link.to_socket == source]
        return (passed[0], groups) if passed else None
    if node.type == "REROUTE":
        return node.inputs[0], groups
    if node.bl_idname == "ShaderNodeGroup":
        inside = _group_output(node.node_tree, source.identifier) if node.node_tree else None
        return None if inside is None else (inside, (*groups, node))
    if node.type == "GROUP_INPUT" and groups:
        outside = _by_identifier(groups[-1].inputs, source.identifier)
        return None if outside is None else (outside, groups[:-1])
    return source, groups


def _group_output(tree: Any, identifier: str) -> Any:
    outputs = [node for node in tree.nodes if node.type == "GROUP_OUTPUT"]
    active = next((node for node in outputs if node.is_active_output), outputs[0] if outputs else None)
    return None if active is None else _by_identifier(active.inputs, identifier)


def _by_identifier(sockets: Any, identifier: str) -> Any:
    return next((socket for socket in sockets if socket.identifier == identifier), None)
