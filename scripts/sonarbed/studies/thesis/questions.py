"""The six questions that the thesis's claims come down to, and what its studies answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from sonarbed.reporting.section import Section
from sonarmap.errors import InputError

__all__ = ["ANSWERED_BY", "QUESTIONS", "REMEDY", "Answer", "Question", "ThesisSection", "questions"]

QUESTIONS = {
    1: "Does HSR raise the map's true score in room 1 (no opening) and room 2 (openings), by how "
    "much, at which parameters?",
    2: "What share of wrong readings does it mend, and how many right readings does it spoil, and "
    "where?",
    3: "Where is the true region of good wall sizes, and does table 6.1 lie in it?",
    4: "Which of the three goodness measures ranks maps as truth does?",
    5: "Is the parameterized model better than the standard one with the same parameters, in every "
    "room?",
    6: "Does the simulated TDTh come out near 60 mm, and the opening curve near 0.8 m for a 0.8 m "
    "opening?",
}

# Which studies settle a question; a report without them says which are missing.
ANSWERED_BY = {
    1: ("wall_sizes",),
    2: ("readings",),
    3: ("wall_sizes",),
    4: ("goodness",),
    5: ("two_models",),
    6: ("target_distance", "openings"),
}

REMEDY = "make it anew with --study {study} --again"
"""What to do about a study whose files are lost or damaged."""


@dataclass(frozen=True)
class Answer:
    """An answer to one of the `QUESTIONS`, with its numbers."""

    question: int
    text: str

    def __post_init__(self) -> None:
        if self.question not in QUESTIONS:
            raise InputError(f"question must be 1 to {len(QUESTIONS)}, got {self.question!r}")


@dataclass(frozen=True)
class ThesisSection(Section):
    """The report of one study of the thesis.

    Parameters
    ----------
    answers : tuple of Answer
        What it settles.
    """

    answers: tuple[Answer, ...] = ()

    @classmethod
    def load(cls, folder: Path) -> Self | None:
        """Return the section of a study's folder, None if it is not done yet."""
        try:
            return super().load(folder)
        except InputError as error:
            raise InputError(f"{error}; {REMEDY.format(study=folder.name)}") from None

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> Self:
        """Return a stored section with its answers."""
        answers = tuple(Answer(**answer) for answer in stored["answers"])
        return replace(super().from_dict(stored), answers=answers)


@dataclass(frozen=True)
class Question:
    """A question of the report, the answers of its studies, and which studies are missing."""

    number: int
    text: str
    answers: tuple[tuple[ThesisSection, Answer], ...]
    missing: tuple[str, ...]


def questions(sections: Sequence[ThesisSection]) -> list[Question]:
    """Return all questions with the answers of the sections that are done."""
    done = {section.study for section in sections}
    return [
        Question(
            number,
            text,
            tuple(
                (section, answer)
                for section in sections
                for answer in section.answers
                if answer.question == number
            ),
            tuple(study for study in ANSWERED_BY[number] if study not in done),
        )
        for number, text in QUESTIONS.items()
    ]
