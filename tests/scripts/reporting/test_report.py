"""The page of invented sections, with templates of nobody's study."""

import csv
import re

import numpy as np
import pytest
from pages import Page, invented
from support import make_log, random_truth

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.report import write_report
from sonarmap import InputError


@pytest.fixture
def context(tmp_path):
    return StudyContext(tmp_path / "report", quick=True, jobs=1)


@pytest.fixture(autouse=True)
def toy_page(tmp_path, monkeypatch):
    """A package with the templates of a page called "Toys"."""
    templates = tmp_path / "toys" / "templates"
    templates.mkdir(parents=True)
    (tmp_path / "toys" / "__init__.py").touch()
    for suffix in ("html", "md"):
        (templates / f"page.{suffix}.j2").write_text(
            f'{{% extends "report.{suffix}.j2" %}}\n'
            "{% block heading %}Toys for {{ child }}{% endblock %}\n"
            "{% block source %}The shop{% endblock %}\n"
        )
    monkeypatch.syspath_prepend(tmp_path)


def written(context, *sections):
    html, markdown = write_report(context, sections, package="toys", values={"child": "Ada"})
    return html.read_text(encoding="utf-8"), markdown.read_text(encoding="utf-8")


def test_page_has_the_words_of_its_package(context):
    for text in written(context, invented(context)):
        assert "Toys for Ada" in text
        assert "The shop:" in text


def test_page_accounts_for_the_readings_of_its_drives(context, rng):
    log = make_log([1.0, 1.1, 1.2, 1.3, np.inf], stale=[0, 0, 1, 0, 0], truth=random_truth(rng, 5))
    for name in ("one", "two"):
        log.write(context.drives.folder / f"{name}.parquet")
    for text in written(context, invented(context)):
        assert "The report's drives: 2 drives, 8 of 10 readings used; not used: 2 stale" in text


def test_page_without_drives_does_not_speak_of_any(context):
    assert "drives:" not in written(context, invented(context))[1]


def test_page_is_self_contained_and_shows_every_item(context):
    html, _ = written(context, invented(context), invented(context, study="second"))
    page = Page(html)
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in page.links)
    assert not re.search(r"https?:|@import|<script|url\(", html)
    assert page.tags.count("img") == 2
    for words in ("Study second", "Figure 1.1", "Table 1.2", "the source says", "row2"):
        assert words in page.words


def test_page_links_lead_to_places_within_it(context):
    html, _ = written(context, invented(context), invented(context, study="second"))
    targets = {link[1:] for link in Page(html).links if link.startswith("#")}
    assert targets == {"first", "second"}
    assert all(f'id="{target}"' in html for target in targets)


def test_page_escapes_what_texts_contain(context):
    text = "<script>alert('x')</script> & \"quoted\""
    html, _ = written(context, invented(context, text=text))
    page = Page(html)
    assert "script" not in page.tags
    assert text in page.words


def test_markdown_has_the_same_items_and_links_to_files_beside_it(context):
    _, markdown = written(context, invented(context))
    for words in ("## Study first", "### Figure 1.1", "### Table 1.2", "| row2 | 2 |"):
        assert words in markdown
    links = re.findall(r"\]\(([^)]+)\)", markdown)
    assert links
    for link in links:
        assert (context.folder / link).is_file(), link


def test_markdown_tables_keep_their_columns(context):
    _, markdown = written(context, invented(context))
    assert "| a\\|b | <c> |" in markdown


@pytest.mark.parametrize(("rows", "shown", "noted"), [(40, 40, False), (41, 40, True)])
def test_tables_are_cut_at_40_rows_with_a_note(context, rows, shown, noted):
    html, markdown = written(context, invented(context, rows=rows))
    for text in (html, markdown):
        assert len(re.findall(r"\brow\d+\b", text)) == shown
        assert (f"{rows} rows, the first 40 shown" in text) == noted
    with (context.folder / "first" / "table.csv").open(newline="") as stream:
        assert len(list(csv.reader(stream))) == rows + 1


def test_a_lost_picture_is_one_clear_line(context):
    section = invented(context)
    (context.folder / "first" / "picture.png").unlink()
    with pytest.raises(InputError, match=r"picture\.png: is missing from the report; buy first"):
        write_report(context, [section], package="toys", remedy="buy {study}")
