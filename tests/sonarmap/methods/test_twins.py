"""Each method against its plain twin: the equations as they are written, cell by cell."""

import math

import numpy as np
import pytest
from support import THREE, random_log

import sonarmap as sm
from sonarmap.methods.cones import beams_of

GRID = sm.GridSpec(0.09, (-1.1, -0.9), (21, 25))


def beams(log, method):
    """Yield (row of the log, reading, was there an echo) of the readings that say anything."""
    limit = method.longest_reading_m(log.ring)
    for i in range(len(log)):
        if log.stale[i] or log.rejected[i] or log.range_m[i] == -math.inf:
            continue
        echo = log.range_m[i] <= limit
        if echo or method.no_echo == "clear":
            yield i, (log.range_m[i] if echo else limit), bool(echo)


def cone(log, i, grid, half_angle):
    """Yield (row, col, range, bearing / half-angle) of the cells in a cone, however far."""
    x, y = log.sensor_xy_m[i]
    for row in range(grid.rows):
        for col in range(grid.cols):
            cx, cy = grid.centre_of(row, col)
            turn = math.remainder(math.atan2(cy - y, cx - x) - log.axis_rad[i], 2 * math.pi)
            if abs(turn) <= half_angle:
                yield row, col, math.hypot(cx - x, cy - y), abs(turn) / half_angle


def logistic(log_odds):
    return 0.5 * (1 + np.tanh(log_odds / 2))


def plain_thrun(log, grid, m):
    log_odds = np.zeros(grid.shape)
    for i, z, echo in beams(log, m):
        for row, col, r, _ in cone(log, i, grid, log.ring.half_angle_rad):
            if r > min(m.longest_reading_m(log.ring), z + m.thickness_m / 2):
                continue
            if echo and abs(r - z) < m.thickness_m / 2:
                log_odds[row, col] += m.occupied_log_odds
            elif r <= z:
                log_odds[row, col] += m.free_log_odds
    return logistic(log_odds)


def plain_free_space(log, grid, m):
    p = np.full(grid.shape, m.share)
    for i in np.flatnonzero(log.usable):
        for row in range(grid.rows):
            for col in range(grid.cols):
                x, y = grid.centre_of(row, col)
                if math.hypot(x - log.x_m[i], y - log.y_m[i]) <= m.radius_m:
                    p[row, col] = m.driven
    return p


def normal(v):
    return math.exp(-v * v / 2) / math.sqrt(2 * math.pi), (1 + math.erf(v / math.sqrt(2))) / 2


def plain_gaussian(log, grid, m):
    log_odds = np.zeros(grid.shape)
    half, rate = log.ring.half_angle_rad, m.density_per_m
    for i, z, echo in beams(log, m):
        for row, col, r, share in cone(log, i, grid, half):
            if r > z + (5 * m.sigma_m if echo else 0):
                continue
            w = m.detection * math.exp(
                -((share * half) ** 2) / (2 * (m.sigma_rad or half / 2) ** 2)
            )
            ratio = 1 - w
            if echo:
                density, below = normal((r - z) / m.sigma_m + rate * m.sigma_m)
                ratio += w * (below + density / (rate * m.sigma_m))
            log_odds[row, col] += math.log(ratio)
    return logistic(log_odds)


def dempster(a, b):
    """Combine masses (occupied, free, unknown) by Dempster's rule."""
    (o1, f1, u1), (o2, f2, u2) = a, b
    k = o1 * f2 + f1 * o2
    return (
        (o1 * o2 + o1 * u2 + u1 * o2) / (1 - k),
        (f1 * f2 + f1 * u2 + u1 * f2) / (1 - k),
        u1 * u2 / (1 - k),
    )


