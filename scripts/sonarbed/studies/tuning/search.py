"""The search: an Optuna study that several processes work on, and that goes on where it was.

Every trial is a task of its own with a sampler of its own, seeded by the number of trials that
were finished before it. One process therefore finds the same, whether it was interrupted or not.
Several processes that share a study make the trials together: before each, one looks whether the
study has them all, so that there is at most one more for each process that was at work.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import optuna
from optuna.distributions import FloatDistribution
from optuna.trial import FrozenTrial, TrialState

from sim.runs.parallel import checked_jobs
from sonarbed.reporting.drives import DriveStore
from sonarbed.reporting.parallel import OnProgress, parallel_map
from sonarbed.studies.tuning.scoring import score_candidate
from sonarbed.studies.tuning.settings import TuneSettings
from sonarbed.studies.tuning.space import Candidate, candidate, ranges, thesis_points
from sonarbed.studies.tuning.storage import StudyStorage, connect, quiet_optuna, release
from sonarmap.errors import InputError, whole
from sonarmap.files import make_folder

__all__ = ["Search", "SearchResult", "find"]

# Generations of 20: ten of them in a search of 200 trials.
_POPULATION = 20
_SETTINGS = "sonarbed"


@dataclass(frozen=True)
class Search:
    """A search and where it is kept.

    Parameters
    ----------
    settings : TuneSettings
        What is searched.
    folder : Path
        Where the drives go, into ``logs``.
    storage : str
        URL of Optuna's storage.
    study_name : str
        Name of the study in it.
    seed : int
        Seed of the samplers, >= 0. Machines that share a study need different ones, or they
        would all begin with the same points.
    """

    settings: TuneSettings
    folder: Path
    storage: str
    study_name: str = "tune"
    seed: int = 0

    def __post_init__(self) -> None:
        whole("seed", self.seed, least=0)

    @property
    def drives(self) -> DriveStore:
        """The drives that it scores, and those to judge by."""
        return DriveStore(self.folder / "logs")

    @property
    def kept(self) -> StudyStorage:
        """Where its study is kept."""
        return StudyStorage(self.storage, self.study_name, maximize=self.settings.higher_is_better)


@dataclass(frozen=True)
class Trial:
    """A finished trial: its number in the study, its candidate and its score."""

    number: int
    candidate: Candidate
    score: float


@dataclass(frozen=True)
class SearchResult:
    """What a search has found: all finished trials in their order, and the best of them."""

    trials: tuple[Trial, ...]
    best: Trial


def find(
    search: Search,
    *,
    judges: Sequence[str] = (),
    trials: int | None = None,
    jobs: int = 1,
    on_progress: OnProgress,
) -> SearchResult:
    """Search until that many trials are finished, those of earlier runs included.

    Parameters
    ----------
    search : Search
        The search.
    judges : sequence of str
        Rooms that will be judged in: their drives are made together with those of the search.
    trials : int, optional
        How many, >= 1; by default 200, or all 1440 of the grid.
    jobs : int
        Processes that work at once, >= 1.
    on_progress : callable
        Called with a label, how much is done, and how much there is.

    Returns
    -------
    SearchResult

    Raises
    ------
    InputError
        If a number breaks its rule, the storage cannot be used, or its study was made with other
        settings.
    """
    grid = len(thesis_points()) if search.settings.sampler == "grid" else None
    wanted = (grid or 200) if trials is None else whole("trials", trials)
    if wanted < 1 or (grid is not None and wanted > grid):
        raise InputError(f"trials must be {f'1 to {grid}' if grid else '>= 1'}, got {wanted}")
    checked_jobs(jobs)
    make_folder(search.drives.folder)
    with quiet_optuna(), search.kept.usable():
        try:
            # Refused before the first drive, not after the last.
            study = _claimed(search)
            search.drives.simulate_missing(
                search.settings.drives((*search.settings.train, *judges)),
                jobs=jobs,
                on_progress=on_progress,
            )
            # A trial that was interrupted is made again; a set of the grid never is once it is
            # finished. Two machines may make the same one: then another is missing, unless
            # somebody else has made it by then.
            while tasks := _missing(search, study, wanted):
                parallel_map(
                    _one_trial,
                    tasks,
                    "trials",
                    jobs=jobs,
                    on_progress=_continued(on_progress, wanted - len(tasks)),
                )
            return _found(search, study)
        finally:
            release(search.kept)


def _continued(on_progress: OnProgress, before: int) -> OnProgress:
    """Return what reports progress after so many that were done before."""
    return lambda label, done, total: on_progress(label, before + done, before + total)


@dataclass(frozen=True)
class _Task:
    """A trial to be made: the how-manieth of all that are wanted, and for the grid its point."""

    search: Search
    number: int
    wanted: int
    point: tuple[tuple[str, float], ...] | None = None


def _missing(search: Search, study: optuna.Study, wanted: int) -> list[_Task]:
    """Return the trials that are left."""
    finished = _finished(study)
    if search.settings.sampler != "grid":
        return [_Task(search, number, wanted) for number in range(len(finished), wanted)]
    points = thesis_points()
    # In a random order, so that a part of the grid is a fair sample of it.
    order = np.random.default_rng(search.seed).permutation(len(points))
    done = {_key(trial.params) for trial in finished}
    left = [points[i] for i in order if _key(points[i]) not in done]
    return [
        _Task(search, number, wanted, tuple(point.items()))
        for number, point in enumerate(left[: max(wanted - len(done), 0)], len(done))
    ]


def _one_trial(task: _Task) -> None:
    """Make one trial; it is finished in the storage, or it does not count.

    Nothing is made when others, who share the study, have made all that is wanted, or the point.
    """
    search, settings = task.search, task.search.settings
    with quiet_optuna(), search.kept.usable():
        study = connect(search.kept)
        if _is_made(task, study):
            return
        study.sampler = _sampler(search, task.number, task.point)
        trial = study.ask(
            {
                name: FloatDistribution(low, high)
                for name, (low, high) in ranges(settings.target, settings.model).items()
            }
        )
        try:
            tried = candidate(trial.params, settings.model, settings.max_range_m)
            scores = [
                score_candidate(tried, search.drives.scorable(spec), settings.score)
                for spec in settings.drives(settings.train)
            ]
        except BaseException:
            # Ctrl-C as well: the trial is marked as failed, or it would seem to run for ever.
            study.tell(trial, state=TrialState.FAIL)
            raise
        # Asked again: who shares the study may have finished the last one meanwhile.
        if _is_made(task, study):
            study.tell(trial, state=TrialState.FAIL)
        else:
            study.tell(trial, float(np.mean(scores)))


def _is_made(task: _Task, study: optuna.Study) -> bool:
    """Return whether all that is wanted, or the task's point, has been made."""
    finished = _finished(study)
    if task.point is None:
        return len(finished) >= task.wanted
    made = {_key(trial.params) for trial in finished}
    return len(made) >= task.wanted or _key(dict(task.point)) in made


