"""The last render of each scene, with its film: what relighting and the studies work on.

It lives in memory only, one for a scene's name; a new render, another file and the end of the add-on let it go.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import bpy
from bpy.app.handlers import persistent

__all__ = [
    "KeptRender",
    "NeedsKeptRender",
    "forget",
    "kept_render",
    "register",
    "remember",
    "renderable_objects",
    "replace_with",
    "unregister",
]

_FACELESS = {"CAMERA", "EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}


@dataclass(slots=True)
class KeptRender:
    """A finished render of a scene.

    Attributes
    ----------
    layers : dict of str to FinishedLayer
        What was rendered, by view layer; without the triangles, which nothing here needs.
    shown : dict of str to FinishedLayer
        The same with the spectra and colours that were applied last.
    source : str
        The file that it was opened from; empty for a render of this session.
    objects : frozenset of str or None
        The objects that could be rendered when it began; None where that is not known.
    outdated : dict of str to None
        What moved or changed its shape since, in words.
    differences : tuple of str
        Where a relit picture departs from a new render.
    problem : str
        Why the last relighting failed; empty when it did not.
    map_report, probe_report : str
        What the last metamerism map and the last probe of this picture found.
    """

    layers: dict[str, Any] = field(default_factory=dict)
    shown: dict[str, Any] = field(default_factory=dict)
    source: str = ""
    objects: frozenset[str] | None = None
    outdated: dict[str, None] = field(default_factory=dict)
    differences: tuple[str, ...] = ()
    problem: str = ""
    map_report: str = ""
    probe_report: str = ""

    def layer(self, name: str) -> Any:
        """Return what is shown of a view layer, or of the first where that one was not rendered."""
        return self.shown.get(name) or next(iter(self.shown.values()))

    @property
    def nbytes(self) -> int:
        """Bytes that the films hold."""
        return sum(finished.render.film.nbytes for finished in self.layers.values())


_kept: dict[str, KeptRender] = {}
_begun: dict[str, frozenset[str]] = {}


def kept_render(scene: Any) -> KeptRender | None:
    """Return the last render of a scene, or None."""
    return _kept.get(scene.name)


def remember(finished: Any) -> None:
    """Keep one view layer's render; the engine calls it, from whatever thread Blender renders in."""
    exported = finished.exported
    name = exported.scene.name
    begun = _begun.pop(name, None)
    kept = _kept.get(name)
    if kept is None or begun is not None or kept.source or exported.layer in kept.layers:
        kept = _kept[name] = KeptRender(objects=begun)
    slim = replace(finished, exported=replace(exported, scene=replace(exported.scene, instances=())))
    kept.layers[exported.layer] = kept.shown[exported.layer] = slim


def replace_with(scene: Any, finished: Any, source: str) -> KeptRender:
    """Keep a render that was opened from a file as the last one of a scene."""
    layer = finished.exported.layer
    kept = _kept[scene.name] = KeptRender({layer: finished}, {layer: finished}, source)
    return kept


def forget(scene: Any) -> None:
    """Let the last render of a scene go."""
    _kept.pop(scene.name, None)


def renderable_objects(scene: Any) -> frozenset[str]:
    """Return the names of the objects that a render may show."""
    return frozenset(obj.name for obj in scene.objects if not obj.hide_render and obj.type not in _FACELESS)


@persistent
def _before_render(scene: Any, *_: Any) -> None:
    if bpy.app.background:  # without a window nothing has evaluated the edits yet: they precede the render
        for view_layer in scene.view_layers:
            view_layer.update()
    _begun[scene.name] = renderable_objects(scene)


@persistent
def _on_load(*_: Any) -> None:
    _kept.clear()
    _begun.clear()


class NeedsKeptRender:
    """For operators: they can be used once a render of the scene is kept."""

    @classmethod
    def poll(cls: Any, context: Any) -> bool:
        if kept_render(context.scene) is None:
            cls.poll_message_set("No render of this scene is kept: render it first, or open one")
            return False
        return True


HANDLERS = (("render_init", _before_render), ("load_pre", _on_load))


def register() -> None:
    """Hang the callbacks into Blender."""
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """Take them out again, and let all renders go."""
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    _on_load()
