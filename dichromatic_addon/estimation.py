"""The button that estimates what the current settings cost: time and colour error, from parts of the picture."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

from ._core import core
from .picture import srgb_development
from .properties import read_settings
from .scene_export import export_scene

__all__ = ["CLASSES", "estimate_lines", "register", "unregister"]

_estimates: dict[str, tuple[Any, Any]] = {}  # by scene: the settings, and what they were estimated to cost


def estimate_lines(scene: Any) -> tuple[str, ...]:
    """Say what a scene's settings were estimated to cost, or nothing where they were not, or were changed since."""
    settings, found = _estimates.get(scene.name, (None, None))
    if found is None:
        return ()
    if settings != read_settings(scene):
        return ("Settings changed since the estimate",)
    return (
        f"About {_seconds(found.seconds)}",
        f"Delta E 2000: mean {found.error.mean:.2g}, 95 % below {found.error.percentile_95:.2g}",
    )


def _seconds(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.2g} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


class DICHROMATIC_OT_estimate(bpy.types.Operator):
    """Estimate time and error of a render."""

    bl_idname = "dichromatic.estimate"
    bl_label = "Estimate"
    bl_description = (
        "Render parts of the picture with these settings and with better ones, and estimate how long the whole "
        "takes and how far its colors will be off (Delta E 2000; 1 is just visible)"
    )
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        if context.scene.camera is None:
            cls.poll_message_set("The scene has no camera")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        scene = context.scene
        if context.window is not None:
            context.window.cursor_set("WAIT")
        try:
            exported = export_scene(context.evaluated_depsgraph_get())
            found = core.estimate(exported.scene, exported.settings, srgb_development(scene))
            _estimates[scene.name] = read_settings(scene), found
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            if context.window is not None:
                context.window.cursor_set("DEFAULT")
        self.report({"INFO"}, found.describe())
        return {"FINISHED"}


@persistent
def _on_load(*_: Any) -> None:
    _estimates.clear()


CLASSES = (DICHROMATIC_OT_estimate,)


def register() -> None:
    """Offer the operator."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_pre.append(_on_load)


def unregister() -> None:
    """Take the operator out again."""
    if _on_load in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_on_load)
    _on_load()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
