"""Compiled: one scan of a physical sonar by image sources, from firings to readings."""

from __future__ import annotations

import math

import numpy as np

from sim.sonar.physical import columns as t
from sim.sonar.physical.detection import detect, readings
from sim.sonar.physical.fresnel import FOCUS_DB
from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.crosstalk import find_crosstalk
from sim.sonar.physical.images.echoes import (
    far_left_m,
    find_of_faces,
    find_of_points,
    has_late,
    is_free,
    take_first,
)
from sim.sonar.physical.images.paths import blocked_at, is_leg_free, next_image, set_transducer
from sim.sonar.physical.images.scatter import find_scatter
from sim.sonar.physical.images.truth import true_ranges
from sim.sonar.physical.levels import loudest_other_db, widest_rad
from sonarmap.kernels.jit import njit

__all__ = ["listen_images"]


@njit(error_model="numpy")
def listen_images(setup, times_s, sonars, start, xy, axis, sounds, draws):
    """Return (readings, firings, detections, the sounds that later firings may still detect).

    Parameters
    ----------
    setup : ImageSetup
    times_s : ndarray, shape (p,)
        When sonars fired together, p times.
    sonars, start : ndarray of int, shapes (n,), (p + 1,)
        Which fired, and where those of each time begin.
    xy, axis : ndarray, shapes (p, ring, 2), (p, ring)
        All transducers at these times.
    sounds : ndarray, shape (m, SOUND_COLUMNS)
        Those that are under way.
    draws : ndarray, shape (n,)
        Of the normal distribution.
    """
    scene, surfaces, acoustics, limits, monostatic, transducers, reading = setup
    gain_db, lean_rad = transducers
    fired = np.empty((len(sonars), t.FIRED_COLUMNS))
    stack = np.empty((limits.max_bounces + 1, c.IMAGE_COLUMNS))
    # Of one image no face has more than two echoes, no point more than one; and the best.
    most = 2 * len(scene.faces) + len(scene.points) + 1
    echoes = np.empty((max(most, axis.shape[1]), c.ECHO_COLUMNS))
    until_m = np.empty(axis.shape[1])
    count = len(sounds)
    beam_rad = axis + lean_rad
    for p in range(len(times_s)):
        until_m[:] = math.inf
        for k in range(start[p], start[p + 1]):
            fired[k, t.FIRED_TIME], fired[k, t.FIRED_SONAR] = times_s[p], sonars[k]
            sounds, count = _own_sounds(
                scene, acoustics, limits, gain_db, fired, k, sonars[k], xy[p], axis[p], beam_rad[p],
                stack, echoes, until_m, sounds, count,
            )  # fmt: skip
        if not monostatic and axis.shape[1] > 1:
            for k in range(start[p], start[p + 1]):
                sounds, count = _others_sounds(
                    scene, acoustics, limits, gain_db, times_s[p], sonars[k], xy[p],
                    beam_rad[p], stack, echoes, until_m, sounds, count,
                )  # fmt: skip
    detections, sounds = detect(fired, sounds[:count], acoustics)
    reading_m = readings(detections, draws, surfaces, reading)
    return reading_m, fired, detections, sounds


@njit(error_model="numpy")
def _own_sounds(
    scene, acoustics, limits, gain_db, fired, k, sonar, xy, axes, beams_rad, stack, echoes, until_m,
    sounds, count,
):  # fmt: skip
    """Set true ranges; add what a sonar detects first of its own sound, and what comes late."""
    faces, points, arms, stops, before, is_listed, rays = scene
    sent_s, x, y, axis = fired[k, t.FIRED_TIME], xy[sonar, 0], xy[sonar, 1], axes[sonar]
    fired[k, t.FIRED_AXIS], fired[k, t.FIRED_CONE] = true_ranges(
        faces, points, rays, limits.range_max_m, limits.cone_rad, x, y, axis
    )
    echoes[0, c.CROSSING], echoes[0, c.BOUNCES] = acoustics.window_s, -1.0
    axis = beams_rad[sonar]
    set_transducer(stack, limits.wide_rad, x, y, axis, gain_db[sonar])
    level = 0
    while level >= 0:
        if stack[level, c.NEXT] == 0:
            found = find_of_faces(
                faces, stops, before, is_listed, acoustics, limits, x, y, axis, stack, level, echoes
            )
            sounds, count = _settled(
                rays, limits, sent_s, sonar, x, y, stack, level, echoes, found, sounds, count
            )
            found = find_of_points(
                faces, points, arms, stops, before, is_listed, acoustics, limits, stack, level,
                echoes,
            )  # fmt: skip
            sounds, count = _settled(
                rays, limits, sent_s, sonar, x, y, stack, level, echoes, found, sounds, count
            )
            find_scatter(faces, before, is_listed, rays, acoustics, limits, stack, level, echoes)
            stack[level, c.NEXT] = 0
        far_m = far_left_m(acoustics, limits, echoes)
        if level < limits.max_bounces and next_image(
            faces, before, is_listed, rays, acoustics, stack, level, far_m, 0.0, 0.0, 0.0
        ):
            level += 1
        else:
            level -= 1
    if echoes[0, c.BOUNCES] >= 0:
        until_m[sonar] = echoes[0, c.CROSSING] * acoustics.speed_mps
        sounds, count = _with_sound(
            sounds, count, sent_s, sonar, sonar, echoes, 0, int(echoes[0, c.BOUNCES])
        )
    return sounds, count


