"""Operators that render, and the pieces they share with the command line."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ._core import core
from .engine import Capture, DichromaticRenderEngine, FinishedLayer, begin_capture, capture, end_capture
from .names import ENGINE_ID
from .output_display import OutputPicture, output_development, output_picture

__all__ = [
    "CLASSES",
    "IMAGE_NAME",
    "addon_registered",
    "put_image",
    "register",
    "render_layers",
    "store_image",
    "unregister",
    "write_image_with_blender",
]

IMAGE_NAME = "Dichromatic Render"


@contextmanager
def addon_registered() -> Iterator[None]:
    """Make sure that the add-on is registered inside the block: by Blender already, or by us for as long."""
    if DichromaticRenderEngine.is_registered:
        yield
        return
    from . import register as register_addon
    from . import unregister as unregister_addon

    register_addon()
    try:
        yield
    finally:
        unregister_addon()


def render_layers(
    scene: Any,
    *,
    layer: str = "",
    progress: Callable[[float, str], None] | None = None,
    adjust: Callable[[Any], Any] | None = None,
    executor: Executor | None = None,
) -> list[FinishedLayer]:
    """Render a scene with the dichromatic engine and return its layers; the scene is left as it was.

    Parameters
    ----------
    scene : bpy.types.Scene
        Any engine may be set in it.
    layer : str, optional
        One view layer; all that are used for rendering when empty.
    progress, adjust, executor
        As :class:`~.engine.Capture` has them.

    Returns
    -------
    list of FinishedLayer
        At least one.

    Raises
    ------
    DichromaticError
        With the reason, also when it was cancelled.
    """
    with _our_engine(scene, layer), capture(progress, adjust, executor) as captured:
        try:
            with bpy.context.temp_override(scene=scene):
                bpy.ops.render.render()
        except RuntimeError as error:  # what the engine reported as an error
            if captured.error is None:
                raise core.DichromaticError(str(error).strip()) from error
    return _outcome(captured)


def _outcome(captured: Capture) -> list[FinishedLayer]:
    if captured.error is not None:
        raise captured.error
    if not captured.layers:
        raise core.SceneError("nothing was rendered: no view layer is used for rendering")
    return captured.layers


def _set_engine(render: Any, engine: str) -> None:
    """Choose an engine; not what is chosen already.

    Blender waits for its material previews to end when it is set, even to what it is, and ours wait for the Python
    thread that sets it.
    """
    if render.engine != engine:
        render.engine = engine


@contextmanager
def _our_engine(scene: Any, layer: str = "") -> Iterator[None]:
    """Choose our engine, one view layer and nothing but the engine's own pixels; put everything back at the end."""
    render = scene.render
    before = render.engine, render.use_compositing, render.use_sequencer
    used = [view_layer.use for view_layer in scene.view_layers]
    _set_engine(render, ENGINE_ID)
    render.use_compositing, render.use_sequencer = False, False
    if layer:
        for view_layer in scene.view_layers:
            view_layer.use = view_layer.name == layer
    try:
        yield
    finally:
        _set_engine(render, before[0])
        render.use_compositing, render.use_sequencer = before[1:]
        for view_layer, use in zip(scene.view_layers, used, strict=True):
            view_layer.use = use


def store_image(finished: FinishedLayer, name: str = IMAGE_NAME) -> Any:
    """Put a finished layer into a Blender image, for the display of its scene, with the colour space that says so."""
    return _store_picture(output_picture(finished, counted=False), name)


def _store_picture(picture: OutputPicture, name: str) -> Any:
    return put_image(name, picture.pixels, is_float=True, colour_space=picture.colour_space)


def put_image(name: str, pixels: NDArray[np.floating[Any]], *, is_float: bool = False, colour_space: str = "") -> Any:
    """Put a picture into the Blender image of a name, made new where there is none that fits.

    Parameters
    ----------
    name : str
        Name of the datablock; another image that has it is renamed and kept.
    pixels : ndarray, shape (H, W, 3) or (H, W, 4)
        Row 0 is the top. Linear Rec.709 (premultiplied) for float images, else display values of sRGB, 0 to 1.
    is_float : bool
        Which of the two.
    colour_space : str, optional
        Blender's name of another colour space that they are in.

    Returns
    -------
    bpy.types.Image
        The image.
    """
    height, width, channels = pixels.shape
    rgba = np.ones((height, width, 4), np.float32)
    rgba[::-1, :, :channels] = pixels  # Blender's rows begin at the bottom
    image = bpy.data.images.get(name)
    if image is not None and (image.is_float != is_float or image.source != "GENERATED"):
        image.name = f"{name} (replaced)"  # somebody else's image of that name: keep it
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    elif tuple(image.size) != (width, height):
        image.generated_width, image.generated_height = width, height
    image.colorspace_settings.name = colour_space or ("Linear Rec.709" if is_float else "sRGB")
    image.alpha_mode = "PREMUL" if is_float else "STRAIGHT"
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    return image


