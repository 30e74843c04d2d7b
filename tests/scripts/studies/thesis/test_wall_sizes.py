import csv

import numpy as np
import pytest
from support import cells

import sonarmap as sm
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.experiments import EXPERIMENTS, Opening
from sonarbed.studies.thesis.wall_sizes import study
from sonarbed.studies.thesis.wall_sizes.findings import border, runs_of
from sonarbed.studies.thesis.wall_sizes.pairs import in_table_6_1, pair_name, wall_pairs
from sonarbed.studies.thesis.wall_sizes.sweep import Sweep, opening_shares

# Free, occupied and unknown cells of a map.
P = {".": 0.1, "#": 0.9, "?": 0.5}


def test_the_sweep_is_the_thesiss_in_steps_of_ten_millimetres():
    pairs = wall_pairs(quick=False)
    # 24 sizes from 20 to 250 mm for 10 and 20 mm, one less for each further 10 mm.
    assert len(pairs) == 24 + 24 + 23 + 22 + 21 + 20 + 19
    assert all(low <= high for low, high in pairs)


@pytest.mark.parametrize("quick", [True, False])
def test_every_pair_that_the_thesis_shows_is_in_the_sweep(quick):
    pairs = wall_pairs(quick=quick)
    for experiment in EXPERIMENTS:
        assert {experiment.thesis, *experiment.shown} <= set(pairs)


def test_table_6_1_holds_its_borders():
    inside = in_table_6_1(((10, 150), (10, 160), (10, 200), (10, 210), (70, 80), (70, 90)))
    assert inside.tolist() == [False, True, True, False, True, False]
    # Ranges of 160-200, 110-190, 50-110, 50-100, 60-90, 70-80 and 80 mm in steps of 10 mm.
    assert in_table_6_1(wall_pairs(quick=False)).sum() == 5 + 9 + 7 + 6 + 4 + 2 + 1


def test_a_pair_is_named_as_in_the_thesis():
    assert pair_name((20, 120)) == "20-120 mm"


def test_an_opening_is_counted_within_its_strip():
    grid = sm.GridSpec(0.1, (0.0, 0.0), (4, 8))
    drawing = cells("""
        ########
        ##....##
        ##.#..?#
        ########
    """)
    p = np.vectorize(P.get)(drawing)
    # Columns 2 to 6, rows 1 and 2: seven free, two occupied, one unknown.
    opening = Opening("door", (0.2, 0.1, 0.7, 0.3), runs_along_x=True)
    free, occupied, gap_m = opening_shares(p, grid, opening)
    assert (free, occupied) == (0.7, 0.2)
    # Columns 3 and 6 are blocked: columns 4 and 5 are the widest gap.
    assert gap_m == pytest.approx(0.2)


def test_an_opening_along_y_is_the_same_turned():
    p = np.full((8, 4), P["."])
    p[5, 1] = P["#"]
    opening = Opening("door", (0.1, 0.2, 0.3, 0.8), runs_along_x=False)
    free, occupied, gap_m = opening_shares(p, sm.GridSpec(0.1, (0.0, 0.0), (8, 4)), opening)
    assert (free, occupied, gap_m) == (pytest.approx(11 / 12), pytest.approx(1 / 12), 0.1 * 3)


def test_a_closed_opening_has_no_gap():
    p = np.full((2, 4), P["#"])
    opening = Opening("door", (0.0, 0.0, 0.4, 0.2), runs_along_x=True)
    assert opening_shares(p, sm.GridSpec(0.1, (0.0, 0.0), (2, 4)), opening) == (0.0, 1.0, 0.0)


def test_changes_are_means_over_drives_and_the_best_pair_has_the_highest():
    sweep = Sweep(
        ((10, 20), (10, 30), (20, 30)),
        {"score": np.array([0.0, 0.1])},
        {"score": np.array([[0.3, 0.1, 0.29], [0.4, 0.2, 0.41]])},
    )
    assert [change.value for change in sweep.changes("score")] == pytest.approx([0.3, 0.1, 0.3])
    assert sweep.best("score") in (0, 2)
    # 0.2 less in both drives is decided, 0.01 less and 0.01 more is not.
    assert sweep.as_good_as_best("score").tolist() == [True, False, True]


def test_runs_of_helpful_walls_end_where_a_pair_does_not_help():
    pairs = ((10, 20), (10, 30), (10, 40), (10, 50), (20, 20))
    after = np.array([[0.2, 0.3, -0.1, 0.2, -0.1], [0.3, 0.4, -0.2, 0.3, -0.2]])
    sweep = Sweep(pairs, {"score": np.zeros(4)}, {"score": np.array([*after, *after])})
    assert runs_of(sweep, "score", 10) == [(20, 30), (50, 50)]
    assert runs_of(sweep, "score", 20) == []
    # The border is the end of the run that begins with the least max wall.
    assert "10: 30 (thesis 200), 20: none (thesis 190)." in border(sweep, "score")


@pytest.mark.engine
def test_the_study_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(StudyContext, "seeds", range(2))
    monkeypatch.setattr(StudyContext, "scans", 40)
    pairs = ((10, 20), (10, 30), (10, 80), (20, 80), (20, 120), (20, 200), (30, 140))
    monkeypatch.setattr(study, "wall_pairs", lambda *, quick: pairs)
    context = StudyContext(tmp_path, quick=True, jobs=1).on_study("wall_sizes")
    section = study.run(context)
    assert [item.number[:11] for item in section.items] == [
        "Figure 6.15",
        "Table 6.1",
        "Figure 6.16",
        "Figure 6.16",
    ]
    assert [answer.question for answer in section.answers] == [1, 1, 3]
    for item in section.items:
        for file, _ in (*item.figures, *item.tables):
            assert (context.study_folder / file).stat().st_size > 0
    with (context.study_folder / "experiment-1-pairs.csv").open(newline="") as stream:
        assert len(list(csv.reader(stream))) == 1 + len(pairs)
