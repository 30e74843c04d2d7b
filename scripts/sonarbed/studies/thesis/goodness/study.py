"""Figures 5.9 to 5.12, tables 5.1 and 5.2, and question 4: goodness of maps without truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import stats

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import Estimate
from sonarbed.reporting.wording import verdicts
from sonarbed.studies.thesis.goodness.best_sets import (
    first_bar_item,
    optimal_sets_item,
    other_measures_item,
    thesis_choices,
)
from sonarbed.studies.thesis.goodness.choices import BINS, choices, first_bar, ranking
from sonarbed.studies.thesis.goodness.figures import (
    draw_histograms,
    draw_rankings,
    draw_scatter,
)
from sonarbed.studies.thesis.goodness.search import (
    CELL_M,
    MEASURES,
    RANGE_LIMIT_M,
    TRUTHS,
    RoomSearch,
    search,
)
from sonarbed.studies.thesis.questions import Answer, ThesisSection

__all__ = ["run"]

_RANK_WORDS = ("ranks as the truth", "ranks against it", "undecided")

Rankings = Mapping[tuple[str, str, str], Estimate]


def run(context: StudyContext) -> ThesisSection:
    """Search the parameter sets in four rooms, and let the truth judge the measures."""
    searches = search(context)
    chosen = {found.room: choices(found) for found in searches}
    printed = {found.room: thesis_choices(found) for found in searches}
    rankings = {
        (found.room, measure.name, truth.name): ranking(found, measure, truth)
        for found in searches
        for measure in MEASURES
        for truth in TRUTHS
    }
    return ThesisSection(
        "goodness",
        "Goodness of maps without ground truth (section 5.3)",
        (
            _histogram(context, searches),
            optimal_sets_item(context, searches, chosen, printed),
            first_bar_item(context, searches),
            other_measures_item(chosen, printed),
            _ranks(context, searches, rankings),
        ),
        (_answer(searches, rankings),),
    )


def _histogram(context: StudyContext, searches: Sequence[RoomSearch]) -> Item:
    bars = [first_bar(found.mean("vsdns")) for found in searches]
    header = ["bin", *(f"{f.room}, {what}" for f in searches for what in ("from", "sets"))]
    rows = [
        [i + 1, *(cell for bar in bars for cell in (f"{bar.edges[i]:.6f}", int(bar.counts[i])))]
        for i in range(BINS)
    ]
    rows.append(["end", *(cell for bar in bars for cell in (f"{bar.edges[-1]:.6f}", ""))])
    clauses = []
    for found, bar in zip(searches, bars, strict=True):
        vsdns = found.mean("vsdns")
        p = float(stats.normaltest(vsdns).pvalue) if vsdns.size >= 20 else float("nan")
        normal = "not normal" if p < 0.05 else "not told from normal"
        clauses.append(
            f"{found.room} {bar.edges[0]:.4f} to {bar.edges[-1]:.4f}, the first bar up to "
            f"{bar.edges[1]:.4f} with {bar.counts[0]} sets, skewness {stats.skew(vsdns):+.2f} "
            f"({normal}, p = {p:.2g})"
        )
    between = searches[0].values["vsdns"].std(axis=1).mean()
    return Item(
        "Figure 5.9",
        "VSDNS of 1440 parameter sets in 14 bins: from 0.054 to about 0.12, 'represents a normal "
        "distribution', the first bar from 0.054079 to 0.059045 with 28 sets.",
        f"VSDNS of {len(searches[0].sets)} sets, mean over the drives: {'; '.join(clauses)}. "
        f"Between drives a set's VSDNS in {searches[0].room} varies by {between:.4f} (standard "
        "deviation).",
        (
            context.figure(
                "histograms",
                draw_histograms(searches),
                f"VSDNS of {len(searches[0].sets)} sets in {BINS} bins, range limit "
                f"{RANGE_LIMIT_M:g} m, cells of {CELL_M * 100:g} cm; the first bar in orange",
            ),
        ),
        (context.table("histograms", header, rows, "The bins: where each begins, and its sets"),),
    )


def _ranks(context: StudyContext, searches: Sequence[RoomSearch], rankings: Rankings) -> Item:
    rooms = [found.room for found in searches]
    table = context.table(
        "rankings",
        ("room", "measure", *(f"with {truth.title}" for truth in TRUTHS)),
        [
            (room, m.title, *(rankings[room, m.name, truth.name].text() for truth in TRUTHS))
            for room in rooms
            for m in MEASURES
        ],
        f"Spearman's rank correlation over {len(searches[0].sets)} sets with the true score, signs "
        "turned so that 1 ranks as the truth does; 95 % intervals over the seeds, those of two "
        "runs widened for the runs that neighbouring pairs share",
    )
    best = max(MEASURES, key=lambda m: _mean_ranking(rankings, rooms, m.name))
    clauses = [f"{m.title} {_mean_ranking(rankings, rooms, m.name):+.2f}" for m in MEASURES]
    return Item(
        "Section 5.4: which measure can be trusted",
        "No measure gave satisfactory results; VSDNS is said to do better than the other two. "
        "There was no truth to compare with.",
        f"Mean rank correlation with the truth over {len(rooms)} rooms and both true scores: "
        f"{', '.join(clauses)}. The highest is that of {best.title}.",
        (
            context.figure(
                "rankings",
                draw_rankings(rooms, rankings),
                "Rank correlation of each measure with the true scores over the parameter sets, "
                "with 95 % intervals over the seeds",
            ),
            context.figure(
                "scatter",
                draw_scatter(searches),
                "Every parameter set: what a measure says (better to the right) and its true Map "
                "Score, means over the seeds",
            ),
        ),
        (table,),
    )


def _mean_ranking(rankings: Rankings, rooms: Sequence[str], measure: str) -> float:
    return float(np.mean([rankings[r, measure, t.name].value for r in rooms for t in TRUTHS]))


def _answer(searches: Sequence[RoomSearch], rankings: Rankings) -> Answer:
    rooms = [found.room for found in searches]
    sentences, trusted = [], []
    for measure in MEASURES:
        by_truth = {
            truth.title: {room: rankings[room, measure.name, truth.name] for room in rooms}
            for truth in TRUTHS
        }
        if all(e.sign > 0 for by_room in by_truth.values() for e in by_room.values()):
            trusted.append(measure.title)
        clauses = [
            f"by {title} {verdicts(by_room, 1, words=_RANK_WORDS)}"
            for title, by_room in by_truth.items()
        ]
        sentences.append(f"{measure.title}: {'; '.join(clauses)}")
    best = max(MEASURES, key=lambda m: _mean_ranking(rankings, rooms, m.name))
    lead = (
        f"In every room and by both true scores only: {', '.join(trusted)}"
        if trusted
        else "None in every room by both true scores"
    )
    return Answer(
        4,
        f"{lead}. The highest mean over rooms and scores is {best.title}'s, "
        f"{_mean_ranking(rankings, rooms, best.name):+.2f}. {'. '.join(sentences)}. (Rank "
        f"correlation over {len(searches[0].sets)} parameter sets: 1 ranks as the truth "
        "does, -1 the other way round, 0 is chance.)",
    )
