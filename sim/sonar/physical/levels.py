"""How loud a sound is: compiled arithmetic of beam, air and receiver.

Levels are decibels over the threshold of a receiver without time-varied gain, unless stated
otherwise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.jit import njit

__all__ = [
    "Acoustics",
    "beam_bound_db",
    "beam_db",
    "loudest_echo_db",
    "mirror_echo_db",
    "tvg_db",
    "wrapped",
]


class Acoustics(NamedTuple):
    """What the compiled steps know of a sonar and the air.

    Parameters
    ----------
    speed_mps, absorption_db_per_m : float
        Of the air that there is.
    nominal_speed_mps, nominal_absorption_db_per_m : float
        Of the air that the time-varied gain is made for.
    assumed_speed_mps : float
        With which the robot turns times into ranges.
    dynamic_range_db, gain_share, pulse_s, blanking_s : float
        See `sim.sonar.physical.receiver.Receiver`.
    edge_db : float
        Level of an edge at 1 m against a plane at 1 m.
    window_s : float
        How long a sonar listens after its firing.
    head_start_s : float
        How long before a sonar another one may have fired whose sound it detects.
    life_s : float
        How long a sound is remembered.
    wavelength_m : float
        Of the tone in the air that there is.
    fresnel : ndarray
        See `sim.sonar.physical.fresnel.fresnel_table`.
    beam_db : ndarray
        One-way level at even steps from 0 to pi.
    beyond_db : ndarray
        The highest level at these angles or farther off the axis.
    """

    speed_mps: float
    absorption_db_per_m: float
    nominal_speed_mps: float
    nominal_absorption_db_per_m: float
    assumed_speed_mps: float
    dynamic_range_db: float
    gain_share: float
    pulse_s: float
    blanking_s: float
    edge_db: float
    window_s: float
    head_start_s: float
    life_s: float
    wavelength_m: float
    fresnel: NDArray[np.float64]
    beam_db: NDArray[np.float64]
    beyond_db: NDArray[np.float64]


@njit()
def wrapped(angle):
    """Return an angle within [-pi, pi)."""
    return angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)


@njit()
def beam_db(acoustics, angle):
    """Return the one-way level at an angle off the axis against the axis."""
    table = acoustics.beam_db
    place = abs(wrapped(angle)) / math.pi * (table.size - 1)
    low = min(int(place), table.size - 2)
    return table[low] + (place - low) * (table[low + 1] - table[low])


@njit()
def beam_bound_db(acoustics, low, high):
    """Return a level that the beam does not exceed between two angles off the axis."""
    table = acoustics.beyond_db
    nearest = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
    return table[min(int(nearest / math.pi * (table.size - 1)), table.size - 1)]


@njit()
def tvg_db(acoustics, time_s):
    """Return the time-varied gain that the receiver adds `time_s` after its firing."""
    half = max(acoustics.nominal_speed_mps * time_s / 2, 0.01)
    spread = 20 * math.log10(half)
    absorbed = 2 * acoustics.nominal_absorption_db_per_m * (half - 1)
    return acoustics.gain_share * (spread + absorbed)


@njit()
def mirror_echo_db(acoustics, path_m):
    """Return the level of a perfect mirror's echo on the axis, by the length of its path.

    It is the dynamic range less the propagation loss beyond 1 m: spreading and absorption.
    """
    spread = 20 * math.log10(max(path_m, 0.01) / 2)
    # The dynamic range is that at 1 m of normal air.
    return (
        acoustics.dynamic_range_db
        - spread
        - acoustics.absorption_db_per_m * path_m
        + 2 * acoustics.nominal_absorption_db_per_m
    )


@njit()
def loudest_echo_db(acoustics, path_m):
    """Return the level, with time-varied gain, of a perfect mirror's echo at any sonar."""
    latest_s = min(path_m / acoustics.speed_mps + acoustics.head_start_s, acoustics.window_s)
    return mirror_echo_db(acoustics, path_m) + tvg_db(acoustics, latest_s)
