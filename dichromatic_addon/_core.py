"""The one door from the add-on to the core.

Inside Blender the extension is ``bl_ext.<repository>.dichromatic`` and the core its subpackage; with pip or in
pytest both are top-level packages. Exactly one of the two names may exist in a process, so nothing else in the
add-on imports the core.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING or __package__ == "dichromatic_addon":
    import spectral_core as core
else:
    from .. import spectral_core as core

__all__ = ["core"]
