"""Reading scores: every number from eight readings counted by hand."""

import dataclasses
import json
import math

import numpy as np
import pytest

import sonarmap as sm
from sonarmap.scores.readings import BEYOND_M, Beyond, RangeErrors

INF = np.inf
D, OFF, OUT = sm.Cause.DIRECT, sm.Cause.OFF_AXIS, sm.Cause.OUT_OF_RANGE
BOUNCE, CROSS, DROP = sm.Cause.BOUNCE, sm.Cause.CROSSTALK, sm.Cause.DROPOUT

# cause, reading before, after, truth in the cone, truth on the axis; the ring sees 0.165 to 3 m.
ROWS = [
    (D, 1.00, 1.00, 1.00, 1.00),  # right, left alone
    (D, 2.00, 1.50, 2.00, 2.00),  # right, spoiled
    (OFF, 1.00, 1.25, 1.00, 1.20),  # right, updated, now near to the axis' truth: not spoiled
    (OUT, INF, INF, INF, INF),  # right, left alone
    (BOUNCE, 2.50, 1.35, 1.30, 1.40),  # wrong, mended
    (BOUNCE, INF, 1.80, 1.00, 1.00),  # wrong, updated, not mended
    (DROP, INF, INF, 0.80, 0.90),  # wrong, missed
    (CROSS, 0.30, 0.30, 2.00, INF),  # wrong (too short), missed
]


def log_of(rows, column, **changes):
    cause, *columns = (np.array(values) for values in zip(*rows, strict=True))
    n = len(rows)
    zeros = np.zeros(n)
    truth = sm.LogTruth(
        x_m=zeros,
        y_m=zeros,
        heading_rad=zeros,
        axis_range_m=columns[3],
        cone_range_m=columns[2],
        cause=cause,
        surface=[""] * n,
        incidence_rad=np.full(n, np.nan),
        bounces=np.zeros(n, int),
        collision=np.zeros(n, bool),
    )
    log = sm.SonarLog(
        ring=sm.AMIGOBOT,
        scan=np.arange(n) // 8,
        sonar=np.arange(n) % 8,
        time_s=np.arange(n) // 8 * 0.175,
        x_m=zeros,
        y_m=zeros,
        heading_rad=zeros,
        range_m=columns[column],
        truth=truth,
    )
    return log.replace(**changes)


def score_of(rows):
    return sm.score_readings(log_of(rows, 0), log_of(rows, 1))


SCORE = score_of(ROWS)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("wrong", 4),
        ("right", 4),
        ("wrong_updated", 2),
        ("right_updated", 2),
        ("mended", 1),
        ("spoiled", 1),
        ("precision", 2 / 4),
        ("recall", 2 / 4),
        ("mended_share", 1 / 4),
        ("spoiled_share", 1 / 4),
    ],
)
def test_counts_and_shares(name, value):
    assert getattr(SCORE, name) == value
    assert len(SCORE) == 8


def test_only_updated_readings_are_mended_or_spoiled():
    # A bounce that happens to be near the truth, and a right reading that is 0.2 m off.
    score = score_of([(BOUNCE, 1.05, 1.05, 1.0, 1.0), (D, 1.2, 1.2, 1.0, 1.0)])
    assert (score.mended, score.spoiled) == (0, 0)


@pytest.mark.parametrize(
    ("group", "when", "against", "errors_m"),
    [
        ("all", "before", "cone", [0, 0, 0, 0, 1.2, 2.0, 2.2, -1.7]),
        ("all", "after", "cone", [0, -0.5, 0.25, 0, 0.05, 0.8, 2.2, -1.7]),
        ("wrong", "before", "axis", [1.1, 2.0, 2.1, -2.7]),
        ("wrong", "after", "axis", [-0.05, 0.8, 2.1, -2.7]),
        ("right", "before", "axis", [0, 0, -0.2, 0]),
        ("right", "after", "axis", [0, -0.5, 0.05, 0]),
    ],
)
def test_errors(group, when, against, errors_m):
    found = SCORE.errors(group, when, against)
    size = np.sort(np.abs(errors_m))
    assert found.readings == len(errors_m)
    assert found.median_m == pytest.approx(np.median(size))
    assert found.p95_m == pytest.approx(np.percentile(size, 95))
    for beyond, limit_m in zip(found.beyond, BEYOND_M, strict=True):
        assert beyond == Beyond(
            limit_m, sum(e > limit_m for e in errors_m), sum(e < -limit_m for e in errors_m)
        )


