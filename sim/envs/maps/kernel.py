"""Compiled: the maps of many robots grow, are scored as they grow, and are seen from the robot."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.fusion import Cone, GridCells, RegionArrays, cone_evidence
from sonarmap.kernels.jit import njit
from sonarmap.occupancy import FREE_UP_TO
from sonarmap.scores.probabilities import CLAMP

__all__ = [
    "FREE",
    "HIDDEN",
    "OCCUPIED",
    "REACHABLE",
    "Cones",
    "Maps",
    "Readings",
    "add_fresh",
    "fresh_echoes",
    "see_patches",
]

# What a cell is in truth.
HIDDEN, OCCUPIED, FREE, REACHABLE = range(4)
# A map's cell counts as free below this.
_FREE_LOG_ODDS = math.log(FREE_UP_TO / (1 - FREE_UP_TO))
# Bits of a cell (see `sonarmap.MapScore`) by the log-odds of its true state, as a table with
# linear steps between: within 1e-6 of the formula, and many times faster.
_LIMIT = math.log((1 - CLAMP) / CLAMP)
_PER_UNIT = 512.0
_BITS = 1 + np.log2(
    1 / (1 + np.exp(-np.linspace(-_LIMIT, _LIMIT, int(2 * _LIMIT * _PER_UNIT) + 2)))
)
_STEPS = _BITS.size - 1


class Maps(NamedTuple):
    """The maps of robots, a row a robot; of one robot, without the first axis.

    Parameters
    ----------
    log_odds : ndarray, shape (robots, rows, cols)
        The cells.
    kind : ndarray of int8, shape (robots, rows, cols)
        What the cells are: `HIDDEN`, `OCCUPIED`, `FREE` or `REACHABLE`, which is free as well.
    gains : ndarray, shape (robots, 3)
        Bits gained and cells newly spoken of since it was cleared, and reachable cells that the
        map calls free.
    shapes, grids : ndarray, shapes (robots, 2), (robots, 3)
        Rows and columns of each map; its lower-left corner and cell size, metres.
    """

    log_odds: NDArray[np.float64]
    kind: NDArray[np.int8]
    gains: NDArray[np.float64]
    shapes: NDArray[np.int64]
    grids: NDArray[np.float64]


class Cones(NamedTuple):
    """The cones of a ring.

    Parameters
    ----------
    mounts : ndarray, shape (sonars, 3)
        Place and axis of each sonar in the robot's frame.
    half_angle, bearing
        See `sonarmap.kernels.fusion.cone_evidence`.
    """

    mounts: NDArray[np.float64]
    half_angle: float
    bearing: NDArray[np.float64]


class Readings(NamedTuple):
    """The readings of the last control step that say something.

    Parameters
    ----------
    number : ndarray of int, shape (robots, sonars)
        Which of the regions are a sonar's; -1 if its reading says nothing.
    border, axis, edge : ndarray, shapes (regions, 3), (regions, 3, 2), (regions, 3, 2)
        `Regions` of the readings.
    """

    number: NDArray[np.int64]
    border: NDArray[np.float64]
    axis: NDArray[np.float64]
    edge: NDArray[np.float64]


@njit()
def _map_of(maps, robot):
    log_odds, kind, gains, shapes, grids = maps
    return Maps(log_odds[robot], kind[robot], gains[robot], shapes[robot], grids[robot])


@njit()
def _bits(log_odds):
    place = (min(max(log_odds, -_LIMIT), _LIMIT) + _LIMIT) * (_STEPS / (2 * _LIMIT))
    low = min(int(place), _STEPS - 1)
    return _BITS[low] + (place - low) * (_BITS[low + 1] - _BITS[low])


@njit()
def _add_reading(own, sensor, cones, readings, i, cells, runs):
    """Add reading `i`, taken at a sensor (x, y, axis), to one robot's map; see `add_fresh`."""
    log_odds, kind, gains, shape, grid = own
    row_begin, row_end = cone_evidence(
        GridCells(shape[0], shape[1], grid[0], grid[1], grid[2]),
        sensor,
        Cone(cones.half_angle, cones.bearing),
        RegionArrays(readings.border[i], readings.axis[i], readings.edge[i]),
        runs,
        cells,
    )
    evidence = cells[5]
    n, gained, new_cells, freed = 0, 0.0, 0, 0
    for row in range(row_begin, row_end):
        first, count = runs[0, row], runs[1, row]
        line = log_odds[row, first : first + count]
        kinds = kind[row, first : first + count]
        for k in range(count):
            added, old = evidence[n + k], line[k]
            new = old + added
            line[k] = new
            if kinds[k] == HIDDEN or added == 0.0:
                continue
            truth = 1.0 if kinds[k] == OCCUPIED else -1.0
            # Looked up twice: to keep what a cell scores in memory would cost more.
            gained += _bits(truth * new) - _bits(truth * old)
            new_cells += old == 0.0
            if kinds[k] == REACHABLE:
                freed += int(new <= _FREE_LOG_ODDS) - int(old <= _FREE_LOG_ODDS)
        n += count
    gains[0] += gained
    gains[1] += new_cells
    gains[2] += freed


