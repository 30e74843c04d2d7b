import math

import numpy as np
import pytest
from support import THREE, make_log, random_log

import sonarmap as sm
from sonarmap.filters.stale import mark_stale

INF = math.inf


@pytest.mark.parametrize(
    ("range_m", "stale"),
    [
        # the first of a run stays fresh
        ([1.0, 1.0, 1.0], [0, 1, 1]),
        ([1.0, 1.1, 1.0], [0, 0, 0]),
        ([1.0, 1.0, 2.0, 2.0, 1.0], [0, 1, 0, 1, 0]),
        # exact repeats only
        ([1.0, math.nextafter(1.0, 2)], [0, 0]),
        # no echo and too close repeat like any other reading
        ([INF, INF, -INF, -INF, INF], [0, 1, 0, 1, 0]),
        # nothing to repeat
        ([1.0], [0]),
        ([], []),
    ],
)
def test_a_repeat_of_one_sonar_is_stale(range_m, stale):
    assert mark_stale(make_log(range_m)).stale.tolist() == [bool(mark) for mark in stale]


def test_each_sonar_is_compared_with_itself():
    # The last reading of sonar 0 is the first of sonar 1, too.
    log = make_log(
        [1.0, 1.0, 2.0, 1.0, 3.0, 2.0],
        ring=THREE,
        sonar=[0, 1, 2, 0, 1, 2],
        scan=[0, 0, 0, 1, 1, 1],
    )
    assert mark_stale(log).stale.tolist() == [False, False, False, True, False, True]


def test_a_long_log_is_marked_as_a_plain_loop_would(rng):
    log = random_log(rng, 1000)
    log = log.replace(range_m=np.round(log.range_m), stale=np.zeros(1000, bool))
    last, stale = {}, []
    for sonar, range_m in zip(log.sonar, log.range_m, strict=True):
        stale.append(last.get(sonar) == range_m)
        last[sonar] = range_m
    assert 200 < sum(stale) < 800
    assert mark_stale(log).stale.tolist() == stale


def test_marks_that_were_there_stay():
    log = make_log([1.0, 2.0, 2.0], stale=[True, False, False])
    assert mark_stale(log).stale.tolist() == [True, False, True]


def test_marking_twice_is_marking_once(rng):
    log = random_log(rng, 200)
    log = log.replace(range_m=np.round(log.range_m))
    once = mark_stale(log)
    assert once.stale.sum() > log.stale.sum()
    np.testing.assert_array_equal(mark_stale(once).stale, once.stale)


def test_all_else_stays(rng):
    log = random_log(rng, 30, truth=True)
    marked = mark_stale(log)
    for name in log.DTYPES:
        if name != "stale":
            np.testing.assert_array_equal(getattr(marked, name), getattr(log, name))
    assert marked.truth is log.truth


def test_a_repeated_log_maps_like_its_fresh_readings():
    model = sm.ParameterizedModel(p1=0.02, p2=0.15, p3_m=0.1, p4=0.98, p5_rad=0.26)
    grid = sm.GridSpec(0.1, (-1, -1), (20, 30))
    repeated = mark_stale(make_log([1.0, 1.0, 1.0, 1.2, 1.2]))
    fresh = make_log([1.0, 1.2])
    np.testing.assert_array_equal(
        sm.build_map(repeated, model, grid).log_odds, sm.build_map(fresh, model, grid).log_odds
    )
