import math
import pickle

import numpy as np
import pytest
from support import ONE, THREE, make_log, random_log, random_truth

import sonarmap as sm

# --- columns -------------------------------------------------------------------------------------


def test_columns_have_one_type_each_and_cannot_be_changed(rng):
    log = random_log(rng, 5, truth=True)
    for part in (log, log.truth):
        for name, dtype in part.DTYPES.items():
            column = getattr(part, name)
            assert column.shape == (5,)
            assert np.issubdtype(column.dtype, dtype)
            with pytest.raises(ValueError, match="read-only"):
                column[0] = column[1]


def test_a_log_does_not_share_memory_with_what_it_was_made_of():
    range_m = np.array([1.0, 2.0])
    log = make_log(range_m)
    range_m[0] = 9.0
    assert log.range_m.tolist() == [1.0, 2.0]


def test_length_is_the_number_of_readings():
    assert len(make_log([1, 2, 3])) == 3
    assert len(make_log(1.0).select(slice(0))) == 0


def test_nothing_is_stale_unless_marked():
    assert make_log([1, 2]).stale.tolist() == [False, False]
    assert make_log([1, 2], stale=[0, 1]).stale.tolist() == [False, True]


def test_no_echo_and_too_close_are_infinities():
    log = make_log([math.inf, -math.inf, 0.0, 20.0])
    assert log.range_m.tolist() == [math.inf, -math.inf, 0.0, 20.0]


def test_causes_know_whether_they_are_right():
    assert [cause.name for cause in sm.Cause if cause.is_right] == [
        "DIRECT",
        "OFF_AXIS",
        "OUT_OF_RANGE",
    ]
    assert [cause.value for cause in sm.Cause] == [0, 1, 2, 3, 4, 5]


# --- geometry ------------------------------------------------------------------------------------


def test_a_sonar_sits_where_pose_and_ring_put_it():
    # A robot at (1, 2) that looks along +y; sonar 0 of the AmigoBot: 70 mm ahead, 100 mm left.
    log = make_log(1.0, ring=sm.AMIGOBOT, x_m=1.0, y_m=2.0, heading_rad=math.pi / 2)
    assert log.sensor_xy_m[0] == pytest.approx([1.0 - 0.100, 2.0 + 0.070])
    assert log.axis_rad[0] == pytest.approx(math.pi)
    assert log.point_xy_m[0] == pytest.approx([-0.1, 2.07])


def test_data_points_lie_on_the_axis_at_the_reading(rng):
    log = random_log(rng, 50)
    heard = np.isfinite(log.range_m)
    away = log.point_xy_m - log.sensor_xy_m
    assert np.hypot(*away[heard].T) == pytest.approx(log.range_m[heard])
    turn = np.arctan2(away[heard, 1], away[heard, 0]) - log.axis_rad[heard]
    assert np.cos(turn) == pytest.approx(1)


def test_without_an_echo_there_is_no_data_point():
    assert np.isnan(make_log([math.inf, -math.inf]).point_xy_m).all()


# --- logs made of logs ---------------------------------------------------------------------------


def test_replace_changes_the_named_columns_only(rng):
    log = random_log(rng, 6, truth=True)
    other = log.replace(range_m=np.ones(6))
    assert (other.range_m == 1).all()
    assert not (log.range_m == 1).any()
    assert other.truth is log.truth
    assert other.provenance == log.provenance
    np.testing.assert_array_equal(other.x_m, log.x_m)


@pytest.mark.parametrize(
    ("rows", "kept"),
    [
        (slice(1, 3), [1, 2]),
        ([0, 3], [0, 3]),
        (np.array([True, False, False, True]), [0, 3]),
        (slice(0), []),
    ],
)
def test_select_takes_rows_and_their_truth(rows, kept, rng):
    log = make_log([1.0, 2.0, 3.0, 4.0], truth=random_truth(rng, 4))
    part = log.select(rows)
    assert part.range_m.tolist() == log.range_m[kept].tolist()
    assert part.scan.tolist() == kept
    assert part.truth.surface.tolist() == log.truth.surface[kept].tolist()


def test_true_poses_take_the_place_of_odometry(rng):
    log = random_log(rng, 6, truth=True)
    true = log.at_true_poses()
    np.testing.assert_array_equal(true.x_m, log.truth.x_m)
    np.testing.assert_array_equal(true.heading_rad, log.truth.heading_rad)
    np.testing.assert_array_equal(true.range_m, log.range_m)


def test_truth_that_is_not_there_is_named_with_its_purpose():
    with pytest.raises(sm.InputError, match=r"no truth \(a real robot's\?\), needed for scores"):
        make_log(1.0).require_truth("scores")
    with pytest.raises(sm.InputError, match="needed for true poses"):
        make_log(1.0).at_true_poses()


