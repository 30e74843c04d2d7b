"""Environments copy and pickle at any moment, and the copy goes on as the original does."""

import copy
import dataclasses
import gc
import os
import pickle
import subprocess
import sys
import weakref

import gymnasium
import numpy as np
import pytest
from sameness import assert_same

import sim.envs
from sim.engines import opening
from sim.envs.registration import IDS
from sim.envs.tasks.navigate import Navigate
from sonarmap import AMIGOBOT
from worlds import load

OPTIONS = {
    "plain": {},
    "patch": {"map_patch": 16, "world": ["office", "clutter"]},
    "drawn": {
        "world": ["office", "l-shape", "corridor"],
        "randomisation": {"materials": ("metal", "foam"), "noise": (1, 2)},
    },
    "own room": {"world": load("office").mirrored(), "action": "discrete"},
    "physical": {"sonar": "physical", "world": "clutter"},
    "eeruf": {
        "sonar": sim.PhysicalSonar("eeruf", AMIGOBOT, firing=sim.Eeruf()),
        "engine": "segments",
    },
    "frames": {"render_mode": "rgb_array"},
}
WAYS = {"pickle": lambda env: pickle.loads(pickle.dumps(env)), "deepcopy": copy.deepcopy}
STEPS = 6


def single(name, **options):
    return gymnasium.make(name, max_episode_steps=STEPS + 3, **options)


def vector(name, mode="NextStep", robots=3, **options):
    return gymnasium.make_vec(
        name,
        num_envs=robots,
        vectorization_mode="vector_entry_point",
        autoreset_mode=mode,
        max_episode_steps=STEPS + 3,
        **options,
    )


def driven(env, steps, seed=3, *, is_vector=False):
    """Return all that an environment says in so many steps; episodes that end begin anew."""
    env.action_space.seed(seed)
    told = []
    for _ in range(steps):
        step = env.step(env.action_space.sample())
        told.append(step)
        if env.render_mode is not None:
            told.append(env.render())
        if not is_vector and (step[2] or step[3]):
            told.append(env.reset())
    return tuple(told)


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("way", WAYS)
def test_a_copy_goes_on_as_the_original_does(name, option, way):
    env = single(name, **OPTIONS[option])
    early = WAYS[way](env)
    assert_same(early.reset(seed=7), env.reset(seed=7))
    begun = WAYS[way](env)
    assert_same(driven(begun, STEPS), driven(env, STEPS))
    # Past the end of the episode, so that the generators are the same, too.
    later = WAYS[way](env)
    assert_same(driven(later, 2 * STEPS), driven(env, 2 * STEPS))


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_a_copy_of_many_goes_on_as_they_do(name, option, mode):
    env = vector(name, mode, **OPTIONS[option])
    early = pickle.loads(pickle.dumps(env))
    assert_same(early.reset(seed=7), env.reset(seed=7))
    for way in WAYS.values():
        other = way(env)
        assert_same(
            driven(other, 2 * STEPS, is_vector=True), driven(env, 2 * STEPS, is_vector=True)
        )


@pytest.mark.parametrize("way", WAYS)
def test_original_and_copy_do_not_meet(way):
    env, alone = (single("sonarbed/Explore-v1", map_patch=16) for _ in range(2))
    for each in (env, alone):
        each.reset(seed=1)
    other = WAYS[way](env)
    driven(other, STEPS, seed=8)
    assert_same(driven(env, STEPS), driven(alone, STEPS))


def test_robots_of_a_copy_stay_in_rooms_that_others_leave():
    # Two rooms of the same faces and other materials share a number, in the copy as well.
    drawn = {"materials": ("metal", "foam")}
    env = vector("sonarbed/FollowWall-v1", "Disabled", world="office", randomisation=drawn)
    env.reset(seed=0)
    other = pickle.loads(pickle.dumps(env))
    for each in (env, other):
        mask = np.array([True, False, False])
        each.reset(seed=4, options={"reset_mask": mask, "world": "clutter"})
    assert_same(driven(other, STEPS - 2, is_vector=True), driven(env, STEPS - 2, is_vector=True))


@pytest.mark.parametrize("way", WAYS)
def test_after_the_end_and_after_close(way):
    env = WAYS[way](single("sonarbed/Navigate-v1"))
    env.reset(seed=0)
    for _ in range(STEPS + 3):
        env.step(env.action_space.sample())
    other = WAYS[way](env)
    assert_same(other.reset(), env.reset())
    env.close()
    other = WAYS[way](env)
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="is closed"):
        other.reset()


