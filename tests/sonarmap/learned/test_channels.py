"""The evidence of a log: against plain loops, and by what must hold of it."""

import math

import numpy as np
import pytest
from support import ONE, THREE, make_log, random_log

import sonarmap as sm
from sonarmap.kernels import evidence
from sonarmap.kernels.competition import claims
from sonarmap.kernels.listed_cones import ListedCones
from sonarmap.learned.channels import CHANNELS, TURNING, channels, telling

GRID = sm.GridSpec(0.05, (-1.5, -1.4), (56, 61))
LIMITS = (0.075, 0.05, 0.4, 1.5, 0.2, 0.5, 0.7, 8.0)
NAMES = list(CHANNELS)


def plain_sums(log, reading, echo, steady, vote, bins, arc_weight, travel):
    """The sums of every cell, cell by cell and reading by reading."""
    tolerance, _, depth, short, core, middle, near, farthest = LIMITS
    sums = np.zeros((*GRID.shape, evidence.SUMS))
    passed, hit = np.zeros(GRID.shape, int), np.zeros(GRID.shape, int)
    nearest = np.full((*GRID.shape, 3), 5.0)
    for i in range(len(log)):
        x, y = log.sensor_xy_m[i]
        r = reading[i]
        for row in range(GRID.rows):
            for col in range(GRID.cols):
                cx, cy = GRID.centre_of(row, col)
                rho = math.hypot(cx - x, cy - y)
                off = math.remainder(math.atan2(cy - y, cx - x) - log.axis_rad[i], 2 * math.pi)
                share = abs(off) / log.ring.half_angle_rad
                if share > 1:
                    continue
                cell, beam = sums[row, col], 1 - share**2
                if not echo[i]:
                    if rho < r:
                        place = evidence.NONE_AXIS if share <= middle else evidence.NONE_EDGE
                        if rho >= near:
                            cell[evidence.NONE_FAR] += vote[i] * beam
                        else:
                            cell[place] += vote[i]
                            cell[evidence.TIMID] -= 0.1 * vote[i] * beam * (1 - rho / farthest)
                elif rho < r - tolerance:
                    place = evidence.PASS_AXIS if share <= middle else evidence.PASS_EDGE
                    cell[place] += vote[i]
                    cell[evidence.PASS_CORE] += vote[i] * (share <= core)
                    cell[evidence.PASS_SHORT] += vote[i] * (r <= short)
                    cell[evidence.PASS_STEADY] += vote[i] * steady[i]
                    cell[evidence.TIMID] -= 0.3 * vote[i] * beam * (1 - rho / farthest)
                    passed[row, col] |= 1 << bins[i]
                    nearest[row, col, 0] = min(nearest[row, col, 0], rho)
                    nearest[row, col, 2] = min(nearest[row, col, 2], travel[i])
                elif rho <= r + tolerance:
                    w = vote[i] * (1 - abs(rho - r) / tolerance)
                    place = evidence.HIT_AXIS if share <= middle else evidence.HIT_EDGE
                    cell[place] += w * arc_weight[i]
                    cell[evidence.HIT_ALL] += w
                    cell[evidence.HIT_CORE] += w * (share <= core)
                    cell[evidence.HIT_FAR] += w * arc_weight[i] * (r > short)
                    cell[evidence.HIT_STEADY] += w * arc_weight[i] * steady[i]
                    cell[evidence.HIT_TRAVEL] += w * arc_weight[i] * travel[i]
                    cell[evidence.TIMID] += 6 * w * arc_weight[i] * beam
                    hit[row, col] |= 1 << bins[i]
                    nearest[row, col, 1] = min(nearest[row, col, 1], rho)
                elif rho <= r + depth:
                    cell[evidence.SHADOW] += vote[i] * beam
    return sums, passed, hit, nearest


