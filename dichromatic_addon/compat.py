"""Every difference between Blender 4.2, 4.5, 5.0 and 5.2 that the add-on has to know about.

No other module asks for ``bpy.app.version``; where a feature can be asked for instead, it is asked for here as well.
"""

from __future__ import annotations

from typing import Any

import bpy

__all__ = [
    "EMISSION_PASS",
    "ENVIRONMENT_PASS",
    "FILE_PATH_OPTIONS",
    "MATERIAL_INDEX_PASS",
    "OBJECT_INDEX_PASS",
    "ensure_node_tree",
    "light_colour_factor",
    "light_exposure_factor",
    "light_is_normalized",
    "node_tree_of",
    "root_package",
    "set_multilayer_exr",
]

_HAS_PERMANENT_TREES = bpy.app.version >= (5, 0, 0)  # materials and worlds always have nodes; use_nodes is deprecated
# Options of a file property that may hold a path beside the .blend ("//name"); from 4.5 on it must say that it may.
FILE_PATH_OPTIONS = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set[str]()
# Passes that Blender wrote out in 5.0; the compositor and other programs look for these names.
EMISSION_PASS, ENVIRONMENT_PASS, OBJECT_INDEX_PASS, MATERIAL_INDEX_PASS = (
    ("Emission", "Environment", "Object Index", "Material Index")
    if bpy.app.version >= (5, 0, 0)
    else ("Emit", "Env", "IndexOB", "IndexMA")
)
_LIGHTS_HAVE_PERMANENT_TREES = bpy.app.version >= (5, 2, 0)


def node_tree_of(owner: Any) -> Any:
    """Return the node tree that a material, world or light uses, or None where nodes are switched off."""
    if _LIGHTS_HAVE_PERMANENT_TREES if isinstance(owner, bpy.types.Light) else _HAS_PERMANENT_TREES:
        return owner.node_tree
    return owner.node_tree if owner.use_nodes else None


def ensure_node_tree(owner: Any) -> Any:
    """Switch the nodes of a material or world on where that is still a choice, and return the tree."""
    if not _HAS_PERMANENT_TREES:
        owner.use_nodes = True
    return owner.node_tree


def light_exposure_factor(light: Any) -> float:
    """Return the factor that a light's exposure puts on its power (1 before 4.5, which has none)."""
    return float(2.0 ** getattr(light, "exposure", 0.0))


def light_is_normalized(light: Any) -> bool:
    """Whether a light's power is spread over its shape (always so before 4.5)."""
    return bool(getattr(light, "normalize", True))


def light_colour_factor(light: Any) -> tuple[float, float, float]:
    """Return a light's colour in scene linear RGB, with the colour of its temperature where 4.5 and later use one."""
    red, green, blue = light.color
    if getattr(light, "use_temperature", False):
        warm = light.temperature_color
        return float(red * warm[0]), float(green * warm[1]), float(blue * warm[2])
    return float(red), float(green), float(blue)


def has_light_linking_panels() -> bool:
    """Tell whether Blender shows light linking with every engine, as from 4.3 on, and not with Cycles alone."""
    return hasattr(bpy.types, "OBJECT_PT_light_linking")


def set_multilayer_exr(image_settings: Any) -> None:
    """Choose multilayer EXR as the output, which from 5.0 on is a media type of its own."""
    if hasattr(image_settings, "media_type"):
        image_settings.media_type = "MULTI_LAYER_IMAGE"
    image_settings.file_format = "OPEN_EXR_MULTILAYER"


def root_package() -> str:
    """Return the name of the extension in Blender (``bl_ext.<repository>.dichromatic``), for its preferences."""
    package = __package__ or ""
    return package.rpartition(".")[0] or package
