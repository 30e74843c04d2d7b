"""Goodness of maps: the thesis's derivations on invented numbers, and one small run."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support import make_log, random_truth

import sonarmap as sm
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.goodness import run
from sonarbed.studies.thesis.goodness import search as study
from sonarbed.studies.thesis.goodness.best_sets import TABLE_5_2
from sonarbed.studies.thesis.goodness.choices import (
    first_bar,
    mean_set,
    parameters,
    ranking,
    tendencies,
)
from sonarbed.studies.thesis.goodness.search import MEASURES, TRUTHS, RoomSearch, sets_of

MEASURE = {measure.name: measure for measure in MEASURES}
MAP_SCORE, F1 = TRUTHS


def a_set(p2=0.1, twice_p3=1.0, p4=0.97, p5_deg=10):
    return sm.ParameterizedModel(1 - p4, p2, twice_p3 / 20, p4, math.radians(p5_deg))


def found(**columns):
    """Return a search of as many sets as rows, one column a seed."""
    values = {name: np.array(column, float) for name, column in columns.items()}
    count = len(next(iter(values.values())))
    return RoomSearch("hall", tuple(a_set(p5_deg=6 + i) for i in range(count)), values)


def test_measures_of_the_thesis_point_the_right_way():
    assert {name: measure.good for name, measure in MEASURE.items()} == {
        "vsdns": -1,
        "derivative": -1,
        "agreement": 1,
        "surplus": 1,
    }


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("vsdns", [3, 2, 1], 1),  # the lowest is the best: as the truth
        ("vsdns", [1, 2, 3], -1),
        ("derivative", [3, 2, 1], 1),
        ("agreement", [0.1, 0.2, 0.3], 1),  # the highest is the best
        ("surplus", [30, 20, 10], -1),
    ],
)
def test_ranking_is_one_when_a_measure_ranks_as_the_truth(name, values, expected):
    both_seeds = np.transpose([values, values])
    search = found(**{name: both_seeds}, map_score=np.transpose([[1, 2, 3]] * 2))
    assert ranking(search, MEASURE[name], MAP_SCORE).value == pytest.approx(expected)


def test_ranking_of_two_runs_is_less_sure_than_its_seeds_say():
    # Rank correlations 1, 0.5, 0.5 of three seeds.
    columns = np.transpose([[1, 2, 3], [2, 1, 3], [1, 3, 2]])
    truth = np.transpose([[1, 2, 3]] * 3)
    one = ranking(found(vsdns=-columns, f1=truth), MEASURE["vsdns"], F1)
    two = ranking(found(agreement=columns, f1=truth), MEASURE["agreement"], F1)
    assert one.value == two.value == pytest.approx(2 / 3)
    assert two.value - two.low == pytest.approx(math.sqrt(2) * (one.value - one.low))
    assert two.high == 1  # no correlation lies beyond


def test_first_bar_of_an_invented_histogram():
    # Fourteen bins of width 1 from 0 to 14: the first has 0, 0.9 and 0.5, in that order of value.
    vsdns = np.array([0.9, 14.0, 1.0, 0.0, 7.5, 0.5])
    bar = first_bar(vsdns)
    assert bar.edges.tolist() == list(range(15))
    assert bar.counts.tolist() == [3, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1]
    assert bar.members.tolist() == [3, 5, 0]


def test_mean_of_table_5_2_is_column_4_of_table_5_1():
    sets = [a_set(p2, p3, p4, p5) for p5, p3, p2 in TABLE_5_2 for p4 in (0.95, 0.96, 0.97, 0.98)]
    assert len(sets) == 28
    p1, p2, twice_p3, p4, p5 = parameters(mean_set(sets))
    assert (p2, twice_p3, p5) == pytest.approx((0.171, 0.786, 6.14), abs=5e-3)
    assert p4 == pytest.approx(0.965)
    assert p1 == pytest.approx(1 - p4)


def test_parameters_are_printed_in_the_units_of_the_thesis():
    assert parameters(a_set(0.2, 2.5, 0.98, 14)) == pytest.approx((0.02, 0.2, 2.5, 0.98, 14))


def test_tendencies_follow_the_parameter():
    leaning = tendencies(found(vsdns=np.transpose([[1, 2, 3], [1, 2, 3]])))
    assert leaning["P5"]["vsdns"].value == pytest.approx(1)
    assert leaning["P2"]["vsdns"].value == 0  # P2 is the same in all


def test_cells_beyond_the_reach_of_every_set_are_not_scored():
    log = make_log([1.0], truth=random_truth(np.random.default_rng(1), 1))
    log = log.replace(truth=replace(log.truth, x_m=[0.5], y_m=[0.5], heading_rad=[0.0]))
    grid = sm.GridSpec(1.0, (0.0, 0.0), (4, 4))
    # Centres of cells, 1 m apart: 2 m ahead or beside are reached, 2 m and 1 m across are not.
    assert draw_mask(study.within_reach(log, grid, 2.0)) == "....\n#...\n##..\n###.\n"


def draw_mask(mask):
    return "".join("".join(np.where(row, "#", ".")) + "\n" for row in mask[::-1])


def test_quick_sets_span_what_all_sets_span():
    everything, few = sets_of(quick=False), sets_of(quick=True)
    assert len(everything) == 1440
    assert set(few) < set(everything)
    ends = [
        (np.min(table, axis=0), np.max(table, axis=0))
        for table in ([parameters(m) for m in sets] for sets in (everything, few))
    ]
    assert np.allclose(ends[0], ends[1])


class TinyContext(StudyContext):
    seeds = range(2)
    scans = 25


@pytest.mark.engine
def test_study_runs_small(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "ROOMS", ("thesis-exp1", "l-shape"))
    some = study.sets_of(quick=False)[::101]
    monkeypatch.setattr(study, "sets_of", lambda *, quick: some)
    section = run(TinyContext(tmp_path, quick=True, jobs=1, study="goodness"))

    assert [item.number for item in section.items] == [
        "Figure 5.9",
        "Figure 5.10 and table 5.1",
        "Table 5.2",
        "Figures 5.11 and 5.12",
        "Section 5.4: which measure can be trusted",
    ]
    assert [answer.question for answer in section.answers] == [4]
    for item in section.items:
        assert not {"nan", "inf"} & set(item.finding.replace("(", " ").replace(",", " ").split())
        for file, _ in (*item.figures, *item.tables):
            assert (tmp_path / "goodness" / file).stat().st_size > 0
    histogram = (tmp_path / "goodness" / "histograms.csv").read_text().splitlines()
    assert len(histogram) == 1 + 14 + 1
    assert sum(int(line.split(",")[2]) for line in histogram[1:15]) == len(some)
