"""Spectral rendering with Tominaga's three dichromatic reflection models, in pure numpy.

Light along any path is a product of spectra with a geometric coefficient. The renderer keeps the two apart: the film
holds coefficients, the spectra are integrated once per scene, and a lamp or a paint can be exchanged after the render.
"""

from __future__ import annotations

__version__ = "0.1.0"

__all__ = ["__version__"]
