"""The compiled loop of occupancy mapping: add the log-odds of readings to the cells they touch.

Work is laid out so that the compiler can use vector instructions: for each reading the cells of
its cone are listed first, their evidence is computed in one straight loop without branches or
library calls, and then it is added row by row. The plain version of the same arithmetic is in
the tests (`tests/sonarmap/test_mapping.py`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.jit import njit

__all__ = [
    "Cone",
    "ConeLists",
    "GridCells",
    "RegionArrays",
    "Sensors",
    "add_listed",
    "add_readings",
    "bearing_polynomial",
    "cone_evidence",
    "cone_memory",
    "cone_room",
    "count_cells",
    "list_cones",
]

_DEGREE = 12
_LN_2 = math.log(2)
# Bits of sqrt(1/2) as float64: the mantissa is split there, so that it lies around 1.
_SQRT_HALF_BITS = int(np.float64(math.sqrt(0.5)).view(np.int64))
_P_MIN, _P_MAX = 1e-6, 1 - 1e-6
# Keeps the quotient of half-angles defined for a cell centre that is the sonar's own place.
_TINY = 1e-300
# Cells; more than the rounding of the cone's edges and less than shows in the time.
_SLACK = 1e-6
# NaN and infinity never enter the loop, and the order of sums within one cell is kept outside.
_FAST = {"contract", "nsz", "nnan", "ninf", "arcp", "reassoc"}


class GridCells(NamedTuple):
    """Where the cells of a grid are: how many, the lower-left corner and the side in metres."""

    rows: int
    cols: int
    origin_x: float
    origin_y: float
    resolution: float


class Sensors(NamedTuple):
    """Where sonars were fired.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)
        Places, metres.
    axis_rad : ndarray, shape (n,)
        Acoustic axes, radians.
    """

    xy: NDArray[np.float64]
    axis_rad: NDArray[np.float64]


class Cone(NamedTuple):
    """The cone of a sonar: its half-angle in radians and the `bearing_polynomial` of that."""

    half_angle: float
    bearing: NDArray[np.float64]


class RegionArrays(NamedTuple):
    """The `Regions` of n readings; of one of them, without the first axis.

    Parameters
    ----------
    border, axis, edge : ndarray, shapes (n, 3), (n, 3, 2), (n, 3, 2)
        Their fields.
    """

    border: NDArray[np.float64]
    axis: NDArray[np.float64]
    edge: NDArray[np.float64]


class ConeLists(NamedTuple):
    """The cells of n cones.

    Parameters
    ----------
    first_run, first_cell : ndarray, shape (n + 1,)
        Where the runs and the cells of each cone begin. A run is a row of the cone.
    run_cell, run_length : ndarray, shape (runs,)
        Flat index of the first cell in the grid, and number of cells.
    ranges, shares : ndarray, shape (cells,)
        Range in metres and bearing / half-angle of each cell.
    """

    first_run: NDArray[np.int64]
    first_cell: NDArray[np.int64]
    run_cell: NDArray[np.int64]
    run_length: NDArray[np.int64]
    ranges: NDArray[np.float64]
    shares: NDArray[np.float64]


def bearing_polynomial(half_angle_rad: float) -> NDArray[np.float64]:
    """Return coefficients c with ``bearing / half_angle = t * sum(c[k] * t**(2 k))``.

    Here ``t = tan(|bearing| / 2)``, which needs no inverse function: it is
    ``across / (range + along)``. The fit is a Chebyshev interpolation of atan(t)/t over the cone,
    good to 1e-12 for half-angles up to 60 degrees.
    """
    widest = math.tan(half_angle_rad / 2) ** 2

    def atan_over(z: NDArray[np.float64]) -> NDArray[np.float64]:
        t = np.sqrt(z)
        return np.arctan(t) / t

    fit = np.polynomial.Chebyshev.interpolate(atan_over, _DEGREE, [0, widest])
    powers = fit.convert(kind=np.polynomial.Polynomial).coef
    coefficients = np.zeros(_DEGREE + 1)
    coefficients[: powers.size] = powers
    return coefficients * (2 / half_angle_rad)


@njit(inline="always", error_model="numpy")
def _log(x):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Natural logarithm of a positive normal number, good to 1e-15, as plain arithmetic."""
    bits = np.float64(x).view(np.int64)
    exponent = (bits - _SQRT_HALF_BITS) >> 52
    mantissa = np.int64(bits - (exponent << 52)).view(np.float64)
    # ln m = 2 atanh((m - 1) / (m + 1)), its series in z <= 0.0295.
    s = (mantissa - 1.0) / (mantissa + 1.0)
    z = s * s
    tail = 2.0 / 15 + z * (2.0 / 17)
    tail = 2.0 / 13 + z * tail
    tail = 2.0 / 11 + z * tail
    tail = 2.0 / 9 + z * tail
    tail = 2.0 / 7 + z * tail
    tail = 2.0 / 5 + z * tail
    tail = 2.0 / 3 + z * tail
    return exponent * _LN_2 + s * (2.0 + z * tail)


