"""Words and clauses: what causes are called, and what an interval decides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sonarbed.reporting.statistics import Estimate
from sonarmap import Cause

__all__ = ["cause_name", "interval_over", "verdicts", "word"]

_WORDS = ("better", "worse", "undecided")


def cause_name(cause: Cause) -> str:
    """Return a cause's name for people."""
    return cause.name.lower().replace("_", " ")


def interval_over(seeds: int) -> str:
    """Return of how many seeds an interval is, as a title says it: over one there is none."""
    return "1 seed, no interval" if seeds == 1 else f"95 % over {seeds} seeds"


def word(difference: Estimate, better: int) -> str:
    """Return whether a difference is better, worse or undecided.

    `better` is 1 if a positive difference is the better one, else -1.
    """
    return {1: _WORDS[0], -1: _WORDS[1], 0: _WORDS[2]}[difference.sign * better]


def verdicts(
    by_room: Mapping[str, Estimate],
    better: int,
    digits: int = 2,
    *,
    words: Sequence[str] = _WORDS,
) -> str:
    """Return in which rooms a number is on the good side of 0, on the other, or undecided.

    Parameters
    ----------
    by_room : mapping of str to Estimate
        The number of each room.
    better : int
        1 if positive is good, else -1.
    digits : int
        Digits after the point of the numbers.
    words : sequence of three str
        What the three are called.
    """
    clauses = []
    for name, wanted in zip(words, (1, -1, 0), strict=True):
        rooms = [
            f"{room} {estimate.value:+.{digits}f}"
            for room, estimate in by_room.items()
            if estimate.sign * better == wanted
        ]
        if rooms:
            clauses.append(f"{name} in {len(rooms)} of {len(by_room)} ({', '.join(rooms)})")
    return ", ".join(clauses)
