"""What the sweep over wall sizes found, in sentences made from its numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.thesis.experiments import Experiment, WallPair
from sonarbed.studies.thesis.wall_sizes.pairs import TABLE_6_1, in_table_6_1, pair_name
from sonarbed.studies.thesis.wall_sizes.sweep import Sweep

__all__ = [
    "ON_AXIS",
    "SCORE",
    "WHOLE",
    "border",
    "cause",
    "effect",
    "openings_kept",
    "region",
    "runs_of",
]

# The sweeps of an experiment: of the drives as they are, and as if no echo came from off the axis.
WHOLE, ON_AXIS = "all readings", "no off-axis echoes"
# A lost echo harms only a map in which no echo clears the cone: there HSR has something to mend.
SCORE = "map_score clear"
_MEASURES = {
    SCORE: "Map Score (no echo clears)",
    "f1 clear": "F1 within 10 cm (no echo clears)",
    "points f1": "F1 of the plotted data points",
}


def effect(experiment: Experiment, sweep: Sweep) -> str:
    """Return what HSR does to the scores at the thesis's pair and at the best one."""
    pair, best = experiment.thesis, sweep.pairs[sweep.best(SCORE)]
    clear, ignore = (sweep.change(f"map_score {policy}", pair) for policy in ("clear", "ignore"))
    raised, lowered = _decided(sweep, SCORE)
    f1 = sweep.change("f1 clear", pair)
    near, beyond = (before_after(sweep, f"points {what}", pair) for what in ("near", "beyond"))
    skill_before, skill_after = before_after(sweep, "skill clear", pair)
    return (
        f"At {pair_name(pair)} HSR {_verb(clear)} the Map Score where no echo clears its cone: "
        f"{clear.text(2)} bit a cell from {sweep.before[SCORE].mean():.2f} (no echo ignored: "
        f"{ignore.text(2)} from {sweep.before['map_score ignore'].mean():.2f}). Its skill, 0 for a "
        f"blank sheet, goes from {skill_before.mean():.2f} to {skill_after.mean():.2f}. Of "
        f"{len(sweep.pairs)} pairs {raised.sum()} raise it and {lowered.sum()} lower it; the best, "
        f"{pair_name(best)}, gives {sweep.change(SCORE, best).text(2)}. The map's F1 within 10 cm "
        f"{_moves(f1)} ({f1.text(2)} from {sweep.before['f1 clear'].mean():.2f}). Of the data "
        f"points, plotted as the thesis plots them, {percent(beyond[0])} lie outside of the room "
        f"before and {percent(beyond[1])} after, and within 0.1 m of a surface "
        f"{percent(near[0])} before and {percent(near[1])} after{_looks(beyond, near)}."
    )


def cause(experiment: Experiment, sweeps: Mapping[str, Sweep]) -> str:
    """Return what the readings and the width of the cone have to do with it."""
    sweep, on_axis = sweeps[WHOLE], sweeps[ON_AXIS]
    pair = experiment.thesis
    mended, spoiled = (before_after(sweep, name, pair)[1] for name in ("mended", "spoiled"))
    spoiled_on_axis = before_after(on_axis, "spoiled", pair)[1]
    near_before, near_after = before_after(on_axis, "points near", pair)
    score, phantom = (on_axis.change(name, pair) for name in (SCORE, "phantom_m2 clear"))
    return (
        f"It mends {percent(mended)} of the wrong readings and spoils {percent(spoiled)} of the "
        "right ones. The data point of an echo from off the axis stands before the wall that the "
        f"axis meets; without such echoes {percent(spoiled_on_axis)} are spoiled, and the data "
        f"points near a surface go from {percent(near_before)} to {percent(near_after)}. The Map "
        f"Score of these drives {_moves(score)} ({score.text(2)} bit), and the area of phantom "
        f"walls {_moves(phantom)} ({phantom.text(2)} m²): a reading is mapped over the whole cone, "
        "mended or not."
    )


def region(sweep: Sweep, *, measures: tuple[str, ...] = tuple(_MEASURES)) -> str:
    """Return where the good pairs are, and which of table 6.1's are among them."""
    inside = in_table_6_1(sweep.pairs)
    sentences = []
    for measure in measures:
        raised, _ = _decided(sweep, measure)
        good, best = sweep.as_good_as_best(measure), sweep.best(measure)
        sentences.append(
            f"By {_MEASURES[measure]} {_those(sweep.pairs, raised)} better than no HSR, "
            f"{(raised & inside).sum()} of them in table 6.1; the best is "
            f"{pair_name(sweep.pairs[best])} ({sweep.changes(measure)[best].text(2)}), "
            f"{'in' if inside[best] else 'outside of'} table 6.1, which holds "
            f"{(good & inside).sum()} of the {good.sum()} pairs not decidedly worse than it. "
            f"{_lead(sweep, measure, inside)}"
        )
    return " ".join(sentences)


