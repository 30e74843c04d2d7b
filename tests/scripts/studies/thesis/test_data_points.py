import numpy as np
import pytest
from rooms import box, world
from support import ONE, make_log, random_truth

import sonarmap as sm
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis import data_points
from sonarbed.studies.thesis.data_points.study import shares_near
from sonarbed.studies.thesis.free_space import FreeSpace
from sonarmap.filters.hsr import EstimatedWalls, Mark


def test_shares_count_points_by_cause_and_the_cells_of_walls(rng):
    # A wall along y at x = 2; the sonar looks along x from the origin.
    room = world(box("wall", 2.0, -5.0, 2.1, 5.0), start=(0.0, 0.0, 0.0))
    direct, off_axis, dropout = sm.Cause.DIRECT, sm.Cause.OFF_AXIS, sm.Cause.DROPOUT
    causes = np.array([direct, direct, off_axis, dropout, direct], np.int8)
    truth = random_truth(rng, 5)
    truth = sm.LogTruth(
        **{name: getattr(truth, name) for name in truth.DTYPES if name != "cause"}, cause=causes
    )
    # Near, near, 0.5 m short, no echo; the last is too close and makes no point.
    log = make_log([2.0, 1.95, 1.5, np.inf, -np.inf], ring=ONE, truth=truth)
    marks = np.zeros((1, 30), np.uint8)
    # Cells of 0.1 m: centres at x = 1.95 (near), 1.55 and 1.65 (not); a reading is no wall.
    marks[0, [19, 15, 16]] = Mark.WALL
    marks[0, 20] = Mark.READING
    es = EstimatedWalls(sm.GridSpec(0.1, (0.0, 0.0), marks.shape), marks)

    shares = shares_near(log, FreeSpace.of(room), es)

    # The edge of the plane, which the point of no echo meets, is no surface.
    assert shares.points == 2 / 4
    assert shares.echoes == pytest.approx(2 / 3)
    assert shares.by_cause[direct] == 1.0
    assert shares.by_cause[off_axis] == 0.0
    assert shares.walls == pytest.approx(1 / 3)


@pytest.mark.engine
def test_the_study_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(StudyContext, "seeds", range(2))
    monkeypatch.setattr(StudyContext, "scans", 40)
    context = StudyContext(tmp_path, quick=True, jobs=1).on_study("data_points")
    section = data_points.run(context)
    assert [item.number for item in section.items] == ["Figure 6.2", "Figure 6.4", "Figure 6.6"]
    for item in section.items:
        for file, _ in (*item.figures, *item.tables):
            assert (context.study_folder / file).stat().st_size > 0
