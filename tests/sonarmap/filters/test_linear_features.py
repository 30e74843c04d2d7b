"""Linear features: the cone's meeting with a segment by sampling, and drawn walls."""

import math

import numpy as np
import pytest
from noise_free import drive, wall
from support import make_log, random_log

import sonarmap as sm
from sonarmap.kernels.segments import nearest_segment

NAME = "linear-features-style"
SIDES = sm.SonarRing("sides", [0, 0], [0, 0], [math.pi / 2, 0.3], math.radians(10), 0.1, 5.0)


def test_the_nearest_point_of_a_segment_in_a_cone_equals_that_of_its_samples(rng):
    n, half_angle = 200, 0.3
    sensors, axes = rng.uniform(-1, 1, (n, 2)), rng.uniform(-4, 4, n)
    ends = rng.uniform(-2, 2, (6, 4))
    ends[5, 2:] = ends[5, :2]  # a segment without length is a point
    range_m, which = nearest_segment(sensors, axes, half_angle, ends)
    t = np.linspace(0, 1, 20001)[:, None]
    for i in range(n):
        best = (math.inf, -1)
        for j, (ax, ay, bx, by) in enumerate(ends):
            xy = [ax, ay] + t * [bx - ax, by - ay] - sensors[i]
            off = np.arctan2(xy[:, 1], xy[:, 0]) - axes[i]
            inside = np.abs((off + math.pi) % (2 * math.pi) - math.pi) <= half_angle
            if inside.any():
                best = min(best, (float(np.hypot(*xy[inside].T).min()), j))
        if math.isinf(best[0]):
            assert which[i] == -1
        else:
            assert range_m[i] == pytest.approx(best[0], abs=2e-3)
            assert which[i] == best[1]


def along_a_wall():
    """A drive of 2 m along a wall 1 m to the left; the oblique sonar's sound is mirrored away."""
    poses = [(x, 0.0, 0.0) for x in np.arange(0, 2, 0.05)]
    log = drive(SIDES, poses, wall(-1, 1.0, 4, 1.0))
    range_m = log.range_m.copy()
    range_m[log.sonar == 1] = 4.5
    range_m[1] = math.inf
    return log.replace(range_m=range_m)


def test_the_features_are_the_walls():
    features = sm.filter(NAME).features(along_a_wall())
    assert len(features) == 1
    ends = np.reshape(features[0].ends_m, (2, 2))
    ends = ends[np.argsort(ends[:, 0])]
    np.testing.assert_allclose(ends, [[-0.1, 1.0], [2.05, 1.0]], atol=0.01)
    assert features[0].rows == tuple(range(0, 80, 2))


def test_what_is_longer_than_the_wall_predicts_is_rejected_or_mended():
    log = along_a_wall()
    made = sm.filter(NAME).apply(log)
    oblique = log.sonar == 1
    # The upper edge of the oblique cone, 27 degrees, meets the wall at 1 m / sin 27 degrees.
    expected = 1 / math.sin(0.3 + math.radians(10))
    inside = oblique & (log.x_m + 1 / math.tan(0.3 + math.radians(10)) < 2.0)
    assert inside.any()
    np.testing.assert_allclose(made.predicted_range_m[inside], expected, atol=0.02)
    assert made.rejected[inside].all()
    assert not made.rejected[~oblique].any()
    assert made.likely_cause[1] == sm.Cause.DROPOUT
    assert (made.likely_cause[inside][1:] == sm.Cause.BOUNCE).all()
    np.testing.assert_allclose(made.doubt[inside], 40 / 42)
    np.testing.assert_allclose(made.doubt[~oblique], 2 / 42)
    assert np.isnan(made.doubt[oblique & ~inside]).any()  # past the end of the feature
    mended = sm.filter(NAME, action="mend").apply(log)
    np.testing.assert_array_equal(mended.changed, made.rejected)
    np.testing.assert_allclose(mended.log.range_m[inside], expected, atol=0.02)


def test_what_is_shorter_gets_no_opinion():
    log = along_a_wall()
    range_m = log.range_m.copy()
    range_m[11] = 0.8
    made = sm.filter(NAME).apply(log.replace(range_m=range_m))
    assert math.isnan(made.doubt[11])
    assert not made.rejected[11]


def test_what_made_a_feature_is_not_rejected_for_a_nearer_one():
    twins = sm.SonarRing("twins", [0, 0], [0, 0], [math.pi / 2] * 2, 0.1, 0.1, 5.0)
    x_m = np.repeat(np.arange(0, 2, 0.05), 2)
    log = make_log(np.tile([0.9, 1.4], 40), ring=twins, sonar=np.tile([0, 1], 40), x_m=x_m)
    made = sm.filter(NAME).apply(log)
    assert len(made.report) == 2
    np.testing.assert_allclose(made.predicted_range_m, 0.9, atol=0.01)
    assert not made.rejected.any()
    # One that made none, being too long for that, is.
    far = sm.filter(NAME, short_m=1.0).apply(log)
    np.testing.assert_array_equal(far.rejected, log.sonar == 1)


@pytest.mark.parametrize(
    "parameters",
    [{"short_m": 0.9}, {"least_length_m": 3.0}, {"least_points": 41}, {"gap_m": 0.04}],
)
def test_without_features_nothing_is_judged(parameters):
    made = sm.filter(NAME, **parameters).apply(along_a_wall())
    assert made.report == ()
    assert np.isnan(made.doubt).all()
    assert not made.rejected.any()
    assert made.likely_cause is None


def test_turns_and_mirrors_change_nothing(rng):
    log = along_a_wall()
    expected = sm.filter(NAME).apply(log)
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    other_side = sm.SonarRing(
        "other", [0, 0], [0, 0], [-math.pi / 2, -0.3], SIDES.half_angle_rad, 0.1, 5.0
    )
    for other in (turned, log.replace(ring=other_side)):
        made = sm.filter(NAME).apply(other)
        np.testing.assert_allclose(made.doubt, expected.doubt)
        np.testing.assert_allclose(made.predicted_range_m, expected.predicted_range_m, rtol=1e-6)
        np.testing.assert_array_equal(made.rejected, expected.rejected)


def test_no_doubt_is_out_of_range(rng):
    log = random_log(rng, 300, ring=SIDES, spread_m=0.3)
    made = sm.filter(NAME, gap_m=2.0, tolerance_m=1.0, least_points=3).apply(log)
    assert made.report
    known = made.doubt[~np.isnan(made.doubt)]
    assert ((known >= 0) & (known <= 1)).all()
    assert sm.filter(NAME).apply(make_log([])).report == ()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        *(
            ({name: 0}, f"{name} must be > 0, got 0")
            for name in (
                "short_m",
                "gap_m",
                "tolerance_m",
                "least_length_m",
                "margin_m",
                "doubtful_points",
            )
        ),
        ({"least_points": 2}, "least_points must be >= 3, got 2"),
        ({"extend_m": -1}, "extend_m must be >= 0, got -1"),
        ({"action": "keep"}, "action 'keep' is unknown.*"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.filter(NAME, **parameters)
