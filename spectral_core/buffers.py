"""What is known of the first surface behind each pixel, apart from its light."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["BUFFERS", "SurfaceBuffers"]

BUFFERS = ("normal", "position", "object_index", "material_index")
"""Buffers that a render keeps when asked; depth is always kept."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceBuffers:
    """The surface that the first sample of each pixel met; nothing is filtered, so that numbers stay what they are.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        Distance along the view axis (m); infinite where nothing was met.
    normal : ndarray of float32, shape (H, W, 3), or None
        Unit shading normal in the world, on the viewer's side; 0 where nothing was met. None when not asked for.
    position : ndarray of float32, shape (H, W, 3), or None
        Place in the world (m); 0 where nothing was met.
    object_index : ndarray of int32, shape (H, W), or None
        Number of the instance in the scene; -1 where nothing was met.
    material_index : ndarray of int32, shape (H, W), or None
        Number of the material in the scene; -1 where nothing was met.
    """

    depth: NDArray[np.float32]
    normal: NDArray[np.float32] | None = None
    position: NDArray[np.float32] | None = None
    object_index: NDArray[np.int32] | None = None
    material_index: NDArray[np.int32] | None = None

    @classmethod
    def empty(cls, height: int, width: int, names: tuple[str, ...] = ()) -> SurfaceBuffers:
        """Make buffers in which nothing was met.

        Parameters
        ----------
        height, width : int
            Size in pixels.
        names : tuple of str
            Which of `BUFFERS` to have besides the depth.

        Returns
        -------
        SurfaceBuffers
            To be filled by :meth:`put`.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        made: dict[str, NDArray[Any]] = {"depth": np.full((height, width), np.inf, np.float32)}
        for name in names:
            made[name] = (
                np.full((height, width), -1, np.int32)
                if name.endswith("index")
                else np.zeros((height, width, 3), np.float32)
            )
        return cls(**made)

    @property
    def names(self) -> tuple[str, ...]:
        """The buffers that there are, depth among them."""
        return tuple(f.name for f in fields(self) if getattr(self, f.name) is not None)

    def put(self, pixels: NDArray[np.integer[Any]], values: dict[str, NDArray[Any]]) -> None:
        """Write what some pixels met, in place.

        Parameters
        ----------
        pixels : ndarray of int, shape (N,)
            Flat pixel indices.
        values : dict of str to ndarray
            For each buffer that there is, N values or rows.

        Raises
        ------
        KeyError
            If a buffer has no values.

        References
        ----------
        Own design.
        """
        for name in self.names:
            array = getattr(self, name)
            array.reshape(-1, *array.shape[2:])[pixels] = values[name]
