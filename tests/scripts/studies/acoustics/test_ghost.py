import math

import pytest

from sim.sonar import presets as sonars
from sonarbed.studies.acoustics import (
    ghost,
    theory,
)

PHYSICAL = sonars.preset("physical")


@pytest.mark.parametrize(("mirrors", "slant_deg"), [(1, 30), (1, 45), (2, 40), (2, 45)])
def test_ghost_is_as_far_as_the_image_source(mirrors, slant_deg):
    corridor = ghost.Corridor(math.radians(slant_deg), mirrors)
    # Unfolded, the axis is one straight line: every leg up to a wall, and the last metre.
    up_m = 0.8 + 1.6 * (mirrors - 1)
    expected_m = up_m / math.sin(math.radians(slant_deg)) + 1.0
    assert corridor.ghost_m == pytest.approx(expected_m)
    sonar = theory.sharp(PHYSICAL.replace(max_bounces=mirrors))
    range_m, met = corridor.reading(sonar)
    assert range_m == pytest.approx(expected_m, abs=1e-4)
    assert met == mirrors
