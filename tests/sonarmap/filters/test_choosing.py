"""Reading filters by name, in a row, and a person's own without any registration."""

import dataclasses
import importlib.metadata
import pickle

import numpy as np
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarmap.parameters import at_point
from sonarmap.pipeline import apply_all

GRID = sm.GridSpec(0.1, (-1.5, -1.5), (30, 31))


@pytest.mark.parametrize("name", list(sm.filters()))
class TestEveryFilter:
    """What holds for every filter that ships."""

    def test_is_a_frozen_dataclass_with_a_name_and_a_source(self, name):
        kind = sm.filters()[name]
        made = sm.filter(name)
        assert isinstance(made, sm.ReadingFilter)
        assert type(made) is kind
        assert made.name == name
        assert made.source.endswith(".")
        assert dataclasses.is_dataclass(kind)
        assert pickle.loads(pickle.dumps(made)) == made

    def test_leaves_the_log_as_it_is_and_tells_what_changed(self, name, rng):
        log = random_log(rng, 300, ring=sm.AMIGOBOT, truth=True)
        before = {column: getattr(log, column).copy() for column in log.DTYPES}
        made = sm.filter(name).apply(log)
        for column, values in before.items():
            np.testing.assert_array_equal(getattr(log, column), values)
        np.testing.assert_array_equal(made.changed, made.log.range_m != log.range_m)
        # Only what a filter may touch is touched.
        for column in set(log.DTYPES) - {"range_m", "stale", "rejected", "doubt"}:
            np.testing.assert_array_equal(getattr(made.log, column), getattr(log, column))
        assert made.log.truth is log.truth

    def test_never_takes_back_a_rejection_nor_changes_what_is_not_used(self, name, rng):
        log = random_log(rng, 300, ring=sm.AMIGOBOT, truth=True)
        made = sm.filter(name).apply(log)
        assert made.rejected[log.rejected].all()
        assert not made.changed[~log.usable].any()

    def test_does_not_listen_to_what_is_not_used(self, name, rng):
        if name == "stale":
            pytest.skip("it is about repeats of all values")
        log = random_log(rng, 300, ring=sm.AMIGOBOT, truth=True)
        lies = log.replace(range_m=np.where(log.usable, log.range_m, 0.4))
        told, lied = sm.filter(name).apply(log), sm.filter(name).apply(lies)
        used = log.usable
        np.testing.assert_array_equal(told.log.range_m[used], lied.log.range_m[used])
        np.testing.assert_array_equal(told.rejected[used], lied.rejected[used])

    def test_says_what_may_be_searched(self, name):
        kind = sm.filters()[name]
        for end in ("low", "high"):
            point = {key: getattr(each, end) for key, each in kind.space().items()}
            assert isinstance(at_point(kind, point), kind)


def test_hsr_is_the_function_with_the_thesis_setting_for_openings(rng):
    log = random_log(rng, 300, ring=sm.AMIGOBOT)
    made, result = sm.filter("hsr").apply(log), sm.hsr(log, sm.HsrParams.thesis_openings())
    np.testing.assert_array_equal(made.log.range_m, result.log.range_m)
    np.testing.assert_array_equal(made.changed, result.updated)
    assert made.report.updates_per_pass == result.updates_per_pass
    assert made.log.provenance == result.log.provenance
    np.testing.assert_array_equal(
        made.predicted_range_m, np.where(result.updated, result.log.range_m, np.nan)
    )
    assert made.likely_cause is None


def test_hsr_leaves_a_log_alone_in_which_nothing_vouches():
    log = make_log([np.inf, -np.inf], ring=sm.AMIGOBOT)
    made = sm.filter("hsr").apply(log)
    assert made.log is log
    assert made.report is None
    assert not made.changed.any()


def test_a_rejected_wall_does_not_vouch():
    # Two sonars at one place look the same way: the near echo cuts the far one, unless rejected.
    near_and_far = make_log([1.0, 2.5, 2.5], ring=sm.AMIGOBOT)
    thesis = sm.HsrParams.thesis()
    assert sm.hsr(near_and_far, thesis).updated.tolist() == [False, True, True]
    rejected = near_and_far.replace(rejected=[True, False, False])
    assert not sm.hsr(rejected, thesis).updated.any()
    only_the_last = near_and_far.replace(stale=[False, True, False])
    assert sm.hsr(only_the_last, thesis).updated.tolist() == [False, False, True]


def test_eeruf_rejects_what_agrees_with_no_neighbour():
    log = make_log([1.0, 1.01, 2.0, 1.0, 1.0, np.inf, np.inf])
    made = sm.filter("eeruf").apply(log)
    assert made.rejected.tolist() == [False, False, True, False, False, False, False]
    assert not made.changed.any()
    np.testing.assert_array_equal(~made.rejected, sm.eeruf_accepts(log))
    # A reading that was rejected before is nobody's neighbour.
    log = log.replace(rejected=[False, True, False, False, False, False, False])
    assert sm.filter("eeruf").apply(log).rejected.tolist() == [True, True, True, *[False] * 4]


def test_marking_stale_sets_stale_alone():
    made = sm.filter("stale").apply(make_log([1.0, 1.0, 2.0]))
    assert made.log.stale.tolist() == [False, True, False]
    assert not made.rejected.any()
    assert not made.changed.any()


# --- in a row ------------------------------------------------------------------------------------


def beyond_two(log):
    return log.replace(rejected=log.range_m > 2, doubt=np.where(log.range_m > 2, 0.9, np.nan))


def forgetful(log):
    """Reject the first reading, and forget what was rejected before."""
    first = np.arange(len(log)) == 0
    return log.replace(rejected=first, doubt=np.where(first, 0.5, np.nan))


