"""The compiled loops of HSR: mark sampled lines on a grid, and search it along them.

The rules sample every line at each millimetre. These loops visit only some of the samples and
give the same result as all of them, bit for bit, for two reasons:

* A visited sample is computed by the literal expression of `_place` and `_cell`, whose every
  rounded step keeps order. Along a line, row and column of the samples therefore never turn
  back: between two samples of one cell all lie in that cell, and between two samples of cells
  that share a side all lie in one of the two.
* A cell that is D cells (king's moves) away from the nearest marked one can be left by up to
  D - 1 cells before a mark can be met. How far a jump really went is checked on the sample where
  it lands, and the jump is halved when it went too far: the estimate decides on speed alone.

The plain version, which visits every sample, is in the tests (`tests/sonarmap/test_hsr.py`).
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["king_distance", "mark_lines", "mark_points", "search_readings"]

# Units of the thesis: its data are whole millimetres, and so are its sampling intervals.
_STEP_M = 0.001
# King's moves are counted up to here, which fits a byte: 2.54 m at 1 cm cells.
_FAR = 254


@njit(inline="always", error_model="numpy")
def _place(start, delta, k, n):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the coordinate of sample k of n + 1."""
    return start + (k / n) * delta


@njit(inline="always", error_model="numpy")
def _cell(place, origin, resolution):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the row or column of a coordinate: `GridSpec.cell_of` once more."""
    return np.int64(math.floor((place - origin) / resolution))


@njit(inline="always", error_model="numpy")
def _intervals(dx, dy):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the number of sampling intervals, at least 1 for a line without length."""
    return max(np.int64(math.ceil(max(abs(dx), abs(dy)) / _STEP_M)), 1)


@njit(error_model="numpy")
def mark_points(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    marks, origin_x, origin_y, resolution, xy, mark
):
    """Mark the cells of points (n, 2); a weaker mark never overwrites a stronger one."""
    for i in range(xy.shape[0]):
        row = _cell(xy[i, 1], origin_y, resolution)
        col = _cell(xy[i, 0], origin_x, resolution)
        marks[row, col] = max(marks[row, col], mark)


@njit(error_model="numpy")
def mark_lines(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    marks, origin_x, origin_y, resolution, from_xy, to_xy, mark
):
    """Mark the cells of the samples of lines (n, 2) to (n, 2), weaker marks only."""
    for i in range(from_xy.shape[0]):
        x, y = from_xy[i, 0], from_xy[i, 1]
        dx, dy = to_xy[i, 0] - x, to_xy[i, 1] - y
        n = _intervals(dx, dy)
        stride = _samples_per_cell(dx, dy, n, resolution)
        row, col = _cell(y, origin_y, resolution), _cell(x, origin_x, resolution)
        marks[row, col] = max(marks[row, col], mark)
        k = 0
        while k < n:
            ahead = min(k + stride, n)
            while True:
                next_row = _cell(_place(y, dy, ahead, n), origin_y, resolution)
                next_col = _cell(_place(x, dx, ahead, n), origin_x, resolution)
                if ahead == k + 1 or abs(next_row - row) + abs(next_col - col) <= 1:
                    break
                ahead = (k + ahead) // 2
            k, row, col = ahead, next_row, next_col
            marks[row, col] = max(marks[row, col], mark)


@njit(error_model="numpy")
def king_distance(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    marks, first, last
):
    """Distance of each cell to the nearest with a mark in [first, last], in king's moves.

    Two sweeps over the grid, exact for this metric; counted up to 254.
    """
    rows, cols = marks.shape
    # A frame of far cells around the grid saves the sweeps from asking for its borders.
    framed = np.full((rows + 2, cols + 2), _FAR, np.uint8)
    for r in range(rows):
        _sweep(marks[r], first, last, framed[r], framed[r + 1])
    for r in range(rows, 0, -1):
        _sweep_back(framed[r + 1], framed[r])
    return framed[1:-1, 1:-1]


@njit(error_model="numpy")
def _sweep(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    marks, first, last, before, line
):
    for c in range(marks.size):
        near = min(before[c], before[c + 1], before[c + 2])
        near = np.uint8(near + 1) if near < _FAR else np.uint8(_FAR)
        line[c + 1] = np.uint8(0) if first <= marks[c] <= last else near
    running = np.int64(_FAR)
    for c in range(1, line.size - 1):
        running = min(running + 1, np.int64(line[c]))
        line[c] = running