def plain_dempster_shafer(log, grid, m):
    masses = {}
    far = m.longest_reading_m(log.ring)
    for i, z, echo in beams(log, m):
        for row, col, r, share in cone(log, i, grid, log.ring.half_angle_rad):
            b = ((far - r) / far + 1 - share) / 2
            if r < z - m.tolerance_m:
                p, textbook = 1 - b, (0, b, 1 - b)
            elif echo and r <= z + m.tolerance_m:
                p = b * m.max_occupied
                textbook = (p, 0, 1 - p)
            else:
                continue
            if m.matching == "textbook":
                said = textbook
            elif m.matching == "pignistic":
                said = (max(0, 2 * p - 1), max(0, 1 - 2 * p), 1 - abs(2 * p - 1))
            elif p >= 0.5:
                said = ((2 * p - 1) / p, 0, (1 - p) / p)
            else:
                said = (0, (1 - 2 * p) / (1 - p), p / (1 - p))
            masses[row, col] = dempster(masses.get((row, col), (0, 0, 1)), said)
    p = np.full(grid.shape, 0.5)
    for place, (o, f, u) in masses.items():
        p[place] = (o + u) / (o + f + 2 * u) if m.matching == "plausibility" else o + u / 2
    return p


def on_line(grid, x, y, end_x, end_y):
    """Return the cells that a line passes through, by its samples at each tenth of a millimetre."""
    t = np.linspace(0, 1, 2 + int(1e4 * math.hypot(end_x - x, end_y - y)))
    row, col = grid.cell_of(x + t * (end_x - x), y + t * (end_y - y))
    inside = grid.contains(row, col)
    return list(dict.fromkeys(zip(row[inside].tolist(), col[inside].tolist(), strict=True)))


def plain_himm(log, grid, m):
    count, seen = np.zeros(grid.shape), np.zeros(grid.shape, bool)
    for i, z, echo in beams(log, m):
        (x, y), axis = log.sensor_xy_m[i], log.axis_rad[i]
        end = x + z * math.cos(axis), y + z * math.sin(axis)
        hit = tuple(int(index) for index in grid.cell_of(*end)) if echo else None
        for place in on_line(grid, x, y, *end):
            seen[place] = True
            if place != hit:
                count[place] = max(count[place] - m.down, 0)
        if hit and grid.contains(*hit):
            row, col = hit
            block = count[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2].sum()
            count[hit] = min(count[hit] + m.up + m.growth * (block - count[hit]), m.top)
    return np.where(seen, count / m.top, 0.5)


def plain_moravec_elfes(log, grid, m):
    emp, occ = np.zeros(grid.shape), np.zeros(grid.shape)
    e, nearest = m.error_m, log.ring.range_min_m
    for i, z, _ in beams(log, m):
        for row, col, r, share in cone(log, i, grid, log.ring.half_angle_rad):
            if nearest <= r <= z - e:
                p = (1 - ((r - nearest) / (z - e - nearest)) ** 2) * (1 - share**2)
                emp[row, col] += p - emp[row, col] * p
    for i, z, echo in beams(log, m):
        arc = {
            (row, col): (1 - ((r - z) / e) ** 2) * (1 - share**2) * (1 - emp[row, col])
            for row, col, r, share in cone(log, i, grid, log.ring.half_angle_rad)
            if echo and abs(r - z) <= e
        }
        total = sum(arc.values())
        for place, p in arc.items():
            p = p / total if total > 1e-3 else p
            occ[place] += p - occ[place] * p
    return (1 + np.where(occ >= emp, occ, -emp)) / 2


