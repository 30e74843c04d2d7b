"""HSR against scenes by hand and against a plain twin that visits every millimetre."""

import dataclasses
import math

import numpy as np
import pytest

import sonarmap as sm
from sonarmap.filters.hsr import HsrStop, Mark, _reason_to_stop, estimate_variant_walls

PARAMS = sm.HsrParams(
    min_wall_m=0.1, max_wall_m=0.3, threshold_m=1.0, target_distance_m=0.06, max_passes=5
)
# One sonar in the middle of the robot, looking ahead: positions and axes are the poses.
POINTER = sm.SonarRing("pointer", [0.0], [0.0], [0.0], math.radians(15), 0.165, 3.0)
STEP_M = 0.001


def readings(*rows, ring=POINTER):
    """Log of rows (x, y, heading in degrees, range)."""
    x_m, y_m, heading_deg, range_m = np.array(rows, dtype=float).T
    n = len(rows)
    return sm.SonarLog(
        ring=ring,
        scan=np.arange(n) // len(ring),
        sonar=np.arange(n) % len(ring),
        time_s=np.arange(n) // len(ring) * 0.175,
        x_m=x_m,
        y_m=y_m,
        heading_rad=np.deg2rad(heading_deg),
        range_m=range_m,
    )


# The slow twin: the rules of the paper, one reading after the other, every sample of it.


def slow_samples(a, b):
    n = max(math.ceil(max(abs(b[0] - a[0]), abs(b[1] - a[1])) / STEP_M), 1)
    share = np.arange(n + 1) / n
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def slow_pass(log, range_m, params):
    """Return the readings after one pass, the grid and the marks."""
    ring, n = log.ring, len(log)
    takes_part = ~log.stale & ~log.rejected
    robot, sensor = np.column_stack([log.x_m, log.y_m]), log.sensor_xy_m
    cos, sin = np.cos(log.axis_rad), np.sin(log.axis_rad)
    code_m = np.where(np.isinf(range_m), max(5.0, ring.range_max_m), range_m)
    point = [
        (sensor[i][0] + code_m[i] * cos[i], sensor[i][1] + code_m[i] * sin[i]) for i in range(n)
    ]

    walls = {}
    for i in range(n):
        if takes_part[i] and 0 <= range_m[i] <= params.threshold_m:
            slope = (params.max_wall_m - params.min_wall_m) * (
                (range_m[i] - ring.range_min_m) / (ring.range_max_m - ring.range_min_m)
            )
            half = max(params.min_wall_m + slope, 0) / 2
            (x, y) = point[i]
            walls[i] = (
                (x - half * -sin[i], y - half * cos[i]),
                (x + half * -sin[i], y + half * cos[i]),
            )
    places = [*robot, *sensor, *(p for i, ends in walls.items() for p in (*ends, point[i]))]
    x, y = np.array(places).T
    size = params.cell_m
    grid = sm.GridSpec.covering(
        x.min() - size, y.min() - size, x.max() + size, y.max() + size, size
    )

    marks = np.zeros(grid.shape, np.uint8)
    for a, b in walls.values():
        marks[grid.cell_of(*slow_samples(a, b))] = Mark.WALL
    for i in walls:
        marks[grid.cell_of(*point[i])] = Mark.READING
    for p in (*robot, *sensor):
        marks[grid.cell_of(*p)] = Mark.POSITION

    after = range_m.copy()
    for i in range(n):
        if range_m[i] == -np.inf or not takes_part[i]:
            continue
        x, y = slow_samples(sensor[i], point[i])
        distance = np.sqrt((x - sensor[i][0]) ** 2 + (y - sensor[i][1]) ** 2)
        target = np.sqrt((point[i][0] - x) ** 2 + (point[i][1] - y) ** 2)
        row, col = grid.cell_of(x, y)
        outside = ~grid.contains(row, col)
        row[outside] = col[outside] = 0
        marked = np.isin(marks[row, col], (Mark.WALL, Mark.READING)) & ~outside
        # The first sample that ends the search decides by the first condition that ends it.
        for k in np.flatnonzero((distance > ring.range_max_m) | outside | marked)[:1]:
            far = distance[k] > ring.range_max_m or outside[k]
            if not far and target[k] > params.target_distance_m:
                after[i] = distance[k]
    return after, grid, marks


def slow_hsr(log, params):
    range_m = slow_pass(log, log.range_m, params)[0]
    counts = [int((range_m != log.range_m).sum())]
    while len(counts) < params.max_passes:
        after = slow_pass(log, range_m, params)[0]
        count = int((after != range_m).sum())
        if not (count > 0 and count > 0.1 * counts[0] and count < counts[-1]):
            break
        counts.append(count)
        range_m = after
    return range_m, tuple(counts)


