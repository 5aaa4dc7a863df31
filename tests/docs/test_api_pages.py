"""The reference holds every public name of the core, each with a docstring to show."""

from __future__ import annotations

import importlib
import re

import pytest

import spectral_core
from tools.api_pages import PACKAGES, api_pages, public_names

VALUES = {"__version__"}


def test_every_public_name_has_its_place() -> None:
    shown = re.findall(r"^::: (\S+)$", "\n".join(api_pages().values()), re.MULTILINE)
    assert len(shown) == len(set(shown)), "a name stands on two pages"
    wanted = {f"spectral_core.{name}" for name in spectral_core.__all__ if name not in VALUES | set(PACKAGES)}
    assert wanted <= set(shown)
    for package in PACKAGES:
        module = importlib.import_module(f"spectral_core.{package}")
        for name in module.__all__:
            assert {f"spectral_core.{name}", f"spectral_core.{package}.{name}"} & set(shown), f"{package}.{name}"


@pytest.mark.parametrize("path", sorted(public_names()))
def test_public_name_can_be_looked_up(path: str) -> None:
    module, _, name = path.rpartition(".")
    thing = getattr(importlib.import_module(module), name)
    if callable(thing):
        assert thing.__doc__, f"{path} has no docstring"


def test_no_page_is_empty() -> None:
    for page, text in api_pages().items():
        assert ":::" in text or page == "api/index.md", page
