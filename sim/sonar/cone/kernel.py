"""The compiled steps of the simple cone: rays begin, and what becomes of them at a surface."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.jit import njit

__all__ = [
    "OFF_SURFACE_M",
    "FirstReturns",
    "Rays",
    "Surfaces",
    "all_measured",
    "measured",
    "meet_surfaces",
    "open_fans",
    "turned",
]

OFF_SURFACE_M = 1e-6
"""A mirrored ray begins this far off the surface, so that it does not meet it again."""


class Rays(NamedTuple):
    """Rays of fans on their current leg, arrays of n entries.

    Parameters
    ----------
    fan : ndarray of int, shape (n,)
        The fan of each ray.
    origin, direction : ndarray, shape (n, 2)
        Where the leg begins, metres, and its unit direction.
    travelled_m, strength : ndarray, shape (n,)
        Path before the leg, metres, and share of the amplitude that is left.
    """

    fan: NDArray[np.int64]
    origin: NDArray[np.float64]
    direction: NDArray[np.float64]
    travelled_m: NDArray[np.float64]
    strength: NDArray[np.float64]


class Surfaces(NamedTuple):
    """What the surfaces of a room do to sound, arrays of shape (surfaces,).

    Parameters
    ----------
    critical_cos, reflectivity : ndarray
        Cosine of the critical angle of incidence, and share of the amplitude that is sent on.
    roughness_m : ndarray
        Of each surface, metres.
    """

    critical_cos: NDArray[np.float64]
    reflectivity: NDArray[np.float64]
    roughness_m: NDArray[np.float64]


class FirstReturns(NamedTuple):
    """The first return of each fan so far, arrays of shape (fans,).

    Parameters
    ----------
    range_m : ndarray
        Its range; the maximum range where there is none yet.
    surface, bounces : ndarray of int
        What sent it, -1 for none yet, and over how many mirrors.
    incidence_rad : ndarray
        Angle of incidence there.
    """

    range_m: NDArray[np.float64]
    surface: NDArray[np.int32]
    incidence_rad: NDArray[np.float64]
    bounces: NDArray[np.int16]


@njit()
def turned(cos, sin, cos_bearing, sin_bearing):
    """Return the direction (x, y) at a bearing off an axis, both given as cosine and sine."""
    return cos * cos_bearing - sin * sin_bearing, sin * cos_bearing + cos * sin_bearing


@njit()
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
    tuple
        Fields of the `Rays`, fan by fan; nothing travelled yet, nothing lost.
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


@njit()
def meet_surfaces(rays, leg_m, normal, surface, surfaces, threshold, bounce, first):
    """Let rays return to their fan or mirror them on; return those still under way.

    A ray that meets its surface within the critical angle returns: its fan keeps the first
    return. A ray beyond it is mirrored, as long as it is loud enough and may still be the first
    of its fan.

    Parameters
    ----------
    rays, surfaces, first : tuple
        Fields of `Rays`, `Surfaces` and `FirstReturns`; the first and the last are changed in
        place. (Numba takes a plain tuple over from Python in less than half of the time of a
        named one.)
    leg_m, normal, surface : ndarray, shapes (n,), (n, 2), (n,)
        What the legs of the rays met, as `worlds.RayHits`.
    threshold : float
        Weaker sound is lost.
    bounce : int
        Mirrors on the path so far.

    Returns
    -------
    tuple
        Fields of the `Rays` that are mirrored on.
    """
    fan, origin, direction, travelled_m, strength = rays
    surfaces, first = Surfaces(*surfaces), FirstReturns(*first)
    n = fan.size
    mirrored = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        if surface[i] < 0:
            continue
        travelled_m[i] += leg_m[i]
        strength[i] *= surfaces.reflectivity[surface[i]]
        if strength[i] < threshold:
            continue
        cos = -(direction[i, 0] * normal[i, 0] + direction[i, 1] * normal[i, 1])
        k = fan[i]
        if cos < surfaces.critical_cos[surface[i]]:
            mirrored[count] = i
            count += 1
        elif travelled_m[i] < first.range_m[k] or (
            # An echo from exactly the maximum range is one.
            first.surface[k] < 0 and travelled_m[i] == first.range_m[k]
        ):
            first.range_m[k], first.surface[k] = travelled_m[i], surface[i]
            first.incidence_rad[k] = math.acos(min(cos, 1.0))
            first.bounces[k] = bounce

    on = np.empty(count, np.int64)
    m = 0
    for k in range(count):
        i = mirrored[k]
        if travelled_m[i] + OFF_SURFACE_M < first.range_m[fan[i]]:
            on[m] = i
            m += 1
            for axis in range(2):
                origin[i, axis] += leg_m[i] * direction[i, axis] + OFF_SURFACE_M * normal[i, axis]
            along = direction[i, 0] * normal[i, 0] + direction[i, 1] * normal[i, 1]
            for axis in range(2):
                direction[i, axis] -= 2 * along * normal[i, axis]
    on = on[:m]
    return fan[on], origin[on], direction[on], travelled_m[on], strength[on]


@njit()
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


@njit()
def all_measured(echo_m, surface, roughness_m, noise, noise_std_m, scale, quantum_m, near_m, far_m):
    """Return what k sonars read of echoes at ranges, +inf for none; see `measured`.

    Parameters
    ----------
    echo_m, surface, noise : ndarray, shape (k,)
        Of each sonar: range of the echo, the surface that sends it, a standard normal number.
    roughness_m : ndarray, shape (surfaces,)
        Of each surface.
    noise_std_m, scale, quantum_m, near_m, far_m : float
        See `measured`.
    """
    reading_m = np.empty(echo_m.size)
    for k in range(echo_m.size):
        reading_m[k] = measured(
            echo_m[k],
            roughness_m[surface[k]] if surface[k] >= 0 else 0.0,
            noise[k],
            noise_std_m,
            scale,
            quantum_m,
            near_m,
            far_m,
            math.inf,
        )
    return reading_m