def test_a_log_can_be_sent_to_another_process(rng):
    log = random_log(rng, 6, truth=True)
    back = pickle.loads(pickle.dumps(log))
    assert back.ring == log.ring
    assert back.range_m.tobytes() == log.range_m.tobytes()
    assert back.provenance == log.provenance


# --- bad input -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        # lengths and types
        ({"x_m": [0, 0]}, r"x_m must have shape \(3,\), got \(2,\)"),
        ({"x_m": np.zeros((3, 1))}, r"x_m must have shape \(3,\), got \(3, 1\)"),
        ({"x_m": ["a", "b", "c"]}, "x_m must be a column of float64"),
        ({"x_m": [[0], [0, 0], 0]}, "x_m must be a column of float64"),
        ({"sonar": [0, 0.5, 0]}, r"sonar\[1\] must be a whole number that fits int16, got 0\.5"),
        ({"sonar": np.array([0, 65536, 0])}, r"sonar\[1\] must be a whole .* int16, got 65536"),
        ({"sonar": [0, 65536, 0]}, "sonar must be a column of int16"),
        ({"scan": np.array([0, math.nan, 2])}, r"scan\[1\] must be a whole .* int32, got nan"),
        # numbers
        ({"time_s": [0, math.nan, 2]}, r"time_s\[1\] must be a finite number, got nan"),
        ({"x_m": [0, 0, math.inf]}, r"x_m\[2\] must be a finite number, got inf"),
        ({"y_m": [math.nan, 0, 0]}, r"y_m\[0\] must be a finite number, got nan"),
        ({"heading_rad": [0, 0, math.nan]}, r"heading_rad\[2\] must be a finite number, got nan"),
        # order
        ({"time_s": [0, 2, 1]}, r"time_s\[2\] must be not less than the row before, got 1\.0"),
        ({"scan": [0, 1, 0]}, r"scan\[2\] must be not less than the row before, got 0"),
        # sonars of the ring
        ({"sonar": [0, 1, 3]}, r"sonar\[2\] must be 0 to 2, got 3"),
        ({"sonar": [-1, 1, 2]}, r"sonar\[0\] must be 0 to 2, got -1"),
        # ranges
        ({"range_m": [1, math.nan, 1]}, r"range_m\[1\] must be within \[0, 20\] m.*, got nan"),
        ({"range_m": [1, -0.1, 1]}, r"range_m\[1\] must be within \[0, 20\] m.*, got -0\.1"),
        ({"range_m": [1, 1, 1500]}, r"range_m\[2\] must be within \[0, 20\] m.*, got 1500\.0"),
    ],
)
def test_bad_columns_are_refused(change, message):
    log = make_log([1.0, 2.0, 3.0], ring=THREE)
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        log.replace(**change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x_m": [math.nan, 0]}, r"truth\.x_m\[0\] must be a finite number, got nan"),
        ({"y_m": [0, 0, 0]}, r"truth\.y_m must have shape \(2,\), got \(3,\)"),
        ({"cause": [0, 6]}, r"truth\.cause\[1\] must be 0 to 5, got 6"),
        ({"cause": [-1, 0]}, r"truth\.cause\[0\] must be 0 to 5, got -1"),
        ({"bounces": [0, 1.5]}, r"truth\.bounces\[1\] must be a whole number .*, got 1\.5"),
    ],
)
def test_bad_truths_are_refused(change, message, rng):
    fields = vars(random_truth(rng, 2)) | change
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.LogTruth(**fields)


def test_a_truth_of_another_length_is_refused(rng):
    with pytest.raises(sm.InputError, match="truth must have one row a reading, got 2 for 3"):
        make_log([1, 2, 3], truth=random_truth(rng, 2))


def test_equal_times_are_in_order():
    # The readings of a scan may share its time.
    assert len(make_log([1.0, 2.0], time_s=[5, 5], scan=[0, 0], ring=ONE)) == 2


# --- rejected and doubted readings ---------------------------------------------------------------


def test_nothing_is_rejected_or_doubted_unless_marked():
    log = make_log([1, 2])
    assert log.rejected.tolist() == [False, False]
    assert np.isnan(log.doubt).all()
    assert log.usable.tolist() == [True, True]


def test_stale_and_rejected_readings_are_not_usable():
    log = make_log([1, 2, 3, 4], stale=[0, 1, 0, 1], rejected=[0, 0, 1, 1])
    assert log.usable.tolist() == [True, False, False, False]


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"doubt": [0.5, 1.1]}, r"doubt\[1\] must be within \[0, 1\], or NaN, got 1.1"),
        ({"doubt": [-0.1, 0.5]}, r"doubt\[0\] must be within \[0, 1\], or NaN, got -0.1"),
        ({"doubt": [np.inf, 0.5]}, r"doubt\[0\] must be within .*, got inf"),
    ],
)
def test_bad_doubts_are_refused(columns, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        make_log([1, 2], **columns)
