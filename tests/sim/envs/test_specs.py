"""Specifications survive JSON with every argument, and what JSON cannot hold is said."""

import dataclasses
import json
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from sameness import assert_same

import sim
from sim.envs import ExploreWeights, NavigateWeights, Randomisation
from sim.envs.registration import FORMER_IDS, IDS
from sim.envs.tasks.navigate import Navigate
from sim.sonar.presets import ARIA, THESIS
from sonarmap import AMIGOBOT, InputError, SonarRing
from worlds import Pose, load

RING = SonarRing("three", [0.1, 0.0, 0.0], [0, 0.1, -0.1], [0, 1.5, -1.5], 0.26, 0.1, 4.0)
ARGUMENTS = {
    "nothing": {},
    "what stays": {
        "action": "discrete",
        "map_patch": np.int64(20),
        "control_s": 0.2,
        "map_resolution_m": np.float32(0.125),
        "map_range_m": 2.5,
        "validity": "multibinary",
        "threads": 1,
        "render_mode": "rgb_array",
    },
    "rooms by name": {"world": ["office", "clutter"]},
    "rooms": {"world": (load("office"), load("l-shape"))},
    "a set of rooms": {"world": {"office", "clutter", "l-shape", "corridor"}},
    "a sonar by name": {"sonar": "webots"},
    "a sonar that ships": {"sonar": THESIS},
    "a cone": {"sonar": ARIA.replace(noise_std_m=0.05, rays=5, name="blurred")},
    "a ring of three": {"sonar": ARIA.replace(ring=RING)},
    "a physical sonar": {
        "sonar": sim.PhysicalSonar(
            "mine",
            AMIGOBOT,
            firing=sim.Eeruf(order=(3, 1, 2, 0)),
            air=sim.Air(temperature_c=5),
            interferers=(sim.Interferer(1.0, 1.0, 0.5),),
        )
    },
    "odometry": {"odometry": sim.OdometryModel(slip_std_m=0.02, ticks_per_turn=500)},
    "odometry by fields": {"odometry": {"slip_std_m": 0.02, "ticks_per_turn": np.int32(500)}},
    "what is drawn": {
        "randomisation": Randomisation(("metal", "foam"), noise=(1, 3), temperature_c=(0, 9.5))
    },
    "what is drawn, by fields": {
        "randomisation": {"materials": {"wood", "metal", "foam"}, "noise": np.array([1, 3])}
    },
    "a start": {"world": "office", "start": (2.0, 3.0, 0.5)},
    "a pose": {"world": "office", "start": Pose(2.0, 3.0, 0.5)},
    "its start": {"start": "world"},
}


def begun(env, steps=4):
    """Return what an environment says in its first steps."""
    env.action_space.seed(1)
    told = [env.reset(seed=5)]
    return (*told, *(env.step(env.action_space.sample()) for _ in range(steps)))


def again(spec):
    text = spec.to_json()
    json.loads(text)
    return EnvSpec.from_json(text)


@pytest.mark.parametrize("arguments", ARGUMENTS)
@pytest.mark.parametrize("name", [IDS[1], FORMER_IDS[1]])
def test_a_specification_makes_its_environment_again(name, arguments):
    env = gymnasium.make(name, **ARGUMENTS[arguments])
    other = gymnasium.make(again(env.spec))
    assert other.observation_space == env.observation_space
    told = begun(env)
    assert_same(begun(other), told)
    # And the other's, and without JSON.
    assert again(other.spec).to_json() == other.spec.to_json() == env.spec.to_json()
    assert_same(begun(gymnasium.make(env.spec)), told)
    assert gymnasium.make(other.spec).spec == other.spec


@pytest.mark.parametrize("arguments", ARGUMENTS)
def test_that_of_a_vector_environment_does_too(arguments):
    env = gymnasium.make_vec(
        IDS[0], num_envs=2, autoreset_mode="SameStep", max_episode_steps=3, **ARGUMENTS[arguments]
    )
    other = gymnasium.make_vec(again(env.spec))
    assert other.num_envs == 2
    assert other.metadata == env.metadata
    assert_same(begun(other), begun(env))


@pytest.mark.parametrize(
    ("name", "weights"),
    [
        ("Explore", ExploreWeights(area=0.5)),
        ("Explore", {"area": 0.5}),
        ("Navigate", NavigateWeights(time=-1.0)),
        ("FollowWall", {"following": np.float32(2.0), "effort": 0}),
    ],
)
def test_weights_survive(name, weights):
    env = gymnasium.make(f"sonarbed/{name}-v1", weights=weights)
    told = begun(env)
    assert_same(begun(gymnasium.make(again(env.spec))), told)
    terms, plain = told[1][4]["reward_terms"], gymnasium.make(f"sonarbed/{name}-v1")
    assert begun(plain)[1][4]["reward_terms"] == terms
    assert begun(plain)[1][1] != told[1][1]


def test_a_room_in_a_file_survives(tmp_path):
    text = Path(load.__code__.co_filename).with_name("rooms").joinpath("office.toml").read_text()
    file = tmp_path / "mine.toml"
    file.write_text(text)
    env = gymnasium.make(IDS[0], world=file)
    assert json.loads(env.spec.to_json())["kwargs"]["world"] == str(file)
    assert_same(begun(gymnasium.make(again(env.spec))), begun(env))


