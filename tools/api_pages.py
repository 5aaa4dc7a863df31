"""A hook of MkDocs: pages of the API reference, one a room of the core, for whatever is public in spectral_core.

Nothing is listed by hand: the names come from ``spectral_core/__init__.py`` and from the ``__all__`` of its public
packages, and the text from their docstrings, through mkdocstrings. A name that is new is in the reference with the
next ``make docs``.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
CORE = ROOT / "spectral_core"

__all__ = ["PAGES", "api_pages", "on_config", "on_files", "public_names"]

# Title of a page, and the modules whose public names stand on it; modules that no page names go to the last.
PAGES: dict[str, tuple[str, ...]] = {
    "Scenes": ("scene", "tracing", "lights", "environment"),
    "Materials": ("reflection", "textures"),
    "Spectra": ("spectra", "resampling", "library", "spectrum_files", "rgb_uplift", "tables"),
    "Colour": ("colorimetry", "display", "display_files", "development"),
    "Rendering": ("renderer", "plan", "estimate", "tradeoff", "statistics", "film"),
    "After the render": ("scene_spectra", "studies", "probe", "render_file", "spectral_exr", "image_io"),
    "Fitting": ("fitting",),
    "Errors and files": (),
}
PACKAGES = ("fitting", "reflection", "tracing")  # whose own __all__ is public beside that of spectral_core


def _all_of(tree: ast.Module) -> list[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            return list(ast.literal_eval(node.value))
    raise ValueError("there is no __all__")


def _origins(package: Path) -> dict[str, str]:
    """Public names of a package, each with the path below spectral_core of the module that it is imported from."""
    tree = ast.parse((package / "__init__.py").read_text(encoding="utf-8"))
    inside = ".".join(package.relative_to(CORE).parts)
    found = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            for alias in node.names:
                module = node.module or alias.name
                found[alias.asname or alias.name] = f"{inside}.{module}" if inside else module
    return {name: found.get(name, inside) for name in _all_of(tree)}


def public_names() -> dict[str, str]:
    """Give every public name by its full path, and the room of the core that it belongs to."""
    names = {}
    for name, module in _origins(CORE).items():
        if name not in PACKAGES and not name.startswith("__"):
            names[f"spectral_core.{name}"] = module.split(".")[0]
    for package in PACKAGES:
        for name in _origins(CORE / package):
            if f"spectral_core.{name}" not in names:
                names[f"spectral_core.{package}.{name}"] = package
    return names


def _file_of(title: str) -> str:
    return f"api/{title.lower().replace(' ', '_')}.md"


def _table(names: list[str]) -> Iterator[str]:
    for name in sorted(names, key=str.lower):
        yield f"- [`{name}`][{name}]"


def api_pages() -> dict[str, str]:
    """Give the Markdown of each page by its path below docs/."""
    names = public_names()
    last = list(PAGES)[-1]
    rooms = {room: title for title, modules in PAGES.items() for room in modules}
    by_title: dict[str, list[str]] = {title: [] for title in PAGES}
    for name, room in names.items():
        by_title[rooms.get(room, last)].append(name)
    pages = {}
    index = ["# Reference", "", "Every public name of `spectral_core`. What is not listed may change without notice."]
    for title, found in by_title.items():
        index += ["", f"## [{title}]({Path(_file_of(title)).name})", "", *_table(found)]
        body = "\n\n".join(f"::: {name}" for name in sorted(found, key=lambda n: n.split(".")[-1].lower()))
        pages[_file_of(title)] = f"# {title}\n\n{body}\n"
    pages["api/index.md"] = "\n".join(index) + "\n"
    return pages


def on_config(config: Any) -> Any:
    """Put the pages into the navigation, behind their index."""
    reference = next(section["Reference"] for section in config.nav if "Reference" in section)
    reference += [{title: _file_of(title)} for title in PAGES if {title: _file_of(title)} not in reference]
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the pages to those that MkDocs found below docs/."""
    from mkdocs.structure.files import File

    for path, content in api_pages().items():
        files.append(File.generated(config, path, content=content))
    return files
