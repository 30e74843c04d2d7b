"""Figures 6.15 and 6.16 and table 6.1: which sizes of estimated walls help, and whether any does."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from sonarbed.studies.mending import heard_on_axis
from sonarbed.studies.section import Answer, Item, Section
from sonarbed.studies.setting import Setting
from sonarbed.studies.statistics import Estimate, mean_of
from sonarbed.studies.wall_drawing import heat_maps, maps, openings
from sonarbed.studies.wall_pairs import (
    EXPERIMENTS,
    TABLE_6_1,
    Experiment,
    Pair,
    in_table_6_1,
    pair_name,
    wall_pairs,
)
from sonarbed.studies.wall_sweep import POLICIES, Room, Sweep, SweepTask, swept

__all__ = ["run"]

_SCORE = "map_score ignore"
# Sections of figure 6.16: what the thesis says of sizes of the largest wall, millimetres.
_BANDS = ((0, 79), (80, 80), (81, 110), (111, 170), (171, 200), (201, 1000))
_WHOLE, _ON_AXIS = "all readings", "no off-axis echoes"


def run(setting: Setting) -> Section:
    """Sweep the sizes of walls in both of the thesis's rooms."""
    pairs = wall_pairs(quick=setting.quick)
    first, second = (_sweeps(setting, experiment, pairs) for experiment in EXPERIMENTS)
    one, two = EXPERIMENTS
    return Section(
        "wall_sizes",
        "HSR: the sizes of estimated walls (section 6.4)",
        (
            _experiment(setting, one, first, "Figure 6.15", _FIGURE_6_15),
            _table_6_1(setting, first),
            _experiment(setting, two, second, "Figure 6.16", _FIGURE_6_16),
            _openings(setting, two, second[_WHOLE]),
        ),
        (
            *(
                Answer(1, _does_it_help(experiment, sweeps))
                for experiment, sweeps in zip(EXPERIMENTS, (first, second), strict=True)
            ),
            Answer(3, _where(first)),
        ),
    )


_FIGURE_6_15 = (
    "Experiment 1, no opening, Rth = Rmax: without HSR nothing of the room can be recognised; "
    "20-120 mm looks close to the room, 10-30 mm is too small, 30-140 mm too large, yet every one "
    "of them is better than none."
)
_FIGURE_6_16 = (
    "Experiment 2, openings of 80 cm, Rth = 800 mm: 10-80 mm works best; smaller walls mend less, "
    "larger ones add noise in the openings; all but one setting look better than no HSR."
)


def _sweeps(
    setting: Setting, experiment: Experiment, pairs: tuple[Pair, ...]
) -> dict[str, Sweep]:
    logs = setting.logs(experiment.room)
    tasks = [SweepTask(experiment, log, pairs) for log in logs]
    tasks += [SweepTask(experiment, heard_on_axis(log), pairs) for log in logs]
    drives = setting.map(swept, tasks, f"wall sizes, experiment {experiment.number}")
    return {
        _WHOLE: Sweep.of(pairs, drives[: len(logs)]),
        _ON_AXIS: Sweep.of(pairs, drives[len(logs) :]),
    }


def _experiment(
    setting: Setting, experiment: Experiment, sweeps: dict[str, Sweep], number: str, thesis: str
) -> Item:
    sweep = sweeps[_WHOLE]
    name = f"experiment-{experiment.number}"
    log = setting.logs(experiment.room)[0]
    room = Room.of(experiment.room, log)
    return Item(
        number,
        thesis,
        _finding(experiment, sweeps),
        (
            setting.figure(
                f"{name}-heat",
                heat_maps(sweeps),
                "Change by HSR, mean over drives. Framed: table 6.1. Star: the best pair. Dots: "
                "the 95 % interval excludes 0. Blue is better, red is worse than no HSR. Right: "
                "the same drives if no echo came from off the axis",
            ),
            setting.figure(
                f"{name}-maps",
                maps(experiment, room, log, sweep),
                "One drive. Upper rows: maps, no echo ignored (black: occupied). Lower rows: data "
                "points as plotted. Orange: the true surfaces",
            ),
        ),
        (
            setting.table(
                f"{name}-scores",
                ("measure", "without HSR", *(f"change, {pair_name(p)}" for p in _told(experiment))),
                _score_rows(experiment, sweep),
                "Scores at the thesis's pairs",
            ),
            setting.table(
                f"{name}-pairs",
                ("min, mm", "max, mm", *_PAIR_HEADER),
                _pair_rows(sweep),
                "Every pair: mean change by HSR with its interval",
            ),
        ),
    )


