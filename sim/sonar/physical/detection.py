"""Compiled: what sonars detect of the sounds that are under way, and what they read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.causes import cause_of
from sim.sonar.cone.kernel import measured
from sim.sonar.physical import columns as t
from sim.sonar.physical.levels import amplitude, tvg_db
from sonarmap import Cause, LogTruth
from sonarmap.kernels.jit import njit

__all__ = ["Detections", "Reading", "detect", "readings"]

_CROSSTALK, _NO_SOURCE = int(Cause.CROSSTALK), int(LogTruth.NO_SOURCE)


class Detections(NamedTuple):
    """What n firings detected, see `sim.sonar.protocol.Echoes`; the range is without noise."""

    range_m: NDArray[np.float64]
    cause: NDArray[np.int8]
    surface: NDArray[np.int32]
    incidence_rad: NDArray[np.float64]
    bounces: NDArray[np.int16]
    source: NDArray[np.int16]
    level_db: NDArray[np.float64]


class Reading(NamedTuple):
    """How a detection becomes a reading.

    Parameters
    ----------
    noise_std_m, weak_noise_std_m, quantum_m : float
        See `sim.sonar.physical.receiver.Receiver`.
    near_m, far_m : float
        Nearest and farthest range of the ring.
    """

    noise_std_m: float
    weak_noise_std_m: float
    quantum_m: float
    near_m: float
    far_m: float


@njit()
def detect(fired, sounds, acoustics):
    """Return (what firings detected, the sounds that later ones may still detect).

    Parameters
    ----------
    fired : ndarray, shape (n, FIRED_COLUMNS)
        In the order of time.
    sounds : ndarray, shape (m, SOUND_COLUMNS)
        All that are under way.
    acoustics : Acoustics
    """
    n = len(fired)
    detections = Detections(
        np.full(n, math.inf),
        np.empty(n, np.int8),
        np.full(n, -1, np.int32),
        np.full(n, math.nan),
        np.zeros(n, np.int16),
        np.full(n, _NO_SOURCE, np.int16),
        np.full(n, math.nan),
    )
    half_m = np.full(n, math.inf)
    others = np.zeros(n, np.bool_)
    for r in range(n):
        k, time_s, over_db = _first_crossing(fired[r], sounds, acoustics)
        if k < 0:
            continue
        sound = sounds[k]
        detections.range_m[r] = acoustics.assumed_speed_mps * time_s / 2
        detections.surface[r] = int(sound[t.SOUND_SURFACE])
        detections.incidence_rad[r] = sound[t.SOUND_INCIDENCE]
        detections.bounces[r] = int(sound[t.SOUND_BOUNCES])
        detections.source[r] = int(sound[t.SOUND_SOURCE])
        detections.level_db[r] = over_db
        half_m[r] = sound[t.SOUND_PATH] / 2
        others[r] = (
            sound[t.SOUND_SOURCE] != fired[r, t.FIRED_SONAR]
            or sound[t.SOUND_SENT] != fired[r, t.FIRED_TIME]
        )
    detections.cause[:] = cause_of(
        half_m,
        detections.bounces,
        np.ascontiguousarray(fired[:, t.FIRED_AXIS]),
        np.ascontiguousarray(fired[:, t.FIRED_CONE]),
    )
    detections.cause[others] = _CROSSTALK
    fresh = sounds[:, t.SOUND_SENT] + acoustics.life_s > fired[n - 1, t.FIRED_TIME]
    return detections, sounds[fresh]


@njit()
def _first_crossing(firing, sounds, acoustics):
    """Return (sound detected first or -1, time since the firing, level over the threshold)."""
    first, time_s, over_db = -1, math.inf, math.nan
    for k in range(len(sounds)):
        sound = sounds[k]
        if sound[t.SOUND_LISTENER] != firing[t.FIRED_SONAR]:
            continue
        travel_s = sound[t.SOUND_PATH] / acoustics.speed_mps
        if travel_s > acoustics.life_s:
            continue
        arrival_s = sound[t.SOUND_SENT] + travel_s - firing[t.FIRED_TIME]
        if arrival_s <= 0 or arrival_s > acoustics.window_s:
            continue
        over = sound[t.SOUND_LEVEL] + tvg_db(acoustics, arrival_s)
        if over <= 0:
            continue
        crossing_s = arrival_s + acoustics.pulse_s * amplitude(-over)
        if crossing_s < acoustics.blanking_s:
            if arrival_s + acoustics.pulse_s < acoustics.blanking_s:
                continue  # over before the receiver opens
            crossing_s = acoustics.blanking_s
        if crossing_s <= acoustics.window_s and crossing_s < time_s:
            first, time_s, over_db = k, crossing_s, over
    return first, time_s, over_db


@njit()
def readings(detections, draws, surfaces, reading):
    """Return what the sonars read of what they detected.

    Parameters
    ----------
    detections : Detections
    draws : ndarray
        Of the normal distribution, one a firing.
    surfaces : ndarray, shape (surfaces + 1, SURFACE_COLUMNS)
        See `sim.sonar.physical.tracing.advance`.
    reading : Reading
    """
    noise_std_m, weak_noise_std_m, quantum_m, near_m, far_m = reading
    reading_m = np.empty(draws.size)
    for r in range(draws.size):
        jitter_m = weak_noise_std_m * amplitude(-detections.level_db[r])
        roughness_m = surfaces[detections.surface[r], t.SURFACE_ROUGHNESS]
        reading_m[r] = measured(
            detections.range_m[r],
            roughness_m,
            draws[r],
            math.hypot(noise_std_m, jitter_m),
            1.0,
            quantum_m,
            near_m,
            far_m,
            math.inf,
        )
    return reading_m
