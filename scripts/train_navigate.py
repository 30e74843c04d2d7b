"""Train a robot with PPO to reach goals in rooms that it sees only by sonar.

It learns in some rooms, mirrored and turned, with sonars, materials and air that differ from
episode to episode, and is judged in rooms that it has never been in. Needs the extra ``rl``:

    pip install -e '.[rl]'
    python scripts/train_navigate.py --minutes 15 --out learning
"""

from __future__ import annotations

import csv
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import count
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import numpy as np
import torch
import typer
from gymnasium.spaces import Dict
from matplotlib.axes import Axes
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

import sim  # noqa: F401  registers the environments
import worlds
from sim.envs import NavigateWeights, write_gif
from sim.envs.policies.policies import Policy, random_policy
from sim.envs.sb3 import SB3VecEnv
from sonarbed.console import as_json, print_table, say
from sonarbed.reporting.drawing import COLOURS, figure_with, save
from sonarmap import InputError
from sonarmap.errors import positive
from sonarmap.files import atomic_path, make_folder

NAVIGATE = "sim:sonarbed/Navigate-v1"
TRAINED_IN = ("thesis-exp1", "thesis-exp2", "clutter", "round-room", "corridor")
JUDGED_IN = ("office", "l-shape")
RANDOMISATION = {
    "materials": ("plaster", "drywall", "wood", "brick", "books", "cardboard"),
    "noise": (0.5, 2.0),
    "temperature_c": (5.0, 35.0),
}

ROBOTS, STEPS_A_ROUND = 256, 32
GAMMA = 0.99
WEIGHTS = NavigateWeights(collision=-0.1, effort=0.0)
# Seeds of what is judged: far from those of the training and of the curve.
CURVE_SEED, JUDGE_SEED, FILM_SEED = 1_000_000, 2_000_000, 3_000_000
CURVE_EPISODES, CURVE_EVERY_S = 100, 20.0
# A film shows every fourth step, as fast as it was.
FILM_EVERY, FILM_FPS, FILM_WAY_M = 4, 2.5, 4.0
FILM_TRIES = 100
# The range that Navigate reports as 1.
GOAL_RANGE_M = 10.0
# Twice the standard deviations between which a normal variable is with 95 % probability.
Z = 1.959964


@dataclass(frozen=True)
class Share:
    """Successes among episodes, with Wilson's 95 % interval."""

    successes: int
    episodes: int

    @property
    def value(self) -> float:
        """The share."""
        return self.successes / self.episodes

    @property
    def interval(self) -> tuple[float, float]:
        """Where the true share lies (Wilson, "Probable inference", 1927)."""
        n, p = self.episodes, self.value
        middle = (p + Z**2 / (2 * n)) / (1 + Z**2 / n)
        half = Z / (1 + Z**2 / n) * math.sqrt(p * (1 - p) / n + Z**2 / (4 * n**2))
        return middle - half, middle + half

    def __add__(self, other: Share) -> Share:
        return Share(self.successes + other.successes, self.episodes + other.episodes)

    def __str__(self) -> str:
        low, high = self.interval
        return f"{self.value:.1%} ({low:.1%} to {high:.1%})"


class NearAndFar(BaseFeaturesExtractor):
    """Shows the network each distance twice: as it is, and stretched where it is near.

    Half a metre is a tenth of what a sonar reaches; it decides whether the robot can pass.

    Parameters
    ----------
    space : Dict
        The observations of Navigate.
    """

    def __init__(self, space: Dict) -> None:
        sizes = {name: math.prod(part.shape or ()) for name, part in space.spaces.items()}
        super().__init__(space, sum(sizes.values()) + sizes["range"] + 1)
        # The environment and the memory of the training do not name them in the same order.
        self._names = sorted(sizes)

    def forward(self, observations: Mapping[str, torch.Tensor]) -> torch.Tensor:
        """Return what the network sees, a row a robot."""
        as_they_are = [observations[name].flatten(1) for name in self._names]
        near = [
            torch.exp(-observations["range"] / 0.1),
            torch.exp(-observations["goal"][:, :1] / 0.1),
        ]
        return torch.cat(as_they_are + near, dim=1)


class Coach(BaseCallback):
    """Ends the training when its time is over, and judges the robot now and then.

    Parameters
    ----------
    seconds : float
        How long to train; judging counts.
    judged : callable
        From a policy to its share of successes.
    """

    def __init__(self, seconds: float, judged: Callable[[Policy], Share]) -> None:
        super().__init__()
        self._seconds, self._judge = seconds, judged
        self._begin_s = time.monotonic()
        self._judged_s = -math.inf
        self.curve: list[dict[str, float]] = []

    @property
    def left_share(self) -> float:
        """What is left of the time, from 1 to 0."""
        return max(0.0, 1.0 - (time.monotonic() - self._begin_s) / self._seconds)

    def _on_rollout_start(self) -> None:
        if time.monotonic() - self._judged_s >= CURVE_EVERY_S:
            self._note()

    def _on_step(self) -> bool:
        return self.left_share > 0

    def _on_training_end(self) -> None:
        if self.curve[-1]["steps"] < self.num_timesteps:
            self._note()

    def _note(self) -> None:
        judged = self._judge(learned(self.model))
        recent = [episode["is_success"] for episode in self.model.ep_info_buffer]
        self._judged_s = time.monotonic()
        point = {
            "steps": self.num_timesteps,
            "minutes": (self._judged_s - self._begin_s) / 60,
            "unseen_rooms": judged.value,
            "unseen_low": judged.interval[0],
            "unseen_high": judged.interval[1],
            "training_rooms": float(np.mean(recent)) if recent else math.nan,
        }
        self.curve.append(point)
        say(
            f"{point['minutes']:5.1f} min  {point['steps']:9,d} steps  "
            f"unseen rooms {judged}  training rooms {point['training_rooms']:.1%}"
        )


