"""`EpisodeOptions`: what may differ from episode to episode, and how an episode is drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

import worlds
from sim.envs.backends.protocol import EpisodeSetup
from sim.envs.facts import RoomFacts, facts_of
from sim.envs.tasks.task import TaskSetup
from sim.robot.amigobot import BODY_RADIUS_M
from sim.robot.odometry import OdometryModel
from sim.sonar import presets as sonars
from sim.sonar.air import Air
from sim.sonar.protocol import Sonar
from sonarmap import InputError
from sonarmap.errors import did_you_mean, positive
from worlds import MATERIALS, Pose, World

__all__ = ["EpisodeOptions", "Randomisation", "check_names", "draw_episode"]

WorldChoice = str | Path | World


@dataclass(frozen=True)
class Randomisation:
    """What is drawn anew for each episode, so that no one room or robot is learned by heart.

    Parameters
    ----------
    materials : tuple of str
        Names of `worlds.MATERIALS`; each solid gets one of them. Empty: the world's own.
    noise : (float, float)
        The noise of the sonars is multiplied by a number between these, > 0.
    temperature_c : (float, float)
        The air is between so many degrees Celsius; the robot goes on assuming 20.
    """

    materials: tuple[str, ...] = ()
    noise: tuple[float, float] = (1.0, 1.0)
    temperature_c: tuple[float, float] = (20.0, 20.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "materials", tuple(self.materials))
        for name in self.materials:
            if name not in MATERIALS:
                raise InputError(f"material {name!r} is unknown{did_you_mean(name, MATERIALS)}")
        for name in ("noise", "temperature_c"):
            _ordered_pair(name, getattr(self, name))
        positive("noise[0]", self.noise[0])
        for temperature_c in self.temperature_c:
            Air(temperature_c=temperature_c)


@dataclass(frozen=True)
class EpisodeOptions:
    """What may differ from episode to episode.

    Parameters
    ----------
    world : str, Path, World or a sequence of them
        Name of a room (`worlds.names`), file or room; of several, one is drawn each episode.
    sonar : str or Sonar
        A name that `sim.sonar.presets.preset` knows, or a sonar.
    odometry : OdometryModel, optional
        Errors of the odometry, by default the AmigoBot's.
    start : str or (float, float, float)
        "random" (anywhere in the room), "world" (the room's own start) or x, y in metres and
        heading in radians.
    goal : str or (float, float)
        "random" or x, y in metres, for tasks with a goal.
    randomisation : Randomisation or mapping of its fields, optional
        What is drawn anew each episode; by default nothing.
    """

    world: WorldChoice | Sequence[WorldChoice] = "thesis-exp1"
    sonar: str | Sonar = "aria"
    odometry: OdometryModel | None = None
    start: str | tuple[float, float, float] = "random"
    goal: str | tuple[float, float] = "random"
    randomisation: Randomisation | Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "world", _loaded(self.world))
        if isinstance(self.sonar, str):
            object.__setattr__(self, "sonar", sonars.preset(self.sonar))
        if self.odometry is None:
            object.__setattr__(self, "odometry", OdometryModel())
        object.__setattr__(self, "start", _place("start", self.start, 3, ("random", "world")))
        object.__setattr__(self, "goal", _place("goal", self.goal, 2, ("random",)))
        if not isinstance(self.randomisation, Randomisation):
            known = [field.name for field in fields(Randomisation)]
            given = self.randomisation or {}
            check_names("randomisation", given, known)
            drawn = Randomisation(**given)
            object.__setattr__(self, "randomisation", drawn)

    def updated(self, options: Mapping[str, Any] | None) -> EpisodeOptions:
        """Return these options with some replaced.

        Raises
        ------
        InputError
            If there is no such option or its value breaks its rule.
        """
        if not options:
            return self
        check_names("option", options, [field.name for field in fields(self)])
        return replace(self, **options)


def draw_episode(
    options: EpisodeOptions, resolution_m: float, rng: np.random.Generator
) -> tuple[EpisodeSetup, TaskSetup]:
    """Draw an episode: what the backend and what the task begin with.

    Parameters
    ----------
    options : EpisodeOptions
        What may be drawn.
    resolution_m : float
        Side of a map's cell, metres.
    rng : numpy.random.Generator
        The only source of what is drawn, now and during the episode.
    """
    # A stream each, so that one does not shift when another draws more.
    noise_rng, slip_rng, task_rng = rng.spawn(3)
    rooms: tuple[World, ...] = options.world  # type: ignore[assignment]
    world = rooms[rng.integers(len(rooms))]
    facts = facts_of(world, resolution_m)
    start = _start(options.start, facts, rng)
    drawn: Randomisation = options.randomisation  # type: ignore[assignment]
    sonar = _randomised(options.sonar, drawn, rng)  # type: ignore[arg-type]
    if drawn.materials:
        names = rng.choice(drawn.materials, len(world.solids))
        world = world.with_materials([MATERIALS[name] for name in names])
    odometry: OdometryModel = options.odometry  # type: ignore[assignment]
    setup = EpisodeSetup(world, start, sonar, odometry, noise_rng, slip_rng)
    return setup, TaskSetup(facts, start, options.goal, task_rng)


def _start(
    wanted: str | tuple[float, float, float], facts: RoomFacts, rng: np.random.Generator
) -> Pose:
    if wanted == "random":
        return facts.random_start(rng)
    start = facts.world.start if isinstance(wanted, str) else Pose(*wanted)
    if not facts.world.has_room_at(start.x_m, start.y_m, radius_m=BODY_RADIUS_M):
        raise InputError(
            f"start of ({start.x_m:g}, {start.y_m:g}) m must leave the robot (radius "
            f"{BODY_RADIUS_M} m) clear of every solid of {facts.world.name!r}"
        )
    return start


def _randomised(sonar: Sonar, drawn: Randomisation, rng: np.random.Generator) -> Sonar:
    noise, temperature_c = rng.uniform(*drawn.noise), rng.uniform(*drawn.temperature_c)
    if (noise, temperature_c) == (1.0, 20.0):
        return sonar
    return sonar.randomised(noise, Air(temperature_c=temperature_c))


def _loaded(choice: WorldChoice | Sequence[WorldChoice]) -> tuple[World, ...]:
    chosen = (choice,) if isinstance(choice, WorldChoice) else tuple(choice)
    if not chosen:
        raise InputError("world must name at least one room, got none")
    return tuple(room if isinstance(room, World) else worlds.load(room) for room in chosen)


def _place(name: str, value: Any, size: int, words: tuple[str, ...]) -> Any:
    if isinstance(value, str):
        if value in words:
            return value
    else:
        try:
            numbers = tuple(float(number) for number in value)
        except (TypeError, ValueError):
            numbers = ()
        if len(numbers) == size and all(map(math.isfinite, numbers)):
            return numbers
    known = " or ".join([*map(repr, words), f"{size} finite numbers"])
    raise InputError(f"{name} must be {known}, got {value!r}")


def _ordered_pair(name: str, value: tuple[float, float]) -> None:
    try:
        low, high = (float(number) for number in value)
    except (TypeError, ValueError):
        low, high = math.nan, math.nan
    if not low <= high:
        raise InputError(f"{name} must be two numbers, the lower one first, got {value!r}")


def check_names(what: str, given: Mapping[str, Any], known: list[str]) -> None:
    """Raise `InputError` if a name that is given is none of the known ones."""
    for name in given:
        if name not in known:
            raise InputError(f"{what} {name!r} is unknown{did_you_mean(str(name), known)}")
