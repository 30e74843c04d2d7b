"""The robots' own maps are those of `build_map`, and what they gain is what `score_map` says."""

import dataclasses
import math
import pickle
from typing import ClassVar

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from sameness import assert_same
from support import make_log

import sonarmap as sm
import worlds
from sim import OdometryModel
from sim.envs.backends.compiled.backend import CompiledBackend
from sim.envs.backends.protocol import EpisodeSetup
from sim.envs.facts import facts_of
from sim.envs.maps.method_maps import MethodMaps
from sim.envs.maps.robot_maps import MAP_MODEL, RobotMaps
from sim.sonar import presets as sonars
from sonarmap.methods.bayes.standard import BayesStandard
from sonarmap.methods.bayes.updating import Bayes

MODEL = sm.ParameterizedModel.thesis()
SONAR = sonars.preset("aria")
ROOMS = ("office", "thesis-exp1", "clutter", "l-shape", "round-room")


@pytest.fixture
def drive(rng):
    """Return (states at every step, maps, facts) of robots in rooms of different sizes."""
    facts = [facts_of(worlds.load(room), 0.1) for room in ROOMS]
    backend = CompiledBackend(SONAR, len(ROOMS), 0.1)
    maps = RobotMaps(len(ROOMS), SONAR.ring, MODEL)
    for row, known in enumerate(facts):
        streams = np.random.default_rng(row).spawn(2)
        start = known.random_start(rng)
        backend.begin(row, EpisodeSetup(known.world, start, SONAR, OdometryModel(), *streams))
        maps.begin(row, known)
    everybody = np.arange(len(ROOMS))
    steps, gains = [], []
    for _ in range(40):
        maps.add(backend.states, everybody)
        steps.append(backend.states.copy())
        gains.append((maps.bits_gained, maps.new_cells))
        backend.advance(rng.uniform(-0.2, 0.7, (len(ROOMS), 2)), np.ones(len(ROOMS), bool))
    return steps, gains, maps, facts


def log_of(steps, row):
    """Return the log of one robot's readings."""
    readings = [(s["fired_pose"][row], s["range_m"][row]) for s in steps]
    poses = np.concatenate([pose for pose, _ in readings])
    range_m = np.concatenate([ranges for _, ranges in readings])
    columns = dict(zip(("x_m", "y_m", "heading_rad"), poses.T, strict=True))
    sonar = np.tile(np.arange(8), len(steps))
    return make_log(range_m, ring=SONAR.ring, sonar=sonar, **columns)


def test_the_map_is_that_of_build_map(drive):
    steps, _, maps, facts = drive
    for row, known in enumerate(facts):
        expected = sm.build_map(log_of(steps, row), MODEL, known.grid)
        assert maps.map_of(row).grid == known.grid
        assert maps.map_of(row).log_odds == pytest.approx(expected.log_odds, abs=1e-9)
        assert np.abs(expected.log_odds).max() > 3


def test_bits_gained_are_those_of_the_map_score(drive):
    _, gains, maps, facts = drive
    for row, known in enumerate(facts):
        gained = sum(bits[row] for bits, _ in gains)
        truth = worlds.truth(known.world, known.grid)
        score = sm.score_map(maps.map_of(row), truth)
        # Bits are looked up in a table.
        assert gained == pytest.approx(score.bits, abs=0.01)


def test_new_cells_are_counted_once(drive):
    _, gains, maps, facts = drive
    for row, known in enumerate(facts):
        spoken_of = (maps.map_of(row).log_odds != 0) & (known.sign != 0)
        assert sum(new[row] for _, new in gains) == spoken_of.sum()


def test_mapped_cells_are_reachable_cells_that_the_map_calls_free(drive):
    _, _, maps, facts = drive
    for row, known in enumerate(facts):
        free = (maps.map_of(row).probability <= 0.35) & known.reachable
        assert maps.mapped_cells[row] == free.sum() > 0


def test_a_new_episode_begins_with_an_empty_map(drive):
    _, _, maps, facts = drive
    maps.begin(1, facts[0])
    assert (maps.map_of(1).log_odds == 0).all()
    assert maps.map_of(1).grid == facts[0].grid
    assert maps.mapped_cells[1] == 0
    assert (maps.map_of(2).log_odds != 0).any()


def plain_patch(map_, pose, size, cell_m):
    """The slow twin: one cell of the patch after the other."""
    x, y, heading = pose
    patch = np.full((size, size), 128)
    for i in range(size):
        for j in range(size):
            ahead, aside = ((size - 1) / 2 - i) * cell_m, ((size - 1) / 2 - j) * cell_m
            row, col = map_.grid.cell_of(
                x + math.cos(heading) * ahead - math.sin(heading) * aside,
                y + math.sin(heading) * ahead + math.cos(heading) * aside,
            )
            if map_.grid.contains(row, col) and map_.log_odds[row, col] != 0:
                patch[i, j] = math.floor(255 * map_.probability[row, col] + 0.5)
    return patch


def test_the_patch_is_the_map_as_the_robot_sees_it(drive):
    steps, _, maps, _ = drive
    patches = maps.patches(steps[-1], 24, 0.1)
    assert (patches.shape, patches.dtype) == ((len(ROOMS), 1, 24, 24), np.uint8)
    for row in range(len(ROOMS)):
        pose = steps[-1]["believed_pose"][row]
        assert np.array_equal(patches[row, 0], plain_patch(maps.map_of(row), pose, 24, 0.1))
    # Few robots take another way than many.
    few = RobotMaps(1, SONAR.ring, MODEL)
    few.begin(0, facts_of(worlds.load("office"), 0.1))
    for states in steps:
        few.add(states[:1], np.array([0]))
    assert np.array_equal(few.patches(steps[-1][:1], 24, 0.1)[0], patches[0])


