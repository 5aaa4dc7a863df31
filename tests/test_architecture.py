"""The rules of the house, read off the syntax trees: nothing is imported and Blender is not needed.

A module that is new must be given its storey below; the messages say which rule is broken, where, and by what.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CORE = ROOT / "spectral_core"
ADDON = ROOT / "dichromatic_addon"

# A module of the core imports from its own storey and from those above it in this list, never from below.
STOREYS: tuple[frozenset[str], ...] = (
    frozenset({"errors"}),
    frozenset({"atomic_files", "validation", "tables", "interpolation", "image_io"}),
    frozenset({"spectra", "resampling", "optical_constants", "spectrum_files"}),
    frozenset({"colorimetry", "display", "display_files", "rgb_uplift", "library", "synthetic_reflectances"}),
    frozenset({"textures", "textured_reflectance", "texture_mixing"}),
    frozenset({"reflection", "tracing"}),
    frozenset({"buffers", "lights", "scene_spectra", "scene", "fitting"}),
    frozenset(
        {
            "development",
            "film",
            "film_builder",
            "light_plan",
            "light_components",
            "paths",
            "plan",
            "render_pass",
            "sample_pattern",
            "shading",
            "shadow_share",
            "statistics",
            "sub_pictures",
            "transport",
            "visibility",
        }
    ),
    frozenset({"adaptive", "job", "workers", "recolouring", "progressive", "renderer"}),
    frozenset({"light_groups", "probe", "render_file", "spectral_exr", "studies", "estimate", "tradeoff"}),
)

# tracing knows meshes and rays, never a spectrum; reflection knows vectors and spectra, never a mesh.
STRANGERS = {"tracing": frozenset().union(*STOREYS[2:5], {"reflection"}), "reflection": frozenset({"tracing"})}

ADDON_MAY_IMPORT = frozenset(
    {"bpy", "bpy_extras", "bl_ui", "gpu", "gpu_extras", "mathutils", "nodeitems_utils", "numpy"}
    | sys.stdlib_module_names
)
DEPSGRAPH_READERS = frozenset({"scene_export.py"})
# What says which render is asked for; the rest of a depsgraph is the scene itself.
DEPSGRAPH_CONTEXT = frozenset({"scene", "view_layer", "mode", "updates", "id_type_updated"})
PIXEL_WRITERS = frozenset({"engine.py", "viewport.py", "operators.py"})
PIXEL_ATTRIBUTES = frozenset({"pixels", "rect"})


def sources(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*.py") if "__pycache__" not in path.parts)


def modules(*folders: Path) -> pytest.MarkDecorator:
    files = [path for folder in folders for path in sources(folder)]
    assert files, f"no modules below {folders}"
    return pytest.mark.parametrize("path", files, ids=[str(path.relative_to(ROOT)) for path in files])


@lru_cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and "TYPE_CHECKING" in {
        getattr(part, "id", getattr(part, "attr", None)) for part in ast.walk(node.test)
    }


def imports(tree: ast.Module) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """Every import with whether it runs when the module is loaded (not in a function, not for type checkers only)."""

    def visit(node: ast.AST, loaded: bool) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import | ast.ImportFrom):
                yield child, loaded
            else:
                is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
                yield from visit(child, loaded and not is_function and not is_type_checking(child))

    return visit(tree, True)


def absolute_imports(path: Path) -> Iterator[tuple[str, ast.stmt, bool]]:
    for node, loaded in imports(tree_of(path)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name.split(".")[0], node, loaded
        elif node.level == 0:
            yield (node.module or "").split(".")[0], node, loaded


def relative_imports(path: Path, package: Path) -> Iterator[tuple[Path, ast.stmt, bool]]:
    """The files of the package that a module names, whether as ``from .a import b`` or ``from . import a``."""

    def as_file(base: Path) -> Path | None:
        if base.with_suffix(".py").is_file():
            return base.with_suffix(".py")
        return base / "__init__.py" if (base / "__init__.py").is_file() else None

    for node, loaded in imports(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split(".") if node.module else ())
            if not base.is_relative_to(package):
                continue
            submodules = [as_file(base / alias.name) for alias in node.names]
            for target in {file for file in (*submodules, as_file(base) if None in submodules else None) if file}:
                yield target, node, loaded


def room_of(path: Path) -> str:
    """The module or package of the core that a file belongs to."""
    return path.relative_to(CORE).parts[0].removesuffix(".py")


def dotted(node: ast.AST) -> str:
    """``bpy.app.version`` for such a chain of attributes, else an empty string or its tail after a dot."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def where(path: Path, node: ast.AST) -> str:
    return f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"


