"""Transducers of a ring that differ."""

import math

import numpy as np
import pytest
from rooms import MIRROR, box, world

import sim
import worlds
from sim import AllAtOnce, PhysicalSonar, Receiver, TransducerSpread
from sim.sonar.presets import preset
from sonarmap import InputError, SonarRing

AHEAD = SonarRing("ahead", [0], [0], [0], math.radians(15), 0.1, 5.0)
QUIET = Receiver(60.0, 1.0, 1e-9, 0.58e-3, noise_std_m=0, weak_noise_std_m=0, quantum_m=0)
ROOM = world(box("wall", 2, -20, 2.1, 20, MIRROR))
BY_SEARCH = pytest.mark.parametrize("search", ["images", "rays"])


def heard(spread, search, axis_deg=0.0):
    sonar = PhysicalSonar("one", AHEAD, AllAtOnce(0.1), receiver=QUIET, spread=spread,
                          search=search)  # fmt: skip
    array = sonar.array(ROOM.faces, ROOM, np.random.default_rng(0))
    array.fire(0.0, (0,), np.zeros((1, 2)), np.radians([axis_deg]))
    return array.detect()


@BY_SEARCH
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_sensitivity_counts_there_and_back(search, seed):
    spread = TransducerSpread(2.0, 0.0, seed)
    gain_db = spread.drawn(1, np.random.default_rng(9)).gain_db[0]
    plain = heard(TransducerSpread(0.0, 0.0), search)
    assert heard(spread, search).level_db[0] - plain.level_db[0] == pytest.approx(2 * gain_db)


@BY_SEARCH
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_beam_leans_and_the_truth_does_not(search, seed):
    spread = TransducerSpread(0.0, math.radians(2.0), seed)
    lean_rad = spread.drawn(1, np.random.default_rng(9)).lean_rad[0]
    alike = TransducerSpread(0.0, 0.0)
    leaning = heard(spread, search, 4.0)
    turned = heard(alike, search, 4.0 + math.degrees(lean_rad))
    assert leaning.level_db[0] == pytest.approx(turned.level_db[0], abs=1e-9)
    straight = heard(alike, search, 4.0)
    assert leaning.axis_range_m[0] == pytest.approx(straight.axis_range_m[0], abs=1e-9)
    assert leaning.cone_range_m[0] == pytest.approx(straight.cone_range_m[0], abs=1e-5)


def test_draws_have_the_spread_and_no_outliers():
    drawn = TransducerSpread(1.5, 0.02).drawn(20_000, np.random.default_rng(0))
    for values, std in ((drawn.gain_db, 1.5), (drawn.lean_rad, 0.02)):
        assert abs(values.mean()) < 0.03 * std
        # Cut at two standard deviations, a normal distribution has 0.95 of its own.
        assert values.std() == pytest.approx(0.95 * std, rel=0.03)
        assert np.abs(values).max() <= 2 * std


def drive(seed, spread):
    sonar = preset("physical").replace(spread=spread)
    return sim.simulate(
        worlds.load("office"), scans=25, seed=seed, sonar=sonar, engine="segments"
    )  # fmt: skip


def test_a_drive_has_its_own_robot_and_a_seed_the_same_one():
    own = TransducerSpread()
    assert (drive(3, own).range_m == drive(3, own).range_m).all()
    first = own.drawn(8, np.random.default_rng(3)).gain_db
    assert (first != own.drawn(8, np.random.default_rng(4)).gain_db).all()
    same = TransducerSpread(seed=5)
    drawn = [same.drawn(8, np.random.default_rng(seed)).gain_db for seed in (3, 4)]
    assert (drawn[0] == drawn[1]).all()


def test_spread_shifts_no_other_draws():
    """Noise, odometry and driver draw the same numbers, whatever the transducers are."""
    one, other = drive(3, TransducerSpread(0.0, 0.0)), drive(3, TransducerSpread(1e-9, 1e-9))
    np.testing.assert_allclose(one.range_m, other.range_m, atol=1e-6)
    assert (one.x_m == other.x_m).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensitivity_std_db": -1.0}, "sensitivity_std_db must be >= 0"),
        ({"sensitivity_std_db": math.nan}, "sensitivity_std_db must be"),
        ({"direction_std_rad": "x"}, "direction_std_rad must be a"),
        ({"seed": -1}, "seed must be >= 0"),
        ({"seed": 1.5}, "seed must be a whole number"),
    ],
)
def test_bad_spread_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        TransducerSpread(**arguments)