def training_rooms() -> list[worlds.World]:
    """Return the rooms to learn in: each in its four turns, and those mirrored."""
    return [
        room.transformed(quarter_turns=turns)
        for name in TRAINED_IN
        for room in (worlds.load(name), worlds.load(name).mirrored())
        for turns in range(4)
    ]


def make(robots: int, **arguments: Any) -> Any:
    """Return that many robots that are to reach goals."""
    return gymnasium.make_vec(
        NAVIGATE,
        num_envs=robots,
        vectorization_mode="vector_entry_point",
        autoreset_mode="SameStep",
        **arguments,
    )


def learned(model: PPO) -> Policy:
    """Return what a model does when it does not try out."""
    return lambda observations: model.predict(observations, deterministic=True)[0]


def straight_on(observations: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
    """Drive straight to the goal and stop before what is in the way: no learning at all."""
    bearing = np.arctan2(observations["goal"][:, 2], observations["goal"][:, 1])
    near = observations["range"][:, 2:4].min(axis=1) < 0.05
    speed = np.where(near, 0.0, np.maximum(np.cos(bearing), 0.0))
    return np.stack([speed, np.clip(2.0 * bearing, -1, 1)], axis=1).astype(np.float32)


def judge(
    act_of: Callable[[Any], Policy], room: str | Sequence[str], *, episodes: int, seed: int
) -> Share:
    """Return in how many episodes a policy reaches its goal; the seed decides start and goal.

    Parameters
    ----------
    act_of : callable
        From the environment to the policy.
    room : str or sequence of str
        Name of the room, or of several, one of which is drawn each episode.
    episodes, seed : int
        How many episodes; episode ``i`` has the seed ``seed + i``.
    """
    env = make(episodes, world=room)
    observations, _ = env.reset(seed=seed)
    act = act_of(env)
    open_, success = np.ones(episodes, bool), np.zeros(episodes, bool)
    while open_.any():
        observations, _, terminated, truncated, info = env.step(act(observations))
        ended = open_ & (terminated | truncated)
        if ended.any():
            success[ended] = info["final_info"]["is_success"][ended]
            open_ &= ~ended
    env.close()
    return Share(int(success.sum()), episodes)


def train(seconds: float, seed: int) -> tuple[PPO, list[dict[str, float]]]:
    """Return a model that was trained for so long, and its learning curve."""
    robots = make(ROBOTS, world=training_rooms(), randomisation=RANDOMISATION, weights=WEIGHTS)
    watched = VecMonitor(SB3VecEnv(robots), info_keywords=("is_success",))
    # Returns near 1 are learned faster than those of a whole way.
    env = VecNormalize(watched, norm_obs=False, gamma=GAMMA)

    def judged(act: Policy) -> Share:
        return judge(lambda env: act, JUDGED_IN, episodes=CURVE_EPISODES, seed=CURVE_SEED)

    coach = Coach(seconds, judged)
    model = PPO(
        "MultiInputPolicy",
        env,
        n_steps=STEPS_A_ROUND,
        batch_size=ROBOTS * STEPS_A_ROUND // 4,
        n_epochs=5,
        gamma=GAMMA,
        ent_coef=0.003,
        # Small steps towards the end, whenever that is.
        learning_rate=lambda _: 1e-3 * max(0.05, coach.left_share),
        policy_kwargs={
            "features_extractor_class": NearAndFar,
            "net_arch": [64, 64],
        },
        stats_window_size=500,
        seed=seed,
        device="cpu",
    )
    model.learn(sys.maxsize, callback=coach)
    env.close()
    return model, coach.curve


def draw_curve(curve: Sequence[Mapping[str, float]], chance: Share, path: Path) -> None:
    """Draw the share of successes over the steps of the training."""
    figure, (axes,) = figure_with(width=7.5)
    steps = np.array([point["steps"] for point in curve]) / 1e6
    columns = {name: np.array([point[name] for point in curve]) * 100 for name in curve[0]}
    rooms = " and ".join(JUDGED_IN)
    axes.fill_between(
        steps, columns["unseen_low"], columns["unseen_high"], color=COLOURS[0], alpha=0.2, lw=0
    )
    axes.plot(
        steps,
        columns["unseen_rooms"],
        "o-",
        color=COLOURS[0],
        ms=4,
        label=f"unseen rooms ({rooms})",
    )
    axes.plot(
        steps, columns["training_rooms"], color=COLOURS[4], label="training rooms, trying out"
    )
    axes.axhline(100 * chance.value, color=COLOURS[1], ls="--", label="random policy, unseen rooms")
    _label(axes, curve[-1]["minutes"])
    save(figure, path)


def _label(axes: Axes, minutes: float) -> None:
    axes.set_title(f"Navigate: PPO for {minutes:.0f} minutes", fontsize=11)
    axes.set_xlabel("control steps of all robots, millions")
    axes.set_ylabel("episodes that reach the goal, %")
    axes.set_ylim(0, 100)
    axes.set_xlim(left=0)
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=9, frameon=False)


