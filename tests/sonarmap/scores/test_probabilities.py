"""Skill, average precision and calibration, by hand and beside slow twins; bad maps as a table."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import binary_dilation

import sonarmap as sm
from sonarmap.scores.probabilities import ProbabilityCounts

FREE, OCCUPIED, HIDDEN = 0, 1, 2


def pair(p, occupied):
    """Return a map and its truth, a row of cells."""
    p, occupied = np.atleast_2d(p), np.atleast_2d(occupied)
    grid = sm.GridSpec(0.05, (0, 0), p.shape)
    return (
        sm.OccupancyMap.from_probability(grid, p),
        SimpleNamespace(grid=grid, state=occupied.astype(np.uint8)),
    )


def score_of(p, occupied):
    return sm.score_map(*pair(p, occupied))


@pytest.fixture
def room(rng):
    """Walls of a room of 60 x 80 cells with a box in it: 7 % of its cells."""
    walls = np.zeros((60, 80), bool)
    walls[[0, -1]] = walls[:, [0, -1]] = True
    walls[20:24, 30:34] = True
    return walls


def slow_average_precision(p, occupied):
    """Sum of precision times added recall, threshold by threshold."""
    area, found_before = 0.0, 0
    for threshold in sorted(set(p), reverse=True):
        marked = p >= threshold
        found = int((marked & occupied).sum())
        area += found / marked.sum() * (found - found_before) / occupied.sum()
        found_before = found
    return area


def test_average_precision_is_that_of_every_threshold(rng):
    occupied = rng.random(2000) < 0.1
    p = np.clip(0.5 * occupied + rng.normal(0.3, 0.2, 2000), 0.01, 0.99)
    # Cells whose log-odds differ by less than 0.02 count as equal: so are these.
    log_odds = np.round(np.log(p / (1 - p)) / 0.02) * 0.02 + 0.01
    p = 1 / (1 + np.exp(-log_odds))
    counts = ProbabilityCounts.of(p, occupied)
    assert counts.average_precision == pytest.approx(slow_average_precision(p, occupied), abs=1e-9)


@pytest.mark.parametrize(
    ("p", "occupied", "expected"),
    [
        ([0.9, 0.8, 0.2, 0.1], [1, 1, 0, 0], 1.0),
        ([0.1, 0.2, 0.8, 0.9], [1, 0, 0, 0], 0.25),
        ([0.5, 0.5, 0.5, 0.5], [1, 0, 0, 0], 0.25),
        ([0.9, 0.8, 0.7, 0.1], [1, 0, 1, 0], (1 + 2 / 3) / 2),
    ],
)
def test_average_precision_by_hand(p, occupied, expected):
    score = score_of(p, occupied)
    assert score.average_precision == pytest.approx(expected)
    assert score.to_dict()["average_precision"] == pytest.approx(expected)


def test_the_sheet_has_no_skill_and_perfect_maps_reach_the_ceiling(room):
    share = room.mean()
    assert score_of(np.full(room.shape, share), room).skill == pytest.approx(0, abs=1e-12)
    perfect = score_of(room.astype(float), room)
    assert perfect.skill == pytest.approx(perfect.skill_ceiling)
    assert 0.95 < perfect.skill_ceiling < 0.97
    assert perfect.average_precision == 1


def test_skill_is_the_information_gained_over_the_sheet(room, rng):
    p = np.where(room, 0.7, 0.05)
    score = score_of(p, room)
    q = room.mean()
    loss = -np.log2(np.where(room, p, 1 - p)).mean()
    sheet = -(q * math.log2(q) + (1 - q) * math.log2(1 - q))
    assert score.skill == pytest.approx(1 - loss / sheet)
    assert score.loss_bits == pytest.approx(loss * room.size)
    assert score.map_score == pytest.approx(1 - loss)


# The pathological maps, and between what their skill lies: map of the walls -> P(occupied).
BAD = {
    "all free": (lambda walls: np.zeros(walls.shape), -0.30, -0.15),
    "all occupied": (np.ones_like, -20, -15),
    "all unknown": (lambda walls: np.full(walls.shape, 0.5), -2.1, -2.0),
    "the sheet": (lambda walls: np.full(walls.shape, walls.mean()), -1e-9, 1e-9),
    "truth shifted by a cell": (lambda walls: np.roll(walls, 1, axis=1), -0.6, 0.6),
    "truth with a wall missing": (
        lambda walls: np.where(np.arange(walls.shape[1]) == 0, 0, walls),
        0.5,
        0.95,
    ),
    "truth with thick walls": (binary_dilation, -2, 0.4),
}


@pytest.mark.parametrize("name", BAD)
def test_pathological_maps(name, room):
    make, low, high = BAD[name]
    score = score_of(make(room).astype(float), room)
    assert low <= score.skill <= high
    assert score.skill <= score.recalibrated_skill + 1e-9
    assert -1e-9 <= score.recalibrated_skill <= score.skill_ceiling + 1e-9


def test_skill_is_not_defined_without_a_wall():
    score = score_of(np.full(10, 0.1), np.zeros(10))
    assert math.isnan(score.skill)
    assert math.isnan(score.average_precision)
    assert score.to_dict()["skill"] is None


def test_skill_pools_over_rooms_by_both_sums(room):
    one = score_of(np.where(room, 0.8, 0.1), room)
    bare = np.zeros((60, 80), bool)
    bare[0, :3] = True
    other = score_of(np.where(bare, 0.4, 0.3), bare)
    both = one + other
    assert both.skill == pytest.approx(
        1 - (one.loss_bits + other.loss_bits) / (one.sheet_loss_bits + other.sheet_loss_bits)
    )
    # One nearly empty room ruins a mean, not the pool.
    assert (one.skill + other.skill) / 2 < -1 < both.skill
    assert both.probabilities == one.probabilities + other.probabilities
    assert both.average_precision < one.average_precision + 1


def test_a_map_that_is_right_about_its_doubt_is_calibrated(rng):
    p = rng.uniform(0.02, 0.9, 40_000)
    occupied = rng.random(p.size) < p
    score = score_of(p, occupied)
    assert score.calibration_error < 0.01
    assert score.recalibrated_skill - score.skill < 0.005
    bins = score.probabilities.reliability
    assert len(bins) == 15
    assert sum(each.cells for each in bins) == p.size
    assert min(each.cells for each in bins) > 0.8 * p.size / 15
    for each in bins:
        assert each.true == pytest.approx(each.stated, abs=0.04)


def test_overconfidence_is_what_recalibration_wins_back(rng):
    honest = rng.uniform(0.02, 0.6, 40_000)
    occupied = rng.random(honest.size) < honest
    log_odds = 4 * np.log(honest / (1 - honest))
    boasting = score_of(1 / (1 + np.exp(-log_odds)), occupied)
    calm = score_of(honest, occupied)
    assert boasting.calibration_error > 0.1 > calm.calibration_error
    assert boasting.skill < 0 < calm.skill
    assert boasting.recalibrated_skill == pytest.approx(calm.recalibrated_skill, abs=1e-3)
    assert boasting.average_precision == pytest.approx(calm.average_precision, abs=2e-3)


@pytest.mark.parametrize("p", [0.0, 1e-9, 0.5, 1 - 1e-9, 1.0])
def test_any_probability_has_a_class(p):
    counts = ProbabilityCounts.of(np.array([p]), np.array([True]))
    assert counts.occupied.sum() == 1
    assert counts.stated.sum() == p