def test_an_episode_with_options_of_its_own():
    env = single("sonarbed/Navigate-v1")
    env.reset(seed=0, options={"sonar": "thesis", "world": "office", "odometry": {"slip_std_m": 0}})
    other = pickle.loads(pickle.dumps(env))
    assert_same(driven(other, 2 * STEPS), driven(env, 2 * STEPS))


class Nearby(Navigate):
    """A task of one's own, which no registry knows."""


@pytest.mark.parametrize("way", WAYS)
def test_a_task_of_ones_own(way):
    env = gymnasium.make("sonarbed/Task-v1", task=Nearby)
    env.reset(seed=1)
    other = WAYS[way](env)
    assert isinstance(other.unwrapped.batch.task, Nearby)
    assert_same(driven(other, STEPS), driven(env, STEPS))
    many = gymnasium.make_vec("sonarbed/Task-v1", num_envs=2, task=Nearby)
    many.reset(seed=1)
    assert_same(driven(WAYS[way](many), STEPS, is_vector=True), driven(many, STEPS, is_vector=True))


def test_a_recorded_episode_goes_on_recording():
    env = sim.envs.RecordLog(single("sonarbed/Navigate-v1", world="office"))
    env.reset(seed=0)
    driven(env, 3)
    other = pickle.loads(pickle.dumps(env))
    for each in (env, other):
        driven(each, 3)
    for name in env.log().DTYPES:
        one, two = (getattr(each.log(), name) for each in (env, other))
        assert np.array_equal(one, two, equal_nan=one.dtype.kind == "f")


def test_a_pickle_is_read_in_another_process(tmp_path):
    env = single("sonarbed/Explore-v1", world="office")
    env.reset(seed=0)
    (tmp_path / "env").write_bytes(pickle.dumps(env))
    code = (
        "import pickle, sys, numpy as np; env = pickle.load(open(sys.argv[1], 'rb'));"
        "print([env.step(np.ones(2, np.float32))[1] for _ in range(3)])"
    )
    told = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "env")],
        check=True, capture_output=True, text=True, env=os.environ,
    )  # fmt: skip
    assert told.stdout.strip() == str([env.step(np.ones(2, np.float32))[1] for _ in range(3)])


def test_windows_stay_where_they_are(monkeypatch):
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = sim.envs.NavigateEnv(render_mode="human")
    env.reset(seed=0)
    other = copy.deepcopy(env)
    env.step(np.zeros(2, np.float32))
    other.step(np.zeros(2, np.float32))
    env.close()
    other.close()


@pytest.mark.engine
@pytest.mark.parametrize("way", WAYS)
def test_bullet_says_that_it_cannot(way):
    env = single("sonarbed/Navigate-v1", engine="bullet")
    early = WAYS[way](env)
    early.close()
    env.reset(seed=0)
    with pytest.raises(TypeError, match="engine 'bullet' can be neither copied nor pickled"):
        WAYS[way](env)
    env.step(env.action_space.sample())  # and nothing is broken
    env.close()
    WAYS[way](env)


class Counted:
    """An engine that counts those of its kind that are open."""

    opened = 0

    def __init__(self, world, start, *, gui=False):
        self._engine, self._is_open = opening.ENGINES["segments"](world, start), True
        type(self).opened += 1

    def __getattr__(self, name):
        return getattr(self._engine, name)

    def close(self):
        type(self).opened -= self._is_open
        self._is_open = False


class Unwilling(sim.PhysicalSonar):
    """A sonar that refuses to be set up."""

    def array(self, rays, world, rng):
        raise OSError("no power")


@pytest.fixture
def counted(monkeypatch):
    monkeypatch.setattr(Counted, "opened", 0)
    monkeypatch.setattr("sim.envs.backends.engine.open_engine", opened)
    return Counted


def opened(name, world, *, start):
    return Counted(world, start)


def test_who_is_dropped_lets_go_of_its_engines(counted):
    options = {"sonar": "physical", "world": "office"}
    env, many = single(IDS[0], **options), vector(IDS[1], **options)
    env.reset(seed=0)
    many.reset(seed=0)
    many.reset()
    assert counted.opened == 4
    watched = weakref.ref(many)
    del many
    gc.collect()
    assert watched() is None
    assert counted.opened == 1
    env = sim.envs.RecordLog(env)
    env.reset()
    env.step(env.action_space.sample())
    del env
    gc.collect()
    assert counted.opened == 0


def test_who_fails_to_begin_lets_go_of_its_engine(counted):
    sonar = Unwilling("unwilling", AMIGOBOT)
    env = sim.envs.NavigateEnv(sonar=sonar)
    with pytest.raises(OSError, match="no power"):
        env.reset(seed=0)
    assert counted.opened == 0
    env.reset(options={"sonar": dataclasses.replace(sim.PhysicalSonar("x", AMIGOBOT))})
    assert counted.opened == 1