class _OnePoint(optuna.samplers.BaseSampler):
    """Samples the point that it was given."""

    def __init__(self, point: dict[str, float]) -> None:
        self._point = point

    def infer_relative_search_space(self, study: Any, trial: Any) -> dict[str, Any]:
        return {}

    def sample_relative(self, study: Any, trial: Any, search_space: Any) -> dict[str, Any]:
        return {}

    def sample_independent(
        self, study: Any, trial: Any, param_name: str, param_distribution: Any
    ) -> float:
        return self._point[param_name]


def _sampler(
    search: Search, number: int, point: tuple[tuple[str, float], ...] | None
) -> optuna.samplers.BaseSampler:
    if point is not None:
        return _OnePoint(dict(point))
    seed = int(np.random.SeedSequence([search.seed, number]).generate_state(1)[0])
    if search.settings.sampler == "nsga2":
        return optuna.samplers.NSGAIISampler(seed=seed, population_size=_POPULATION)
    if search.settings.sampler == "tpe":
        return optuna.samplers.TPESampler(seed=seed)
    return optuna.samplers.CmaEsSampler(seed=seed)


def _found(search: Search, study: optuna.Study) -> SearchResult:
    trials = tuple(
        Trial(
            trial.number,
            candidate(trial.params, search.settings.model, search.settings.max_range_m),
            float(trial.values[0]),
        )
        for trial in _finished(study)
    )
    sign = 1 if search.settings.higher_is_better else -1
    # The first of equals, whoever else works on the study.
    return SearchResult(trials, max(trials, key=lambda trial: (sign * trial.score, -trial.number)))


def _finished(study: optuna.Study) -> list[FrozenTrial]:
    return study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))


def _key(point: dict[str, Any]) -> tuple[tuple[str, float], ...]:
    # A database may round the last digits of a number.
    return tuple(sorted((name, round(value, 9)) for name, value in point.items()))


def _claimed(search: Search) -> optuna.Study:
    """Return the study, made if it is new, or raise `InputError` if it is another search's."""
    study = connect(search.kept)
    found = study.user_attrs.get(_SETTINGS)
    where = f"study {search.study_name!r} in {search.kept.shown_url}"
    if found is None:
        if not study.get_trials(deepcopy=False):
            study.set_user_attr(_SETTINGS, search.settings.to_dict())
        # Read again: another who began at the same time may have claimed it.
        found = study.user_attrs.get(_SETTINGS)
    if found is None:
        raise InputError(f"{where} was not made by sonarbed: choose another study name")
    difference = search.settings.difference(found)
    if difference is not None:
        raise InputError(
            f"{where} was made with {difference}: choose another folder, storage or study name"
        )
    return study
