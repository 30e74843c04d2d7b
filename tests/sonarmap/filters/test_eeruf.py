import math

import pytest
from support import THREE, make_log

import sonarmap as sm


def test_readings_that_agree_with_a_neighbour_in_time_are_accepted():
    log = make_log([1.0, 1.04, 2.0, 1.0, 1.1, math.inf, math.inf, 1.0])
    accepted = sm.eeruf_accepts(log, tolerance_m=0.05)
    assert accepted.tolist() == [True, True, False, False, False, True, True, False]


def test_sonars_are_compared_with_themselves_only():
    log = make_log([1.0, 1.0, 2.0, 1.01], ring=THREE, sonar=[0, 1, 0, 1], scan=[0, 0, 1, 1])
    assert sm.eeruf_accepts(log).tolist() == [False, True, False, True]


def test_a_repeat_is_no_second_witness():
    log = make_log([1.0, 1.0, 2.0, 2.0, 2.01], stale=[False, True, False, True, False])
    assert sm.eeruf_accepts(log).tolist() == [False, False, True, True, True]


def test_a_negative_tolerance_is_refused():
    with pytest.raises(sm.InputError, match=r"tolerance_m must be >= 0, got -1"):
        sm.eeruf_accepts(make_log([1.0]), tolerance_m=-1)