def _told(experiment: Experiment) -> tuple[Pair, ...]:
    return (experiment.thesis, *experiment.shown)


def _score_rows(experiment: Experiment, sweep: Sweep) -> Iterable[tuple[str, ...]]:
    for measure, before in sweep.before.items():
        known = "" if np.isnan(before).all() else mean_of(before).text()
        yield (
            measure,
            known,
            # Shares of mended and spoiled readings have no before: the change is the share.
            *(_change(sweep, measure, pair).text() for pair in _told(experiment)),
        )


def _change(sweep: Sweep, measure: str, pair: Pair) -> Estimate:
    if measure in ("mended", "spoiled"):
        return mean_of(sweep.after[measure][:, sweep.pairs.index(pair)])
    return sweep.change(measure, pair)


_PAIR_MEASURES = ("map_score ignore", "map_score clear", "f1 ignore", "f1 clear", "points f1")
_PAIR_HEADER = (
    *(f"{measure}{suffix}" for measure in _PAIR_MEASURES for suffix in ("", ", low", ", high")),
    "mended",
    "spoiled",
)


def _pair_rows(sweep: Sweep) -> Iterable[tuple[str | int, ...]]:
    changes = [sweep.changes(measure) for measure in _PAIR_MEASURES]
    for index, (low, high) in enumerate(sweep.pairs):
        row: list[str | int] = [low, high]
        for change in changes:
            told = change[index]
            row += [f"{told.value:.4f}", f"{told.low:.4f}", f"{told.high:.4f}"]
        row += [f"{sweep.after[name][:, index].mean():.4f}" for name in ("mended", "spoiled")]
        yield tuple(row)


def _finding(experiment: Experiment, sweeps: dict[str, Sweep]) -> str:
    sweep, on_axis = sweeps[_WHOLE], sweeps[_ON_AXIS]
    pair = experiment.thesis
    ignore, clear = (sweep.change(f"map_score {policy}", pair) for policy in POLICIES)
    best = sweep.pairs[sweep.best(_SCORE)]
    near = [_percent(values) for values in _before_after(sweep, "points near", pair)]
    return (
        f"At {pair_name(pair)} HSR {_verb(ignore)} the Map Score: {ignore.text(2)} bit a cell with "
        f"no echo ignored, {clear.text(2)} where no echo clears its cone. The best of "
        f"{len(sweep.pairs)} pairs, {pair_name(best)}, gives {sweep.change(_SCORE, best).text(2)}; "
        f"{_helping(sweep)}. Plotted as the thesis plots them, {near[0]} of the data points lie "
        f"within 0.1 m of a surface before and {near[1]} after. {_cause(sweep, on_axis, pair)}"
    )


def _cause(sweep: Sweep, on_axis: Sweep, pair: Pair) -> str:
    """Return the sentence that tells what the width of the cone has to do with it."""
    index = sweep.pairs.index(pair)
    spoiled = [mean_of(s.after["spoiled"][:, index]) for s in (sweep, on_axis)]
    change = on_axis.change("map_score clear", pair)
    near = _before_after(on_axis, "points near", pair)
    return (
        f"It mends {_percent(sweep.after['mended'][:, index])} of the wrong readings and spoils "
        f"{_percent(sweep.after['spoiled'][:, index])} of the right ones. Without the echoes from "
        f"off the axis, whose data points stand before the walls, it spoils "
        f"{spoiled[1].value:.1%} (with them {spoiled[0].value:.1%}), and the points near a surface "
        f"go from {_percent(near[0])} to {_percent(near[1])}; the Map Score where no echo clears "
        f"{_moves(change)}: {change.text(2)} bit."
    )


