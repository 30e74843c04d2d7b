"""`truth`: what a perfect map of a known room would say, cell by cell."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, label

from sonarmap.errors import InputError, one_of, resolves
from sonarmap.files import atomic_path
from sonarmap.grid import GridSpec
from worlds.faces import Faces
from worlds.raster import INSET_M, touched_cells
from worlds.world import World

if TYPE_CHECKING:
    from sonarmap.log import SonarLog

__all__ = ["FREE", "HIDDEN", "OCCUPIED", "CellState", "TruthGrid", "truth"]


class CellState(IntEnum):
    """What is true of a cell."""

    FREE = 0
    """Nothing stands in it, and the robot's start is connected to it."""
    OCCUPIED = 1
    """A solid covers a part of it, and a free cell is beside it: a surface a sonar can meet."""
    HIDDEN = 2
    """Anything else, the inside of solids and the world outside: no sonar can tell."""


_EIGHT_NEIGHBOURS = np.ones((3, 3), dtype=bool)

FREE, OCCUPIED, HIDDEN = CellState.FREE, CellState.OCCUPIED, CellState.HIDDEN


@dataclass(frozen=True, slots=True, eq=False)
class TruthGrid:
    """The truth about the cells of a grid.

    Parameters
    ----------
    grid : GridSpec
        Geometry of the cells.
    state : ndarray of uint8, shape (rows, cols)
        A `CellState` each.
    faces : Faces
        The surfaces of the world, for lines of sight.
    """

    grid: GridSpec
    state: NDArray[np.uint8]
    faces: Faces

    def __post_init__(self) -> None:
        self.state.flags.writeable = False

    def observable(
        self, log: SonarLog, *, poses: Literal["auto", "true", "odometry"] = "auto"
    ) -> NDArray[np.bool_]:
        """Return which cells the sonars of a log could have observed from where they were.

        A cell counts when a part of it lies in a sonar's cone within the maximum range and in
        line of sight, the first surface included. HIDDEN cells never count, for there is
        nothing to be right or wrong about.

        Parameters
        ----------
        log : SonarLog
            Only the poses and the ring are used, not the readings.
        poses : {"auto", "true", "odometry"}
            Where the robot was: "true", by the truth of a simulated log; "odometry", by its own
            account, all that a real log has, in the frame of the room (`worlds.align`). "auto": the
            truth where there is one.

        Returns
        -------
        ndarray of bool, shape (rows, cols)

        Raises
        ------
        InputError
            If the log has no truth and the true poses are asked for.
        """
        one_of("poses", poses, ("auto", "true", "odometry"))
        cones = _cones(log, is_true=poses == "true" or (poses == "auto" and log.truth is not None))
        from worlds.visibility import mark_visible  # numba is heavy: loaded when rays are cast

        ring, cell_m = log.ring, self.grid.resolution_m
        x_m, y_m = self.grid.origin_xy_m
        # Neighbouring rays are at most one cell apart at the end, so that they meet every cell.
        step_rad = cell_m / ring.range_max_m
        seen = np.zeros(self.grid.shape, dtype=bool)
        mark_visible(
            seen,
            (cones - (x_m, y_m, 0.0)) / (cell_m, cell_m, 1.0),
            ring.half_angle_rad,
            math.ceil(2 * ring.half_angle_rad / step_rad) + 1,
            ring.range_max_m / cell_m,
            # One inset would end on the border of the cells that a solid only just touches.
            2 * INSET_M / cell_m,
            self.faces.table_in_cells(self.grid.origin_xy_m, cell_m),
        )
        seen &= self.state != HIDDEN
        return seen

    def save(self, folder: str | Path) -> Path:
        """Write ``truth.npz`` (state, resolution_m, origin_xy_m) into `folder`; return its path."""
        target = Path(folder) / "truth.npz"
        with atomic_path(target) as beside:
            np.savez_compressed(
                beside,
                state=self.state,
                resolution_m=self.grid.resolution_m,
                origin_xy_m=np.array(self.grid.origin_xy_m),
            )
        return target


