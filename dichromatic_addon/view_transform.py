"""What Blender's colour management does to our colours on their way to the screen, said in words.

Our pixels are linear light. One view shows them as they were computed: *Standard*, which encodes them for the display
and clips what it cannot show. The others restyle them on purpose.
"""

from __future__ import annotations

from typing import Any

__all__ = ["is_colorimetric", "view_notes"]

_PURPOSE = {
    "Raw": "Raw shows linear light without the display's encoding, so that all looks too dark; it is for data passes",
    "False Color": "False Color paints exposure, not colors",
}


def view_notes(scene: Any) -> list[str]:
    """Say what keeps the picture on the screen from being colorimetric.

    Parameters
    ----------
    scene : bpy.types.Scene
        Whose view settings count.

    Returns
    -------
    list of str
        A line for each reason; empty when colours within the display's gamut are shown as computed.

    Raises
    ------
    None.

    References
    ----------
    Blender manual, Color Management; measured in the tests against IEC 61966-2-1.
    """
    view = scene.view_settings
    notes = []
    transform = view.view_transform
    if transform != "Standard":
        purpose = _PURPOSE.get(transform, f"{transform} restyles colors")
        notes.append(f"{purpose}. Standard shows colors as computed")
    if view.look != "None":
        notes.append(f"The look '{view.look}' restyles colors")
    if view.gamma != 1.0:
        notes.append(f"A gamma of {view.gamma:.3g} changes contrast and saturation")
    if view.use_curve_mapping:
        notes.append("The curves of Color Management restyle colors")
    if getattr(view, "use_white_balance", False):
        notes.append("Blender's white balance adapts colors once more, after the adopted white of this engine")
    return notes


def is_colorimetric(scene: Any) -> bool:
    """Whether colours within the display's gamut are shown as computed, up to exposure."""
    return not view_notes(scene)
