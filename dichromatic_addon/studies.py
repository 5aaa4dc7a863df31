# mypy: disable-error-code="valid-type"
"""Operators that study the last render: metamerism map, contact sheet, pixel probe. None of them traces a ray."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import last_render
from ._core import core
from .bitmap_font import draw_text, text_width
from .callbacks import search_callback
from .image_view import show_whole
from .operators import put_image
from .picture import srgb_development
from .spectrum_plot import plot_spectra
from .spectrum_sources import illuminant_by_name, search_illuminants
from .study_settings import STANDARD_LAMPS, sheet_lamps

__all__ = ["CLASSES", "MAP_IMAGE", "PROBE_IMAGE", "PROBE_TEXT", "SHEET_IMAGE", "register", "unregister"]

MAP_IMAGE = "Dichromatic Metamerism"
SHEET_IMAGE = "Dichromatic Contact Sheet"
PROBE_IMAGE = "Dichromatic Probe"
PROBE_TEXT = "Dichromatic Probe.csv"
_LABEL_SCALE = 2
_GAP = 8  # pixels between the pictures of a sheet


def _kept(context: Any) -> last_render.KeptRender:
    kept = last_render.kept_render(context.scene)
    if kept is None:
        raise core.SceneError(f"no render of scene '{context.scene.name}' is kept: render it first, or open one")
    return kept


def _shown(context: Any) -> Any:
    """Return the layer of the last render that the studies look at."""
    return _kept(context).layer(context.view_layer.name)


def _show(context: Any, image: Any) -> None:
    """Show a picture in the Image Editor that asked for it."""
    space = context.space_data
    if space is not None and space.type == "IMAGE_EDITOR":
        is_another_size = space.image is None or tuple(space.image.size) != tuple(image.size)
        space.image = image
        if is_another_size:  # at the zoom of the picture before, only the middle of a sheet would be seen
            show_whole(context.area, image)


class _Study(last_render.NeedsKeptRender):
    """What the operators share: a render must be there, and what cannot be done is reported with its reason."""

    bl_options = {"REGISTER"}

    def execute(self: Any, context: Any) -> set[str]:
        try:
            self.study(context)
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class DICHROMATIC_OT_metamerism_map(_Study, bpy.types.Operator):
    """Map how far colours move between two lamps."""

    bl_idname = "dichromatic.metamerism_map"
    bl_label = "Metamerism Map"
    bl_description = (
        "Draw the color difference (Delta E 2000) of each pixel between two lamps, after adaptation to each, "
        "into an image"
    )

    first: StringProperty(
        name="First Lamp",
        description="Lamp of the library",
        default="D65",
        search=search_callback(search_illuminants),
    )
    second: StringProperty(
        name="Second Lamp",
        description="Lamp of the library",
        default="A",
        search=search_callback(search_illuminants),
    )
    largest: FloatProperty(name="White at", description="Delta E 2000 that is drawn white", default=10.0, min=0.01)

    def study(self, context: Any) -> None:
        finished = _shown(context)
        lamps = illuminant_by_name(self.first), illuminant_by_name(self.second)
        found = core.metamerism_map(finished.render, *lamps, srgb_development(context.scene))
        _show(context, put_image(MAP_IMAGE, found.picture(self.largest)))
        report = found.describe()
        _kept(context).map_report = report
        self.report({"INFO"}, report)


class DICHROMATIC_OT_contact_sheet(_Study, bpy.types.Operator):
    """Show the last render under several lamps."""

    bl_idname = "dichromatic.contact_sheet"
    bl_label = "Contact Sheet"
    bl_description = "Draw the last render under each lamp of a list, side by side, into an image"

    lamps: StringProperty(
        name="Lamps",
        description="Names of lamps of the library, separated by commas; those of the scene's list when empty",
    )
    adapt: BoolProperty(name="Adapt to Each Lamp", description="Show each picture as an eye adapted to its lamp does")
    columns: IntProperty(name="Columns", description="Pictures in a row; 0 chooses", default=0, min=0)

    def study(self, context: Any) -> None:
        finished = _shown(context)
        names = [name.strip() for name in self.lamps.split(",") if name.strip()]
        names = names or sheet_lamps(context.scene.dichromatic_studies)
        sheet = core.contact_sheet(
            finished.render,
            [illuminant_by_name(name) for name in names],
            srgb_development(context.scene),
            columns=self.columns or None,
            adapt=self.adapt,
            gap=_GAP,
        )
        picture = sheet.picture.copy()
        _label(picture, names, sheet.columns, finished.render.film)
        _show(context, put_image(SHEET_IMAGE, picture))
        self.report({"INFO"}, f"'{SHEET_IMAGE}': {', '.join(names)}")


def _label(picture: Any, names: Sequence[str], columns: int, film: Any) -> None:
    """Write each lamp's name into the lower left corner of its picture, where it has room for it."""
    for number, name in enumerate(names):
        if text_width(name, _LABEL_SCALE) + 16 > film.width or film.height < 48:
            continue
        row, column = divmod(number, columns)
        left, bottom = column * (film.width + _GAP), row * (film.height + _GAP) + film.height
        box = picture[bottom - 26 : bottom, left : left + text_width(name, _LABEL_SCALE) + 16]
        box *= 0.25
        draw_text(picture, name, left + 8, bottom - 20, (1.0, 1.0, 1.0), _LABEL_SCALE)


