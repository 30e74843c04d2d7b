"""Compiled loops of the one-pass methods: what beams say of listed cells, into flat layers.

All take `first`, `cell`, `ranges` and `shares` of `sonarmap.methods.cones.Cells`. Each has its
plain twin in the tests of its method.
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = [
    "add_costs",
    "add_empty",
    "add_fuzzy",
    "add_gaussian",
    "add_himm",
    "add_kernels",
    "add_masses",
    "add_occupied",
    "add_profile",
    "add_thrun",
    "add_votes",
    "admit_buckets",
    "admit_travel",
    "expand_runs",
    "judge_beams",
    "keep_cells",
    "mark_arcs",
    "mark_free",
    "strongest_votes",
]

_P_MIN = 1e-6
_MOST_LOG_ODDS = math.log((1 - _P_MIN) / _P_MIN)
# What the range layer gives the cell on the axis before anything else.
_TARGET_COST = 233
# Standard deviations from the reading beyond which nothing of the Gaussian is left.
_TAIL = 8.0


@njit(error_model="numpy")
def expand_runs(run_cell, run_length, size):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the cells of runs one by one: flat indices, int64 (size,)."""
    cell = np.empty(size, np.int64)
    n = 0
    for run in range(run_cell.size):
        for k in range(run_length[run]):
            cell[n] = run_cell[run] + k
            n += 1
    return cell


@njit(error_model="numpy")
def keep_cells(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    first, cell, ranges, shares, kept
):
    """Return `first`, `cell`, `ranges` and `shares` of the cells that are kept."""
    size = 0
    for k in range(kept.size):
        size += kept[k]
    first_out, cell_out = np.zeros_like(first), np.empty(size, np.int64)
    ranges_out, shares_out = np.empty(size), np.empty(size)
    n = 0
    for i in range(first.size - 1):
        for k in range(first[i], first[i + 1]):
            if kept[k]:
                cell_out[n], ranges_out[n], shares_out[n] = cell[k], ranges[k], shares[k]
                n += 1
        first_out[i + 1] = n
    return first_out, cell_out, ranges_out, shares_out


@njit(error_model="numpy")
def add_thrun(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds, seen, first, cell, ranges, reading, echo, half_thickness, occupied, free
):
    """Add the three cases of table 9.2 to the log-odds and mark the cells they speak of."""
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            r, c = ranges[k], cell[k]
            if echo[i] and abs(r - z) < half_thickness:
                log_odds[c] += occupied
            elif r <= z:
                log_odds[c] += free
            else:
                continue
            seen[c] = True


@njit(error_model="numpy")
def add_gaussian(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds,
    seen,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    sigma,
    sigma_share,
    detection,
    density,
):
    """Add the Gaussian model's log-odds; `sigma_share` is the angle's sigma over the half-angle."""
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            t = shares[k] / sigma_share
            w = detection * math.exp(-0.5 * t * t)
            v = (ranges[k] - z) / sigma + density * sigma if echo[i] else -2 * _TAIL
            ratio = 1 - w
            if v > -_TAIL:
                peak = math.exp(-0.5 * v * v) / math.sqrt(2 * math.pi)
                ratio += w * (0.5 * math.erfc(-v / math.sqrt(2.0)) + peak / (density * sigma))
            c = cell[k]
            log_odds[c] += min(max(math.log(ratio), -_MOST_LOG_ODDS), _MOST_LOG_ODDS)
            seen[c] = True


