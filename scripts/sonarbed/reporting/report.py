"""The report: sections of studies as one self-contained HTML page, and the same in Markdown."""

from __future__ import annotations

import base64
import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, select_autoescape

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Section
from sonarmap.errors import InputError
from sonarmap.files import atomic_path

__all__ = ["write_report"]

# Of a longer table the page shows the beginning, and the file has the rest.
_MOST_ROWS = 40


def write_report(
    context: StudyContext,
    sections: Sequence[Section],
    *,
    package: str,
    values: Mapping[str, Any] | None = None,
    remedy: str = "make the report anew",
) -> tuple[Path, Path]:
    """Write ``report.html`` and ``report.md`` into the report's folder; return their paths.

    Parameters
    ----------
    context : StudyContext
        Where the sections' figures and tables are, and how they were made.
    sections : sequence of Section
        The studies that are done, in the order of the report.
    package : str
        Whose page: its ``templates/page.*.j2`` give the report its title, beginning and words.
    values : mapping, optional
        What these templates need besides `context`, `sections` and `drives`, by name.
    remedy : str
        What to do when a file of a section is missing; ``{study}`` is its study.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package), PackageLoader("sonarbed.reporting")]),
        autoescape=select_autoescape(["html.j2"]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )

    def path_of(section: Section, file: str) -> Path:
        path = context.folder / section.study / file
        if not path.is_file():
            advice = remedy.format(study=section.study)
            raise InputError(f"{path}: is missing from the report; {advice}")
        return path

    environment.globals["picture"] = lambda section, file: _data_url(path_of(section, file))
    environment.globals["rows"] = lambda section, file: _rows(path_of(section, file))
    environment.filters["cell"] = _markdown_cell
    environment.globals["most_rows"] = _MOST_ROWS
    drives = context.drives.account()
    written = []
    for suffix in ("html", "md"):
        text = environment.get_template(f"page.{suffix}.j2").render(
            context=context, sections=sections, drives=drives, **(values or {})
        )
        with atomic_path(context.folder / f"report.{suffix}") as path:
            path.write_text(text, encoding="utf-8")
        written.append(context.folder / f"report.{suffix}")
    return written[0], written[1]


def _data_url(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode()


def _rows(file: Path) -> list[list[str]]:
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.reader(stream))


def _markdown_cell(text: str) -> str:
    """Return text as the cell of a table, where a bar would begin the next and a line end it."""
    return " ".join(text.split()).replace("|", "\\|")
