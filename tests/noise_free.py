"""Noise-free readings of drawn walls, for methods that must explain them: no simulator needed."""

import math

import numpy as np

import sonarmap as sm


def nearest_in_cone(points, x, y, axis, half_angle):
    """Range of the nearest of the points (n, 2) that lies in a cone; inf for none."""
    dx, dy = points[:, 0] - x, points[:, 1] - y
    off = np.abs((np.arctan2(dy, dx) - axis + math.pi) % (2 * math.pi) - math.pi)
    inside = off <= half_angle
    return float(np.hypot(dx, dy)[inside].min()) if inside.any() else math.inf


def wall(x0, y0, x1, y1, step=0.002):
    """Points of a straight wall, two millimetres apart."""
    n = int(math.hypot(x1 - x0, y1 - y0) / step) + 1
    return np.column_stack([np.linspace(x0, x1, n), np.linspace(y0, y1, n)])


def drive(ring, poses, points):
    """The log of a ring whose every sonar fires at each pose, and hears the nearest point."""
    rows = [(scan, sonar, *pose) for scan, pose in enumerate(poses) for sonar in range(len(ring))]
    scan, sonar, x, y, heading = (np.array(values) for values in zip(*rows, strict=True))
    log = sm.SonarLog(ring, scan, sonar, scan, x, y, heading, np.zeros(scan.size))
    range_m = [
        nearest_in_cone(points, *place, axis, ring.half_angle_rad)
        for place, axis in zip(log.sensor_xy_m, log.axis_rad, strict=True)
    ]
    range_m = np.array(range_m)
    return log.replace(range_m=np.where(range_m <= ring.range_max_m, range_m, math.inf))


# One sonar in the middle, wide as a Polaroid's lobe.
WIDE = sm.SonarRing("wide", [0], [0], [0], math.radians(15), 0.1, 4.0)


def door():
    """Two wide cones through one door: all that is known of a door of 0.6 m in a wall at x = 2.

    From afar the cones hear the jambs, and their arcs close the door. From near, narrow enough,
    they see through it up to the wall at x = 3.5 behind.
    """
    points = np.concatenate(
        [wall(2, -2, 2, -0.3), wall(2, 0.3, 2, 2), wall(3.5, -2, 3.5, 2)],
    )
    far = [(x, y, 0.0) for x in (0.2, 0.4, 0.6) for y in (-0.1, 0.0, 0.1)]
    near = [(x, y, 0.0) for x in (1.2, 1.3, 1.4) for y in (-0.05, -0.02, 0.02, 0.05)]
    beside = [(x, y, 0.0) for x in (0.6, 1.2) for y in np.arange(0.8, 1.6, 0.05)]
    beside += [(x, -y, 0.0) for x, y, _ in beside]
    log = drive(WIDE, [*far, *near, *beside], points)
    return log, sm.GridSpec(0.05, (-0.5, -2.0), (80, 90))


def door_cells(grid):
    """Rows of the door's middle, and columns of the wall it is in."""
    rows = [grid.cell_of(0, y)[0] for y in (-0.15, 0.15)]
    cols = [grid.cell_of(x, 0)[1] for x in (1.9, 2.1)]
    return slice(rows[0], rows[1]), slice(cols[0], cols[1])
