"""Median of repeats, against a plain loop and by hand."""

import math
import statistics

import numpy as np
import pytest
from support import THREE, make_log, random_log

import sonarmap as sm

INF = math.inf


def plain(f, log):
    """The median around each reading: a loop over readings, sorted by hand."""
    medians = []
    for i in range(len(log)):
        rows = [
            k
            for k in range(len(log))
            if log.sonar[k] == log.sonar[i]
            and log.usable[k]
            and (f.no_echo == "farthest" or log.range_m[k] != INF)
        ]
        if i not in rows:
            medians.append(math.nan)
            continue
        at = rows.index(i)
        near = []
        for k in rows[max(0, at - f.each_side) : at + f.each_side + 1]:
            turn = math.remainder(log.heading_rad[k] - log.heading_rad[i], 2 * math.pi)
            moved = math.hypot(log.x_m[k] - log.x_m[i], log.y_m[k] - log.y_m[i])
            if moved <= f.travel_m and abs(turn) <= f.turn_rad:
                near.append(log.range_m[k])
        medians.append(statistics.median_low(near))
    return medians


@pytest.mark.parametrize("no_echo", ["farthest", "ignore"])
def test_equals_a_plain_loop(no_echo, rng):
    f = sm.filter("median-of-repeats", travel_m=1.0, turn_rad=2.0, no_echo=no_echo)
    log = random_log(rng, 300)
    np.testing.assert_array_equal(f.apply(log).predicted_range_m, plain(f, log))


def test_a_lone_wild_reading_is_mended_or_rejected():
    log = make_log([1.0, 1.01, 2.5, 1.02, 1.03])
    made = sm.filter("median-of-repeats", tolerance_m=0.1).apply(log)
    assert made.log.range_m.tolist() == [1.0, 1.01, 1.02, 1.02, 1.03]
    assert made.changed.tolist() == [False, False, True, False, False]
    made = sm.filter("median-of-repeats", tolerance_m=0.1, action="reject").apply(log)
    assert made.rejected.tolist() == [False, False, True, False, False]
    assert not made.changed.any()


def test_the_published_rule_replaces_every_reading_by_the_median():
    log = make_log([1.0, 1.4, 1.2, INF, 1.1])
    made = sm.filter("median-of-repeats", each_side=1).apply(log)
    assert made.log.range_m.tolist() == [1.0, 1.2, 1.4, 1.2, 1.1]


def test_no_echo_is_the_longest_range_or_no_repeat():
    log = make_log([INF, 1.0, INF])
    one = {"each_side": 1}
    assert sm.filter("median-of-repeats", **one).apply(log).log.range_m.tolist() == [1, INF, 1]
    ignoring = sm.filter("median-of-repeats", no_echo="ignore", **one).apply(log)
    assert ignoring.log.range_m.tolist() == [INF, 1, INF]


def test_what_was_read_elsewhere_or_by_another_sonar_is_no_repeat():
    for columns in (
        {"x_m": [0, 1, 2]},
        {"heading_rad": [0, 0.5, 1]},
        {"ring": THREE, "sonar": [0, 1, 2]},
    ):
        made = sm.filter("median-of-repeats").apply(make_log([1.0, 2.0, 3.0], **columns))
        assert not made.changed.any()
    # A whole turn is no turn.
    made = sm.filter("median-of-repeats").apply(
        make_log([1.0, 2.0, 1.0], heading_rad=[0, 2 * math.pi, 0])
    )
    assert made.log.range_m.tolist() == [1, 1, 1]


def test_turning_and_mirroring_the_drive_changes_nothing(rng):
    log = random_log(rng, 200, ring=sm.SonarRing("ahead", [0], [0], [0], 0.2, 0.1, 5.0))
    f = sm.filter("median-of-repeats", travel_m=1.0, turn_rad=2.0)
    expected = f.apply(log).log.range_m
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    mirrored = log.replace(y_m=-log.y_m, heading_rad=-log.heading_rad)
    for other in (turned, mirrored):
        np.testing.assert_array_equal(f.apply(other).log.range_m, expected)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"each_side": 0}, "each_side must be >= 1, got 0"),
        ({"each_side": 1.5}, "each_side must be a whole number, got 1.5"),
        ({"tolerance_m": -1}, "tolerance_m must be >= 0, got -1"),
        ({"travel_m": 0}, "travel_m must be > 0, got 0"),
        ({"turn_rad": math.nan}, "turn_rad must be > 0, got nan"),
        ({"no_echo": "clear"}, "no_echo 'clear' is unknown.*"),
        ({"action": "keep"}, "action 'keep' is unknown.*"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.filter("median-of-repeats", **parameters)