@njit(error_model="numpy")
def _settled(rays, limits, sent_s, sonar, x, y, stack, level, echoes, found, sounds, count):
    """Let the first free echo that was found be the best; add those that the next firing hears."""
    if found > 1:
        found = take_first(rays, stack, level, x, y, echoes, found)
    if limits.is_late:
        for e in range(1, found):
            if has_late(limits, echoes[e, c.PATH]) and is_free(rays, stack, level, x, y, echoes, e):
                sounds, count = _with_sound(sounds, count, sent_s, sonar, sonar, echoes, e, level)
    return sounds, count


@njit(error_model="numpy")
def _others_sounds(
    scene, acoustics, limits, gain_db, sent_s, sonar, xy, axes, stack, found, until_m, sounds, count
):
    """Add the sounds of a sonar that the others may detect."""
    faces, _, _, _, before, is_listed, rays = scene
    most_db = gain_db.max()
    # Only so far off the axis enough is sent for others, who listen on their axes at best.
    sent_db = loudest_other_db(acoustics, limits.least_cross_path_m) + FOCUS_DB
    wide_rad = widest_rad(acoustics, 2 * (sent_db + gain_db[sonar] + most_db))
    set_transducer(
        stack, min(limits.wide_rad, wide_rad), xy[sonar, 0], xy[sonar, 1], axes[sonar],
        gain_db[sonar],
    )  # fmt: skip
    # The listeners lie in a circle about the sonar.
    spread_m = 0.0
    for k in range(len(axes)):
        dx, dy = xy[k, 0] - xy[sonar, 0], xy[k, 1] - xy[sonar, 1]
        spread_m = max(spread_m, math.sqrt(dx * dx + dy * dy))
    level = 0
    while level >= 0:
        if stack[level, c.NEXT] == 0:
            looked, paths = 0, 1
            while paths > 0:
                looked, paths = find_crosstalk(
                    scene, acoustics, limits, stack, level, sonar, xy, axes, gain_db, until_m,
                    spread_m, most_db, looked, found,
                )  # fmt: skip
                for e in range(paths):
                    listener = int(found[e, c.IS_STRAIGHT])
                    px, py = found[e, c.AT_X], found[e, c.AT_Y]
                    if is_leg_free(rays, xy[listener, 0], xy[listener, 1], px, py) and (
                        blocked_at(rays, stack, level, px, py)[0] < 0
                    ):
                        sounds, count = _with_sound(
                            sounds, count, sent_s, sonar, listener, found, e, level
                        )
        if level < limits.max_bounces and next_image(
            faces, before, is_listed, rays, acoustics, stack, level, 0.0,
            limits.least_cross_path_m, limits.reach_m, most_db,
        ):  # fmt: skip
            level += 1
        else:
            level -= 1
    return sounds, count


@njit(error_model="numpy")
def _with_sound(sounds, count, sent_s, source, listener, echoes, k, bounces):
    """Add an echo to the sounds that are under way; return (sounds, how many there are now)."""
    if count == len(sounds):
        more = np.empty((2 * count + 16, t.SOUND_COLUMNS))
        more[:count] = sounds
        sounds = more
    sounds[count, t.SOUND_SENT], sounds[count, t.SOUND_SOURCE] = sent_s, source
    sounds[count, t.SOUND_LISTENER], sounds[count, t.SOUND_PATH] = listener, echoes[k, c.PATH]
    sounds[count, t.SOUND_LEVEL] = echoes[k, c.LEVEL]
    sounds[count, t.SOUND_SURFACE] = echoes[k, c.ECHO_SURFACE]
    sounds[count, t.SOUND_INCIDENCE] = echoes[k, c.INCIDENCE]
    sounds[count, t.SOUND_BOUNCES] = bounces
    return sounds, count + 1
