"""The page of the thesis report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.report import write_report
from sonarbed.studies.thesis.questions import REMEDY, ThesisSection, questions

__all__ = ["write_thesis_report"]


def write_thesis_report(
    context: StudyContext, sections: Sequence[ThesisSection]
) -> tuple[Path, Path]:
    """Write the page with the six questions and the sections that are done; return its files."""
    return write_report(
        context,
        sections,
        package="sonarbed.studies.thesis",
        values={"questions": questions(sections)},
        remedy=REMEDY,
    )
