"""What a study reports: items of the thesis, what we found, and answers to the six questions."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from sonarmap.errors import InputError
from sonarmap.files import atomic_path

__all__ = ["ANSWERED_BY", "QUESTIONS", "Answer", "Item", "Section"]

_FILE = "section.json"

QUESTIONS = {
    1: "Does HSR raise the map's true score in room 1 (no opening) and room 2 (openings), by how "
    "much, at which parameters?",
    2: "What share of wrong readings does it mend, and how many right readings does it spoil, and "
    "where?",
    3: "Where is the true region of good wall sizes, and does table 6.1 lie in it?",
    4: "Which of the three goodness measures ranks maps as truth does?",
    5: "Is the parameterised model better than the standard one with the same parameters, in every "
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


@dataclass(frozen=True)
class Item:
    """A figure or table: of the thesis, made again, or of theory, beside what is simulated.

    Parameters
    ----------
    number : str
        Which, such as "Figure 6.15 and table 6.1".
    thesis : str
        What the thesis, or theory, shows or says there.
    finding : str
        What ours shows: a sentence with the number that decides.
    figures : tuple of (file, caption)
        PNG files beside the section.
    tables : tuple of (file, caption)
        CSV files beside the section, the first row its header.
    """

    number: str
    thesis: str
    finding: str
    figures: tuple[tuple[str, str], ...] = ()
    tables: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Answer:
    """An answer to one of the `QUESTIONS`, with its numbers."""

    question: int
    text: str

    def __post_init__(self) -> None:
        if self.question not in QUESTIONS:
            raise InputError(f"question must be 1 to {len(QUESTIONS)}, got {self.question!r}")


@dataclass(frozen=True)
class Section:
    """The report of one study.

    Parameters
    ----------
    study : str
        Name of the study.
    title : str
        For people.
    items : tuple of Item
        What it made again.
    answers : tuple of Answer
        What it settles.
    """

    study: str
    title: str
    items: tuple[Item, ...]
    answers: tuple[Answer, ...] = ()

    def save(self, folder: Path) -> None:
        """Write ``section.json`` into the study's folder: from then on the study is done."""
        with atomic_path(folder / _FILE) as path:
            path.write_text(json.dumps(asdict(self), indent=2) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, folder: Path) -> Section | None:
        """Return the section of a study's folder, None if it is not done yet."""
        file = folder / _FILE
        if not file.exists():
            return None
        try:
            told = json.loads(file.read_text(encoding="utf-8"))
            return cls(
                study=told["study"],
                title=told["title"],
                items=tuple(
                    Item(
                        item["number"],
                        item["thesis"],
                        item["finding"],
                        tuple((name, caption) for name, caption in item["figures"]),
                        tuple((name, caption) for name, caption in item["tables"]),
                    )
                    for item in told["items"]
                ),
                answers=tuple(Answer(**answer) for answer in told["answers"]),
            )
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(
                f"{file}: is not a section of a report ({error!r}); make it anew with "
                f"--study {folder.name} --again"
            ) from None
