"""The page on acoustics."""

import re

import pytest

from sonarbed.cli import main
from sonarbed.studies import acoustics
from sonarbed.studies.acoustics import (
    causes,
    crosstalk,
    reality,
)


@pytest.mark.engine
def test_page_shows_every_part(tmp_path, run, monkeypatch):
    monkeypatch.setattr(crosstalk, "SECONDS", (1.0, 1.0))
    monkeypatch.setattr(causes, "SECONDS", (1.0, 1.0))
    monkeypatch.setattr(reality, "SECONDS", (2.0, 2.0))
    monkeypatch.setattr(causes, "ROOMS", ("thesis-exp1", "corridor"))
    out = tmp_path / "page"
    told = run(["acoustics", "--quick", "--jobs", "1", "--out", out])
    assert told == f"Page: {out / 'report.html'}, {out / 'report.md'}\n"
    html, markdown = (
        (out / name).read_text(encoding="utf-8") for name in ("report.html", "report.md")
    )
    assert not re.search(r"https?:|<script|\.\.\.|\bnan\b", html)
    assert "The thesis" not in html
    assert html.count("<img") == 11
    assert "A quick run" in html
    for part in acoustics.PARTS:
        assert f'id="{part}"' in html
        assert (out / part / "section.json").is_file()
    links = re.findall(r"\]\(([^)]+)\)", markdown)
    assert {link.split("/")[0] for link in links} == set(acoustics.PARTS)
    assert all((out / link).is_file() for link in links)
    # A report of the thesis does not get into its folder.
    err = run(["thesis", "--quick", "--sonar", "physical", "--out", out], code=2)
    assert "holds a report with report 'acoustics', asked for 'thesis'" in err


def test_bad_jobs_end_before_the_folder_is_made(tmp_path, capsys):
    assert main(["acoustics", "--out", str(tmp_path / "new"), "--jobs", "0"]) == 2
    assert capsys.readouterr().err == "sonarbed: --jobs must be >= 1, got 0\n"
    assert not (tmp_path / "new").exists()
