"""Small worlds for tests of the simulator, built from boxes and pillars by hand."""

from __future__ import annotations

import math

import shapely

from worlds import Material, Pose, Solid, World

# Sends every sound straight back, mirrors whatever does not come almost head-on, and swallows.
ROUGH = Material("rough", math.pi / 2, 1.0, 0.0)
MIRROR = Material("mirror", math.radians(10), 1.0, 0.0)
SOFT = Material("soft", math.pi / 2, 0.1, 0.0)


def box(name, x_min, y_min, x_max, y_max, material=ROUGH, *, turned_deg=0.0, about=(0.0, 0.0)):
    outline = shapely.box(x_min, y_min, x_max, y_max)
    turned = shapely.affinity.rotate(outline, turned_deg, origin=about)
    return Solid(name, material, 1.0, turned)


def pillar(name, x_m, y_m, radius_m, material=ROUGH):
    outline = shapely.Point(x_m, y_m).buffer(radius_m, quad_segs=32)
    return Solid(name, material, 1.0, outline, (x_m, y_m, radius_m))


def world(*solids, start=(0.0, 0.0, 0.0), name="test"):
    return World(
        name=name,
        title="a room for a test",
        source="made by hand",
        bounds_m=(-5.0, -5.0, 5.0, 5.0),
        start=Pose(*start),
        route_m=(),
        solids=solids,
        notes={},
        parameters={},
    )


def closed_room(half_m=1.5, material=ROUGH, **arguments):
    """Return a square room about the origin with inner faces `half_m` away."""
    far = half_m + 0.1
    return world(
        box("east", half_m, -far, far, far, material),
        box("north", -half_m, half_m, half_m, far, material),
        box("west", -far, -far, -half_m, far, material),
        box("south", -half_m, -far, half_m, -half_m, material),
        **arguments,
    )
