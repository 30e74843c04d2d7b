"""The vector environment is its single environments, step for step."""

import dataclasses

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from sameness import assert_same

from sim.envs.registration import IDS
from sim.envs.tasks.explore import Explore
from sonarmap import InputError

ROBOTS = 5
OPTIONS = {
    "plain": {"world": "office"},
    "patch": {"world": ["office", "thesis-exp1"], "map_patch": 16},
    "rooms": {
        "world": ["office", "clutter", "round-room"],
        "action": "wheels",
        "randomisation": {
            "materials": ("metal", "foam"),
            "noise": (1, 9),
            "temperature_c": (0, 30),
        },
    },
    "discrete": {"action": "discrete", "sonar": "thesis"},
    "physical": {"sonar": "physical", "world": "clutter"},
}


def vector(name, mode=AutoresetMode.NEXT_STEP, *, limit=None, robots=ROBOTS, **options):
    if limit is not None:
        options["max_episode_steps"] = limit
    return gymnasium.make_vec(
        f"sim:{name}",
        num_envs=robots,
        vectorization_mode="vector_entry_point",
        autoreset_mode=mode,
        **options,
    )


def singles(name, mode, *, limit, **options):
    """Return Gymnasium's own vector environment of single ones."""
    return SyncVectorEnv(
        [lambda: gymnasium.make(f"sim:{name}", max_episode_steps=limit, **options)] * ROBOTS,
        autoreset_mode=mode,
    )


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("mode", AutoresetMode)
def test_step_for_step_as_gymnasiums_own(name, option, mode):
    # So short a limit makes many episodes, and robots that begin at different times do not keep
    # in step: who runs into a wall ends earlier.
    steps, limit = (12, 5) if option == "physical" else (70, 30)
    ours = vector(name, mode, limit=limit, **OPTIONS[option])
    theirs = singles(name, mode, limit=limit, **OPTIONS[option])
    ours.action_space.seed(0)
    assert_same(ours.reset(seed=11), theirs.reset(seed=11))
    rng = np.random.default_rng(5)
    for step in range(steps):
        actions = ours.action_space.sample()
        mine = ours.step(actions)
        assert_same(mine, theirs.step(actions), f"step {step}")
        done = mine[2] | mine[3]
        if mode is AutoresetMode.DISABLED and done.any():
            # Now and then one begins anew that could have gone on.
            mask, seeds = done | (rng.uniform(size=ROBOTS) < 0.2), [None, 3, None, 4, 5]
            begun = [
                envs.reset(seed=seeds, options={"reset_mask": mask.copy(), "start": "world"})
                for envs in (ours, theirs)
            ]
            assert_same(*begun, f"reset after step {step}")
    theirs.close()
    ours.close()


@pytest.mark.parametrize("mode", AutoresetMode)
def test_all_may_end_and_begin_in_one_step(mode):
    ours, theirs = (make("sonarbed/Explore-v1", mode, limit=3) for make in (vector, singles))
    still = np.zeros((ROBOTS, 2), np.float32)
    for _ in range(2):
        assert_same(ours.reset(seed=1), theirs.reset(seed=1))
        for _ in range(3 if mode is AutoresetMode.DISABLED else 8):
            assert_same(ours.step(still), theirs.step(still))


def test_some_may_begin_anew_in_every_mode():
    mask = np.array([True, False, True, False, False])
    for mode in AutoresetMode:
        ours, theirs = (make("sonarbed/Navigate-v1", mode, limit=9) for make in (vector, singles))
        assert_same(ours.reset(seed=1), theirs.reset(seed=1))
        for _ in range(3):
            actions = ours.action_space.sample()
            assert_same(ours.step(actions), theirs.step(actions))
        begun = [envs.reset(seed=8, options={"reset_mask": mask.copy()}) for envs in (ours, theirs)]
        assert_same(*begun)
        for _ in range(4):
            actions = ours.action_space.sample()
            assert_same(ours.step(actions), theirs.step(actions))


@pytest.mark.parametrize("mode", AutoresetMode)
def test_frames_are_those_of_the_single_environments(mode):
    options = {"world": ["office", "corridor"], "limit": 3, "render_mode": "rgb_array"}
    ours, theirs = (make("sonarbed/Explore-v1", mode, **options) for make in (vector, singles))
    for envs in (ours, theirs):
        envs.reset(seed=2)
    assert_same(ours.render(), theirs.render())
    for _ in range(3):
        actions = ours.action_space.sample()
        assert_same(ours.step(actions), theirs.step(actions))
    frames = ours.render()
    assert_same(frames, theirs.render())
    assert len(frames) == ROBOTS
    assert len({frame.shape for frame in frames}) == 1


