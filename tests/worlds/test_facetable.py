"""The grid that speeds up rays changes nothing: what it finds, a look at every face finds too."""

import math

import numpy as np
import pytest
import shapely
from rooms import box, pillar, world

import worlds
from worlds.facetable import face_table
from worlds.raycast import cast_rays, clearance


def every_face(faces, origin, direction, reach):
    """The slow twin of the walk through the grid: (distance, surface) by looking at all faces."""
    best, found = math.inf, -1
    for (x0, y0, x1, y1), surface in zip(faces.segments_m, faces.segment_surface, strict=True):
        ray = np.column_stack([direction, [x0 - x1, y0 - y1]])
        if np.linalg.det(ray) == 0:
            continue
        distance, share = np.linalg.solve(ray, np.array([x0, y0]) - origin)
        if 1e-9 < distance <= reach and -1e-9 <= share <= 1 + 1e-9 and distance < best:
            best, found = distance, surface
    for (x, y, radius), surface in zip(faces.circles_m, faces.circle_surface, strict=True):
        along = (np.array([x, y]) - origin) @ direction
        half_chord_2 = radius**2 - ((np.array([x, y]) - origin) ** 2).sum() + along**2
        if half_chord_2 < 0:
            continue
        near, far = along - math.sqrt(half_chord_2), along + math.sqrt(half_chord_2)
        distance = near if near > 1e-9 else far
        if 1e-9 < distance <= reach and distance < best:
            best, found = distance, surface
    return best, found


@pytest.fixture
def crowd(rng):
    """A field of small boxes and pillars, some of them overlapping, in a hall."""
    things = []
    for k, (x, y) in enumerate(rng.uniform(-4, 4, (120, 2))):
        size = rng.uniform(0.05, 0.4)
        if k % 3:
            turn = rng.uniform(0, 90)
            things.append(box(f"box {k}", x, y, x + size, y + 0.3, turned_deg=turn, about=(x, y)))
        else:
            things.append(pillar(f"pillar {k}", x, y, size / 2))
    return world(box("wall", 4.5, -4.5, 4.6, 4.5), *things)


def rays(rng, n, spread_m):
    angle = rng.uniform(-math.pi, math.pi, n)
    return rng.uniform(-spread_m, spread_m, (n, 2)), np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("reach_m", [0.4, 3.0, math.inf])
def test_the_walk_finds_what_a_look_at_every_face_finds(crowd, rng, reach_m):
    # Some rays begin outside of all faces, some inside of a box or pillar.
    origins, directions = rays(rng, 300, 6.0)
    directions[:20] = [1, 0]
    directions[20:40] = [0, -1]
    hits = crowd.faces.cast(origins, directions, reach_m)
    for k in range(len(origins)):
        distance, surface = every_face(crowd.faces, origins[k], directions[k], reach_m)
        assert hits.distance_m[k] == pytest.approx(distance, abs=1e-9)
        assert hits.surface[k] == surface
    assert (hits.surface >= 0).sum() > 30


def test_rooms_of_one_table_do_not_meet(crowd, rng):
    others = [crowd.faces, worlds.load("clutter").faces, worlds.load("office").faces]
    table = face_table([(faces.segments_m, faces.circles_m, faces.surface) for faces in others])
    origins, directions = rays(rng, 500, 3.0)
    for room, faces in enumerate(others):
        alone = faces.cast(origins, directions, 4.0)
        together = cast_rays(table, room, origins, directions, np.full(500, 4.0))
        assert np.array_equal(together[0], alone.distance_m)
        assert np.array_equal(together[1], alone.normal_xy)
        assert np.array_equal(together[2], alone.surface)


def test_a_room_without_faces_has_a_table():
    hits = world().faces.cast([[0, 0]], [[1, 0]], 10.0)
    assert hits.surface.tolist() == [-1]


def test_a_room_with_a_single_wall_along_an_axis_is_met():
    faces = worlds.Faces(
        np.array([[-1.0, 2.0, 1.0, 2.0]]),
        np.zeros(1, np.int32),
        np.empty((0, 3)),
        np.empty(0, np.int32),
        ("wall",),
    )
    hits = faces.cast([[0, 0], [1.5, 0]], [[0, 1], [0, 1]], 5.0)
    assert hits.distance_m.tolist() == [2.0, math.inf]


def test_clearance_is_the_distance_to_the_nearest_face(crowd, rng):
    outlines = [(shapely.Point(s.circle[:2]), s.circle[2]) for s in crowd.solids if s.circle]
    flat = shapely.union_all([s.outline.boundary for s in crowd.solids if not s.circle])
    gained = []
    for x, y in rng.uniform(-4, 4, (300, 2)):
        point = shapely.Point(x, y)
        nearest = min([point.distance(c) - r for c, r in outlines] + [point.distance(flat)])
        found, away_x, away_y = clearance(crowd.faces.table, 0, x, y, 0.5)
        if nearest >= 0.5:
            assert found == math.inf
            continue
        assert found == pytest.approx(nearest, abs=1e-12)
        further, _, _ = clearance(crowd.faces.table, 0, x + 1e-7 * away_x, y + 1e-7 * away_y, 0.6)
        gained.append(further - found)
    # A step along the vector leads away by its length (unless another face is as near).
    assert np.isclose(gained, 1e-7, rtol=1e-3).mean() > 0.98
