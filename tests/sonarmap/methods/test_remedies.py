"""Remedies for repeated readings, before any method of evidence."""

import importlib
import math
import pickle

import numpy as np
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarmap.methods.bayes.updating import BayesUpdating
from sonarmap.methods.onepass import EvidenceMethod
from sonarmap.methods.remedies import Remedied

GRID = sm.GridSpec(0.1, (-2.5, -2.5), (50, 50))
EVIDENCE = [
    name
    for name, kind in sm.methods().items()
    if issubclass(kind, (BayesUpdating, EvidenceMethod)) and name != "nav2-range"
]
# A standing robot: all of its readings are one reading.
STANDING = make_log(np.full(1000, 1.0), y_m=0.02, heading_rad=0.3)
ALONE = STANDING.select(slice(1))
SELECTING = {
    "buckets": {"bucket_rad": math.radians(15), "bucket_m": 0.25},
    "travel": {"travel_m": 0.05},
    "both": {"bucket_rad": 0.5, "bucket_m": 1.0, "travel_m": 0.05},
}


@pytest.mark.parametrize("name", EVIDENCE)
@pytest.mark.parametrize("remedy", list(SELECTING))
def test_a_thousand_repeats_tell_no_more_than_one(name, remedy):
    method = sm.method(name)
    once = method.map(ALONE, GRID).probability
    p = Remedied(method=method, **SELECTING[remedy]).map(STANDING, GRID).probability
    np.testing.assert_allclose(p, once, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["bayes-parameterized", "thrun-inverse", "himm", "dempster-shafer"]
)
def test_without_a_remedy_they_do(name):
    method = sm.method(name)
    m, once = method.map(STANDING, GRID), method.map(ALONE, GRID)
    assert (m.log_odds - once.log_odds).max() > 1
    assert Remedied(method=method).map(STANDING, GRID).log_odds.tobytes() == m.log_odds.tobytes()


@pytest.mark.parametrize("name", EVIDENCE)
def test_a_robot_that_has_moved_tells_anew(name):
    # Ten places 6 cm apart, ten readings in each: as if there had been one in each.
    log = make_log(np.full(100, 1.0), x_m=np.repeat(np.arange(10) * 0.06, 10))
    spaced = log.select(slice(0, None, 10))
    method = sm.method(name)
    p = Remedied(method=method, travel_m=0.05).map(log, GRID).probability
    expected = method.map(spaced, GRID).probability
    if name in ("tbf", "konolige-style"):  # triangles need two; its own buckets give way
        assert np.isfinite(p).all()
    else:
        np.testing.assert_allclose(p, expected, atol=1e-12)


def slow_votes(log, grid, half_angle, reach_m, bucket_rad, bucket_m, travel_m):
    """Yield (reading, row, col) of the votes that count, one by one."""
    buckets, last, way = set(), {}, 0.0
    used = np.flatnonzero(log.usable & np.isfinite(log.range_m))
    for n, i in enumerate(used):
        if n:
            before = used[n - 1]
            way += math.hypot(log.x_m[i] - log.x_m[before], log.y_m[i] - log.y_m[before])
        x, y = log.sensor_xy_m[i]
        for row in range(grid.rows):
            for col in range(grid.cols):
                cx, cy = grid.centre_of(row, col)
                r = math.hypot(cx - x, cy - y)
                turn = math.remainder(math.atan2(cy - y, cx - x) - log.axis_rad[i], 2 * math.pi)
                if r > reach_m[i] or abs(turn) > half_angle:
                    continue
                if bucket_rad:
                    toward = math.atan2(y - cy, x - cx) % (2 * math.pi)
                    bucket = (row, col, int(toward / bucket_rad), int(r / bucket_m))
                    if bucket in buckets:
                        continue
                    buckets.add(bucket)
                if travel_m:
                    if way - last.get((row, col, log.sonar[i]), -math.inf) < travel_m:
                        continue
                    last[row, col, log.sonar[i]] = way
                yield i, row, col