def random_log(rng, ring, n):
    """Readings of every kind, in no order, in a space that makes many of them meet."""
    range_m = rng.uniform(0, 1.3 * ring.range_max_m, n)
    kind = rng.random(n)
    range_m[kind < 0.4] = rng.uniform(0, 1.2, int((kind < 0.4).sum()))
    range_m[kind > 0.85] = np.inf
    range_m[kind > 0.95] = -np.inf
    return sm.SonarLog(
        ring=ring,
        scan=np.arange(n) // len(ring),
        sonar=np.arange(n) % len(ring),
        time_s=np.arange(n) // len(ring) * 0.175,
        x_m=rng.uniform(-1.5, 1.5, n),
        y_m=rng.uniform(-1.5, 1.5, n),
        heading_rad=rng.uniform(-math.pi, math.pi, n),
        range_m=range_m,
        stale=rng.random(n) < 0.1,
        rejected=rng.random(n) < 0.1,
    )


def room_log(rng, ring, n, side_m=3.0):
    """A drive along a line in a square room, ranges in whole millimetres, some mirrored away."""
    s = np.arange(n) / n
    log = random_log(rng, ring, n).replace(
        x_m=0.6 + 1.5 * s, y_m=np.full(n, 1.2), heading_rad=np.round(2 * s, 1)
    )
    (x, y), (cos, sin) = log.sensor_xy_m.T, (np.cos(log.axis_rad), np.sin(log.axis_rad))
    range_m = np.minimum(
        np.where(cos > 0, side_m - x, x) / np.abs(cos),
        np.where(sin > 0, side_m - y, y) / np.abs(sin),
    ).round(3)
    lost = rng.random(n) < 0.3
    range_m[lost] = np.where(rng.random(int(lost.sum())) < 0.5, np.inf, range_m[lost] + 0.7)
    range_m[::7] = 0.75
    return log.replace(range_m=range_m)


def grid_log(ring):
    """Positions, axes and ranges on whole cells: every tie of the floor rule at once."""
    x, y = np.meshgrid(np.arange(6) * 0.3, np.arange(5) * 0.25)
    heading = np.arange(x.size) % 8 * 45
    range_m = np.where(np.arange(x.size) % 3 == 0, 1.7, 0.3)
    return readings(*zip(x.ravel(), y.ravel(), heading, range_m, strict=True), ring=ring)


PARAMETER_SETS = [
    sm.HsrParams(0.02, 0.15, 3.0, 0.06),
    sm.HsrParams(0.04, 0.6, 0.8, 0.06, cell_m=0.03),
    sm.HsrParams(0.0, 0.0, 1.0, 0.0, cell_m=0.02),
    # The paper's line falls below 0 at the sonar; cells smaller than a sampling interval.
    sm.HsrParams(0.001, 0.9, 2.0, 0.1, cell_m=0.0049, max_passes=1),
    sm.HsrParams(0.1, 0.1, 1.5, 0.3, cell_m=0.5),
]


@pytest.mark.parametrize("params", PARAMETER_SETS, ids=str)
@pytest.mark.parametrize("ring_name", ["amigobot", "pioneer3dx", "udacity8"])
@pytest.mark.parametrize("kind", ["random", "room", "grid"])
def test_equals_the_twin_that_visits_every_millimetre(params, ring_name, kind):
    ring, rng = sm.ring(ring_name), np.random.default_rng(7)
    log = {
        "random": lambda: random_log(rng, ring, 64),
        "room": lambda: room_log(rng, ring, 80),
        "grid": lambda: grid_log(ring),
    }[kind]()
    result = sm.hsr(log, params)
    range_m, counts = slow_hsr(log, params)
    np.testing.assert_array_equal(result.log.range_m, range_m)
    assert result.updates_per_pass == counts


@pytest.mark.parametrize("seed", range(12))
def test_one_pass_equals_the_twin_on_many_random_logs(seed):
    rng = np.random.default_rng(seed)
    params = sm.HsrParams(
        0.05, rng.uniform(0.05, 0.5), 2.0, 0.05, cell_m=rng.uniform(0.0007, 0.05), max_passes=1
    )
    # Small cells make large grids: the readings are kept together.
    log = random_log(rng, sm.AMIGOBOT, 40)
    log = log.replace(x_m=log.x_m / 3, y_m=log.y_m / 3)
    np.testing.assert_array_equal(
        sm.hsr(log, params).log.range_m, slow_pass(log, log.range_m, params)[0]
    )


def test_the_twin_finds_enough_to_compare():
    log = room_log(np.random.default_rng(7), sm.AMIGOBOT, 80)
    result = sm.hsr(log, PARAMETER_SETS[0])
    assert len(result.updates_per_pass) > 1
    assert 8 <= result.updated.sum() < 72