def _before_after(
    sweep: Sweep, measure: str, pair: Pair
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return sweep.before[measure], sweep.after[measure][:, sweep.pairs.index(pair)]


def _percent(values: NDArray[np.float64]) -> str:
    return f"{float(np.mean(values)):.0%}"


def _verb(change: Estimate) -> str:
    return {1: "raises", -1: "lowers", 0: "does not decidedly change"}[change.sign]


def _moves(change: Estimate) -> str:
    return {1: "rises", -1: "falls", 0: "does not decidedly change"}[change.sign]


def _helping(sweep: Sweep) -> str:
    """Return how many pairs decidedly raise and lower the Map Score under each policy."""
    told = []
    for policy, name in zip(POLICIES, ("no echo ignored", "no echo clearing"), strict=True):
        signs = np.array([change.sign for change in sweep.changes(f"map_score {policy}")])
        told.append(f"{(signs > 0).sum()} pairs raise it and {(signs < 0).sum()} lower it ({name})")
    return ", ".join(told)


def _table_6_1(setting: Setting, sweeps: dict[str, Sweep]) -> Item:
    sweep = sweeps[_WHOLE]
    region = in_table_6_1(sweep.pairs)
    rows = []
    for low, (least, most) in TABLE_6_1.items():
        of_low = np.array([pair[0] == low for pair in sweep.pairs])
        if not of_low.any():
            continue
        within = of_low & region
        rows.append(
            (
                low,
                f"{least}-{most}",
                *(
                    _range_of(sweep, of_low & _as_good(sweep, measure))
                    for measure in (_SCORE, "map_score clear", "points f1")
                ),
                f"{_mean_change(sweep, within).text()}" if within.any() else "",
                f"{_mean_change(sweep, of_low & ~region).text()}",
            )
        )
    return Item(
        "Table 6.1",
        "Good sizes, min: max wall in mm: 10: 160-200, 20: 110-190, 30: 50-110, 40: 50-100, "
        "50: 60-90, 60: 70-80, 70: 80.",
        _where(sweeps),
        tables=(
            setting.table(
                "table-6-1",
                (
                    "min wall, mm",
                    "thesis: max wall, mm",
                    "ours, Map Score, no echo ignored",
                    "ours, Map Score, no echo clears",
                    "ours, plotted points F1",
                    "mean change in the thesis's range, bit",
                    "mean change elsewhere, bit",
                ),
                rows,
                "Max walls not decidedly worse than the best pair of the sweep (of each measure); "
                "empty: none",
            ),
        ),
    )


def _as_good(sweep: Sweep, measure: str) -> NDArray[np.bool_]:
    return sweep.as_good_as_best(measure)


def _range_of(sweep: Sweep, chosen: NDArray[np.bool_]) -> str:
    highs = [high for (_, high), take in zip(sweep.pairs, chosen, strict=True) if take]
    if not highs:
        return ""
    return f"{min(highs)}-{max(highs)}" if len(highs) > 1 else str(highs[0])


def _mean_change(sweep: Sweep, chosen: NDArray[np.bool_]) -> Estimate:
    change = sweep.after[_SCORE][:, chosen].mean(axis=1) - sweep.before[_SCORE]
    return mean_of(change)


def _where(sweeps: dict[str, Sweep]) -> str:
    told = []
    for name, sweep in sweeps.items():
        region = in_table_6_1(sweep.pairs)
        for measure, title in ((_SCORE, "Map Score"), ("points f1", "F1 of the plotted points")):
            good = _as_good(sweep, measure)
            best = sweep.pairs[sweep.best(measure)]
            raised = np.array([change.sign > 0 for change in sweep.changes(measure)])
            told.append(
                f"{title}, {name}: best {pair_name(best)}, "
                f"{'within' if region[sweep.best(measure)] else 'outside of'} table 6.1; "
                f"{(good & region).sum()} of the {region.sum()} pairs of table 6.1 are as good as "
                f"it ({good.sum()} pairs in all), {(raised & region).sum()} are better than no HSR "
                f"({raised.sum()} of {len(sweep.pairs)} in all)."
            )
    sweep = sweeps[_WHOLE]
    region = in_table_6_1(sweep.pairs)
    values = sweep.after[_SCORE]
    lead = mean_of(values[:, region].mean(axis=1) - values[:, ~region].mean(axis=1))
    verdict = {1: "better", -1: "worse", 0: "neither better nor worse"}[lead.sign]
    return (
        f"Table 6.1's pairs are {verdict} than the others: {lead.text(3)} bit a cell. "
        + " ".join(told)
    )


def _does_it_help(experiment: Experiment, sweeps: dict[str, Sweep]) -> str:
    openings_ = "openings" if experiment.openings else "no opening"
    return f"Room {experiment.number} ({openings_}): {_finding(experiment, sweeps)}"


def _openings(setting: Setting, experiment: Experiment, sweep: Sweep) -> Item:
    largest = np.array([high for _, high in sweep.pairs])
    measures = [
        f"{opening.name} {what} {policy}"
        for policy in POLICIES
        for opening in experiment.openings
        for what in ("free", "occupied", "gap_m")
    ]
    measures += [f"glass {policy}" for policy in POLICIES]
    columns: list[tuple[str, NDArray[np.bool_] | None]] = [("without HSR", None)]
    for low, high in _BANDS:
        chosen = (largest >= low) & (largest <= high)
        if chosen.any():
            found = largest[chosen]
            columns.append((f"max {found.min()}-{found.max()} mm", chosen))
    thesis = np.array([pair == experiment.thesis for pair in sweep.pairs])
    columns.append((pair_name(experiment.thesis), thesis))
    rows = [
        (
            measure,
            *(
                (mean_of(sweep.before[measure]) if chosen is None else sweep.mean_over(measure, chosen)).text(2)
                for _, chosen in columns
            ),
        )
        for measure in measures
    ]
    return Item(
        "Figure 6.16: the openings D1, D2 and the glass wall",
        "Max walls below 80 mm keep the openings best, 90 to 200 mm add noise in them, and one "
        "setting abolishes them; the glass wall is to come out by HSR.",
        _openings_finding(experiment, sweep),
        (
            setting.figure(
                "openings",
                openings(experiment, sweep),
                "Openings and glass wall over the max wall, mean over min walls; no echo clears; "
                "bands: 95 %",
            ),
        ),
        (
            setting.table(
                "openings",
                ("measure", *(name for name, _ in columns)),
                rows,
                "Shares of an opening's cells mapped free and occupied, its widest free gap, and "
                "the share of the glass wall found within 10 cm",
            ),
        ),
    )


def _openings_finding(experiment: Experiment, sweep: Sweep) -> str:
    index = sweep.pairs.index(experiment.thesis)
    told = []
    for opening in experiment.openings:
        gap, share = (f"{opening.name} {what} clear" for what in ("gap_m", "occupied"))
        told.append(
            f"{opening.name} keeps a gap of {sweep.after[gap][:, index].mean():.2f} m "
            f"(without HSR {sweep.before[gap].mean():.2f} m) with "
            f"{_percent(sweep.after[share][:, index])} of its cells occupied "
            f"({_percent(sweep.before[share])})"
        )
    worst = min(
        (sweep.after[f"{opening.name} gap_m clear"].mean(axis=0).min(), opening.name)
        for opening in experiment.openings
    )
    glass = [_percent(values) for values in _before_after(sweep, "glass clear", experiment.thesis)]
    return (
        f"At {pair_name(experiment.thesis)}, no echo clearing: {'; '.join(told)}. Of all pairs the "
        f"worst leaves {worst[0]:.2f} m of {worst[1]}. The glass wall is found to {glass[0]} "
        f"before and {glass[1]} after."
    )
