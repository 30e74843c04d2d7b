"""The compiled batch does what any engine and any sonar do one by one: to the last bit."""

import math

import numpy as np
import pytest

import worlds
from sim import ConeSonar, OdometryModel
from sim.envs.backends.compiled.backend import CompiledBackend
from sim.envs.backends.engine import EngineBackend
from sim.envs.backends.protocol import EpisodeSetup
from sim.envs.facts import facts_of
from sim.sonar import presets as sonars
from sim.sonar.cone.compiled import CompiledCone
from worlds import MATERIALS, Pose

CONTROL_S = 0.1
# Times and mean speeds are summed in another order.
ROUNDED = {"time_s": 1e-12, "fired_s": 1e-12, "wheel_mps": 1e-12}


def setup(sonar, room="office", seed=0, **changes):
    known = worlds.load(room)
    noise_rng, slip_rng = np.random.default_rng(seed).spawn(2)
    start = facts_of(known, 0.1).random_start(np.random.default_rng(seed))
    wanted = {"world": known, "start": start, "sonar": sonar, "odometry": OdometryModel()}
    return EpisodeSetup(**wanted | changes, noise_rng=noise_rng, slip_rng=slip_rng)


def assert_same(one, other, tolerances=ROUNDED):
    for name in one.dtype.names:
        a, b = np.asarray(one[name], float), np.asarray(other[name], float)
        tolerance = tolerances.get(name, 0.0)
        close = np.isclose(a, b, rtol=0, atol=tolerance, equal_nan=True)
        assert close.all(), (name, a, b)


def speeds(rng, robots):
    # Fast enough to run into things, and to turn against the limits.
    return rng.uniform(-0.1, 0.75, (robots, 2))


@pytest.mark.parametrize(
    ("name", "sonar"),
    [
        ("aria", sonars.preset("aria")),
        ("thesis", sonars.preset("thesis")),
        ("fan", sonars.preset("aria").replace(rays=31)),
        ("webots", sonars.preset("webots")),
    ],
)
def test_a_batch_is_its_robots_one_by_one(name, sonar, rng):
    rooms = ("office", "clutter", "round-room")
    batch = CompiledBackend(sonar, len(rooms), CONTROL_S)
    alone = EngineBackend("segments", len(rooms), len(sonar.ring), CONTROL_S)
    for row, room in enumerate(rooms):
        batch.begin(row, setup(sonar, room, row))
        alone.begin(row, setup(sonar, room, row))
    rounded = ROUNDED
    if name == "webots":
        # Its own rays are not turned from a fan's, so their ranges round otherwise.
        heard = ("range_m", "cone_range_m", "axis_range_m", "incidence_rad")
        rounded = ROUNDED | dict.fromkeys(heard, 1e-9)
    assert_same(batch.states, alone.states, rounded)
    touched = False
    for step in range(200):
        wanted, moves = speeds(rng, len(rooms)), np.array([True, step % 2 == 0, step < 150])
        batch.advance(wanted, moves)
        alone.advance(wanted, moves)
        assert_same(batch.states, alone.states, rounded)
        touched = touched or batch.states["touched"].any()
    assert touched  # or the drive would not have tried the walls


def test_a_second_episode_begins_as_if_there_had_been_no_first(rng):
    sonar = sonars.preset("aria")
    used, fresh = (CompiledBackend(sonar, 2, CONTROL_S) for _ in range(2))
    for row in (0, 1):
        used.begin(row, setup(sonar, "office", 7))
    for _ in range(80):
        used.advance(speeds(rng, 2), np.ones(2, bool))
    for backend in (used, fresh):
        backend.begin(0, setup(sonar, "clutter", 3))
        backend.begin(1, setup(sonar, "office", 4))
    for _ in range(80):
        wanted = speeds(rng, 2)
        used.advance(wanted, np.ones(2, bool))
        fresh.advance(wanted, np.ones(2, bool))
        assert_same(used.states, fresh.states, {})


