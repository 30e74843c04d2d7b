"""The best candidate against the thesis's own, in rooms that the search has never seen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarbed.reporting.drives import DriveSpec
from sonarbed.reporting.parallel import OnProgress, parallel_map
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.tuning.scoring import score_candidate
from sonarbed.studies.tuning.search import Search
from sonarbed.studies.tuning.settings import check_rooms
from sonarbed.studies.tuning.space import Candidate
from sonarmap.errors import InputError

__all__ = ["ALL_ROOMS", "BEST", "RoomScores", "check_judges", "judge"]

BEST = "best"
ALL_ROOMS = "all rooms"


@dataclass(frozen=True)
class RoomScores:
    """Scores of candidates in rooms.

    Parameters
    ----------
    rooms : tuple of str
        The rooms.
    scores : mapping of str to ndarray, shape (rooms, seeds)
        Score of each drive's map, by the name of the candidate.
    """

    rooms: tuple[str, ...]
    scores: Mapping[str, NDArray[np.float64]]

    @property
    def places(self) -> tuple[str, ...]:
        """What there are means of: each room and, when there are several, all of them."""
        return self.rooms if len(self.rooms) == 1 else (*self.rooms, ALL_ROOMS)

    def only(self, rooms: Sequence[str]) -> RoomScores:
        """Return the scores of some of the rooms."""
        rows = [self.rooms.index(room) for room in rooms]
        return RoomScores(
            tuple(rooms), {name: scores[rows] for name, scores in self.scores.items()}
        )

    @property
    def mean(self) -> dict[str, float]:
        """Mean score of each candidate over all drives, what the search goes by."""
        return {name: float(scores.mean()) for name, scores in self.scores.items()}

    def score(self, name: str, place: str) -> Estimate:
        """Return a candidate's mean score over the seeds, with its 95 % interval."""
        return mean_of(self._by_seed(self.scores[name], place))

    def gain(self, over: str, place: str) -> Estimate:
        """Return how much the best candidate's score exceeds another's, drive by drive."""
        return mean_of(self._by_seed(self.scores[BEST] - self.scores[over], place))

    def to_dict(self) -> dict[str, Any]:
        """Return means, intervals and the scores behind them as JSON-able values."""
        others = [name for name in self.scores if name != BEST]
        return {
            place: {
                "scores": {
                    name: {
                        **_as_dict(self.score(name, place)),
                        "by_seed": self._by_seed(scores, place).tolist(),
                    }
                    for name, scores in self.scores.items()
                },
                "best_minus": {name: _as_dict(self.gain(name, place)) for name in others},
            }
            for place in self.places
        }

    def _by_seed(self, scores: NDArray[np.float64], place: str) -> NDArray[np.float64]:
        # Over all rooms a seed counts once: the mean of its drives, a room each.
        by_seed: NDArray[np.float64] = (
            scores.mean(axis=0) if place == ALL_ROOMS else scores[self.rooms.index(place)]
        )
        return by_seed


def check_judges(search: Search, rooms: Sequence[str]) -> None:
    """Raise `InputError` unless the rooms are known and none is one of the search."""
    check_rooms("judge", rooms)
    both = [room for room in rooms if room in search.settings.train]
    if both:
        raise InputError(
            f"judge must name other rooms than train, got {', '.join(both)} in both: a search is "
            "judged where it has not been"
        )


def judge(
    search: Search,
    rooms: Sequence[str],
    candidates: Mapping[str, Candidate],
    *,
    jobs: int = 1,
    on_progress: OnProgress,
) -> RoomScores:
    """Return the scores of candidates in rooms, on the drives that `find` has made there."""
    specs = search.settings.drives(rooms)
    tasks = [(search, spec, tuple(candidates.values())) for spec in specs]
    scores = np.array(parallel_map(_scores, tasks, "judging", jobs=jobs, on_progress=on_progress))
    by_candidate = scores.reshape(len(rooms), search.settings.seeds, len(candidates))
    return RoomScores(tuple(rooms), {n: by_candidate[..., i] for i, n in enumerate(candidates)})


def _scores(task: tuple[Search, DriveSpec, tuple[Candidate, ...]]) -> list[float]:
    search, spec, candidates = task
    drive, settings = search.drives.scorable(spec), search.settings
    return [score_candidate(each, drive, settings.score) for each in candidates]


def _as_dict(estimate: Estimate) -> dict[str, float | None]:
    numbers = {"mean": estimate.value, "low": estimate.low, "high": estimate.high}
    return {name: value if math.isfinite(value) else None for name, value in numbers.items()}
