"""`EpisodeOptions`: what may differ from episode to episode, and how an episode is drawn."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

import worlds
from sim.envs.backends.protocol import EpisodeSetup
from sim.envs.facts import RoomFacts, facts_of
from sim.envs.specs import described
from sim.envs.tasks.task import TaskSetup
from sim.envs.values import check_names, in_order, value_of
from sim.robot.amigobot import BODY_RADIUS_M
from sim.robot.odometry import OdometryModel
from sim.sonar import presets as sonars
from sim.sonar.air import Air
from sim.sonar.carried import with_ring
from sim.sonar.protocol import Sonar
from sonarmap import InputError, SonarRing
from sonarmap.errors import did_you_mean, finite, positive
from worlds import MATERIALS, Pose, World

__all__ = ["EpisodeOptions", "Randomisation", "draw_episode"]

WorldChoice = str | Path | World
RingChoice = str | Path | SonarRing | Mapping[str, Any]


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
        if isinstance(self.materials, str | Mapping) or not isinstance(self.materials, Iterable):
            raise InputError(f"materials must be a sequence of names, got {self.materials!r}")
        object.__setattr__(self, "materials", in_order(self.materials))
        for name in self.materials:
            if not isinstance(name, str) or name not in MATERIALS:
                raise InputError(
                    f"material {name!r} is unknown{did_you_mean(str(name), MATERIALS)}"
                )
        for name in ("noise", "temperature_c"):
            object.__setattr__(self, name, _ordered_pair(name, getattr(self, name)))
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
    sonar : str, Sonar or mapping
        A name that `sim.sonar.presets.preset` knows, a sonar, or one as a specification keeps it
        (`sim.envs.specs.described`).
    ring : str, Path, SonarRing or mapping, optional
        Another ring for the sonar, whatever the sonar is, see `sim.sonar.carried.with_ring`.
    odometry : OdometryModel or mapping of its fields, optional
        Errors of the odometry, by default the AmigoBot's.
    start : str, Pose or (float, float, float)
        "random" (anywhere in the room), "world" (the room's own start) or x, y in metres and
        heading in radians.
    goal : str or (float, float)
        "random" or x, y in metres, for tasks with a goal.
    randomisation : Randomisation or mapping of its fields, optional
        What is drawn anew each episode; by default nothing.
    """

    world: WorldChoice | Sequence[WorldChoice] = "thesis-exp1"
    sonar: str | Sonar | Mapping[str, Any] = "aria"
    ring: RingChoice | None = None
    odometry: OdometryModel | Mapping[str, Any] | None = None
    start: str | Pose | tuple[float, float, float] = "random"
    goal: str | tuple[float, float] = "random"
    randomisation: Randomisation | Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        def accept(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        accept("world", _loaded(self.world))
        ring = described("ring", self.ring) if isinstance(self.ring, Mapping) else self.ring
        accept("ring", ring)
        accept("sonar", with_ring(_sonar(self.sonar), ring))
        accept("start", _place("start", self.start, 3, ("random", "world")))
        accept("goal", _place("goal", self.goal, 2, ("random",)))
        for name, kind in (("odometry", OdometryModel), ("randomisation", Randomisation)):
            given = getattr(self, name)
            # A field of a randomisation is no number: it checks itself.
            accept(name, value_of(name, kind, {} if given is None else given))

    def updated(self, options: Mapping[str, Any] | None) -> EpisodeOptions:
        """Return these options with some replaced.

        Raises
        ------
        InputError
            If there is no such option or its value breaks its rule.
        """
        if options is None or options == {}:
            return self
        if not isinstance(options, Mapping):
            raise InputError(f"options must be a mapping of their names, got {options!r}")
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
    start = _start(options.start, facts, rng)  # type: ignore[arg-type]
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


def _loaded(choice: Any) -> tuple[World, ...]:
    chosen: tuple[Any, ...] = ()
    if isinstance(choice, WorldChoice):
        chosen = (choice,)
    elif isinstance(choice, Iterable) and not isinstance(choice, Mapping | bytes):
        chosen = in_order(choice)
        if not chosen:
            raise InputError("world must name at least one room, got none")
    if not chosen or not all(isinstance(room, WorldChoice) for room in chosen):
        raise InputError(
            f"world must be the name of a room, a file, a World or a sequence of them, "
            f"got {choice!r}"
        )
    return tuple(room if isinstance(room, World) else worlds.load(room) for room in chosen)


def _sonar(given: Any) -> Sonar:
    sonar = given
    if isinstance(given, str):
        sonar = sonars.preset(given)
    elif isinstance(given, Mapping):
        sonar = described("sonar", given)
    for need in ("name", "ring", "firing", "array", "compiled"):
        if isinstance(sonar, type) or not hasattr(sonar, need):
            raise InputError(f"sonar must be the name of a preset or a sonar, got {given!r}")
    return sonar  # type: ignore[no-any-return]


def _place(name: str, value: Any, size: int, words: tuple[str, ...]) -> Any:
    if isinstance(value, Pose):
        value = (value.x_m, value.y_m, value.heading_rad)
    if isinstance(value, str):
        if value in words:
            return value
    elif (numbers := _numbers(value, size)) is not None:
        return numbers
    known = " or ".join([*map(repr, words), f"{size} finite numbers"])
    raise InputError(f"{name} must be {known}, got {value!r}")


def _ordered_pair(name: str, value: Any) -> tuple[float, float]:
    match _numbers(value, 2):
        case (low, high) if low <= high:
            return low, high
    raise InputError(f"{name} must be two numbers, the lower one first, got {value!r}")


def _numbers(value: Any, size: int) -> tuple[float, ...] | None:
    """Return so many finite numbers in their order, None if it is anything else."""
    if not isinstance(value, Iterable) or isinstance(value, str | Mapping | set | frozenset):
        return None
    try:
        numbers = tuple(finite("number", number) for number in value)
    except InputError:
        return None
    return numbers if len(numbers) == size else None
