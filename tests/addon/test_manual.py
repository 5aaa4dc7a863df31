"""Every property and operator of ours has a tooltip, and a page of the manual that is there."""

from __future__ import annotations

from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from dichromatic_addon import manual, preferences

pytestmark = pytest.mark.bpy

PAGES = Path(__file__).resolve().parent.parent.parent / "docs" / "manual"


def own_classes(base: Any) -> Iterator[Any]:
    for cls in base.__subclasses__():
        if cls.__module__.startswith("dichromatic_addon"):
            yield cls


def own_properties() -> Iterator[tuple[str, Any]]:
    """Our properties with the names that Blender looks them up by."""
    groups = [*own_classes(bpy.types.PropertyGroup), *own_classes(bpy.types.AddonPreferences)]
    assert len(groups) >= 6
    for cls in groups:
        for known in cls.bl_rna.properties:
            if known.identifier not in ("rna_type", "name", "bl_idname"):
                yield f"bpy.types.{cls.__name__}.{known.identifier}".lower(), known
    for cls in own_classes(bpy.types.Operator):
        category, name = cls.bl_idname.split(".")
        for known in getattr(getattr(bpy.ops, category), name).get_rna_type().properties:
            if known.identifier != "rna_type" and not known.is_hidden:
                yield f"bpy.ops.{cls.bl_idname}.{known.identifier}".lower(), known


def test_every_property_has_a_tooltip(addon: Any) -> None:
    missing = [name for name, known in own_properties() if not known.description]
    assert missing == []


def test_every_operator_has_a_tooltip(addon: Any) -> None:
    operators = list(own_classes(bpy.types.Operator))
    assert len(operators) > 10
    for cls in operators:
        assert getattr(cls, "bl_description", "") or cls.__doc__, cls.bl_idname


def test_every_property_has_a_page(addon: Any) -> None:
    for name, _ in own_properties():
        page = next((page for pattern, page in manual.PAGES if fnmatchcase(name, pattern)), None)
        assert page is not None, f"{name} has no page of the manual"
        assert (PAGES / f"{page}.md").is_file(), f"{name} leads to the page {page}, which is not there"


@pytest.mark.parametrize(
    ("place", "prefix"),
    [
        ("https://example.org/dichromatic/", "https://example.org/dichromatic/manual/"),
        ("/opt/dichromatic/site", "file:///opt/dichromatic/site/manual/"),
    ],
)
def test_manual_is_where_the_preferences_say(addon: Any, monkeypatch: Any, place: str, prefix: str) -> None:
    monkeypatch.setattr(manual, "preferences", lambda: SimpleNamespace(manual=place))
    found, pages = manual.manual_map()
    assert found == prefix
    assert ("bpy.types.dichromaticnode*", "material.html") in pages


def test_without_a_place_there_is_no_manual(addon: Any, monkeypatch: Any) -> None:
    assert manual.manual_map() == ("", ())
    assert manual.manual_map in bpy.utils._manual_map
    monkeypatch.setattr(manual, "preferences", lambda: SimpleNamespace(manual=" "))
    assert manual.manual_map() == ("", ())


@pytest.mark.parametrize("lamp", ["", "A", "no such lamp"])
def test_new_files_start_with_the_preferred_lamp(scene: Any, monkeypatch: Any, lamp: str) -> None:
    chosen = SimpleNamespace(observer="cie_1964_10", samples=7, lamp=lamp)
    monkeypatch.setattr(preferences, "preferences", lambda: chosen)
    own = bpy.data.lights.new("Own", "POINT")
    own.dichromatic.source = "TEMPERATURE"
    new = bpy.data.lights.new("New", "POINT")
    preferences._start_new_file()
    assert (scene.dichromatic.observer, scene.dichromatic.samples) == ("cie_1964_10", 7)
    assert own.dichromatic.source == "TEMPERATURE"
    assert (new.dichromatic.source, new.dichromatic.illuminant) == (
        ("LIBRARY", "A") if lamp == "A" else ("COLOR", "D65")
    )
