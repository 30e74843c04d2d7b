"""What many tests need: maps as drawings, small logs, and the thesis's equations in plain words."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path

import numpy as np

import sonarmap as sm

# A real robot's log; it is not part of the repository, and tests that read it skip without it.
REAL_LOG = Path(__file__).parents[2] / "shared" / "data" / "udacity-8sonar"

# One sonar in the robot's middle that looks ahead: the simplest ring there is.
ONE = sm.SonarRing("one", [0], [0], [0], math.radians(15), 0.1, 8.0)

# Three sonars, none on the robot's axis, no two alike.
THREE = sm.SonarRing(
    "three", [0.1, -0.05, 0.0], [0.07, -0.11, 0.02], [0.4, -1.9, 2.6], math.radians(15), 0.1, 8.0
)


def cells(drawing):
    """Return the characters of a drawn map as ``array[row, col]``; the last line is row 0."""
    lines = textwrap.dedent(drawing).split()
    return np.array([list(line) for line in reversed(lines)])


def draw(log_odds):
    """Return the drawing of a map: ``.`` rather free, ``#`` rather occupied, ``?`` unknown."""
    signs = np.array(["?", "#", "."])[np.sign(log_odds).astype(int)]
    return "\n".join("".join(row) for row in signs[::-1]) + "\n"


def make_log(range_m, *, ring=ONE, **columns):
    """Return a log of the given readings; what is not given is 0, one reading a second."""
    range_m = np.atleast_1d(np.asarray(range_m, float))
    n = range_m.size
    zeros = dict.fromkeys(("sonar", "x_m", "y_m", "heading_rad"), 0)
    given = {"scan": np.arange(n), "time_s": np.arange(n), **zeros, **columns}
    whole = {
        name: np.broadcast_to(values, n) if name in sm.SonarLog.DTYPES else values
        for name, values in given.items()
    }
    return sm.SonarLog(ring=ring, range_m=range_m, **whole)


def random_log(rng, n=40, *, ring=THREE, reach_m=2.0, spread_m=1.0, truth=False):
    """Return a log of random poses and readings, some without echo, too close, stale, rejected."""
    range_m = rng.uniform(0.05, reach_m, n)
    range_m[rng.random(n) < 0.2] = np.inf
    range_m[rng.random(n) < 0.1] = -np.inf
    return make_log(
        range_m,
        ring=ring,
        sonar=rng.integers(len(ring), size=n),
        x_m=rng.uniform(-spread_m, spread_m, n),
        y_m=rng.uniform(-spread_m, spread_m, n),
        heading_rad=rng.uniform(-7, 7, n),
        stale=rng.random(n) < 0.1,
        rejected=rng.random(n) < 0.1,
        doubt=np.where(rng.random(n) < 0.3, np.nan, rng.random(n)),
        truth=random_truth(rng, n) if truth else None,
        provenance={"source": "test", "seed": 1},
    )


def random_truth(rng, n):
    return sm.LogTruth(
        x_m=rng.normal(size=n),
        y_m=rng.normal(size=n),
        heading_rad=rng.normal(size=n),
        axis_range_m=np.where(rng.random(n) < 0.2, np.inf, rng.random(n)),
        cone_range_m=np.where(rng.random(n) < 0.2, np.inf, rng.random(n)),
        cause=rng.integers(len(sm.Cause), size=n),
        surface=rng.choice(["wall_1", "Tür", ""], size=n),
        incidence_rad=np.where(rng.random(n) < 0.2, np.nan, rng.random(n)),
        bounces=rng.integers(4, size=n),
        collision=rng.random(n) < 0.5,
        source=rng.integers(-2, 3, size=n),
        level_db=np.where(rng.random(n) < 0.2, np.nan, rng.random(n)),
    )


def standard_equations(model, r, a, s):
    """P(occupied) by equations 4.9 to 4.12, for one cell at range r and bearing a >= 0."""
    beta, longest, tolerance = model.beta_rad, model.max_range_m, model.tolerance_m
    if a > beta or s > longest or r > s + tolerance:
        return 0.5
    belief = ((longest - r) / longest + (beta - a) / beta) / 2
    if r < s - tolerance:  # region 2
        return 1 - belief  # (4.12), (4.11)
    return belief * model.max_occupied  # region 1: (4.9)


def parameterized_equations(model, r, a, s):
    """P(occupied) by equations 5.1 and 5.3 to 5.5, for one cell at range r and bearing a >= 0."""
    p1, p2, p3, p4, p5 = model.p1, model.p2, model.p3_m, model.p4, model.p5_rad
    if a > p5 or r > s + p3:
        return 0.5
    if r < s - p3:
        on_axis = p1 + (0.5 - p1 - p2) / (s - p3) * r  # line 1 (5.3)
    elif r < s:
        on_axis = (0.5 + p2) + (p4 - 0.5 - p2) / p3 * (r - s + p3)  # line 3 (5.4)
    else:
        on_axis = p4 + (0.5 + p2 - p4) / p3 * (r - s)  # line 4 (5.5)
    return (p5 - a) / p5 * (on_axis - 0.5) + 0.5  # (5.1)


def equations(model, r, a, s):
    """P(occupied) of either model, one cell at a time."""
    if isinstance(model, sm.StandardModel):
        return standard_equations(model, r, a, s)
    return parameterized_equations(model, r, a, s)