@njit(error_model="numpy")
def add_masses(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied,
    free,
    unknown,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    longest,
    tolerance,
    max_occupied,
    matching,
):
    """Combine the masses of beams with those of the cells by Dempster's rule.

    `matching` is 0 for the textbook's masses, 1 for pignistic and 2 for plausibility matching.
    """
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            r = ranges[k]
            belief = ((longest - r) / longest + (1.0 - shares[k])) / 2.0
            if r < z - tolerance:
                p = 1.0 - belief
                on_arc = False
            elif echo[i] and r <= z + tolerance:
                p = belief * max_occupied
                on_arc = True
            else:
                continue
            p = min(max(p, _P_MIN), 1.0 - _P_MIN)
            m_occ, m_free = 0.0, 0.0
            if matching == 0:
                if on_arc:
                    m_occ = p
                else:
                    m_free = 1.0 - p
            elif matching == 1:
                m_occ, m_free = max(0.0, 2 * p - 1), max(0.0, 1 - 2 * p)
            elif p >= 0.5:
                m_occ = (2 * p - 1) / p
            else:
                m_free = (1 - 2 * p) / (1 - p)
            m_unknown = 1.0 - m_occ - m_free
            c = cell[k]
            o, f, u = occupied[c], free[c], unknown[c]
            agreed = 1.0 - (o * m_free + f * m_occ)
            occupied[c] = (o * m_occ + o * m_unknown + u * m_occ) / agreed
            free[c] = (f * m_free + f * m_unknown + u * m_free) / agreed
            unknown[c] = u * m_unknown / agreed


@njit(error_model="numpy")
def add_himm(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    count, seen, first, cell, target, up, down, top, growth
):
    """Count down the cells of axes (n) and up their `target`, -1 for none; count is (rows, cols).

    With `growth` a hit also adds that much of each of the eight neighbours' counts.
    """
    rows, cols = count.shape
    for i in range(target.size):
        hit = False
        for k in range(first[i], first[i + 1]):
            row, col = cell[k] // cols, cell[k] % cols
            seen[cell[k]] = True
            if cell[k] == target[i]:
                hit = True
            else:
                count[row, col] = max(count[row, col] - down, 0.0)
        if not hit:
            continue
        row, col = target[i] // cols, target[i] % cols
        total = count[row, col] + up
        if growth > 0.0:
            around = 0.0
            for r in range(max(row - 1, 0), min(row + 2, rows)):
                for c in range(max(col - 1, 0), min(col + 2, cols)):
                    if r != row or c != col:
                        around += count[r, c]
            total += growth * around
        count[row, col] = min(total, top)


@njit(error_model="numpy")
def add_empty(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    empty, first, cell, ranges, shares, reading, nearest, error
):
    """Superpose the empty areas of Moravec and Elfes; return which cells lie on an arc."""
    on_arc = np.zeros(cell.size, np.bool_)
    for i in range(reading.size):
        z = reading[i]
        border = z - error
        for k in range(first[i], first[i + 1]):
            r = ranges[k]
            if r > border:
                on_arc[k] = True
            elif r >= nearest and border > nearest:
                depth = (r - nearest) / (border - nearest)
                p = (1.0 - depth * depth) * (1.0 - shares[k] * shares[k])
                c = cell[k]
                empty[c] += p - empty[c] * p
    return on_arc


@njit(error_model="numpy")
def add_occupied(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied, empty, first, cell, ranges, shares, reading, error, least
):
    """Cancel, normalise and enhance the occupied areas of Moravec and Elfes."""
    for i in range(reading.size):
        begin, end = first[i], first[i + 1]
        total = 0.0
        for step in range(2):
            # A sum of next to nothing says that all of the arc is empty: it is not blown up.
            norm = total if total > least else 1.0
            for k in range(begin, end):
                depth = (ranges[k] - reading[i]) / error
                if abs(depth) > 1.0:
                    continue
                c = cell[k]
                p = (1.0 - depth * depth) * (1.0 - shares[k] * shares[k]) * (1.0 - empty[c])
                if step == 0:
                    total += p
                else:
                    p /= norm
                    occupied[c] += p - occupied[c] * p


