"""How loud a sound is: compiled arithmetic of beam, air and receiver.

Levels are decibels over the threshold of a receiver without time-varied gain, unless stated
otherwise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical import tables
from sonarmap.kernels.jit import njit

__all__ = [
    "ABOUT_DB",
    "ABOUT_FROM_M",
    "Acoustics",
    "about_own_db",
    "amplitude",
    "beam_bound_db",
    "beam_db",
    "lost_reach_m",
    "loudest_echo_db",
    "loudest_other_db",
    "mirror_echo_db",
    "others_tvg_db",
    "power_db",
    "tvg_db",
    "widest_rad",
    "wrapped",
]


_NEPER_PER_DB = math.log(10) / 20
ABOUT_FROM_M, ABOUT_DB = 0.3, 0.5
"""From a path so long on `about_own_db` is right to so much."""
# Entries of the beam's tables in a radian.
_PER_RAD = (tables.BEAM_STEPS - 1) / math.pi


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
        How much later than it was sent, at most, a sound counts for the gain of a sonar that did
        not send it: the longest that one fires before another one whose sound it still hears;
        where nobody listens to a fresh sound, less than 0, the shortest time between two firings.
    life_s : float
        How long a sound is remembered.
    wavelength_m : float
        Of the tone in the air that there is.
    path_step_m : float
        Between two entries of the tables by path.
    tables : ndarray
        See `sim.sonar.physical.tables`.
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
    path_step_m: float
    tables: NDArray[np.float64]


@njit(forceinline=True)
def amplitude(level_db):
    """Return the amplitude of a level against that of 0 dB; `exp` costs half of `pow`."""
    return math.exp(level_db * _NEPER_PER_DB)


@njit(forceinline=True)
def power_db(share):
    """Return the level of a share of the power; no power has one, too, -120 dB."""
    return 10 * math.log10(share + 1e-12)


@njit(forceinline=True)
def wrapped(angle):
    """Return an angle within [-pi, pi)."""
    return angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)


@njit(forceinline=True)
def beam_db(acoustics, angle):
    """Return the one-way level at an angle off the axis against the axis."""
    place = abs(wrapped(angle)) * _PER_RAD
    low = min(int(place), tables.BEAM_STEPS - 2)
    one = acoustics.tables[tables.BEAM + low]
    return one + (place - low) * (acoustics.tables[tables.BEAM + low + 1] - one)


@njit(forceinline=True)
def beam_bound_db(acoustics, low, high):
    """Return a level that the beam does not exceed between two angles off the axis."""
    nearest = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
    return acoustics.tables[tables.BEYOND + min(int(nearest * _PER_RAD), tables.BEAM_STEPS - 1)]


@njit()
def widest_rad(acoustics, level_db):
    """Return an angle off the axis beyond which the beam, there and back, takes away a level."""
    low, high = 0, tables.BEAM_STEPS - 1
    while low < high:
        middle = (low + high) // 2
        if 2 * acoustics.tables[tables.BEYOND + middle] + level_db > 0:
            low = middle + 1
        else:
            high = middle
    return low / _PER_RAD


@njit(forceinline=True)
def tvg_db(acoustics, time_s):
    """Return the time-varied gain that the receiver adds `time_s` after its firing."""
    half = max(acoustics.nominal_speed_mps * time_s / 2, 0.01)
    spread = 20 * math.log10(half)
    absorbed = 2 * acoustics.nominal_absorption_db_per_m * (half - 1)
    return acoustics.gain_share * (spread + absorbed)


@njit(forceinline=True)
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


@njit(forceinline=True)
def loudest_echo_db(acoustics, path_m):
    """Return the level, with time-varied gain, of a perfect mirror's echo at who sent it."""
    latest_s = min(path_m / acoustics.speed_mps, acoustics.window_s)
    return mirror_echo_db(acoustics, path_m) + tvg_db(acoustics, latest_s)


@njit(forceinline=True)
def about_own_db(acoustics, path_m):
    """Return `loudest_echo_db` from a table, within `ABOUT_DB` beyond `ABOUT_FROM_M` of path."""
    place = min(int(path_m / acoustics.path_step_m + 0.5), tables.PATH_STEPS - 1)
    return acoustics.tables[tables.OWN + place]


@njit(forceinline=True)
def lost_reach_m(acoustics, loss_db):
    """Return how far sound reaches, there and back, that is weaker than a mirror's on the axis."""
    return acoustics.tables[tables.LOST + max(0, min(tables.LOST_STEPS - 1, int(loss_db)))]


@njit(forceinline=True)
def others_tvg_db(acoustics, path_m):
    """Return the most gain that another sonar's sound gets after a path."""
    latest_s = path_m / acoustics.speed_mps + acoustics.head_start_s
    return tvg_db(acoustics, min(latest_s, acoustics.window_s))


@njit(forceinline=True)
def loudest_other_db(acoustics, path_m):
    """Return the level of a perfect mirror's echo of another sonar on a path, or a longer one."""
    place = min(int(path_m / acoustics.path_step_m), tables.PATH_STEPS - 1)
    return acoustics.tables[tables.OTHERS + place]
