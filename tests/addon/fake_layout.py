"""A layout that draws nothing and checks everything: that each property, operator and menu asked for exists."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy


class FakeLayout:
    """Stands in for ``bpy.types.UILayout``, which only a window can make.

    Attributes
    ----------
    drawn : list of tuple
        What was asked for, in order; shared by all sub-layouts.
    """

    def __init__(self, drawn: list[tuple[str, str]] | None = None) -> None:
        self.drawn: list[tuple[str, str]] = [] if drawn is None else drawn
        self.alert = self.active = self.enabled = True
        self.use_property_split = self.use_property_decorate = False
        self.alignment = "EXPAND"

    def _sub(self, **_: Any) -> FakeLayout:
        return FakeLayout(self.drawn)

    row = column = box = _sub

    def split(self, *, factor: float = 0.0, align: bool = False) -> FakeLayout:
        assert 0.0 <= factor <= 1.0
        return self._sub()

    def separator(self, **_: Any) -> None:
        self.drawn.append(("separator", ""))

    def label(self, *, text: str = "", icon: str = "NONE") -> None:
        _require_icon(icon)
        self.drawn.append(("label", text))

    def prop(self, data: Any, name: str, *, text: str | None = None, icon: str = "NONE", **_: Any) -> None:
        assert name in data.bl_rna.properties, f"{data} has no property {name}"
        _require_icon(icon)
        getattr(data, name)
        self.drawn.append(("prop", name))

    def panel(self, idname: str, *, default_closed: bool = False) -> tuple[FakeLayout, FakeLayout | None]:
        return self._sub(), None if default_closed else self._sub()

    def operator(self, idname: str, *, text: str | None = None, icon: str = "NONE", emboss: bool = True) -> Any:
        _require_operator(idname)
        _require_icon(icon)
        self.drawn.append(("operator" if self.enabled else "greyed operator", idname))
        return SimpleNamespace()

    def operator_menu_enum(self, idname: str, name: str, *, text: str = "", icon: str = "NONE") -> Any:
        rna = _require_operator(idname)
        assert name in rna.properties, f"operator {idname} has no property {name}"
        _require_icon(icon)
        self.drawn.append(("operator", idname))
        return SimpleNamespace()

    def menu(self, idname: str, *, text: str = "", icon: str = "NONE") -> None:
        assert hasattr(bpy.types, idname), f"no menu {idname}"
        _require_icon(icon)
        self.drawn.append(("menu", idname))

    def context_pointer_set(self, name: str, data: Any) -> None:
        assert data is None or hasattr(data, "bl_rna")

    def template_icon(self, icon_value: int, *, scale: float = 1.0) -> None:
        assert isinstance(icon_value, int)
        self.drawn.append(("icon", str(icon_value)))

    def template_list(
        self, kind: str, name: str, data: Any, items: str, active_data: Any, active: str, **_: Any
    ) -> None:
        drawer = getattr(bpy.types, kind)
        for property_data, property_name in ((data, items), (active_data, active)):
            assert property_name in property_data.bl_rna.properties
        # Blender's own list draws its items in C.
        for item in getattr(data, items) if hasattr(drawer, "draw_item") else ():
            drawer.draw_item(None, None, self._sub(), data, item, 0, active_data, active)
        self.drawn.append(("template_list", items))

    def template_ID(self, data: Any, name: str, *, new: str = "", open: str = "", **_: Any) -> None:
        assert name in data.bl_rna.properties, f"{data} has no property {name}"
        for idname in filter(None, (new, open)):
            _require_operator(idname)
        self.drawn.append(("template_ID", name))

    def template_light_linking_collection(self, context_layout: Any, data: Any, name: str) -> None:
        assert name in data.bl_rna.properties, f"{data} has no property {name}"
        self.drawn.append(("template_light_linking_collection", name))

    def prop_search(
        self, data: Any, name: str, search_data: Any, search_name: str, *, text: str = "", **_: Any
    ) -> None:
        assert name in data.bl_rna.properties, f"{data} has no property {name}"
        assert search_name in search_data.bl_rna.properties
        self.drawn.append(("prop", name))

    def template_node_view(self, tree: Any, node: Any, socket: Any) -> None:
        assert socket.node == node
        assert node.id_data == tree
        self.drawn.append(("template_node_view", node.name))

    def names(self, kind: str) -> list[str]:
        """What was drawn of one kind."""
        return [name for drawn, name in self.drawn if drawn == kind]


def _require_icon(icon: str) -> None:
    known = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
    assert icon in known, f"no icon {icon}"


def _require_operator(idname: str) -> Any:
    category, name = idname.split(".")
    return getattr(getattr(bpy.ops, category), name).get_rna_type()  # raises KeyError where there is none
