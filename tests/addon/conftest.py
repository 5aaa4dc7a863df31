"""The add-on, registered once in this process's Blender, and an empty file for each test that asks for one."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator
from typing import Any

import pytest

# Without the bpy module the tests of the core remain.
collect_ignore_glob = [] if importlib.util.find_spec("bpy") else ["test_*.py"]


_statuses: list[int] = []


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    _statuses.append(int(exitstatus))


def pytest_unconfigure(config: pytest.Config) -> None:
    """End at once when all is reported: Blender 4.5 may wait for ever where Python ends by itself.

    Something that outlives the tests (a traceback of a failure, a cache of `typing`) keeps the bpy module alive; then
    a destructor of Blender's waits for a thread of its own that is only ended when the module is let go. Mended in
    Blender 5.0.
    """
    if _statuses and "bpy" in sys.modules:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_statuses[-1])


@pytest.fixture(scope="session")
def addon() -> Iterator[Any]:
    """The registered add-on; taken out again at the end, for an engine left registered hangs Blender's exit."""
    import dichromatic_addon

    dichromatic_addon.register()
    yield dichromatic_addon
    dichromatic_addon.unregister()


@pytest.fixture
def scene(addon: Any) -> Any:
    """The scene of an empty file, with the dichromatic engine chosen."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "DICHROMATIC"
    return scene