def truth(world: World, grid: GridSpec | None = None, *, resolution_m: float = 0.05) -> TruthGrid:
    """Return the truth about the cells of a grid.

    Parameters
    ----------
    world : World
        The room.
    grid : GridSpec, optional
        The cells. None: the smallest grid of `resolution_m` cells over the world's bounds. A grid
        over a part of the room that lacks the start, such as that of a map that was cut out, is
        judged as a part of a grid over the whole room.
    resolution_m : float
        Side of a cell in metres when no grid is given.

    Raises
    ------
    InputError
        If the grid lies wholly outside of the world's bounds, or its cells are so coarse that a
        solid shares the cell of the robot's start.
    """
    if grid is None:
        x_min, y_min, x_max, y_max = world.bounds_m
        resolves(resolution_m, x_max - x_min, y_max - y_min)
        grid = GridSpec.covering(*world.bounds_m, resolution_m)
    if grid.contains(*_start_cell(world, grid)):
        return TruthGrid(grid, _states(world, grid), world.faces)
    whole, window = _over_room(world, grid)
    return TruthGrid(grid, _states(world, whole)[window].copy(), world.faces)


def _states(world: World, grid: GridSpec) -> NDArray[np.uint8]:
    """Return the state of each cell of a grid that holds the start."""
    touched = np.zeros(grid.shape, dtype=bool)
    for solid in world.solids:
        touched[touched_cells(solid, grid)] = True
    free = _connected(~touched, world, grid)
    state = np.full(grid.shape, HIDDEN, dtype=np.uint8)
    state[touched & binary_dilation(free, _EIGHT_NEIGHBOURS)] = OCCUPIED
    state[free] = FREE
    return state


def _over_room(world: World, grid: GridSpec) -> tuple[GridSpec, tuple[slice, slice]]:
    """Return a grid grown, cell by cell, over the whole room, and where in it the old one lies."""
    x_min, y_min, x_max, y_max = world.bounds_m
    rows, cols = grid.cell_of([x_min, x_max, world.start.x_m], [y_min, y_max, world.start.y_m])
    bottom, top = int(rows.min()), int(rows.max())
    left, right = int(cols.min()), int(cols.max())
    if top < 0 or right < 0 or bottom >= grid.rows or left >= grid.cols:
        raise InputError(
            f"grid must hold {_start_of(world)}, got extent_m {grid.extent_m}, "
            f"wholly outside of the room's bounds_m {list(world.bounds_m)}"
        )
    below, beside = max(-bottom, 0), max(-left, 0)
    shape = (max(top + 1, grid.rows) + below, max(right + 1, grid.cols) + beside)
    x_m, y_m = grid.origin_xy_m
    size = grid.resolution_m
    whole = GridSpec(size, (x_m - beside * size, y_m - below * size), shape)
    return whole, (slice(below, below + grid.rows), slice(beside, beside + grid.cols))


def _start_cell(world: World, grid: GridSpec) -> tuple[int, int]:
    row, col = grid.cell_of(world.start.x_m, world.start.y_m)
    return int(row), int(col)


def _start_of(world: World) -> str:
    return f"the start [{world.start.x_m:g}, {world.start.y_m:g}] of {world.name!r}"


def _connected(untouched: NDArray[np.bool_], world: World, grid: GridSpec) -> NDArray[np.bool_]:
    row, col = _start_cell(world, grid)
    if not untouched[row, col]:
        raise InputError(
            f"resolution_m must leave {_start_of(world)} a free cell, got {grid.resolution_m:g}"
        )
    labels, _ = label(untouched)  # its default is the four sides
    free: NDArray[np.bool_] = labels == labels[row, col]
    return free


def _cones(log: SonarLog, *, is_true: bool) -> NDArray[np.float64]:
    """Return (x_m, y_m, axis_rad) of every distinct firing at its pose, shape (n, 3)."""
    where = log.truth if is_true else log
    if where is None:
        raise InputError("the log has no truth (a real robot's?), needed for the true poses")
    firings = np.column_stack([where.x_m, where.y_m, where.heading_rad, log.sonar])
    x_m, y_m, heading_rad, sonar = np.unique(firings, axis=0).T
    mount = sonar.astype(int)
    places = log.ring.sensor_xy_m(mount, x_m, y_m, heading_rad)
    return np.column_stack([places, heading_rad + log.ring.heading_rad[mount]])
