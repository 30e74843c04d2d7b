"""Range confidence: the doubt by plain loops, by hand, and in drawn scenes."""

import math

import numpy as np
import pytest
from noise_free import WIDE, drive, wall
from support import make_log, random_log

import sonarmap as sm

NAME = "range-confidence-style"


def plain_doubts(f, log):
    """Doubts of readings that all have an echo, by loops over cells and orientations."""
    ring = log.ring
    rcf = [min(max(1 - (r / ring.range_max_m) ** f.power, 0.02), 0.98) for r in log.range_m]
    weight = [each * math.log(f.p_seen / f.p_missed) for each in rcf]
    normals = [2 * math.pi * k / f.orientations for k in range(f.orientations)]

    def faces(angle, normal):
        return abs(math.remainder(angle - normal, 2 * math.pi)) <= f.critical_rad

    arcs = []  # per reading: cell (col, row counted from x = y = 0) -> direction to the sonar
    for (x, y), axis, r in zip(log.sensor_xy_m, log.axis_rad, log.range_m, strict=True):
        arc = {}
        reach = int((r + 1) / f.cell_m)
        for col in range(int(x / f.cell_m) - reach, int(x / f.cell_m) + reach):
            for row in range(int(y / f.cell_m) - reach, int(y / f.cell_m) + reach):
                cx, cy = (col + 0.5) * f.cell_m, (row + 0.5) * f.cell_m
                off = math.remainder(math.atan2(cy - y, cx - x) - axis, 2 * math.pi)
                if abs(off) > ring.half_angle_rad:
                    continue
                if abs(math.hypot(cx - x, cy - y) - r) <= f.cell_m / 2:
                    arc[col, row] = math.atan2(y - cy, x - cx)
        arcs.append(arc)
    doubts = []
    for i in range(len(log)):
        best = 0.0
        for at, mine in arcs[i].items():
            p = [1.0] * f.orientations
            for other in range(len(log)):
                if other != i and at in arcs[other]:
                    for k, normal in enumerate(normals):
                        if faces(arcs[other][at], normal):
                            p[k] *= math.exp(weight[other])
            sides = {True: [], False: []}
            for each, normal in zip(p, normals, strict=True):
                sides[faces(mine, normal)].append(each)
            best = max(best, np.mean(sides[True]) / np.mean(sides[False]))
        right = rcf[i] * (best or 1.0)
        doubts.append((1 - rcf[i]) / (right + 1 - rcf[i]))
    return doubts


def test_equals_plain_loops(rng):
    log = random_log(rng, 60)
    f = sm.filter(NAME)
    made = f.apply(log)
    judged = log.usable & np.isfinite(log.range_m)
    np.testing.assert_allclose(made.doubt[judged], plain_doubts(f, log.select(judged)), rtol=1e-9)
    np.testing.assert_array_equal(made.doubt[~judged], log.doubt[~judged])


def test_the_confidence_of_a_lone_reading_is_that_of_its_range():
    # 1 - (R / 8 m)^2: 0.9375 at 2 m, 0.4375 at 6 m.
    made = sm.filter(NAME).apply(make_log([2.0, 6.0, math.inf], x_m=[0, 20, 40]))
    np.testing.assert_allclose(made.doubt, [0.0625, 0.5625, math.nan])
    assert not made.rejected.any()


def scene():
    """A drive along a wall, and a look into a corner where a mirror sends the sound far away."""
    along = [(x, 0.0, math.pi / 2) for x in np.arange(0, 1.5, 0.1)]
    log = drive(WIDE, along, wall(-1, 1.0, 3, 1.0))
    far = make_log(3.9, ring=WIDE, x_m=0.7, heading_rad=0.3, scan=99, time_s=99)
    columns = {
        name: np.concatenate([getattr(log, name), getattr(far, name)]) for name in log.DTYPES
    }
    return sm.SonarLog(WIDE, **columns)


def test_a_wall_seen_again_is_trusted_and_a_long_lone_reading_is_not():
    made = sm.filter(NAME).apply(scene())
    assert (made.doubt[:-1] < 0.1).all()
    assert made.doubt[-1] > 0.9
    assert made.rejected.tolist() == [False] * 15 + [True]
    assert made.likely_cause.tolist() == [-1] * 15 + [sm.Cause.BOUNCE]
    assert not made.changed.any()
    assert not sm.filter(NAME, reject_from=1.0).apply(scene()).rejected.any()


def test_order_turns_and_mirrors_change_nothing(rng):
    log = random_log(rng, 80, ring=WIDE)
    f = sm.filter(NAME)
    expected = f.apply(log).doubt
    names = ("range_m", "x_m", "y_m", "heading_rad", "stale", "rejected", "doubt")
    backwards = {name: getattr(log, name)[::-1] for name in names}
    made = f.apply(make_log(backwards.pop("range_m"), ring=WIDE, **backwards))
    np.testing.assert_allclose(made.doubt[::-1], expected, rtol=1e-9)
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    mirrored = log.replace(y_m=-log.y_m, heading_rad=-log.heading_rad)
    for other in (turned, mirrored):
        np.testing.assert_allclose(f.apply(other).doubt, expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"power": 0}, "power must be > 0, got 0"),
        ({"critical_rad": 2}, r"critical_rad must be in \(0, pi/2\), got 2"),
        ({"p_seen": 0.2}, "p_missed and p_seen must be .*, got 0.3 and 0.2"),
        ({"orientations": 3}, "orientations must be >= 4, got 3"),
        ({"cell_m": 0}, "cell_m must be > 0, got 0"),
        ({"reject_from": 1.1}, r"reject_from must be within \[0, 1\], got 1.1"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.filter(NAME, **parameters)
