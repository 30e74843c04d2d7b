"""Figures 5.9 to 5.12, tables 5.1 and 5.2, and question 4: goodness of maps without truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import stats

import sonarmap as sm
import worlds
from sonarbed.studies.goodness_figures import (
    draw_chosen,
    draw_histograms,
    draw_rankings,
    draw_scatter,
)
from sonarbed.studies.goodness_search import (
    BINS,
    CELL_M,
    MEASURES,
    RANGE_LIMIT_M,
    TRUTHS,
    Choice,
    Search,
    choices,
    first_bar,
    parameters,
    ranking,
    search,
    tendencies,
)
from sonarbed.studies.section import Answer, Item, Section
from sonarbed.studies.setting import Setting
from sonarbed.studies.statistics import Estimate, mean_of
from sonarbed.studies.two_models_figures import Example
from sonarbed.studies.wording import verdicts

__all__ = ["run"]

# Table 5.2: (P5, 2 P3, P2), each with the four values of P4.
_TABLE_5_2 = {
    (6, 0.5, 0.2),
    (6, 0.5, 0.15),
    (6, 0.5, 0.1),
    (6, 1.0, 0.2),
    (6, 1.0, 0.15),
    (6, 1.5, 0.2),
    (7, 0.5, 0.2),
}
# What the thesis's table 5.1 and figures 5.11 and 5.12 print: P1, P2, 2 P3, P4, P5.
_THESIS_CHOICES = {
    "VSDNS, mean of the first bar": ("0.03", "0.171", "0.786", "0.97", "6.14"),
    "VSDNS, lowest": ("0.02", "0.2", "0.5", "0.98", "6"),
    "VSDNS, nearest to the mean": ("0.02", "0.05", "2.0", "0.98", "14"),
    "derivative, lowest": ("0.05", "0.2", "0.5 (figure: 1.0)", "0.95", "40"),
    "two runs, positive less negative": ("0.02", "0.05", "3.0", "0.98", "35"),
}
_NAMES = ("P1", "P2", "2 P3, 0.1 m", "P4", "P5, degrees")
_RANK_WORDS = ("as the truth", "against the truth", "undecided")

Rankings = Mapping[tuple[str, str, str], Estimate]


def run(setting: Setting) -> Section:
    """Search the parameter sets in four rooms, and let the truth judge the measures."""
    searches = search(setting)
    chosen = {found.room: choices(found) for found in searches}
    rankings = {
        (found.room, measure.name, truth.name): ranking(found, measure, truth)
        for found in searches
        for measure in MEASURES
        for truth in TRUTHS
    }
    return Section(
        "goodness",
        "Goodness of maps without ground truth (section 5.3)",
        (
            _histogram(setting, searches),
            _optimal_sets(setting, searches, chosen),
            _first_bar(setting, searches),
            _other_measures(searches, chosen),
            _ranks(setting, searches, rankings),
        ),
        (_answer(searches, rankings),),
    )


def _histogram(setting: Setting, searches: Sequence[Search]) -> Item:
    bars = [first_bar(found.mean("vsdns")) for found in searches]
    header = ["bin", *(f"{f.room}, {what}" for f in searches for what in ("from", "sets"))]
    rows = [
        [i + 1, *(cell for bar in bars for cell in (f"{bar.edges[i]:.6f}", int(bar.counts[i])))]
        for i in range(BINS)
    ]
    rows.append(["end", *(cell for bar in bars for cell in (f"{bar.edges[-1]:.6f}", ""))])
    told = []
    for found, bar in zip(searches, bars, strict=True):
        vsdns = found.mean("vsdns")
        p = float(stats.normaltest(vsdns).pvalue) if vsdns.size >= 20 else float("nan")
        normal = "not normal" if p < 0.05 else "not told from normal"
        told.append(
            f"{found.room} {bar.edges[0]:.4f} to {bar.edges[-1]:.4f}, the first bar up to "
            f"{bar.edges[1]:.4f} with {bar.counts[0]} sets, skewness {stats.skew(vsdns):+.2f} "
            f"({normal}, p = {p:.2g})"
        )
    seeds = mean_of(searches[0].values["vsdns"].std(axis=1, ddof=1)) if _several(setting) else None
    chance = f" Between drives a set's VSDNS varies by {seeds.value:.4f} (SD)." if seeds else ""
    return Item(
        "Figure 5.9",
        "VSDNS of 1440 parameter sets in 14 bins: from 0.054 to about 0.12, 'represents a normal "
        "distribution', the first bar from 0.054079 to 0.059045 with 28 sets.",
        f"VSDNS of {len(searches[0].sets)} sets, mean over the drives: {'; '.join(told)}.{chance}",
        (
            setting.figure(
                "histograms",
                draw_histograms(searches),
                f"VSDNS of {len(searches[0].sets)} sets in {BINS} bins, range limit "
                f"{RANGE_LIMIT_M:g} m, cells of {CELL_M * 100:g} cm; the first bar in orange",
            ),
        ),
        (setting.table("histograms", header, rows, "The bins: where each begins, and its sets"),),
    )


def _several(setting: Setting) -> bool:
    return len(setting.seeds) > 1


def _optimal_sets(
    setting: Setting, searches: Sequence[Search], chosen: Mapping[str, Sequence[Choice]]
) -> Item:
    header = (
        "where",
        "best by",
        *_NAMES,
        "VSDNS",
        "true Map Score, bit",
        "sets that are better",
        "true F1 at 10 cm",
        "sets that are better by F1",
    )
    rows = [("thesis", rule, *values, *[""] * 5) for rule, values in _THESIS_CHOICES.items()]
    for room, of_room in chosen.items():
        rows.extend(
            (
                room,
                choice.rule,
                *_printed(choice.model),
                choice.mean("vsdns").text(4),
                choice.mean("map_score").text(),
                f"{choice.beaten_by['map_score']:.1%}",
                choice.mean("f1").text(),
                f"{choice.beaten_by['f1']:.1%}",
            )
            for choice in of_room
        )
    table = setting.table(
        "optimal-sets",
        header,
        rows,
        "The sets that each rule calls the best (table 5.1 and figures 5.10 to 5.12), and what "
        "they are worth; scores over observable cells, mean over the seeds",
    )
    told = []
    for before, what in ((0, "the first bar's mean"), (1, "the lowest VSDNS")):
        gains = {
            room: mean_of(of_room[2].values["map_score"] - of_room[before].values["map_score"])
            for room, of_room in chosen.items()
        }
        told.append(f"against {what} it is {verdicts(gains, 1)}")
    worth = [
        f"{room} {of_room[1].beaten_by['map_score']:.0%}, {of_room[0].beaten_by['map_score']:.0%} "
        f"and {of_room[2].beaten_by['map_score']:.0%}"
        for room, of_room in chosen.items()
    ]
    return Item(
        "Figure 5.10 and table 5.1",
        "Three optimal sets by VSDNS: the mean of the first bar (5.10 d), the lowest VSDNS (e), "
        "and the set at the mean VSDNS (f), 'remarkably better' than the other two.",
        f"The set at the mean VSDNS by true Map Score, bit: {'; '.join(told)}. Share of all sets "
        "with a better true Map Score than the lowest VSDNS, the first bar's mean and the mean "
        f"VSDNS: {'; '.join(worth)}.",
        tuple(_chosen_maps(setting, found, chosen[found.room]) for found in searches),
        (table,),
    )


def _printed(model: sm.ParameterizedModel) -> list[str]:
    return [f"{value:.3g}" for value in parameters(model)]


def _chosen_maps(setting: Setting, found: Search, chosen: Sequence[Choice]) -> tuple[str, str]:
    truth = worlds.truth(worlds.load(found.room), resolution_m=CELL_M)
    run_ = found.runs[0]
    examples = []
    for letter, choice in zip(("d", "e", "f", "5.11", "5.12", "", ""), chosen, strict=True):
        built = sm.build_map(run_.log, choice.model, truth.grid, max_range_m=RANGE_LIMIT_M)
        score = sm.score_map(built, truth, observable=run_.observable)
        lead = f"{letter}: " if letter else ""
        title = (
            f"{lead}{choice.rule}\n{', '.join(_printed(choice.model))}\n"
            f"{score.map_score:.2f} bit, F1 = {score.f1(1):.2f}"
        )
        examples.append(Example(title, built))
    return setting.figure(
        f"chosen-{found.room}",
        draw_chosen(truth, run_.observable, examples),
        f"{found.room}, seed {setting.seeds[0]}: the truth (light: not observable) and the maps of "
        "the sets that each rule calls the best; below the rule P1, P2, 2 P3, P4, P5 and the true "
        "scores of this map",
    )


def _first_bar(setting: Setting, searches: Sequence[Search]) -> Item:
    found = searches[0]
    vsdns, score = found.mean("vsdns"), found.mean("map_score")
    members = first_bar(vsdns).members
    rows, shared = [], 0
    for index in members:
        _, p2, twice_p3, p4, p5 = parameters(found.sets[index])
        in_thesis = (round(p5), round(twice_p3, 2), round(p2, 2)) in _TABLE_5_2
        shared += in_thesis
        rows.append(
            (
                f"{p5:.0f}",
                f"{p4:.2f}",
                f"{twice_p3:.1f}",
                f"{p2:.2f}",
                f"{vsdns[index]:.6f}",
                f"{score[index]:.3f}",
                f"{(score > score[index]).mean():.1%}",
                "yes" if in_thesis else "no",
            )
        )
    table = setting.table(
        "first-bar",
        (
            "P5",
            "P4",
            "2 P3, 0.1 m",
            "P2",
            "VSDNS",
            "true Map Score, bit",
            "sets that are better",
            "in table 5.2",
        ),
        rows,
        f"The sets of the first bar in {found.room}, mean over the seeds",
    )
    leaning = {f.room: tendencies(f) for f in searches}
    names = ("P2", "P3", "P4", "P5")
    tendency = setting.table(
        "tendencies",
        ("room", "parameter", "with VSDNS", *(f"with {truth.title}" for truth in TRUTHS)),
        [
            (room, name, *(by_column[name][c].text(2) for c in ("vsdns", "map_score", "f1")))
            for room, by_column in leaning.items()
            for name in names
        ],
        "Rank correlation over the sets of each parameter with VSDNS and with the true scores",
    )
    vsdns_told = ", ".join(f"{n} {leaning[found.room][n]['vsdns'].text(2)}" for n in names)
    true_told = ", ".join(f"{n} {leaning[found.room][n]['map_score'].text(2)}" for n in names)
    possible = sum(
        (round(p5), round(twice_p3, 2), round(p2, 2)) in _TABLE_5_2
        for _, p2, twice_p3, _, p5 in map(parameters, found.sets)
    )
    return Item(
        "Table 5.2",
        "The 28 sets of the first bar: lower P3 and P5 and higher P2 give less VSDNS, P1 and P4 "
        "show no pattern.",
        f"In {found.room} the first bar has {len(members)} sets, {shared} of them among the "
        f"{possible} of table 5.2 that were searched. Rank correlation with VSDNS: {vsdns_told}. "
        f"With the true Map Score: {true_told}.",
        tables=(table, tendency),
    )


def _other_measures(searches: Sequence[Search], chosen: Mapping[str, Sequence[Choice]]) -> Item:
    told = []
    for index, figure in ((3, "Figure 5.11, the lowest derivative"), (4, "figure 5.12, two runs")):
        worth = [
            f"{room} {', '.join(_printed(of_room[index].model))}: "
            f"{of_room[index].mean('map_score').text(2, 'bit')}, "
            f"{of_room[index].beaten_by['map_score']:.0%} of the sets are better, "
            f"{of_room[index].beaten_by['f1']:.0%} by F1"
            for room, of_room in chosen.items()
        ]
        told.append(f"{figure} (P1, P2, 2 P3, P4, P5): {'; '.join(worth)}")
    best = [
        f"{room} {of_room[5].mean('map_score').text(2, 'bit')}" for room, of_room in chosen.items()
    ]
    return Item(
        "Figures 5.11 and 5.12",
        "The derivative calls 0.05, 0.2, 0.5, 0.95, 40 optimal, 'worse than most of the maps of "
        "figure 5.10'; two runs call 0.02, 0.05, 3, 0.98, 35 optimal, 'better than several sets "
        "but not the best one'.",
        f"{'. '.join(told)}. The best by truth: {'; '.join(best)}. The two runs have the same "
        "start and the same orders, but their odometry errs differently, as a robot's does: the "
        "measure includes that. The maps are in the figures above.",
    )


def _ranks(setting: Setting, searches: Sequence[Search], rankings: Rankings) -> Item:
    rooms = [found.room for found in searches]
    table = setting.table(
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
    told = [f"{m.title} {_mean_ranking(rankings, rooms, m.name):+.2f}" for m in MEASURES]
    return Item(
        "Section 5.4: which measure can be trusted",
        "No measure gave satisfactory results; VSDNS is said to do better than the other two. "
        "There was no truth to compare with.",
        f"Mean rank correlation with the truth over {len(rooms)} rooms and both true scores: "
        f"{', '.join(told)}. The highest is that of {best.title}.",
        (
            setting.figure(
                "rankings",
                draw_rankings(rooms, rankings),
                "Rank correlation of each measure with the true scores over the parameter sets, "
                "with 95 % intervals over the seeds",
            ),
            setting.figure(
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


def _answer(searches: Sequence[Search], rankings: Rankings) -> Answer:
    rooms = [found.room for found in searches]
    told, trusted = [], []
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
        told.append(f"{measure.title}: {'; '.join(clauses)}")
    best = max(MEASURES, key=lambda m: _mean_ranking(rankings, rooms, m.name))
    lead = (
        f"In every room and by both true scores only: {', '.join(trusted)}"
        if trusted
        else "None in every room by both true scores"
    )
    return Answer(
        4,
        f"{lead}. Nearest to the truth on average is {best.title} (mean rank correlation "
        f"{_mean_ranking(rankings, rooms, best.name):+.2f}). {'. '.join(told)}. (Rank correlation "
        f"over {len(searches[0].sets)} parameter sets, 1 = ranks as the truth.)",
    )