@njit()
def fresh_echoes(states, limit_m):
    """Return the ranges of what was read in the last control step, and which of them is whose.

    Parameters
    ----------
    states : structured ndarray, shape (robots,)
        `sim.envs.states.robot_dtype`.
    limit_m : float
        Longer readings say nothing.

    Returns
    -------
    range_m : ndarray, shape (readings,)
    number : ndarray of int, shape (robots, sonars)
        Which reading is a sonar's; -1 for none.
    """
    sonars = states[0].range_m.size
    number = np.full((states.size, sonars), -1)
    range_m = np.empty(states.size * sonars)
    count = 0
    for robot in range(states.size):
        state = states[robot]
        for k in range(sonars):
            if state.fresh[k] and 0.0 <= state.range_m[k] <= limit_m:
                number[robot, k], range_m[count] = count, state.range_m[k]
                count += 1
    return range_m[:count], number


@njit()
def add_fresh(states, rows, maps, cones, readings, cells, runs):
    """Add the readings of the last control step to the maps of robots.

    Parameters
    ----------
    states : structured ndarray, shape (robots,)
        `sim.envs.states.robot_dtype`.
    rows : ndarray of int
        Which robots.
    maps, cones, readings : tuple
        Fields of `Maps`, changed in place, `Cones` and `Readings`. (Numba takes a plain tuple over
        from Python in less than half of the time of a named one.)
    cells, runs
        Working memory, see `sonarmap.kernels.fusion.cone_evidence`.
    """
    maps, cones, readings = Maps(*maps), Cones(*cones), Readings(*readings)
    mounts = cones.mounts
    for row in rows:
        own = _map_of(maps, row)
        for k in range(mounts.shape[0]):
            i = readings.number[row, k]
            if i < 0:
                continue
            pose = states[row].fired_pose[k]
            cos, sin = math.cos(pose[2]), math.sin(pose[2])
            sensor = (
                pose[0] + cos * mounts[k, 0] - sin * mounts[k, 1],
                pose[1] + sin * mounts[k, 0] + cos * mounts[k, 1],
                pose[2] + mounts[k, 2],
            )
            _add_reading(own, sensor, cones, readings, i, cells, runs)


@njit()
def _see_patch(patch, pose, own, cell_m):
    """Write the map around one robot; see `see_patches`."""
    log_odds, _, _, shape, grid = own
    size = patch.shape[0]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(size):
        ahead = (0.5 * size - 0.5 - i) * cell_m
        for j in range(size):
            aside = (0.5 * size - 0.5 - j) * cell_m
            col = cell_index(pose[0] + cos * ahead - sin * aside, grid[0], grid[2])
            row = cell_index(pose[1] + sin * ahead + cos * aside, grid[1], grid[2])
            known = 0.0
            if 0 <= row < shape[0] and 0 <= col < shape[1]:
                known = log_odds[row, col]
            # Half up, so that 0.5 is 128.
            patch[i, j] = int(255.0 / (1.0 + math.exp(-known)) + 0.5) if known != 0.0 else 128


@njit()
def see_patches(patches, states, maps, cell_m):
    """Write the maps around the robots as they see them.

    Parameters
    ----------
    patches : ndarray of uint8, shape (robots, 1, size, size)
        Written: P(occupied) times 255; the first row is farthest ahead, the first column farthest
        left. What is not in the map is unknown, 128.
    states, maps
        As for `add_fresh`.
    cell_m : float
        Side of a cell of the patch, metres.
    """
    maps = Maps(*maps)
    for robot in range(states.size):
        _see_patch(patches[robot, 0], states[robot].believed_pose, _map_of(maps, robot), cell_m)