def all_of(tree: ast.Module) -> list[str] | None:
    for node in tree.body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        if any(isinstance(target, ast.Name) and target.id == "__all__" for target in targets):
            value = node.value  # type: ignore[union-attr]
            return list(ast.literal_eval(value))
    return None


# --- the core -------------------------------------------------------------------------------------------------------


@modules(CORE)
def test_core_imports_numpy_and_the_standard_library_only(path: Path) -> None:
    for name, node, loaded in absolute_imports(path):
        if name == "OpenImageIO":
            assert path.name == "image_io.py", f"{where(path, node)}: OpenImageIO belongs to image_io.py"
            assert not loaded, f"{where(path, node)}: OpenImageIO is optional, so it is imported where it is used"
            continue
        allowed = name == "numpy" or name in sys.stdlib_module_names
        assert allowed, f"{where(path, node)}: the core must not import {name}"


@modules(CORE)
def test_core_imports_point_one_way(path: Path) -> None:
    if path == CORE / "__init__.py":
        return  # the facade sees every room
    storey_of = {room: number for number, rooms in enumerate(STOREYS) for room in rooms}
    room = room_of(path)
    assert room in storey_of, f"{path.relative_to(ROOT)}: give {room} its storey in {Path(__file__).name}"
    for target, node, _ in relative_imports(path, CORE):
        assert target != CORE / "__init__.py", f"{where(path, node)}: a module must not import the facade"
        other = room_of(target)
        assert storey_of.get(other, 0) <= storey_of[room], f"{where(path, node)}: {room} must not import {other}"
        assert other not in STRANGERS.get(room, ()), f"{where(path, node)}: {room} must not know {other}"


def test_core_imports_form_no_cycle() -> None:
    edges = {
        path: {target for target, _, loaded in relative_imports(path, CORE) if loaded} - {path}
        for path in sources(CORE)
    }
    done: set[Path] = set()

    def visit(path: Path, trail: tuple[Path, ...]) -> None:
        names = " -> ".join(str(step.relative_to(CORE)) for step in (*trail, path))
        assert path not in trail, f"import cycle: {names}"
        if path not in done:
            for target in edges[path]:
                visit(target, (*trail, path))
            done.add(path)

    assert len(edges) > 10
    for path in edges:
        visit(path, ())


@modules(CORE, ADDON)
def test_quadrature_is_explicit(path: Path) -> None:
    for node in ast.walk(tree_of(path)):
        name = node.attr if isinstance(node, ast.Attribute) else ""
        assert name not in {"trapz", "trapezoid"}, f"{where(path, node)}: numpy.{name} is absent in some numpy versions"


@modules(CORE, ADDON)
def test_nothing_is_swallowed(path: Path) -> None:
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"{where(path, node)}: name the exception"
            silent = all(isinstance(statement, ast.Pass | ast.Continue) for statement in node.body)
            broad = dotted(node.type) in {"Exception", "BaseException"}
            assert not (silent and broad), f"{where(path, node)}: an exception of any kind vanishes here"


# --- both packages: what is public ----------------------------------------------------------------------------------


