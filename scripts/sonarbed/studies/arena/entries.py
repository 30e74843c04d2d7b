"""`Entry`: a reading filter and a mapping method that enter the arena together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import sonarmap as sm
from sonarmap.errors import InputError, did_you_mean
from sonarmap.tuned import tuned_names, tuned_point

__all__ = ["FILTERED_METHODS", "NO_FILTER", "Entry", "Variant", "all_entries", "entries_of"]

NO_FILTER = "none"
FILTERED_METHODS = ("bayes-parameterized", "konolige-style", "arc-competition")
"""Every filter is tried before these: the thesis's model, one that knows of specular walls, and one
whose echoes compete. Named before anything was run."""
# What an oracle is called; it alone sees the truth.
_ORACLE = "oracle-"
Variant = Literal["published", "tuned", "logistic"]


@dataclass(frozen=True)
class Entry:
    """A filter and a method, by the names or paths that make them.

    Parameters
    ----------
    method : str
        See `sonarmap.method`.
    filter : str
        See `sonarmap.filter`; `NO_FILTER` for none.
    variant : {"published", "tuned", "logistic"}
        With the paper's parameters; with tuned ones, of the filter if there is one and else of the
        method; or with these and a logistic after the method, see `sonarmap.method`.
    """

    method: str
    filter: str = NO_FILTER
    variant: Variant = "published"

    @property
    def label(self) -> str:
        """What tables call it: "hsr + bayes-standard", or the method alone."""
        parts = self.method if self.filter == NO_FILTER else f"{self.filter} + {self.method}"
        return parts if self.variant == "published" else f"{parts} ({self.variant})"

    def made(self) -> tuple[sm.ReadingFilter, sm.MappingMethod]:
        """Return its filter and its method."""
        is_filter = self.filter != NO_FILTER
        filter_ = sm.filter(self.filter, tuned=is_filter and self.variant == "tuned")
        tuned = {"published": False, "tuned": True, "logistic": "logistic"}[self.variant]
        return filter_, sm.method(self.method, tuned=False if is_filter else tuned)  # type: ignore[arg-type]  # one of three

    @property
    def is_oracle(self) -> bool:
        """Whether its filter is shown the truth."""
        return self.filter.startswith(_ORACLE)

    def checked(self) -> Entry:
        """Return it, or raise `InputError` if it has no such filter or method."""
        self.made()
        return self


def all_entries() -> list[Entry]:
    """Return every method without a filter, and every filter with the methods named for it.

    What stays as it was published after tuning has no second row of that.
    """
    variants: tuple[Variant, ...] = get_args(Variant)
    methods = [
        Entry(name, variant=variant)
        for name in sm.methods()
        for variant in variants
        if variant == "published"
        or (variant == "tuned" and _moved("method", name))
        or (variant == "logistic" and name in tuned_names("method"))
    ]
    filtered = [
        Entry(method, filter_)
        for filter_ in sm.filters()
        if filter_ != NO_FILTER
        for method in FILTERED_METHODS
    ]
    tuned = [
        Entry(FILTERED_METHODS[-1], name, "tuned")
        for name in tuned_names("filter")
        if _moved("filter", name)
    ]
    return methods + filtered + tuned


def _moved(kind: Literal["method", "filter"], name: str) -> bool:
    """Return whether tuning found something better than what was published."""
    return name in tuned_names(kind) and bool(tuned_point(kind, name))


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
