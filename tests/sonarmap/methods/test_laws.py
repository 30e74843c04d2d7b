"""Laws that hold for every mapping method, or for all but those that are named with the reason."""

import dataclasses
import math

import numpy as np
import pytest
from support import ONE, THREE, make_log, random_log

import sonarmap as sm
from sonarmap.parameters import from_text

GRID = sm.GridSpec(0.1, (-2.5, -2.5), (50, 50))
NAMES = list(sm.methods())
SEEDED = ["thrun-forward"]

# What a reading says depends on the map so far; for "learned", on the way driven so far.
IN_ORDER = {"himm", "konolige-style", "learned", "nav2-range", "tbf"}
# A network's forms do not turn to the last digit: see test_learned.
NEARLY_TURNING = {"learned"}
# In single precision.
ROUGHLY = {"learned": 1e-4}
# Region 2 of the standard model says "occupied" in its corners (thesis, section 5.1).
STANDARD_MODEL = {"bayes-standard", "dempster-shafer"}
COLUMNS = ("sonar", "x_m", "y_m", "heading_rad", "range_m", "stale", "rejected")


def turned(log, angle_rad):
    """Return the log of a world that is turned about the origin."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return log.replace(
        x_m=cos * log.x_m - sin * log.y_m,
        y_m=sin * log.x_m + cos * log.y_m,
        heading_rad=log.heading_rad + angle_rad,
    )


def probability(name, log, grid=GRID):
    return sm.method(name).map(log, grid).probability


@pytest.mark.parametrize("name", [name for name in NAMES if name not in IN_ORDER])
def test_the_order_of_the_readings_does_not_matter(name, rng):
    log = random_log(rng, 60)
    order = rng.permutation(len(log))
    shuffled = log.replace(**{column: getattr(log, column)[order] for column in COLUMNS})
    np.testing.assert_allclose(probability(name, shuffled), probability(name, log), atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_of_the_log_turns_the_map(name, quarters, rng):
    if name in SEEDED:
        pytest.skip("climbs from seeded starts, which do not turn with the log")
    if name in NEARLY_TURNING:
        pytest.skip("turns nearly, which has a test of its own")
    log = random_log(rng, 60)
    p = probability(name, turned(log, quarters * math.pi / 2))
    # numpy turns an image, whose rows grow downwards: counter-clockwise there is clockwise here.
    np.testing.assert_allclose(p, np.rot90(probability(name, log), -quarters), atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_mirrored_log_gives_the_mirrored_map(name, rng):
    if name in SEEDED:
        pytest.skip("climbs from seeded starts, which are not mirrored with the log")
    if name in NEARLY_TURNING:
        pytest.skip("is mirrored nearly, which has a test of its own")
    log = random_log(rng, 60)
    fields = THREE.to_dict()
    for column in ("y_m", "heading_rad"):
        fields[column] = [-value for value in fields[column]]
    mirrored = log.replace(
        ring=sm.SonarRing.from_dict(fields), y_m=-log.y_m, heading_rad=-log.heading_rad
    )
    np.testing.assert_allclose(probability(name, mirrored), probability(name, log)[::-1], atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_whole_turns_of_the_heading_change_nothing(name, rng):
    log = random_log(rng, 40)
    further = log.replace(heading_rad=log.heading_rad + 2 * math.pi * rng.integers(-3, 4, 40))
    tolerance = ROUGHLY.get(name, 1e-9)
    np.testing.assert_allclose(probability(name, further), probability(name, log), atol=tolerance)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("range_m", [[], [-np.inf] * 3])
def test_a_log_that_says_nothing_has_a_map_all_the_same(name, range_m):
    log = make_log([1.0]).select(slice(0)) if not range_m else make_log(range_m)
    m = sm.method(name).map(log, GRID)
    if name == "sheet":
        assert (m.probability == 0.06).all()
    elif name == "free-space":
        assert (m.probability > 0.05).all() == (len(log) == 0)
    else:
        # Unknown, or the prior share of walls: nothing is known of one cell rather than another.
        assert np.unique(m.probability).size == 1
        assert not (m.occupied | m.free).any()


@pytest.mark.parametrize("name", NAMES)
def test_the_log_is_left_as_it_was(name, rng):
    log = random_log(rng, 30)
    before = {column: getattr(log, column).tobytes() for column in sm.SonarLog.DTYPES}
    sm.method(name).map(log, GRID)
    assert before == {column: getattr(log, column).tobytes() for column in sm.SonarLog.DTYPES}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("ring", [ONE, sm.AMIGOBOT, sm.ring("pioneer3dx"), sm.ring("udacity8")])
@pytest.mark.parametrize("origin_xy_m", [(-2.5, -2.5), (0.4, -0.2), (30.0, 0.0)])
def test_any_ring_maps_on_any_grid(name, ring, origin_xy_m, rng):
    log = random_log(rng, 60, ring=ring, reach_m=6.0)
    m = sm.method(name).map(log, sm.GridSpec(0.13, origin_xy_m, (17, 23)))
    assert np.isfinite(m.probability).all()


@pytest.mark.parametrize("name", NAMES)
def test_a_wide_cone_is_a_cone(name, rng):
    fields = THREE.to_dict() | {"half_angle_rad": 1.2, "name": "wide"}
    log = random_log(rng, 30, ring=sm.SonarRing.from_dict(fields))
    if name.startswith("bayes-") and name != "bayes-gaussian":
        pytest.skip("its models end at 60 degrees")
    assert np.isfinite(probability(name, log)).all()


@pytest.mark.parametrize("name", NAMES)
def test_readings_above_the_limit_are_no_echo(name, rng):
    kind = sm.methods()[name]
    if not hasattr(kind, "max_range_m"):
        pytest.skip("has no limit")
    log = random_log(rng, 60)
    method = sm.method(name, max_range_m=1.2)
    assert method.longest_reading_m(log.ring) == 1.2
    cut = log.replace(range_m=np.where(log.range_m > 1.2, np.inf, log.range_m))
    p = method.map(log, GRID).probability
    np.testing.assert_array_equal(p, method.map(cut, GRID).probability)
    assert (p != probability(name, log)).any()


@pytest.mark.parametrize("name", NAMES)
def test_no_echo_says_nothing_or_that_the_cone_is_free(name):
    if not hasattr(sm.methods()[name], "no_echo"):
        pytest.skip("has no such parameter")
    log = make_log([np.inf], x_m=-2.0)
    ignoring = sm.method(name, no_echo="ignore", max_range_m=2).map(log, GRID).probability
    assert (ignoring == 0.5).all()
    clearing = sm.method(name, no_echo="clear", max_range_m=2).map(log, GRID).probability
    assert clearing[GRID.cell_of(-1.0, 0.01)] < 0.5
    assert (clearing <= 0.5).all() or name in STANDARD_MODEL


@pytest.mark.parametrize("name", NAMES)
def test_its_parameters_can_be_given_as_text(name):
    method = sm.method(name)
    fields = [each.name for each in dataclasses.fields(method)]
    given = from_text(name, type(method), {each: str(getattr(method, each)) for each in fields})
    assert type(method)(**given) == method
