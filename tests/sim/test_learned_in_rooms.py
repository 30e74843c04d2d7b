"""The learned mapper in rooms: what it has learned, and what must hold of real maps."""

import functools
import math
import operator

import gymnasium
import numpy as np
import pytest

import sonarmap as sm
import worlds
from sim import simulate
from sim.sonar.presets import PHYSICAL


@functools.cache
def drive(room="thesis-exp1", scans=150):
    """Return a log of a shipped room, its truth and which cells could be seen."""
    sonar = PHYSICAL.replace(search="images")
    log = simulate(worlds.load(room), scans=scans, seed=3, sonar=sonar, engine="segments")
    truth = worlds.truth(worlds.load(room))
    return log, truth, truth.observable(log)


def learned(log, grid):
    return sm.method("learned").map(log, grid)


def turned(log, quarters):
    cos, sin = round(math.cos(quarters * math.pi / 2)), round(math.sin(quarters * math.pi / 2))
    return log.replace(
        x_m=cos * log.x_m - sin * log.y_m,
        y_m=sin * log.x_m + cos * log.y_m,
        heading_rad=log.heading_rad + quarters * math.pi / 2,
    )


def square_over(truth):
    """Return a square grid about the origin over a room, so that it turns into itself."""
    half = math.ceil(max(map(abs, truth.grid.extent_m)) / 0.05)
    return sm.GridSpec(0.05, (-half * 0.05, -half * 0.05), (2 * half, 2 * half))


def test_it_knows_a_room_that_it_has_never_seen():
    log, truth, observable = drive()
    score = sm.score_map(learned(log, truth.grid), truth, observable=observable)
    assert score.skill > 0.5
    assert score.f1(1) > 0.8
    # Of one room; over all of them it is a third of this.
    assert score.calibration_error < 0.04
    rival = sm.method("bayes-parameterized").map(log, truth.grid)
    assert sm.score_map(rival, truth, observable=observable).skill < 0


def test_probabilities_are_calibrated_in_rooms_that_were_never_seen():
    scores = []
    for room in worlds.names():
        log, truth, observable = drive(room)
        scores.append(sm.score_map(learned(log, truth.grid), truth, observable=observable))
    assert functools.reduce(operator.add, scores).calibration_error <= 0.02


def test_what_was_observed_is_about_what_could_be_seen():
    log, truth, observable = drive()
    observed = learned(log, truth.grid).observed
    known = truth.state != worlds.HIDDEN
    assert (observed == observable)[known].mean() > 0.9


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_turns_the_map(quarters):
    log, truth, _ = drive()
    grid = square_over(truth)
    p = np.rot90(learned(log, grid).probability, -quarters)
    assert np.abs(learned(turned(log, quarters), grid).probability - p).mean() < 0.02


def test_a_mirror_mirrors_the_map():
    log, truth, _ = drive()
    grid = square_over(truth)
    ring = log.ring.to_dict()
    for name in ("y_m", "heading_rad"):
        ring[name] = [-value for value in ring[name]]
    mirrored = log.replace(
        ring=sm.SonarRing.from_dict(ring), y_m=-log.y_m, heading_rad=-log.heading_rad
    )
    p = learned(log, grid).probability[::-1]
    assert np.abs(learned(mirrored, grid).probability - p).mean() < 0.02


@pytest.mark.parametrize("place", ["where it stands", "at the end"])
def test_a_thousand_repeats_of_one_reading_move_no_cell(place):
    log, truth, _ = drive()
    row = 500
    rows = np.concatenate([np.arange(len(log)), np.full(1000, row)])
    rows = np.sort(rows) if place == "where it stands" else rows
    columns = {name: getattr(log, name)[rows] for name in sm.SonarLog.DTYPES}
    columns |= {"scan": np.arange(rows.size), "time_s": np.arange(rows.size)}
    more = learned(sm.SonarLog(log.ring, **columns), truth.grid).probability
    assert np.abs(more - learned(log, truth.grid).probability).max() <= 0.02


def test_noisy_repeats_of_a_standing_robot_hardly_count(rng):
    log, truth, _ = drive()
    rows = np.sort(np.concatenate([np.arange(len(log)), np.full(1000, 500)]))
    columns = {name: getattr(log, name)[rows] for name in sm.SonarLog.DTYPES}
    columns |= {"scan": np.arange(rows.size), "time_s": np.arange(rows.size)}
    columns["range_m"] = columns["range_m"] + (rows == 500) * rng.normal(0, 0.003, rows.size)
    more = learned(sm.SonarLog(log.ring, **columns), truth.grid).probability
    assert np.abs(more - learned(log, truth.grid).probability).mean() <= 0.005


@pytest.mark.parametrize("resolution_m", [0.025, 0.1])
def test_other_resolutions_are_calibrated_too(resolution_m):
    log, _, _ = drive()
    truth = worlds.truth(worlds.load("thesis-exp1"), resolution_m=resolution_m)
    m = learned(log, truth.grid)
    score = sm.score_map(m, truth, observable=truth.observable(log))
    assert score.skill > 0.3
    # Of one small room: a few hundred cells.
    assert score.calibration_error < 0.08


def test_parts_of_a_grid_are_as_the_whole():
    log, truth, _ = drive()
    whole = learned(log, truth.grid).probability
    x_m, y_m = truth.grid.origin_xy_m
    part = learned(log, sm.GridSpec(0.05, (x_m + 0.8, y_m + 0.4), (40, 32))).probability
    # All but near the border, where the whole saw more.
    assert np.abs(part - whole[8:48, 16:48])[8:-8, 8:-8].mean() < 0.02


def test_thresholds_are_those_of_the_weights_unless_given():
    log, truth, _ = drive()
    m = learned(log, truth.grid)
    assert 0.1 <= m.occupied_from < 0.65
    other = sm.method("learned", occupied_from=0.5, free_up_to=0.2).map(log, truth.grid)
    assert (other.occupied_from, other.free_up_to) == (0.5, 0.2)
    np.testing.assert_array_equal(other.probability, m.probability)


def test_a_map_of_the_past_is_made_anew_as_the_robot_drives():
    log, truth, observable = drive()
    state = sm.method("learned").begin(log.ring, truth.grid)
    first = state.map
    assert not first.observed.any()
    seen, maps = 0, []
    for row in range(400):
        state.add(log.select(slice(row, row + 1)))
        made = state.map
        seen += made is not (maps[-1] if maps else first)
        maps.append(made)
    # Far more readings than maps, and each map is of the past alone.
    assert 3 < seen < 100
    state.add(log.select(slice(400, None)))
    whole = learned(log, truth.grid)
    np.testing.assert_array_equal(state.map.probability, whole.probability)
    early = sm.score_map(maps[-1], truth, observable=observable)
    assert early.skill < sm.score_map(whole, truth, observable=observable).skill
    assert not first.observed.any()


def test_environments_map_by_it():
    env = gymnasium.make(
        "sim:sonarbed/Explore-v1", world="thesis-exp1", map_method="learned", map_patch=16
    )
    env.reset(seed=0)
    for _ in range(3):
        _, _, _, _, info = env.step(env.action_space.sample())
    assert info["mapped_share"] > 0
    env.close()
