"""Fair tuning: each method and filter gets as many evaluations, in rooms the arena never uses.

The objective is skill pooled over the training drives. A filter is tuned before one method with the
paper's parameters. To every tuned method a logistic of two numbers is fitted on the same drives.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

import sim
import sonarmap as sm
import worlds
from sonarbed.reporting.parallel import OnProgress, no_progress, parallel_map
from sonarbed.studies.arena.entries import FILTERED_METHODS
from sonarbed.studies.arena.jobs import DriveJob, Room, grid_of
from sonarbed.studies.arena.plan import FIRST_SEED
from sonarmap.errors import InputError, whole
from sonarmap.files import atomic_path
from sonarmap.parameters import Choice, Space, Whole, at_point
from sonarmap.scores.probabilities import CLAMP

__all__ = ["BEFORE", "TRAINING_ROOMS", "tune_all"]

BEFORE = FILTERED_METHODS[-1]
"""Filters are tuned before this method, the best of those named for them."""
TRAINING_ROOMS = 10
_SCANS, _RESOLUTION_M, _SONARS = 200, 0.05, ("physical", "thesis")
# What an oracle knows is not to be tuned, and what has nothing to search neither.
_UNTUNED = ("oracle-",)
# What a failing point scores: far below every sheet.
_LEAST_SLOPE = 0.001
_FAILED = -1e3


@dataclass(frozen=True)
class _Task:
    """A part to be tuned."""

    kind: str
    name: str
    budget: int
    seed: int


def tune_all(
    out: Path, *, budget: int, seed: int, jobs: int, on_progress: OnProgress = no_progress
) -> dict[str, Any]:
    """Tune every method and filter that has something to search, and write the result as JSON.

    Parameters
    ----------
    out : Path
        The file: put in place of ``sonarmap/tuned.json`` it is what ``tuned=True`` stands for.
    budget : int
        Evaluations of each, >= 1; the paper's parameters are one more, and stand if they are best.
    seed : int
        Of the search, >= 0.
    jobs : int
        Processes that work at once.
    """
    whole("budget", budget, least=1)
    whole("seed", seed, least=0)
    tasks = [
        *(_Task("method", name, budget, seed) for name in sm.methods() if _space("method", name)),
        *(
            _Task("filter", name, budget, seed)
            for name in sm.filters()
            if _space("filter", name) and not name.startswith(_UNTUNED)
        ),
    ]
    found = parallel_map(_tuned, tasks, "tuning", jobs=jobs, on_progress=on_progress)
    result: dict[str, Any] = {
        "command": f"sonarbed arena --tune {out.name} --budget {budget} --seed {seed}",
        "sonarbed": version("sonarbed"),
        "rooms": [room.name for room in _training_rooms()],
        "scans": _SCANS,
        "methods": {},
        "filters": {},
    }
    for task, told in zip(tasks, found, strict=True):
        result[f"{task.kind}s"][task.name] = told
    with atomic_path(out) as path:
        path.write_text(json.dumps(result, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return result


def _space(kind: str, name: str) -> Space:
    parts = sm.methods() if kind == "method" else sm.filters()
    space = getattr(parts[name], "space", None)
    return {} if space is None else space()


def _tuned(task: _Task) -> dict[str, Any]:
    """Return the best point of a part, with its skill and, of a method, its logistic."""
    try:
        import optuna
    except ImportError:
        raise InputError("--tune needs optuna: pip install 'sonarbed[tune]'") from None
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    space = _space(task.kind, task.name)
    study = optuna.create_study(
        direction="maximize", sampler=optuna.samplers.TPESampler(seed=task.seed)
    )

    def objective(trial: optuna.Trial) -> float:
        return _skill_of(task, {name: _suggested(trial, name, space[name]) for name in space})

    study.optimize(objective, n_trials=task.budget)
    published, best = _skill_of(task, None), float(study.best_value)
    # What no trial did better than the published setting for stays as it was published.
    point: dict[str, Any] = dict(study.best_params) if best > published else {}
    told: dict[str, Any] = {
        "point": point,
        "skill": round(max(best, published), 4),
        "published_skill": round(published, 4),
    }
    if task.kind == "method":
        told["logistic"] = _logistic(at_point(sm.methods()[task.name], point))
    return told


def _suggested(trial: Any, name: str, searched: Any) -> Any:
    if isinstance(searched, Choice):
        return trial.suggest_categorical(name, list(searched.values))
    if isinstance(searched, Whole):
        return trial.suggest_int(name, searched.low, searched.high)
    return trial.suggest_float(name, searched.low, searched.high, log=searched.log)


def _skill_of(task: _Task, point: Mapping[str, Any] | None) -> float:
    """Return the pooled skill of a point over the training drives; None is the published one."""
    try:
        if task.kind == "method":
            parts = sm.methods()[task.name]
            method = sm.method(task.name) if point is None else at_point(parts, point)
            pipeline = sm.Pipeline([], method)
        else:
            filters = sm.filters()[task.name]
            filter_ = sm.filter(task.name) if point is None else at_point(filters, point)
            pipeline = sm.Pipeline([filter_], sm.method(BEFORE))
        loss = sheet = 0.0
        for blind, truth, observable in _drives():
            score = sm.score_map(pipeline.map(blind, truth.grid), truth, observable=observable)
            if score.truth_occupied:
                loss, sheet = loss + score.loss_bits, sheet + score.sheet_loss_bits
    except InputError:  # the point breaks a rule of the part
        return _FAILED
    return 1 - loss / sheet


def _logistic(method: sm.MappingMethod) -> list[float]:
    """Return the slope and intercept that lose least over the training drives."""
    odds, walls = [], []
    for blind, truth, observable in _drives():
        m = method.map(blind, truth.grid)
        odds.append(m.log_odds[observable])
        walls.append(truth.state[observable] == worlds.OCCUPIED)
    x, y = np.concatenate(odds), np.concatenate(walls)

    def loss(numbers: NDArray[np.float64]) -> float:
        z = np.clip(numbers[0] * x + numbers[1], -30, 30)
        p = np.clip(1 / (1 + np.exp(-z)), CLAMP, 1 - CLAMP)
        return float(-np.where(y, np.log(p), np.log1p(-p)).mean())

    start = np.array([0.5, np.log(y.mean() / (1 - y.mean()))])
    best = minimize(
        loss,
        start,
        method="Nelder-Mead",
        # A map that ranks cells the wrong way round is not turned over: it is told to say nothing.
        bounds=[(_LEAST_SLOPE, None), (None, None)],
        options={"xatol": 1e-4, "fatol": 1e-7},
    )
    return [round(float(number), 5) for number in best.x]


def _training_rooms() -> list[Room]:
    styles = sorted(worlds.styles())
    assert TRAINING_ROOMS < FIRST_SEED, "the arena's rooms are others"
    return [Room(styles[k % len(styles)], k) for k in range(TRAINING_ROOMS)]


_Drive = tuple[sm.SonarLog, worlds.TruthGrid, NDArray[np.bool_]]


@lru_cache(maxsize=1)
def _drives() -> tuple[_Drive, ...]:
    """Return the training drives as methods see them; each process makes them once."""
    return tuple(map(_drive, range(TRAINING_ROOMS)))


def _drive(number: int) -> _Drive:
    room = _training_rooms()[number]
    sonar = _SONARS[number % len(_SONARS)]
    world = room.world()
    log = sim.simulate(world, scans=_SCANS, seed=number, sonar=sonar, engine="segments")
    drive = DriveJob(room, sonar, number, _SCANS, _RESOLUTION_M)
    truth = worlds.truth(world, grid_of(world, drive))
    return log.replace(truth=None, provenance={}), truth, truth.observable(log)
