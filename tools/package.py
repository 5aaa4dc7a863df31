"""Build ``dist/dichromatic-<version>.zip`` and validate it, both with the extension tool of the bpy module.

Run it with the Python of an environment that has the bpy module; Blender itself is not started.
Only the parts named below get into the zip, whatever else lies around in the checkout (environments, renders).
"""

from __future__ import annotations

import argparse
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# What belongs into the zip; the manifest's [build] table excludes the same rest for Blender's own build command.
PARTS = ("blender_manifest.toml", "__init__.py", "LICENSE", "README.md", "dichromatic_addon", "spectral_core")


def extension_tool() -> Path:
    """Path of ``blender_ext.py`` in the installed bpy module."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        raise SystemExit("package.py: this Python has no bpy module; run it through `make package`")
    found = sorted(Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    if not found:
        raise SystemExit(f"package.py: no blender_ext.py below {Path(spec.origin).parent}")
    return found[-1]


def run_tool(*arguments: str) -> None:
    """Run the extension tool; its messages go through and its failure ends this program."""
    command = [sys.executable, str(extension_tool()), *arguments]
    completed = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
    print((completed.stdout + completed.stderr).strip())
    if completed.returncode:
        raise SystemExit(f"package.py: blender_ext.py {arguments[0]} failed")


def source_files() -> list[Path]:
    """Files of the extension, relative to the project; without caches and hidden files."""
    files = []
    for part in PARTS:
        path = ROOT / part
        if not path.exists():
            raise SystemExit(f"package.py: {part} is missing from {ROOT}")
        found = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
        files += [file.relative_to(ROOT) for file in found]
    return sorted(
        file
        for file in files
        if file.suffix != ".pyc" and not any(part == "__pycache__" or part.startswith(".") for part in file.parts)
    )


def build(output_folder: Path) -> Path:
    """Build the zip into a folder and return its path.

    The files are copied to a folder of their own first, and the extension tool sees nothing else.
    """
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    target = output_folder / f"{manifest['id']}-{manifest['version']}.zip"
    output_folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in source_files():
            copy = Path(folder, name)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, copy)
        run_tool("build", "--source-dir", folder, "--output-filepath", str(target))
    run_tool("validate", str(target))
    return target


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Build and validate the extension's zip.")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder for the zip (default: dist)")
    target = build(parser.parse_args(argv).output)
    with zipfile.ZipFile(target) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
        count = len(archive.namelist())
    print(f"{target}: {count} files, {target.stat().st_size >> 10} KiB, unpacked {unpacked >> 10} KiB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