def plain_nav2(log, grid, m):
    cost = np.full(grid.shape, 127)
    q, half = grid.resolution_m, log.ring.half_angle_rad
    far = m.longest_reading_m(log.ring)

    def to_cell(x, y, rule):
        return (
            rule((x - grid.origin_xy_m[0]) / grid.resolution_m),
            rule((y - grid.origin_xy_m[1]) / grid.resolution_m),
        )

    def side(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    for i, z, _ in beams(log, m):
        if z < log.ring.range_min_m:
            continue
        (x, y), axis = log.sensor_xy_m[i], log.axis_rad[i]
        col, row = to_cell(x + z * math.cos(axis), y + z * math.sin(axis), math.floor)
        if grid.contains(row, col):
            cost[row, col] = 233
        corners = [to_cell(x, y, int)] + [
            to_cell(x + 1.2 * z * math.cos(axis + a), y + 1.2 * z * math.sin(axis + a), int)
            for a in (-half, half)
        ]
        o, a, b = corners
        cols, rows = zip(*corners, strict=True)
        for col in range(max(0, min(cols)), min(grid.cols - 1, max(cols)) + 1):
            for row in range(max(0, min(rows)), min(grid.rows - 1, max(rows)) + 1):
                least = -m.inflate_cone * abs(side(a, b, o)) / 2
                sides = [side(a, b, (col, row)), side(b, o, (col, row)), side(o, a, (col, row))]
                if m.inflate_cone < 1 and min(sides) < least:
                    continue
                cx, cy = grid.centre_of(row, col)
                r = math.hypot(cx - x, cy - y)
                bearing = math.remainder(math.atan2(cy - y, cx - x) - axis, 2 * math.pi)
                gamma = 1 - (bearing / half) ** 2 if abs(bearing) <= half else 0
                lam = (1 - (1 + math.tanh(2 * (r - m.phi_m))) / 2) * gamma
                if z >= far and m.no_echo == "clear":
                    p = 0
                elif r < z - 2 * q * z:
                    p = (1 - lam) / 2
                elif r < z - q * z:
                    p = lam / 2 * ((r - (z - 2 * q * z)) / (q * z)) ** 2 + (1 - lam) / 2
                elif r < z + q * z:
                    p = lam * (1 - ((z - r) / (q * z)) ** 2 / 2 - 0.5) + 0.5
                else:
                    p = 0.5
                prior = cost[row, col] / 254
                odds = p * prior, (1 - p) * (1 - prior)
                cost[row, col] = int(254 * (odds[0] / sum(odds))) if sum(odds) else 0
    return cost / 254


def plain_fuzzy(log, grid, m):
    def dombi(a, b):
        """Return the union of two memberships."""
        if a == 0 or b == 0:
            return max(a, b)
        total = (1 / a - 1) ** -m.power + (1 / b - 1) ** -m.power
        return 1 / (1 + total ** (-1 / m.power))

    empty, occupied = np.zeros(grid.shape), np.zeros(grid.shape)
    for i, z, echo in beams(log, m):
        for row, col, r, share in cone(log, i, grid, log.ring.half_angle_rad):
            seen = (1 - share**2) * (1 - (1 + math.tanh(2 * (r - m.visible_m))) / 2)
            if r < z:
                e = m.most_empty * seen * min((z - r) / m.thickness_m, 1) ** 2
                empty[row, col] = dombi(empty[row, col], e)
            if echo and abs(r - z) < m.thickness_m:
                o = m.most_occupied * seen * (1 - ((r - z) / m.thickness_m) ** 2)
                occupied[row, col] = dombi(occupied[row, col], o)
    if m.reading == "difference":
        return (1 + occupied - empty) / 2
    ambiguous, unknown = empty * occupied, (1 - empty) * (1 - occupied)
    safe = empty**2 * (1 - occupied) * (1 - ambiguous) * (1 - unknown)
    return np.where((empty > 0) | (occupied > 0), 1 - safe, 0.5)


def plain_konolige(log, grid, m):
    log_odds, voted = np.zeros(grid.shape), set()
    limit = m.longest_reading_m(log.ring)
    f = m.false_share / limit
    for i, z, echo in beams(log, m):
        admitted = []
        for row, col, r, share in cone(log, i, grid, log.ring.half_angle_rad):
            if r > z + (5 * (m.sigma_m + m.sigma_slope * z) if echo else 0):
                continue
            cx, cy = grid.centre_of(row, col)
            x, y = log.sensor_xy_m[i]
            toward = math.floor(math.degrees(math.atan2(y - cy, x - cx)) / 15) % 24
            bucket = (row, col, toward, min(int(r / m.bucket_m), int(limit / m.bucket_m)))
            if m.bucket_rad == 0 or bucket not in voted:
                admitted.append((row, col, r, share))
            voted.add(bucket)
        q = max(
            (
                math.tanh(log_odds[row, col] / 2) * (1 - share**2)
                for row, col, r, share in admitted
                if r < z - 3 * (m.sigma_m + m.sigma_slope * r)
            ),
            default=0,
        )
        for row, col, r, share in admitted:
            delta = m.sigma_m + m.sigma_slope * r
            alpha = m.detection * (1 - min(1, r / m.detection_reach_m)) * (1 - share**2)
            density, below = normal((z - r) / delta)
            if echo:
                ratio = (alpha * density / delta + f) / f * (1 - alpha * below - f * z)
            else:
                ratio = 1 - alpha - f * z
            log_odds[row, col] += (1 - m.specular * max(q, 0)) * math.log(ratio / (1 - f * z))
    return logistic(log_odds)


def crossings(log, i, j, half, least_angle):
    """Return the bearings on arc i at which it crosses arc j, by the law of cosines."""
    (xi, yi), (xj, yj) = log.sensor_xy_m[[i, j]]
    a, b, d = log.range_m[i], log.range_m[j], math.hypot(xj - xi, yj - yi)
    if d == 0 or not abs(a - b) <= d <= a + b:
        return []
    between = math.acos((a * a + b * b - d * d) / (2 * a * b))
    if min(between, math.pi - between) < least_angle:
        return []
    found = []
    for side in (-1, 1):
        direction = math.atan2(yj - yi, xj - xi) + side * math.acos(
            (a * a + d * d - b * b) / (2 * a * d)
        )
        x, y = xi + a * math.cos(direction), yi + a * math.sin(direction)
        on_i = math.remainder(direction - log.axis_rad[i], 2 * math.pi)
        on_j = math.remainder(math.atan2(y - yj, x - xj) - log.axis_rad[j], 2 * math.pi)
        if max(abs(on_i), abs(on_j)) <= half:
            found.append(on_i)
    return found


def plain_points(log, grid, m, bearing):
    """Make the map of points: `bearing` returns that of a row's target, or None."""
    hits, passes = np.zeros(grid.shape), np.zeros(grid.shape)
    for i, z, echo in beams(log, m):
        for row, col, r, _ in cone(log, i, grid, log.ring.half_angle_rad):
            passes[row, col] += r <= z - (m.tolerance_m if echo else 0)
        target = bearing(i) if echo else None
        if target is not None:
            axis = log.axis_rad[i] + target
            x, y = log.sensor_xy_m[i]
            at = grid.cell_of(x + z * math.cos(axis), y + z * math.sin(axis))
            if grid.contains(*at):
                hits[tuple(at)] += 1
    w = m.point_weight
    return (1 + (w * hits - passes) / (w * hits + passes + 1)) / 2


def median_bearing(log, echoes, i, m):
    """Return the bearing of a reading's target by the arc-transversal median, or None."""
    half = log.ring.half_angle_rad
    found = [b for j in echoes for b in crossings(log, i, j, half, m.crossing_rad) if j != i]
    lonely = None if m.lonely == "drop" else 0.0
    return float(np.median(found)) if found else lonely


def cluster_bearing(log, echoes, i, m):
    """Return the bearing of a reading's triangulation point, or None."""
    half, at = log.ring.half_angle_rad, echoes.index(i)
    window = echoes[max(at - m.window_scans * len(log.ring), 0) : at]
    found = sorted(b for j in window for b in crossings(log, i, j, half, m.crossing_rad))
    clusters = [
        [b for b in found if begin <= b <= begin + m.cluster_m / log.range_m[i]] for begin in found
    ]
    best = max(clusters, key=lambda each: (len(each), -abs(np.mean(each))), default=[])
    return float(np.mean(best)) if len(best) >= m.least else None


def plain_atm(log, grid, m):
    echoes = [i for i, _, echo in beams(log, m) if echo]
    return plain_points(log, grid, m, lambda i: median_bearing(log, echoes, i, m))


def plain_tbf(log, grid, m):
    echoes = [i for i, _, echo in beams(log, m) if echo]
    return plain_points(log, grid, m, lambda i: cluster_bearing(log, echoes, i, m))


def plain_bki(log, grid, m):
    def kernel(d):
        d = abs(d) / m.length_m
        if d >= 1:
            return 0
        turn = 2 * math.pi * d
        return (2 + math.cos(turn)) / 3 * (1 - d) + math.sin(turn) / (2 * math.pi)

    a, b = np.full(grid.shape, m.prior), np.full(grid.shape, m.prior)
    half = log.ring.half_angle_rad
    for i, z, echo in beams(log, m):
        weight = max(2 * half * z / grid.resolution_m, 1) ** -m.spread
        end = z - m.length_m if echo else z
        for row, col, r, _ in cone(log, i, grid, half):
            if not echo and r > z:
                continue
            b[row, col] += kernel(max(r - end, 0)) if end > 0 else 0
            a[row, col] += weight * kernel(r - z) if echo else 0
    return a / (a + b)


def plain_conflict_evaluation(log, grid, m):
    half, beta = log.ring.half_angle_rad, m.thickness_m
    read = [
        (z, echo, list(cone(log, i, grid, half)), (log.x_m[i], log.y_m[i]))
        for i, z, echo in beams(log, m)
    ]
    best = {}
    for z, echo, cells, _ in read:
        for row, col, r, share in cells:
            occupied = echo and abs(r - z) <= beta
            if not occupied and r >= (z - beta if echo else z):
                continue
            t = math.degrees(share * half)
            pressure = -0.00102 * t * t + 0.00241 * t - math.log10(r)
            pressure += math.log10(2) if occupied and z <= m.short_m else 0
            best[row, col] = max(best.get((row, col), (-1000, False)), (pressure, occupied))
    path = set()
    for *_, (x, y) in read:
        at_row, at_col = (int(index) for index in grid.cell_of(x, y))
        beside = range(-m.path_cells, m.path_cells + 1)
        path |= {(at_row + a, at_col + b) for a in beside for b in beside}
    wall = {place for place, (_, occupied) in best.items() if occupied} - path
    state, free = np.zeros(grid.shape), []
    for z, echo, cells, _ in read:
        met = [r for row, col, r, _ in cells if (row, col) in wall and r <= z + beta * echo]
        before = [r for r in met if not echo or r < z - beta]
        right = not before and (bool(met) or not echo)
        for row, col, r, _ in cells:
            if right and echo and abs(r - z) <= beta:
                state[row, col] = 1
        border = (z - beta if echo else z) if right else min([z, *met]) - beta
        free += [(row, col) for row, col, r, _ in cells if r < border]
    for place in (*free, *path):
        if grid.contains(*place):
            state[place] = -1
    return (1 + state) / 2


CASES = [
    ("atm", {}, plain_atm),
    ("atm", {"lonely": "centre", "crossing_rad": 0.9, "point_weight": 5.0}, plain_atm),
    ("atm", {"no_echo": "clear"}, plain_atm),
    ("bki", {}, plain_bki),
    ("bki", {"no_echo": "clear", "spread": 0.4, "prior": 0.2, "length_m": 0.1}, plain_bki),
    ("conflict-evaluation-style", {}, plain_conflict_evaluation),
    (
        "conflict-evaluation-style",
        {"no_echo": "ignore", "path_cells": 0, "thickness_m": 0.1, "short_m": 1.0},
        plain_conflict_evaluation,
    ),
    ("tbf", {"least": 1}, plain_tbf),
    ("tbf", {"least": 2, "cluster_m": 0.4, "window_scans": 5, "no_echo": "clear"}, plain_tbf),
    ("fuzzy", {}, plain_fuzzy),
    ("fuzzy", {"reading": "unsafe", "no_echo": "clear", "power": 1.7}, plain_fuzzy),
    ("konolige-style", {}, plain_konolige),
    ("konolige-style", {"bucket_rad": 0.0, "sigma_m": 0.05, "specular": 0.7}, plain_konolige),
    ("konolige-style", {"no_echo": "ignore", "bucket_m": 0.5, "specular": 0.0}, plain_konolige),
    ("nav2-range", {}, plain_nav2),
    ("nav2-range", {"inflate_cone": 0.2, "phi_m": 2.0}, plain_nav2),
    ("nav2-range", {"no_echo": "clear"}, plain_nav2),
    ("bayes-gaussian", {}, plain_gaussian),
    ("bayes-gaussian", {"no_echo": "clear", "sigma_rad": 0.4, "sigma_m": 0.1}, plain_gaussian),
    ("dempster-shafer", {"matching": "textbook"}, plain_dempster_shafer),
    ("dempster-shafer", {"matching": "pignistic", "no_echo": "clear"}, plain_dempster_shafer),
    ("dempster-shafer", {"matching": "plausibility"}, plain_dempster_shafer),
    ("himm", {}, plain_himm),
    ("himm", {"growth": 0.5, "up": 2.0}, plain_himm),
    ("himm", {"no_echo": "ignore"}, plain_himm),
    ("moravec-elfes", {}, plain_moravec_elfes),
    ("moravec-elfes", {"no_echo": "clear", "error_m": 0.12}, plain_moravec_elfes),
    ("free-space", {}, plain_free_space),
    ("thrun-inverse", {}, plain_thrun),
    ("thrun-inverse", {"no_echo": "ignore", "occupied_log_odds": 1.3}, plain_thrun),
]


@pytest.mark.parametrize(("name", "parameters", "twin"), CASES)
def test_the_compiled_map_is_the_plain_one(name, parameters, twin, rng):
    log = random_log(rng, 30, reach_m=1.5, spread_m=0.8)
    if "max_range_m" in vars(sm.method(name)):
        parameters = {"max_range_m": 1.2, **parameters}  # some readings are above it
    method = sm.method(name, **parameters)
    p = twin(log, GRID, method)
    assert (p != np.median(p)).mean() > 0.02, "the case says nothing"
    np.testing.assert_allclose(method.map(log, GRID).probability, p, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "parameters", "twin"),
    [
        ("atm", {}, median_bearing),
        ("atm", {"crossing_rad": 1.0}, median_bearing),
        ("tbf", {"least": 1, "cluster_m": 0.2}, cluster_bearing),
        ("tbf", {"least": 2, "cluster_m": 0.3, "window_scans": 20}, cluster_bearing),
    ],
)
def test_the_targets_on_crowded_arcs_are_the_plain_ones(name, parameters, twin, rng):
    ring = sm.SonarRing.from_dict(THREE.to_dict() | {"half_angle_rad": 0.7})
    log = random_log(rng, 150, ring=ring, reach_m=1.2, spread_m=0.5)
    log = log.select(log.usable & np.isfinite(log.range_m))
    method = sm.method(name, **parameters)
    scene = method.scene(log.ring, GRID)
    bearings = method.bearings_rad(scene, beams_of(log, scene.limit_m, "ignore"))
    echoes = list(range(len(log)))
    plain = [twin(log, echoes, i, method) for i in echoes]
    assert plain.count(None) < 0.7 * len(plain), "the case says nothing"
    np.testing.assert_allclose(bearings, np.array(plain, float), atol=1e-9)
