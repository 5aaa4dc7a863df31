"""The documents, and the code blocks in them.

A block is fenced and names its language. A comment on the line before the fence says how the tests take it:

``<!-- not run: REASON -->``
    The block stands for itself; the reason says why it cannot be run.
``<!-- output -->``
    What the block above prints, ``...`` standing for any text.
``<!-- run -->``
    A block of commands that is carried out and not only parsed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = ("python", "sh", "text", "csv", "json")
MARKERS = ("not run", "output", "run")

__all__ = ["LANGUAGES", "ROOT", "Block", "blocks", "documents", "prose"]

_FENCE = re.compile(r"^( *)(`{3,})([^`]*)$")
_MARKER = re.compile(r"^ *<!-- ([a-z ]+?)(?:: (.*?))? -->$")
_LIST_ITEM = re.compile(r"^ *([*+-]|\d+\.) ")


@dataclass(frozen=True, slots=True)
class Block:
    """One fenced block.

    Attributes
    ----------
    path : Path
        The document.
    line : int
        Line of its first code line, from 1.
    language : str
        As the fence says.
    code : str
        Without the indentation of the fence.
    marker : str
        One of `MARKERS`, or empty.
    reason : str
        What the marker says behind its colon.
    """

    path: Path
    line: int
    language: str
    code: str
    marker: str
    reason: str

    @property
    def place(self) -> str:
        return f"{self.path.relative_to(ROOT)}:{self.line}"


def documents() -> list[Path]:
    """Every document of the project: those beside the README, and those below docs/."""
    found = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
    assert len(found) > 10, "the documents are not where this test looks for them"
    return found


def blocks(path: Path) -> list[Block]:
    """The fenced blocks of a document, in order."""
    return list(_walk(path, path.read_text(encoding="utf-8").splitlines()))


def _walk(path: Path, lines: list[str]) -> Iterator[Block]:
    number = 0
    while number < len(lines):
        opening = _FENCE.match(lines[number])
        if not opening:
            number += 1
            continue
        indent, fence, language = opening[1], opening[2], opening[3].strip()
        end = number + 1
        while end < len(lines) and lines[end].strip() != fence:
            end += 1
        where = f"{path.relative_to(ROOT)}:{number + 1}"
        assert end < len(lines), f"{where}: the block is not closed"
        marked = _MARKER.match(lines[number - 1]) if number else None
        marker, reason = (marked[1], marked[2] or "") if marked else ("", "")
        if marker.startswith(("generated", "end of")):  # of tables, not of blocks
            marker = ""
        assert not marker or marker in MARKERS, f"{where}: the marker must be one of {MARKERS}, but is {marker!r}"
        code = "\n".join(line.removeprefix(indent) for line in lines[number + 1 : end]) + "\n"
        yield Block(path, number + 2, language, code, marker, reason)
        number = end + 1


def prose(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a document that belong to no block, with their numbers."""
    fence = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        found = _FENCE.match(line)
        if fence:
            fence = "" if line.strip() == fence else fence
        elif found:
            fence = found[2]
        else:
            yield number, line


def indented_blocks(path: Path) -> list[int]:
    """Lines where a block begins that is indented instead of fenced, and so has no language."""
    found, before, in_list = [], "", False
    for number, line in prose(path):
        if _LIST_ITEM.match(line):
            in_list = True
        elif line and not line.startswith(" "):
            in_list = False
        if line.startswith("    ") and not before and not in_list:
            found.append(number)
        before = line.strip()
    return found
