"""Meshes, cameras and rays: who is seen, who is lit. Nothing here knows of spectra."""

from __future__ import annotations

from .acceleration import Acceleration, AccelerationCache
from .bvh import Bvh
from .camera import Camera
from .geometry import Geometry
from .hits import Hits, offset_origins
from .mesh import Instance, Mesh
from .rasterize import PrimaryView, primary_hits
from .sampling import PIXEL_FILTERS, disk_points, pixel_offsets, polygon_points, sobol_points, square_points
from .shadows import LightView, occluded_from_direction, occluded_from_point
from .solids import Solids, sight_box

__all__ = [
    "PIXEL_FILTERS",
    "Acceleration",
    "AccelerationCache",
    "Bvh",
    "Camera",
    "Geometry",
    "Hits",
    "Instance",
    "LightView",
    "Mesh",
    "PrimaryView",
    "Solids",
    "disk_points",
    "occluded_from_direction",
    "occluded_from_point",
    "offset_origins",
    "pixel_offsets",
    "polygon_points",
    "primary_hits",
    "sight_box",
    "sobol_points",
    "square_points",
]
