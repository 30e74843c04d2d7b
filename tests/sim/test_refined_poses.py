"""Poses refined in simulated rooms: better than odometry by truth, which is never looked at."""

import dataclasses

import numpy as np
import pytest

import sonarmap as sm
import worlds
from sim import simulate

pytestmark = pytest.mark.engine


@pytest.fixture(scope="module")
def drives():
    return [
        simulate(worlds.load(room), scans=300, seed=0, sonar="physical", engine="segments")
        for room in ("office", "clutter", "thesis-exp2")
    ]


def errors(log):
    return np.array(sm.pose_error(log, log.at_true_poses()))


def test_errors_fall_in_shipped_rooms(drives):
    shares = [errors(sm.refine_poses(log)) / errors(log) for log in drives]
    assert (np.median(shares, axis=0) < 0.7).all()


def test_the_truth_is_not_looked_at(drives):
    log = drives[2]
    false = dataclasses.replace(
        log.truth, x_m=log.truth.x_m + 1.0, heading_rad=-log.truth.heading_rad
    )
    assert np.array_equal(sm.refine_poses(log).x_m, sm.refine_poses(log.replace(truth=false)).x_m)
    assert np.array_equal(sm.refine_poses(log).x_m, sm.refine_poses(log.replace(truth=None)).x_m)
