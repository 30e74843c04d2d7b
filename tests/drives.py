"""A drive in a rectangular room, echoes by arithmetic: each from the foot of a perpendicular."""

import math

import numpy as np

import sonarmap as sm

HALF_M = (3.0, 2.0)
CORNERS_M = ((1.5, 0.8), (-1.6, 0.9), (-1.4, -0.9), (1.6, -0.7))
STEP_M, TURN_RAD = 0.04, 0.08


def way(laps):
    """Return true poses (n, 3) along a quadrangle, turning on the spot at its corners."""
    poses = []
    heading = 0.0
    for start, end in zip((CORNERS_M * laps)[:-1], (CORNERS_M * laps)[1:], strict=True):
        along = math.atan2(end[1] - start[1], end[0] - start[0])
        turn = (along - heading + math.pi) % math.tau - math.pi
        steps = max(1, round(abs(turn) / TURN_RAD))
        poses += [(*start, heading + turn * k / steps) for k in range(steps)]
        heading += turn
        steps = round(math.dist(start, end) / STEP_M)
        poses += [
            (*(np.array(start) + (np.array(end) - start) * k / steps), heading)
            for k in range(steps)
        ]
    return np.array(poses)


def heard(place, axis_rad, half_angle_rad):
    """Return the range of the nearest wall whose perpendicular lies in the cone, or inf."""
    nearest = math.inf
    for normal, room_m in ((0, HALF_M[0]), (90, HALF_M[1]), (180, HALF_M[0]), (270, HALF_M[1])):
        normal_rad = math.radians(normal)
        off = (normal_rad - axis_rad + math.pi) % math.tau - math.pi
        if abs(off) <= half_angle_rad:
            away = room_m - place[0] * math.cos(normal_rad) - place[1] * math.sin(normal_rad)
            nearest = min(nearest, away)
    return nearest


def by_odometry(true, rng, *, scale=1.0, turn=1.0, slip=0.0):
    """Return the poses that an odometer with these errors tells of true ones."""
    step = np.diff(true, axis=0, prepend=true[:1])
    turned = (step[:, 2] + math.pi) % math.tau - math.pi
    gone = np.hypot(step[:, 0], step[:, 1])
    wheels = gone + abs(turned) * 0.14
    heading = true[0, 2] + np.cumsum(
        turn * turned + slip * np.sqrt(wheels) * rng.normal(size=len(gone))
    )
    before = np.concatenate([heading[:1], heading[:-1]])
    forward = np.sign(step[:, 0] * np.cos(true[:, 2]) + step[:, 1] * np.sin(true[:, 2])) * gone
    middle = (heading + before) / 2
    x = true[0, 0] + scale * np.cumsum(forward * np.cos(middle))
    y = true[0, 1] + scale * np.cumsum(forward * np.sin(middle))
    return np.column_stack([x, y, heading])


def log_of(true, told, rng, *, noise_m=0.01, ring=sm.AMIGOBOT):
    """Return the log of a robot at true poses that believes to be elsewhere."""
    ranges = []
    for x, y, heading in true:
        for sonar in range(len(ring)):
            place = ring.sensor_xy_m(
                np.array([sonar]), np.array([x]), np.array([y]), np.array([heading])
            )[0]
            axis = heading + ring.heading_rad[sonar]
            ranges.append(heard(place, axis, ring.half_angle_rad))
    ranges = np.array(ranges)
    ranges = np.where(
        ranges < ring.range_max_m, ranges + noise_m * rng.normal(size=len(ranges)), np.inf
    )
    scans, sonars = np.divmod(np.arange(len(ranges)), len(ring))
    x, y, heading = np.repeat(told, len(ring), axis=0).T
    return sm.SonarLog(
        ring=ring,
        scan=scans,
        sonar=sonars,
        time_s=scans * 0.2,
        x_m=x,
        y_m=y,
        heading_rad=heading,
        range_m=ranges,
    )


def pose_errors(log, true):
    """Return root mean square errors of place, metres, and heading, radians."""
    x, y, heading = np.repeat(true, len(log.ring), axis=0).T
    return sm.pose_error(log, log.replace(x_m=x, y_m=y, heading_rad=heading))