@njit(fastmath=_FAST, error_model="numpy")
def _geometry(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    dx, dy, r_out, share_out, axis_x, axis_y, c
):
    """Write range and bearing / half-angle of cells at (dx, dy) from the sonar.

    Cells behind the sonar get a share of 2: outside of the cone, like all above 1.
    """
    for j in range(r_out.size):
        r = math.sqrt(dx[j] * dx[j] + dy[j] * dy[j])
        along = dx[j] * axis_x + dy[j] * axis_y
        across = abs(dx[j] * axis_y - dy[j] * axis_x)
        # Behind the sonar, where r + along comes down to 0, any finite number will do.
        ahead = along if along > 0.0 else 0.0
        t = across / (r + ahead + _TINY)
        z = t * t
        # Horner's rule, written out: a loop here would keep the outer one from being vectorised.
        poly = c[11] + z * c[12]
        poly = c[10] + z * poly
        poly = c[9] + z * poly
        poly = c[8] + z * poly
        poly = c[7] + z * poly
        poly = c[6] + z * poly
        poly = c[5] + z * poly
        poly = c[4] + z * poly
        poly = c[3] + z * poly
        poly = c[2] + z * poly
        poly = c[1] + z * poly
        share = t * (c[0] + z * poly)
        r_out[j] = r
        share_out[j] = share if along >= 0.0 else 2.0


@njit(fastmath=_FAST, error_model="numpy")
def _evidence(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    ranges, shares, p_out, log_odds_out, regions
):
    """Write P(occupied) of cells, -1 where silent, and its log-odds, 0 where silent."""
    border, axis, edge = regions
    near, middle, reach = border[0], border[1], border[2]
    axis0, axis0_slope, edge0, edge0_slope = axis[0, 0], axis[0, 1], edge[0, 0], edge[0, 1]
    axis1, axis1_slope, edge1, edge1_slope = axis[1, 0], axis[1, 1], edge[1, 0], edge[1, 1]
    axis2, axis2_slope, edge2, edge2_slope = axis[2, 0], axis[2, 1], edge[2, 0], edge[2, 1]
    for j in range(p_out.size):
        r, share = ranges[j], shares[j]
        in_first, in_second = r < near, r < middle
        on_axis = (
            axis0 + axis0_slope * r
            if in_first
            else (axis1 + axis1_slope * r if in_second else axis2 + axis2_slope * r)
        )
        at_edge = (
            edge0 + edge0_slope * r
            if in_first
            else (edge1 + edge1_slope * r if in_second else edge2 + edge2_slope * r)
        )
        p = on_axis + (at_edge - on_axis) * share
        p = p if p > _P_MIN else _P_MIN
        p = p if p < _P_MAX else _P_MAX
        log_odds = _log(p / (1.0 - p))
        speaks = (share <= 1.0) & (r <= reach)
        p_out[j] = p if speaks else -1.0
        log_odds_out[j] = log_odds if speaks else 0.0


