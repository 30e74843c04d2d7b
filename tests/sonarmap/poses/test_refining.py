"""Poses refined: a drift is found back, and what echoes do not tell stays."""

import math

import numpy as np
import pytest
from drives import by_odometry, log_of, pose_errors, way

import sonarmap as sm


@pytest.fixture(scope="module")
def refined(drive):
    return sm.refine_poses(drive[1])


def test_errors_fall_by_half_in_a_room_of_four_walls():
    # What the heading lost before the first way was driven no echo tells: not in every drive.
    shares = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        true = way(2)
        log = log_of(true, by_odometry(true, rng, scale=1.003, turn=0.997, slip=0.005), rng)
        shares.append(np.divide(pose_errors(sm.refine_poses(log), true), pose_errors(log, true)))
    assert (np.median(shares, axis=0) < 0.5).all()


def test_true_poses_stay_where_they_are(rng):
    true = way(1)
    log = log_of(true, true, rng)
    assert pose_errors(sm.refine_poses(log), true) < (0.01, math.radians(0.3))


def test_only_poses_change_and_the_log_stays_as_it_was(drive, refined):
    _, log = drive
    before = {name: getattr(log, name).tobytes() for name in sm.SonarLog.DTYPES}
    sm.refine_poses(log)
    assert {name: getattr(log, name).tobytes() for name in sm.SonarLog.DTYPES} == before
    changed = {n for n in before if getattr(refined, n).tobytes() != before[n]}
    assert changed == {"x_m", "y_m", "heading_rad"}
    assert (refined.x_m[0], refined.heading_rad[0]) == (log.x_m[0], log.heading_rad[0])


def test_a_moved_and_turned_log_is_refined_alike(drive, refined):
    _, log = drive
    turn, dx, dy = 0.7, 3.0, -5.0
    cos, sin = math.cos(turn), math.sin(turn)

    def moved(poses):
        return poses.replace(
            x_m=cos * poses.x_m - sin * poses.y_m + dx,
            y_m=sin * poses.x_m + cos * poses.y_m + dy,
            heading_rad=poses.heading_rad + turn,
        )

    other, wanted = sm.refine_poses(moved(log)), moved(refined)
    # Walls are looked for every 3 degrees, so the ways there differ a little.
    assert np.hypot(other.x_m - wanted.x_m, other.y_m - wanted.y_m).max() < 0.02
    assert np.abs(other.heading_rad - wanted.heading_rad).max() < math.radians(0.5)


@pytest.mark.parametrize("unused", ["stale", "rejected"])
def test_readings_that_may_not_be_used_are_not(drive, refined, unused, rng):
    _, log = drive
    spoiled = rng.random(len(log)) < 0.3
    ranges = np.where(spoiled, rng.uniform(0.2, 3.0, len(log)), log.range_m)
    marked = log.replace(range_m=ranges, **{unused: spoiled})
    without = log.replace(range_m=np.where(spoiled, np.inf, log.range_m))
    assert np.array_equal(sm.refine_poses(marked).x_m, sm.refine_poses(without).x_m)


def test_a_third_of_wrong_echoes_does_little_harm(drive, rng):
    true, log = drive
    wrong = (rng.random(len(log)) < 1 / 3) & np.isfinite(log.range_m)
    spoiled = log.replace(range_m=np.where(wrong, rng.uniform(0.2, 4.0, len(log)), log.range_m))
    before, after = pose_errors(log, true), pose_errors(sm.refine_poses(spoiled), true)
    assert before[1] > math.radians(1)
    assert after[0] < before[0] / 1.5
    assert after[1] < before[1] / 1.5


def test_a_robot_that_stands_adds_nothing(drive, refined):
    _, log = drive
    last = np.flatnonzero(log.scan == log.scan[-1])
    rows = np.concatenate([np.arange(len(log)), np.tile(last, 200)])
    repeats = np.arange(200).repeat(len(last))
    still = log.select(rows)
    tail = slice(len(log), None)
    scan, time_s = still.scan.copy(), still.time_s.copy()
    scan[tail], time_s[tail] = scan[-1] + 1 + repeats, time_s[-1] + 0.2 * (1 + repeats)
    still = sm.refine_poses(still.replace(scan=scan, time_s=time_s))
    assert np.abs(still.x_m[: len(log)] - refined.x_m).max() < 0.005
    assert np.abs(still.heading_rad[: len(log)] - refined.heading_rad).max() < math.radians(0.1)


def silent(log):
    return log.replace(range_m=np.full(len(log), np.inf))


@pytest.mark.parametrize(
    "cut",
    [
        lambda log: log.select(slice(0, 0)),
        lambda log: log.select(slice(0, 1)),
        lambda log: log.select(slice(0, 16)),
        silent,
        lambda log: log.replace(rejected=np.ones(len(log), bool)),
    ],
    ids=["empty", "one reading", "two scans", "no echo", "all rejected"],
)
def test_a_log_that_tells_nothing_is_given_back(drive, cut):
    log = cut(drive[1])
    refined = sm.refine_poses(log)
    for name in ("x_m", "y_m", "heading_rad"):
        assert np.array_equal(getattr(refined, name), getattr(log, name))


def test_a_robot_that_never_moved_stays(drive, rng):
    true = np.tile([[0.3, -0.2, 0.4]], (60, 1))
    refined = sm.refine_poses(log_of(true, true, rng))
    assert pose_errors(refined, true) == pytest.approx((0, 0), abs=1e-6)


@pytest.mark.parametrize("sonars", [1, 3, 16])
def test_rings_of_any_size(rng, sonars):
    angles = np.linspace(0, math.tau, sonars, endpoint=False)
    ring = sm.SonarRing(
        "any", 0.1 * np.cos(angles), 0.1 * np.sin(angles), angles, math.radians(15), 0.1, 5.0
    )
    true = way(2)
    told = by_odometry(true, rng, slip=0.01)
    log = log_of(true, told, rng, ring=ring)
    before, after = pose_errors(log, true), pose_errors(sm.refine_poses(log), true)
    assert after[1] < before[1] + math.radians(0.2)
    assert after[0] < before[0] + 0.01


@pytest.mark.parametrize("knot_m", [0.0, -1.0, math.nan, "1", True])
def test_bad_knots_are_refused(drive, knot_m):
    with pytest.raises(sm.InputError, match="knot_m must be"):
        sm.refine_poses(drive[1], knot_m=knot_m)
