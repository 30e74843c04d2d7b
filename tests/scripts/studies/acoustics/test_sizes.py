"""Plates and zones beside theory."""

import numpy as np
import pytest

from sim.sonar import presets as sonars
from sonarbed.reporting.bench import board, post, scene
from sonarbed.studies.acoustics import sizes
from sonarbed.studies.acoustics.theory import GLASS, sharp

SHARP = sharp(sonars.preset("physical"))
WAVELENGTH_M = SHARP.piston.wavelength_m


@pytest.mark.parametrize("distance_m", [1.0, 3.0])
def test_small_strips_lose_six_decibels_at_each_halving_and_large_ones_nothing(distance_m):
    small = [sizes.strip_db(width, distance_m, WAVELENGTH_M) for width in (0.02, 0.01, 0.005)]
    assert np.diff(small) == pytest.approx([-6.02, -6.02], abs=0.1)
    assert sizes.strip_db(50.0, distance_m, WAVELENGTH_M) == pytest.approx(0, abs=0.1)


def zone(solid):
    """Return the bearings and distances at which a thing is detected, as a table."""
    distance_m, bearing_rad = np.arange(0.3, 4.9, 0.5), np.radians(np.arange(-60, 61, 3))
    return sizes._heard(SHARP, scene(solid), distance_m, bearing_rad)


def test_zone_of_a_rod_lies_within_that_of_a_plate_and_narrows():
    rod, plate = zone(post("rod", 0.0125, material=GLASS)), zone(board("p", 0.5, material=GLASS))
    assert not (rod & ~plate).any()
    assert rod.sum() < plate.sum()
    for heard in (rod, plate):
        assert (heard == heard[:, ::-1]).all()
        widths = heard.sum(axis=1)
        assert widths[0] > widths[-1] > 0