@njit(error_model="numpy")
def _list_cells(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    grid, place, direction, half_angle, reach, runs, dx, dy
):
    """List the cells of a cone row by row: in each those between its edges and within reach.

    Writes the first column and the number of cells of each row, and the cells' places relative
    to the sonar; returns (first row, row after the last, cells). `place` is the sonar's (x, y),
    `direction` the unit vector of its axis.
    """
    rows, cols, origin_x, origin_y, resolution = grid
    axis_x, axis_y = direction
    first, count = runs[0], runs[1]
    # The sonar's place relative to the centre of cell (0, 0).
    start_x = place[0] - origin_x - 0.5 * resolution
    start_y = place[1] - origin_y - 0.5 * resolution
    cos_half, sin_half = math.cos(half_angle), math.sin(half_angle)
    # Directions of the cone's left and right edge.
    left_x = axis_x * cos_half - axis_y * sin_half
    left_y = axis_y * cos_half + axis_x * sin_half
    right_x = axis_x * cos_half + axis_y * sin_half
    right_y = axis_y * cos_half - axis_x * sin_half

    # Divisions once a cone, not once a row: what rounding may do to them the slack forgives.
    per_cell = 1.0 / resolution
    left_slope = left_x / left_y if abs(left_y) > _TINY else 0.0
    right_slope = right_x / right_y if abs(right_y) > _TINY else 0.0

    # Rows of the cone: between its corners, or up to the arc where it holds the y direction.
    top = reach if axis_y > cos_half else reach * max(0.0, left_y, right_y)
    bottom = -reach if axis_y < -cos_half else reach * min(0.0, left_y, right_y)
    # Here and below a cell of slack: `_geometry` decides exactly, this only saves it work.
    row_begin = max(0, math.floor((start_y + bottom) / resolution))
    row_end = min(rows, math.ceil((start_y + top) / resolution) + 1)

    n = 0
    for row in range(row_begin, row_end):
        first[row], count[row] = 0, 0
        v = row * resolution - start_y
        half_chord_squared = reach * reach - v * v
        if half_chord_squared < 0:
            continue
        high = math.sqrt(half_chord_squared)
        low = -high
        if left_y > _TINY:
            low = max(low, v * left_slope)
        elif left_y < -_TINY:
            high = min(high, v * left_slope)
        if right_y > _TINY:
            high = min(high, v * right_slope)
        elif right_y < -_TINY:
            low = max(low, v * right_slope)
        begin = max(0, math.floor((start_x + low) * per_cell - _SLACK))
        end = min(cols, math.ceil((start_x + high) * per_cell + _SLACK) + 1)
        if end <= begin:
            continue
        first[row], count[row] = begin, end - begin
        for k in range(end - begin):
            dx[n + k] = (begin + k) * resolution - start_x
            dy[n + k] = v
        n += end - begin
    return row_begin, row_end, n


@njit(error_model="numpy")
def cone_room(rows, cols, resolution, reach):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return a bound on the cells within reach of a sonar: half a disc, in its bounding box."""
    room = 0
    for i in range(reach.size):
        across = int(2 * reach[i] / resolution) + 3
        room = max(room, min(rows, across) * min(cols, across))
    return room


@njit()
def cone_memory(room):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return working memory of `cone_evidence`."""
    return (
        np.empty(room),
        np.empty(room),
        np.empty(room),
        np.empty(room),
        np.empty(room),
        np.empty(room),
    )