def test_the_sums_are_those_of_plain_loops(rng):
    log = random_log(rng, 18, reach_m=1.6)
    log = log.select(log.usable & (log.range_m >= 0))
    n = len(log)
    echo = np.isfinite(log.range_m)
    assert echo.any()
    assert not echo.all()
    reading = np.where(echo, log.range_m, 1.0)
    steady, vote = rng.random(n) < 0.5, rng.uniform(0.1, 1, n)
    bins, weight = rng.integers(16, size=n), rng.uniform(0.1, 1, n)
    travel = rng.uniform(0, 4, n)
    cones = ListedCones.on(
        GRID, log.sensor_xy_m, log.axis_rad, log.ring.half_angle_rad, reading + 0.4 * echo
    )
    sums = np.zeros((GRID.rows * GRID.cols, evidence.SUMS), np.float32)
    passed, hit = (np.zeros(GRID.rows * GRID.cols, np.uint16) for _ in range(2))
    nearest = np.full((GRID.rows * GRID.cols, 3), 5.0, np.float32)
    evidence.sum_evidence(
        cones.first,
        cones.cell,
        cones.range_m,
        cones.share,
        reading,
        echo,
        steady,
        vote,
        bins,
        weight,
        travel,
        LIMITS,
        sums,
        passed,
        hit,
        nearest,
    )
    wanted = plain_sums(log, reading, echo, steady, vote, bins, weight, travel)
    np.testing.assert_allclose(sums.reshape(*GRID.shape, -1), wanted[0], atol=1e-5)
    np.testing.assert_array_equal(passed.reshape(GRID.shape), wanted[1])
    np.testing.assert_array_equal(hit.reshape(GRID.shape), wanted[2])
    np.testing.assert_allclose(nearest.reshape(*GRID.shape, 3), wanted[3], atol=1e-6)