@pytest.mark.parametrize(
    ("before_m", "true_m", "error_m"),
    [
        # No echo and anything farther than the ring's maximum are the same, on both sides.
        (INF, INF, 0),
        (INF, 1.0, 2.0),
        (1.0, INF, -2.0),
        (4.0, 3.5, 0),
        # So are too close and anything nearer than its minimum.
        (-INF, 0.1, 0),
        (-INF, 0.265, -0.1),
        (0.12, 0.1, 0),
    ],
)
def test_rule_for_no_echo_and_too_close(before_m, true_m, error_m):
    score = score_of([(D, before_m, before_m, true_m, true_m)])
    assert score.cone_before_m[0] == pytest.approx(error_m)
    assert score.axis_after_m[0] == pytest.approx(error_m)
    assert not score.updated[0]


def test_an_error_that_equals_a_limit_is_not_beyond_it():
    found = RangeErrors.of(np.array([1.1 - 1.0, 1.0 - 1.1, 1.3 - 1.0]))
    assert found.beyond == (Beyond(0.1, 1, 0), Beyond(0.3, 0, 0))


def test_scores_add_up_to_the_score_of_all_readings():
    total = score_of(ROWS[:3]) + score_of(ROWS[3:])
    assert total.to_dict() == SCORE.to_dict()


def test_a_stale_reading_is_not_scored():
    stale = np.arange(8) == 1
    score = sm.score_readings(log_of(ROWS, 0, stale=stale), log_of(ROWS, 1, stale=stale))
    assert (len(score), score.spoiled) == (7, 0)


def test_dict_is_json_and_tells_the_causes():
    told = json.loads(json.dumps(SCORE.to_dict(), allow_nan=False))
    assert told["causes"]["bounce"] == {"readings": 2, "updated": 2, "mended": 1, "spoiled": 0}
    assert told["causes"]["direct"] == {"readings": 2, "updated": 1, "mended": 0, "spoiled": 1}
    assert told["counts"]["readings"] == 8
    first = told["errors"]["wrong"]["before"]["cone"]["beyond"][0]
    assert (first["too_long"], first["too_short"], first["share"]) == (3, 1, 1.0)
    assert first["share_too_long"] == 0.75


def test_scores_of_nothing_are_not_defined():
    calm = score_of([(D, 1.0, 1.0, 1.0, 1.0)])
    assert math.isnan(calm.precision)
    assert math.isnan(calm.recall)
    told = calm.to_dict()
    assert told["precision"] is told["recall"] is None
    assert told["errors"]["wrong"]["after"]["axis"]["median_m"] is None
    assert told["errors"]["wrong"]["after"]["axis"]["beyond"][0]["share"] is None


def test_a_score_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        SCORE.updated = None
    with pytest.raises(ValueError, match="read-only"):
        SCORE.updated[0] = True


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ({"truth": None}, {}, "the log has no truth .*, needed for the score of readings"),
        ({}, {"sonar": np.arange(8)[::-1]}, r"after\.sonar\[0\] must be what it was before, got 7"),
        ({}, {"scan": np.arange(8)}, r"after\.scan\[1\] must be what it was before, got 1"),
        ({}, {"time_s": np.arange(8)}, r"after\.time_s\[1\] must be what it was before, got 1"),
        ({}, {"ring": sm.ring("pioneer3dx")}, "same ring, got 'amigobot' and 'pioneer3dx'"),
    ],
)
def test_logs_that_do_not_belong_together(before, after, message):
    with pytest.raises(sm.InputError, match=message):
        sm.score_readings(log_of(ROWS, 0, **before), log_of(ROWS, 1, **after))


def test_logs_of_different_length():
    with pytest.raises(sm.InputError, match="same readings, got 8 before and 7 after"):
        sm.score_readings(log_of(ROWS, 0), log_of(ROWS[:7], 1))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("wrogn", "before", "cone"), "group 'wrogn' is unknown; did you mean 'wrong'"),
        (("all", "befor", "cone"), "when 'befor' is unknown; did you mean 'before'"),
        (("all", "before", "beam"), "against 'beam' is unknown; known: axis, cone"),
    ],
)
def test_unknown_words(words, message):
    with pytest.raises(sm.InputError, match=message):
        SCORE.errors(*words)


