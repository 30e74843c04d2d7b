"""Environments are made from their tasks: those that ship, and a person's own."""

import importlib.metadata
import pickle
from dataclasses import dataclass

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box

import sim
from sim.envs import Evaluation, SonarEnv, SonarVectorEnv, StepOutcome, Task, TaskSetup
from sim.envs.environments import env_class, vector_env_class
from sim.envs.registration import IDS
from sim.envs.tasks.registry import TASKS
from sonarmap import InputError


@dataclass(frozen=True, slots=True)
class SpinWeights:
    turn: float = 2.0


class Spin(Task):
    """Turn on the spot.

    Terms of the reward
    -------------------
    ``turn``: radians to the left in this step.
    """

    weights_class = SpinWeights
    max_episode_steps = 7
    observations = {"far": Box(0.0, 10.0, (1,), np.float32)}  # noqa: RUF012 - as in the base

    def __init__(self, robots, weights=None):
        super().__init__(robots, weights)
        self.heading_rad = np.zeros(robots)
        self.start_m = np.zeros((robots, 2))

    def begin(self, row: int, setup: TaskSetup):
        self.heading_rad[row] = setup.start.heading_rad
        self.start_m[row] = setup.start.x_m, setup.start.y_m

    def observe(self, states):
        far_m = np.hypot(*(states["true_pose"][:, :2] - self.start_m).T)
        return {"far": far_m[:, None].astype(np.float32)}

    def evaluate(self, outcome: StepOutcome) -> Evaluation:
        heading_rad = outcome.states["true_pose"][:, 2].copy()
        terms = {"turn": heading_rad - self.heading_rad}
        self.heading_rad = heading_rad
        return self.evaluation(terms, outcome.stuck, heading_rad=heading_rad)


@pytest.fixture
def spin(mine):
    mine.Spin = Spin
    return "mine:Spin"


def test_every_task_that_ships_is_an_environment():
    assert list(TASKS) == ["Explore", "Navigate", "FollowWall"]
    for name, identity in zip(TASKS, IDS, strict=True):
        spec = gymnasium.spec(identity)
        assert spec.entry_point == f"sim.envs.environments:{name}Env"
        assert spec.vector_entry_point == f"sim.envs.environments:{name}VectorEnv"
        assert spec.max_episode_steps == TASKS[name].max_episode_steps
        single = getattr(sim.envs, f"{name}Env")
        assert single is env_class(TASKS[name])
        assert getattr(sim.envs, f"{name}VectorEnv") is vector_env_class(TASKS[name])
        assert issubclass(single, SonarEnv)


@pytest.mark.parametrize("name", ["ExploreEnv", "FollowWallVectorEnv"])
def test_the_classes_pickle(name):
    made = getattr(sim.envs, name)
    assert (made.__module__, made.__qualname__) == ("sim.envs.environments", name)
    assert pickle.loads(pickle.dumps(made)) is made


def test_the_docstring_is_the_task_and_what_all_have_in_common():
    doc = sim.envs.NavigateEnv.__doc__
    assert doc.startswith("Reach a goal in a room that is seen only by sonar.\n\nObservation of")
    assert "Terms of the reward (weights: `NavigateWeights`)" in doc
    assert "``last_action``" in doc
    assert doc.count("\nParameters\n") == 1


def test_there_are_no_other_environments():
    import sim.envs.environments as environments

    with pytest.raises(AttributeError, match="has no attribute 'DanceEnv'"):
        _ = environments.DanceEnv


def test_a_task_of_ones_own_is_made_by_its_module(spin):
    env = gymnasium.make("sim:sonarbed/Task-v1", task=spin, world="office", action="wheels")
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    assert observation["far"].shape == (1,)
    rewards, turned = [], []
    for step in range(1, 8):
        _, reward, terminated, truncated, info = env.step(np.array([-0.2, 0.2], np.float32))
        rewards.append(reward)
        turned.append(info["reward_terms"]["turn"])
        assert not terminated
        assert truncated == (step == 7)  # the task's own limit
    assert rewards == pytest.approx(2 * np.array(turned))
    assert sum(turned) > 0.1
    # Its specification makes it again.
    again = gymnasium.make(env.spec)
    assert again.unwrapped.batch.task.__class__ is Spin
    assert again.spec.to_json() == env.spec.to_json()


def test_its_weights_and_its_class_may_be_given(spin):
    env = gymnasium.make("sim:sonarbed/Task-v1", task=Spin, weights=SpinWeights(turn=0.0))
    env.reset(seed=0)
    assert env.step(np.ones(2, np.float32))[1] == 0.0


def test_many_of_it_do_what_one_does(spin):
    single = gymnasium.make("sim:sonarbed/Task-v1", task=spin, world="office")
    many = gymnasium.make_vec(
        "sim:sonarbed/Task-v1",
        num_envs=3,
        vectorization_mode="vector_entry_point",
        task=spin,
        world="office",
    )
    assert isinstance(many, SonarVectorEnv)
    single.reset(seed=2)
    many.reset(seed=0)
    action = np.array([0.1, 0.5], np.float32)
    for step in range(1, 8):
        one, rows = single.step(action), many.step(np.tile(action, (3, 1)))
        assert rows[1][2] == one[1]
        assert rows[0]["far"][2] == one[0]["far"]
        assert rows[3].tolist() == [step == 7] * 3


@pytest.mark.parametrize(
    ("task", "message"),
    [
        ("Explor", r"task 'Explor' is unknown; did you mean 'Explore'\?"),
        ("mine:Nothing", "task 'mine:Nothing' cannot be imported: 'mine' has no 'Nothing'"),
        ("sim:Air", "task 'sim:Air' must be a subclass of sim.envs.Task, got"),
    ],
)
def test_what_is_no_task_is_refused(mine, task, message):
    with pytest.raises(InputError, match=message):
        gymnasium.make("sim:sonarbed/Task-v1", task=task)


def test_the_task_of_an_installed_package_has_an_environment(spin, monkeypatch):
    entry = importlib.metadata.EntryPoint("Spin", spin, "sonarbed.tasks")
    monkeypatch.setattr(
        "sonarmap.registry.entry_points",
        lambda group: [entry] if group == "sonarbed.tasks" else [],
    )
    monkeypatch.setattr("sim.envs.registration.register", register := Registered())
    sim.envs.registration.register_all()
    assert register.made["sonarbed/Spin-v1"]["kwargs"] == {"task": "Spin"}
    former = register.made["sonarbed/Spin-v0"]["kwargs"]
    assert former == {"task": "Spin", "validity": "multibinary"}
    env = sim.envs.environments.task_env(**register.made["sonarbed/Spin-v1"]["kwargs"])
    assert isinstance(env.unwrapped.batch.task, Spin)
    assert sim.envs.environments.SpinEnv is env_class(Spin)


class Registered:
    """Stands in for Gymnasium's registry, which has ours already."""

    def __init__(self):
        self.made = {}

    def __call__(self, identity, **arguments):
        self.made[identity] = arguments


def test_former_names_stay():
    assert sim.envs.TeamSpec is sim.envs.BatchSpec
    env = sim.envs.ExploreEnv()
    assert env.team is env.batch
