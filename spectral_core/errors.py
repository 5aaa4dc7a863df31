"""The exceptions a caller of the core may catch.

Every one of them derives from :class:`DichromaticError`; those that report a bad value are also
:class:`ValueError`, so that code written against numpy's habits keeps working.
"""

from __future__ import annotations

__all__ = [
    "DichromaticError",
    "FittingError",
    "InvalidParameterError",
    "MemoryLimitError",
    "MissingDependencyError",
    "RenderCancelledError",
    "SceneError",
    "SpectrumFileError",
]


class DichromaticError(Exception):
    """Base class of every error that this package raises on purpose."""


class InvalidParameterError(DichromaticError, ValueError):
    """A parameter breaks its rule; the message names the parameter, the rule and the value."""


class SpectrumFileError(DichromaticError, ValueError):
    """A spectrum file cannot be read; the message names the file, the line and the reason."""


class FittingError(DichromaticError, ValueError):
    """Measured spectra do not determine what was asked of them (too few, all zero, no angles)."""


class SceneError(DichromaticError, ValueError):
    """A scene cannot be rendered (no camera, a mesh with NaN, an index without a material)."""


class MemoryLimitError(DichromaticError, MemoryError):
    """A result would need more memory than the caller allowed."""


class MissingDependencyError(DichromaticError, ImportError):
    """An optional library is needed for what was asked and is not installed."""


class RenderCancelledError(DichromaticError):
    """The ``cancel`` callable asked for the render to stop."""
