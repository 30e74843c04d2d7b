"""Drivers: who decides the wheel speeds, knowing only what the robot senses.

A driver is a frozen configuration; `begin` gives the controller of one drive, a function from
what is sensed to wheel speeds that may remember things.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sim import catalogue
from sim.robot import amigobot
from sim.robot.compiled import CONSTANT, FOLLOW, ROUTE, WANDER, CompiledDriver
from sonarmap import InputError, SonarRing
from sonarmap.errors import finite, positive
from sonarmap.registry import Registry
from worlds import Pose, World

__all__ = [
    "DRIVERS",
    "ConstantSpeeds",
    "Controller",
    "Driver",
    "RandomWander",
    "Sensed",
    "WallFollower",
    "Waypoints",
    "driver",
    "names",
    "of",
]

# Turning this fast in place, radians a second; assumed, about half of what the robot can.
_TURN_RADPS = 0.45
# How long a robot backs off after a collision, seconds; assumed.
_BACK_S = 1.5
# A wall follower that has turned this far and found no wall drives on straight.
_GIVE_UP_RAD = math.radians(300)


@dataclass(frozen=True, eq=False)
class Sensed:
    """What the robot knows when it decides.

    Parameters
    ----------
    time_s : float
        Time since the start.
    pose : Pose
        By odometry.
    range_m : ndarray, shape (sonars,)
        The newest reading of each sonar; +inf no echo, -inf too close.
    ring : SonarRing
        Where the sonars are.
    collided : bool
        Whether the robot has touched something since it decided last.
    """

    time_s: float
    pose: Pose
    range_m: NDArray[np.float64]
    ring: SonarRing
    collided: bool

    def nearest_m(self, from_deg: float, to_deg: float) -> float:
        """Return the nearest reading of the sonars that look between two headings.

        Too close counts as 0; +inf if none of them has an echo.
        """
        heading = np.rad2deg(self.ring.heading_rad)
        looks = (heading >= from_deg) & (heading <= to_deg)
        return float(np.maximum(self.range_m[looks], 0).min(initial=math.inf))


Controller = Callable[[Sensed], tuple[float, float]]
"""From what is sensed to the wanted speeds of the left and right wheel, m/s."""


class Driver(Protocol):
    """Decides how a robot drives."""

    def begin(self, rng: np.random.Generator) -> Controller:
        """Return the controller of one drive."""


@dataclass(frozen=True)
class ConstantSpeeds:
    """Drives with constant wheel speeds, by default those of the thesis: a circle.

    Parameters
    ----------
    left_mps, right_mps : float
        Speeds of the wheels, m/s.
    """

    left_mps: float = amigobot.THESIS_LEFT_MPS
    right_mps: float = amigobot.THESIS_RIGHT_MPS

    def __post_init__(self) -> None:
        finite("left_mps", self.left_mps)
        finite("right_mps", self.right_mps)

    def begin(self, rng: np.random.Generator) -> Controller:
        """Return the controller of one drive."""
        return lambda sensed: (self.left_mps, self.right_mps)

    def compiled(self) -> CompiledDriver:
        """Return it as numbers for compiled drives, see `sim.robot.deciding`."""
        return CompiledDriver(CONSTANT, (self.left_mps, self.right_mps))


@dataclass(frozen=True)
class Waypoints:
    """Drives from point to point by odometry, to the last one and back to the first, and so on.

    Parameters
    ----------
    points_m : tuple of (x, y)
        Where to go, metres; at least one.
    speed_mps : float
        Speed on the straight, > 0.
    reached_m : float
        A point counts as reached this near, > 0.
    """

    points_m: tuple[tuple[float, float], ...]
    speed_mps: float = 0.2
    reached_m: float = 0.1

    def __post_init__(self) -> None:
        positive("speed_mps", self.speed_mps)
        positive("reached_m", self.reached_m)
        object.__setattr__(self, "points_m", _checked_points(self.points_m))

    def begin(self, rng: np.random.Generator) -> Controller:
        """Return the controller of one drive."""
        # There and back again: the ends are visited once a round.
        tour = cycle(self.points_m + self.points_m[-2:0:-1])
        target = next(tour)

        def control(sensed: Sensed) -> tuple[float, float]:
            nonlocal target
            dx, dy = _offset(sensed.pose, target)
            if math.hypot(dx, dy) < self.reached_m:
                target = next(tour)
                dx, dy = _offset(sensed.pose, target)
            error = math.remainder(math.atan2(dy, dx) - sensed.pose.heading_rad, math.tau)
            # Turn in place when the point is far off the bow, else steer while driving.
            speed = self.speed_mps * max(0.0, math.cos(error)) ** 3
            return _wheels(speed, max(-_TURN_RADPS, min(_TURN_RADPS, 1.5 * error)))

        return control

    def compiled(self) -> CompiledDriver:
        """Return it as numbers for compiled drives, see `sim.robot.deciding`."""
        numbers = self.speed_mps, self.reached_m, _TURN_RADPS
        return CompiledDriver(
            ROUTE, numbers, points_m=tuple(self.points_m) + tuple(self.points_m[-2:0:-1])
        )


@dataclass(frozen=True)
class WallFollower:
    """Keeps a wall at a distance on one side, by the sonars alone.

    Parameters
    ----------
    distance_m : float
        Wanted distance of the side sonar from the wall, > 0.
    side : {"left", "right"}
        Where the wall is kept.
    speed_mps : float
        Speed along the wall, > 0.
    """

    distance_m: float = 0.45
    side: str = "left"
    speed_mps: float = 0.15

    def __post_init__(self) -> None:
        positive("distance_m", self.distance_m)
        positive("speed_mps", self.speed_mps)
        if self.side not in ("left", "right"):
            raise InputError(f"side must be 'left' or 'right', got {self.side!r}")

    def begin(self, rng: np.random.Generator) -> Controller:
        """Return the controller of one drive."""
        towards = 1 if self.side == "left" else -1
        searching, lost_at_rad, back_until_s = True, 0.0, -1.0

        def control(sensed: Sensed) -> tuple[float, float]:
            nonlocal searching, lost_at_rad, back_until_s
            front_m = sensed.nearest_m(-20, 20)
            beside_m = sensed.nearest_m(*sorted((35 * towards, 95 * towards)))
            if sensed.collided and sensed.time_s >= back_until_s:
                back_until_s = sensed.time_s + _BACK_S
            if sensed.time_s < back_until_s:
                return _wheels(-0.5 * self.speed_mps, -towards * _TURN_RADPS / 2)
            if front_m < self.distance_m or beside_m < 0.5 * self.distance_m:
                searching = False
                return _wheels(0.0, -towards * _TURN_RADPS)
            # A wall at twice the distance is as good as lost, at a corner or an opening: curve
            # towards it; but not in a circle, if there is none.
            error_m = min(beside_m, 2 * self.distance_m) - self.distance_m
            if error_m < self.distance_m:
                searching, lost_at_rad = False, sensed.pose.heading_rad
            elif abs(sensed.pose.heading_rad - lost_at_rad) > _GIVE_UP_RAD:
                searching = True
            turn = 0.0 if searching else towards * max(-0.4, min(0.4, 1.2 * error_m))
            return _wheels(self.speed_mps, turn)

        return control

    def compiled(self) -> CompiledDriver:
        """Return it as numbers for compiled drives, see `sim.robot.deciding`."""
        towards = 1 if self.side == "left" else -1
        numbers = (
            self.distance_m, float(towards), self.speed_mps, _TURN_RADPS, _BACK_S, _GIVE_UP_RAD
        )  # fmt: skip
        low_deg, high_deg = sorted((35.0 * towards, 95.0 * towards))
        return CompiledDriver(FOLLOW, numbers, ((-20.0, 20.0), (low_deg, high_deg)))


@dataclass(frozen=True)
class RandomWander:
    """Drives straight, turns away from what is near, and now and then for no reason.

    Parameters
    ----------
    speed_mps : float
        Speed on the straight, > 0.
    clearance_m : float
        Turns away when something ahead is nearer than this, > 0.
    whim_s : float
        Mean time between turns for no reason, seconds, > 0.
    """

    speed_mps: float = 0.2
    clearance_m: float = 0.45
    whim_s: float = 20.0

    def __post_init__(self) -> None:
        positive("speed_mps", self.speed_mps)
        positive("clearance_m", self.clearance_m)
        positive("whim_s", self.whim_s)

    def begin(self, rng: np.random.Generator) -> Controller:
        """Return the controller of one drive."""
        turning, turn_until_s, back_until_s = 1.0, -1.0, -1.0
        next_whim_s = rng.exponential(self.whim_s)

        def control(sensed: Sensed) -> tuple[float, float]:
            nonlocal turning, turn_until_s, back_until_s, next_whim_s
            now = sensed.time_s
            ahead_m = sensed.nearest_m(-50, 50)
            if sensed.collided and now >= back_until_s:
                # Sonar did not see it coming: back off a little, then turn.
                back_until_s = now + _BACK_S
                turning = float(rng.choice((-1.0, 1.0)))
                turn_until_s = back_until_s + rng.uniform(2.0, 5.0)
            elif now >= turn_until_s and (ahead_m < self.clearance_m or now > next_whim_s):
                left_m, right_m = sensed.nearest_m(35, 95), sensed.nearest_m(-95, -35)
                turning = 1.0 if left_m > right_m else -1.0
                turn_until_s = now + rng.uniform(1.0, 4.0)
                next_whim_s = now + rng.exponential(self.whim_s)
            if now < back_until_s:
                return _wheels(-0.5 * self.speed_mps, 0.0)
            if now < turn_until_s or ahead_m < self.clearance_m:
                return _wheels(0.0, turning * _TURN_RADPS)
            return _wheels(self.speed_mps, 0.0)

        return control

    def compiled(self) -> CompiledDriver:
        """Return it as numbers for compiled drives, see `sim.robot.deciding`."""
        numbers = self.speed_mps, self.clearance_m, self.whim_s, _TURN_RADPS, _BACK_S
        return CompiledDriver(WANDER, numbers, ((-50.0, 50.0), (35.0, 95.0), (-95.0, -35.0)))


STRAIGHT = ConstantSpeeds(0.1, 0.1)
"""Drives straight on at 0.1 m/s."""
FOLLOW_RIGHT = WallFollower(side="right")
"""Keeps the wall on its right."""


def route(world: World) -> Waypoints:
    """Return the driver along the route of a world."""
    if not world.route_m:
        raise InputError(f"driver 'route' needs route_m in the world {world.name!r}, it has none")
    return Waypoints(world.route_m)


def auto(world: World) -> Driver:
    """Return the driver along the route of a world, or, where there is none, one that wanders."""
    return route(world) if world.route_m else RandomWander()


DRIVERS = Registry[Driver | Callable[..., Driver]]("driver", "sonarbed.drivers", catalogue.DRIVERS)
"""A driver, the class of one that is made without arguments, or a function from a world to one."""


def names() -> tuple[str, ...]:
    """Return the names of the drivers that `driver` knows."""
    return tuple(DRIVERS)


def driver(name: str, world: World) -> Driver:
    """Return the driver called `name` for a world.

    Parameters
    ----------
    name : str
        A name of `names`, or ``package.module:Name`` of a driver, of the class of one that is
        made without arguments, or of a function that takes the world and returns one.
    world : World
        The room.

    Raises
    ------
    InputError
        If there is no such driver (with the nearest known name), what the name stands for is
        none, or the world lacks what it needs.
    """
    part = DRIVERS.find(name)
    made: Driver | Callable[..., Driver] = part
    if isinstance(part, type):
        try:
            made = part()
        except TypeError as error:
            raise InputError(f"driver {name!r} must be made without arguments: {error}") from error
    elif callable(part):
        made = part(world)
    return _checked(f"driver {name!r}", made, " or make one")


def of(driver_or_name: str | Driver, world: World) -> Driver:
    """Return the driver of a name, or the driver that was given; see `driver`."""
    if isinstance(driver_or_name, str):
        return driver(driver_or_name, world)
    return _checked("driver", driver_or_name)


def _checked(what: str, made: Any, or_else: str = "") -> Driver:
    if isinstance(made, type) or not hasattr(made, "begin"):
        raise InputError(f"{what} must be a driver{or_else}, got {made!r}")
    return made  # type: ignore[no-any-return]


def _checked_points(points_m: Any) -> tuple[tuple[float, float], ...]:
    """Return places of (x, y) as they are meant: finite numbers, at least one place."""
    if isinstance(points_m, str) or not hasattr(points_m, "__len__"):
        raise InputError(f"points_m must be points (x, y), got {points_m!r}")
    if not len(points_m):
        raise InputError("points_m must have at least one point, got none")
    checked = []
    for place, point in enumerate(points_m):
        if isinstance(point, str) or not hasattr(point, "__len__") or len(point) != 2:
            raise InputError(f"points_m[{place}] must be (x, y) in metres, got {point!r}")
        x_m, y_m = (finite(f"points_m[{place}]", each) for each in point)
        checked.append((x_m, y_m))
    return tuple(checked)


def _offset(pose: Pose, point_m: tuple[float, float]) -> tuple[float, float]:
    return point_m[0] - pose.x_m, point_m[1] - pose.y_m


def _wheels(speed_mps: float, turn_radps: float) -> tuple[float, float]:
    """Return the wheel speeds that give a speed and a turn rate."""
    half = turn_radps * amigobot.TRACK_M / 2
    return speed_mps - half, speed_mps + half
