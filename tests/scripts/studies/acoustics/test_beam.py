import math

import pytest

from sim.sonar import presets as sonars
from sonarbed.studies.acoustics import (
    beam,
)

PHYSICAL = sonars.preset("physical")


def test_beams_angles_are_those_of_a_piston():
    piston = PHYSICAL.piston
    rule = math.asin(0.61 * piston.wavelength_m / piston.radius_m)
    assert beam.first_null_rad(piston) == pytest.approx(rule, abs=math.radians(0.05))
    # 2 J1(x) / x is 1 / sqrt(2) at x = 1.616.
    ka = 2 * math.pi / piston.wavelength_m * piston.radius_m
    half_power_db = 10 * math.log10(2)
    assert beam.half_angle_rad(piston, half_power_db) == pytest.approx(
        math.asin(1.616 / ka), abs=1e-4
    )
