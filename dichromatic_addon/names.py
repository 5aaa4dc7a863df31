"""Names that several modules of the add-on share; what is stored in .blend files must never change."""

from __future__ import annotations

__all__ = [
    "CLOTH_NODE",
    "ENGINE_ID",
    "METAL_NODE",
    "PLASTIC_NODE",
    "SPECTRUM_MIX_NODE",
    "SPECTRUM_NODE",
    "SPECTRUM_NODES",
    "SURFACE_NODES",
]

ENGINE_ID = "DICHROMATIC"

PLASTIC_NODE = "DichromaticNodePlastic"
CLOTH_NODE = "DichromaticNodeCloth"
METAL_NODE = "DichromaticNodeMetal"
SPECTRUM_NODE = "DichromaticNodeSpectrum"
SPECTRUM_MIX_NODE = "DichromaticNodeSpectrumMix"

SPECTRUM_NODES = (SPECTRUM_NODE, SPECTRUM_MIX_NODE)
SURFACE_NODES = [PLASTIC_NODE, CLOTH_NODE, METAL_NODE]  # nodes.surfaces.add_surface_node adds to it
