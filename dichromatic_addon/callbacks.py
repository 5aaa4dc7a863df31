"""Callbacks of Blender properties that refer to their functions by name.

Blender never lets go of a property's callback, and with it of the globals of the module that the callback stands in.
Where those hold `bpy`, the bpy module is not freed at the interpreter's exit, and Blender 4.2 crashes there. So what
Blender is given are functions of this module, which imports nothing of Blender's.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

__all__ = ["get_callback", "search_callback", "set_callback", "update_callback"]


def update_callback(function: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    """Return a property's ``update`` callback that finds a module's function, and calls it, when it is needed."""
    module, name = function.__module__, function.__name__

    def update(owner: Any, context: Any) -> None:
        getattr(sys.modules[module], name)(owner, context)

    return update


def search_callback(function: Callable[[Any, Any, str], Any]) -> Callable[[Any, Any, str], Any]:
    """Return a property's ``search`` callback that finds a module's function, and calls it, when it is needed."""
    module, name = function.__module__, function.__name__

    def search(owner: Any, context: Any, edit_text: str) -> Any:
        return getattr(sys.modules[module], name)(owner, context, edit_text)

    return search


def get_callback(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a property's ``get`` callback that finds a module's function, and calls it, when it is needed."""
    module, name = function.__module__, function.__name__

    def get(owner: Any) -> Any:
        return getattr(sys.modules[module], name)(owner)

    return get


def set_callback(function: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    """Return a property's ``set`` callback that finds a module's function, and calls it, when it is needed."""
    module, name = function.__module__, function.__name__

    def assign(owner: Any, value: Any) -> None:
        getattr(sys.modules[module], name)(owner, value)

    return assign
