"""The filter by the learned map: its walk against plain loops, and what must hold of it."""

import dataclasses
import math

import numpy as np
import pytest
from learned_weights import small_weights
from support import ONE, make_log, random_log

import sonarmap as sm
from sonarmap.errors import InputError
from sonarmap.kernels.along import walk
from sonarmap.learned.readings import CANDIDATES, FEATURES, candidates_of, features_of


def plain_walk(p, grid, place, angle, reading, reach, step, offsets, levels):
    """One ray, step by step."""
    survival, falls, mean = np.ones(len(offsets)), np.full(len(levels), reach), 0.0
    s, noted, peak, done = 1.0, np.zeros(len(offsets), bool), [0.0, 0.0], False
    for k in range(math.ceil(reach / step)):
        r = (k + 0.5) * step
        due = (reading + offsets <= r) & ~noted
        survival[due], noted = s, noted | due
        row, col = grid.cell_of(place[0] + r * math.cos(angle), place[1] + r * math.sin(angle))
        if grid.contains(row, col):
            if r < reading - 0.12:
                peak[0] = max(peak[0], p[row, col])
            elif r <= reading + 0.12:
                peak[1] = max(peak[1], p[row, col])
            if not done:
                s *= (1 - min(p[row, col], 0.999)) ** (step / grid.resolution_m)
        if done:
            continue
        mean += s * step
        falls = np.where((s < levels) & (falls == reach), r, falls)
        done = s < 1e-3
    survival[~noted] = s
    return survival, falls, mean, peak


def test_the_walk_is_that_of_plain_loops(rng):
    grid = sm.GridSpec(0.1, (-1, -0.8), (17, 21))
    p = rng.random(grid.shape) ** 3
    places, axes = rng.uniform(-0.7, 0.7, (6, 2)), rng.uniform(-4, 4, 6)
    bearings, readings = np.array([-0.2, 0.0, 0.3]), rng.uniform(0.2, 2, 6)
    offsets, levels = np.array([-0.3, 0.0, 0.2]), np.array([0.8, 0.4])
    survival, falls, mean, peak = walk(
        p, (-1, -0.8, 0.1), places, axes, bearings, readings, 2.0, 0.03, offsets, levels, 0.12
    )
    for i in range(6):
        for ray in range(3):
            wanted = plain_walk(
                p, grid, places[i], axes[i] + bearings[ray], readings[i], 2.0, 0.03, offsets, levels
            )
            np.testing.assert_allclose(survival[i, ray], wanted[0], atol=1e-9)
            np.testing.assert_allclose(falls[i, ray], wanted[1])
            assert mean[i, ray] == pytest.approx(wanted[2])
            np.testing.assert_allclose(peak[i, ray], wanted[3])


def test_the_names_of_features_and_candidates_are_as_many_as_there_are(rng):
    log = random_log(rng, 40)
    log = log.select(log.usable & (log.range_m >= 0))
    m = sm.method("learned").map(log, sm.grid_over(log))
    features, candidate_m = features_of(log, m)
    assert features.shape == (len(log), len(FEATURES))
    assert candidate_m.shape == (len(log), len(CANDIDATES))
    assert np.isfinite(features).all()
    assert len(set(FEATURES)) == len(FEATURES)


def test_candidates_are_the_nearest_of_all_of_the_inner_rays_and_the_axis():
    falls = np.arange(35, dtype=float).reshape(1, 7, 5)[:, ::-1]
    found = candidates_of(falls, 99.0)
    assert found.tolist() == [[*range(5), *range(10, 15), *range(15, 20), 99]]


@pytest.mark.parametrize("range_m", [[], [-np.inf], [np.inf], [1.0]])
def test_the_least_logs_are_judged(range_m):
    log = make_log(range_m or [1.0], ring=ONE)
    log = log if range_m else log.select(slice(0))
    made = sm.filter("consistency", mode="mend").apply(log)
    assert len(made.log) == len(log)
    too_close = log.range_m == -np.inf
    assert np.isnan(made.doubt[too_close]).all()
    assert (made.likely_cause[too_close] == -1).all()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"mode": "drop"}, "mode 'drop' is unknown"),
        ({"lost_share": 0.5}, r"lost_share must be within \[0.0003, 0.2\], got 0.5"),
        ({"least_confidence": 2}, r"least_confidence must be within \[0, 1\], got 2"),
        ({"weights": 3}, "weights must be the path of a file, got 3"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(InputError, match=message):
        sm.filter("consistency", **parameters)


def test_weights_without_a_judge_or_with_another_one_are_refused(rng, tmp_path):
    weights = small_weights(rng)
    path = str(tmp_path / "w.npz")
    weights.save(path)
    with pytest.raises(InputError, match=r"w\.npz: the weights judge no readings"):
        sm.filter("consistency", weights=path).apply(make_log([1.0]))
    other = {"mean": np.zeros(3, np.float32), "threshold": np.ones(2), "lost_share": np.ones(2)}
    path = str(tmp_path / "other.npz")
    dataclasses.replace(weights, reading=other).save(path)
    with pytest.raises(InputError, match=r"must have \d+ features, got 3: .* another version"):
        sm.filter("consistency", weights=path).apply(make_log([1.0]))
