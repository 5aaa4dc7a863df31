"""Callbacks of Blender that keep the hidden inputs in line: after loading, undo and each animated frame.

Drivers and keyframes change node properties without running their update callbacks.
"""

from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..image_reading import forget
from ..names import SPECTRUM_NODES, SURFACE_NODES
from . import dielectric, metal, mix, spectrum
from .groups import is_hidden_group, shared_group

__all__ = ["refresh_nodes", "register", "unregister"]


def _trees() -> list[Any]:
    return [material.node_tree for material in bpy.data.materials if material.node_tree] + list(bpy.data.node_groups)


def _our_nodes(trees: list[Any]) -> list[Any]:
    kinds = (*SURFACE_NODES, *SPECTRUM_NODES)
    own = [tree for tree in trees if tree.library is None and not is_hidden_group(tree)]
    return [node for tree in own for node in tree.nodes if node.bl_idname in kinds]


def refresh_nodes(trees: list[Any]) -> None:
    """Bring the hidden inputs of our nodes in the given trees up to date."""
    for node in _our_nodes(trees):
        node.refresh()


@persistent
def _after_load(*_: Any) -> None:
    """Rebuild hidden groups of an older version, and give nodes that have lost their group a new one."""
    forget()
    for node_class in (*dielectric.CLASSES, *metal.CLASSES, *spectrum.CLASSES, *mix.CLASSES):
        recipe = node_class.recipe
        if any(
            tree.library is None and tree.get("dichromatic_node_group") == recipe.tag for tree in bpy.data.node_groups
        ):
            shared_group(recipe)
    for node in _our_nodes(_trees()):
        if node.node_tree is None:
            node.node_tree = shared_group(node.recipe)
        node.bring_up_to_date()


@persistent
def _after_frame_change(scene: Any, *_: Any) -> None:
    refresh_nodes([tree for tree in _trees() if tree.animation_data is not None])


HANDLERS = (("load_post", _after_load), ("frame_change_post", _after_frame_change))


def register() -> None:
    """Hang the callbacks into Blender."""
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """Take them out again."""
    forget()
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