def test_ahead_is_up_and_left_is_left():
    """A wall ahead and one on the left, in a map drawn by hand."""
    known = facts_of(worlds.load("thesis-exp1"), 0.1)
    maps = RobotMaps(1, SONAR.ring, MODEL)
    maps.begin(0, known)
    backend = CompiledBackend(SONAR, 1, 0.1)
    streams = np.random.default_rng(0).spawn(2)
    room = known.world
    backend.begin(0, EpisodeSetup(room, room.start, SONAR, OdometryModel(), *streams))
    states = backend.states.copy()
    x, y, _ = states["believed_pose"][0]
    states["believed_pose"][0] = x, y, math.pi / 2
    states["fired_pose"][0] = x, y, math.pi / 2
    states["range_m"][0] = np.inf
    states["range_m"][0, 0] = 0.5  # sonar 0 looks to the left
    maps.add(states, np.array([0]))
    patch = maps.patches(states, 20, 0.1)[0, 0]
    left, right = patch[:, :10], patch[:, 10:]
    assert (left > 128).any()
    assert (left < 128).any()
    assert (right == 128).all()


def explorer(**arguments):
    return gymnasium.make("sonarbed/Explore-v1", world="office", map_patch=16, **arguments)


def driven(env, steps=25):
    env.action_space.seed(2)
    return [env.reset(seed=2), *(env.step(env.action_space.sample()) for _ in range(steps))]


@dataclasses.dataclass(frozen=True)
class Plain:
    """The default method behind another's face: it offers nothing compiled."""

    trust: float = 0.6
    name: ClassVar[str] = "plain"

    def begin(self, ring, grid):
        return Bayes(dataclasses.replace(MAP_MODEL, p4=self.trust)).begin(ring, grid)


def test_any_method_maps_as_the_compiled_one_does():
    compiled, plain = explorer(), explorer(map_method=Plain())
    for one, other in zip(driven(compiled), driven(plain), strict=True):
        for name, values in one[0].items():
            # The order of sums within a step differs.
            np.testing.assert_allclose(values.astype(float), other[0][name].astype(float), atol=1)
        if len(one) == 5:
            assert other[1] == pytest.approx(one[1], abs=1e-4)
            assert other[4]["mapped_share"] == one[4]["mapped_share"]
            assert other[4]["reward_terms"]["area"] == pytest.approx(one[4]["reward_terms"]["area"])
    one, other = (env.unwrapped.occupancy_map for env in (compiled, plain))
    np.testing.assert_allclose(one.log_odds, other.log_odds, atol=1e-9)
    assert (one.log_odds != 0).any()


@pytest.mark.parametrize(
    ("given", "kind"),
    [
        (None, RobotMaps),
        ("bayes-standard", RobotMaps),
        ("sonarmap.methods.bayes.standard:BayesStandard", RobotMaps),
        ({"type": "bayes-parameterized", "p4": 0.7, "p2": 0.05}, RobotMaps),
        (BayesStandard(max_occupied=0.7), RobotMaps),
        (BayesStandard, RobotMaps),
        (BayesStandard(no_echo="clear"), MethodMaps),
        (BayesStandard(log_odds_limit=3.0), MethodMaps),
        (Plain(trust=0.7), MethodMaps),
    ],
)
def test_a_method_may_be_given_in_every_way(given, kind):
    env = explorer(map_method=given)
    told = driven(env)
    assert type(env.unwrapped.batch._parts.maps) is kind
    assert told[-1][4]["mapped_share"] > 0
    # And its specification makes it again, its copy goes on, and a batch does the same.
    assert_same(driven(gymnasium.make(EnvSpec.from_json(env.spec.to_json()))), told)
    env.reset(seed=4)
    other = pickle.loads(pickle.dumps(env))
    step = env.step(np.ones(2, np.float32))
    assert_same(other.step(np.ones(2, np.float32)), step)
    many = gymnasium.make_vec(env.spec.id, num_envs=2, **env.spec.kwargs)
    many.reset(seed=4)
    rows = many.step(np.ones((2, 2), np.float32))
    assert rows[1][0] == step[1]
    assert np.array_equal(rows[0]["map"][0], step[0]["map"])


class Whole:
    """A method that maps whole logs."""

    name = "whole"

    def map(self, log, grid):
        raise NotImplementedError


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (Whole(), r"map_method must take readings one at a time, by .begin\(ring, grid\), since"),
        (Whole, "map_method must take readings one at a time"),
        (lambda log, grid: None, "map_method must take readings one at a time"),
        (3, "map_method must take readings one at a time .*got 3, which does not"),
        ("bayes-standart", "method 'bayes-standart' is unknown; did you mean 'bayes-standard'"),
        ({"type": "bayes-standard", "beta": 1}, "has no parameter 'beta'"),
        ({"p4": 0.7}, "map_method given as a mapping must have the key 'type'"),
    ],
)
def test_what_cannot_map_as_a_robot_drives_is_refused(given, message):
    with pytest.raises(sm.InputError, match=message.replace("time .", "time, .")):
        explorer(map_method=given)


class Elsewhere:
    """Maps on a grid of its own."""

    def begin(self, ring, grid):
        return self

    map = sm.OccupancyMap(sm.GridSpec(0.5, (0.0, 0.0), (2, 2)), np.zeros((2, 2)))


def test_a_map_must_be_on_the_grid_that_it_was_given():
    env = explorer(map_method=Elsewhere())
    with pytest.raises(sm.InputError, match="its map must be on the grid given"):
        env.reset(seed=0)