def test_materials_noise_and_air_are_those_of_the_episode(rng):
    sonar = sonars.preset("aria")
    known = worlds.load("clutter")
    soft = known.with_materials([MATERIALS["foam"]] * len(known.solids))
    loud = sonar.replace(noise_std_m=0.05, range_scale=1.02, threshold=0.1)
    backend = CompiledBackend(sonar, 3, CONTROL_S)
    alone = EngineBackend("segments", 3, len(sonar.ring), CONTROL_S)
    wanted = [(sonar, known), (sonar, soft), (loud, known)]
    for row, (changed, room) in enumerate(wanted):
        for each in (backend, alone):
            each.begin(row, setup(changed, "clutter", 5, world=room))
    for _ in range(30):
        actions = speeds(rng, 3)
        for each in (backend, alone):
            each.advance(actions, np.ones(3, bool))
        assert_same(backend.states, alone.states)
    plain, foam, noisy = backend.states["range_m"]
    assert np.isinf(foam).sum() > np.isinf(plain).sum()
    assert not np.array_equal(plain, noisy)


def test_readings_come_at_the_firings_of_the_sonar_not_of_the_control(rng):
    # The thesis's sonars are read every 175 ms, the control step is 100 ms.
    backend = CompiledBackend(sonars.preset("thesis"), 1, CONTROL_S)
    backend.begin(0, setup(sonars.preset("thesis")))
    fired, fresh = [], []
    for _ in range(8):
        backend.advance(np.full((1, 2), 0.1), np.ones(1, bool))
        fired.append(backend.states["fired_s"][0, 0])
        fresh.append(int(backend.states["fresh"][0, 0]))
    assert fired == pytest.approx([0, 0.175, 0.175, 0.35, 0.35, 0.525, 0.7, 0.7])
    assert fresh == [0, 1, 0, 1, 0, 1, 1, 0]


@pytest.mark.engine
def test_pybullet_and_segments_drive_alike_where_nothing_is_touched():
    sonar = sonars.preset("aria")
    start = Pose(2.5, 3.0, 0.4)
    told = [setup(sonar, "office", 1, start=start) for _ in range(2)]
    with_bullet, without = (EngineBackend(e, 1, 8, CONTROL_S) for e in ("bullet", "segments"))
    with_bullet.begin(0, told[0])
    without.begin(0, told[1])
    for _ in range(30):
        for backend in (with_bullet, without):
            backend.advance(np.array([[0.2, 0.25]]), np.ones(1, bool))
    bullet, segments = with_bullet.states[0], without.states[0]
    with_bullet.close()
    with_bullet.close()  # closing twice is fine
    assert bullet["true_pose"] == pytest.approx(segments["true_pose"], abs=0.01)
    assert bullet["wheel_mps"] == pytest.approx(segments["wheel_mps"], abs=0.005)
    # A mirror may show one robot what the other, 1 cm beside it, does not see.
    near = np.isclose(bullet["range_m"], segments["range_m"], atol=0.03)
    assert near.mean() >= 0.75


def test_any_sonar_has_physics(rng):
    backend = EngineBackend("segments", 1, 8, CONTROL_S)
    sonar = sonars.preset("physical")
    assert not isinstance(sonar.compiled(), CompiledCone)
    backend.begin(0, setup(sonar, "clutter", 2))
    heard = set()
    for _ in range(10):
        backend.advance(np.full((1, 2), 0.2), np.ones(1, bool))
        heard |= set(np.flatnonzero(backend.states["fresh"][0]).tolist())
    # One sonar fires every 40 ms: in a second each has fired at least three times.
    assert heard == set(range(8))
    assert backend.states["fired_s"][0].min() >= 1.0 - 0.32
    fired = backend.states["fired_true_pose"][0]
    assert len({tuple(pose) for pose in fired}) == 8


def test_colder_air_reads_farther():
    wall = worlds.load("thesis-exp1")
    quiet = {"noise_std_m": 0.0, "quantum_m": 0.0}
    cold = ConeSonar("cold", sonars.preset("aria").ring, 0.1, range_scale=1.01, **quiet)
    warm = ConeSonar("warm", sonars.preset("aria").ring, 0.1, **quiet)
    ranges = []
    for sonar in (cold, warm):
        backend = CompiledBackend(sonar, 1, CONTROL_S)
        backend.begin(0, setup(sonar, "thesis-exp1", 0, world=wall))
        ranges.append(backend.states["range_m"][0].copy())
    echo = np.isfinite(ranges[1])
    assert echo.any()
    assert ranges[0][echo] == pytest.approx(1.01 * ranges[1][echo], abs=1e-4)
    assert math.isfinite(ranges[0][echo].sum())
