"""The filter by the learned map in a room where many readings are wrong."""

import functools

import numpy as np

import sonarmap as sm
import worlds
from sim import simulate
from sim.sonar.presets import PHYSICAL


@functools.cache
def drive():
    """Return a log of a hallway of smooth walls, where many readings are wrong."""
    sonar = PHYSICAL.replace(search="images")
    world = worlds.load("thesis-exp1")
    return simulate(world, scans=200, seed=4, sonar=sonar, engine="segments")


def test_it_finds_most_wrong_readings_and_loses_few_right_ones():
    log = drive()
    score = sm.score_readings(log, sm.filter("consistency").apply(log))
    assert score.wrong > 100
    assert score.roc_auc > 0.98
    assert score.caught_share > 0.7
    assert score.lost_share < 0.05


def test_what_it_mends_is_marked_and_mostly_right():
    log = drive()
    made = sm.filter("consistency", mode="mend").apply(log)
    score = sm.score_readings(log, made)
    assert score.mended / score.wrong_updated > 0.8
    assert score.spoiled_share < 0.02
    np.testing.assert_array_equal(made.changed, made.log.range_m != log.range_m)
    assert made.changed.any()
    changed = made.changed
    assert not (made.rejected & changed).any()
    np.testing.assert_array_equal(made.log.range_m[changed], made.predicted_range_m[changed])


def test_what_is_not_sure_enough_to_mend_is_rejected():
    log = drive()
    timid, bold = (
        sm.filter("consistency", mode="mend", least_confidence=least).apply(log)
        for least in (0.999, 0.0)
    )
    assert not bold.rejected.any()
    assert timid.rejected.any()
    assert (timid.report.confidence[timid.changed] >= 0.999).all()
    np.testing.assert_array_equal(
        timid.rejected | timid.changed, bold.changed | (timid.rejected & ~bold.changed)
    )


def test_doubt_alone_changes_and_rejects_nothing():
    log = drive()
    made = sm.filter("consistency", mode="doubt").apply(log)
    np.testing.assert_array_equal(made.log.range_m, log.range_m)
    np.testing.assert_array_equal(made.rejected, log.rejected)
    assert ((made.doubt >= 0) & (made.doubt <= 1)).all()


def test_the_doubt_is_about_as_often_right_as_it_says():
    log = drive()
    made = sm.filter("consistency", mode="doubt").apply(log)
    wrong = log.truth.cause > sm.Cause.OUT_OF_RANGE
    for low, high in ((0, 0.2), (0.8, 1)):
        those = (made.doubt >= low) & (made.doubt <= high)
        assert abs(wrong[those].mean() - made.doubt[those].mean()) < 0.1
    # The likeliest cause is the cause.
    assert (made.likely_cause == log.truth.cause).mean() > 0.8


def test_the_threshold_falls_as_more_may_be_lost():
    log = drive()
    shares = [0.0003, 0.001, 0.01, 0.1]
    rejected = [
        sm.filter("consistency", lost_share=share).apply(log).rejected.sum() for share in shares
    ]
    assert rejected == sorted(rejected)
    assert rejected[0] < rejected[-1]


def test_the_log_is_left_as_it_was():
    log = drive()
    before = {name: getattr(log, name).tobytes() for name in sm.SonarLog.DTYPES}
    for mode in ("doubt", "reject", "mend"):
        sm.filter("consistency", mode=mode).apply(log)
    assert before == {name: getattr(log, name).tobytes() for name in sm.SonarLog.DTYPES}


def test_readings_one_at_a_time_are_judged_by_the_past():
    log = drive().select(slice(640))
    method = sm.filter("consistency", mode="mend")
    state = method.begin(log.ring, sm.grid_over(log))
    made = [state.add(log.select(slice(row, row + 8))) for row in range(0, len(log), 8)]
    doubt = np.concatenate([each.doubt for each in made])
    assert doubt.shape == log.range_m.shape
    score = sm.score_readings(log, log.replace(doubt=doubt))
    # Less than the whole log tells, which is 0.98 and more.
    assert score.roc_auc > 0.85
    # The past is the past: what came later changed nothing.
    again = method.begin(log.ring, sm.grid_over(log))
    early = [again.add(log.select(slice(row, row + 8))) for row in range(0, 240, 8)]
    np.testing.assert_array_equal(np.concatenate([each.doubt for each in early]), doubt[:240])
