"""What is known of a scene's triangles, kept from one frame to the next while they do not change.

This is Blender's *Persistent Data*: lamps, spectra, materials and the camera may move, and the triangles need neither
be gathered nor sorted again. Whether they are the same is decided by comparing them, so nothing can be stale.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ._core import core

__all__ = ["acceleration_for", "forget", "register", "unregister"]

_caches: dict[tuple[str, str], Any] = {}


def acceleration_for(
    exported: Any, precision: str, *, is_kept: bool, stop_if_cancelled: Callable[[], None] = lambda: None
) -> Any:
    """Give the acceleration of an exported scene's triangles.

    Parameters
    ----------
    exported : ExportedScene
        The scene.
    precision : str
        "float32" or "float64".
    is_kept : bool
        Whether to take it from the last render of the layer if it fits, and to keep it for the next.
    stop_if_cancelled : callable
        Asked often; raises when the user wants an end.

    Returns
    -------
    Acceleration
        Of the core.

    Raises
    ------
    RenderCancelledError
        If the user wants an end.

    References
    ----------
    Blender manual, Render > Performance > Persistent Data.
    """
    key = exported.scene.name, exported.layer
    cache = _caches.setdefault(key, core.AccelerationCache()) if is_kept else core.AccelerationCache()
    if not is_kept:
        _caches.pop(key, None)
    dtype = np.float64 if precision == "float64" else np.float32
    return cache.get(exported.scene.instances, dtype, stop_if_cancelled)


def forget() -> None:
    """Let everything go."""
    _caches.clear()


@persistent
def _on_load(*_: Any) -> None:
    forget()


def register() -> None:
    """Let go of everything when another file is opened."""
    bpy.app.handlers.load_pre.append(_on_load)


def unregister() -> None:
    """Take the callback out again, and let everything go."""
    if _on_load in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_on_load)
    forget()
