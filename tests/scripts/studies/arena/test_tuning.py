"""Fair tuning, and what tuned=True stands for."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import sonarmap as sm
import worlds
from sonarbed.studies.arena import tuning
from sonarbed.studies.arena.entries import Entry, all_entries
from sonarbed.studies.arena.plan import FIRST_SEED, full
from sonarmap import tuned
from sonarmap.methods.recalibrated import Recalibrated
from sonarmap.parameters import at_point


@pytest.fixture
def shipped(tmp_path, monkeypatch):
    """A result of tuning, in place of the one that ships."""
    result = {
        "methods": {
            "himm": {"point": {"up": 2.0, "top": 12.0, "growth": 0.0}, "logistic": [0.5, -1]}
        },
        "filters": {"eeruf": {"point": {"tolerance_m": 0.123}}},
    }
    monkeypatch.setattr(tuned, "_shipped", lambda: result)


def test_tuned_parts_have_the_values_of_the_tuning(shipped):
    made = sm.method("himm", tuned=True)
    assert (made.up, made.top) == (2.0, 12.0)
    assert sm.method("himm", tuned=True, up=3.0).up == 3.0
    assert sm.method("himm").up != 2.0
    assert sm.filter("eeruf", tuned=True).tolerance_m == 0.123
    fitted = sm.method("himm", tuned="logistic")
    assert isinstance(fitted, Recalibrated)
    assert (fitted.slope, fitted.intercept, fitted.method) == (0.5, -1.0, made)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sm.method("sheet", tuned=True), "method 'sheet' has no tuned parameters"),
        (lambda: sm.filter("hsr", tuned=True), "filter 'hsr' has no tuned parameters"),
        (
            lambda: sm.method("himm", tuned="yes"),
            "tuned must be False, True or 'logistic', got 'yes'",
        ),
        (lambda: sm.filter("eeruf", tuned="logistic"), "tuned must be True or False"),
        (lambda: sm.method("himm", tuned=True, upp=1), "has no parameter 'upp'"),
        (lambda: sm.method("himm", tuned=True, up=-1.0), "up must be"),
    ],
)
def test_what_was_not_tuned_is_refused(shipped, make, message):
    with pytest.raises(sm.InputError, match=message):
        make()


def test_entries_have_a_row_for_each_variant(shipped):
    labels = [entry.label for entry in all_entries()]
    assert {"himm", "himm (tuned)", "himm (logistic)"} <= set(labels)
    assert "eeruf + arc-competition (tuned)" in labels
    assert len(set(labels)) == len(labels)
    filter_, method = Entry("arc-competition", "eeruf", "tuned").made()
    assert (filter_.tolerance_m, method) == (0.123, sm.method("arc-competition"))


def test_a_recalibrated_map_ranks_as_before_and_moves_its_thresholds(rng):
    grid = sm.GridSpec(0.1, (0.0, 0.0), (6, 7))
    p = rng.uniform(0.02, 0.98, grid.shape)

    def given(log, on):
        return sm.OccupancyMap.from_probability(on, p)

    method = Recalibrated(_Own(given), 0.4, -1.5)
    m = method.map(None, grid)
    odds = np.log(p / (1 - p))
    assert np.allclose(m.log_odds, 0.4 * odds - 1.5)
    before = sm.OccupancyMap.from_probability(grid, p)
    assert np.array_equal(m.occupied, before.occupied)
    assert np.array_equal(m.free, before.free)


class _Own:
    name, source = "own", "the test"

    def __init__(self, function):
        self.function = function

    def map(self, log, grid):
        return self.function(log, grid)


def test_tuning_beats_the_paper_in_its_rooms_and_its_rooms_are_its_own(tmp_path, monkeypatch):
    monkeypatch.setattr(tuning, "TRAINING_ROOMS", 2)
    monkeypatch.setattr(tuning, "_SCANS", 25)
    monkeypatch.setattr(
        sm, "methods", lambda: {"bayes-standard": sm.method("bayes-standard").__class__}
    )
    monkeypatch.setattr(sm, "filters", lambda: {"eeruf": type(sm.filter("eeruf"))})
    tuning._drives.cache_clear()
    found = tuning.tune_all(tmp_path / "tuned.json", budget=8, seed=1, jobs=1)
    tuning._drives.cache_clear()
    assert json.loads((tmp_path / "tuned.json").read_text()) == json.loads(json.dumps(found))
    told = found["methods"]["bayes-standard"]
    assert told["skill"] > told["published_skill"]
    slope, intercept = told["logistic"]
    assert 0 <= slope < 1
    assert intercept < 0
    arena = {room.name for room in full().rooms}
    assert not arena & set(found["rooms"])
    assert all(int(name.rsplit("-", 1)[1]) < FIRST_SEED for name in found["rooms"])


def test_what_no_trial_beats_stays_as_it_was_published(monkeypatch):
    monkeypatch.setattr(tuning, "_skill_of", lambda task, point: 0.25)
    told = tuning._tuned(tuning._Task("filter", "eeruf", budget=3, seed=0))
    assert told == {"point": {}, "skill": 0.25, "published_skill": 0.25}


def test_a_point_without_coordinates_is_the_published_part():
    for name, part in sm.methods().items():
        assert at_point(part, {}) == sm.method(name)


def test_a_map_that_ranks_wrongly_is_told_to_say_nothing(monkeypatch):
    grid = sm.GridSpec(0.1, (0.0, 0.0), (10, 10))
    walls = np.arange(100).reshape(10, 10) < 6
    truth = SimpleNamespace(grid=grid, state=np.where(walls, worlds.OCCUPIED, worlds.FREE))
    monkeypatch.setattr(tuning, "_drives", lambda: [(None, truth, np.ones((10, 10), bool))])

    def wrong(log, on):
        return sm.OccupancyMap.from_probability(on, np.where(walls, 0.2, 0.7))

    slope, intercept = tuning._logistic(_Own(wrong))
    made = Recalibrated(_Own(wrong), slope, intercept).map(None, grid)
    assert np.allclose(made.probability, 0.06, atol=0.001)
    with pytest.raises(sm.InputError, match=r"slope must be .*> 0"):
        Recalibrated(_Own(wrong), 0.0, 0.0)
