"""Sweeps of single things against theory and arithmetic."""

import math

import numpy as np
import pytest

from sim import Piston
from sim.sonar import presets as sonars
from sonarbed.studies.acoustics import (
    theory,
)
from sonarbed.studies.acoustics.regions import sweeps, targets

PHYSICAL = sonars.preset("physical")


STEP_DEG = 0.5


def swept(target, sonar=None):
    axis = np.radians(np.arange(-180, 180, STEP_DEG))
    sonar = theory.sharp(PHYSICAL) if sonar is None else sonar
    heard = sweeps.sweep(sonar, target.world, (-target.distance_m, 0.0), axis)
    return axis, heard.range_m


@pytest.mark.parametrize("number", range(6))
def test_single_things_are_read_at_the_distance_of_theory(number):
    target = targets.targets(PHYSICAL)[number]
    axis, read_m = swept(target)
    deviation = sweeps.compared(read_m, theory.range_m(PHYSICAL, target.loci, axis))
    assert deviation.largest_m < 1e-6
    # Steps that fall beside the end of an arc may disagree by rounding.
    assert deviation.agreeing > 0.995
    own = np.isclose(read_m, [2.0, 2.0, 1.0, 1.0, 1.0, 1.0][number], atol=1e-3)
    assert own[np.argmin(np.abs(axis))]
    assert own.any() == np.isfinite(read_m).any()


def test_width_of_a_planes_arc_is_that_of_beam_and_level():
    # At 2 m spreading takes 6.02 dB and two more metres of air 1.64 each; 30 % of it stays lost.
    loss_db = 20 * math.log10(2) + 2 * PHYSICAL.air.absorption_db_per_m(49_400)
    over_db = 48 - 0.3 * loss_db
    assert theory.plane_over_db(PHYSICAL, 2.0) == pytest.approx(over_db)
    (begin, end), *side = theory.heard_spans_rad(PHYSICAL, over_db)
    assert begin == 0
    assert 2 * Piston().level_db(end) == pytest.approx(-over_db, abs=0.1)
    assert len(side) == 1
    axis, read_m = swept(targets.targets(PHYSICAL)[0])
    heard = np.degrees(axis[np.isfinite(read_m)])
    assert heard.max() == pytest.approx(math.degrees(side[0][1]), abs=STEP_DEG)


def test_side_walls_of_a_corner_are_read_where_they_are_nearest():
    axis, read_m = swept(targets.targets(PHYSICAL)[1])
    beside = np.isclose(np.abs(np.degrees(axis)), 45)
    assert read_m[beside] == pytest.approx([math.sqrt(2)] * 2, abs=1e-6)


def test_comparison_counts_what_only_one_side_hears():
    inf = math.inf
    deviation = sweeps.compared(np.array([1, inf, 1, 2.1]), np.array([1.02, inf, inf, 2.1]))
    assert deviation == sweeps.Deviation(pytest.approx(0.02), 0.75)
    assert math.isnan(sweeps.compared(np.array([inf]), np.array([1.0])).largest_m)
