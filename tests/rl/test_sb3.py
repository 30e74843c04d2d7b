"""Stable-Baselines3's own checks; run by `make test-rl`."""

import gymnasium
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecFrameStack, VecMonitor, VecNormalize

import sim  # noqa: F401  registers the environments
from sim.envs.registration import IDS
from sim.envs.sb3 import SB3VecEnv
from sonarmap import InputError

# Of a map smaller than 36 cells Stable-Baselines3 warns: its own network for pictures needs more.
OPTIONS = [
    {},
    {"action": "wheels"},
    {"action": "discrete"},
    {"map_patch": 40},
    {"engine": "bullet"},
    {"sonar": "physical"},
]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("name", IDS)
def test_the_checker_finds_nothing(name, options):
    with gymnasium.make(name, disable_env_checker=True, **options) as env:
        check_env(env.unwrapped, warn=True, skip_render_check=True)


def make(name="Navigate", robots=3, **arguments):
    return gymnasium.make_vec(
        f"sonarbed/{name}-v1",
        num_envs=robots,
        vectorization_mode="vector_entry_point",
        **{"autoreset_mode": "SameStep", **arguments},
    )


def test_the_adapter_does_what_the_vector_environment_does(rng):
    plain, adapted = make(max_episode_steps=7), SB3VecEnv(make(max_episode_steps=7))
    adapted.seed(4)
    first, _ = plain.reset(seed=4)
    for name, rows in adapted.reset().items():
        np.testing.assert_array_equal(rows, first[name])
    for step in range(1, 16):
        actions = rng.uniform(-1, 1, (3, 2)).astype(np.float32)
        expected, reward, terminated, truncated, info = plain.step(actions)
        observations, rewards, dones, infos = adapted.step(actions)
        np.testing.assert_array_equal(rewards, reward.astype(np.float32))
        np.testing.assert_array_equal(dones, terminated | truncated)
        for name, rows in observations.items():
            np.testing.assert_array_equal(rows, expected[name])
        assert dones.all() == (step % 7 == 0)
        for row in np.flatnonzero(dones):
            told = infos[row]
            assert told["TimeLimit.truncated"]
            assert told["is_success"] is False
            # The vector environment's has a mask beside each term.
            terms = {name for name in info["final_info"]["reward_terms"] if name[0] != "_"}
            assert set(told["reward_terms"]) == terms
            for name, value in info["final_obs"][row].items():
                np.testing.assert_array_equal(told["terminal_observation"][name], value)
        assert all(dones[row] or not infos[row] for row in range(3))
    plain.close()
    adapted.close()
    adapted.close()


@pytest.mark.parametrize("name", IDS)
def test_frames_stack_and_are_normalised(name):
    singles = make_vec_env(name, n_envs=2, env_kwargs={"map_patch": 40})
    batch = SB3VecEnv(make(robots=2, map_patch=40))
    for env in (singles, batch):
        stacked = VecFrameStack(env, 4)
        assert stacked.reset()["validity"].shape == (2, 32)
        measured = [key for key in stacked.observation_space.spaces if key != "map"]
        normalised = VecNormalize(stacked, norm_obs_keys=measured)
        assert normalised.reset()["range"].shape == (2, 32)
        normalised.close()


def test_arriving_is_no_time_limit():
    adapted = SB3VecEnv(make(robots=1, world="thesis-exp1", start=(0.5, 1.0, 0.0), goal=(1.2, 1.0)))
    adapted.reset()
    for _ in range(60):
        _, _, dones, infos = adapted.step(np.array([[1.0, 0.0]], np.float32))
        if dones[0]:
            break
    assert infos[0]["is_success"]
    assert not infos[0]["TimeLimit.truncated"]
    adapted.close()


def test_options_reach_the_episodes():
    adapted = SB3VecEnv(make(robots=2))
    adapted.set_options({"start": (0.5, 1.0, 0.0), "goal": (1.2, 1.0)})
    observations = adapted.reset()
    np.testing.assert_allclose(observations["goal"], [[0.07, 1, 0]] * 2, atol=1e-6)
    adapted.set_options([{"goal": (1.2, 1.0)}, {}])
    with pytest.raises(InputError, match="all robots must have the same options"):
        adapted.reset()
    adapted.close()


@pytest.mark.parametrize("arguments", [{}, {"map_patch": 40}, {"action": "discrete"}], ids=str)
def test_ppo_learns_a_little_through_the_adapter(arguments):
    adapted = VecMonitor(SB3VecEnv(make(robots=4, max_episode_steps=10, **arguments)))
    model = PPO("MultiInputPolicy", adapted, n_steps=16, batch_size=32, n_epochs=1, seed=0)
    model.learn(128)
    assert model.num_timesteps == 128
    assert len(model.ep_info_buffer) >= 4
    adapted.close()


@pytest.mark.parametrize(
    ("env", "message"),
    [
        (lambda: make(autoreset_mode="NextStep"), "autoreset_mode"),
        (lambda: gymnasium.make("sonarbed/Navigate-v1"), "must be a vector environment"),
    ],
)
def test_other_environments_are_refused(env, message):
    with pytest.raises(InputError, match=message):
        SB3VecEnv(env())


def test_nothing_is_set_or_called_on_single_robots():
    adapted = SB3VecEnv(make())
    with pytest.raises(InputError, match="cannot be set"):
        adapted.set_attr("anything", 1)
    with pytest.raises(InputError, match="cannot be called"):
        adapted.env_method("anything")
    assert adapted.env_is_wrapped(gymnasium.Wrapper) == [False] * 3
    assert adapted.get_attr("num_envs", indices=[0, 1]) == [3, 3]
    adapted.close()