@modules(CORE, ADDON)
def test_all_names_what_is_public(path: Path) -> None:
    if path.name == "__main__.py":
        return  # nobody imports it
    tree = tree_of(path)
    public = all_of(tree)
    assert public is not None, f"{path.relative_to(ROOT)}: no __all__"
    assert len(set(public)) == len(public), f"{path.relative_to(ROOT)}: __all__ names something twice"
    bound: set[str] = set()
    for node in tree.body:
        for part in ast.walk(node) if not isinstance(node, ast.ClassDef | ast.FunctionDef) else [node]:
            if isinstance(part, ast.Import | ast.ImportFrom):
                bound |= {(alias.asname or alias.name).split(".")[0] for alias in part.names}
            elif isinstance(part, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                bound.add(part.name)
            elif isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
                bound.add(part.id)
    if path.name == "__init__.py":
        bound |= {child.stem for child in path.parent.iterdir() if child.suffix == ".py" or child.is_dir()}
    missing = sorted(set(public) - bound)
    assert not missing, f"{path.relative_to(ROOT)}: __all__ names {missing}, which the module does not have"


SECTION = re.compile(r"^[ \t]*(\w[\w ]*)\n[ \t]*-{3,}[ \t]*$", re.MULTILINE)


def decorators(function: ast.FunctionDef) -> set[str]:
    return {
        dotted(item.func if isinstance(item, ast.Call) else item).split(".")[-1] for item in function.decorator_list
    }


def public_functions(path: Path) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Functions in ``__all__`` and public methods of classes in ``__all__``; properties count as attributes."""
    tree = tree_of(path)
    public = set(all_of(tree) or ())
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name in public:
            yield node.name, node
        elif isinstance(node, ast.ClassDef) and node.name in public:
            for item in node.body:
                if isinstance(item, ast.FunctionDef) and not item.name.startswith("_"):
                    yield f"{node.name}.{item.name}", item


def missing_sections(function: ast.FunctionDef, is_method: bool) -> list[str]:
    marks = decorators(function)
    if "overload" in marks:
        return []
    docstring = ast.get_docstring(function)
    if not docstring:
        return ["docstring"]
    if marks & {"property", "cached_property"}:
        return []
    arguments = function.args
    names = [item.arg for item in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    takes = len(names) - (is_method and "staticmethod" not in marks) + bool(arguments.vararg) + bool(arguments.kwarg)
    returns_none = isinstance(function.returns, ast.Constant) and function.returns.value is None
    needed = {"Raises", "References"}
    needed |= {"Parameters"} if takes else set()
    if not returns_none:
        returned = ast.unparse(function.returns) if function.returns else ""
        needed |= {"Yields"} if returned.split("[")[0].split(".")[-1] in {"Iterator", "Generator"} else {"Returns"}
    found = set(SECTION.findall(docstring))
    return sorted(
        section for section in needed if section not in found and not (section == "Yields" and "Returns" in found)
    )


@modules(CORE)
def test_public_functions_of_the_core_are_documented(path: Path) -> None:
    problems = {
        name: missing
        for name, function in public_functions(path)
        if (missing := missing_sections(function, "." in name))
    }
    assert not problems, f"{path.relative_to(ROOT)}: missing in docstrings: {problems}"


# --- the add-on -----------------------------------------------------------------------------------------------------


@modules(ADDON)
def test_addon_imports(path: Path) -> None:
    for name, node, loaded in absolute_imports(path):
        if path.name == "_core.py" and name == "spectral_core":
            continue
        if name == "matplotlib":
            assert path.name == "plotting.py", f"{where(path, node)}: matplotlib belongs to plotting.py"
            assert not loaded, f"{where(path, node)}: matplotlib is optional, so it is imported where it is used"
            continue
        assert name not in {"spectral_core", "dichromatic_addon"}, (
            f"{where(path, node)}: the core comes through _core.py"
        )
        assert name in ADDON_MAY_IMPORT, f"{where(path, node)}: the add-on must not import {name}"
    for node, _ in imports(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and node.level and path.name != "_core.py":
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            assert base.is_relative_to(ADDON), f"{where(path, node)}: reaches out of the add-on; use _core.py"


@modules(ADDON)
def test_core_is_named_core(path: Path) -> None:
    for node, _ in imports(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and node.level and node.module == "_core":
            names = [alias.name for alias in node.names]
            assert names == ["core"], f"{where(path, node)}: `from ._core import core` is the one form"


@modules(ADDON)
def test_version_branches_stand_in_compat(path: Path) -> None:
    for node in ast.walk(tree_of(path)):
        if path.name != "compat.py" and isinstance(node, ast.Attribute):
            chain = dotted(node)
            assert not chain.endswith("app.version"), f"{where(path, node)}: {chain} belongs to compat.py"


@modules(ADDON)
def test_only_scene_export_reads_the_depsgraph(path: Path) -> None:
    if path.name in DEPSGRAPH_READERS:
        return
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Attribute):
            is_depsgraph = dotted(node.value).split(".")[-1] in {"depsgraph", "_depsgraph"}
            is_read = (is_depsgraph and node.attr not in DEPSGRAPH_CONTEXT) or node.attr == "object_instances"
            assert not is_read, f"{where(path, node)}: {dotted(node)}: only scene_export.py reads the depsgraph"


@modules(ADDON)
def test_only_three_modules_write_pixels(path: Path) -> None:
    if path.name in PIXEL_WRITERS:
        return
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Attribute) and node.attr in PIXEL_ATTRIBUTES:
            is_written = isinstance(node.ctx, ast.Store)
            assert not is_written, f"{where(path, node)}: only {sorted(PIXEL_WRITERS)} write pixels"
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            written = isinstance(node.value, ast.Attribute) and node.value.attr in PIXEL_ATTRIBUTES
            assert not written, f"{where(path, node)}: only {sorted(PIXEL_WRITERS)} write pixels"
        if isinstance(node, ast.Call) and dotted(node.func).endswith(".foreach_set"):
            written = dotted(node.func).split(".")[-2] in PIXEL_ATTRIBUTES
            assert not written, f"{where(path, node)}: only {sorted(PIXEL_WRITERS)} write pixels"


@modules(ADDON)
def test_classes_are_registered_by_their_module(path: Path) -> None:
    tree = tree_of(path)
    blender_classes = [
        node.name
        for node in tree.body
        if isinstance(node, ast.ClassDef) and any(".types." in dotted(base) for base in node.bases)
    ]
    if blender_classes:
        public = set(all_of(tree) or ())
        package = path.parent / "__init__.py"  # a package may register what its modules list
        if path.parent != ADDON and package.is_file():
            public |= {"register", "unregister"} & set(all_of(tree_of(package)) or ())
        missing = {"CLASSES", "register", "unregister"} - public
        assert not missing, f"{path.relative_to(ROOT)} defines {blender_classes} but not {sorted(missing)}"


@modules(ADDON)
def test_module_search_is_left_alone(path: Path) -> None:
    for node in ast.walk(tree_of(path)):
        target = node.func if isinstance(node, ast.Call) else node.value if isinstance(node, ast.Subscript) else None
        if target is None or (isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load)):
            continue
        edited = re.match(
            r"sys\.(path|modules)(\.(append|insert|extend|remove|pop|update|setdefault|clear))?$", dotted(target)
        )
        assert not edited, f"{where(path, node)}: extensions must not edit sys.path or sys.modules"


# --- the root -------------------------------------------------------------------------------------------------------


def test_root_module_is_a_shim() -> None:
    path = ROOT / "__init__.py"
    loaded = [where(path, node) for node, loaded in imports(tree_of(path)) if loaded and ast.unparse(node) != FUTURE]
    assert not loaded, f"the shim must import nothing when it is loaded: {loaded}"


FUTURE = "from __future__ import annotations"


def test_versions_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
    assert project == manifest