def runs_of(sweep: Sweep, measure: str, low: int) -> list[tuple[int, int]]:
    """Return the runs of max walls, for one min wall, that are better than no HSR."""
    changes = sweep.changes(measure)
    runs: list[tuple[int, int]] = []
    previous = False
    for (smallest, largest), change in zip(sweep.pairs, changes, strict=True):
        if smallest != low:
            continue
        helps = change.sign > 0
        if helps:
            runs = [*runs[:-1], (runs[-1][0], largest)] if previous else [*runs, (largest,) * 2]
        previous = helps
    return runs


def border(sweep: Sweep, measure: str = "points f1") -> str:
    """Return up to which max wall HSR helps, from the least on, beside the end of table 6.1."""
    clauses = []
    for low, (_, most) in TABLE_6_1.items():
        highs = [high for smallest, high in sweep.pairs if smallest == low]
        if not highs:
            continue
        runs = runs_of(sweep, measure, low)
        helps = bool(runs) and runs[0][0] == min(highs)
        clauses.append(f"{low}: {runs[0][1] if helps else 'none'} (thesis {most})")
    return (
        "Min wall, and the max wall up to which HSR helps from the least one on, mm: "
        f"{', '.join(clauses)}."
    )


def openings_kept(experiment: Experiment, sweep: Sweep) -> str:
    """Return what becomes of the openings and the glass wall."""
    pair, clauses = experiment.thesis, []
    for opening in experiment.openings:
        gap = before_after(sweep, f"{opening.name} gap_m clear", pair)
        occupied = before_after(sweep, f"{opening.name} occupied clear", pair)
        clauses.append(
            f"{opening.name} has a gap of {gap[0].mean():.2f} m before and {gap[1].mean():.2f} m "
            f"after, and {percent(occupied[0])} and {percent(occupied[1])} of its cells occupied"
        )
    closed = []
    for opening in experiment.openings:
        left = sweep.after[f"{opening.name} gap_m clear"].mean(axis=0)
        worst = int(left.argmin())
        closed.append(f"{opening.name} {left[worst]:.2f} m at {pair_name(sweep.pairs[worst])}")
    glass = sweep.change("glass clear", pair)
    before, after = before_after(sweep, "glass clear", pair)
    return (
        f"At {pair_name(pair)}, no echo clearing: {'; '.join(clauses)}. The least gap of all "
        f"pairs: {', '.join(closed)}. The share of the glass wall that is found {_moves(glass)}: "
        f"{percent(before)} before, {percent(after)} after."
    )


def before_after(
    sweep: Sweep, measure: str, pair: WallPair
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a measure of each drive without HSR and after HSR with a pair."""
    return sweep.before[measure], sweep.after[measure][:, sweep.pairs.index(pair)]


def percent(values: NDArray[np.float64]) -> str:
    """Return the mean of shares in percent."""
    return f"{float(np.nanmean(values)):.0%}"


def _decided(sweep: Sweep, measure: str) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    signs = np.array([change.sign for change in sweep.changes(measure)])
    return signs > 0, signs < 0


def _looks(
    beyond: tuple[NDArray[np.float64], NDArray[np.float64]],
    near: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> str:
    """Return how the eye is misled when fewer points lie outside and fewer lie right."""
    cleared, missed = (mean_of(after - before).sign for before, after in (beyond, near))
    return ": to the eye tidier, in truth worse" if cleared < 0 and missed < 0 else ""


def _those(pairs: tuple[WallPair, ...], chosen: NDArray[np.bool_]) -> str:
    taken = [pair for pair, take in zip(pairs, chosen, strict=True) if take]
    if not taken:
        return f"none of the {len(pairs)} pairs is"
    if len(taken) == len(pairs):
        return f"all {len(pairs)} pairs are"
    lows, highs = {low for low, _ in taken}, {high for _, high in taken}
    return (
        f"{len(taken)} of the {len(pairs)} pairs (min {min(lows)} to {max(lows)} mm, max "
        f"{min(highs)} to {max(highs)} mm) are"
    )


def _lead(sweep: Sweep, measure: str, inside: NDArray[np.bool_]) -> str:
    values = sweep.after[measure]
    lead = mean_of(values[:, inside].mean(axis=1) - values[:, ~inside].mean(axis=1))
    verdict = {1: "better than", -1: "worse than", 0: "not to be told from"}[lead.sign]
    return f"Table 6.1's pairs are on average {verdict} the others: {lead.text(3)}."


def _verb(change: Estimate) -> str:
    return {1: "raises", -1: "lowers", 0: "does not decidedly change"}[change.sign]


def _moves(change: Estimate) -> str:
    return {1: "rises", -1: "falls", 0: "does not decidedly change"}[change.sign]