@njit(error_model="numpy")
def cone_evidence(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    grid, sensor, cone, regions, runs, cells
):
    """Write what one reading says of the cells in its cone; return (first row, row after the last).

    Parameters
    ----------
    grid : GridCells
        The grid.
    sensor : tuple of float
        Place (x, y) of the sonar, metres, and its axis, radians.
    cone : Cone
    regions : RegionArrays
        Those of the reading.
    runs : ndarray of int, shape (2, rows)
        Written for these rows: first column and number of cells.
    cells : tuple of six ndarray, shape (room,)
        Working memory for `cone_room` cells; the last gets the log-odds, row by row. (Six arrays,
        since the compiler does not vectorise over rows of one.)
    """
    x, y, axis_rad = sensor
    axis_x, axis_y = math.cos(axis_rad), math.sin(axis_rad)
    dx, dy, ranges, shares, p, evidence = cells
    row_begin, row_end, n = _list_cells(
        grid, (x, y), (axis_x, axis_y), cone.half_angle, regions.border[2], runs, dx, dy
    )
    _geometry(dx[:n], dy[:n], ranges[:n], shares[:n], axis_x, axis_y, cone.bearing)
    _evidence(ranges[:n], shares[:n], p[:n], evidence[:n], regions)
    return row_begin, row_end