@njit(error_model="numpy")
def admit_buckets(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    voted, cols, origin_x, origin_y, resolution, sensor_xy, first, cell, ranges, edges, distance
):
    """Return which cells a beam sees from a bucket that has not voted, and mark the bucket.

    Parameters
    ----------
    voted : ndarray of bool, shape (bearings, distances, cells)
        Changed in place. Cells come last, since neighbours mostly see a beam from one bucket.
    edges : ndarray, shape (n, 2)
        Directions of the borders of buckets inside of a quadrant; bearings is 4 (n + 1).
    distance : float
        Width of a bucket of ranges, metres.
    """
    distances, in_quadrant = voted.shape[1], edges.shape[0] + 1
    admitted = np.zeros(cell.size, np.bool_)
    for i in range(sensor_xy.shape[0]):
        x = (sensor_xy[i, 0] - origin_x) / resolution - 0.5
        y = (sensor_xy[i, 1] - origin_y) / resolution - 0.5
        for k in range(first[i], first[i + 1]):
            row = cell[k] // cols
            dx, dy = x - (cell[k] - row * cols), y - row
            # The bucket by comparing with its borders: cheaper than the angle.
            if dy >= 0.0:
                toward, u, v = (0, dx, dy) if dx > 0.0 else (in_quadrant, dy, -dx)
            elif dx < 0.0:
                toward, u, v = 2 * in_quadrant, -dx, -dy
            else:
                toward, u, v = 3 * in_quadrant, -dy, dx
            for e in range(edges.shape[0]):
                toward += v * edges[e, 0] >= u * edges[e, 1]
            far = min(np.int64(ranges[k] / distance), distances - 1)
            admitted[k] = not voted[toward, far, cell[k]]
            voted[toward, far, cell[k]] = True
    return admitted


@njit(error_model="numpy")
def admit_travel(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    last, sonar, travel, first, cell, step
):
    """Return which cells a sonar has not told anything since `step` of travel, and note it did.

    `last` is (cells, sonars): the travel in metres at which each last voted.
    """
    admitted = np.zeros(cell.size, np.bool_)
    for i in range(sonar.size):
        for k in range(first[i], first[i + 1]):
            if travel[i] - last[cell[k], sonar[i]] >= step:
                last[cell[k], sonar[i]] = travel[i]
                admitted[k] = True
    return admitted


@njit(error_model="numpy")
def add_costs(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    cost,
    seen,
    origin_x,
    origin_y,
    resolution,
    sensor_xy,
    axis_rad,
    reading,
    clear,
    half_angle,
    inflate,
    visible,
    bearing,
):
    """Update an 8-bit costmap (rows, cols) by beams as nav2's range layer does.

    `bearing` is the `bearing_polynomial` of the half-angle, `seen` marks the cells in a cone.
    """
    rows, cols = cost.shape
    for i in range(reading.size):
        z = reading[i]
        ox = (sensor_xy[i, 0] - origin_x) / resolution
        oy = (sensor_xy[i, 1] - origin_y) / resolution
        axis_x, axis_y = math.cos(axis_rad[i]), math.sin(axis_rad[i])
        to_x, to_y = ox + z / resolution * axis_x, oy + z / resolution * axis_y
        if 0 <= to_x < cols and 0 <= to_y < rows:
            cost[np.int64(to_y), np.int64(to_x)] = _TARGET_COST
            seen[np.int64(to_y), np.int64(to_x)] = True
        far = 1.2 * z / resolution
        # Whole numbers as a cast to int makes them: toward zero.
        o_x, o_y = np.int64(ox), np.int64(oy)
        a_x = np.int64(ox + far * math.cos(axis_rad[i] - half_angle))
        a_y = np.int64(oy + far * math.sin(axis_rad[i] - half_angle))
        b_x = np.int64(ox + far * math.cos(axis_rad[i] + half_angle))
        b_y = np.int64(oy + far * math.sin(axis_rad[i] + half_angle))
        least = -inflate * abs(0.5 * _orient(a_x, a_y, b_x, b_y, o_x, o_y))
        left, right = min(o_x, a_x, b_x), max(o_x, a_x, b_x)
        low, high = min(o_y, a_y, b_y), max(o_y, a_y, b_y)
        for row in range(max(np.int64(0), low), min(np.int64(rows - 1), high) + 1):
            for col in range(max(np.int64(0), left), min(np.int64(cols - 1), right) + 1):
                if inflate < 1.0 and (
                    _orient(a_x, a_y, b_x, b_y, col, row) < least
                    or _orient(b_x, b_y, o_x, o_y, col, row) < least
                    or _orient(o_x, o_y, a_x, a_y, col, row) < least
                ):
                    continue
                old = cost[row, col]
                if clear[i]:
                    cost[row, col] = _updated_cost(old, 0.0)
                    seen[row, col] = True
                    continue
                dx, dy = (col + 0.5 - ox) * resolution, (row + 0.5 - oy) * resolution
                r = math.sqrt(dx * dx + dy * dy)
                along = dx * axis_x + dy * axis_y
                # The model says 1/2 here and beside the cone, which changes none of the 255 costs.
                if along < 0.0 or r >= z * (1 + resolution):
                    continue
                t = abs(dx * axis_y - dy * axis_x) / max(r + along, 1e-300)
                share, power = 0.0, t
                for k in range(bearing.size):
                    share += bearing[k] * power
                    power *= t * t
                if share > 1.0:
                    continue
                seen[row, col] = True
                weight = (1 - (1 + math.tanh(2 * (r - visible))) / 2) * (1 - share * share)
                blur = resolution * z
                if r < z - 2 * blur:
                    p = (1 - weight) * 0.5
                elif r < z - blur:
                    depth = (r - (z - 2 * blur)) / blur
                    p = weight * 0.5 * depth * depth + (1 - weight) * 0.5
                else:
                    depth = (z - r) / blur
                    p = weight * (1 - 0.5 * depth * depth - 0.5) + 0.5
                cost[row, col] = _updated_cost(old, p)


