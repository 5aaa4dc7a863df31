"""The tables in the documents are what the commands print now."""

from __future__ import annotations

import pytest

from tests.docs.documents import ROOT
from tools.document_tables import TABLES, TIMED, between, replaced


@pytest.mark.parametrize("name", TABLES)
def test_table_is_up_to_date(name: str) -> None:
    page, make = TABLES[name]
    written = between((ROOT / "docs" / page).read_text(encoding="utf-8"), name)
    assert written.strip() == make().strip(), f"docs/{page}: run `make tables`"


@pytest.mark.parametrize("name", TIMED)
def test_timed_table_is_there(name: str) -> None:
    page, _ = TIMED[name]
    assert "Delta E" in between((ROOT / "docs" / page).read_text(encoding="utf-8"), name)


def test_only_what_is_between_the_markers_is_replaced() -> None:
    page = "before\n<!-- generated: a -->\nold\n<!-- end of a -->\nafter\n"
    assert replaced(page, "a", "new") == "before\n<!-- generated: a -->\n\nnew\n\n<!-- end of a -->\nafter\n"
    with pytest.raises(ValueError, match="no markers"):
        replaced(page, "b", "new")
