"""What the scripts inside Blender share: steps that wait for something to happen, and never for time to pass.

A script is a generator. It does something and yields :func:`until` a condition holds; a timer of Blender's main loop
asks for it, so that Blender handles its events, draws and renders in between as it does for a user.
"""

from __future__ import annotations

import json
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
from x_window import screen_pixels, write_png

__all__ = ["ENGINE", "PACKAGE", "Stage", "Step", "Until", "act", "choices_of_node", "states_of", "until"]

ENGINE = "DICHROMATIC"
PACKAGE = "bl_ext.user_default.dichromatic"
_TICK = 0.01  # seconds between two questions whether a condition holds


@dataclass(frozen=True)
class Until:
    """A condition to wait for.

    Attributes
    ----------
    holds : callable
        Asked until it is true.
    what : str
        Told when it never is.
    limit : float
        Seconds after which the script has failed.
    """

    holds: Callable[[], Any]
    what: str
    limit: float = 60.0


def until(holds: Callable[[], Any], what: str, limit: float = 60.0) -> Until:
    return Until(holds, what, limit)


Step = Generator[Until, None, None]


class Stage:
    """The window, its areas, and the report.

    Attributes
    ----------
    report : dict
        Written as ``report.json`` at the end.
    drawn : Counter
        How often each panel of the add-on was drawn, by its class's name.
    arguments : list of str
        Those after the folder.
    """

    def __init__(self) -> None:
        given = sys.argv[sys.argv.index("--") + 1 :]
        self.folder = Path(given[0])
        self.arguments = given[1:]
        self.report: dict[str, Any] = {"version": bpy.app.version_string, "shots": []}
        self.drawn: Counter[str] = Counter()
        self._panels: list[Any] = []

    # ---- the window

    @property
    def window(self) -> Any:
        return bpy.context.window_manager.windows[0]

    @property
    def scene(self) -> Any:
        return self.window.scene

    def area(self, kind: str) -> Any:
        """The largest area of a kind."""
        return max((a for a in self.window.screen.areas if a.type == kind), key=lambda a: a.width * a.height)

    def override(self, area: Any = None, region: str = "WINDOW") -> Any:
        """The context that an operator has that is called in an area."""
        area = area or self.area("VIEW_3D")
        found = next(r for r in area.regions if r.type == region)
        return bpy.context.temp_override(
            window=self.window, screen=self.window.screen, area=area, region=found, scene=self.scene
        )

    def redraw(self) -> None:
        """Draw the window now."""
        with bpy.context.temp_override(window=self.window, screen=self.window.screen):
            bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)

    def shot(self, name: str, area: Any = None) -> None:
        """Keep a picture of an area, or of the whole window."""
        left, top, width, height = 0, 0, self.window.width, self.window.height
        if area is not None:
            left, top, width, height = area.x, self.window.height - area.y - area.height, area.width, area.height
        write_png(self.folder / f"{name}.png", screen_pixels(left, top, width, height))
        self.report["shots"].append(name)

    def press(self, key: str, area: Any = None, **modifiers: bool) -> None:
        """Press a key and let it go, with the mouse over the middle of an area."""
        area = area or self.area("VIEW_3D")
        x, y = area.x + area.width // 2, area.y + area.height // 2
        self.window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
        self.window.event_simulate(key, "PRESS", x=x, y=y, **modifiers)
        self.window.event_simulate(key, "RELEASE", x=x, y=y, **modifiers)

    def tab(self, name: str) -> Until:
        """Ask the Properties editor for a tab, until it has it: its list of tabs is made when it is drawn."""
        area = self.area("PROPERTIES")

        def has_it() -> bool:
            try:
                area.spaces.active.context = name
            except TypeError:
                area.tag_redraw()
                return False
            return True

        return until(has_it, f"the Properties editor had the tab {name}", limit=20.0)

    def tabs(self) -> list[str]:
        """The tabs that the Properties editor has now."""
        space = self.area("PROPERTIES").spaces.active
        found = []
        for name in list(space.bl_rna.properties["context"].enum_items.keys()):
            try:
                space.context = name
            except TypeError:  # not for this object
                continue
            found.append(name)
        return found

    # ---- the add-on

    def module(self, name: str) -> Any:
        """A module of the add-on."""
        return sys.modules[f"{PACKAGE}.dichromatic_addon.{name}"]

    def watch_panels(self) -> None:
        """Open the add-on's panels, and count from now on how often each is drawn."""
        for name in ("panels", "study_panels"):
            module = self.module(name)
            classes = [cls for cls in module.CLASSES if issubclass(cls, bpy.types.Panel)]
            for cls in reversed(classes):
                bpy.utils.unregister_class(cls)
            for cls in classes:
                cls.bl_options = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
                cls.draw = self._counting(cls.__name__, cls.draw)
                bpy.utils.register_class(cls)
                self._panels.append(cls)

    def panels_of(self, area: Any, region: str = "WINDOW") -> list[str]:
        """The add-on's panels that an area has to show, by their classes' names."""
        tab = area.spaces.active.context.lower() if area.type == "PROPERTIES" else None
        wanted = []
        with self.override(area, region):
            for cls in self._panels:
                is_here = cls.bl_space_type == area.type and cls.bl_region_type == region
                if is_here and tab in (None, getattr(cls, "bl_context", None)) and cls.poll(bpy.context):
                    wanted.append(cls.__name__)
        return wanted

    def show(self, area: Any, state: str, region: str = "WINDOW") -> Step:
        """Have an area drawn, with all panels of the add-on that belong there."""
        before = Counter(self.drawn)
        wanted: list[str] = []
        rounds = 0

        def is_drawn() -> bool:
            nonlocal rounds
            rounds += 1
            if rounds % 100 == 1:  # at first, and again where Blender had something else to do
                area.tag_redraw()
                return False
            wanted[:] = self.panels_of(area, region)  # known once the editor has found out what it shows
            return all(self.drawn[name] > before[name] for name in wanted)

        self.report.setdefault("states", []).append(state)
        yield until(is_drawn, f"the panels were drawn in the state: {state}", limit=20.0)

    def _counting(self, name: str, draw: Callable[..., None]) -> Callable[..., None]:
        def counted(panel: Any, context: Any) -> None:
            draw(panel, context)  # an exception is Blender's to print, and the panel does not count as drawn
            self.drawn[name] += 1

        return counted