@njit(inline="always", error_model="numpy")
def _updated_cost(cost, p):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    prior = cost / 254.0
    hit, miss = p * prior, (1 - p) * (1 - prior)
    # A cost of 254 that is told 0 has no quotient; what a cast makes of NaN there is 0.
    return np.uint8(254.0 * (hit / (hit + miss))) if hit + miss > 0.0 else np.uint8(0)


@njit(inline="always")
def _orient(a_x, a_y, b_x, b_y, x, y):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Twice the signed area of a triangle."""
    return (b_x - a_x) * (y - a_y) - (b_y - a_y) * (x - a_x)


@njit(error_model="numpy")
def add_fuzzy(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    empty,
    occupied,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    thickness,
    most_empty,
    most_occupied,
    visible,
    power,
):
    """Add the memberships' odds, to a power: Dombi's union is a sum of these."""
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            r = ranges[k]
            seen = 1.0 - shares[k] * shares[k]
            seen *= 1.0 - (1.0 + math.tanh(2.0 * (r - visible))) / 2.0
            depth = (z - r) / thickness
            c = cell[k]
            if depth > 0.0:
                a = most_empty * seen * min(depth * depth, 1.0)
                empty[c] += _odds(a, power)
            if echo[i] and abs(depth) < 1.0:
                a = most_occupied * seen * (1.0 - depth * depth)
                occupied[c] += _odds(a, power)


@njit(inline="always", error_model="numpy")
def _odds(a, power):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    odds = a / (1.0 - a)
    return odds if power == 1.0 else odds**power


@njit(error_model="numpy")
def add_profile(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds,
    seen,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    false_density,
    detection,
    detection_reach,
    sigma_0,
    sigma_slope,
    clear_sigmas,
    discount,
):
    """Add the range profile's log-odds, less where the beam crosses what is believed occupied."""
    root = math.sqrt(2 * math.pi)
    for i in range(reading.size):
        z = reading[i]
        nothing = 1.0 - false_density * z
        specular = 0.0
        if discount > 0.0:
            for k in range(first[i], first[i + 1]):
                r, believed = ranges[k], log_odds[cell[k]]
                if believed > 0.0 and r < z - clear_sigmas * (sigma_0 + sigma_slope * r):
                    crossed = math.tanh(believed / 2) * (1.0 - shares[k] * shares[k])
                    specular = max(specular, crossed)
        weight = 1.0 - discount * specular
        for k in range(first[i], first[i + 1]):
            r, c = ranges[k], cell[k]
            sigma = sigma_0 + sigma_slope * r
            alpha = detection * (1.0 - min(1.0, r / detection_reach))
            alpha *= 1.0 - shares[k] * shares[k]
            v = (z - r) / sigma
            ratio = 1.0
            if echo[i]:
                if v < -_TAIL:
                    continue
                heard = alpha
                if v < _TAIL:
                    ratio += alpha * math.exp(-0.5 * v * v) / (root * sigma * false_density)
                    heard *= 0.5 * math.erfc(-v / math.sqrt(2.0))
                ratio *= (nothing - heard) / nothing
            else:
                ratio = (nothing - alpha) / nothing
            log_odds[c] += weight * min(max(math.log(ratio), -_MOST_LOG_ODDS), _MOST_LOG_ODDS)
            seen[c] = True


