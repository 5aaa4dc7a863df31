# mypy: disable-error-code="valid-type"
"""Render passes: which ones a view layer asks for, under Blender's own names, and their pixels.

Light passes are partial sums over the film, so they cost a matrix product and no ray. Data passes (depth, normals and
indices) hold the first sample of each pixel, unfiltered: the mean of two distances or of two numbers means nothing.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, PointerProperty
from numpy.typing import NDArray

from . import compat
from ._core import core

__all__ = [
    "CLASSES",
    "DichromaticViewLayerSettings",
    "PassRequest",
    "RenderPass",
    "pass_pixels",
    "passes_of_layer",
    "register",
    "unregister",
]

_FAR = 1e10  # depth where a ray met nothing, as Blender's engines write it


@dataclass(frozen=True, slots=True)
class RenderPass:
    """One pass beside Combined.

    Attributes
    ----------
    name : str
        What Blender calls it.
    channels : str
        One letter a channel.
    kind : str
        "COLOR", "VECTOR" or "VALUE".
    content : str
        "depth", one of the core's buffers, "shadow", "body", "interface", "environment", "emission" or "group".
    group : str
        Name of the light group where the content is one.
    """

    name: str
    channels: str
    kind: str
    content: str
    group: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class PassRequest:
    """The passes of a view layer, and what they need to know of the scene.

    Attributes
    ----------
    passes : tuple of RenderPass
        Beside Combined.
    emitter_groups : tuple of str
        Light group of each emitter of the core's scene: the lights in order, the world, glowing materials.
    object_indices, material_indices : ndarray of int64
        Pass index of each instance and of each material of the core's scene.
    """

    passes: tuple[RenderPass, ...] = ()
    emitter_groups: tuple[str, ...] = ()
    object_indices: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    material_indices: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def wants(self, content: str) -> bool:
        """Whether a pass has that content."""
        return any(item.content == content for item in self.passes)

    @property
    def splits_light(self) -> bool:
        """Whether a pass holds a part of the light."""
        return any(item.content in _LIGHT_CONTENTS for item in self.passes)

    @property
    def buffers(self) -> tuple[str, ...]:
        """The buffers that the core is to keep."""
        return tuple(item.content for item in self.passes if item.content in _BUFFERS)


_BUFFERS = frozenset({"normal", "position", "object_index", "material_index"})
_LIGHT_CONTENTS = frozenset({"body", "interface", "environment", "emission", "group"})


class DichromaticViewLayerSettings(bpy.types.PropertyGroup):
    """Passes of a view layer that only this engine has."""

    use_pass_body: BoolProperty(
        name="Body",
        description=(
            "Deliver the light that a body has reflected: the first term of the dichromatic model, also where it is "
            "seen in a mirror"
        ),
        default=False,
    )
    use_pass_interface: BoolProperty(
        name="Interface",
        description=(
            "Deliver the light that only interfaces have reflected: highlights, metals, and what colored mirrors show "
            "of highlights and of the world"
        ),
        default=False,
    )


def passes_of_layer(view_layer: Any) -> tuple[RenderPass, ...]:
    """Return the passes that a view layer asks for, beside Combined, in the order of the panel.

    Parameters
    ----------
    view_layer : bpy.types.ViewLayer
        Original or evaluated.

    Returns
    -------
    tuple of RenderPass
        Each name once.

    Raises
    ------
    None.

    References
    ----------
    The names are those that Cycles gives to the same contents.
    """
    found = {item.name: item for item in _wanted(view_layer)}
    return tuple(found.values())


def _wanted(view_layer: Any) -> Iterator[RenderPass]:
    ours = view_layer.dichromatic
    if view_layer.use_pass_z:
        yield RenderPass("Depth", "Z", "VALUE", "depth")
    if view_layer.use_pass_position:
        yield RenderPass("Position", "XYZ", "VECTOR", "position")
    if view_layer.use_pass_normal:
        yield RenderPass("Normal", "XYZ", "VECTOR", "normal")
    if view_layer.use_pass_object_index:
        yield RenderPass(compat.OBJECT_INDEX_PASS, "X", "VALUE", "object_index")
    if view_layer.use_pass_material_index:
        yield RenderPass(compat.MATERIAL_INDEX_PASS, "X", "VALUE", "material_index")
    if ours.use_pass_body:
        yield RenderPass("Body", "RGB", "COLOR", "body")
    if ours.use_pass_interface:
        yield RenderPass("Interface", "RGB", "COLOR", "interface")
    if view_layer.use_pass_emit:
        yield RenderPass(compat.EMISSION_PASS, "RGB", "COLOR", "emission")
    if view_layer.use_pass_environment:
        yield RenderPass(compat.ENVIRONMENT_PASS, "RGB", "COLOR", "environment")
    if view_layer.use_pass_shadow:
        yield RenderPass("Shadow", "RGB", "COLOR", "shadow")
    for group in view_layer.lightgroups:
        yield RenderPass(f"Combined_{group.name}", "RGB", "COLOR", "group", group.name)


def pass_pixels(render: Any, exported: Any) -> dict[str, NDArray[np.float32]]:
    """Return the pixels of the passes that were asked for, by name.

    Parameters
    ----------
    render : Render
        What was rendered.
    exported : ExportedScene
        What it was rendered from, with the request.

    Returns
    -------
    dict of str to ndarray of float32, shape (H, W, C)
        Row 0 is the top; light in scene linear RGB as in Combined, premultiplied like it.

    Raises
    ------
    DichromaticError
        If the light was not kept by terms.

    References
    ----------
    Own design.
    """
    request = exported.passes
    light = [item for item in request.passes if item.content in _LIGHT_CONTENTS]
    pictures = core.split_light(render, [_light_part(item, exported) for item in light]) if light else []
    pixels = {
        item.name: exported.colour.rgba(picture, None)[..., :3] for item, picture in zip(light, pictures, strict=True)
    }
    for item in request.passes:
        if item.name not in pixels:
            pixels[item.name] = _data(item.content, render, request)
    return {item.name: np.ascontiguousarray(pixels[item.name], np.float32) for item in request.passes}


def _data(content: str, render: Any, request: PassRequest) -> NDArray[Any]:
    """Return the pixels (H, W, C) of a pass that holds no light."""
    if content == "depth":
        return np.where(np.isfinite(render.depth), render.depth, _FAR)[..., None]
    if content == "shadow":  # the part that arrives, as a factor; 1 where nothing is in the way
        arrives = 1.0 - render.film.planes["occluded"]
        return np.repeat(arrives[..., None], 3, axis=-1)
    buffer = getattr(render.buffers, content)
    if content == "object_index":
        return _numbers(buffer, request.object_indices)
    if content == "material_index":
        return _numbers(buffer, request.material_indices)
    return buffer  # type: ignore[no-any-return]


def _numbers(buffer: NDArray[np.int32], pass_indices: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the pass index (H, W, 1) of what was met; 0 where nothing was."""
    return np.append(pass_indices, 0)[buffer][..., None]  # -1 is the last


def _light_part(item: RenderPass, exported: Any) -> Any:
    """Return which part of the light a pass holds."""
    if item.content in ("body", "interface"):
        return core.LightPart(item.content)
    groups = exported.passes.emitter_groups
    if item.content == "group":
        return core.LightPart(lights=tuple(i for i, group in enumerate(groups) if group == item.group))
    world = len(exported.scene.lights)
    if item.content == "environment":
        return core.LightPart("emission", lights=(world,))
    return core.LightPart("emission", lights=tuple(range(world + 1, len(groups))))


CLASSES = (DichromaticViewLayerSettings,)


def register() -> None:
    """Register the settings and hang them on view layers."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.ViewLayer.dichromatic = PointerProperty(name="Dichromatic", type=DichromaticViewLayerSettings)


def unregister() -> None:
    """Take them off again."""
    del bpy.types.ViewLayer.dichromatic
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