class DICHROMATIC_OT_probe_pixel(_Study, bpy.types.Operator):
    """Take the light of one pixel apart."""

    bl_idname = "dichromatic.probe_pixel"
    bl_label = "Probe Pixel"
    bl_description = (
        "Report which light and which reflectances reach a pixel of the last render; store the spectra as a text "
        "(CSV) and as a plot"
    )

    x: IntProperty(name="X", description="Column from the left, from 0", default=0, min=0)
    y: IntProperty(name="Y", description="Row from the bottom, as the Image Editor counts, from 0", default=0, min=0)

    def study(self, context: Any) -> None:
        finished = _shown(context)
        render = finished.render
        if self.x >= render.film.width or self.y >= render.film.height:
            raise core.InvalidParameterError(
                f"the pixel must lie within the picture of {render.film.width} x {render.film.height} pixels, "
                f"but is ({self.x}, {self.y})"
            )
        names = _emitter_names(finished)
        probe = core.probe_pixel(render, self.x, render.film.height - 1 - self.y, emitter_names=names)
        report = replace(probe, row=self.y).describe()  # with Blender's count of the rows
        text = bpy.data.texts.get(PROBE_TEXT) or bpy.data.texts.new(PROBE_TEXT)
        text.from_string(probe.csv())
        put_image(PROBE_IMAGE, plot_spectra(probe.wavelengths_nm, *_parts(probe), report.splitlines()[0]))
        settings = context.scene.dichromatic_studies
        settings.probe_x, settings.probe_y = self.x, self.y
        _kept(context).probe_report = report
        self.report({"INFO"}, report)


def _emitter_names(finished: Any) -> list[str]:
    """Call lamps whose data several objects share by their objects; the render knows the data alone."""
    names = [emitter.name for emitter in finished.render.spectra.emitters]
    objects = finished.exported.light_objects  # none where the render was opened from a file
    shared = {name for name in names[: len(objects)] if names[: len(objects)].count(name) > 1}
    return [objects[i] if i < len(objects) and name in shared else name for i, name in enumerate(names)]


def _parts(probe: Any) -> tuple[Any, tuple[str, ...]]:
    if probe.labels:
        return probe.radiance, probe.labels
    return np.zeros((1, len(probe.wavelengths_nm))), ("no light",)


