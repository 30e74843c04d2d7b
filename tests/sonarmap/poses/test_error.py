"""How far poses are from others."""

import math

import numpy as np
import pytest

import sonarmap as sm


def test_errors_are_root_mean_squares(drive):
    _, log = drive
    moved = log.replace(x_m=log.x_m + 0.03, y_m=log.y_m - 0.04, heading_rad=log.heading_rad + 0.1)
    assert sm.pose_error(moved, log) == pytest.approx((0.05, 0.1))
    half = np.where(np.arange(len(log)) % 2 == 0, 0.2, 0.0)
    assert sm.pose_error(log.replace(x_m=log.x_m + half), log).place_m == pytest.approx(
        math.sqrt(0.02), rel=0.01
    )
    assert sm.pose_error(log, log) == (0, 0)


@pytest.mark.parametrize("turns", [-2, 1, 3])
def test_whole_turns_are_no_error(drive, turns):
    _, log = drive
    turned = log.replace(heading_rad=log.heading_rad + turns * math.tau)
    assert sm.pose_error(turned, log).heading_rad == pytest.approx(0, abs=1e-9)


def test_no_reading_no_error_and_other_readings_are_refused(drive):
    _, log = drive
    none = log.select(np.zeros(len(log), bool))
    assert sm.pose_error(none, none) == (0, 0)
    with pytest.raises(sm.InputError, match="reference must have the log's"):
        sm.pose_error(log, none)
