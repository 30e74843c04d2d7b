import math
from dataclasses import replace

import numpy as np
import pytest
from rooms import box, world
from support import ONE, make_log

import sonarmap as sm
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis import readings
from sonarbed.studies.thesis.readings.mending import Counts, share_over_drives
from sonarbed.studies.thesis.readings.places import Place, places_of


def truth_of(x_m, y_m, heading_rad, cause=sm.Cause.DIRECT):
    n = len(x_m)
    return sm.LogTruth(
        x_m=x_m,
        y_m=y_m,
        heading_rad=heading_rad,
        axis_range_m=np.ones(n),
        cone_range_m=np.ones(n),
        cause=np.broadcast_to(np.asarray(cause), n),
        surface=np.full(n, ""),
        incidence_rad=np.zeros(n),
        bounces=np.zeros(n),
        collision=np.zeros(n, bool),
    )


def place(x_m, y_m, heading_deg):
    """The place of one reading of a sonar with a range of 8 m in a room of 6 m by 4 m.

    The north wall, y = 4, has an opening from x = 2.5 to 3.5; behind it all is free.
    """
    room = world(
        box("south", -0.1, -0.1, 6.1, 0.0),
        box("west", -0.1, 0.0, 0.0, 4.1),
        box("east", 6.0, 0.0, 6.1, 4.1),
        box("north, left", 0.0, 4.0, 2.5, 4.1),
        box("north, right", 3.5, 4.0, 6.0, 4.1),
        start=(1.0, 1.0, 0.0),
    )
    room = replace(room, bounds_m=(-0.1, -0.1, 6.1, 9.0))
    pose = ([x_m], [y_m], [math.radians(heading_deg)])
    log = make_log([1.0], ring=ONE, truth=truth_of(*pose))
    return Place(places_of(log, room)[0])


def test_a_wall_met_squarely_is_plain():
    assert place(5.0, 2.0, 0) == Place.PLAIN


def test_a_wall_met_at_thirty_five_degrees_is_oblique():
    # The axis meets the south wall at x = 3 + 1 * tan 35 degrees, far from every corner.
    assert place(3.0, 1.0, -90 + 35) == Place.OBLIQUE


def test_twenty_five_degrees_are_still_plain():
    assert place(3.0, 1.0, -90 + 25) == Place.PLAIN


def test_the_axis_into_a_corner_is_a_corner():
    assert place(5.0, 1.0, -45) == Place.CORNER


def test_near_a_corner_is_within_three_tenths_of_a_metre():
    # The axis meets the east wall 0.29 m and 0.8 m above its lower corner; half a metre away
    # the cone's nearest point is the foot on the axis.
    assert place(5.5, 0.29, 0) == Place.CORNER
    assert place(5.5, 0.8, 0) == Place.PLAIN


def test_the_axis_through_an_opening_is_an_opening():
    assert place(3.0, 2.0, 90) == Place.OPENING


def test_an_axis_that_meets_the_wall_beside_an_opening_is_none():
    # The axis meets the wall at x = 2.2, 0.3 m from the jamb (a corner), the cone sees the gap.
    assert place(2.21, 3.0, 90) == Place.CORNER
    assert place(1.9, 3.0, 90) == Place.PLAIN


def test_a_surface_far_behind_an_edge_is_an_opening():
    # A post of 0.2 m stands in the cone 1 m before the sonar, 0.13 m off the axis; the axis meets
    # a wall at 3 m.
    room = world(
        box("wall", 3.0, -5.0, 3.1, 5.0),
        box("post", 1.0, 0.1, 1.2, 0.3),
        start=(-1.0, 0.0, 0.0),
    )
    log = make_log([1.0], ring=ONE, truth=truth_of([0.0], [0.0], [0.0]))
    assert places_of(log, room).tolist() == [Place.OPENING]


def test_a_share_over_drives_is_the_mean_of_their_shares():
    counts = [Counts(10, 5, 4, 1), Counts(20, 5, 0, 0)]
    assert share_over_drives(counts, "mended", "wrong").value == (0.5 + 0.25) / 2
    # A drive without right readings has no share.
    assert share_over_drives(counts, "spoiled", "right").value == 0.25


@pytest.mark.engine
def test_the_study_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(StudyContext, "seeds", range(2))
    monkeypatch.setattr(StudyContext, "scans", 40)
    context = StudyContext(tmp_path, quick=True, jobs=1).on_study("readings")
    section = readings.run(context)
    assert len(section.items) == 3
    assert [answer.question for answer in section.answers] == [2] * 4
    for item in section.items:
        for file, _ in (*item.figures, *item.tables):
            assert (context.study_folder / file).stat().st_size > 0