class Own(Navigate):
    """A task of one's own."""


def test_a_task_of_ones_own_survives():
    env = gymnasium.make("sonarbed/Task-v1", task=Own)
    other = gymnasium.make(again(env.spec))
    assert isinstance(other.unwrapped.batch.task, Own)
    assert_same(begun(other), begun(env))


class Loud:
    """A sonar that is no dataclass."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(ARIA, name)


@dataclasses.dataclass(frozen=True)
class _Hidden(sim.ConeSonar):
    """Found by no name once it is replaced below."""


Found, _Hidden = _Hidden, None


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        (
            IDS[0],
            {"world": load("office").mirrored()},
            "world cannot be kept .* 'office' was given as a World of its own",
        ),
        (IDS[0], {"world": ["l-shape", load("office").mirrored()]}, r"world\[1\] cannot be kept"),
        (IDS[0], {"sonar": Loud()}, "sonar cannot be kept in a specification: JSON holds"),
        (
            IDS[0],
            {"sonar": Found("hidden", AMIGOBOT, 0.1)},
            "sonar cannot be kept .*_Hidden cannot be imported by its name",
        ),
    ],
)
def test_what_json_cannot_hold_is_said(name, arguments, message):
    env = gymnasium.make(name, **arguments)
    with pytest.raises(InputError, match=message):
        env.spec.to_json()
    # Without JSON it can.
    assert_same(begun(gymnasium.make(env.spec)), begun(env))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"weights": {"map_skore": 1}}, "weights 'map_skore' is unknown; did you mean 'map_score'"),
        ({"weights": {"area": "0.1"}}, "weights.area must be a number, got '0.1'"),
        ({"weights": {"area": True}}, "weights.area must be a number, got True"),
        ({"weights": ExploreWeights(area=float("nan"))}, "weights.area must be a finite number"),
        ({"weights": NavigateWeights()}, "weights must be ExploreWeights or a mapping of its"),
        ({"weights": 3}, "weights must be ExploreWeights or a mapping of its fields, got 3"),
        ({"odometry": {"slip": 1}}, "odometry 'slip' is unknown"),
        ({"odometry": {"slip_std_m": "1"}}, "odometry.slip_std_m must be a number, got '1'"),
        ({"odometry": {"slip_std_m": -1.0}}, "slip_std_m must be >= 0, got -1.0"),
        ({"odometry": {"ticks_per_turn": 1.5}}, "odometry.ticks_per_turn must be a whole number"),
        ({"odometry": 0.1}, "odometry must be OdometryModel or a mapping of its fields, got 0.1"),
        ({"randomisation": ["noise"]}, "randomisation must be Randomisation or a mapping"),
        ({"randomisation": {"materials": "wood"}}, "materials must be a sequence of names"),
        ({"randomisation": {"materials": [3]}}, "material 3 is unknown"),
        ({"randomisation": {"noise": ("1", "2")}}, "noise must be two numbers"),
        ({"randomisation": {"noise": 2}}, "noise must be two numbers, .* got 2"),
        ({"sonar": {"ring": "amigobot"}}, "sonar given as a mapping must have the key 'type'"),
        ({"sonar": {"type": "sim:Sonnar"}}, "sonar 'sim:Sonnar' cannot be imported"),
        ({"sonar": {"type": "sim:ConeSonar"}}, "sonar 'sim:ConeSonar' needs the parameter 'name'"),
        ({"sonar": {"type": "sim:simulate"}}, "sonar 'sim:simulate' must be a dataclass"),
        ({"sonar": {"type": "sim:Air"}}, "sonar must be the name of a preset or a sonar"),
        ({"sonar": 3}, "sonar must be the name of a preset or a sonar, got 3"),
        ({"world": 3}, "world must be the name of a room, a file, a World or a sequence"),
        ({"world": {"office": 1}}, "world must be the name of a room, a file"),
        ({"world": ["office", None]}, "world must be the name of a room, a file"),
    ],
)
def test_values_of_other_kinds_are_refused_by_name(arguments, message):
    with pytest.raises(InputError, match=message):
        gymnasium.make(IDS[0], **arguments)


def test_minari_makes_the_environment_again(tmp_path, monkeypatch):
    minari = pytest.importorskip("minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr("warnings.warn", lambda *args, **kwargs: None)
    arguments = {
        "weights": {"arrival": 2.0},
        "odometry": sim.OdometryModel(slip_std_m=0.01),
        "randomisation": Randomisation(("metal", "foam")),
        "world": load("office"),
        "sonar": ARIA.replace(noise_std_m=0.01),
        "max_episode_steps": 5,
    }
    env = gymnasium.make(IDS[1], **arguments)
    policy = sim.envs.random_policy(env.action_space, np.random.default_rng(0))
    sim.envs.record_minari(env, policy, "sonarbed/whole-v0", episodes=1, seed=3)
    made = minari.load_dataset("sonarbed/whole-v0").recover_environment()
    assert_same(begun(made), begun(env))
