"""Figures 6.15 and 6.16, table 6.1: which sizes of estimated walls help, and whether any does."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.thesis.experiments import EXPERIMENTS, Experiment, WallPair
from sonarbed.studies.thesis.on_axis import heard_on_axis
from sonarbed.studies.thesis.questions import Answer, ThesisSection
from sonarbed.studies.thesis.wall_sizes.figures import heat_maps, maps, openings
from sonarbed.studies.thesis.wall_sizes.findings import (
    ON_AXIS,
    SCORE,
    WHOLE,
    border,
    cause,
    effect,
    openings_kept,
    region,
    runs_of,
)
from sonarbed.studies.thesis.wall_sizes.pairs import TABLE_6_1, in_table_6_1, pair_name, wall_pairs
from sonarbed.studies.thesis.wall_sizes.sweep import POLICIES, Room, Sweep, SweepTask, swept

__all__ = ["run"]

_FIGURE_6_15 = (
    "Experiment 1, no opening, Rth = Rmax: without HSR nothing of the room can be recognised; "
    "20-120 mm looks close to the room, 10-30 mm is too small, 30-140 mm too large, yet every one "
    "of them is better than none."
)
_FIGURE_6_16 = (
    "Experiment 2, openings of 80 cm, Rth = 800 mm: 10-80 mm works best; smaller walls mend less, "
    "larger ones add noise in the openings; all but one setting look better than no HSR."
)
_FIGURES = {1: ("Figure 6.15", _FIGURE_6_15), 2: ("Figure 6.16", _FIGURE_6_16)}
# Figure 6.16 speaks of these sizes of the largest wall, millimetres.
_BANDS = ((0, 79), (80, 80), (81, 110), (111, 170), (171, 200), (201, 1000))
_PAIR_MEASURES = (SCORE, "map_score ignore", "f1 clear", "f1 ignore", "points f1")


def run(context: StudyContext) -> ThesisSection:
    """Sweep the sizes of walls in both of the thesis's rooms."""
    pairs = wall_pairs(quick=context.quick)
    items: list[Item] = []
    answers: list[Answer] = []
    found: list[dict[str, Sweep]] = []
    for experiment in EXPERIMENTS:
        sweeps = _sweeps(context, experiment, pairs)
        items.append(_figure(context, experiment, sweeps))
        room = f"Room {experiment.number} ({'openings' if experiment.openings else 'no opening'})"
        answers.append(Answer(1, f"{room}. {effect(experiment, sweeps[WHOLE])}"))
        if experiment.openings:
            items.append(_openings(context, experiment, sweeps[WHOLE]))
        found.append(sweeps)
    first, second = found
    items.insert(1, _table_6_1(context, first))
    # The item covers the plotted points too; they lie in the plane, not in a map.
    of_maps = (SCORE, "f1 clear")
    in_1, in_2 = (region(sweeps[WHOLE], measures=of_maps) for sweeps in (first, second))
    where = f"Room 1. {in_1} Room 2. {in_2}"
    title = "HSR: the sizes of estimated walls (section 6.4)"
    return ThesisSection("wall_sizes", title, tuple(items), (*answers, Answer(3, where)))


def _sweeps(
    context: StudyContext, experiment: Experiment, pairs: tuple[WallPair, ...]
) -> dict[str, Sweep]:
    logs = context.logs(context.specs(experiment.room))
    tasks = [SweepTask(experiment, log, pairs) for log in logs]
    tasks += [SweepTask(experiment, heard_on_axis(log), pairs) for log in logs]
    drives = context.map(swept, tasks, f"wall sizes, experiment {experiment.number}")
    return {
        WHOLE: Sweep.of(pairs, drives[: len(logs)]),
        ON_AXIS: Sweep.of(pairs, drives[len(logs) :]),
    }


def _figure(context: StudyContext, experiment: Experiment, sweeps: Mapping[str, Sweep]) -> Item:
    number, thesis = _FIGURES[experiment.number]
    sweep = sweeps[WHOLE]
    name = f"experiment-{experiment.number}"
    (log,) = context.logs(context.specs(experiment.room, seeds=context.seeds[:1]))
    thesis_pairs = (experiment.thesis, *experiment.shown)
    return Item(
        number,
        thesis,
        f"{effect(experiment, sweep)} {cause(experiment, sweeps)}",
        (
            context.figure(
                f"{name}-heat",
                heat_maps(sweeps),
                "Change by HSR, mean over drives: blue is better, red is worse than no HSR. "
                "Framed: table 6.1. Star: the best pair. Dots: the interval excludes 0. Right: "
                "the same drives if no echo came from off the axis",
            ),
            context.figure(
                f"{name}-maps",
                maps(experiment, Room.of(experiment.room, log), log, sweep),
                "One drive. Upper half: maps, no echo clears (black: occupied). Lower half: data "
                "points as plotted; those beyond the picture are not shown. Orange: the true "
                "surfaces",
            ),
        ),
        (
            context.table(
                f"{name}-scores",
                (
                    "measure",
                    "without HSR",
                    *(f"change, {pair_name(pair)}" for pair in thesis_pairs),
                ),
                (
                    (
                        measure,
                        mean_of(before).text(),
                        *(sweep.change(measure, pair).text() for pair in thesis_pairs),
                    )
                    for measure, before in sweep.before.items()
                ),
                "All measures at the thesis's pairs",
            ),
            context.table(
                f"{name}-pairs",
                ("min wall, mm", "max wall, mm", *_PAIR_MEASURES, "mended", "spoiled"),
                _pair_rows(sweep),
                "Every pair: mean change by HSR with its interval; shares of the wrong readings "
                "mended and of the right ones spoiled",
            ),
        ),
    )


