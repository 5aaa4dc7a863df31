"""The Blender side of Dichromatic: nodes, panels and the render engine around the core."""

from __future__ import annotations

__all__ = ["register", "unregister"]


def _modules() -> tuple[object, ...]:
    """Return the modules in the order of registration; imported late, so that the package itself needs no Blender."""
    from . import (
        cli,
        conversion,
        engine,
        estimation,
        last_render,
        light_linking_panels,
        live_relight,
        manual,
        menus,
        nodes,
        operators,
        panels,
        persistent,
        preferences,
        presets,
        properties,
        render_files,
        render_passes,
        studies,
        study_panels,
        study_settings,
        view_layer_panels,
    )

    studying = (study_settings, last_render, live_relight, persistent, studies, render_files, estimation, study_panels)
    drawing = (presets, panels, view_layer_panels, light_linking_panels)
    return (
        properties,
        render_passes,
        preferences,
        manual,
        nodes,
        *drawing,
        engine,
        operators,
        conversion,
        *studying,
        menus,
        cli,
    )


def register() -> None:
    """Register everything with Blender."""
    for module in _modules():
        module.register()  # type: ignore[attr-defined]


def unregister() -> None:
    """Take everything out of Blender again, last first."""
    for module in reversed(_modules()):
        module.unregister()  # type: ignore[attr-defined]
