"""The two filters that know the truth, and the one that knows nothing."""

import math

import numpy as np
import pytest
from support import make_log, random_log, random_truth

import sonarmap as sm

INF, NAN = math.inf, math.nan


def known_log(range_m, cause, cone_range_m, rng, **columns):
    n = len(range_m)
    truth = random_truth(rng, n)
    fields = {name: getattr(truth, name) for name in truth.DTYPES}
    truth = sm.LogTruth(**(fields | {"cause": cause, "cone_range_m": cone_range_m}))
    return make_log(range_m, ring=sm.AMIGOBOT, truth=truth, **columns)


@pytest.fixture
def log(rng):
    # One reading of each cause, then a wrong one that may not be touched.
    return known_log(
        [1.0, 0.9, INF, 2.5, 0.4, INF, 2.0],
        [*(int(cause) for cause in sm.Cause), int(sm.Cause.BOUNCE)],
        [1.0, 0.9, INF, 1.5, 4.0, 0.1, 1.0],
        rng,
        stale=[False] * 6 + [True],
        doubt=[NAN] * 6 + [0.3],
    )


def test_the_oracle_drops_what_is_wrong_and_nothing_else(log):
    made = sm.filter("oracle-drop").apply(log)
    assert made.rejected.tolist() == [False, False, False, True, True, True, False]
    assert made.doubt.tolist() == [0, 0, 0, 1, 1, 1, 0.3]
    assert not made.changed.any()
    assert made.likely_cause.tolist() == [0, 1, 2, 3, 4, 5, -1]
    # What the amigobot can tell: 0.165 to 3 m.
    np.testing.assert_array_equal(made.predicted_range_m, [1, 0.9, INF, 1.5, INF, -INF, NAN])


def test_the_oracle_mends_what_is_wrong_and_nothing_else(log):
    made = sm.filter("oracle-mend").apply(log)
    assert made.log.range_m.tolist() == [1.0, 0.9, INF, 1.5, INF, -INF, 2.0]
    assert made.changed.tolist() == [False, False, False, True, True, True, False]
    assert not made.rejected.any()
    assert made.doubt.tolist() == [0, 0, 0, 1, 1, 1, 0.3]


def test_the_oracles_score_what_can_be_scored(rng):
    log = random_log(rng, 500, ring=sm.AMIGOBOT, truth=True)
    dropped = sm.score_readings(log, sm.filter("oracle-drop").apply(log))
    assert (dropped.caught_share, dropped.lost_share, dropped.roc_auc) == (1, 0, 1)
    mended = sm.score_readings(log, sm.filter("oracle-mend").apply(log))
    assert mended.spoiled_share == 0
    assert (mended.is_mended == mended.updated).all()
    assert (mended.cone_after_m[mended.is_wrong] == 0).all()
    # Once mended, nothing is left to do, and dropping twice drops no more.
    for name in ("oracle-drop", "oracle-mend"):
        once = sm.filter(name).apply(log)
        twice = sm.filter(name).apply(once.log)
        assert not twice.changed.any()
        np.testing.assert_array_equal(twice.rejected, once.rejected)


@pytest.mark.parametrize("name", ["oracle-drop", "oracle-mend"])
def test_an_oracle_needs_the_truth(name):
    message = rf"the log has no truth \(a real robot's\?\), needed for the filter '{name}'"
    with pytest.raises(sm.InputError, match=message):
        sm.filter(name).apply(make_log(1.0))


def test_no_filter_is_no_filter(rng):
    log = random_log(rng, 50)
    made = sm.filter("none").apply(log)
    assert made.log is log
    assert not made.changed.any()