def _pair_rows(sweep: Sweep) -> Iterable[tuple[str, ...]]:
    changes = [sweep.changes(measure) for measure in (*_PAIR_MEASURES, "mended", "spoiled")]
    for index, (low, high) in enumerate(sweep.pairs):
        yield (str(low), str(high), *(change[index].text() for change in changes))


def _table_6_1(context: StudyContext, sweeps: Mapping[str, Sweep]) -> Item:
    sweep = sweeps[WHOLE]
    inside = in_table_6_1(sweep.pairs)
    lows = np.array([low for low, _ in sweep.pairs])
    measures = (SCORE, "f1 clear", "points f1")
    rows = []
    for low, (least, most) in TABLE_6_1.items():
        of_low = lows == low
        if not of_low.any():
            continue
        good = (_range_of(sweep, of_low & sweep.as_good_as_best(name)) for name in measures)
        means = (_mean_change(sweep, of_low & side) for side in (inside, ~inside))
        alone = runs_of(sweeps[ON_AXIS], "points f1", low)
        runs = ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in alone)
        rows.append((low, f"{least}-{most}", *good, *means, runs))
    return Item(
        "Table 6.1",
        "Good sizes, min: max wall in mm: 10: 160-200, 20: 110-190, 30: 50-110, 40: 50-100, "
        "50: 60-90, 60: 70-80, 70: 80.",
        f"{region(sweep)} Without off-axis echoes: {region(sweeps[ON_AXIS])} "
        f"By the plotted points: {border(sweeps[ON_AXIS])}",
        tables=(
            context.table(
                "table-6-1",
                (
                    "min wall, mm",
                    "thesis: max wall, mm",
                    "best by Map Score",
                    "best by F1",
                    "best by plotted points",
                    "mean change of Map Score in the thesis's range, bit",
                    "and outside of it, bit",
                    "without off-axis echoes, better than no HSR by plotted points",
                ),
                rows,
                "Best: the max walls, mm, not decidedly worse than the sweep's best pair (empty: "
                "none); maps with no echo clearing",
            ),
        ),
    )


def _range_of(sweep: Sweep, chosen: NDArray[np.bool_]) -> str:
    highs = [high for (_, high), take in zip(sweep.pairs, chosen, strict=True) if take]
    if len(highs) < 2:
        return "".join(map(str, highs))
    return f"{min(highs)}-{max(highs)}"


def _mean_change(sweep: Sweep, chosen: NDArray[np.bool_]) -> str:
    if not chosen.any():
        return ""
    return mean_of(sweep.after[SCORE][:, chosen].mean(axis=1) - sweep.before[SCORE]).text()


def _openings(context: StudyContext, experiment: Experiment, sweep: Sweep) -> Item:
    largest = np.array([high for _, high in sweep.pairs])
    columns: dict[str, NDArray[np.bool_]] = {}
    for low, high in _BANDS:
        band = (largest >= low) & (largest <= high)
        if band.any():
            columns[f"max {largest[band].min()}-{largest[band].max()} mm"] = band
    columns[pair_name(experiment.thesis)] = np.array(
        [pair == experiment.thesis for pair in sweep.pairs]
    )

    def row(measure: str) -> tuple[str, ...]:
        estimates: list[Estimate] = [mean_of(sweep.before[measure])]
        estimates += [sweep.mean_over(measure, chosen) for chosen in columns.values()]
        return (measure, *(estimate.text(2) for estimate in estimates))

    return Item(
        "Figure 6.16: the openings D1, D2 and the glass wall",
        "Max walls below 80 mm keep the openings best, 90 to 200 mm add noise in them, and one "
        "setting abolishes them; a glass wall is among those to be mended.",
        openings_kept(experiment, sweep),
        (
            context.figure(
                "openings",
                openings(experiment, sweep),
                "Openings, glass wall and readings over the max wall, mean over min walls; maps "
                "with no echo clearing. Bands: 95 %. Dotted: without HSR",
            ),
        ),
        (
            context.table(
                "openings",
                ("measure", "without HSR", *columns),
                [
                    row(f"{opening.name} {what} {policy}")
                    for policy in POLICIES
                    for opening in experiment.openings
                    for what in ("free", "occupied", "gap_m")
                ]
                + [row(f"glass {policy}") for policy in POLICIES],
                "Shares of an opening's cells mapped free and occupied, its widest gap without an "
                "occupied cell, and the share of the glass wall found within 10 cm",
            ),
        ),
    )
