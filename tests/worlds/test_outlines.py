import math

import pytest
from shapely import Polygon
from shapely import box as rectangle

from sonarmap import InputError
from worlds.outlines import box_outline, pillar_outline, wall_outline

SQUARE = [(0, 0), (4, 0), (4, 3), (0, 3)]  # counter-clockwise
BEND = [(0, 0), (2, 0), (2, 2)]


def wall(points, side="centre", *, closed=False, thickness_m=0.2):
    return wall_outline(points, closed=closed, thickness_m=thickness_m, side=side)


@pytest.mark.parametrize(
    ("side", "outline"),
    [
        ("centre", rectangle(0, -0.1, 2, 0.1)),
        ("left", rectangle(0, 0, 2, 0.2)),
        ("right", rectangle(0, -0.2, 2, 0)),
    ],
)
def test_a_wall_lies_on_the_named_side_of_its_line(side, outline):
    assert wall([(0, 0), (2, 0)], side).equals(outline)


@pytest.mark.parametrize(
    ("side", "outline"),
    [
        ("left", [(0, 0), (2, 0), (2, 2), (1.8, 2), (1.8, 0.2), (0, 0.2)]),
        ("right", [(0, 0), (2, 0), (2, 2), (2.2, 2), (2.2, -0.2), (0, -0.2)]),
        ("centre", [(0, -0.1), (2.1, -0.1), (2.1, 2), (1.9, 2), (1.9, 0.1), (0, 0.1)]),
    ],
)
def test_corners_are_drawn_out_to_a_point_and_ends_are_flat(side, outline):
    assert wall(BEND, side).symmetric_difference(Polygon(outline)).area < 1e-12


@pytest.mark.parametrize(
    ("side", "outer", "inner"),
    [
        ("right", rectangle(-0.2, -0.2, 4.2, 3.2), rectangle(0, 0, 4, 3)),
        ("left", rectangle(0, 0, 4, 3), rectangle(0.2, 0.2, 3.8, 2.8)),
        ("centre", rectangle(-0.1, -0.1, 4.1, 3.1), rectangle(0.1, 0.1, 3.9, 2.9)),
    ],
)
def test_a_closed_wall_is_a_ring(side, outer, inner):
    ring = wall(SQUARE, side, closed=True)
    assert ring.symmetric_difference(outer.difference(inner)).area < 1e-12


def test_the_side_follows_the_direction_in_which_a_closed_wall_is_drawn():
    outwards = wall(SQUARE, "right", closed=True)
    assert wall(SQUARE[::-1], "left", closed=True).equals(outwards)


def test_the_drawn_line_of_a_one_sided_wall_is_its_face_to_the_last_bit():
    thirds = [(0.1, 1 / 3), (2 / 3, 1 / 3), (2 / 3, 2.2)]
    for side in ("left", "right"):
        assert set(thirds) <= set(wall(thirds, side).exterior.coords)
        ring = wall(thirds, side, closed=True)
        coords = {*ring.exterior.coords, *ring.interiors[0].coords}
        assert set(thirds) <= coords


def test_a_horseshoe_whose_mouth_closes_keeps_its_holes():
    horseshoe = [(0, 0), (5, 0), (5, 4), (2.6, 4), (2.6, 3), (4, 3), (4, 1)]
    horseshoe += [(1, 1), (1, 3), (2.4, 3), (2.4, 4), (0, 4)]
    ring = wall(horseshoe, "right", closed=True, thickness_m=0.15)
    assert len(ring.interiors) == 2
    assert ring.is_valid


@pytest.mark.parametrize(
    ("points", "closed", "rule"),
    [
        ([(0, 0)], False, "a wall needs at least 2 points, got 1"),
        ([(0, 0), (1, 0)], True, "a closed wall needs at least 3 points, got 2"),
        ([(0, 0), (1, 0), (1, 0)], False, r"zero length: points 1 and 2 are both \[1, 0\]"),
        ([*SQUARE, (0, 0)], True, r"zero length: points 4 and 0 are both \[0, 0\]"),
        ([(0, 0), (2, 2), (2, 0), (0, 2)], False, r"the wall crosses itself at \[1, 1\]"),
        ([(0, 0), (2, 2), (2, 0), (0, 2)], True, r"the wall crosses itself at \[1, 1\]"),
        ([(0, 0), (2, 0), (1, 0)], False, "the wall crosses itself"),
        ([(0, 0), (0.1, 0), (0.1, 0.1)], True, "a wall 0.2 m thick cannot follow this line"),
    ],
)
def test_impossible_lines_are_refused(points, closed, rule):
    with pytest.raises(InputError, match=rule):
        wall(points, closed=closed)


def test_a_box_has_its_length_along_its_heading():
    turned = box_outline((1, 1), length_m=2, width_m=0.5, heading_rad=math.pi / 2)
    assert turned.equals(rectangle(0.75, 0, 1.25, 2))
    tilted = box_outline((0, 0), length_m=2, width_m=1, heading_rad=math.radians(30))
    nose = tilted.exterior.coords[1:3]
    middle = [sum(c) / 2 for c in zip(*nose, strict=True)]
    assert middle == pytest.approx([math.cos(math.radians(30)), 0.5])


@pytest.mark.parametrize("turns", range(-4, 5))
def test_right_angles_are_exact(turns):
    outline = box_outline((0, 0), length_m=2, width_m=1, heading_rad=turns * math.pi / 2)
    half = (0.5, 1.0) if turns % 2 else (1.0, 0.5)
    assert outline.bounds == (-half[0], -half[1], *half)


def test_the_outline_of_a_pillar_stays_within_its_circle():
    outline = pillar_outline((1, 2), radius_m=0.5)
    assert outline.bounds == (0.5, 1.5, 1.5, 2.5)
    assert math.pi * 0.25 * 0.999 < outline.area < math.pi * 0.25