def test_the_shares_of_arcs_are_those_of_plain_loops(rng):
    grid = sm.GridSpec(0.1, (0.2, -0.3), (5, 7))
    p = rng.uniform(0.02, 0.9, 35)
    first = np.array([0, 6, 6, 15])
    cell = rng.permutation(35)[:15].astype(np.int32)
    claim = rng.uniform(-1, 1, 15).astype(np.float32)
    vote, places = np.array([0.5, 1.0, 1.0]), rng.normal(size=(3, 2))
    out = np.zeros((35, 4))
    evidence.arc_shares(p, first, cell, claim, vote, places, 0.05, 7, (0.2, -0.3, 0.1), out)
    wanted = np.zeros((35, 4))
    for i in range(3):
        arc = [k for k in range(first[i], first[i + 1]) if claim[k] > 0]
        odds = {k: claim[k] * p[cell[k]] / (1 - p[cell[k]]) for k in arc}
        for k in arc:
            share = odds[k] / (sum(odds.values()) + 0.05)
            x, y = grid.centre_of(cell[k] // 7, cell[k] % 7)
            angle = math.atan2(y - places[i, 1], x - places[i, 0])
            part = vote[i] * share * np.array([1, math.cos(2 * angle), math.sin(2 * angle)])
            wanted[cell[k], :3] += part
            wanted[cell[k], 3] = max(wanted[cell[k], 3], share)
    np.testing.assert_allclose(out, wanted, atol=1e-6)


def test_claims_are_those_of_the_competition(rng):
    log = random_log(rng, 30, reach_m=1.6)
    log = log.select(log.usable & (log.range_m >= 0))
    n, echo = len(log), np.isfinite(log.range_m)
    reading = np.where(echo, log.range_m, 1.0)
    reach = reading + 0.4 * echo
    half_angle = log.ring.half_angle_rad
    cones = ListedCones.on(GRID, log.sensor_xy_m, log.axis_rad, half_angle, reach)
    cells = (cones.first, cones.cell, cones.range_m, cones.share)
    ones, layers = np.ones(n), np.zeros((GRID.rows * GRID.cols, evidence.SUMS), np.float32)
    bits = [np.zeros(GRID.rows * GRID.cols, np.uint16) for _ in range(2)]
    nearest = np.zeros((GRID.rows * GRID.cols, 3), np.float32)
    bins = np.zeros(n, int)
    of, cell, claim = evidence.sum_evidence(
        *cells, reading, echo, echo, ones, bins, ones, ones, LIMITS, layers, *bits, nearest
    )
    # No echo counts up to 0.7 m.
    believed = np.where(echo, reading, 0.7)
    every = claims(cones.first, cones.range_m, cones.share, believed, echo, 0.05, 8.0)
    np.testing.assert_array_equal(claim, every[every != 0])
    np.testing.assert_array_equal(cell, cones.cell[every != 0])
    assert of[-1] == claim.size
    assert of[3] == (every[: cones.first[3]] != 0).sum()


def test_every_channel_says_something_and_none_is_large():
    drive = driven(np.random.default_rng(5), 60)
    grid = sm.GridSpec(0.05, (-4.5, -4.5), (180, 170))
    stack = channels(drive, grid)
    assert stack.dtype == np.float32
    assert stack.shape == (len(CHANNELS), *grid.shape)
    for name, layer in zip(CHANNELS, stack, strict=True):
        assert np.ptp(layer) > 0.01, name
        assert np.abs(layer).max() < 4, name


def driven(rng, scans):
    """Return a log of THREE on a straight way, its readings about what a square room would give."""
    # Nowhere on the border of a cell, which belongs to one side.
    at = np.repeat(np.linspace(-0.813, 0.827, scans), 3)
    sonar = np.tile(np.arange(3), scans)
    log = make_log(
        np.ones(3 * scans),
        ring=THREE,
        sonar=sonar,
        x_m=at,
        y_m=0.3 * at + 0.0137,
        heading_rad=0.3 + 0 * at,
    )
    across = np.maximum(np.abs(np.cos(log.axis_rad)), np.abs(np.sin(log.axis_rad)))
    range_m = np.clip(1.2 / across - 0.3 * np.abs(at) + rng.normal(0, 0.02, at.size), 0.1, 2)
    return log.replace(range_m=np.where(rng.random(at.size) < 0.15, np.inf, range_m))


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_turns_the_channels(quarters):
    log = driven(np.random.default_rng(1), 40)
    grid = sm.GridSpec(0.05, (-1.5, -1.5), (60, 60))
    angle = quarters * math.pi / 2
    cos, sin = round(math.cos(angle)), round(math.sin(angle))
    turned = log.replace(
        x_m=cos * log.x_m - sin * log.y_m,
        y_m=sin * log.x_m + cos * log.y_m,
        heading_rad=log.heading_rad + angle,
    )
    wanted = np.rot90(channels(log, grid), -quarters, axes=(1, 2)).copy()
    if quarters % 2:
        for name in TURNING:
            wanted[NAMES.index(name)] *= -1
    np.testing.assert_allclose(channels(turned, grid), wanted, atol=1e-3)


def test_a_mirror_mirrors_the_channels():
    log = driven(np.random.default_rng(2), 40)
    grid = sm.GridSpec(0.05, (-1.5, -1.5), (60, 60))
    ring = THREE.to_dict() | {
        "y_m": [-y for y in THREE.y_m],
        "heading_rad": [-each for each in THREE.heading_rad],
    }
    mirrored = log.replace(
        ring=sm.SonarRing.from_dict(ring), y_m=-log.y_m, heading_rad=-log.heading_rad
    )
    wanted = channels(log, grid)[:, ::-1].copy()
    wanted[NAMES.index("sin_2")] *= -1
    np.testing.assert_allclose(channels(mirrored, grid), wanted, atol=1e-3)


def test_exact_repeats_are_told_once_wherever_they_stand():
    log = driven(np.random.default_rng(3), 20)
    order = np.concatenate([np.arange(len(log)), np.full(500, 7)])
    columns = {
        name: getattr(log, name)[order]
        for name in ("sonar", "x_m", "y_m", "heading_rad", "range_m")
    }
    n = order.size
    repeated = sm.SonarLog(log.ring, np.arange(n), time_s=np.arange(n), **columns)
    assert len(telling(repeated)) == len(telling(log))


def test_what_a_place_keeps_is_bounded(rng):
    log = random_log(rng, 20_000, spread_m=0.2)
    kept = telling(log)
    # 0.7 m a side with the sonars: 9 to 16 squares, 16 directions of 6 readings.
    assert len(kept) <= 16 * 16 * 6
    assert np.ptp(np.flatnonzero(np.isin(log.time_s, kept.time_s))) > 15_000


def test_readings_that_may_not_be_used_are_not():
    log = make_log([1.0, 1.2, -np.inf, 0.8], stale=[True, False, False, False])
    log = log.replace(rejected=np.array([False, True, False, False]))
    assert telling(log).range_m.tolist() == [0.8]


def test_the_least_ring_and_no_echo_alone_have_channels():
    stack = channels(make_log([np.inf], ring=ONE), GRID)
    assert np.isfinite(stack).all()
    assert stack[NAMES.index("none_axis")].max() > 0
    assert stack[NAMES.index("hit_all")].max() == 0
