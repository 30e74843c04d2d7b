"""What a study reports: items of its source, beside what we found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from sonarmap.errors import InputError
from sonarmap.files import atomic_path

__all__ = ["Item", "Section"]

_FILE = "section.json"


@dataclass(frozen=True)
class Item:
    """A figure or table: of the source, made again, beside what is simulated.

    Parameters
    ----------
    number : str
        Which, such as "Figure 6.15 and table 6.1".
    source : str
        What the source (a thesis, theory, a real log) shows or says there.
    finding : str
        What ours shows: a sentence with the number that decides.
    figures : tuple of (file, caption)
        PNG files beside the section.
    tables : tuple of (file, caption)
        CSV files beside the section, the first row its header.
    """

    number: str
    source: str
    finding: str
    figures: tuple[tuple[str, str], ...] = ()
    tables: tuple[tuple[str, str], ...] = ()

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> Self:
        """Return the item of a stored section."""
        return cls(
            stored["number"],
            # The name it had when a thesis was the only source.
            stored["thesis"] if "thesis" in stored else stored["source"],
            stored["finding"],
            tuple((name, caption) for name, caption in stored["figures"]),
            tuple((name, caption) for name, caption in stored["tables"]),
        )


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
    """

    study: str
    title: str
    items: tuple[Item, ...]

    def save(self, folder: Path) -> None:
        """Write ``section.json`` into the study's folder: from then on the study is done."""
        with atomic_path(folder / _FILE) as path:
            path.write_text(json.dumps(asdict(self), indent=2) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, folder: Path) -> Self | None:
        """Return the section of a study's folder, None if it is not done yet."""
        file = folder / _FILE
        if not file.exists():
            return None
        try:
            return cls.from_dict(json.loads(file.read_text(encoding="utf-8")))
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"{file}: is not a section of a report ({error!r})") from None

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> Self:
        """Return a stored section; what it holds besides is a subclass's."""
        items = tuple(Item.from_dict(item) for item in stored["items"])
        return cls(stored["study"], stored["title"], items)
