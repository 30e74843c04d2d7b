"""`Entry`: a reading filter and a mapping method that enter the arena together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sonarmap as sm
from sonarmap.errors import InputError, did_you_mean

__all__ = ["FILTERED_METHODS", "NO_FILTER", "Entry", "all_entries", "entries_of"]

NO_FILTER = "none"
FILTERED_METHODS = ("bayes-parameterized", "konolige-style", "arc-competition")
"""Every filter is tried before these: the thesis's model, one that knows of specular walls, and one
whose echoes compete. Named before anything was run."""
# What an oracle is called; it alone sees the truth.
_ORACLE = "oracle-"


@dataclass(frozen=True)
class Entry:
    """A filter and a method, by the names or paths that make them.

    Parameters
    ----------
    method : str
        See `sonarmap.method`.
    filter : str
        See `sonarmap.filter`; `NO_FILTER` for none.
    """

    method: str
    filter: str = NO_FILTER

    @property
    def label(self) -> str:
        """What tables call it: "hsr + bayes-standard", or the method alone."""
        return self.method if self.filter == NO_FILTER else f"{self.filter} + {self.method}"

    @property
    def is_oracle(self) -> bool:
        """Whether its filter is shown the truth."""
        return self.filter.startswith(_ORACLE)

    def checked(self) -> Entry:
        """Return it, or raise `InputError` if it has no such filter or method."""
        sm.method(self.method)
        sm.filter(self.filter)
        return self


def all_entries() -> list[Entry]:
    """Return every method without a filter, and every filter with the methods named for it."""
    methods = [Entry(name) for name in sm.methods()]
    filtered = [
        Entry(method, filter_)
        for filter_ in sm.filters()
        if filter_ != NO_FILTER
        for method in FILTERED_METHODS
    ]
    return methods + filtered


def entries_of(methods: Iterable[str], filters: Iterable[str]) -> list[Entry]:
    """Return the entries of some methods with some filters, or with none.

    Raises
    ------
    InputError
        If a name is unknown, with the nearest known one, or given twice.
    """
    chosen = [
        Entry(method, filter_).checked()
        for method in methods
        for filter_ in (tuple(filters) or (NO_FILTER,))
    ]
    for i, entry in enumerate(chosen):
        if entry in chosen[:i]:
            raise InputError(f"{entry.label} is entered twice")
    return chosen


def find(label: str, labels: Iterable[str]) -> str:
    """Return the label of an entry that is in the table, or raise `InputError`."""
    known = sorted(labels)
    if label not in known:
        raise InputError(f"{label!r} has no row in the table{did_you_mean(label, known)}")
    return label
