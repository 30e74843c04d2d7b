"""Air and beam against tables that were computed elsewhere."""

import math

import numpy as np
import pytest

from sim.sonar.air import Air
from sim.sonar.physical.piston import Piston
from sonarmap import InputError


@pytest.mark.parametrize(
    ("temperature_c", "speed_mps"), [(0, 331.3), (10, 337.3), (20, 343.2), (30, 349.0)]
)
def test_speed_of_sound(temperature_c, speed_mps):
    assert Air(temperature_c).speed_mps == pytest.approx(speed_mps, abs=0.06)


@pytest.mark.parametrize(
    ("temperature_c", "expected"),
    [
        (10, [0.56, 0.71, 0.86, 1.01, 1.14, 1.34]),
        (20, [0.93, 1.25, 1.50, 1.64, 1.70, 1.68]),
        (30, [1.61, 1.92, 1.95, 1.86, 1.73, 1.50]),
    ],
)
def test_absorption_at_49_khz(temperature_c, expected):
    humidity = (20, 30, 40, 50, 60, 80)
    absorption = [Air(temperature_c, h).absorption_db_per_m(49_400) for h in humidity]
    assert absorption == pytest.approx(expected, rel=0.01)


def test_absorption_at_1_khz_is_that_of_the_standards_table():
    # ISO 9613-2, table 2: 20 degrees, 70 %: 5.0 dB/km at 1 kHz, 76.6 at 8 kHz.
    assert 1000 * Air(20, 70).absorption_db_per_m(1000) == pytest.approx(5.0, abs=0.1)
    assert 1000 * Air(20, 70).absorption_db_per_m(8000) == pytest.approx(76.6, rel=0.02)


def first_angle_deg(piston, level_db):
    angle = np.radians(np.linspace(0, 20, 20001))
    return math.degrees(angle[np.argmax(piston.level_db(angle) < level_db)])


@pytest.mark.parametrize(
    ("radius_m", "half_power_deg", "half_amplitude_deg", "null_deg"),
    [(0.0192, 5.3, 7.3, 12.7), (0.0165, 6.2, 8.5, 14.9)],
)
def test_main_lobe(radius_m, half_power_deg, half_amplitude_deg, null_deg):
    piston = Piston(radius_m)
    assert first_angle_deg(piston, -3.0) == pytest.approx(half_power_deg, abs=0.06)
    assert first_angle_deg(piston, -6.0) == pytest.approx(half_amplitude_deg, abs=0.06)
    assert first_angle_deg(piston, -50.0) == pytest.approx(null_deg, abs=0.15)


@pytest.mark.parametrize(("angle_deg", "level_db"), [(17.2, -17.6), (29.0, -23.8), (42.0, -28.0)])
def test_side_lobes(angle_deg, level_db):
    near = np.radians(angle_deg + np.linspace(-3, 3, 601))
    assert Piston().level_db(near).max() == pytest.approx(level_db, abs=0.06)
    assert Piston().level_db(math.radians(angle_deg)) == pytest.approx(level_db, abs=0.1)


@pytest.mark.parametrize(
    ("dynamic_range_db", "reach_deg"),
    [(10, 6.7), (20, 9.0), (30, 10.4), (36, 18.3), (40, 19.8), (48, 29.7), (56, 42.4), (60, 45.0)],
)
def test_reach_is_that_of_the_lobes(dynamic_range_db, reach_deg):
    assert math.degrees(Piston().reach_rad(dynamic_range_db)) == pytest.approx(reach_deg, abs=0.6)


def test_nothing_goes_backwards():
    assert (Piston().level_db(np.radians([90, 120, -150, 180])) <= -100).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Air(-21), r"temperature_c must be within \[-20, 50\], got -21"),
        (lambda: Air(math.nan), r"temperature_c must be within \[-20, 50\], got nan"),
        (lambda: Air(20, 101), r"humidity_percent must be within \[0, 100\], got 101"),
        (lambda: Air().absorption_db_per_m(0), r"frequency_hz must be > 0, got 0"),
        (lambda: Piston(0), r"radius_m must be > 0, got 0"),
        (lambda: Piston(frequency_hz=-1), r"frequency_hz must be > 0, got -1"),
        (lambda: Piston(0.001), r"radius_m must be >= 0.61 wavelengths \(0.00424 m\), got 0.001"),
        (lambda: Piston(0.2), r"radius_m must have its far field within 1 m .* got 0.2"),
    ],
)
def test_impossible_numbers_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