def film(act: Policy, path: Path) -> int | None:
    """Film the first episode in an unseen room with a way worth seeing; return its seed.

    That is the first seed whose goal is at least `FILM_WAY_M` from the start and is reached; None
    and no film if none of `FILM_TRIES` is.
    """
    for seed in range(FILM_SEED, FILM_SEED + FILM_TRIES):
        # Frames cost more than driving: first without.
        if drive(act, seed, lambda env: None):
            write_gif(frames_of(act, seed), path, fps=FILM_FPS)
            return seed
    return None


def frames_of(act: Policy, seed: int) -> list[NDArray[np.uint8]]:
    """Return what an episode looks like, every few steps."""
    frames: list[NDArray[np.uint8]] = []
    drive(act, seed, lambda env: frames.append(env.render()))
    return frames


def drive(act: Policy, seed: int, look: Callable[[Any], None]) -> bool:
    """Drive an episode in an unseen room; return whether it is worth seeing.

    `look` is called with the environment at the begin, every few steps and in the end.
    """
    env = gymnasium.make(
        NAVIGATE,
        world=JUDGED_IN[0],
        render_mode="rgb_array",
    )
    observation, _ = env.reset(seed=seed)
    worth = observation["goal"][0] * GOAL_RANGE_M >= FILM_WAY_M
    ended, info = not worth, {"is_success": False}
    look(env)
    for step in count(1):
        if ended:
            break
        many = {name: values[None] for name, values in observation.items()}
        observation, _, terminated, truncated, info = env.step(act(many)[0])
        ended = terminated or truncated
        if ended or step % FILM_EVERY == 0:
            look(env)
    env.close()
    return info["is_success"]


def write_curve(curve: Sequence[Mapping[str, float]], path: Path) -> None:
    """Write the learning curve as CSV."""
    with atomic_path(path) as beside, beside.open("w", newline="") as file:
        writer = csv.DictWriter(file, curve[0].keys())
        writer.writeheader()
        writer.writerows(curve)


def main(
    minutes: Annotated[float, typer.Option(help="How long to train.")] = 15.0,
    seed: Annotated[int, typer.Option(help="Seed of the training.")] = 0,
    episodes: Annotated[
        int, typer.Option(help="Episodes in each unseen room that judge the end.")
    ] = 500,
    out: Annotated[
        Path, typer.Option(help="The folder for the model, the curve, the film and the figures.")
    ] = Path("learning"),
) -> None:
    """Train a robot to reach goals by sonar, and judge it in rooms that it has never been in."""
    positive("--minutes", minutes)
    positive("--episodes", episodes)
    make_folder(out)
    # So small a network gains nothing from more cores; the robots do.
    torch.set_num_threads(1)
    model, curve = train(60 * minutes, seed)
    with atomic_path(out / "model.zip") as beside:
        # The schedule holds the clock of this training.
        model.save(beside, exclude=["learning_rate", "lr_schedule"])
    policies: dict[str, Callable[[Any], Policy]] = {
        "random": lambda env: random_policy(env.action_space, np.random.default_rng(seed)),
        "straight to the goal": lambda env: straight_on,
        "PPO": lambda env: learned(model),
    }
    shares = {
        name: {room: judge(act_of, room, episodes=episodes, seed=JUDGE_SEED) for room in JUDGED_IN}
        for name, act_of in policies.items()
    }
    both = {
        name: sum(list(rooms.values())[1:], start=rooms[JUDGED_IN[0]])
        for name, rooms in shares.items()
    }
    write_curve(curve, out / "curve.csv")
    draw_curve(curve, both["random"], out / "curve.png")
    film_seed = film(learned(model), out / "film.gif")
    results = {
        "minutes": minutes,
        "seed": seed,
        "steps": model.num_timesteps,
        "film_seed": film_seed,
        "shares": {
            name: {room: asdict(share) for room, share in rooms.items()}
            for name, rooms in shares.items()
        },
    }
    with atomic_path(out / "results.json") as beside:
        beside.write_text(as_json(results) + "\n")
    print_table(
        f"Episodes that reach the goal, {episodes} a room, after {model.num_timesteps:,} steps",
        ["policy", *JUDGED_IN, "both"],
        [
            [name, *(str(share) for share in rooms.values()), str(both[name])]
            for name, rooms in shares.items()
        ],
    )


if __name__ == "__main__":
    try:
        typer.run(main)
    except InputError as error:
        sys.exit(f"train_navigate: {error}")
