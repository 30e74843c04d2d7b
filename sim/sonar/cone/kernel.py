"""The compiled steps of the simple cone: rays begin, and what becomes of them at a surface."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["OFF_SURFACE_M", "all_measured", "measured", "meet_surfaces", "open_fans", "turned"]

OFF_SURFACE_M = 1e-6
"""A mirrored ray begins this far off the surface, so that it does not meet it again."""


@njit(cache=True)
def turned(cos, sin, cos_bearing, sin_bearing):
    """Return the direction (x, y) at a bearing off an axis, both given as cosine and sine."""
    return cos * cos_bearing - sin * sin_bearing, sin * cos_bearing + cos * sin_bearing


@njit(cache=True)
def open_fans(sensor_xy_m, axis_rad, bearing_rad):
    """Return the rays of k fans, as `meet_surfaces` takes them.

    Parameters
    ----------
    sensor_xy_m, axis_rad : ndarray, shapes (k, 2), (k,)
        Where each fan begins, metres, and its axis.
    bearing_rad : ndarray, shape (rays,)
        Bearings of its rays off the axis.

    Returns
    -------
    fan, origin, direction, travelled_m, strength : ndarray
        Of k times rays rays, fan by fan; nothing travelled yet, nothing lost.
    """
    rays = bearing_rad.size
    n = axis_rad.size * rays
    fan = np.empty(n, np.int64)
    origin, direction = np.empty((n, 2)), np.empty((n, 2))
    cos_bearing, sin_bearing = np.cos(bearing_rad), np.sin(bearing_rad)
    for k in range(axis_rad.size):
        cos, sin = math.cos(axis_rad[k]), math.sin(axis_rad[k])
        for j in range(rays):
            i = k * rays + j
            fan[i] = k
            origin[i, 0], origin[i, 1] = sensor_xy_m[k, 0], sensor_xy_m[k, 1]
            direction[i, 0], direction[i, 1] = turned(cos, sin, cos_bearing[j], sin_bearing[j])
    return fan, origin, direction, np.zeros(n), np.ones(n)


@njit(cache=True)
def meet_surfaces(
    fan,
    origin,
    direction,
    travelled_m,
    strength,
    leg_m,
    normal,
    surface,
    critical_cos,
    reflectivity,
    threshold,
    bounce,
    best_m,
    best_surface,
    best_incidence_rad,
    best_bounces,
):
    """Let rays return to their fan or mirror them on; return those still under way.

    A ray that meets its surface within the critical angle returns: its fan keeps the first
    return in the ``best_*`` arrays, changed in place. A ray beyond it is mirrored, as long as
    it is loud enough and may still be the first of its fan.

    Parameters
    ----------
    fan : ndarray of int, shape (n,)
        The fan of each ray, an index of the ``best_*`` arrays.
    origin, direction : ndarray, shape (n, 2)
        Where the last leg began, metres, and its unit direction.
    travelled_m, strength : ndarray, shape (n,)
        Way before the last leg, metres, and share of the amplitude that is left.
    leg_m, normal, surface : ndarray, shapes (n,), (n, 2), (n,)
        What the leg met, as `worlds.RayHits`.
    critical_cos, reflectivity : ndarray, shape (surfaces,)
        What the surfaces do to sound: cosine of the critical angle of incidence, and share of the
        amplitude that is sent on.
    threshold : float
        Weaker sound is lost.
    bounce : int
        Mirrors on the way so far.
    best_m, best_surface, best_incidence_rad, best_bounces : ndarray, shape (fans,)
        The first return of each fan so far; ``best_m`` begins as the maximum range.

    Returns
    -------
    fan, origin, direction, travelled_m, strength : ndarray
        As the parameters, of the m <= n rays that are mirrored on.
    """
    n = fan.size
    mirrored = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        if surface[i] < 0:
            continue
        travelled_m[i] += leg_m[i]
        strength[i] *= reflectivity[surface[i]]
        if strength[i] < threshold:
            continue
        cos = -(direction[i, 0] * normal[i, 0] + direction[i, 1] * normal[i, 1])
        if cos < critical_cos[surface[i]]:
            mirrored[count] = i
            count += 1
        elif travelled_m[i] < best_m[fan[i]] or (
            # An echo from exactly the maximum range is one.
            best_surface[fan[i]] < 0 and travelled_m[i] == best_m[fan[i]]
        ):
            best_m[fan[i]] = travelled_m[i]
            best_surface[fan[i]] = surface[i]
            best_incidence_rad[fan[i]] = math.acos(min(cos, 1.0))
            best_bounces[fan[i]] = bounce

    on = np.empty(count, np.int64)
    m = 0
    for k in range(count):
        i = mirrored[k]
        if travelled_m[i] + OFF_SURFACE_M < best_m[fan[i]]:
            on[m] = i
            m += 1
            for axis in range(2):
                origin[i, axis] += leg_m[i] * direction[i, axis] + OFF_SURFACE_M * normal[i, axis]
            along = direction[i, 0] * normal[i, 0] + direction[i, 1] * normal[i, 1]
            for axis in range(2):
                direction[i, axis] -= 2 * along * normal[i, axis]
    on = on[:m]
    return fan[on], origin[on], direction[on], travelled_m[on], strength[on]


@njit(cache=True)
def measured(echo_m, roughness_m, noise, noise_std_m, scale, quantum_m, near_m, far_m, silent_m):
    """Return what a sonar reads of an echo at a range.

    Parameters
    ----------
    echo_m : float
        Range of the echo; +inf for none.
    roughness_m : float
        Of the surface that sends it.
    noise : float
        A standard normal number.
    noise_std_m, scale, quantum_m : float
        Standard deviation of the noise, what ranges are multiplied with, step of the readings
        (0 for none).
    near_m, far_m, silent_m : float
        Nearest and farthest reading, and the reading of no echo.
    """
    if math.isinf(echo_m):
        return silent_m
    reading = scale * echo_m + noise * math.hypot(noise_std_m, roughness_m)
    if quantum_m > 0.0:
        reading = np.rint(reading / quantum_m) * quantum_m
    # Noise alone must not turn an echo at the very end of the range into silence.
    reading = min(reading, far_m)
    return -math.inf if reading < near_m else reading


@njit(cache=True)
def all_measured(
    echo_m, roughness_m, noise, noise_std_m, scale, quantum_m, near_m, far_m, silent_m
):
    """Return `measured` of k sonars; the first three parameters have shape (k,)."""
    reading_m = np.empty(echo_m.size)
    for k in range(echo_m.size):
        reading_m[k] = measured(
            echo_m[k],
            roughness_m[k],
            noise[k],
            noise_std_m,
            scale,
            quantum_m,
            near_m,
            far_m,
            silent_m,
        )
    return reading_m
