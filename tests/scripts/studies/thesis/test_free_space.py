import math

import numpy as np
import pytest
from rooms import box, world
from support import make_log

from sonarbed.studies.thesis.free_space import FreeSpace, plotted_points, score_points


def room():
    """A closed room of 2 m by 1 m with its lower-left corner in the origin."""
    return world(
        box("south", -0.1, -0.1, 2.1, 0.0),
        box("north", -0.1, 1.0, 2.1, 1.1),
        box("west", -0.1, 0.0, 0.0, 1.0),
        box("east", 2.0, 0.0, 2.1, 1.0),
        start=(1.0, 0.5, 0.0),
    )


def test_distances_are_to_the_inner_faces():
    space = FreeSpace.of(room())
    assert space.polygon.area == pytest.approx(2.0)
    # In the middle, before the east wall, and behind it beyond its outer face.
    distances = space.distance_m(np.array([[1.0, 0.5], [1.9, 0.5], [2.2, 0.5]]))
    assert distances == pytest.approx([0.5, 0.1, 0.2])


def test_corners_are_where_walls_meet_and_not_where_they_abut():
    corners = {tuple(xy) for xy in FreeSpace.of(room()).corners_xy_m.round(6).tolist()}
    assert corners == {(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)}


def test_no_echo_is_plotted_at_five_metres_and_too_close_not_at_all():
    log = make_log([1.0, np.inf, -np.inf], heading_rad=math.pi / 2)
    assert plotted_points(log) == pytest.approx(np.array([[0.0, 1.0], [0.0, 5.0]]))


def test_points_are_near_beyond_or_before_a_surface():
    space = FreeSpace.of(room())
    points = np.array([[1.95, 0.5], [2.05, 0.5], [1.5, 0.5], [4.0, 0.5]])
    shares = score_points(points, space, np.array([[2.02, 0.5], [-0.02, 0.5]]))
    assert (shares.near, shares.beyond, shares.shown) == (0.5, 0.25, 0.5)
    assert shares.f1 == 0.5
