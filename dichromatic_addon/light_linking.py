"""Which objects a lamp lights: Blender's light linking, by the collection of its receivers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["linked_objects"]


def linked_objects(obj: Any, notes: list[str]) -> Callable[[str], bool] | None:
    """Read which objects a light lights.

    Parameters
    ----------
    obj : bpy.types.Object
        A light, or an object with a material that gives light.
    notes : list of str
        What is approximated is added.

    Returns
    -------
    callable or None
        Tells by its name whether an object is lit; None where all are. As in Cycles: where an object is included, only
        included ones are lit; excluded ones never are.
    """
    linking = obj.light_linking
    if linking.blocker_collection is not None:
        notes.append(f"shadow linking of '{obj.name}' is not rendered: everything casts its shadow")
    if linking.receiver_collection is None:
        return None
    states = _states(linking.receiver_collection)
    included = {name for name, state in states.items() if state == "INCLUDE"}
    excluded = {name for name, state in states.items() if state == "EXCLUDE"}

    def is_lit(name: str) -> bool:
        return name not in excluded and (name in included or not included)

    return is_lit


def _states(collection: Any) -> dict[str, str]:
    """Return whether each object of a collection is included; an object's own state goes before its collection's."""
    states: dict[str, str] = {}
    for child, link in zip(collection.children, collection.collection_children, strict=True):
        for item in child.all_objects:
            states[item.name] = link.light_linking.link_state
    for item, link in zip(collection.objects, collection.collection_objects, strict=True):
        states[item.name] = link.light_linking.link_state
    return states
