"""Drives with the physical sonar: symmetry, seeds, schedules, cross-talk, and a real log."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import MIRROR, box, closed_room, world

import sim
import sonarmap as sm
import worlds
from sim import ConstantSpeeds, Eeruf, OdometryModel, Receiver, StatusPackets
from sim.sonar import presets as sonars
from sonarmap import Cause, LogTruth
from worlds import Material

pytestmark = pytest.mark.engine

PHYSICAL = sonars.preset("physical")
ALIKE = sim.TransducerSpread(0.0, 0.0)
STILL = PHYSICAL.replace(
    receiver=Receiver(noise_std_m=0, weak_noise_std_m=0, quantum_m=0), spread=ALIKE
)
BRICK = Material("brick", 1.0, 0.9, 0.0, diffuse_floor_db=-20)


def mixed_room():
    """A room without any symmetry: scattering and mirroring walls, a box in a corner."""
    extra = (
        box("box", 0.7, 0.8, 1.1, 1.2, MIRROR),
        box("mirror", -1.3, -1.0, -1.2, 0.9, MIRROR, turned_deg=20, about=(-1.25, 0)),
    )
    return world(*closed_room(1.4, BRICK).solids, *extra, start=(0.1, -0.3, 0.4))


def drive(room=None, **changes):
    exact = OdometryModel.exact()
    arguments = {"scans": 20, "seed": 3, "driver": "thesis", "sonar": STILL, "odometry": exact}
    return sim.simulate(mixed_room() if room is None else room, **(arguments | changes))


@pytest.mark.parametrize("firing", [sim.AllAtOnce(0.1), sim.InTurn(), Eeruf()])
def test_mirrored_world_gives_a_mirrored_log(firing):
    partner = np.array([5, 4, 3, 2, 1, 0, 7, 6])
    sonar = STILL.replace(firing=firing)
    there = firing
    if not isinstance(firing, sim.AllAtOnce):
        # The partner fires when the sonar did.
        there = replace(firing, order=tuple(int(partner[sonar]) for sonar in firing.order))
    log = drive(driver=ConstantSpeeds(0.04, 0.075), sonar=sonar)
    mirrored = drive(
        mixed_room().mirrored(),
        driver=ConstantSpeeds(0.075, 0.04),
        sonar=STILL.replace(firing=there),
    )
    rows = np.argsort(partner[mirrored.sonar] + 8 * mirrored.scan, kind="stable")
    mine = np.argsort(log.sonar + 8 * log.scan, kind="stable")
    seen, own = mirrored.range_m[rows], log.range_m[mine]
    same = np.isclose(seen, own, atol=1e-4) | (np.isinf(own) & (seen == own))
    assert same.mean() > 0.98
    assert (mirrored.truth.cause[rows] == log.truth.cause[mine]).mean() > 0.98
    assert mirrored.time_s[rows] == pytest.approx(log.time_s[mine])


def test_sensors_have_their_own_noise_and_seeds_repeat():
    one, again, other = (drive(sonar=PHYSICAL, seed=seed) for seed in (0, 0, 1))
    assert (one.range_m == again.range_m).all()
    assert (one.range_m != other.range_m).any()
    # A robot at rest, its sides alike: what differs between two sonars is their noise.
    still = drive(closed_room(1.4, BRICK), sonar=PHYSICAL, driver=ConstantSpeeds(0, 0), scans=200)
    left, right = (still.range_m[still.sonar == sonar] for sonar in (0, 5))
    # Both read 1.3 m of a strong echo; 1 mm of noise and steps of 1 mm.
    for side in (left, right):
        assert side.std() == pytest.approx(0.00105, rel=0.15)
    assert abs(np.corrcoef(left, right)[0, 1]) < 0.25


def test_firing_in_turn_gives_each_reading_its_time_and_pose():
    log = drive()
    assert np.diff(log.time_s) == pytest.approx(np.full(159, 0.040))
    assert log.sonar.tolist() == list(range(8)) * 20
    moving = slice(80, None)
    assert (np.diff(log.truth.x_m[moving]) != 0).all()


def test_labels_agree_with_what_they_stand_beside():
    log = drive(scans=60, driver="wander", sonar=STILL.replace(firing=sim.AllAtOnce(0.1)))
    truth, silent = log.truth, np.isposinf(log.range_m)
    cause = truth.cause
    assert (truth.source[silent] == LogTruth.NO_SOURCE).all()
    assert (truth.surface[silent] == "").all()
    assert np.isnan(truth.level_db[silent]).all()
    assert (truth.level_db[~silent] > 0).all()
    own = (cause == Cause.DIRECT) | (cause == Cause.OFF_AXIS) | (cause == Cause.BOUNCE)
    assert (truth.source[own] == log.sonar[own]).all()
    assert (truth.source[cause == Cause.CROSSTALK] != log.sonar[cause == Cause.CROSSTALK]).all()
    assert (truth.bounces[cause == Cause.BOUNCE] > 0).all()
    assert np.isposinf(truth.cone_range_m[cause == Cause.OUT_OF_RANGE]).all()
    assert set(cause) >= {Cause.DIRECT, Cause.OFF_AXIS, Cause.CROSSTALK}


def test_eeruf_rejects_cross_talk_and_keeps_good_readings():
    # A round room of mirrors throws each sonar's sound at the others.
    sonar = PHYSICAL.replace(firing=Eeruf(), receiver=Receiver(38.0))
    log = drive(
        worlds.load("round-room"), sonar=sonar, driver=ConstantSpeeds(0.05, 0.09), scans=200
    )
    accepted = sm.eeruf_accepts(log)
    crosstalk = log.truth.cause == Cause.CROSSTALK
    good = log.truth.cause <= Cause.OUT_OF_RANGE
    assert crosstalk.sum() > 100
    assert good.sum() > 300
    assert (~accepted[crosstalk]).mean() >= 0.90
    assert accepted[good].mean() >= 0.95


def test_a_third_of_the_corridor_is_lost_and_most_is_repeated():
    # Beside the real log stands the hallway of `sonarbed acoustics`; this is the shipped room.
    log = sim.simulate(
        worlds.load("corridor"), scans=240, seed=1, sonar=PHYSICAL.replace(spread=ALIKE),
        driver="route", packets=StatusPackets(),
    )  # fmt: skip
    lost = np.isposinf(log.range_m)
    by_sonar = np.array([lost[log.sonar == sonar].mean() for sonar in range(8)])
    repeats = sm.mark_stale(log).stale
    repeats_by_sonar = np.array([repeats[log.sonar == sonar].mean() for sonar in range(8)])
    assert lost.mean() == pytest.approx(0.35, abs=0.04)
    assert by_sonar.min() < 0.05
    assert 0.5 < by_sonar.max() < 0.7
    assert repeats_by_sonar.min() > 0.69
    assert repeats_by_sonar.max() < 0.9
