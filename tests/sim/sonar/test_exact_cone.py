"""The exact cone against a slow walk of rays, against fans that grow, and against its laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from rooms import MIRROR, ROUGH, SOFT, box, closed_room, pillar, world

import worlds
from sim import ConeSonar
from sim.envs.facts import facts_of
from sim.sonar import presets
from sim.sonar.cone.exact.echo import hear_all
from sonarmap import Cause, SonarRing
from worlds import Faces, Material

AHEAD = SonarRing("ahead", [0], [0], [0], math.radians(15), 0.165, 3.0)
EXACT = ConeSonar("exact", AHEAD, scan_period_s=0.1, rays=None, noise_std_m=0, quantum_m=0)
FAR = EXACT.replace(ring=replace(AHEAD, range_max_m=8.0), max_bounces=3)
HALF = Material("half", math.radians(30), 0.6, 0.0)


def listen(room, places, axes, *, sonar=EXACT):
    places, axes = np.atleast_2d(np.array(places, float)), np.atleast_1d(np.array(axes, float))
    return sonar.listen(room.faces, room, places, axes, np.random.default_rng(0))


# The slow twin: rays that are traced one by one in plain Python, close together, closer still where
# two of them meet different faces, and between them the shortest way of those that meet the same.


def met(faces, x, y, dx, dy, last):
    """Return (distance, normal, number) of the first face that a ray meets, after `last`."""
    best = (math.inf, None, -1)
    for i, (x0, y0, x1, y1) in enumerate(faces.segments_m.tolist()):
        across = dx * (y1 - y0) - dy * (x1 - x0)
        if across == 0 or i == last:
            continue
        distance = ((x0 - x) * (y1 - y0) - (y0 - y) * (x1 - x0)) / across
        share = ((x0 - x) * dy - (y0 - y) * dx) / across
        if 1e-9 < distance < best[0] and 0 <= share <= 1:
            length = math.hypot(x1 - x0, y1 - y0)
            best = (distance, ((y1 - y0) / length, (x0 - x1) / length), i)
    for i, (cx, cy, radius) in enumerate(faces.circles_m.tolist(), len(faces.segments_m)):
        along, aside = (cx - x) * dx + (cy - y) * dy, (cx - x) * dy - (cy - y) * dx
        if abs(aside) >= radius or i == last:
            continue
        distance = along - math.sqrt(radius**2 - aside**2)
        if distance <= 1e-9 and math.hypot(cx - x, cy - y) < radius:
            distance = along + math.sqrt(radius**2 - aside**2)
        if 1e-9 < distance < best[0]:
            best = (
                distance,
                ((x + distance * dx - cx) / radius, (y + distance * dy - cy) / radius),
                i,
            )
    return best


def trace(room, sonar, at, angle):
    """Return the faces that a ray meets with what becomes of it, and its path."""
    (x, y), dx, dy = at, math.cos(angle), math.sin(angle)
    way, path, strength = [], 0.0, 1.0
    for _ in range(sonar.max_bounces + 1):
        distance, normal, face = met(room.faces, x, y, dx, dy, way[-1] if way else -1)
        path += distance
        if path > sonar.ring.range_max_m:
            return (*way, "far"), math.inf
        way.append(face)
        material = room.solids[room.faces.surface[face]].material
        strength *= material.reflectivity
        if strength < sonar.threshold:
            return (*way, "weak"), math.inf
        cos = dx * normal[0] + dy * normal[1]
        if abs(cos) >= math.cos(material.critical_incidence_rad):
            return (*way, "back"), path
        x, y = x + distance * dx, y + distance * dy
        dx, dy = dx - 2 * cos * normal[0], dy - 2 * cos * normal[1]
    return (*way, "lost"), math.inf


def shortest(room, sonar, at, axis_rad, rays):
    """Return the way of the first return and its length."""
    half = sonar.ring.half_angle_rad
    angles = (axis_rad + np.linspace(-half, half, rays)).tolist()
    traced = [(angle, *trace(room, sonar, at, angle)) for angle in angles]
    best = ((), math.inf)
    begin = traced[0]
    for one, other in zip(traced, [*traced[1:], None], strict=True):
        if other is not None and other[1] == one[1]:
            continue
        end = one
        if other is not None:
            # Where it changes, from both sides.
            low, high = one, other
            while high[0] - low[0] > 1e-13:
                middle = 0.5 * (low[0] + high[0])
                found = (middle, *trace(room, sonar, at, middle))
                low, high = (found, high) if found[1] == one[1] else (low, found)
            end = low
        if one[1][-1] == "back":
            best = min(best, (one[1], descend(room, sonar, at, begin, end)), key=lambda b: b[1])
        begin = None if other is None else high
        if begin is not None and begin[1] != other[1]:
            begin = other  # something narrower than two rays: left to more rays
    return best


def descend(room, sonar, at, begin, end):
    """Return the shortest of the ways between two rays that meet the same faces."""
    best, low, high = min(begin[2], end[2]), begin[0], end[0]
    ratio = (math.sqrt(5) - 1) / 2
    while high - low > 1e-9:
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        paths = [trace(room, sonar, at, angle)[1] for angle in (left, right)]
        best = min(best, *paths)
        low, high = (low, right) if paths[0] < paths[1] else (left, high)
    return best


def scene(rng, *, overlap):
    """A room of turned boxes and pillars about the origin, which stays free."""
    materials = [MIRROR, MIRROR, HALF, MIRROR, ROUGH, MIRROR, MIRROR, SOFT, MIRROR]
    solids = list(closed_room(2.2, MIRROR).solids)
    for k in range(9):
        x, y = rng.uniform(-2, 2, 2)
        material = materials[k]
        if k % 3 == 0:
            solid = pillar(f"pillar {k}", x, y, rng.uniform(0.05, 0.5), material)
        else:
            turned = {"turned_deg": rng.uniform(0, 360), "about": (x, y)}
            solid = box(f"box {k}", x - 0.5, y - 0.1, x + 0.5, y + 0.1, material, **turned)
        free = solid.outline.distance(shapely.Point(0, 0)) > 0.2
        apart = overlap or all(solid.outline.distance(other.outline) > 0.01 for other in solids)
        if free and apart:
            solids.append(solid)
    return world(*solids)


@pytest.mark.parametrize("overlap", [False, True])
def test_it_is_what_a_slow_walk_of_rays_finds(rng, overlap):
    bounced, pillars = 0, 0
    for _ in range(25):
        room, axis = scene(rng, overlap=overlap), rng.uniform(-math.pi, math.pi)
        echoes = listen(room, (0, 0), axis, sonar=FAR)
        for rays in (151, 3001, 40_001):
            way, path_m = shortest(room, FAR, (0.0, 0.0), axis, rays)
            if path_m <= echoes.range_m[0] + 1e-7:
                break  # else a gap is narrower than two rays are apart: closer ones must find it
        assert echoes.range_m[0] == pytest.approx(path_m, abs=1e-7)
        if way:
            assert echoes.bounces[0] == len(way) - 2
            assert echoes.surface[0] == room.faces.surface[way[-2]]
            bounced += len(way) > 2
            pillars += any(face >= len(room.faces.segments_m) for face in way[:-2])
    assert bounced >= 5
    assert pillars >= 1  # or the scenes have become too easy


def spots(room, n, seed=0):
    """Places and directions all over a room."""
    rng = np.random.default_rng(seed)
    starts = [facts_of(room, 0.1).random_start(rng) for _ in range(n)]
    return np.array([(s.x_m, s.y_m) for s in starts]), rng.uniform(-math.pi, math.pi, n)


@pytest.mark.parametrize("name", worlds.names())
def test_fans_of_more_and_more_rays_come_close(name):
    room = worlds.load(name)
    places, axes = spots(room, 1000)
    aria = presets.preset("aria").replace(noise_std_m=0, quantum_m=0, ring=EXACT.ring)
    exact = listen(room, places, axes, sonar=aria)
    close, same_cause = [], []
    for rays in (31, 101, 1001):
        fan = listen(room, places, axes, sonar=aria.replace(rays=rays))
        # Rays are some of the cone: they find nothing nearer.
        assert (fan.range_m >= exact.range_m - 1e-5).all()
        assert (fan.cone_range_m >= exact.cone_range_m - 1e-9).all()
        assert fan.axis_range_m == pytest.approx(exact.axis_range_m, abs=1e-9)
        close.append(np.isclose(fan.range_m, exact.range_m, rtol=0, atol=1e-3).mean())
        same_cause.append((fan.cause == exact.cause).mean())
    assert close == sorted(close)
    assert close[-1] >= 0.98
    assert same_cause == sorted(same_cause)
    assert same_cause[-1] >= 0.997


def same(one, other):
    for field in ("range_m", "axis_range_m", "cone_range_m", "incidence_rad"):
        a, b = getattr(one, field), getattr(other, field)
        assert a == pytest.approx(b, abs=1e-7, nan_ok=True), field
    for field in ("cause", "surface", "bounces"):
        assert (getattr(one, field) == getattr(other, field)).all(), field


@pytest.mark.parametrize("name", worlds.names())
def test_a_turned_room_gives_the_turned_readings_and_a_mirrored_one_the_mirrored(name):
    room = worlds.load(name)
    (x, y), axes = spots(room, 500)[0].T, spots(room, 500)[1]
    told = listen(room, np.column_stack([x, y]), axes)
    turned = room.transformed(quarter_turns=1)
    same(listen(turned, np.column_stack([-y, x]), axes + math.pi / 2), told)
    same(listen(room.mirrored(), np.column_stack([x, -y]), -axes), told)


# Faces as they come, without solids.


def hear(segments=(), circles=(), *, axis_rad=0.0, half_deg=15, critical_deg=90.0, bounces=2):
    """Return (echo, surface, incidence, bounces, axis range, cone range); a surface each face."""
    n = len(segments) + len(circles)
    faces = Faces(
        np.array(segments, float).reshape(-1, 4), np.arange(len(segments), dtype=np.int32),
        np.array(circles, float).reshape(-1, 3), np.arange(len(segments), n, dtype=np.int32),
        tuple(str(i) for i in range(n)),
    )  # fmt: skip
    critical_cos = np.cos(np.radians(np.broadcast_to(critical_deg, n).astype(float)))
    told = hear_all(
        tuple(faces.table), 0, np.zeros((1, 2)), np.array([axis_rad]), math.radians(half_deg),
        (3.0, bounces, 0.1), critical_cos, np.ones(n),
    )  # fmt: skip
    return [column[0] for column in told]


def test_no_face_sends_nothing():
    echo_m, surface, _, _, axis_m, cone_m = hear()
    assert (echo_m, surface, axis_m, cone_m) == (math.inf, -1, math.inf, math.inf)


def test_one_face_is_read_at_its_foot():
    wall = (2, -5, 2, 5)
    assert hear([wall])[0] == 2.0
    tilted = hear([wall], axis_rad=math.radians(14))
    assert tilted[0] == pytest.approx(2.0, abs=1e-14)
    assert tilted[2] == 0.0
    assert tilted[4] == pytest.approx(2 / math.cos(math.radians(14)), abs=1e-14)
    beyond = hear([wall], axis_rad=math.radians(35))
    assert beyond[0] == beyond[5] == pytest.approx(2 / math.cos(math.radians(20)), abs=1e-14)
    assert math.degrees(beyond[2]) == pytest.approx(20)


def test_faces_that_touch_are_one_wall():
    whole = [(1.5, -1, 2.5, 1)]
    parts = [(1.5, -1, 1.75, -0.5), (1.75, -0.5, 2.1, 0.2), (2.1, 0.2, 2.5, 1)]
    beside = [(-1, 2.0, 3, 2.0)]
    for axis_rad in np.linspace(-0.6, 0.6, 25):
        for critical_deg in (90, 15):
            arguments = {"axis_rad": axis_rad, "critical_deg": critical_deg}
            one, other = (hear(walls + beside, **arguments) for walls in (whole, parts))
            for a, b in zip(one[2:] + one[:1], other[2:] + other[:1], strict=True):
                assert a == pytest.approx(b, abs=1e-9, nan_ok=True)


def test_of_faces_that_coincide_the_first_is_met():
    longer, shorter = (1, -2, 1, 2), (1, 0.1, 1, -0.1)
    for walls in ([longer, shorter], [shorter, longer], [longer, longer[2:] + longer[:2]]):
        echo_m, surface, *_ = hear(walls)
        assert (echo_m, surface) == (1.0, 0)


def test_faces_that_cross_are_seen_on_either_side_of_the_crossing():
    # An X before the sonar: of each bar the near half is seen, from its critical angle on.
    bars = [(1, -0.5, 2, 0.5), (1, 0.5, 2, -0.5)]
    echo_m, _, incidence, _, axis_m, cone_m = hear(bars)
    assert axis_m == pytest.approx(1.5)
    # Of the right bar, y = x - 1.5, the cone's edge y = -tan(15) x meets the nearest place.
    x = 1.5 / (1 + math.tan(math.radians(15)))
    assert echo_m == cone_m == pytest.approx(x / math.cos(math.radians(15)))
    assert math.degrees(incidence) == pytest.approx(30)
    assert hear(bars, critical_deg=29, bounces=0)[0] == math.inf


def test_a_face_through_the_sonar_is_not_met():
    # As for a ray: what is within a nanometre does not count.
    for through in [(0, -1, 0, 1), (-1, -1, 1, 1), (0, 0, 0, 1)]:
        assert hear([through, (2, -2, 2, 2)])[0] == 2.0


def test_an_edge_on_face_sends_nothing_and_hides_nothing():
    told = hear([(1, 0, 2, 0), (2.5, -2, 2.5, 2)])
    assert told[0] == told[4] == 2.5


def test_nothing_is_seen_in_the_corner_behind_a_box():
    # The front mirrors what comes at 45 degrees; the side would answer, but is behind the corner.
    front, side = (1, 0, 2, 1), (1, 0, 2, -1)
    assert hear([front, side], critical_deg=29, bounces=0)[0] == math.inf
    hidden = (1, 0, 3, 0.5)
    assert hear([front, hidden], critical_deg=[29, 90], bounces=0)[0] == math.inf


def test_inside_a_pillar_its_far_side_is_met():
    radius, off = 0.8, 0.3
    # Towards the nearer side, from behind the centre, aside.
    assert hear(circles=[(-off, 0, radius)])[0] == pytest.approx(radius - off)
    across = off * math.sin(math.radians(15))
    edge = off * math.cos(math.radians(15)) + math.sqrt(radius**2 - across**2)
    assert hear(circles=[(off, 0, radius)])[0] == pytest.approx(edge)
    told = hear(circles=[(0, off, radius)], critical_deg=20, bounces=2)
    # The sine of the angle of incidence is off / radius * cos(bearing): at -15 degrees 21 degrees.
    assert told[0] == math.inf
    assert told[4] == pytest.approx(math.sqrt(radius**2 - off**2))
    assert hear(circles=[(0, off, radius)])[0] == pytest.approx(
        -across + math.sqrt(radius**2 - (off * math.cos(math.radians(15))) ** 2)
    )


def test_a_mirror_pillar_sends_sound_to_where_its_tangent_does():
    # Met at 45 degrees, a thin pillar turns the axis by 90: sqrt(2) / 2 of its radius aside.
    radius = 0.05
    aside = radius * math.sqrt(0.5)
    walls = [(0.9, 1.0, 1.0, 1.0)]
    told = hear(walls, [(1.0, -aside, radius)], half_deg=1, critical_deg=[5, 10])
    assert told[3] == 1
    # The way to a wall at right angles is 1 - aside and 1 long.
    assert told[0] == pytest.approx(2 - aside, abs=1e-3)
    assert told[0] <= 2 - aside


def test_ten_thousand_faces(rng):
    n = 10_000
    middle, angle = rng.uniform(-10, 10, (n, 2)), rng.uniform(0, math.pi, n)
    ends = 0.05 * np.column_stack([np.cos(angle), np.sin(angle)])
    segments = np.column_stack([middle - ends, middle + ends])
    surface = np.zeros(n, np.int32)
    nothing = np.empty((0, 3)), np.empty(0, np.int32)
    many = Faces(segments, surface, *nothing, ("all",))
    places, axes = rng.uniform(-5, 5, (200, 2)), rng.uniform(-math.pi, math.pi, 200)
    arguments = (math.radians(15), (3.0, 1, 0.1), np.array([math.cos(0.3)]), np.ones(1))
    told = hear_all(tuple(many.table), 0, places, axes, *arguments)
    # The same with only the faces in reach, which are few enough to be taken as a whole.
    for k in range(0, 200, 10):
        reach_m = min(told.echo_m[k], 3.0) + 0.06
        near = np.hypot(*(middle - places[k]).T) < reach_m
        few = Faces(segments[near], surface[near], *nothing, ("all",))
        alone = hear_all(tuple(few.table), 0, places[k : k + 1], axes[k : k + 1], *arguments)
        for one, other in zip(told[:4], alone[:4], strict=True):
            assert one[k] == other[0] or (one[k] != one[k] and other[0] != other[0])
    assert (told.bounces > 0).sum() >= 3
    assert np.isfinite(told.axis_range_m).mean() > 0.5


def test_a_number_of_rays_is_cast_on_any_engine_and_none_where_faces_are_known():
    room = world(box("wall", 1.0, -2, 1.1, 2, turned_deg=7.7))

    class Blind:
        """Casts rays, and shows no faces."""

        cast = room.faces.cast

    place, axis = np.zeros((1, 2)), np.zeros(1)
    fan = listen(room, place, axis, sonar=EXACT.replace(rays=31)).range_m[0]
    blind = EXACT.listen(Blind(), room, place, axis, np.random.default_rng(0)).range_m[0]
    assert blind == fan
    assert listen(room, place, axis).range_m[0] < fan
    assert Cause(listen(room, place, axis).cause[0]) is Cause.DIRECT
