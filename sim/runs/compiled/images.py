"""The compiled drive with physical sonars that listen by image sources."""

from __future__ import annotations

import numpy as np

from sim.runs.compiled.moving import decide_speeds, go_through
from sim.sonar.physical import columns as t
from sim.sonar.physical.images.scan import listen_images
from sonarmap.kernels.jit import njit

__all__ = ["run"]


@njit(error_model="numpy")
def run(robot, controls, images, noise, sounds, first_scan, end_scan, recorded):
    """Drive, listen and record for some scans; other threads go on meanwhile.

    Parameters
    ----------
    robot : Robot
        Changed, so that the next call goes on.
    controls : Controls
    images : ImageSetup
    noise : ndarray, shape (firings,)
        Standard normal numbers.
    sounds : ndarray, shape (m, SOUND_COLUMNS)
        Those that are under way.
    first_scan, end_scan : int
        From which scan on, and the one after the last.
    recorded : Recorded
        Written.

    Returns
    -------
    ndarray, shape (m, SOUND_COLUMNS)
        The sounds that are under way now.
    """
    schedule, sonars = robot.schedule, len(robot.mounts)
    most = np.diff(schedule.first_ping).max()
    places, axes = np.empty((most, sonars, 2)), np.empty((most, sonars))
    for scan in range(first_scan, end_scan):
        go_through(robot, scan, places, axes, recorded)
        ping, end_ping = schedule.first_ping[scan], schedule.first_ping[scan + 1]
        start = schedule.first_firing[ping : end_ping + 1]
        first, end = start[0], start[-1]
        if first < end:  # else it is a scan in which nothing fires
            count = end_ping - ping
            reading_m, fired, detections, sounds = listen_images(
                images, schedule.time_s[ping:end_ping], schedule.sonar[first:end], start - first,
                places[:count], axes[:count], sounds, noise[first:end],
            )  # fmt: skip
            recorded.range_m[first:end] = reading_m
            recorded.axis_range_m[first:end] = fired[:, t.FIRED_AXIS]
            recorded.cone_range_m[first:end] = fired[:, t.FIRED_CONE]
            recorded.incidence_rad[first:end] = detections.incidence_rad
            recorded.level_db[first:end] = detections.level_db
            recorded.cause[first:end] = detections.cause
            recorded.surface[first:end] = detections.surface
            recorded.bounces[first:end] = detections.bounces
            recorded.source[first:end] = detections.source
        decide_speeds(robot, controls, scan, recorded)
    return sounds
