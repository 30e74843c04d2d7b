"""The report: sections of studies as one self-contained HTML page, and the same in Markdown."""

from __future__ import annotations

import base64
import csv
from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader, select_autoescape

from sonarbed.studies.section import QUESTIONS, Section
from sonarbed.studies.setting import Setting
from sonarmap.files import atomic_path

__all__ = ["write_report"]

# A longer table is told by its file; the page shows its beginning.
_MOST_ROWS = 40


def write_report(setting: Setting, sections: Sequence[Section]) -> tuple[Path, Path]:
    """Write ``report.html`` and ``report.md`` into the setting's folder; return their paths.

    Parameters
    ----------
    setting : Setting
        Where the sections' figures and tables are, and what is told of how they were made.
    sections : sequence of Section
        The studies that are done, in the order of the report.
    """
    environment = Environment(
        loader=PackageLoader("sonarbed", "templates"),
        autoescape=select_autoescape(["html"]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals["picture"] = lambda section, file: _data_url(_file(setting, section, file))
    environment.globals["rows"] = lambda section, file: _rows(_file(setting, section, file))
    environment.filters["cells"] = _markdown_cells
    environment.globals["most_rows"] = _MOST_ROWS
    context = {
        "setting": setting,
        "sections": sections,
        "questions": [
            (number, text, _answers(sections, number)) for number, text in QUESTIONS.items()
        ],
    }
    written = []
    for name in ("report.html", "report.md"):
        text = environment.get_template(f"{name}.j2").render(context)
        with atomic_path(setting.folder / name) as path:
            path.write_text(text, encoding="utf-8")
        written.append(setting.folder / name)
    return written[0], written[1]


def _answers(sections: Sequence[Section], number: int) -> list[str]:
    return [a.text for section in sections for a in section.answers if a.question == number]


def _file(setting: Setting, section: Section, file: str) -> Path:
    return setting.folder / section.study / file


def _data_url(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode()


def _rows(file: Path) -> list[list[str]]:
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.reader(stream))


def _markdown_cells(texts: Sequence[str]) -> str:
    """Return texts as the cells of a row; a bar within one would begin the next."""
    return " | ".join(text.replace("|", "\\|") for text in texts)
