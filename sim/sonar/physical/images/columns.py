"""Columns of the tables that the compiled image sources pass on.

Passing an array on costs its count of references, so what is asked for often lies in few tables.
"""

from __future__ import annotations

# Segments: ends, normal, side of the outside (1 that of the normal, -1 the other, 0 unknown), level
# of the mirror and of the scattering, surface; where the list of what stands before it begins, its
# points begin and it ends; where the stops on the side of its normal begin, those on the other side
# begin and these end.
X0, Y0, X1, Y1, NORMAL_X, NORMAL_Y, OUTWARD, MIRROR, FLOOR, SURFACE = range(10)
FIRST, FIRST_POINT, LAST, FIRST_STOP, MIDDLE_STOP, LAST_STOP, FACE_COLUMNS = range(10, 17)
# Pillars and vertices: place, radius or 0, levels and surface of a pillar, where the arms of a
# vertex begin and end, whether it can be a right-angled corner (1) or an edge only (0).
POINT_X, POINT_Y, RADIUS, POINT_MIRROR, POINT_FLOOR, POINT_SURFACE = range(6)
FIRST_ARM, LAST_ARM, IS_CORNER, POINT_COLUMNS = range(6, 10)
# Arms of vertices: unit vector away from it, the segment, how far it goes on seen from its left and
# from its right.
ARM_X, ARM_Y, ARM_FACE, ARM_LEFT, ARM_RIGHT, ARM_COLUMNS = range(6)
# Stops of segments: how far from the begin, whether it limits what lies before it (1) or what lies
# behind it (-1), how high over the segment the face stands that stops it.
STOP_AT, STOP_SIDE, STOP_DEPTH, STOP_COLUMNS = range(4)
# Images: place, the axis as it looks from there, sign of bearings, sum of the transducer's
# sensitivity and the one-way losses of its mirrors; the window through which it looks: directions
# of its right and left end, its normal towards what is before it, a point of it, its segment or
# -1; the next mirror to be tried.
IMAGE_X, IMAGE_Y, AXIS_X, AXIS_Y, SIGN, LOSS, RIGHT_X, RIGHT_Y, LEFT_X, LEFT_Y = range(10)
WINDOW_X, WINDOW_Y, ON_X, ON_Y, FACE, NEXT, IMAGE_COLUMNS = range(10, 17)
# Echoes: when they cross the threshold, path, level, surface, incidence, over how many mirrors;
# the place that turns them and whether they come back straight from there.
CROSSING, PATH, LEVEL, ECHO_SURFACE, INCIDENCE, BOUNCES, AT_X, AT_Y, IS_STRAIGHT = range(9)
ECHO_COLUMNS = 9
