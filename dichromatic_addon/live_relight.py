"""Relighting at once: an edit of a lamp, a paint, a metal, the observer or the white re-colours the last render."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

from . import last_render
from ._core import core
from .operators import IMAGE_NAME, store_image
from .output_display import output_development
from .relighting import relit_layer

__all__ = ["CLASSES", "image_name", "register", "relight", "run_pending", "unregister"]

_DEBOUNCE = 0.05  # seconds: an edit that is dragged re-colours the picture about twenty times a second
_WHILE_RENDERING = 0.5

_pending: set[str] = set()


def relight(scene: Any, *, always: bool = False) -> list[Any]:
    """Re-colour the last render of a scene and store it in its images.

    Parameters
    ----------
    scene : bpy.types.Scene
        Its last render is kept.
    always : bool
        Store the images even where no colour changed.

    Returns
    -------
    list of bpy.types.Image
        Those that were written.

    Raises
    ------
    DichromaticError
        With the reason, where the render cannot be relit; it is kept in ``KeptRender.problem`` too.
    """
    kept = last_render.kept_render(scene)
    if kept is None:
        raise core.SceneError(f"no render of scene '{scene.name}' is kept: render it first, or open one")
    try:
        output_development(scene)  # tells what is wrong with the display of the image
        relit = {name: relit_layer(scene, finished) for name, finished in kept.layers.items()}
    except core.DichromaticError as error:
        kept.problem = str(error)
        raise
    kept.problem = ""
    kept.differences = tuple(dict.fromkeys(text for layer in relit.values() for text in layer.differences))
    images = []
    for name, layer in relit.items():
        if always or _look(layer.finished) != _look(kept.shown[name]):
            images.append(store_image(layer.finished, image_name(kept, name)))
        kept.shown[name] = layer.finished
    if images:
        kept.map_report = kept.probe_report = ""  # they are of the colours before
    _redraw()
    return images


def image_name(kept: last_render.KeptRender, layer: str) -> str:
    """Return the name of the image that a layer of the last render is stored in."""
    return IMAGE_NAME if len(kept.layers) == 1 else f"{IMAGE_NAME} {layer}"


def _look(finished: Any) -> tuple[Any, ...]:
    """What the colours of a picture depend on."""
    render, colour = finished.render, finished.exported.colour
    spectra = [(e.illuminant.key, e.strength) for e in render.spectra.emitters]
    spectra += [(slot.reflectance.key, 1.0) for slot in render.spectra.slots]
    shown = colour.adaptation.tobytes(), colour.working_space.tobytes(), colour.output
    return render.observer, render.grid, *shown, spectra


def _redraw() -> None:
    manager = bpy.context.window_manager
    for window in manager.windows if manager else ():
        for area in window.screen.areas:
            if area.type in {"IMAGE_EDITOR", "PROPERTIES"}:
                area.tag_redraw()


@persistent
def _on_update(scene: Any, depsgraph: Any) -> None:
    if depsgraph.mode == "RENDER":
        return
    kept = last_render.kept_render(scene)
    if kept is None:
        return
    _note_geometry(scene, depsgraph, kept)
    if scene.dichromatic_studies.live_relight:
        _pending.add(scene.name)
        if not bpy.app.background and not bpy.app.timers.is_registered(_on_timer):
            bpy.app.timers.register(_on_timer, first_interval=_DEBOUNCE)


def _note_geometry(scene: Any, depsgraph: Any, kept: last_render.KeptRender) -> None:
    if kept.source:
        return  # what a file shows need not be this scene
    for update in depsgraph.updates:
        changed = update.id
        if isinstance(changed, bpy.types.Camera):
            if scene.camera is not None and scene.camera.data.name == changed.name:
                kept.outdated[f"camera '{changed.name}' was changed"] = None
        elif isinstance(changed, bpy.types.Object):
            seen = changed.type != "CAMERA" or (scene.camera is not None and changed.name == scene.camera.name)
            if update.is_updated_transform and seen:
                kept.outdated[f"'{changed.name}' moved"] = None
            elif update.is_updated_geometry and changed.type not in {"LIGHT", "CAMERA", "EMPTY"}:
                kept.outdated[f"'{changed.name}' changed its shape"] = None
    if kept.objects is not None and last_render.renderable_objects(scene) != kept.objects:
        kept.outdated["objects were added, removed, renamed or hidden"] = None


def _on_timer() -> float | None:
    if bpy.app.is_job_running("RENDER"):
        return _WHILE_RENDERING
    run_pending()
    return None


def run_pending() -> None:
    """Relight what was edited since the last call; where that cannot be done, the panel tells why."""
    names = sorted(_pending)
    _pending.clear()
    for name in names:
        scene = bpy.data.scenes.get(name)
        if scene is None or last_render.kept_render(scene) is None or not scene.dichromatic_studies.live_relight:
            continue
        try:
            relight(scene)
        except core.DichromaticError:
            _redraw()  # the reason stands in the kept render, and the panel shows it


class DICHROMATIC_OT_relight(bpy.types.Operator):
    """Re-colour the last render."""

    bl_idname = "dichromatic.relight"
    bl_label = "Relight"
    bl_description = (
        "Apply the scene's present lamps, spectra, observer and adaptation to its last render, without tracing a ray"
    )
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        if last_render.kept_render(context.scene) is None:
            cls.poll_message_set("No render of this scene is kept: render it first, or open one")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        try:
            images = relight(context.scene, always=True)
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        kept = last_render.kept_render(context.scene)
        for text in kept.differences if kept else ():
            self.report({"WARNING"}, f"{text}: render again to see it")
        self.report({"INFO"}, "relit: " + ", ".join(f"'{image.name}'" for image in images))
        return {"FINISHED"}


class DICHROMATIC_OT_show_render(bpy.types.Operator):
    """Show the image that is relit."""

    bl_idname = "dichromatic.show_render"
    bl_label = "Show Relit Image"
    bl_description = (
        "Show the image that relighting changes in this editor; Blender's own Render Result stays as it was"
    )
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        if context.space_data is None or context.space_data.type != "IMAGE_EDITOR":
            cls.poll_message_set("Images are shown in the Image Editor")
            return False
        return last_render.kept_render(context.scene) is not None

    def execute(self, context: Any) -> set[str]:
        kept = last_render.kept_render(context.scene)
        if kept is None:
            self.report({"ERROR"}, "the render is no longer kept")
            return {"CANCELLED"}
        finished = kept.layer(context.view_layer.name)
        context.space_data.image = store_image(finished, image_name(kept, finished.exported.layer))
        return {"FINISHED"}


class DICHROMATIC_OT_free_render(bpy.types.Operator):
    """Let the last render go."""

    bl_idname = "dichromatic.free_render"
    bl_label = "Free Render"
    bl_description = "Free the memory of this scene's last render; its images stay, but can no longer be relit"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return last_render.kept_render(context.scene) is not None

    def execute(self, context: Any) -> set[str]:
        last_render.forget(context.scene)
        return {"FINISHED"}


CLASSES = (DICHROMATIC_OT_relight, DICHROMATIC_OT_show_render, DICHROMATIC_OT_free_render)


def register() -> None:
    """Offer the operators, and watch for edits."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.depsgraph_update_post.append(_on_update)


def unregister() -> None:
    """Stop watching, and take the operators out again."""
    if _on_update in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.remove(_on_update)
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
    _pending.clear()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