@pytest.mark.parametrize(
    "remedy",
    [
        {"bucket_rad": math.pi / 6, "bucket_m": 0.4},
        {"travel_m": 0.3},
        {"bucket_rad": math.pi / 2, "bucket_m": 0.7, "travel_m": 0.2},
    ],
)
def test_the_compiled_votes_are_the_slow_ones(remedy, rng):
    log = random_log(rng, 60, reach_m=1.5, spread_m=0.5)
    walk = np.cumsum(rng.normal(0, 0.03, (60, 2)), axis=0)
    log = log.replace(x_m=walk[:, 0], y_m=walk[:, 1])
    grid = sm.GridSpec(0.17, (-1.3, -1.2), (14, 15))
    method = sm.method("thrun-inverse", no_echo="ignore")
    count = np.zeros(grid.shape)
    args = {"bucket_rad": 0, "bucket_m": 0, "travel_m": 0} | remedy
    reach_m = log.range_m + 0.1
    for i, row, col in slow_votes(log, grid, log.ring.half_angle_rad, reach_m, **args):
        cx, cy = grid.centre_of(row, col)
        r = math.hypot(cx - log.sensor_xy_m[i, 0], cy - log.sensor_xy_m[i, 1])
        count[row, col] += 0.4 if abs(r - log.range_m[i]) < 0.1 else -0.4
    made = Remedied(method=method, **remedy).map(log, grid)
    np.testing.assert_allclose(made.log_odds, count, atol=1e-9)
    assert (made.log_odds != method.map(log, grid).log_odds).mean() > 0.05


def test_votes_carry_over_from_part_to_part(rng, monkeypatch):
    log = random_log(rng, 80)
    remedied = Remedied(method=sm.method("himm"), **SELECTING["both"])
    cones = Remedied(method=sm.method("thrun-inverse"), **SELECTING["both"])
    whole = [each.map(log, GRID).log_odds for each in (remedied, cones)]
    monkeypatch.setattr(importlib.import_module("sonarmap.methods.cones"), "_PART_CELLS", 50)
    monkeypatch.setattr(importlib.import_module("sonarmap.methods.himm"), "_PART_BEAMS", 7)
    for each, expected in zip((remedied, cones), whole, strict=True):
        np.testing.assert_allclose(each.map(log, GRID).log_odds, expected, atol=1e-12)


def test_tempering_and_clamping_are_of_the_maps_log_odds(rng):
    log, method = random_log(rng, 60), sm.method("bayes-parameterized")
    plain = method.map(log, GRID).log_odds
    tempered = Remedied(method=method, temper=0.25).map(log, GRID)
    np.testing.assert_allclose(tempered.log_odds, plain / 4, atol=1e-9)
    clamped = Remedied(method=method, clamp=1.5).map(log, GRID)
    np.testing.assert_allclose(clamped.log_odds, plain.clip(-1.5, 1.5), atol=1e-9)
    # Any method has a map.
    flat = Remedied(method=sm.method("sheet"), clamp=1.0).map(log, GRID)
    assert flat.log_odds == pytest.approx(-1)
    assert flat.observed is not None


def test_it_is_a_mapping_method(rng):
    method = Remedied(method=sm.method("himm"), temper=0.5, **SELECTING["both"], clamp=3)
    assert isinstance(method, sm.MappingMethod)
    assert method.name == "himm, buckets 28.6479 deg 1 m, travel 0.05 m, temper 0.5, clamp 3"
    assert Remedied(method=sm.method("sheet")).name == "sheet"
    assert pickle.loads(pickle.dumps(method)) == method
    log = random_log(rng, 20)
    assert sm.Pipeline([], method).map(log, GRID).grid == GRID
    assert method.longest_reading_m(log.ring) == log.ring.range_max_m
    for end in ("low", "high"):
        Remedied(method=method.method, **{k: getattr(v, end) for k, v in Remedied.space().items()})


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"bucket_rad": 0.2}, "bucket_rad and bucket_m must be given together, got 0.2 and None"),
        ({"bucket_rad": 0, "bucket_m": 1}, "bucket_rad must be > 0, got 0"),
        ({"travel_m": -1}, "travel_m must be > 0, got -1"),
        ({"temper": 0}, r"temper must be in \(0, 1\], got 0"),
        ({"temper": 1.5}, r"temper must be in \(0, 1\], got 1.5"),
        ({"clamp": 0}, "clamp must be > 0, got 0"),
        ({"clamp": math.nan}, "clamp must be > 0, got nan"),
        (
            {"method": sm.method("sheet"), "travel_m": 0.1},
            "buckets and travel need a method of evidence, got 'sheet'",
        ),
    ],
)
def test_bad_remedies_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        Remedied(**{"method": sm.method("himm"), **parameters})


def test_nav2_takes_none():
    remedied = Remedied(method=sm.method("nav2-range"), travel_m=0.1)
    with pytest.raises(sm.InputError, match=r"^nav2-range takes no remedy"):
        remedied.map(ALONE, GRID)
