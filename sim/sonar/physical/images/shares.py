"""Compiled: what the sizes of faces leave of a sound that they turn or pass on."""

from __future__ import annotations

import math

from sim.sonar.physical.fresnel import strip_share
from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.extents import extent
from sonarmap.kernels.jit import njit

__all__ = ["corner_share", "face_share", "mirrors_share"]

# Of the way from an image to its mirror.
_LEAST_M = 1e-3


@njit(error_model="numpy", makes_arrays=False)
def face_share(faces, stops, acoustics, i, height, foot_m, at_m, cos, one_m, other_m):
    """Return the power that a face turns at a place against that of a large one.

    Parameters
    ----------
    i, height, foot_m, at_m
        See `sim.sonar.physical.images.extents.extent`.
    cos : float
        Cosine of the angle of incidence.
    one_m, other_m : float
        How far the sound goes before and after the face.
    """
    low_m, high_m = extent(faces, stops, i, height, foot_m, at_m)
    return strip_share(acoustics, low_m, high_m, cos, one_m, other_m)


@njit(error_model="numpy", makes_arrays=False)
def corner_share(arms, acoustics, right, right_rad, left, left_rad, half_m):
    """Return the power of a right-angled corner against that of a large one.

    What meets the one face within its reach leaves by the other, as far off the vertex.
    """
    width_m = min(
        arms[right, c.ARM_LEFT] * math.sin(right_rad), arms[left, c.ARM_RIGHT] * math.sin(left_rad)
    )
    return strip_share(acoustics, -width_m, width_m, 1.0, half_m, half_m)


@njit(error_model="numpy", makes_arrays=False)
def mirrors_share(faces, stops, acoustics, stack, level, x, y, path_m):
    """Return the power that the mirrors of an image let pass on a way to a place, each once.

    Small mirrors take away; what they may add is left out.

    Parameters
    ----------
    path_m : float
        Length of the whole path, beyond the place, too.
    """
    share = 1.0
    for leg in range(level, 0, -1):
        ix, iy = stack[leg, c.IMAGE_X], stack[leg, c.IMAGE_Y]
        mx, my = stack[leg, c.ON_X], stack[leg, c.ON_Y]
        nx, ny = stack[leg, c.WINDOW_X], stack[leg, c.WINDOW_Y]
        behind = (ix - mx) * nx + (iy - my) * ny
        part = behind / (behind - (x - mx) * nx - (y - my) * ny)
        x, y = ix + part * (x - ix), iy + part * (y - iy)
        i = int(stack[leg, c.FACE])
        # The window's normal looks away from who is behind: on the side of the one before.
        height = -behind if nx * faces[i, c.NORMAL_X] + ny * faces[i, c.NORMAL_Y] > 0 else behind
        ex, ey = faces[i, c.X1] - mx, faces[i, c.Y1] - my
        length_m = math.sqrt(ex * ex + ey * ey)
        at_m = ((x - mx) * ex + (y - my) * ey) / length_m
        foot_m = ((ix - mx) * ex + (iy - my) * ey) / length_m
        one_m = max(math.hypot(x - ix, y - iy), _LEAST_M)
        cos = min(abs(height) / one_m, 1.0)
        one = face_share(
            faces, stops, acoustics, i, height, foot_m, at_m, cos, one_m, path_m - one_m
        )
        share *= min(1.0, one)
    return share
