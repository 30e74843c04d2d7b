"""The report: sections of studies as one self-contained HTML page, and the same in Markdown."""

from __future__ import annotations

import base64
import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, PackageLoader, select_autoescape

from sonarbed.reporting.section import ANSWERED_BY, QUESTIONS, Answer, Section
from sonarbed.reporting.setting import Setting
from sonarmap.errors import InputError
from sonarmap.files import atomic_path

__all__ = ["write_report"]

# A longer table is told by its file; the page shows its beginning.
_MOST_ROWS = 40


@dataclass(frozen=True)
class _Question:
    """A question of the report, the answers of its studies, and which studies are missing."""

    number: int
    text: str
    answers: tuple[tuple[Section, Answer], ...]
    missing: tuple[str, ...]

    @classmethod
    def of(cls, number: int, sections: Sequence[Section]) -> _Question:
        done = {section.study for section in sections}
        return cls(
            number,
            QUESTIONS[number],
            tuple(
                (s, answer) for s in sections for answer in s.answers if answer.question == number
            ),
            tuple(study for study in ANSWERED_BY[number] if study not in done),
        )


def write_report(
    setting: Setting, sections: Sequence[Section], *, page: str = "thesis"
) -> tuple[Path, Path]:
    """Write ``report.html`` and ``report.md`` into the setting's folder; return their paths.

    Parameters
    ----------
    setting : Setting
        Where the sections' figures and tables are, and what is told of how they were made.
    sections : sequence of Section
        The studies that are done, in the order of the report.
    page : str
        Which page: templates of this name give it its title, its beginning and its words.
    """
    environment = Environment(
        loader=PackageLoader("sonarbed.reporting", "templates"),
        autoescape=select_autoescape(["html.j2"]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals["picture"] = lambda section, file: _data_url(_file(setting, section, file))
    environment.globals["rows"] = lambda section, file: _rows(_file(setting, section, file))
    environment.filters["cell"] = _markdown_cell
    environment.globals["most_rows"] = _MOST_ROWS
    context = {
        "setting": setting,
        "sections": sections,
        "questions": [_Question.of(number, sections) for number in QUESTIONS],
    }
    written = []
    for suffix in ("html", "md"):
        text = environment.get_template(f"{page}.{suffix}.j2").render(context)
        with atomic_path(setting.folder / f"report.{suffix}") as path:
            path.write_text(text, encoding="utf-8")
        written.append(setting.folder / f"report.{suffix}")
    return written[0], written[1]


def _file(setting: Setting, section: Section, file: str) -> Path:
    path = setting.folder / section.study / file
    if not path.is_file():
        raise InputError(
            f"{path}: is missing from the report; make it anew with --study {section.study} --again"
        )
    return path


def _data_url(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode()


def _rows(file: Path) -> list[list[str]]:
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.reader(stream))


def _markdown_cell(text: str) -> str:
    """Return text as the cell of a table, where a bar would begin the next and a line end it."""
    return " ".join(text.split()).replace("|", "\\|")