@njit(error_model="numpy")
def add_votes(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    hits, passes, first, cell, ranges, reading
):
    """Count for each cell the beams that end in it, at their reading, and those that pass it."""
    for i in range(reading.size):
        for k in range(first[i], first[i + 1]):
            if ranges[k] == reading[i]:
                hits[cell[k]] += 1
            else:
                passes[cell[k]] += 1


@njit(inline="always", error_model="numpy")
def _sparse_kernel(d, length):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    if d >= length:
        return 0.0
    turn = 2 * math.pi * d / length
    return (2 + math.cos(turn)) * (1 - d / length) / 3 + math.sin(turn) / (2 * math.pi)


@njit(error_model="numpy")
def add_kernels(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied, free, first, cell, ranges, reading, echo, length, arc_weight
):
    """Add the kernels of beams' arcs, weighed by `arc_weight` (n,), and sectors to Beta counts."""
    for i in range(reading.size):
        z = reading[i]
        border = z - length if echo[i] else z
        for k in range(first[i], first[i + 1]):
            r, c = ranges[k], cell[k]
            if r <= border:
                free[c] += 1.0
            else:
                free[c] += _sparse_kernel(r - border, length) if border > 0.0 else 0.0
                if echo[i]:
                    occupied[c] += arc_weight[i] * _sparse_kernel(abs(r - z), length)


@njit(error_model="numpy")
def strongest_votes(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    pressure,
    occupied,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    half_angle_deg,
    square,
    slope,
    thickness,
    short,
):
    """Keep for each cell the vote of the beam whose sound is strongest there."""
    closer = math.log10(2.0)
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            r, t = ranges[k], shares[k] * half_angle_deg
            on_arc = echo[i] and abs(r - z) <= thickness
            if not on_arc and echo[i] and r >= z - thickness:
                continue
            sound = square * t * t + slope * t - math.log10(max(r, 1e-6))
            if on_arc and z <= short:
                sound += closer
            c = cell[k]
            if sound > pressure[c] or (sound == pressure[c] and on_arc):
                pressure[c], occupied[c] = sound, on_arc


@njit(error_model="numpy")
def judge_beams(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied, first, cell, ranges, reading, echo, thickness
):
    """Return which beams agree with a map of occupied cells, and the ranges as it mends them."""
    right = np.zeros(reading.size, np.bool_)
    mended = reading.copy()
    for i in range(reading.size):
        border = reading[i] - thickness if echo[i] else np.inf
        nearest, explained = np.inf, False
        for k in range(first[i], first[i + 1]):
            if occupied[cell[k]]:
                nearest = min(nearest, ranges[k])
                explained = explained or abs(ranges[k] - reading[i]) <= thickness
        right[i] = nearest >= border and (explained or not echo[i])
        if not right[i] and nearest < mended[i]:
            mended[i] = nearest
    return right, mended


@njit(error_model="numpy")
def mark_arcs(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    state, first, cell, ranges, reading, marking, thickness
):
    """Mark the arcs of beams that are `marking` with 1."""
    for i in range(reading.size):
        if marking[i]:
            for k in range(first[i], first[i + 1]):
                if abs(ranges[k] - reading[i]) <= thickness:
                    state[cell[k]] = 1


@njit(error_model="numpy")
def mark_free(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    state, first, cell, ranges, border
):
    """Mark the cells of beams before their `border` (n,) with -1."""
    for i in range(border.size):
        for k in range(first[i], first[i + 1]):
            if ranges[k] < border[i]:
                state[cell[k]] = -1
