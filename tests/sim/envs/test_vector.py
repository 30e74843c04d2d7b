"""The vector environment is its single environments, step for step."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from sim.envs.registration import IDS
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


def assert_same(one, other):
    assert one.keys() == other.keys()
    for key, values in one.items():
        assert values.dtype == other[key].dtype
        assert np.array_equal(values, other[key]), key


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_step_for_step_as_the_single_environment(name, option, mode):
    # So short a limit makes many episodes, and robots that begin at different times do not keep
    # in step: who runs into a wall ends earlier.
    steps, limit = (12, 5) if option == "physical" else (70, 30)
    ours = vector(name, mode, limit=limit, **OPTIONS[option])
    theirs = singles(name, mode, limit=limit, **OPTIONS[option])
    ours.action_space.seed(0)
    (mine, my_info), (expected, their_info) = ours.reset(seed=11), theirs.reset(seed=11)
    assert_same(mine, expected)
    assert np.array_equal(my_info["true_pose"], their_info["true_pose"])
    for _ in range(steps):
        actions = ours.action_space.sample()
        mine, expected = ours.step(actions), theirs.step(actions)
        assert_same(mine[0], expected[0])
        for part in (1, 2, 3):
            assert mine[part].dtype == expected[part].dtype
            assert np.array_equal(mine[part], expected[part])
        my_info, their_info = mine[4], expected[4]
        assert np.array_equal(my_info["true_pose"], their_info["true_pose"])
        assert ("final_obs" in my_info) == ("final_obs" in their_info)
        if "final_obs" in my_info:
            assert np.array_equal(my_info["_final_obs"], their_info["_final_obs"])
            for row in np.flatnonzero(my_info["_final_obs"]):
                assert_same(my_info["final_obs"][row], their_info["final_obs"][row])
                for term, values in my_info["final_info"]["reward_terms"].items():
                    told = their_info["final_info"]["reward_terms"][term]
                    assert values[row] == pytest.approx(told[row], abs=1e-12)
    theirs.close()
    ours.close()


def test_a_big_batch_is_its_rows():
    few = vector("sonarbed/Explore-v0", robots=2, world="office", map_patch=16)
    many = vector("sonarbed/Explore-v0", robots=64, world="office", map_patch=16)
    few.reset(seed=30)
    many.reset(seed=30)
    rng = np.random.default_rng(0)
    for _ in range(40):
        actions = rng.uniform(-0.5, 1.0, (64, 2)).astype(np.float32)
        one, other = few.step(actions[:2]), many.step(actions)
        assert_same(one[0], {key: values[:2] for key, values in other[0].items()})
        assert np.array_equal(one[1], other[1][:2])


def test_rows_differ_and_rooms_are_drawn():
    env = vector("sonarbed/Explore-v0", robots=20, world=["office", "clutter"])
    _, info = env.reset(seed=0)
    assert len(np.unique(info["true_pose"], axis=0)) == 20
    rooms = [env.batch.setup_of(row).world.name for row in range(20)]
    assert set(rooms) == {"office", "clutter"}


def test_seeds_may_be_a_list_and_none_goes_on():
    env, again = vector("sonarbed/Navigate-v0"), vector("sonarbed/Navigate-v0")
    first = env.reset(seed=[3, 1, 4, 1, 5])[1]["true_pose"]
    assert np.array_equal(first[1], first[3])
    assert not np.array_equal(first[0], first[1])
    again.reset(seed=[3, 1, 4, 1, 5])
    assert np.array_equal(env.reset()[1]["true_pose"], again.reset()[1]["true_pose"])
    assert not np.array_equal(env.reset()[1]["true_pose"], first)


def test_observations_share_no_memory():
    env = vector("sonarbed/Explore-v0", map_patch=16)
    told = [env.reset(seed=0)[0]]
    told += [env.step(env.action_space.sample())[0] for _ in range(3)]
    for i, one in enumerate(told):
        for other in told[i + 1 :]:
            assert not any(np.shares_memory(one[key], other[key]) for key in one)


def test_observations_are_in_their_space():
    env = vector("sonarbed/Navigate-v0", map_patch=16, limit=20, world=["office", "corridor"])
    env.reset(seed=0)
    for _ in range(50):
        observation, reward, *_ = env.step(env.action_space.sample())
        assert env.observation_space.contains(observation)
        assert np.isfinite(reward).all()


def test_gymnasiums_wrappers_take_it():
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(vector("sonarbed/Navigate-v0", limit=5))
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
        ({"mode": AutoresetMode.DISABLED}, "autoreset_mode must be NextStep or SameStep"),
        ({"render_mode": "rgb_array"}, "render_mode must be None"),
        ({"engine": "segment"}, r"engine 'segment' is unknown; did you mean 'segments'\?"),
        ({"world": "ofice"}, r"did you mean 'office'\?"),
        ({"wrld": "office"}, r"argument 'wrld' is unknown; did you mean 'world'\?"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        vector("sonarbed/Explore-v0", **arguments)


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
    env = vector("sonarbed/Explore-v0")
    env.reset(seed=0)
    with pytest.raises(gymnasium.error.InvalidAction, match=message):
        env.step(actions)


def test_what_comes_at_the_wrong_time_is_refused():
    env = vector("sonarbed/Explore-v0")
    with pytest.raises(gymnasium.error.ResetNeeded, match="before the first step"):
        env.step(env.action_space.sample())
    with pytest.raises(InputError, match=f"seed must have one number a robot, {ROBOTS}, got 2"):
        env.reset(seed=[1, 2])
    with pytest.raises(InputError, match="option 'wrld' is unknown"):
        env.reset(seed=0, options={"wrld": "office"})
    env.close()
    env.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="is closed"):
        env.reset()
