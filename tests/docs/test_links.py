"""Links between the documents hold as they stand in the repository, and so does the check of the built site."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.documents import ROOT, documents, prose
from tools.check_links import broken_links, is_well_formed

LINK = re.compile(r"(!?)\[[^\]]*\]\(([^()\s]+(?:\([^()]*\))?[^()\s]*)\)")
GENERATED = ("api/",)  # pages that `make docs` makes


def anchors(path: Path) -> set[str]:
    """The anchors that headings have, by the rule that forges and MkDocs share."""
    found: set[str] = set()
    for _, line in prose(path):
        heading = re.match(r"#+ (.*)", line)
        if heading:
            text = re.sub(r"[`*_]|\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).strip().lower()
            found.add(re.sub(r"[^\w\- ]", "", text).replace(" ", "-"))
        found |= set(re.findall(r'<a id="([^"]+)"', line))
    return found


@pytest.mark.parametrize("path", documents(), ids=lambda path: str(path.relative_to(ROOT)))
def test_links_of_a_document_hold(path: Path) -> None:
    for number, line in prose(path):
        for _, link in LINK.findall(line):
            where = f"{path.relative_to(ROOT)}:{number}: {link}"
            if "://" in link or link.startswith("mailto:"):
                assert is_well_formed(link), where
                continue
            name, _, anchor = link.partition("#")
            target = (path.parent / name).resolve() if name else path
            inside = str(target.relative_to(ROOT / "docs")) if target.is_relative_to(ROOT / "docs") else ""
            if inside.startswith(GENERATED):
                continue
            assert target.exists(), f"{where}: leads nowhere"
            if anchor and target.suffix == ".md":
                assert anchor in anchors(target), f"{where}: no such heading"


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "images").iterdir()), ids=lambda path: path.name)
def test_every_picture_is_shown_somewhere(path: Path) -> None:
    assert any(path.name in page.read_text(encoding="utf-8") for page in documents()), f"no document shows {path.name}"
    assert path.stat().st_size < 1_500_000, "pictures of documents are small"


def test_every_page_is_in_the_navigation() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:")[2]
    named = set(re.findall(r"[\w/]+\.md", navigation))
    there = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    assert there <= named, f"not in the navigation of mkdocs.yml: {sorted(there - named)}"
    assert {page for page in named if not page.startswith(GENERATED)} <= there


def test_broken_links_of_a_site_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<h1 id="top"></h1><a href="b.html#there">x</a><a href="b.html#absent">x</a><a href="#top">x</a>'
        '<img src="absent.png"><a href="https://example.org/x">x</a><a href="https://example">x</a>'
    )
    (tmp_path / "b.html").write_text('<h1 id="there"></h1><a href="sub/">x</a>')
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "index.html").write_text('<a href="../a.html">x</a>')
    assert broken_links(tmp_path) == [
        "a.html: absent.png leads nowhere",
        "a.html: b.html#absent names an anchor that is not there",
        "a.html: https://example is not well formed",
    ]
