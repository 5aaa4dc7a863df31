"""A monkey in the window: random clicks, values, nodes, operators, undos and renders, the same for the same seed."""

from __future__ import annotations

import random
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
from stage import ENGINE, PACKAGE, Stage, Step, act, until

NODES = ("Plastic", "Cloth", "Metal", "Spectrum", "SpectrumMix")
WORDS = ("", "D65", "A", "FL11", "no such lamp", "white 9.5", "copper", "gold", "//none.csv", "/nowhere/at/all.spd")
CALM = {"samples": 4, "max_bounces": 5, "adaptive_min_samples": 8, "columns": 6, "term_limit": 64}  # so that it goes on
NOT_CALLED = {"open_render", "save_render", "write_spectral_exr", "import_material", "pick_pixel"}  # they ask for files
TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "MATERIAL", "DATA")
EDITORS = ("VIEW_3D", "ShaderNodeTree", "IMAGE_EDITOR")


class Monkey:
    def __init__(self, stage: Stage, seed: int) -> None:
        self.stage = stage
        self.random = random.Random(seed)
        self.done: Counter[str] = Counter()

    # ---- values

    def owners(self) -> Iterator[Any]:
        scene = self.stage.scene
        yield from (scene.dichromatic, scene.dichromatic_studies)
        yield from (light.dichromatic for light in bpy.data.lights)
        yield from (world.dichromatic for world in bpy.data.worlds)
        yield from (layer.dichromatic for layer in scene.view_layers if hasattr(layer, "dichromatic"))
        yield bpy.context.preferences.addons[PACKAGE].preferences
        for material in bpy.data.materials:
            if material.node_tree is not None:
                yield from (node for node in material.node_tree.nodes if node.bl_idname.startswith("Dichromatic"))

    def random_value(self, known: Any) -> Any:
        if known.type == "ENUM":
            return self.random.choice(known.enum_items.keys())
        if known.type == "BOOLEAN":
            return self.random.random() < 0.5
        if known.type == "STRING":
            return self.random.choice(WORDS)
        low, high = (known.soft_min, known.soft_max) if self.random.random() < 0.8 else (known.hard_min, known.hard_max)
        high = min(high, CALM.get(known.identifier, 1e6))
        value = self.random.uniform(max(low, -1e6), high)
        return int(value) if known.type == "INT" else value

    def value(self) -> None:
        owner = self.random.choice(list(self.owners()))
        base = bpy.types.ShaderNodeCustomGroup if isinstance(owner, bpy.types.Node) else None
        common = set(base.bl_rna.properties.keys()) if base else {"rna_type", "name", "bl_idname"}
        names = sorted(set(owner.bl_rna.properties.keys()) - common)
        if not names:
            return
        known = owner.bl_rna.properties[self.random.choice(names)]
        if known.is_readonly or known.type in ("POINTER", "COLLECTION") or getattr(known, "is_array", False):
            return
        self.say(f"{type(owner).__name__}.{known.identifier}")
        setattr(owner, known.identifier, self.random_value(known))

    def socket(self) -> None:
        nodes = [owner for owner in self.owners() if isinstance(owner, bpy.types.Node)]
        sockets = [socket for node in nodes for socket in node.inputs if hasattr(socket, "default_value")]
        if sockets:
            socket = self.random.choice(sockets)
            self.say(f"{socket.node.name}.{socket.name}")
            if hasattr(socket.default_value, "__len__"):
                socket.default_value = [self.random.random() for _ in socket.default_value]
            else:
                socket.default_value = self.random_value(socket.bl_rna.properties["default_value"])

    def blender_value(self) -> None:
        scene, light = self.stage.scene, self.random.choice(list(bpy.data.lights))
        choices: list[tuple[Any, str, Any]] = [
            (scene.render, "film_transparent", self.random.random() < 0.3),
            (scene.render, "use_border", self.random.random() < 0.3),
            (scene.render, "use_persistent_data", self.random.random() < 0.5),
            (scene.view_settings, "view_transform", self.random.choice(("Standard", "AgX", "Raw"))),
            (light, "energy", self.random.choice((0.0, 1.0, 500.0))),
            (light, "type", self.random.choice(("POINT", "SUN", "SPOT", "AREA"))),
            (scene.camera.data, "type", self.random.choice(("PERSP", "ORTHO", "PANO"))),
            (scene, "frame_current", self.random.randrange(1, 20)),
        ]
        owner, name, value = self.random.choice(choices)
        self.say(f"{name} = {value}")
        setattr(owner, name, value)

    # ---- nodes and objects

    def node(self) -> None:
        tree = self.random.choice([m.node_tree for m in bpy.data.materials if m.node_tree is not None])
        nodes = list(tree.nodes)
        if self.random.random() < 0.4 or not nodes:
            kind = "DichromaticNode" + self.random.choice(NODES)
            self.say(f"new {kind}")
            tree.nodes.new(kind)
        elif self.random.random() < 0.3:
            self.say("remove a node")
            tree.nodes.remove(self.random.choice(nodes))
        else:
            outputs = [socket for node in nodes for socket in node.outputs]
            inputs = [socket for node in nodes for socket in node.inputs]
            if outputs and inputs:
                giver, taker = self.random.choice(outputs), self.random.choice(inputs)
                self.say(f"link {giver.node.name} to {taker.node.name}.{taker.name}")
                tree.links.new(giver, taker)

    def thing(self) -> None:
        made = self.random.choice(list(self.stage.scene.objects))
        action = self.random.choice(("active", "move", "hide"))
        self.say(f"{action} {made.name}")
        if action == "move":
            made.location = [self.random.uniform(-3, 3) for _ in range(3)]
        elif action == "hide":
            made.hide_render = not made.hide_render
        else:
            self.stage.window.view_layer.objects.active = made

    # ---- operators

    def operator(self) -> None:
        name = self.random.choice([name for name in dir(bpy.ops.dichromatic) if name not in NOT_CALLED])
        operator = getattr(bpy.ops.dichromatic, name)
        given = {}
        for known in operator.get_rna_type().properties:
            usable = known.type in ("ENUM", "BOOLEAN", "INT", "FLOAT", "STRING") and not getattr(
                known, "is_array", False
            )
            if known.identifier != "rna_type" and usable and not known.is_hidden and self.random.random() < 0.7:
                given[known.identifier] = self.random_value(known)
        area = self.random.choice([area for area in self.stage.window.screen.areas if area.type != "TOPBAR"])
        with self.stage.override(area):
            if not operator.poll():
                return
            self.say(f"operator {name} {given}")
            operator(**given)

    def push(self) -> None:
        with self.stage.override(self.stage.area("PROPERTIES")):
            bpy.ops.ed.undo_push(message="monkey")

    def history(self) -> None:
        with self.stage.override(self.stage.area("PROPERTIES")):
            action = self.random.choice(("undo", "undo", "redo"))
            self.say(action)
            if action == "undo" and bpy.ops.ed.undo.poll():
                bpy.ops.ed.undo()
            elif action == "redo" and bpy.ops.ed.redo.poll():
                bpy.ops.ed.redo()

    def render(self) -> None:
        if not bpy.app.is_job_running("RENDER"):
            self.say("F12")
            with self.stage.override(self.stage.area("PROPERTIES")):
                bpy.ops.render.render("INVOKE_DEFAULT")

    # ---- the window

    def look(self) -> None:
        try:
            if self.random.random() < 0.7:
                tab = self.random.choice(TABS)
                self.say(f"tab {tab}")
                self.stage.area("PROPERTIES").spaces.active.context = tab
                return
        except TypeError:  # not for this object
            return
        area = max(self.stage.window.screen.areas, key=lambda a: a.width * a.height)
        area.ui_type = self.random.choice(EDITORS)
        self.say(f"editor {area.ui_type}")
        if area.type == "VIEW_3D":
            area.spaces.active.shading.type = self.random.choice(("SOLID", "RENDERED", "RENDERED", "MATERIAL"))
        elif area.type == "IMAGE_EDITOR":
            area.spaces.active.show_region_ui = True

    def click(self) -> None:
        window = self.stage.window
        shown = [
            (area, region)
            for area in window.screen.areas
            if area.type in ("PROPERTIES", "IMAGE_EDITOR")
            for region in area.regions
            if region.type in ("WINDOW", "UI", "NAVIGATION_BAR") and region.width > 20 and region.height > 20
        ]
        if not shown:  # an earlier click made another area cover the window
            self.say("nowhere to click")
            return
        area, region = self.random.choice(shown)
        x = region.x + self.random.randrange(5, region.width - 5)
        y = region.y + self.random.randrange(5, region.height - 5)
        self.say(f"click {area.type} {region.type} ({x}, {y})")
        window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
        window.event_simulate("LEFTMOUSE", "PRESS", x=x, y=y)
        window.event_simulate("LEFTMOUSE", "RELEASE", x=x, y=y)
        if self.random.random() < 0.7:
            window.event_simulate("ESC", "PRESS", x=x, y=y)
            window.event_simulate("ESC", "RELEASE", x=x, y=y)

    # ---- all of it

    def say(self, text: str) -> None:
        print(f"monkey {sum(self.done.values())}: {text}", flush=True)

    def act(self) -> None:
        actions: list[tuple[Callable[[], None], int]] = [
            (self.value, 10),
            (self.socket, 5),
            (self.blender_value, 3),
            (self.node, 4),
            (self.thing, 3),
            (self.operator, 5),
            (self.history, 3),
            (self.render, 1),
            (self.look, 3),
            (self.click, 8),
        ]
        action = self.random.choices([a for a, _ in actions], [weight for _, weight in actions])[0]
        self.done[action.__name__] += 1
        try:
            action()
            if action in (self.value, self.socket, self.blender_value, self.node, self.thing, self.operator):
                self.push()  # as Blender does for what a user edits; without it, its undo is led astray and crashes
        except RuntimeError as error:  # what an operator reports to the user
            if "Traceback" in str(error):
                self.wrong(error)
        except (TypeError, ValueError, ReferenceError, AttributeError, KeyError) as error:
            self.wrong(error)

    def wrong(self, error: Exception) -> None:
        text = "".join(traceback.format_exception(error))
        self.stage.report.setdefault("wrong", []).append(text)
        print(f"monkey: WRONG {text}", flush=True)


