"""Which objects a lamp lights and which hide it: Blender's light and shadow linking, by their collections."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["is_linked", "linked_objects"]


def linked_objects(collection: Any) -> Callable[[str], bool] | None:
    """Read which objects a light lights, or which of them hide it.

    Parameters
    ----------
    collection : bpy.types.Collection or None
        Receivers or blockers of the light's object.

    Returns
    -------
    callable or None
        Tells by its name whether an object is one of them; None where all are. As in Cycles: where an object is
        included, only included ones are; excluded ones never are.
    """
    if collection is None:
        return None
    states = _states(collection)
    included = {name for name, state in states.items() if state == "INCLUDE"}
    excluded = {name for name, state in states.items() if state == "EXCLUDE"}

    def is_one(name: str) -> bool:
        return name not in excluded and (name in included or not included)

    return is_one


def is_linked(obj: Any) -> bool:
    """Tell whether an object lights some objects only, or is hidden by some only."""
    linking = obj.light_linking
    return linking.receiver_collection is not None or linking.blocker_collection is not None


def _states(collection: Any) -> dict[str, str]:
    """Return whether each object of a collection is included; an object's own state goes before its collection's."""
    states: dict[str, str] = {}
    for child, link in zip(collection.children, collection.collection_children, strict=True):
        for item in child.all_objects:
            states[item.name] = link.light_linking.link_state
    for item, link in zip(collection.objects, collection.collection_objects, strict=True):
        states[item.name] = link.light_linking.link_state
    return states
