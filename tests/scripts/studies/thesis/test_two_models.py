"""The two models compared: arithmetic on invented maps, and one small run."""

import math

import numpy as np
import pytest
from rooms import closed_room

import sonarbed.studies.thesis.two_models.study as study
import sonarmap as sm
import worlds
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.two_models import run
from sonarbed.studies.thesis.two_models.comparison import (
    PAIRS,
    SCORES,
    ScoredMap,
    differences,
    mean,
)


def test_pairs_have_the_same_parameters():
    for pair in PAIRS:
        assert pair.standard.tolerance_m == pair.parameterized.p3_m == pair.tolerance_m
        assert pair.standard.beta_rad == pair.parameterized.p5_rad == math.radians(15)
        assert pair.standard.max_occupied == pair.parameterized.p4 == 0.98
    assert [pair.tolerance_m for pair in PAIRS] == [0.1, 0.025]
    assert PAIRS[0].parameterized == sm.ParameterizedModel.thesis()


def map_of(truth, p):
    return sm.OccupancyMap(truth.grid, np.log(p / (1 - p)))


def test_parts_of_the_map_score_add_up_and_tell_where_it_is_lost():
    truth = worlds.truth(closed_room(), resolution_m=0.05)
    seen = truth.state != worlds.HIDDEN
    wall = truth.state == worlds.OCCUPIED
    x_m, y_m = truth.grid.centre_of(*np.indices(truth.grid.shape))
    to_wall_m = 1.5 - np.maximum(np.abs(x_m), np.abs(y_m))
    # All right but for a phantom ring of free cells that are near to the walls.
    ring = ~wall & (to_wall_m < 0.1)
    right = ScoredMap.of(map_of(truth, np.where(wall, 0.75, 0.25)), truth, seen)
    ringed = ScoredMap.of(map_of(truth, np.where(wall | ring, 0.75, 0.25)), truth, seen)

    for found in (right, ringed):
        parts = found.bits_wall + found.bits_near + found.bits_open
        assert parts == pytest.approx(found.map_score)
    bit = 1 + math.log2(0.75)
    assert right.map_score == pytest.approx(bit)
    assert (right.phantom_m2, ringed.false_free_m2) == (0, 0)
    assert ringed.phantom_m2 == pytest.approx((ring & seen).sum() * 0.05**2)
    assert ringed.bits_wall == pytest.approx(right.bits_wall)
    assert ringed.bits_open == pytest.approx(right.bits_open)
    # A cell that was right by 1 + log2(0.75) is wrong by 1 + log2(0.25) = -1.
    lost = (ring & seen).sum() * (-1 - bit) / seen.sum()
    assert ringed.bits_near - right.bits_near == pytest.approx(lost)


def scored(**scores):
    return ScoredMap(**{**dict.fromkeys(ScoredMap.__slots__, 0.0), **scores})


def test_differences_are_paired_by_seed():
    # Seeds differ widely, the two models always by 0.25.
    drives = [[(scored(f1=level), scored(f1=level + 0.25))] for level in (0, 8, 64)]
    difference = differences(drives, 0, "f1")
    assert (difference.low, difference.value, difference.high) == (0.25, 0.25, 0.25)
    assert mean(drives, 0, 0, "f1").value == 24
    assert mean(drives, 0, 1, "f1").value == 24.25


def test_brier_is_better_when_it_is_lower():
    assert {score.name: score.better for score in SCORES} == {
        "skill": 1,
        "map_score": 1,
        "brier": -1,
        "correlation": 1,
        "f1": 1,
    }


class TinyContext(StudyContext):
    seeds = range(2)
    scans = 12


@pytest.mark.engine
def test_study_runs_small(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "_rooms_compared", lambda: ("thesis-exp1", "opening-rig"))
    section = run(TinyContext(tmp_path, quick=True, jobs=1, study="two_models"))

    assert [answer.question for answer in section.answers] == [5]
    assert "of 2 (" in section.answers[0].text
    for item in section.items:
        for file, _ in (*item.figures, *item.tables):
            assert (tmp_path / "two_models" / file).stat().st_size > 0
    table = (tmp_path / "two_models" / "rooms-100-mm.csv").read_text().splitlines()
    assert len(table) == 1 + 2 * (len(SCORES) + 1)
    assert sum(line.count("blank sheet") for line in table) == 2
    assert "(skill above 0)" in section.answers[0].text
