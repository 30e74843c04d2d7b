"""`sonarbed tune`: parameters found by the true score of maps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.options import Json, check_writable

if TYPE_CHECKING:
    from rich.progress import TaskID

    from sonarbed.reporting.statistics import Estimate
    from sonarbed.studies.tuning.judging import RoomScores

__all__ = ["tune"]


def tune(
    out: Annotated[
        Path, typer.Option(help="The folder for tune.json, tune.png, the drives and the study.")
    ] = Path("tune"),
    target: Annotated[
        str, typer.Option(help="model, hsr (the model as in the thesis) or both.")
    ] = "model",
    model: Annotated[str, typer.Option(help="parameterized or standard.")] = "parameterized",
    sampler: Annotated[
        str, typer.Option(help="grid (the thesis's 1440 sets), nsga2 (genetic), tpe or cmaes.")
    ] = "tpe",
    score: Annotated[
        str,
        typer.Option(
            help="skill, map_score, average_precision, f1_10_cm or brier, over observable cells."
        ),
    ] = "skill",
    train: Annotated[
        str, typer.Option(metavar="ROOM,...", help="Rooms to tune on.")
    ] = "thesis-exp1,thesis-exp2,office",
    judge: Annotated[
        str, typer.Option(metavar="ROOM,...", help="Other rooms, to judge the best in.")
    ] = "l-shape,clutter",
    seeds: Annotated[int, typer.Option(help="Drives a room.")] = 3,
    scans: Annotated[int, typer.Option(help="Scans a drive.")] = 300,
    max_range: Annotated[
        float | None, typer.Option(help="Longer readings are no echo, metres; default the ring's.")
    ] = None,
    trials: Annotated[
        int | None, typer.Option(help="Trials in all, default 200; for the grid 1440.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes that work at once.")] = 2,
    seed: Annotated[
        int, typer.Option(help="Seed of the samplers; another on each machine of one study.")
    ] = 0,
    storage: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Optuna storage; default OUT/study.db (SQLite)."),
    ] = None,
    study_name: Annotated[str, typer.Option(help="Name of the study in the storage.")] = "tune",
    as_json: Json = False,
) -> None:
    """Find parameters of the sensor model and of HSR against the true score of maps.

    They are tuned on the drives of some rooms and judged on those of others, beside the thesis's
    own. The study is kept: after an interruption the same command goes on.

    Example:

      sonarbed tune --target both --sampler nsga2 --out tuned
    """
    from sonarmap.errors import InputError

    try:
        import cmaes  # noqa: F401  Optuna loads it only in the middle of a search
        import optuna  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"tune needs the package {error.name}: pip install 'sonarbed[tune]'"
        ) from None
    from sonarbed.console import as_json as json_text
    from sonarbed.console import print_json, print_table, progress, say
    from sonarbed.reporting.drives import account_of_drives
    from sonarbed.reporting.wording import interval_over
    from sonarbed.studies.tuning.judging import BEST, check_judges
    from sonarbed.studies.tuning.judging import judge as judge_in
    from sonarbed.studies.tuning.picture import draw_search
    from sonarbed.studies.tuning.search import Search, find
    from sonarbed.studies.tuning.settings import TuneSettings
    from sonarbed.studies.tuning.space import thesis_candidates
    from sonarmap.files import atomic_path

    settings = TuneSettings(target, model, sampler, score, _rooms(train), seeds, scans, max_range)
    url = f"sqlite:///{(out / 'study.db').absolute()}" if storage is None else storage
    search = Search(settings, out, url, study_name, seed)
    judges = _rooms(judge)
    check_judges(search, judges)
    results_file, picture = out / "tune.json", out / "tune.png"
    for path in (results_file, picture):
        check_writable(path)

    with progress() as bars:
        tasks: dict[str, TaskID] = {}

        def show(label: str, done: int, total: int) -> None:
            if label not in tasks:
                tasks[label] = bars.add_task(label, total=total)
            bars.update(tasks[label], completed=done, total=total)

        found = find(search, judges=judges, trials=trials, jobs=jobs, on_progress=show)
        candidates = {BEST: found.best.candidate, **thesis_candidates(target, model, max_range)}
        everywhere = judge_in(
            search, (*settings.train, *judges), candidates, jobs=jobs, on_progress=show
        )
        readings = {
            part: account_of_drives(
                search.drives, settings.drives(rooms), candidates["thesis"].pipeline.method
            )
            for part, rooms in (("training", settings.train), ("judged", judges))
        }
    training, judged = everywhere.only(settings.train), everywhere.only(judges)
    results: dict[str, Any] = {
        "settings": settings.to_dict(),
        "judge": judges,
        "seed": seed,
        "study": {"storage": search.kept.shown_url, "name": study_name},
        "trials": len(found.trials),
        "best_trial": found.best.number,
        "parameters": {name: each.to_dict() for name, each in candidates.items()},
        "readings": {part: used.to_dict() for part, used in readings.items()},
        "training": training.to_dict(),
        "judged": judged.to_dict(),
    }
    with atomic_path(results_file) as beside:
        beside.write_text(json_text(results), encoding="utf-8")
    others = {name: mean for name, mean in training.mean.items() if name != BEST}
    draw_search(search, found.trials, found.best, others, picture)
    if as_json:
        print_json(results)
        return
    print_table(
        f"Best of {len(found.trials)} trials: {target}, {sampler}",
        ["parameter", *candidates],
        _parameter_rows(results["parameters"]),
    )
    for title, result in (("Tuned on", training), ("Judged on", judged)):
        print_table(
            f"{title}: {score} ({interval_over(seeds)})",
            ["", *result.places],
            _score_rows(result),
        )
    for title, used in (("Tuned on", readings["training"]), ("Judged on", readings["judged"])):
        for line in used.lines:
            say(f"{title}: {line}")
    say(f"Written: {results_file}, {picture}; the study: {search.kept.shown_url}")


def _rooms(text: str) -> tuple[str, ...]:
    return tuple(room.strip() for room in text.split(",") if room.strip())


def _parameter_rows(candidates: dict[str, dict[str, float]]) -> list[list[str]]:
    # In the order in which they first come: HSR's after those of the model.
    names = dict.fromkeys(name for values in candidates.values() for name in values)
    return [
        [
            name,
            *(f"{values[name]:.4g}" if name in values else "-" for values in candidates.values()),
        ]
        for name in names
    ]


def _score_rows(judged: RoomScores) -> list[list[str]]:
    best, *others = judged.scores
    return [
        *(
            [name, *(_short(judged.score(name, place)) for place in judged.places)]
            for name in judged.scores
        ),
        *(
            [f"{best} - {name}", *(_short(judged.gain(name, place)) for place in judged.places)]
            for name in others
        ),
    ]


def _short(estimate: Estimate) -> str:
    # Student's interval is symmetric; there is none over one seed.
    half = estimate.high - estimate.value
    return f"{estimate.value:.3f}" + (f"±{half:.3f}" if math.isfinite(half) else "")