class DICHROMATIC_OT_pick_pixel(_Study, bpy.types.Operator):
    """Probe the pixel that is clicked."""

    bl_idname = "dichromatic.pick_pixel"
    bl_label = "Pick Pixel"
    bl_description = "Click on the last render in this Image Editor to probe that pixel"

    @classmethod
    def poll(cls: Any, context: Any) -> bool:
        if context.space_data is None or context.space_data.type != "IMAGE_EDITOR":
            cls.poll_message_set("Pixels are picked in the Image Editor")
            return False
        return bool(super().poll(context))

    def invoke(self, context: Any, event: Any) -> set[str]:
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set("Click: probe the pixel    Esc, right click: stop")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self.cancel(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"RUNNING_MODAL"}
        self.cancel(context)
        region = next(region for region in context.area.regions if region.type == "WINDOW")
        u, v = region.view2d.region_to_view(event.mouse_x - region.x, event.mouse_y - region.y)
        return self.pick(context, u, v)

    def pick(self, context: Any, u: float, v: float) -> set[str]:
        """Probe the pixel at a place of the image, 0 to 1 from its lower left corner."""
        if not (0.0 <= u < 1.0 and 0.0 <= v < 1.0):
            self.report({"WARNING"}, "that place lies outside the picture")
            return {"CANCELLED"}
        film = _shown(context).render.film
        x, y = u * film.width, v * film.height
        image = context.space_data.image if context.space_data is not None else None
        if image is not None and image.name == PROBE_IMAGE:
            self.report({"WARNING"}, f"'{PROBE_IMAGE}' is a plot: pick a pixel in a picture of the render")
            return {"CANCELLED"}
        if image is not None and image.name == SHEET_IMAGE:  # its pictures are whole from the lower left corner on
            x, y = u * image.size[0] % (film.width + _GAP), v * image.size[1] % (film.height + _GAP)
            if x >= film.width or y >= film.height:
                self.report({"WARNING"}, "that place lies between the pictures")
                return {"CANCELLED"}
        return set(bpy.ops.dichromatic.probe_pixel(x=int(x), y=int(y)))

    def cancel(self, context: Any) -> None:
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)


class DICHROMATIC_OT_study_lamps(bpy.types.Operator):
    """Edit the list of lamps."""

    bl_idname = "dichromatic.study_lamps"
    bl_label = "Edit Lamps"
    bl_description = "Add a lamp to the list of the contact sheet, or take the selected one out"
    bl_options = {"UNDO", "INTERNAL"}  # nothing to adjust afterwards, nor to search for

    action: EnumProperty(
        name="Action",
        description="What to do",
        items=(
            ("ADD", "Add", "Add a lamp to the list", 0),
            ("REMOVE", "Remove", "Take the selected lamp out of the list", 1),
            ("STANDARD", "Standard Lamps", "Fill the list with daylight, a light bulb and two fluorescent tubes", 2),
        ),
    )

    def execute(self, context: Any) -> set[str]:
        settings = context.scene.dichromatic_studies
        if self.action == "REMOVE":
            if not settings.lamps:
                self.report({"WARNING"}, "the list of lamps is empty")
                return {"CANCELLED"}
            settings.lamps.remove(settings.active_lamp)
        elif self.action == "ADD":
            settings.lamps.add().lamp = "D65"
            settings.active_lamp = len(settings.lamps) - 1
        else:
            settings.lamps.clear()
            for name in STANDARD_LAMPS:
                settings.lamps.add().lamp = name
        settings.active_lamp = max(0, min(settings.active_lamp, len(settings.lamps) - 1))
        return {"FINISHED"}


CLASSES = (
    DICHROMATIC_OT_metamerism_map,
    DICHROMATIC_OT_contact_sheet,
    DICHROMATIC_OT_probe_pixel,
    DICHROMATIC_OT_pick_pixel,
    DICHROMATIC_OT_study_lamps,
)


def register() -> None:
    """Offer the studies."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take them out again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
