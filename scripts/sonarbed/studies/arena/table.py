"""The leaderboard: skill pooled and by room, with intervals over rooms, and paired differences."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError

__all__ = ["Interval", "Standing", "Table"]

_DRAWS, _LEVEL = 2000, 0.95
Row = Mapping[str, Any]


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval over rooms (bootstrap)."""

    value: float
    low: float
    high: float

    def text(self, digits: int = 2) -> str:
        """Return it as ``0.35 (0.30 to 0.41)``."""
        return f"{self.value:.{digits}f} ({self.low:.{digits}f} to {self.high:.{digits}f})"

    @property
    def sign(self) -> int:
        """-1 or 1 when the whole interval lies on that side of 0, else 0: not decided."""
        return 1 if self.low > 0 else -1 if self.high < 0 else 0


@dataclass(frozen=True)
class Standing:
    """How an entry stands.

    Parameters
    ----------
    entry : str
        Its label.
    runs : int
        Rows that it has.
    skill : Interval
        Mean of the rooms' skills, each pooled over its drives.
    pooled : float
        1 - sum / sum over all cells of all rooms.
    worst : float
        Skill in its worst room.
    rank : float
        Mean rank over the rooms, 1 the best.
    behind : Interval
        Skill less than the best entry's, room by room.
    means : mapping of str to float
        Means of other scores over the drives, NaN left out.
    """

    entry: str
    runs: int
    skill: Interval
    pooled: float
    worst: float
    rank: float
    behind: Interval
    means: Mapping[str, float]


MEANS = (
    "map_score",
    "average_precision",
    "tolerant_average_precision",
    "calibration_error",
    "recalibrated_skill",
    "f1_10_cm",
    "false_free_m2",
    "phantom_m2",
    "paths_colliding_share",
    "paths_missed_share",
    "seconds",
)


class Table:
    """Rows of the arena, entry by entry and room by room.

    Parameters
    ----------
    rows : iterable of mapping
        As `run_arena` returns them.
    seed : int
        Of the bootstrap.
    """

    def __init__(self, rows: Iterable[Row], *, seed: int = 0) -> None:
        self.rows = list(rows)
        if not self.rows:
            raise InputError("the arena has no row: every run failed")
        self.entries = sorted({str(row["entry"]) for row in self.rows})
        self.rooms = sorted({str(row["room"]) for row in self.rows})
        self._seed = seed

    def where(self, **wanted: Any) -> Table:
        """Return the table of the rows that have some values, as ``sonar="physical"``."""
        chosen = [row for row in self.rows if all(row[key] == v for key, v in wanted.items())]
        return Table(chosen, seed=self._seed)

    def room_skill(self, entry: str) -> NDArray[np.float64]:
        """Return an entry's skill in each room, NaN where it has no row; shape (rooms,)."""
        loss, sheet = self._losses(entry)
        with np.errstate(invalid="ignore", divide="ignore"):
            skill: NDArray[np.float64] = np.where(sheet > 0, 1 - loss / sheet, np.nan)
        return skill

    def paired(self, entry: str, other: str) -> Interval:
        """Return how much more skill an entry has than another, over the rooms that both have."""
        return self._interval(self.room_skill(entry) - self.room_skill(other))

    def standings(self) -> list[Standing]:
        """Return how all entries stand, the best mean skill first."""
        return list(self._standings)

    @cached_property
    def _standings(self) -> list[Standing]:
        """How all entries stand: a page asks for it again and again."""
        skills = {entry: self.room_skill(entry) for entry in self.entries}
        means = {entry: _mean(skill) for entry, skill in skills.items()}
        order = sorted(self.entries, key=lambda entry: (-_or_least(means[entry]), entry))
        best, ranks = order[0], self._ranks(skills)
        return [
            Standing(
                entry=entry,
                runs=sum(row["entry"] == entry for row in self.rows),
                skill=self._interval(skills[entry]),
                pooled=self._pooled(entry),
                worst=float(np.nanmin(skills[entry]))
                if np.isfinite(skills[entry]).any()
                else math.nan,
                rank=ranks[entry],
                behind=self._interval(skills[entry] - skills[best]),
                means={name: self.mean(entry, name) for name in MEANS},
            )
            for entry in order
        ]

    def mean(self, entry: str, name: str) -> float:
        """Return the mean of a score over an entry's drives, undefined ones left out."""
        values = [row.get(name) for row in self.rows if row["entry"] == entry]
        known = [float(value) for value in values if value is not None]
        return float(np.mean(known)) if known else math.nan

    def _losses(self, entry: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the summed losses of an entry and of the sheet in each room."""
        place = {room: k for k, room in enumerate(self.rooms)}
        loss, sheet = np.zeros(len(self.rooms)), np.zeros(len(self.rooms))
        for row in self.rows:
            # Where no wall was observable there is nothing to be skilled at.
            if row["entry"] == entry and row["skill"] is not None:
                loss[place[row["room"]]] += row["loss_bits"]
                sheet[place[row["room"]]] += row["sheet_loss_bits"]
        return loss, sheet

    def _pooled(self, entry: str) -> float:
        loss, sheet = self._losses(entry)
        return float(1 - loss.sum() / sheet.sum()) if sheet.sum() else math.nan

    def _ranks(self, skills: Mapping[str, NDArray[np.float64]]) -> dict[str, float]:
        """Return each entry's mean rank over the rooms that all have."""
        matrix = np.array([skills[entry] for entry in self.entries])
        both = matrix[:, np.isfinite(matrix).all(axis=0)]
        ranks = 1 + (-both).argsort(axis=0).argsort(axis=0)
        mean = ranks.mean(axis=1) if both.size else np.full(len(self.entries), math.nan)
        return dict(zip(self.entries, mean.tolist(), strict=True))

    def _interval(self, by_room: NDArray[np.float64]) -> Interval:
        known = by_room[np.isfinite(by_room)]
        if not known.size:
            return Interval(math.nan, math.nan, math.nan)
        rng = np.random.default_rng(self._seed)
        drawn = known[rng.integers(known.size, size=(_DRAWS, known.size))].mean(axis=1)
        low, high = np.quantile(drawn, [(1 - _LEVEL) / 2, (1 + _LEVEL) / 2])
        return Interval(float(known.mean()), float(low), float(high))


def _mean(values: NDArray[np.float64]) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else math.nan


def _or_least(value: float) -> float:
    return -math.inf if math.isnan(value) else value


def shares(rows: Sequence[Row], name: str) -> NDArray[np.float64]:
    """Return a score of rows as numbers, NaN where it is not defined."""
    return np.array([math.nan if row[name] is None else float(row[name]) for row in rows])
