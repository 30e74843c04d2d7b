"""The maps of robots by any mapping method that takes readings one at a time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sim.envs.facts import RoomFacts
from sim.envs.maps.grids import MapGrids
from sim.envs.maps.robot_maps import MAP_MODEL, RobotMaps
from sim.envs.specs import described
from sonarmap import GridSpec, InputError, OccupancyMap, SonarLog, SonarRing, method, methods
from sonarmap.methods.bayes.updating import Bayes
from sonarmap.methods.choosing import as_method
from sonarmap.methods.protocol import IncrementalMap
from sonarmap.scores.probabilities import CLAMP

__all__ = ["MAP_METHOD", "MapMethod", "MethodMaps", "map_method", "maps_by"]

MAP_METHOD = Bayes(MAP_MODEL)
"""What environments map by if they are not told otherwise."""


class MapMethod(Protocol):
    """What an environment asks of a mapping method, see `sonarmap.methods.protocol`."""

    def begin(self, ring: SonarRing, grid: GridSpec) -> IncrementalMap:
        """Return an empty map, to which readings are added one at a time."""


def map_method(given: Any) -> MapMethod:
    """Return the mapping method that an environment is given.

    Parameters
    ----------
    given : str, mapping, MappingMethod, its class, or None
        A name of `sonarmap.methods` or ``package.module:Name``; a mapping of its fields with such
        a name as ``type``; the method itself; None for `MAP_METHOD`.

    Raises
    ------
    InputError
        If there is no such method, or it does not take readings one at a time.
    """
    if given is None:
        return MAP_METHOD
    made = given
    if isinstance(given, str):
        made = method(given)
    elif isinstance(given, Mapping):
        name: Any = given.get("type")
        fields = {n: v for n, v in given.items() if n != "type"}
        is_known = isinstance(name, str) and name in methods()
        made = method(name, **fields) if is_known else described("map_method", given)
    elif isinstance(given, type):
        made = as_method(given)
    if isinstance(made, type) or not callable(getattr(made, "begin", None)):
        known = ", ".join(n for n, kind in methods().items() if hasattr(kind, "begin"))
        raise InputError(
            "map_method must take readings one at a time, by .begin(ring, grid), since a robot "
            f"maps as it drives; got {given!r}, which does not (these do: {known})"
        )
    return made  # type: ignore[no-any-return]


def maps_by(
    chosen: MapMethod, robots: int, ring: SonarRing, max_range_m: float, threads: int
) -> MapGrids:
    """Return empty maps by a method: in compiled calls if it is of that kind, else one by one.

    Parameters
    ----------
    chosen : MapMethod
        The method. One that has ``compiled_evidence`` says by it whether it adds the log-odds of
        regions and does nothing else, see `sonarmap.methods.bayes.updating.BayesUpdating`.
    robots, ring, threads
        See `RobotMaps`.
    max_range_m : float
        Longer readings are not mapped.
    """
    offered = getattr(chosen, "compiled_evidence", None)
    evidence = None if offered is None else offered(ring)
    if evidence is None:
        return MethodMaps(robots, ring, chosen, max_range_m)
    return RobotMaps(robots, ring, evidence.model, min(evidence.limit_m, max_range_m), threads)


class MethodMaps(MapGrids):
    """Occupancy maps of robots by any method, robot by robot, each a map of its own.

    A map is looked at after every control step that brings readings: what it states of the cells
    counts, whatever it keeps inside.

    Parameters
    ----------
    robots, ring
        See `RobotMaps`.
    method : MapMethod
        How they are mapped.
    max_range_m : float
        Longer readings are not mapped; what no echo means the method knows.
    """

    def __init__(self, robots: int, ring: SonarRing, method: MapMethod, max_range_m: float) -> None:
        super().__init__(robots)
        self._ring, self._method, self._limit_m = ring, method, max_range_m
        self._built: list[IncrementalMap | None] = [None] * robots
        self._stated: list[NDArray[np.float64] | None] = [None] * robots
        self._spoken: list[NDArray[np.bool_] | None] = [None] * robots
        self._scans = [0] * robots

    def begin(self, row: int, facts: RoomFacts) -> None:
        """Begin an empty map of a room."""
        super().begin(row, facts)
        self._built[row] = self._method.begin(self._ring, facts.grid)
        self._stated[row] = self._map_of(row).probability
        self._spoken[row] = np.zeros(facts.grid.shape, bool)
        self._scans[row] = 0
        self._keep(row, self._map_of(row))

    def add(self, states: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        """Add the readings of the last control step, see `MapGrids.add`."""
        for row in rows.tolist():
            self._maps.gains[row, :2] = 0.0
            readings = self._readings(states[row], self._scans[row])
            if len(readings) == 0:
                continue
            self._scans[row] += 1
            built = self._built[row]
            assert built is not None, "added before begin"
            built.add(readings)
            self._judge(row, self._map_of(row))

    def map_of(self, row: int) -> OccupancyMap:
        """Return one robot's map."""
        return self._map_of(row)

    def _map_of(self, row: int) -> OccupancyMap:
        built, grid = self._built[row], self._facts_of(row).grid
        assert built is not None, "asked before begin"
        made = OccupancyMap.of(built.map)
        if made.grid != grid:
            raise InputError(f"map_method: its map must be on the grid given, got {made.grid}")
        return made

    def _readings(self, state: np.void, scan: int) -> SonarLog:
        """Return what was fired in the last control step, in the order of firing."""
        mapped = ~(np.isfinite(state["range_m"]) & (state["range_m"] > self._limit_m))
        sonar = np.flatnonzero(state["fresh"].astype(bool) & mapped)
        sonar = sonar[np.argsort(state["fired_s"][sonar], kind="stable")]
        x_m, y_m, heading_rad = state["fired_pose"][sonar].T
        return SonarLog(
            ring=self._ring,
            scan=np.full(sonar.size, scan),
            sonar=sonar.astype(np.int16),
            time_s=state["fired_s"][sonar],
            x_m=x_m,
            y_m=y_m,
            heading_rad=heading_rad,
            range_m=state["range_m"][sonar],
        )

    def _judge(self, row: int, made: OccupancyMap) -> None:
        """Note what a map has gained since it was last looked at, as `sonarmap.score_map` does."""
        facts, before, spoken = self._facts_of(row), self._stated[row], self._spoken[row]
        assert before is not None, "judged before begin"
        assert spoken is not None, "judged before begin"
        now, judged = made.probability, facts.sign != 0
        changed = judged & (now != before)
        is_wall = facts.sign[changed] == 1
        gained = _bits(now[changed], is_wall) - _bits(before[changed], is_wall)
        speaks = now != 0.5 if made.observed is None else made.observed
        self._maps.gains[row, 0] = gained.sum()
        self._maps.gains[row, 1] = np.count_nonzero(speaks & ~spoken & judged)
        self._spoken[row], self._stated[row] = spoken | speaks, now
        self._keep(row, made)

    def _keep(self, row: int, made: OccupancyMap) -> None:
        grid = made.grid
        self._maps.log_odds[row, : grid.rows, : grid.cols] = made.log_odds
        free = np.count_nonzero(made.free & self._facts_of(row).reachable)
        self._maps.gains[row, 2] = free


def _bits(probability: NDArray[np.float64], is_wall: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return what cells score, see `sonarmap.MapScore`."""
    of_truth = np.where(is_wall, probability, 1 - probability).clip(CLAMP, 1 - CLAMP)
    bits: NDArray[np.float64] = 1 + np.log2(of_truth)
    return bits
