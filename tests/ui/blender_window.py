"""A whole Blender with its window: found, started with the add-on as it is shipped, and its report read.

The scripts in ``inside/`` run in that Blender. They write ``report.json`` when they are done; whatever Blender prints
is kept beside it, since an exception in a panel's or node's drawing ends nothing and stands in the console alone.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from tools.package import ROOT, source_files

__all__ = ["ARTIFACTS", "NoWindowError", "Played", "console_errors", "play", "python_errors", "window_command"]

INSIDE = Path(__file__).resolve().parent / "inside"
ARTIFACTS = ROOT / "artifacts" / "ui"
SCREEN = "1600x1800x24"
TALL = (1600, 1800)  # a tab of the Properties editor is seen from top to bottom

# What Blender, its drivers and the sound system say without being wrong.
_HARMLESS = re.compile(
    r"ALSA|Unable to open a display|XDG|libEGL|MESA|EGL|vulkan|Vulkan|pipewire|PulseAudio|dbus|"
    r"Error: (region could not be drawn|Not freed memory)?$"
)
_PYTHON = re.compile(
    r"^Traceback|^Error: Python|pyrna_|rna_ui|UILayout|property not found|no enum item|matches no enum"
)
_WRONG = re.compile(
    r"Traceback|\bError\b|Exception|\bWARN(ING)?\b.*(rna|bpy|enum)|pyrna_|rna_ui|UILayout|property not found|"
    r"unknown operator"
)


class NoWindowError(RuntimeError):
    """There is no Blender that could open a window here."""


@dataclass(frozen=True, slots=True)
class Played:
    """What a script left behind.

    Attributes
    ----------
    report : dict
        What it measured; has at least "version".
    console : str
        What Blender printed.
    folder : Path
        Where its screenshots are.
    """

    report: dict[str, Any]
    console: str
    folder: Path


def window_command() -> list[str]:
    """Return the command that starts Blender: that of the variable BLENDER_GUI, or `blender` on the PATH."""
    named = os.environ.get("BLENDER_GUI", "")
    if named:
        command = shlex.split(named)
        if shutil.which(command[0]) is None:
            raise NoWindowError(f"BLENDER_GUI names '{command[0]}', which is not there")
        return command  # it may bring a screen of its own
    found = shutil.which("blender")
    if found is None:
        raise NoWindowError("no `blender` is on the PATH, and BLENDER_GUI names none")
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or shutil.which("Xvfb")):
        raise NoWindowError(f"{found} has no screen: set DISPLAY, or install Xvfb")
    return [found]


@contextmanager
def _screen(environment: dict[str, str]) -> Iterator[None]:
    """Give Blender a screen that nobody looks at, where Xvfb is found; else whatever DISPLAY names."""
    if shutil.which("Xvfb") is None or os.environ.get("DICHROMATIC_UI_DISPLAY") == "own":
        yield
        return
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", SCREEN, "+extension", "GLX", "-nolisten", "tcp"],
        pass_fds=(writing,),
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    try:
        with os.fdopen(reading) as told:
            number = told.readline().strip()
        if not number:
            raise NoWindowError("Xvfb ended before it had a screen")
        environment["DISPLAY"] = f":{number}"
        environment.pop("WAYLAND_DISPLAY", None)
        yield
    finally:
        server.terminate()
        server.wait()


def _install(resources: Path) -> None:
    """Put the files of the package where Blender looks for extensions."""
    folder = resources / "extensions" / "user_default" / "dichromatic"
    for name in source_files():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, target)


@cache
def _series(command: tuple[str, ...]) -> str:
    told = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True, timeout=120).stdout
    found = re.search(r"Blender (\d+\.\d+)", told)
    if found is None:
        raise NoWindowError(f"{command[0]} does not say which version it is: {told[:200]}")
    return found[1]


def play(
    script: str,
    *arguments: str,
    seconds: float = 240.0,
    simulates: bool = True,
    size: tuple[int, int] = TALL,
    blend: Path | None = None,
) -> Played:
    """Run a script of ``inside/`` in a window.

    Parameters
    ----------
    script : str
        Its name without the ending.
    *arguments : str
        Given to it.
    seconds : float
        When to give it up.
    simulates : bool
        Whether events come from the script; then the keyboard's and mouse's are ignored.
    size : tuple of int
        Of the window in pixels.
    blend : Path, optional
        A file to open first.

    Returns
    -------
    Played
        Its report, and the console.

    Raises
    ------
    NoWindowError
        If there is no Blender with a window.
    AssertionError
        If the script did not come to its end, with the end of what Blender printed.
    """
    command = window_command()
    folder = ARTIFACTS / _series(tuple(command)) / "-".join([script, *arguments])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    report = folder / "report.json"
    with tempfile.TemporaryDirectory(prefix="dichromatic-ui-") as resources:
        _install(Path(resources))
        environment = {
            **os.environ,
            "BLENDER_USER_RESOURCES": resources,
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONUNBUFFERED": "1",
        }
        environment["TMPDIR"] = resources  # where Blender leaves its quit.blend
        parts = [*command, "--factory-startup", "--no-window-focus", *["--enable-event-simulate"][: int(simulates)]]
        parts += ["--window-geometry", "0", "0", *map(str, size)]
        parts += [str(blend)] if blend else []
        parts += ["--python-exit-code", "3", "--python", str(INSIDE / f"{script}.py"), "--", str(folder), *arguments]
        with _screen(environment):
            console, code = _run(parts, environment, folder / "console.txt", seconds)
        for crash in Path(resources).glob("*.crash.txt"):
            shutil.copyfile(crash, folder / "crash.txt")
    ending = "\n".join(console.splitlines()[-40:])
    assert report.is_file(), f"{script} wrote no report (exit code {code}):\n{ending}"
    told = json.loads(report.read_text(encoding="utf-8"))
    assert "failure" not in told, f"{script}: {told['failure']}\n{ending}"
    assert code == 0, f"{script}: Blender ended with code {code}:\n{ending}"
    return Played(told, console, folder)


def _run(parts: Sequence[str], environment: dict[str, str], log: Path, seconds: float) -> tuple[str, int | str]:
    with log.open("w", encoding="utf-8") as output:
        process = subprocess.Popen(
            parts, env=environment, stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True
        )
        try:
            code: int | str = process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            code = f"none after {seconds:g} s"
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
    return log.read_text(encoding="utf-8", errors="replace"), code


def python_errors(console: str) -> list[str]:
    """Return the lines in which Python complains, and not what operators and renders report to the user."""
    return [line for line in console.splitlines() if _PYTHON.search(line)]


def console_errors(console: str) -> list[str]:
    """Return the lines in which Blender or Python complain."""
    return [line for line in console.splitlines() if _WRONG.search(line) and not _HARMLESS.search(line)]
