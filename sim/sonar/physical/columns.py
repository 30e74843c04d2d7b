"""Columns of the tables that the compiled steps of the physical sonar pass on."""

from __future__ import annotations

# Rays: begin of the leg, direction, how far it goes, bearing off the axis at departure, image of
# the transducer, path so far, sign of the bearings after mirroring, sum of the transducer's
# sensitivity and one-way mirror losses, last mirror's normal.
RAY_X, RAY_Y, RAY_DX, RAY_DY, RAY_REACH, RAY_THETA, RAY_IX, RAY_IY = range(8)
RAY_PATH, RAY_SIGN, RAY_LOSS, RAY_MX, RAY_MY, RAY_COLUMNS = range(8, 14)
# Whose fan a ray belongs to, the face that mirrored it last or -1, its number in the fan.
ID_SONAR, ID_MIRROR, ID_NUMBER, ID_COLUMNS = range(4)
# Faces, each a run of neighbouring rays on the same flat face or pillar: bearings between which it
# is seen, a point of it, its normal; of its first ray the image, bearing, direction, and the rest.
FACE_LOW, FACE_HIGH, FACE_X, FACE_Y, FACE_NX, FACE_NY, FACE_IX, FACE_IY = range(8)
FACE_THETA, FACE_ALONG, FACE_SIGN, FACE_LOSS, FACE_MX, FACE_MY, FACE_COLUMNS = range(8, 15)
# Who sees it, its surface, the face that mirrors it last or -1, over how many mirrors; what is at
# its lower and upper limit: the face that mirrors it on in a hollow corner, its end, or something
# that only hides how it goes on.
LINK_SONAR, LINK_SURFACE, LINK_MIRROR, LINK_MIRRORS, LINK_LOW, LINK_HIGH, LINK_COLUMNS = range(7)
ENDS, GOES_ON = -1, -2
# Right-angled hollow corners: the two faces, the vertex. Edges: the nearer face, the vertex.
CORNER_FACE, CORNER_OTHER, CORNER_X, CORNER_Y, CORNER_COLUMNS = range(5)
EDGE_FACE, EDGE_X, EDGE_Y, EDGE_COLUMNS = range(4)
# Ends of faces that are looked for: whether it is the upper limit (1) or the lower one (-1),
# bearings just on the face and just off it, length of the ray on the face.
END_FACE, END_SIDE, END_INSIDE, END_OUTSIDE, END_LENGTH, END_COLUMNS = range(6)
# What surfaces are like: radius of a pillar or 0, level of the mirror, of the scattering.
SURFACE_RADIUS, SURFACE_MIRROR, SURFACE_FLOOR, SURFACE_ROUGHNESS, SURFACE_COLUMNS = range(5)
# Sounds: when and by which sonar sent, by which one received, length of the path and level without
# time-varied gain, surface that turned it, angle of incidence there, mirrors on the path.
SOUND_SENT, SOUND_SOURCE, SOUND_LISTENER, SOUND_PATH, SOUND_LEVEL = range(5)
SOUND_SURFACE, SOUND_INCIDENCE, SOUND_BOUNCES, SOUND_COLUMNS = range(5, 9)
# Checks: a ray (begin, direction, reach as in `sim.sonar.physical.tracing`), the length at which
# it must meet something, and the sound whose path it is a part of.
CHECK_X, CHECK_Y, CHECK_DX, CHECK_DY, CHECK_REACH = range(5)
CHECK_LENGTH, CHECK_SOUND, CHECK_COLUMNS = range(5, 8)
# Firings: when, which sonar, its true ranges on the axis and in the cone.
FIRED_TIME, FIRED_SONAR, FIRED_AXIS, FIRED_CONE, FIRED_COLUMNS = range(5)