def states_of(settings: Any) -> Iterator[str]:
    """Bring a group of settings into each state that its choices and switches offer, one away from where it started."""
    for known in settings.bl_rna.properties:
        if not known.is_readonly and not getattr(known, "is_array", False):
            yield from _values(settings, known, but_the_present=True)


def choices_of_node(node: Any) -> Iterator[str]:
    """States of the choices that the node has beyond those of all group nodes."""
    for name in sorted(
        set(node.bl_rna.properties.keys()) - set(bpy.types.ShaderNodeCustomGroup.bl_rna.properties.keys())
    ):
        yield from _values(node, node.bl_rna.properties[name])


def _values(owner: Any, known: Any, *, but_the_present: bool = False) -> Iterator[str]:
    """Give a choice or switch each value, with what it hangs on, and put all back."""
    name = known.identifier
    if known.type not in ("ENUM", "BOOLEAN"):
        return
    source = getattr(owner, "source", None)
    before = getattr(owner, name)
    if name == "radiator":  # else it is not to be seen
        owner.source = "TEMPERATURE"
    for value in known.enum_items.keys() if known.type == "ENUM" else (False, True):
        if not (but_the_present and value == before):
            setattr(owner, name, value)
            yield f"{name} {value}"
    setattr(owner, name, before)
    if name == "radiator":
        owner.source = source


def act(script: Callable[[Stage], Step]) -> None:
    """Play a script in the main loop, write its report, and end Blender as its menu does."""
    stage = Stage()
    bpy.ops.preferences.addon_enable(module=PACKAGE)
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.smooth_view = 0  # a view that is framed is there at once
    bpy.context.preferences.filepaths.use_auto_save_temporary_files = False
    steps = script(stage)
    waiting: list[tuple[Until, float]] = []

    def tick() -> float | None:
        try:
            while True:
                if waiting:
                    condition, since = waiting[0]
                    if not condition.holds():
                        if time.monotonic() - since > condition.limit:
                            raise TimeoutError(f"waited {condition.limit:g} s in vain until {condition.what}")
                        return _TICK
                    waiting.clear()
                waiting.append((next(steps), time.monotonic()))
                print(f"stage: until {waiting[0][0].what}", flush=True)
        except StopIteration:
            pass
        except BaseException:
            stage.report["failure"] = traceback.format_exc()
        (stage.folder / "report.json").write_text(json.dumps(stage.report, indent=1), encoding="utf-8")
        with bpy.context.temp_override(window=stage.window):
            bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(tick, first_interval=_TICK, persistent=True)