@njit()
def _regions_of(regions, i):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the regions of reading `i`."""
    return RegionArrays(regions.border[i], regions.axis[i], regions.edge[i])


@njit(error_model="numpy")
def add_readings(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds, grid, sensors, cone, regions, limit
):
    """Add the evidence of n readings to `log_odds` (rows, cols) in place.

    Parameters
    ----------
    log_odds : ndarray, shape (rows, cols)
        The map, changed in place.
    grid : GridCells
        Where its cells are.
    sensors : Sensors
        Where the readings were taken.
    cone : Cone
    regions : RegionArrays
        Those of the readings.
    limit : float
        Bound on the sum in each cell, inf for none.
    """
    cells = cone_memory(cone_room(grid.rows, grid.cols, grid.resolution, regions.border[:, 2]))
    runs = np.empty((2, grid.rows), np.int64)
    for i in range(sensors.axis_rad.size):
        sensor = sensors.xy[i, 0], sensors.xy[i, 1], sensors.axis_rad[i]
        row_begin, row_end = cone_evidence(grid, sensor, cone, _regions_of(regions, i), runs, cells)
        n = 0
        for row in range(row_begin, row_end):
            first, count = runs[0, row], runs[1, row]
            line = log_odds[row, first : first + count]
            added = cells[5][n : n + count]
            for k in range(line.size):
                total = line[k] + added[k]
                total = total if total < limit else limit
                line[k] = total if total > -limit else -limit
            n += count


@njit(error_model="numpy")
def count_cells(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    grid, sensors, half_angle, reach
):
    """Return a bound on the cells of each cone and on its rows, int64 (n, 2)."""
    room = cone_room(grid.rows, grid.cols, grid.resolution, reach)
    dx, dy = np.empty(room), np.empty(room)
    runs = np.empty((2, grid.rows), np.int64)
    bounds = np.empty((reach.size, 2), np.int64)
    for i in range(reach.size):
        place = sensors.xy[i, 0], sensors.xy[i, 1]
        direction = math.cos(sensors.axis_rad[i]), math.sin(sensors.axis_rad[i])
        row_begin, row_end, n = _list_cells(
            grid, place, direction, half_angle, reach[i], runs, dx, dy
        )
        bounds[i, 0], bounds[i, 1] = n, max(row_end - row_begin, 0)
    return bounds


@njit(error_model="numpy")
def list_cones(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    grid, sensors, cone, reach, bounds
):
    """List the cells of n cones with what no model changes: their ranges and bearings.

    Parameters
    ----------
    grid : GridCells
    sensors : Sensors
    cone : Cone
    reach : ndarray, shape (n,)
        How far each cone is listed, metres.
    bounds : ndarray, shape (n, 2)
        From `count_cells`.

    Returns
    -------
    ConeLists
    """
    room = cone_room(grid.rows, grid.cols, grid.resolution, reach)
    dx, dy, r, share = np.empty(room), np.empty(room), np.empty(room), np.empty(room)
    row_runs = np.empty((2, grid.rows), np.int64)
    first, count = row_runs[0], row_runs[1]
    cell_bound, run_bound = bounds[:, 0].sum(), bounds[:, 1].sum()
    ranges, shares = np.empty(cell_bound), np.empty(cell_bound)
    run_cell, run_length = np.empty(run_bound, np.int64), np.empty(run_bound, np.int64)
    first_run = np.zeros(reach.size + 1, np.int64)
    first_cell = np.zeros(reach.size + 1, np.int64)
    runs, cells = 0, 0

    for i in range(reach.size):
        axis_x, axis_y = math.cos(sensors.axis_rad[i]), math.sin(sensors.axis_rad[i])
        place = sensors.xy[i, 0], sensors.xy[i, 1]
        row_begin, row_end, n = _list_cells(
            grid, place, (axis_x, axis_y), cone.half_angle, reach[i], row_runs, dx, dy
        )
        _geometry(dx[:n], dy[:n], r[:n], share[:n], axis_x, axis_y, cone.bearing)
        n = 0
        for row in range(row_begin, row_end):
            begin, end = n, n + count[row]
            n = end
            # A cone is convex: what lies outside of it lies at the ends of a row.
            while begin < end and (share[begin] > 1.0 or r[begin] > reach[i]):
                begin += 1
            while begin < end and (share[end - 1] > 1.0 or r[end - 1] > reach[i]):
                end -= 1
            if begin == end:
                continue
            run_cell[runs] = row * grid.cols + first[row] + begin - (n - count[row])
            run_length[runs] = end - begin
            runs += 1
            ranges[cells : cells + end - begin] = r[begin:end]
            shares[cells : cells + end - begin] = share[begin:end]
            cells += end - begin
        first_run[i + 1], first_cell[i + 1] = runs, cells
    return ConeLists(
        first_run,
        first_cell,
        run_cell[:runs].copy(),
        run_length[:runs].copy(),
        ranges[:cells].copy(),
        shares[:cells].copy(),
    )


@njit(error_model="numpy")
def add_listed(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds,
    seen,
    mean,
    deviation,
    first_run,
    first_cell,
    run_cell,
    run_length,
    ranges,
    shares,
    border,
    axis,
    edge,
):
    """Add the evidence of n listed readings to a map and to the running moments of P(occupied).

    Flat, unlike the others: with named groups this loop takes 4 % longer.

    Parameters
    ----------
    log_odds, seen, mean, deviation : ndarray, shape (rows * cols,)
        Changed in place: the map; the number of readings that spoke of each cell, the mean of
        what they said and the sum of its squared deviations (Welford's recurrence).
    first_run, first_cell, run_cell, run_length, ranges, shares
        Fields of `ConeLists`.
    border, axis, edge
        Fields of `RegionArrays`, those of the readings.
    """
    room = 0
    for i in range(first_cell.size - 1):
        room = max(room, first_cell[i + 1] - first_cell[i])
    p, evidence = np.empty(room), np.empty(room)
    for i in range(first_cell.size - 1):
        begin, end = first_cell[i], first_cell[i + 1]
        n = end - begin
        own = RegionArrays(border[i], axis[i], edge[i])
        _evidence(ranges[begin:end], shares[begin:end], p[:n], evidence[:n], own)
        n = 0
        for run in range(first_run[i], first_run[i + 1]):
            for cell in range(run_cell[run], run_cell[run] + run_length[run]):
                value = p[n]
                if value >= 0.0:
                    log_odds[cell] += evidence[n]
                    seen[cell] += 1.0
                    step = value - mean[cell]
                    mean[cell] += step / seen[cell]
                    deviation[cell] += step * (value - mean[cell])
                n += 1
