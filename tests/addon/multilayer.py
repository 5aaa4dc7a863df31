"""What Blender wrote into a multilayer EXR, and compositor trees on all versions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from dichromatic_addon import compat

__all__ = ["compositor", "rendered_passes", "single_layer"]


def rendered_passes(scene: Any, path: Path) -> dict[str, np.ndarray]:
    """Render as F12 does into a multilayer EXR and return its passes by name, (H, W, C), row 0 at the top."""
    openimageio = pytest.importorskip("OpenImageIO")
    compat.set_multilayer_exr(scene.render.image_settings)
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    found: dict[str, dict[str, np.ndarray]] = {}
    source = openimageio.ImageInput.open(str(path))
    try:
        part = 0
        while source.seek_subimage(part, 0):
            names = source.spec().channelnames
            values = np.array(source.read_image(part, 0, 0, len(names), openimageio.FLOAT))
            for channel, name in enumerate(names):
                # "ViewLayer.Body.R", or "Body.R" in a part "ViewLayer" from 5.0 on; group names hold no dots.
                *_, pass_name, letter = name.split(".")
                found.setdefault(pass_name, {})[letter] = values[..., channel]
            part += 1
    finally:
        source.close()
    order = "RGBAXYZW"
    return {
        name: np.stack([channels[letter] for letter in sorted(channels, key=order.index)], axis=-1)
        for name, channels in found.items()
    }


def single_layer(scene: Any) -> None:
    """Choose a file with one picture again."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"


def compositor(scene: Any) -> tuple[Any, Any, Any]:
    """Switch the compositor on; return its tree, a Render Layers node and the input socket of the final picture."""
    scene.render.use_compositing = True
    if hasattr(scene, "compositing_node_group"):
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        scene.compositing_node_group = tree
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        final = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        final = tree.nodes.new("CompositorNodeComposite")
    layers = tree.nodes.new("CompositorNodeRLayers")
    layers.scene = scene
    return tree, layers, final.inputs["Image"]
