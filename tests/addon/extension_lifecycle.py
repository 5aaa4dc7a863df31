"""Takes a zip through the life of an extension in a hermetic Blender; run by test_package.py in a process of its own.

    python extension_lifecycle.py EXTENSION.zip FILE.blend WIDTH HEIGHT RESULT_FOLDER

Writes ``observed.json`` and the linear pixels of two renders, ``first.npy`` and ``second.npy``: with the extension just
installed, and after it was disabled and enabled again. Judging is the test's business.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path

import bpy  # isort: skip  (it puts Blender's own modules on the path)
import addon_utils
import numpy as np

MODULE = "bl_ext.user_default.dichromatic"
OWNERS = (
    "Scene",
    "Light",
    "Material",
    "World",
    "Object",
    "Image",
    "Camera",
    "ViewLayer",
    "WindowManager",
    "ShaderNodeTree",
)


def registered() -> dict[str, list[str]]:
    """Everything that an add-on could leave behind."""
    handlers = {
        name: [getattr(function, "__module__", "") for function in found]
        for name in dir(bpy.app.handlers)
        if isinstance(found := getattr(bpy.app.handlers, name), list)
    }
    compatible, drawn = [], []
    for name in dir(bpy.types):
        cls = getattr(bpy.types, name)
        compatible += [f"{name}: {engine}" for engine in sorted(getattr(cls, "COMPAT_ENGINES", ()))]
        functions = getattr(getattr(cls, "draw", None), "_draw_funcs", ())
        drawn += [f"{name}: {function.__module__}.{function.__qualname__}" for function in functions]
    return {
        "types": sorted(dir(bpy.types)),
        "operators": sorted(name for name in dir(bpy.ops) if "dichromatic" in name),
        "engines": sorted(
            getattr(cls, "bl_idname", cls.__name__)
            for cls in bpy.types.RenderEngine.__subclasses__()
            if getattr(cls, "is_registered", False)
        ),
        "properties": sorted(
            f"{name}.{known.identifier}" for name in OWNERS for known in getattr(bpy.types, name).bl_rna.properties
        ),
        "handlers": sorted(f"{name}: {module}" for name, modules in handlers.items() for module in modules),
        "compatible": sorted(compatible),
        # Blender's own first draw function comes to the list with the first append and stays there.
        "drawn": sorted(line for line in drawn if "dichromatic" in line),
    }


def policy_warnings() -> list[str]:
    addon_utils._extensions_warnings_get._is_first = True
    return [line for lines in addon_utils._extensions_warnings_get().values() for line in lines]


def render(blend: str, width: int, height: int, folder: Path, name: str) -> None:
    bpy.ops.wm.open_mainfile(filepath=blend, load_ui=False)
    scene = bpy.context.scene
    scene.render.engine = "DICHROMATIC"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.filepath = str(folder / f"{name}.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    np.save(folder / f"{name}.npy", pixels.reshape(height, width, 4)[::-1, :, :3])


def main(package: str, blend: str, width: str, height: str, result: str) -> None:
    folder = Path(result)
    size = int(width), int(height)
    before = registered()
    bpy.ops.extensions.package_install_files(filepath=package, repo="user_default", enable_on_install=True)
    try:
        observed = {
            "blender": bpy.app.version_string,
            "enabled": MODULE in bpy.context.preferences.addons,
            "before": before,
            "installed": registered(),
        }
        render(blend, *size, folder, "first")
        observed["policy"] = policy_warnings()
        observed["modules"] = sorted(sys.modules)
        addon_utils.disable(MODULE, default_set=True, handle_error=fail)
        observed["disabled"] = registered()
        addon_utils.enable(MODULE, default_set=True, handle_error=fail)
        observed["again"] = registered()
        render(blend, *size, folder, "second")
    finally:
        # A render engine that is still registered when the interpreter ends crashes 4.2 and hangs 4.5.
        addon_utils.disable(MODULE, default_set=True, handle_error=fail)
    (folder / "observed.json").write_text(json.dumps(observed), encoding="utf-8")


def fail(error: Exception) -> None:
    raise error


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except BaseException:
        # An engine that could not be unregistered would keep 4.5 from ever ending.
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
