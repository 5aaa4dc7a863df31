"""Every piece of code in the documents is run, and every command in them exists."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import re
import shlex
from pathlib import Path

import pytest

from tests.docs.documents import LANGUAGES, ROOT, Block, blocks, documents, indented_blocks
from tests.docs.run_page import commands, compare, is_run, run_page, run_python

DOCUMENTS = documents()
HAS_BLENDER = importlib.util.find_spec("bpy") is not None
# Programs that are not ours: their commands are read by whoever follows the page, and not judged here.
FOREIGN = {"blender", "cd", "export", "git", "ln", "mkdir", "pip", "python3"}


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def with_runnable_blocks() -> list[Path]:
    return [path for path in DOCUMENTS if any(is_run(block) for block in blocks(path))]


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_blocks_say_what_they_are(path: Path) -> None:
    assert not indented_blocks(path), f"{name_of(path)}: fence these blocks and name their language"
    for block in blocks(path):
        assert block.language in LANGUAGES, f"{block.place}: the language must be one of {LANGUAGES}"
        if block.marker == "not run":
            assert len(block.reason.split()) >= 3, f"{block.place}: say why the block is not run"


@pytest.mark.parametrize("path", with_runnable_blocks(), ids=name_of)
def test_code_of_a_page_runs_in_order(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = [block for block in blocks(path) if is_run(block)]
    if not HAS_BLENDER and any("bpy" in block.code or "render sample_blends" in block.code for block in found):
        pytest.skip("the page needs the bpy module")
    for name in ("docs", "sample_blends"):
        (tmp_path / name).symlink_to(ROOT / name)
    if any("import bpy" in block.code for block in found):
        # In a process of its own: what it registers stays there, and one that hangs at its end is found.
        done = run_python(["-W", "error", "-m", "tests.docs.run_page", str(path)], tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
    else:
        monkeypatch.chdir(tmp_path)
        run_page(path)


# --- commands -------------------------------------------------------------------------------------------------------


def shell_blocks() -> list[Block]:
    return [b for path in DOCUMENTS for b in blocks(path) if b.language == "sh" and b.marker != "not run"]


@pytest.mark.parametrize("block", shell_blocks(), ids=lambda block: block.place)
def test_commands_exist(block: Block) -> None:
    for command in commands(block):
        problem = problem_of(shlex.split(command, comments=True))
        assert not problem, f"{block.place}: {command}: {problem}"


def problem_of(words: list[str]) -> str:
    """Say what is wrong with a command, or nothing."""
    while words and re.fullmatch(r"[A-Z_]+=.*", words[0]):  # variables set for this command
        words = words[1:]
    program, arguments = words[0], words[1:]
    if program == "blender" and arguments[:2] == ["--command", "dichromatic"]:
        program, arguments = "dichromatic", arguments[2:]
    if program == "dichromatic":
        return problem_of_arguments(arguments)
    if program == "make":
        return problem_of_make(arguments)
    if program.endswith("python"):
        return problem_of_python(arguments)
    if program.startswith(("tools/", "./")):
        return "" if (ROOT / program).is_file() else "there is no such script"
    return "" if program in FOREIGN else f"the tests do not know {program!r}"


def problem_of_arguments(arguments: list[str]) -> str:
    from dichromatic_addon.cli import parse_arguments

    with contextlib.redirect_stderr(io.StringIO()) as complaint, contextlib.redirect_stdout(io.StringIO()):
        try:
            parse_arguments(arguments)
        except SystemExit as end:
            return complaint.getvalue() if end.code else ""
    return ""


def problem_of_make(arguments: list[str]) -> str:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z][a-z-]*):", makefile, re.MULTILINE))
    variables = set(re.findall(r"^(?:export )?([A-Z]+)\b", makefile, re.MULTILINE))
    for word in arguments:
        name, is_variable, _ = word.partition("=")
        if is_variable and name not in variables:
            return f"the Makefile has no variable {name}"
        if not is_variable and name not in targets:
            return f"the Makefile has no target {name}"
    return ""


def problem_of_python(arguments: list[str]) -> str:
    if arguments and arguments[0] == "-m":
        module = ROOT.joinpath(*arguments[1].split("."))
        is_there = module.with_suffix(".py").is_file() or (module / "__main__.py").is_file()
        return "" if is_there or arguments[1] == "pip" else f"there is no module {arguments[1]}"
    return "" if arguments and (ROOT / arguments[0]).is_file() else "there is no such script"


def test_wrong_commands_are_found() -> None:
    for right in (
        "make render SAMPLES=1",
        "dichromatic fit x.csv -o y.json",
        "blender --command dichromatic plan a.blend",
        "python tools/measure_grids.py",
    ):
        assert not problem_of(right.split()), right
    for wrong in (
        "make rendering",
        "make render QUALITY=2",
        "dichromatic fit x.csv --colour red",
        "dichromatic paint x.csv",
        "dichromatic render a.blend",
        "python tools/absent.py",
        "absent --help",
    ):
        assert problem_of(wrong.split()), wrong


def test_output_is_compared() -> None:
    block = Block(ROOT / "README.md", 1, "text", "Delta E ... of 24\n", "output", "")
    compare(block, "Delta E 0.12 of 24\n")
    with pytest.raises(AssertionError, match="the page says"):
        compare(block, "Delta E 0.12 of 25\n")
