# mypy: disable-error-code="valid-type"
"""Operators that write the last render with its film, open one again, and write spectral pictures."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import last_render
from ._core import core
from .camera_reading import Region
from .engine import FinishedLayer
from .operators import IMAGE_NAME, store_image
from .output_display import output_development
from .picture import PictureColour, working_space_from_tristimulus
from .scene_export import ExportedScene

__all__ = ["CLASSES", "register", "unregister"]


def _kept_layer(context: Any) -> Any:
    kept = last_render.kept_render(context.scene)
    if kept is None:
        raise core.SceneError(f"no render of scene '{context.scene.name}' is kept: render it first, or open one")
    return kept.layer(context.view_layer.name)


class _Writer(last_render.NeedsKeptRender):
    """What the operators that write share."""

    bl_options = {"REGISTER"}


class DICHROMATIC_OT_save_render(_Writer, bpy.types.Operator, ExportHelper):
    """Write the last render with its film."""

    bl_idname = "dichromatic.save_render"
    bl_label = "Save Render"
    bl_description = (
        "Write the last render with its film to a .npz file, which can be opened, relit and probed again, "
        "here or on the command line"
    )

    filename_ext = ".npz"
    filter_glob: StringProperty(default="*.npz", options={"HIDDEN"})

    def execute(self, context: Any) -> set[str]:
        path = bpy.path.abspath(self.filepath)
        try:
            core.save_render(path, _kept_layer(context).render, output_development(context.scene))
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{path} written")
        return {"FINISHED"}


class DICHROMATIC_OT_open_render(bpy.types.Operator, ImportHelper):
    """Open a render with its film."""

    bl_idname = "dichromatic.open_render"
    bl_label = "Open Render"
    bl_description = "Open a render from a .npz file as the last one of this scene, and show it in an image"
    bl_options = {"REGISTER"}

    filename_ext = ".npz"
    filter_glob: StringProperty(default="*.npz", options={"HIDDEN"})

    def execute(self, context: Any) -> set[str]:
        path = bpy.path.abspath(self.filepath)
        try:
            finished = _opened(context.scene, path)
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        last_render.replace_with(context.scene, finished, Path(path).name)
        image = store_image(finished, IMAGE_NAME)
        space = context.space_data
        if space is not None and space.type == "IMAGE_EDITOR":
            space.image = image
        self.report({"INFO"}, f"{path} opened in the image '{image.name}'")
        return {"FINISHED"}


def _opened(scene: Any, path: str) -> FinishedLayer:
    """Read a file; its picture is shown as the file says until it is relit with this scene's settings."""
    render, development = core.open_render(path)
    white = core.white_point(development.adopted_white, core.observer(render.observer))
    film = render.film
    exported = ExportedScene(
        layer="",
        scene=core.Scene(name=scene.name),
        settings=core.RenderSettings(
            width=film.width,
            height=film.height,
            samples=max(1, render.statistics.samples),
            observer=render.observer,
            grid=render.grid,
        ),
        region=Region(film.width, film.height, 0, 0, film.width, film.height),
        colour=PictureColour(
            adaptation=core.chromatic_adaptation(white, core.SRGB_WHITE, development.adaptation),
            working_space=working_space_from_tristimulus(),
        ),
        is_transparent=False,
        notes=(),
    )
    return FinishedLayer(render, exported)


class DICHROMATIC_OT_write_spectral_exr(_Writer, bpy.types.Operator, ExportHelper):
    """Write the spectra of all pixels."""

    bl_idname = "dichromatic.write_spectral_exr"
    bl_label = "Write Spectral EXR"
    bl_description = (
        "Write the spectrum of every pixel, 400 to 700 nm at 5 nm, to an EXR file for other programs. "
        "Blender itself cannot open files with that many channels"
    )

    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    def execute(self, context: Any) -> set[str]:
        path = bpy.path.abspath(self.filepath)
        try:
            core.write_spectral_exr(path, _kept_layer(context).render)
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{path} written")
        return {"FINISHED"}


CLASSES = (DICHROMATIC_OT_save_render, DICHROMATIC_OT_open_render, DICHROMATIC_OT_write_spectral_exr)


def register() -> None:
    """Offer the operators."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take them out again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