def write_image_with_blender(path: Path, pixels: NDArray[np.float32]) -> None:
    """Write display values (.png) or linear Rec.709 (.exr) with Blender's own writer, whole or not at all.

    Parameters
    ----------
    path : Path
        Ends in ".png" or ".exr".
    pixels : ndarray of float32, shape (H, W, 3) or (H, W, 4)
        Row 0 is the top.

    Raises
    ------
    DichromaticError
        If the file cannot be written.
    """
    height, width, channels = pixels.shape
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels
    is_float = path.suffix.lower() == ".exr"
    image = bpy.data.images.new(".dichromatic output", width, height, alpha=channels == 4, float_buffer=is_float)
    try:
        image.colorspace_settings.name = "Non-Color"  # the values go to the file as they are
        image.pixels.foreach_set(np.ascontiguousarray(rgba[::-1]).ravel())
        image.file_format = "OPEN_EXR" if is_float else "PNG"
        with core.replacing(path) as temporary:
            image.filepath_raw = str(temporary)
            image.save()
    except RuntimeError as error:  # Blender's own complaint
        raise core.DichromaticError(f"{path} cannot be written: {str(error).strip()}") from error
    finally:
        bpy.data.images.remove(image)


class DICHROMATIC_OT_render_image(bpy.types.Operator):
    """Render to an image datablock."""

    bl_idname = "dichromatic.render_image"
    bl_label = "Render to Image"
    bl_description = "Render the scene spectrally, whatever engine is set, and store the colors in an image of the file"
    bl_options = {"REGISTER"}

    _captured: Capture | None = None
    _timer: Any = None
    _engine_context: Any = None

    @classmethod
    def poll(cls, context: Any) -> bool:
        return not bpy.app.is_job_running("RENDER")

    def execute(self, context: Any) -> set[str]:
        """Render at once, for scripts."""
        try:
            output_development(context.scene)  # what is wrong with it should be said before the render
            self._store(render_layers(context.scene))
        except core.RenderCancelledError:
            self.report({"INFO"}, "the render was cancelled: no image was stored")
            return {"CANCELLED"}
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Render as F12 does, with the window alive, and store the image when it is done."""
        if bpy.app.background:
            return self.execute(context)
        try:
            output_development(context.scene)
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._engine_context = _our_engine(context.scene)
        self._engine_context.__enter__()
        self._captured = begin_capture()
        bpy.ops.render.render("INVOKE_DEFAULT")
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        # Not while a material preview runs either: see _set_engine.
        if event.type != "TIMER" or any(bpy.app.is_job_running(job) for job in ("RENDER", "RENDER_PREVIEW")):
            return {"PASS_THROUGH"}
        captured = self._finish(context)
        try:
            self._store(_outcome(captured))
        except core.RenderCancelledError:
            self.report({"INFO"}, "the render was cancelled: no image was stored")
            return {"CANCELLED"}
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def cancel(self, context: Any) -> None:
        """Blender ends the operator (a file is loaded, the window is closed)."""
        if self._captured is not None:
            self._finish(context)

    def _finish(self, context: Any) -> Capture:
        captured = self._captured
        assert captured is not None
        context.window_manager.event_timer_remove(self._timer)
        end_capture(captured)
        self._engine_context.__exit__(None, None, None)
        self._captured = None
        return captured

    def _store(self, layers: list[FinishedLayer]) -> None:
        for finished in layers:
            name = IMAGE_NAME if len(layers) == 1 else f"{IMAGE_NAME} {finished.exported.layer}"
            picture = output_picture(finished)
            image = _store_picture(picture, name)
            told = ""
            if picture.mapping is not None:
                told = f"; {picture.mapping.describe()}"
                finished.render.statistics.notes.append(picture.mapping.describe())
            self.report({"INFO"}, f"stored in the image '{image.name}'{told}")


CLASSES = (DICHROMATIC_OT_render_image,)


def register() -> None:
    """Offer the operators."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take the operators out again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
