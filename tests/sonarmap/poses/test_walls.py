"""Walls that echoes agree on, in a room whose walls are known."""

import dataclasses
import math

import numpy as np
import pytest
from drives import HALF_M

from sonarmap.poses.walls import Echoes, attributed, find_walls

ROOM = {0: HALF_M[0], 90: HALF_M[1], 180: HALF_M[0], 270: HALF_M[1]}


@pytest.fixture(scope="module")
def echoes(drive):
    true, log = drive
    heard = np.isfinite(log.range_m)
    x, y, heading = np.repeat(true, len(log.ring), axis=0)[heard].T
    sonar = log.sonar[heard]
    return Echoes(
        log.ring.sensor_xy_m(sonar, x, y, heading),
        heading + log.ring.heading_rad[sonar],
        log.range_m[heard],
        np.ones(heard.sum()),
        log.ring.half_angle_rad,
    )


def test_the_walls_of_the_room_come_first_and_where_they_are(echoes):
    found = find_walls(echoes, 0.03)
    first = {round(math.degrees(normal)) % 360: away for normal, away in found[:4]}
    assert first == pytest.approx(ROOM, abs=0.02)


def test_no_echo_no_wall(echoes):
    none = Echoes(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0), 0.2)
    assert find_walls(none, 0.05).shape == (0, 2)
    few = dataclasses.replace(
        echoes,
        **{
            name: getattr(echoes, name)[:4] for name in ("place_m", "axis_rad", "range_m", "weight")
        },
    )
    assert find_walls(few, 0.05).shape == (0, 2)


def test_echoes_go_to_the_wall_they_came_from(echoes):
    walls = np.array([(math.radians(normal), away) for normal, away in ROOM.items()])
    rows, wall = attributed(echoes, walls, 0.02)
    assert len(rows) > 0.97 * len(echoes.range_m)
    away = np.abs(echoes.distance_m(walls[:, 0]) - walls[:, 1])
    away[~echoes.in_cone(walls[:, 0])] = np.inf
    assert (wall == np.argmin(away[rows], axis=1)).mean() > 0.99


def test_a_wall_that_few_echoes_happen_to_agree_with_gets_none(echoes, rng):
    # Walls of no room: whatever lies on them does so by chance, and along all of their length.
    walls = np.array([(math.radians(normal), away) for normal, away in ROOM.items()])
    oblique = np.column_stack([rng.uniform(0, math.tau, 12), rng.uniform(0.5, 2.5, 12)])
    _, wall = attributed(echoes, np.concatenate([walls, oblique]), 0.02)
    assert (wall >= 4).mean() < 0.03


def test_a_thousand_echoes_of_no_weight_are_no_wall(echoes):
    weightless = dataclasses.replace(echoes, weight=np.full(len(echoes.weight), 1e-4))
    assert len(find_walls(weightless, 0.05)) == 0
