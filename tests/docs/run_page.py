"""Run the code of a document in order, in the current folder, and compare what it prints with what it says.

    python -m tests.docs.run_page docs/tutorials/two_fabrics.md

The blocks of Python share their names. Blocks of commands are run where the page marks them so.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from tests.docs.documents import ROOT, Block, blocks

LONGEST = 240  # seconds; only a process that hangs takes longer

__all__ = ["commands", "compare", "is_run", "run_page", "run_python"]


def is_run(block: Block) -> bool:
    return (block.language == "python" and block.marker != "not run") or block.marker == "run"


def run_page(path: Path) -> None:
    """Run a document's blocks; an AssertionError tells what was printed that the page does not say."""
    namespace: dict[str, Any] = {"__name__": "__main__"}
    printed = None
    for block in blocks(path):
        if block.marker == "output":
            assert printed is not None, f"{block.place}: there is nothing above that prints this"
            compare(block, printed)
            printed = None
        elif is_run(block):
            printed = _run(block, namespace)


def _run(block: Block, namespace: dict[str, Any]) -> str:
    """Carry a block out; what it prints."""
    if block.language == "python":
        # As many empty lines before the code as there are in the document, so that tracebacks name its lines.
        source = "\n" * (block.line - 1) + block.code
        # colour-science, which other tests import, makes numpy print as it did in version 1.13.
        with contextlib.redirect_stdout(io.StringIO()) as printed, np.printoptions(legacy=False):
            exec(compile(source, str(block.path), "exec"), namespace)
        return printed.getvalue()
    text = ""
    for command in commands(block):
        words = shlex.split(command, comments=True)
        assert words[0] == "dichromatic", f"{block.place}: only our own commands are run"
        done = run_python(["-m", "dichromatic_addon", *words[1:]], Path.cwd())
        assert done.returncode == 0, f"{block.place}: {command}\n{done.stdout}{done.stderr}"
        text += done.stdout
    return text


def run_python(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run this Python in a folder, with the project on its path."""
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=LONGEST,
        check=False,
    )


def compare(block: Block, printed: str) -> None:
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    is_same = doctest.OutputChecker().check_output(block.code, printed, flags)
    assert is_same, f"{block.place}: the page says\n{block.code}\nand the code prints\n{printed}"


def commands(block: Block) -> list[str]:
    """The commands of a block, continued lines joined, comments left out."""
    joined = block.code.replace("\\\n", " ")
    return [line for line in joined.splitlines() if shlex.split(line, comments=True)]


if __name__ == "__main__":
    run_page(Path(sys.argv[1]).resolve())