def test_without_a_render_mode_nothing_is_drawn():
    env = vector("sonarbed/Explore-v1", robots=1)
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="nothing is drawn"):
        assert env.render() is None


def test_infos_share_no_memory():
    env = vector("sonarbed/Explore-v1", AutoresetMode.SAME_STEP, limit=2)
    env.reset(seed=0)
    told = [env.step(env.action_space.sample())[4] for _ in range(4)]
    arrays = [array for info in told for array in leaves(info)]
    for i, one in enumerate(arrays):
        assert not any(np.shares_memory(one, other) for other in arrays[i + 1 :])


def leaves(info):
    for value in info.values():
        if isinstance(value, dict):
            yield from leaves(value)
        elif value.dtype != object:
            yield value


def test_the_actions_of_robots_that_begin_are_ignored():
    ours, theirs = (
        make("sonarbed/Explore-v1", AutoresetMode.NEXT_STEP, limit=1) for make in (vector, singles)
    )
    for envs in (ours, theirs):
        envs.reset(seed=0)
        envs.step(np.zeros((ROBOTS, 2), np.float32))
    anything = np.full((ROBOTS, 2), np.nan, np.float32)
    assert_same(ours.step(anything), theirs.step(anything))


class Chatty(Explore):
    """Says things of every kind."""

    def evaluate(self, outcome):
        evaluation = super().evaluate(outcome)
        n = len(outcome.states)
        said = {
            "few": np.full(n, 7, np.int16),
            "half": np.full(n, 0.5, np.float32),
            "place": outcome.states["true_pose"][:, :2],
            "word": np.full(n, "yes"),
            "nested": {"deep": {"flag": outcome.stuck, "row": np.ones((n, 3), np.int8)}},
        }
        info = {**evaluation.info, **said}
        return dataclasses.replace(evaluation, info=info)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_the_infos_of_a_task_of_ones_own_are_gathered_as_gymnasium_does(mode):
    ours, theirs = (
        make("sonarbed/Task-v1", mode, task=Chatty, limit=4) for make in (vector, singles)
    )
    assert_same(ours.reset(seed=1), theirs.reset(seed=1))
    for _ in range(9):
        actions = ours.action_space.sample()
        assert_same(ours.step(actions), theirs.step(actions))


def test_a_big_batch_is_its_rows():
    few = vector("sonarbed/Explore-v1", robots=2, world="office", map_patch=16)
    many = vector("sonarbed/Explore-v1", robots=64, world="office", map_patch=16)
    few.reset(seed=30)
    many.reset(seed=30)
    rng = np.random.default_rng(0)
    for _ in range(40):
        actions = rng.uniform(-0.5, 1.0, (64, 2)).astype(np.float32)
        one, other = few.step(actions[:2]), many.step(actions)
        assert_same(one[0], {key: values[:2] for key, values in other[0].items()})
        assert np.array_equal(one[1], other[1][:2])


def test_rows_differ_and_rooms_are_drawn():
    env = vector("sonarbed/Explore-v1", robots=20, world=["office", "clutter"])
    _, info = env.reset(seed=0)
    assert len(np.unique(info["true_pose"], axis=0)) == 20
    rooms = [env.batch.setup_of(row).world.name for row in range(20)]
    assert set(rooms) == {"office", "clutter"}


def test_seeds_may_be_a_list_and_none_goes_on():
    env, again = vector("sonarbed/Navigate-v1"), vector("sonarbed/Navigate-v1")
    first = env.reset(seed=[3, 1, 4, 1, 5])[1]["true_pose"]
    assert np.array_equal(first[1], first[3])
    assert not np.array_equal(first[0], first[1])
    again.reset(seed=[3, 1, 4, 1, 5])
    assert np.array_equal(env.reset()[1]["true_pose"], again.reset()[1]["true_pose"])
    assert not np.array_equal(env.reset()[1]["true_pose"], first)


def test_observations_share_no_memory():
    env = vector("sonarbed/Explore-v1", map_patch=16)
    told = [env.reset(seed=0)[0]]
    told += [env.step(env.action_space.sample())[0] for _ in range(3)]
    for i, one in enumerate(told):
        for other in told[i + 1 :]:
            assert not any(np.shares_memory(one[key], other[key]) for key in one)


def test_observations_are_in_their_space():
    env = vector("sonarbed/Navigate-v1", map_patch=16, limit=20, world=["office", "corridor"])
    env.reset(seed=0)
    for _ in range(50):
        observation, reward, *_ = env.step(env.action_space.sample())
        assert env.observation_space.contains(observation)
        assert np.isfinite(reward).all()