@pytest.mark.parametrize("params", PARAMETER_SETS, ids=str)
def test_es_equals_the_twin_mark_by_mark(params):
    log = random_log(np.random.default_rng(3), sm.AMIGOBOT, 64)
    es = estimate_variant_walls(log, params)
    _, grid, marks = slow_pass(log, log.range_m, params)
    assert es.grid == grid
    np.testing.assert_array_equal(es.marks, marks)


# Scenes by hand. The witness stands 0.5 m before a wall at x = 1 m and reads 0.5 m: half of its
# wall is (0.1 + 0.2 * 0.335 / 2.835) / 2 = 0.0618 m long.
WITNESS = (0.5025, 0.0025, 0, 0.5)


@pytest.mark.parametrize(
    ("searcher", "expected_m"),
    [
        # Too long by 0.7 m, and without echo: the wall's cell begins at x = 1.0 m.
        ((0.0025, 0.0025, 0, 1.7), 0.998),
        ((0.0025, 0.0025, 0, np.inf), 0.998),
        # Past the end of the wall, and just before it.
        ((0.0025, 0.0825, 0, 1.7), 1.7),
        ((0.0025, 0.0575, 0, 1.7), 0.998),
        # The data point within the target distance of the mark, and just beyond it.
        ((0.0025, 0.0025, 0, 1.057), 1.057),
        ((0.0025, 0.0025, 0, 1.061), 0.998),
        # Looking away; too near to reach the wall; too close to be read.
        ((0.0025, 0.0025, 180, 1.7), 1.7),
        ((0.0025, 0.0025, 0, 0.9), 0.9),
        ((0.0025, 0.0025, 0, -np.inf), -np.inf),
        # The wall within the maximum range of 3 m, and beyond it: an empty place.
        ((-1.9975, 0.0025, 0, np.inf), 2.998),
        ((-2.0125, 0.0025, 0, np.inf), np.inf),
        ((-2.0035, 0.0025, 0, np.inf), np.inf),
        # Through ES without meeting a mark, and out of it: stays without echo.
        ((0.0025, 0.0025, 90, np.inf), np.inf),
    ],
)
def test_a_reading_through_a_wall_becomes_the_distance_to_it(searcher, expected_m):
    log = readings(searcher, WITNESS)
    result = sm.hsr(log, dataclasses.replace(PARAMS, threshold_m=0.6, max_passes=1))
    # The first sample in the wall's cell is less than a sampling interval behind its border.
    assert result.log.range_m[0] == pytest.approx(expected_m, abs=STEP_M)
    assert result.log.range_m[1] == 0.5
    changed = expected_m != searcher[3]
    assert result.updated.tolist() == [changed, False]
    assert result.updates_per_pass == (int(changed),)


def test_a_robot_in_the_wall_hides_its_cell():
    searcher = (0.0025, 0.0025, 0, 1.7)
    # A reading that is too close takes no part, but its robot stands in the wall's only cell.
    params = dataclasses.replace(PARAMS, min_wall_m=0, max_wall_m=0, threshold_m=0.6)
    without, hidden = (
        sm.hsr(readings(searcher, WITNESS, (x_m, 0.0025, 0, -np.inf)), params).log.range_m[0]
        for x_m in (1.0125, 1.0025)
    )
    assert without == pytest.approx(0.998, abs=STEP_M)
    assert hidden == 1.7


def test_es_holds_the_strongest_mark_of_each_cell():
    # 0.1 m to the right a wall of 5 cm; the second robot stands on its upper end.
    log = readings((0.01, 0.05, 0, 0.1), (0.11, 0.07, 90, 2.0))
    params = sm.HsrParams(0.05, 0.05, 0.6, 0.06, cell_m=0.02)
    marks = estimate_variant_walls(log, params).marks
    assert ["".join(" wrp"[mark] for mark in row) for row in marks[::-1]] == [
        "        ",
        "      p ",
        " p    r ",
        "      w ",
        "        ",
    ]


@pytest.mark.parametrize(
    ("range_m", "length_m"), [(0.165, 0.1), (3.0, 0.3), (1.5825, 0.2), (0.0, 0.1 - 0.0116402)]
)
def test_wall_length_follows_the_papers_line(range_m, length_m):
    params = dataclasses.replace(PARAMS, threshold_m=3.0, cell_m=0.001)
    es = estimate_variant_walls(readings((0.0005, 0.0005, 0, range_m)), params)
    rows = np.nonzero((es.marks == Mark.WALL).any(axis=1))[0]
    assert (np.ptp(rows) + 1) * 0.001 == pytest.approx(length_m, abs=0.0011)


