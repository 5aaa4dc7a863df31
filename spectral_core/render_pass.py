"""One kind of work of a render, done or left out, and why."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["RenderPass"]


@dataclass(frozen=True, slots=True)
class RenderPass:
    """One kind of work, done or left out.

    Attributes
    ----------
    name : str
        What would be done.
    is_needed : bool
        Whether it is.
    reason : str
        Why, or why not.
    """

    name: str
    is_needed: bool
    reason: str