@njit(error_model="numpy")
def _sweep_back(before, line):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    for c in range(1, line.size - 1):
        near = min(before[c - 1], before[c], before[c + 1])
        near = np.uint8(near + 1) if near < _FAR else np.uint8(_FAR)
        line[c] = min(line[c], near)
    running = np.int64(_FAR)
    for c in range(line.size - 2, 0, -1):
        running = min(running + 1, np.int64(line[c]))
        line[c] = running


@njit(error_model="numpy")
def search_readings(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    distance, origin_x, origin_y, resolution, sensor_xy, point_xy, range_max, target_distance, out
):
    """Write the range of each reading that a marked cell shortens into `out`.

    Parameters
    ----------
    distance : ndarray of uint8, shape (rows, cols)
        `king_distance` to the cells that end a search.
    origin_x, origin_y, resolution : float
        The grid, metres.
    sensor_xy, point_xy : ndarray, shape (n, 2)
        Where each search begins and ends, metres; NaN for a reading that takes no part.
    range_max, target_distance : float
        Metres.
    out : ndarray, shape (n,)
        Changed in place where a reading is updated.
    """
    for i in range(out.size):
        x, y = sensor_xy[i, 0], sensor_xy[i, 1]
        end_x, end_y = point_xy[i, 0], point_xy[i, 1]
        if math.isnan(end_x):
            continue
        dx, dy = end_x - x, end_y - y
        n = _intervals(dx, dy)
        k = _first_marked(distance, origin_x, origin_y, resolution, x, y, dx, dy, n, range_max)
        if k < 0:
            continue
        at_x, at_y = _place(x, dx, k, n), _place(y, dy, k, n)
        found = _length(at_x - x, at_y - y)
        # Condition 1 (range_max) and 3 (target distance) of the thesis. Along the line the
        # distance never falls: had a sample before this one been too far, this one would be.
        if found <= range_max and _length(end_x - at_x, end_y - at_y) > target_distance:
            out[i] = found


@njit(error_model="numpy")
def _first_marked(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    distance, origin_x, origin_y, resolution, x, y, dx, dy, n, range_max
):
    """Index of the first sample in a marked cell; -1 if none before the search stops."""
    rows, cols = distance.shape
    stride = _samples_per_cell(dx, dy, n, resolution)
    row, col = _cell(y, origin_y, resolution), _cell(x, origin_x, resolution)
    k, clear = 0, np.int64(distance[row, col])
    while clear > 0:
        if k == n or _length(_place(x, dx, k, n) - x, _place(y, dy, k, n) - y) > range_max:
            return -1
        ahead = min(k + max(clear - 1, 1) * stride, n)
        while True:
            next_row = _cell(_place(y, dy, ahead, n), origin_y, resolution)
            next_col = _cell(_place(x, dx, ahead, n), origin_x, resolution)
            moved_rows, moved_cols = abs(next_row - row), abs(next_col - col)
            side_by_side = moved_rows + moved_cols == 1
            if max(moved_rows, moved_cols) < clear or side_by_side or ahead == k + 1:
                break
            ahead = (k + ahead) // 2
        # Condition 2 of the thesis: the point has left ES, and never comes back.
        if not (0 <= next_row < rows and 0 <= next_col < cols):
            return -1
        clear = np.int64(distance[next_row, next_col])
        if clear > 0:
            k, row, col = ahead, next_row, next_col
            continue
        # Somewhere in (k, ahead] the line enters the marked cell, from the cell of k.
        while ahead - k > 1:
            middle = (k + ahead) // 2
            if (
                _cell(_place(y, dy, middle, n), origin_y, resolution) == row
                and _cell(_place(x, dx, middle, n), origin_x, resolution) == col
            ):
                k = middle
            else:
                ahead = middle
        k = ahead
    return k


@njit(inline="always", error_model="numpy")
def _length(dx, dy):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    return math.sqrt(dx * dx + dy * dy)


@njit(inline="always", error_model="numpy")
def _samples_per_cell(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    dx, dy, n, resolution
):
    """Return the samples in which a line moves by about a cell: a guess, see above."""
    fastest = max(abs(dx), abs(dy))
    return max(np.int64(min(resolution * n / fastest, n)), 1) if fastest > 0 else np.int64(1)