@pytest.mark.parametrize(
    ("changes", "kept", "reason"),
    [
        (50, [100], None),
        (11, [100, 50], None),
        (0, [100], HsrStop.NOTHING_CHANGED),
        (10, [100, 50], HsrStop.TOO_FEW),
        (100, [100], HsrStop.NOT_LESS),
        (50, [100, 50], HsrStop.NOT_LESS),
        (60, [100, 50], HsrStop.NOT_LESS),
    ],
)
def test_rule_for_keeping_a_pass(changes, kept, reason):
    assert _reason_to_stop(changes, kept) == reason


def test_result_tells_why_it_stopped():
    log = room_log(np.random.default_rng(7), sm.AMIGOBOT, 80)
    full = sm.hsr(log, PARAMETER_SETS[0])
    assert full.stopped in set(HsrStop) - {HsrStop.MAX_PASSES}
    assert full.rejected_updates is not None
    one = sm.hsr(log, dataclasses.replace(PARAMETER_SETS[0], max_passes=1))
    assert one.stopped == "max passes"
    assert one.rejected_updates is None
    assert one.updates_per_pass == full.updates_per_pass[:1]
    # A pass over a log that has nothing to mend.
    calm = sm.hsr(readings(WITNESS), PARAMS)
    assert (calm.updates_per_pass, calm.rejected_updates) == ((0,), None)
    assert calm.stopped is HsrStop.NOTHING_CHANGED


def test_the_original_log_stays_as_it_was():
    log = room_log(np.random.default_rng(7), sm.AMIGOBOT, 80).replace(provenance={"seed": 7})
    before = log.range_m.copy()
    result = sm.hsr(log, PARAMETER_SETS[0])
    np.testing.assert_array_equal(log.range_m, before)
    np.testing.assert_array_equal(result.updated, result.log.range_m != before)
    assert log.provenance == {"seed": 7}
    assert result.log.provenance["seed"] == 7
    (run,) = result.log.provenance["hsr"]
    assert run["max_wall_m"] == 0.15
    assert run["updates_per_pass"] == list(result.updates_per_pass)
    again = sm.hsr(result.log, PARAMETER_SETS[0])
    assert len(again.log.provenance["hsr"]) == 2


@pytest.mark.parametrize("seed", range(3))
def test_readings_only_get_shorter_and_their_order_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    log = random_log(rng, sm.AMIGOBOT, 200)
    log = log.replace(scan=np.zeros(200, int), time_s=np.zeros(200))
    result = sm.hsr(log, PARAMS)
    assert result.updated.any()
    assert (result.log.range_m[result.updated] < log.range_m[result.updated]).all()
    order = rng.permutation(200)
    shuffled = sm.hsr(log.select(order), PARAMS)
    np.testing.assert_array_equal(shuffled.log.range_m, result.log.range_m[order])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"min_wall_m": -0.01}, r"min_wall_m must be >= 0, got -0\.01"),
        ({"max_wall_m": math.nan}, r"max_wall_m must be >= 0, got nan"),
        ({"min_wall_m": 0.4}, r"min_wall_m must be <= max_wall_m, got 0\.4 and 0\.3"),
        ({"threshold_m": 0}, r"threshold_m must be > 0, got 0"),
        ({"threshold_m": math.inf}, r"threshold_m must be > 0, got inf"),
        ({"target_distance_m": -1}, r"target_distance_m must be >= 0, got -1"),
        ({"cell_m": 0}, r"cell_m must be > 0, got 0"),
        ({"cell_m": "a"}, r"cell_m must be a number, got 'a'"),
        ({"max_passes": 0}, r"max_passes must be > 0, got 0"),
        ({"max_passes": 1.5}, r"max_passes must be a whole number, got 1\.5"),
    ],
)
def test_bad_parameters(change, message):
    with pytest.raises(sm.InputError, match=message):
        dataclasses.replace(PARAMS, **change)


@pytest.mark.parametrize(
    ("rows", "change", "message"),
    [
        ([WITNESS], {"threshold_m": 3.5}, r"threshold_m must be <= the ring's range_max_m 3, got"),
        (
            [(0, 0, 0, 1.5), (0, 0, 0, np.inf), (0, 0, 0, -np.inf)],
            {},
            r"a reading up to threshold_m 1\.0, got none in 3 readings",
        ),
        ([WITNESS, (9000, 9000, 0, 1)], {}, r"cell_m is too small for a log this wide: shape"),
    ],
)
@pytest.mark.parametrize("function", [sm.hsr, estimate_variant_walls])
def test_bad_logs(rows, change, message, function):
    with pytest.raises(sm.InputError, match=message):
        function(readings(*rows), dataclasses.replace(PARAMS, **change))
