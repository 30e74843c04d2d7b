"""Compiled: how much of the sound a face turns or lets pass that is small for a Fresnel zone.

Across a face between two places, d1 and d2 away on the path, the sound of its parts adds up by
Fresnel's integrals (Born and Wolf, *Principles of Optics*, section 8.7). A mirror that is passed is
an opening in unfolded space, so one formula serves both. Heights are not looked at: solids are
taken to be tall.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import fresnel

from sim.sonar.physical.tables import FRESNEL
from sonarmap.kernels.jit import njit

__all__ = ["FOCUS_DB", "clearance_per_m", "fresnel_table", "strip_share"]

FOCUS_DB = 2.6
"""A face of the size of its first Fresnel zone answers louder than a large one, by so much."""
# What is so far from the path, as `clearance_per_m` counts, sends its sound when a pulse of 16
# cycles is over: 16 wavelengths later. Ripples fade out on the way there.
_FADES_FROM, _LAST, _PER_UNIT = 6.0, 8.0, 50
# Nothing is nearer to a face than this: the wave length would not be small any more.
_LEAST_M = 1e-3
# Edge-on a face has no width; so little keeps "farther than any" apart from that.
_LEAST_COS = 1e-9


def fresnel_table() -> NDArray[np.float64]:
    """Return Fresnel's integrals C and S, one row each 0.02, for `strip_share`."""
    u = np.arange(round(_LAST * _PER_UNIT) + 1) / _PER_UNIT
    sine, cosine = fresnel(u)
    fade = np.clip((_LAST - u) / (_LAST - _FADES_FROM), 0, 1)
    fade = fade * fade * (3 - 2 * fade)
    table: NDArray[np.float64] = 0.5 + (np.column_stack([cosine, sine]) - 0.5) * fade[:, None]
    return table


@njit(error_model="numpy", forceinline=True)
def clearance_per_m(wavelength_m, one_m, other_m):
    """Return what a distance across a path, metres, is multiplied with to be Fresnel's argument.

    The path goes on for `one_m` before and for `other_m` after the place.
    """
    return math.sqrt(2 * (one_m + other_m) / (wavelength_m * one_m * other_m))


@njit(error_model="numpy", makes_arrays=False)
def strip_share(acoustics, low_m, high_m, cos, one_m, other_m):
    """Return the power of a strip between two distances from a path against that of a large face.

    Parameters
    ----------
    low_m, high_m : float
        Along the face, from the place where the path meets it; infinite for far.
    cos : float
        Cosine of the angle of incidence.
    one_m, other_m : float
        How far the sound goes before and after the face.
    """
    per_m = max(cos, _LEAST_COS) * clearance_per_m(
        acoustics.wavelength_m, max(one_m, _LEAST_M), max(other_m, _LEAST_M)
    )
    return _seen_share(acoustics.tables, low_m * per_m, high_m * per_m)


@njit(error_model="numpy", forceinline=True)
def _seen_share(tables, low, high):
    """Return the power of a face between two Fresnel arguments against that of a large one.

    Parameters
    ----------
    tables : ndarray
        See `sim.sonar.physical.tables`.
    """
    if low <= -_LAST and high >= _LAST:
        return 1.0
    low_c, low_s = _integrals(tables, low)
    high_c, high_s = _integrals(tables, high)
    across, along = high_c - low_c, high_s - low_s
    return (across * across + along * along) / 2


@njit(error_model="numpy", forceinline=True)
def _integrals(tables, u):
    size = abs(u)
    if size >= _LAST:
        return math.copysign(0.5, u), math.copysign(0.5, u)
    place = size * _PER_UNIT
    k = int(place)
    rest = place - k
    k = FRESNEL + 2 * k
    cosine = tables[k] + rest * (tables[k + 2] - tables[k])
    sine = tables[k + 1] + rest * (tables[k + 3] - tables[k + 1])
    return math.copysign(cosine, u), math.copysign(sine, u)
