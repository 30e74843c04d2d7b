"""The pages name all that there is, and no blank was left in them."""

import re
from pathlib import Path

import pytest

import sonarmap as sm

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_blank_is_left(page):
    assert not re.findall(r"@[A-Z_]+@|\bTODO\b|\bTBD\b|\bXXX\b", page.read_text("utf-8"))


@pytest.mark.parametrize(
    ("page", "names"), [("methods.md", sm.methods()), ("filters.md", sm.filters())]
)
def test_each_has_a_row_and_a_word(page, names):
    text = (ROOT / "docs" / page).read_text("utf-8")
    rows = set(re.findall(r"^\| `([a-z0-9-]+)` \|", text, re.MULTILINE))
    assert set(names) <= rows