# --- rejected and doubted readings ---------------------------------------------------------------

# Of the eight readings: is wrong 0 0 0 0 1 1 1 1.
REJECTED = [False, True, False, False, True, True, False, True]


def test_rejections_are_counted():
    score = sm.score_readings(log_of(ROWS, 0), log_of(ROWS, 0, rejected=REJECTED))
    assert (score.caught, score.lost) == (3, 1)
    assert (score.caught_share, score.lost_share) == (0.75, 0.25)
    assert score.wrong_updated == score.right_updated == 0
    told = json.loads(json.dumps(score.to_dict(), allow_nan=False))
    assert told["counts"]["caught"] == 3
    assert told["rejected"]["bounce"] == 2
    assert told["roc_auc"] is None  # nothing is doubted
    double = score + score
    assert (double.caught, double.lost, double.lost_share) == (6, 2, 0.25)


def test_what_was_rejected_before_is_not_judged():
    before = log_of(ROWS, 0, rejected=REJECTED)
    score = sm.score_readings(before, log_of(ROWS, 1, rejected=REJECTED))
    assert len(score) == 4
    assert (score.caught, score.lost) == (0, 0)


def test_a_filters_own_result_is_scored_as_its_log():
    after = log_of(ROWS, 1, rejected=REJECTED)
    filtered = sm.Filtered(after, np.zeros(8, bool))
    before = log_of(ROWS, 0)
    assert sm.score_readings(before, filtered).to_dict() == (
        sm.score_readings(before, after).to_dict()
    )


def doubts_of(wrong, doubt):
    """Return the score of readings that are wrong or right, with a doubt each."""
    rows = [(BOUNCE if each else D, 1.0, 1.0, 1.0, 1.0) for each in wrong]
    return sm.score_readings(log_of(rows, 0), log_of(rows, 0, doubt=doubt))


def slow_auc(wrong, doubt):
    pairs = [
        (a > b) + 0.5 * (a == b)
        for a, bad in zip(doubt, wrong, strict=True)
        if bad
        for b, also in zip(doubt, wrong, strict=True)
        if not also
    ]
    return np.mean(pairs)


@pytest.mark.parametrize(
    ("wrong", "doubt", "auc", "caught"),
    [
        ([1, 1, 0, 0], [0.9, 0.8, 0.2, 0.1], 1.0, 1.0),
        ([1, 1, 0, 0], [0.1, 0.2, 0.8, 0.9], 0.0, 0.0),
        ([1, 1, 0, 0], [0.5, 0.5, 0.5, 0.5], 0.5, 0.0),
        ([1, 1, 0, 0], [0.9, 0.3, 0.6, 0.1], 0.75, 0.5),
        ([1, 1, 0, np.nan], [0.9, 0.3, 0.6, 0.1], 0.5, 0.5),  # the last has no opinion
        ([1, 1, 1], [0.9, 0.3, 0.6], np.nan, np.nan),
    ],
)
def test_doubts_by_hand(wrong, doubt, auc, caught):
    unsure = np.isnan(wrong)
    score = doubts_of(np.nan_to_num(wrong), np.where(unsure, np.nan, doubt))
    assert score.roc_auc == pytest.approx(auc, nan_ok=True)
    assert score.caught_at_lost_1_percent == pytest.approx(caught, nan_ok=True)


def test_the_area_is_the_share_of_pairs_in_order(rng):
    wrong = rng.random(300) < 0.3
    doubt = np.round(np.clip(0.3 * wrong + 0.7 * rng.random(300), 0, 1), 2)  # with ties
    assert doubts_of(wrong, doubt).roc_auc == pytest.approx(slow_auc(wrong, doubt))


def test_one_in_a_hundred_right_readings_may_be_lost(rng):
    right = np.linspace(0.0, 0.5, 200)  # two of them may be lost: 0.5 and the one before
    wrong = np.array([0.6, 0.499, 0.4975, 0.49, 0.1])
    score = doubts_of(np.arange(205) >= 200, np.concatenate([right, wrong]))
    allowed = np.sort(right)[-3]
    assert score.caught_at_lost_1_percent == (wrong > allowed).mean() == 0.6
