"""A log's readings, taken again by simulated sonars."""

from dataclasses import replace

import numpy as np
import pytest
from support import REAL_LOG, make_log

import sim
import sonarmap as sm
import worlds
from sim.runs.replay import CLOSE_M, Replay
from sim.sonar import presets
from sonarbed.studies.acoustics.reality import ROOM


def quiet(name):
    """Return a preset without noise; its transducers are alike, as those of a replay are."""
    sonar = presets.preset(name)
    if name == "physical":
        return sonar.replace(
            receiver=replace(sonar.receiver, noise_std_m=0.0, weak_noise_std_m=0.0),
            spread=sim.TransducerSpread(0.0, 0.0),
        )
    return sonar.replace(noise_std_m=0.0) if hasattr(sonar, "noise_std_m") else sonar


@pytest.mark.parametrize("packets", [None, sim.StatusPackets()], ids=["firings", "packets"])
@pytest.mark.parametrize("name", ["thesis", "webots", "physical"])
def test_a_simulated_log_without_noise_agrees_with_itself(name, packets):
    room, sonar = worlds.load("clutter"), quiet(name)
    log = sim.simulate(room, scans=25, seed=1, sonar=sonar, engine="segments", packets=packets)
    told = sim.replay(log, room, sonar=sonar)
    assert told.poses == "true"
    assert told.agreement == 1
    assert [told.within(m) for m in CLOSE_M] == [1, 1, 1]
    assert not any(told.disagreements().values())
    used = log.select(log.usable)
    # The roughness of the surfaces is drawn anew.
    assert np.allclose(told.simulated.range_m, used.range_m, rtol=0, atol=0.04)
    assert np.array_equal(told.simulated.truth.cause, used.truth.cause)
    assert np.array_equal(told.simulated.truth.source, used.truth.source)


def test_sonars_that_share_a_time_by_their_packet_alone_do_not_hear_one_another():
    room = worlds.load("l-shape")
    log = sim.simulate(room, scans=10, seed=0, sonar="aria", engine="segments")
    told = sim.replay(log, room, sonar="physical")  # its ring fires one after the other
    assert (told.simulated.truth.cause != sm.Cause.CROSSTALK).all()
    heard = told.simulated.truth.source >= 0
    assert np.array_equal(told.simulated.truth.source[heard], told.simulated.sonar[heard])


def test_odometry_is_what_a_real_log_has():
    room = worlds.load("l-shape")
    log = sim.simulate(room, scans=15, seed=0, sonar=quiet("thesis"), engine="segments")
    real = log.at_true_poses().replace(truth=None)
    told = sim.replay(real, room, sonar=quiet("thesis"))
    assert (told.poses, told.agreement) == ("odometry", 1)
    off = sim.replay(real.replace(x_m=real.x_m + 0.15), room, sonar=quiet("thesis"))
    assert off.within(0.05) < 0.9
    with pytest.raises(sm.InputError, match="the log has no truth"):
        sim.replay(real, room, poses="true")


def test_counts_by_hand():
    inf = np.inf
    log = make_log(
        [1.0, 1.0, inf, inf, 1.0, -inf], ring=sm.ring("hc-sr04-3"), sonar=[0, 0, 0, 1, 1, 1]
    )
    other = make_log([1.04, 1.5, inf, 2.0, inf, 1.0], ring=log.ring, sonar=log.sonar)
    causes = [sm.Cause.DIRECT, sm.Cause.BOUNCE, sm.Cause.DROPOUT] * 2
    room = worlds.load("l-shape")
    truth = sim.simulate(room, scans=2, seed=0, sonar="aria", engine="segments").truth
    truth = replace(truth.select(slice(0, 6)), cause=np.array(causes))
    told = Replay(log, other.replace(truth=truth), sm.account.account_of(log), "odometry")
    assert told.agreement == pytest.approx(4 / 6)
    assert [told.within(m) for m in CLOSE_M] == [0.5, 0.5, 0.5]
    real, simulated = told.silence_by_sonar()
    assert np.allclose(real, [1 / 3, 1 / 3, np.nan], equal_nan=True)
    assert np.allclose(simulated, [1 / 3, 1 / 3, np.nan], equal_nan=True)
    assert told.disagreements() == {
        "silent_but_simulated_echo": {"DIRECT": 1},
        "echo_but_simulated_silent": {"BOUNCE": 1},
        # Too close is nearer than anything.
        "shorter_than_simulated": {"BOUNCE": 1, "DROPOUT": 1},
        "longer_than_simulated": {},
    }


def test_stale_and_rejected_readings_are_not_compared():
    room = worlds.load("l-shape")
    log = sim.simulate(room, scans=6, seed=0, sonar=quiet("thesis"), engine="segments")
    third = np.arange(len(log)) % 3
    told = sim.replay(log.replace(stale=third == 0, rejected=third == 1), room, sonar="thesis")
    assert len(told.log) == (third == 2).sum()
    assert str(told.account) == "16 of 48 readings used; not used: 16 stale, 16 rejected"
    with pytest.raises(sm.InputError, match="neither stale nor rejected, got none"):
        sim.replay(log.replace(stale=np.ones(48, bool)), room)


def test_a_ring_larger_than_our_robot_is_replayed():
    ring = sm.ring("pioneer3dx-front")
    log = make_log(
        np.full(8, 1.0), ring=ring, sonar=np.arange(8), scan=0, time_s=0, x_m=1.5, y_m=1.2
    )
    told = sim.replay(log, worlds.load("l-shape"))
    assert told.simulated.ring == ring


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sonar": "physicl"}, "sonar 'physicl' is unknown; did you mean 'physical'"),
        ({"poses": "gps"}, "poses 'gps' is unknown"),
        ({"seed": -1}, "seed must be >= 0"),
        ({"engine": "bulet"}, "engine 'bulet' is unknown"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(sm.InputError, match=message):
        sim.replay(make_log([1.0, 2.0]), worlds.load("l-shape"), **arguments)


@pytest.mark.skipif(not REAL_LOG.is_dir(), reason="the real log is not part of the repository")
def test_the_real_log_fits_the_hallway_that_was_made_after_it():
    files = [REAL_LOG / "measurement.txt", REAL_LOG / "poses.txt"]
    log = sm.import_log(files, "udacity", sm.ring("udacity8"))
    room = worlds.load(str(ROOM))
    motion = worlds.align(log, room)
    assert motion.median_m < 0.1
    told = sim.replay(motion.moved(log), room)
    assert told.poses == "odometry"
    assert told.agreement > 0.65
    # The walls beside the robot, met head-on, are where they were measured.
    beside = np.isin(told.log.sonar, (0, 7)) & told.both_measured
    off_m = np.abs(told.log.range_m[beside] - told.simulated.range_m[beside])
    assert np.median(off_m) < 0.2


def test_transducers_of_a_replay_are_nominal_unless_a_seed_tells_which_they_are():
    room, sonar = worlds.load("l-shape"), quiet("physical")
    log = sim.simulate(room, scans=15, seed=0, sonar=sonar, engine="segments")
    drawn = sim.replay(log, room, sonar=sonar.replace(spread=sim.TransducerSpread()))
    assert drawn.agreement == 1
    known = sonar.replace(spread=sim.TransducerSpread(3.0, 0.05, seed=1))
    levels = [
        sim.replay(log, room, sonar=known, seed=seed).simulated.truth.level_db for seed in (0, 5)
    ]
    np.testing.assert_array_equal(*levels)
    assert not np.array_equal(levels[0], drawn.simulated.truth.level_db, equal_nan=True)