def test_gymnasiums_wrappers_take_it():
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(vector("sonarbed/Navigate-v1", limit=5))
    env.reset(seed=0)
    for _ in range(6):
        *_, info = env.step(env.action_space.sample())
        if "episode" in info:
            break
    assert info["episode"]["l"].tolist() == [5] * ROBOTS


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"robots": 0}, "num_envs must be >= 1, got 0"),
        ({"mode": "Sometimes"}, "autoreset_mode must be one of .*, got 'Sometimes'"),
        ({"robots": 2.5}, "num_envs must be a whole number, got 2.5"),
        ({"robots": "2"}, "num_envs must be a number, got '2'"),
        ({"robots": True}, "num_envs must be a number, got True"),
        ({"limit": 0}, "max_episode_steps must be >= 1, got 0"),
        ({"limit": 2.5}, "max_episode_steps must be a whole number, got 2.5"),
        ({"render_mode": "human"}, "render_mode 'human' is unknown"),
        ({"weights": {"map_skore": 1}}, "weights 'map_skore' is unknown; did you mean"),
        ({"engine": "segment"}, r"engine 'segment' is unknown; did you mean 'segments'\?"),
        ({"world": "ofice"}, r"did you mean 'office'\?"),
        ({"wrld": "office"}, r"argument 'wrld' is unknown; did you mean 'world'\?"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        vector("sonarbed/Explore-v1", **arguments)


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        (np.zeros((ROBOTS, 3)), rf"must have shape \({ROBOTS}, 2\), got \({ROBOTS}, 3\)"),
        (np.zeros(2), rf"must have shape \({ROBOTS}, 2\), got \(2,\)"),
        (np.full((ROBOTS, 2), np.nan), r"must be within \[-1, 1\]"),
        (np.full((ROBOTS, 2), 1.5), r"must be within \[-1, 1\]"),
    ],
)
def test_bad_actions_are_refused(actions, message):
    env = vector("sonarbed/Explore-v1")
    env.reset(seed=0)
    with pytest.raises(gymnasium.error.InvalidAction, match=message):
        env.step(actions)


def test_what_comes_at_the_wrong_time_is_refused():
    env = vector("sonarbed/Explore-v1")
    with pytest.raises(gymnasium.error.ResetNeeded, match="before the first step"):
        env.step(env.action_space.sample())
    with pytest.raises(InputError, match=f"seed must have one number a robot, {ROBOTS}, got 2"):
        env.reset(seed=[1, 2])
    with pytest.raises(InputError, match="option 'wrld' is unknown"):
        env.reset(seed=0, options={"wrld": "office"})
    with pytest.raises(gymnasium.error.ResetNeeded, match="all robots before some"):
        env.reset(options={"reset_mask": np.array([True] + [False] * (ROBOTS - 1))})
    env.close()
    env.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="is closed"):
        env.reset()


def test_who_resets_by_hand_must_reset_who_is_done():
    env = vector("sonarbed/Explore-v1", AutoresetMode.DISABLED, limit=2)
    env.reset(seed=0)
    still = np.zeros((ROBOTS, 2), np.float32)
    env.step(still)
    env.step(still)
    env.reset(options={"reset_mask": np.array([True, False, True, True, False])})
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"of the robots \[1, 4\] have ended"):
        env.step(still)


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        ([True] * ROBOTS, "reset_mask must be an array of bool, got"),
        (np.ones(ROBOTS), "reset_mask must be an array of bool, got"),
        (np.ones(2, bool), r"reset_mask must have shape \(5,\), got \(2,\)"),
        (np.zeros(ROBOTS, bool), "reset_mask must name at least one robot, got none"),
    ],
)
def test_bad_masks_are_refused(mask, message):
    env = vector("sonarbed/Explore-v1")
    env.reset(seed=0)
    with pytest.raises(InputError, match=message):
        env.reset(options={"reset_mask": mask})


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (1.5, "seed must be a whole number, got 1.5"),
        ("12345", "seed must be a number, got '12345'"),
        (True, "seed must be a number, got True"),
        (-1, "seed must be >= 0, got -1"),
        ([1, 2, 3, 4, 0.5], r"seed\[4\] must be a whole number, got 0.5"),
    ],
)
def test_bad_seeds_are_refused(seed, message):
    with pytest.raises(InputError, match=message):
        vector("sonarbed/Explore-v1").reset(seed=seed)