def test_rejections_of_several_filters_are_united():
    log = make_log([1.0, 2.5, 1.0, 3.0])
    made = sm.Pipeline([beyond_two, forgetful], lambda log, grid: 0).apply(log)
    assert made.rejected.tolist() == [True, True, False, True]
    np.testing.assert_array_equal(made.doubt, [0.5, 0.9, np.nan, 0.9])


def test_the_order_of_filters_that_only_reject_does_not_matter(rng):
    log = random_log(rng, 100)
    one = apply_all([sm.filter("eeruf"), sm.filter("stale")], log)
    assert one.rejected[log.rejected].all()
    forward = sm.Pipeline([beyond_two, forgetful], lambda log, grid: 0).apply(log)
    back = sm.Pipeline([forgetful, beyond_two], lambda log, grid: 0).apply(log)
    np.testing.assert_array_equal(forward.rejected, back.rejected)


def test_a_pipeline_maps_what_its_filters_leave(rng):
    log = random_log(rng, 300, ring=sm.AMIGOBOT)
    method = sm.method("bayes-standard")
    pipeline = sm.Pipeline([sm.filter("hsr"), beyond_two], method)
    mended = sm.filter("hsr").apply(log).log
    expected = method.map(mended.replace(rejected=mended.rejected | (mended.range_m > 2)), GRID)
    assert pipeline.map(log, GRID).log_odds.tobytes() == expected.log_odds.tobytes()
    assert pipeline.name == "hsr + beyond_two + bayes-standard"
    assert sm.Pipeline([], method).map(log, GRID).log_odds.tobytes() == (
        method.map(log, GRID).log_odds.tobytes()
    )


def test_of_predictions_and_causes_the_last_opinion_counts():
    log = make_log([1.0, 2.0, 3.0])

    def first(log):
        return sm.Filtered(log, [False] * 3, [1.0, 1.0, np.nan], [3, -1, -1])

    def second(log):
        return sm.Filtered(log, [False] * 3, [np.nan, 2.0, np.nan], [-1, 5, -1])

    made = sm.Pipeline([first, second], lambda log, grid: 0).apply(log)
    np.testing.assert_array_equal(made.predicted_range_m, [1.0, 2.0, np.nan])
    assert made.likely_cause.tolist() == [3, 5, -1]
    assert made.report == (None, None)


# --- a person's own ------------------------------------------------------------------------------


@pytest.fixture
def own_module(tmp_path, monkeypatch):
    (tmp_path / "own_filter.py").write_text(
        "import dataclasses\nimport sonarmap as sm\n"
        "@dataclasses.dataclass(frozen=True)\n"
        "class Shy:\n"
        "    name, source = 'shy', 'A toy.'\n"
        "    beyond_m: float = 2.0\n"
        "    def apply(self, log):\n"
        "        log = log.replace(rejected=log.rejected | (log.range_m > self.beyond_m))\n"
        "        return sm.Filtered(log, [False] * len(log))\n"
        "    @classmethod\n"
        "    def space(cls):\n        return {}\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    return "own_filter"


def test_anything_that_can_be_imported_is_a_filter(own_module, monkeypatch):
    log = make_log([1.0, 2.5])
    assert sm.filter(f"{own_module}:Shy").apply(log).rejected.tolist() == [False, True]
    assert sm.filter(f"{own_module}:Shy", beyond_m=3).apply(log).rejected.tolist() == [False] * 2
    entry = importlib.metadata.EntryPoint("shy", f"{own_module}:Shy", "sonarbed.filters")
    monkeypatch.setattr(
        "sonarmap.registry.entry_points",
        lambda group: [entry] if group == "sonarbed.filters" else [],
    )
    assert "shy" in sm.filters()
    assert sm.filter("shy").name == "shy"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sm.filter("hsrr"), "filter 'hsrr' is unknown; did you mean 'hsr'\\?"),
        (lambda: sm.filter("hsr", wall=1), "filter 'hsr' has no parameter 'wall'; .*"),
        (
            lambda: sm.filter("hsr", min_wall_m=1),
            "min_wall_m must be <= max_wall_m, got 1.0 and 0.08",
        ),
        (lambda: sm.filter("eeruf", tolerance_m=-1), "tolerance_m must be >= 0, got -1"),
        (lambda: sm.filter("stale", x=1), "filter 'stale' has no parameter 'x'; .*"),
        (
            lambda: sm.filter("math:pi"),
            r"filter 'math:pi' must have .apply\(log\) or .*, got float",
        ),
    ],
)
def test_bad_filters_are_refused(call, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        call()


def shortened(log):
    return log.select(slice(0, 1))


def no_log(log):
    return log.range_m


def filtered_short(log):
    return sm.Filtered(log.select(slice(0, 1)), [False])


@pytest.mark.parametrize(
    ("bad", "got"),
    [(shortened, "a log of 1"), (no_log, "ndarray"), (filtered_short, "1")],
)
def test_a_filter_that_returns_other_readings_is_refused(bad, got):
    with pytest.raises(
        sm.InputError, match=f"^filter '{bad.__name__}' must return a log of 2 readings, got {got}$"
    ):
        sm.Pipeline([bad], lambda log, grid: 0).apply(make_log([1.0, 2.0]))


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (([True],), r"changed must have shape \(2,\), got \(1,\)"),
        (([True, False], [1.0]), r"predicted_range_m must have shape \(2,\), got \(1,\)"),
        (([True, False], None, [6, 0]), r"likely_cause\[0\] must be -1 to 5, got 6"),
    ],
)
def test_bad_results_are_refused(columns, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.Filtered(make_log([1.0, 2.0]), *columns)