def tidy(stage: Stage) -> None:
    """Put back what would end the test: another engine, another window, no camera, a dead tree."""
    while len(bpy.context.window_manager.windows) > 1 and not bpy.app.is_job_running("RENDER"):
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[-1]):
            bpy.ops.wm.window_close()
    scene = stage.scene
    if scene.render.engine != ENGINE:
        scene.render.engine = ENGINE
    if scene.camera is None or scene.camera.type != "CAMERA":
        scene.camera = next(made for made in scene.objects if made.type == "CAMERA")
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 96, 54, 100
    if stage.window.screen.areas and not any(area.type == "PROPERTIES" for area in stage.window.screen.areas):
        min(stage.window.screen.areas, key=lambda a: a.width).ui_type = "PROPERTIES"
    stage.window.view_layer.update()


def script(stage: Stage) -> Step:
    seed, seconds = int(stage.arguments[0]), float(stage.arguments[1])
    yield until(lambda: stage.window.screen, "there was a window")
    scene = stage.scene
    scene.render.engine = ENGINE
    bpy.context.preferences.view.render_display_type = "NONE"
    editing = sys.modules[f"{PACKAGE}.dichromatic_addon.nodes.editing"]
    editing.set_surface_node(bpy.data.materials["Material"], "DichromaticNodePlastic")
    for kind in ("SUN", "SPOT", "AREA"):
        lamp = bpy.data.objects.new(kind.title(), bpy.data.lights.new(kind.title(), kind))
        lamp.location = (2.0, -2.0, 4.0)
        scene.collection.objects.link(lamp)
    with stage.override():
        bpy.ops.mesh.primitive_monkey_add(location=(2, 0, 0))
    bpy.data.objects["Suzanne"].data.materials.append(bpy.data.materials["Material"])
    monkey = Monkey(stage, seed)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        tidy(stage)
        monkey.act()
        turns = iter(range(2))
        yield until(lambda turns=turns: next(turns, None) is None, "Blender handled it")  # draws, events, jobs
    yield until(lambda: not bpy.app.is_job_running("RENDER"), "the last render was over", limit=300.0)
    stage.report["done"] = dict(monkey.done)


act(script)
