"""Image sources against plain mirrored points, against rays, and in odd rooms."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from mirrored_points import Room, Sonar, first_echo
from rooms import MIRROR, box, closed_room, pillar, world

import worlds
from sim import AllAtOnce, Eeruf, InTurn, PhysicalSonar, Receiver, TransducerSpread
from sim.engines.segments import Segments
from sim.sonar import presets as sonars
from sim.sonar.firing import pings
from sonarmap import Cause, InputError, SonarRing
from worlds import MATERIALS, Material, Solid, World

EXACT = Receiver(noise_std_m=0, weak_noise_std_m=0, quantum_m=0)
# Transducers that are all alike, so that each reading has one true value.
ALIKE = TransducerSpread(0.0, 0.0)
SONAR = sonars.preset("physical").replace(receiver=EXACT, search="images", spread=ALIKE)
BRICK = Material("brick", math.radians(55), 1.0, 0.0, diffuse_floor_db=-20)
ROOMS = worlds.names()


def smooth(room):
    """Return a room whose materials add no noise of their own."""
    return room.with_materials([replace(s.material, roughness_m=0.0) for s in room.solids])


def poses(room, count, rng):
    """Return places where the robot fits, with headings."""
    found = []
    while len(found) < count:
        x, y = rng.uniform(room.bounds_m[:2], room.bounds_m[2:])
        if room.has_room_at(x, y, radius_m=0.2):
            found.append((x, y, rng.uniform(-math.pi, math.pi)))
    return found


def random_room(rng):
    """Return a room with walls, boxes and pillars that may touch and cross each other."""
    materials = ["glass", "drywall", "cardboard", "plaster", "brick", "curtain"]
    width, depth = rng.uniform(3, 6, 2)
    corners = [(0, 0), (width, 0), (width, depth), (0, depth)]
    solids = [Solid.wall("walls", corners, thickness_m=0.1, height_m=2, closed=True, side="right",
                         material=rng.choice(materials))]  # fmt: skip
    for k in range(rng.integers(1, 7)):
        centre, material = rng.uniform((0, 0), (width, depth)), rng.choice(materials)
        if rng.random() < 0.3:
            solid = Solid.pillar(f"s{k}", centre, rng.uniform(0.02, 0.2), height_m=1,
                                 material=material)  # fmt: skip
        else:
            turn = rng.choice([0, math.pi / 2, rng.uniform(0, math.pi)])
            solid = Solid.box(f"s{k}", centre, rng.uniform(0.1, 1, 2), height_m=1,
                              heading_rad=turn, material=material)  # fmt: skip
        solids.append(solid)
    free = rng.uniform((0.3, 0.3), (width - 0.3, depth - 0.3), (200, 2))
    inside = [any(s.outline.contains(shapely.Point(p)) for s in solids) for p in free]
    return World.of(
        "random",
        solids,
        bounds_m=(-0.2, -0.2, width + 0.2, depth + 0.2),
        start=(*free[inside.index(False)], 0.0),
    )


def heard(room, places, axes, *, sonar=SONAR):
    return sonar.listen(room.faces, room, np.asarray(places, float), np.asarray(axes, float),
                        np.random.default_rng(0))  # fmt: skip


def in_scans(room, stops, sonar):
    """Return the readings, causes, bounces and sources of scans at some poses."""
    array, ring = sonar.array(room.faces, room, np.random.default_rng(0)), sonar.ring
    rows = []
    for stop, (x, y, heading) in enumerate(stops):
        places = ring.sensor_xy_m(slice(None), x, y, heading)
        # Two scans: EERUF's delays alternate, and sound of the one is heard in the other.
        for ping in pings(sonar.firing, len(ring), scans=2):
            array.fire(10 * stop + ping.time_s, ping.sonars, places, heading + ring.heading_rad)
        echoes = array.detect()
        rows.append((echoes.range_m, echoes.cause, echoes.bounces, echoes.source))
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


# Against arithmetic.


def differences(room, sonar, count, rng):
    """Return how many of some readings are not those of plain arithmetic."""
    plain, wrong = Room(room), 0
    for x, y, axis in poses(room, count, rng):
        echoes = heard(room, [(x, y)], [axis], sonar=sonar)
        range_m, bounces = first_echo(
            plain, Sonar(sonar.acoustics, (x, y), axis), sonar.max_bounces
        )
        same = echoes.range_m[0] == range_m or abs(echoes.range_m[0] - range_m) < 1e-3
        wrong += not (same and (math.isinf(range_m) or echoes.bounces[0] == bounces))
    return wrong


@pytest.mark.parametrize("name", ROOMS)
def test_readings_are_those_of_mirrored_points(name, rng):
    assert differences(smooth(worlds.load(name)), SONAR, 8, rng) == 0


@pytest.mark.parametrize("bounces", [0, 1, 2])
def test_readings_of_random_rooms_are_those_of_mirrored_points(bounces, rng):
    sonar = SONAR.replace(max_bounces=bounces)
    wrong = sum(differences(smooth(random_room(rng)), sonar, 4, rng) for _ in range(10))
    assert wrong == 0


# Against rays: the more of them, the fewer readings differ.


def share_alike(room, stops, sonar, step_deg):
    rays = sonar.replace(search="rays", ray_step_rad=math.radians(step_deg))
    range_m, *labels = in_scans(room, stops, sonar)
    rays_m, *ray_labels = in_scans(room, stops, rays)
    with np.errstate(invalid="ignore"):
        alike = (range_m == rays_m) | (np.abs(range_m - rays_m) < 1e-3)
    for one, other in zip(labels, ray_labels, strict=True):
        alike &= one == other
    return alike.mean()


@pytest.mark.parametrize("firing", [InTurn(), AllAtOnce(0.1), Eeruf()])
def test_rays_come_the_closer_the_more_there_are(firing, rng):
    room = smooth(worlds.load("clutter"))
    stops, sonar = poses(room, 12, rng), SONAR.replace(firing=firing)
    coarse, fine = (share_alike(room, stops, sonar, step_deg) for step_deg in (1.0, 0.1))
    # Rays try rough places only where they meet them, and know the size of a face to the gap
    # between them: near the threshold that costs millimetres.
    assert coarse > 0.85
    assert fine > 0.9
    assert fine >= coarse


# Symmetry.


@pytest.mark.parametrize("firing", [InTurn(), AllAtOnce(0.1)])
def test_mirrored_room_is_heard_mirrored(firing, rng):
    room = worlds.load("office")
    stops, sonar = poses(room, 10, rng), SONAR.replace(firing=firing)
    ring = sonar.ring
    # Left becomes right: the ring's sonars change places in pairs.
    mirrored_ring = SonarRing("mirrored", ring.x_m, -ring.y_m, -ring.heading_rad,
                              ring.half_angle_rad, ring.range_min_m, ring.range_max_m)  # fmt: skip
    here = in_scans(room, stops, sonar)
    there = in_scans(room.mirrored(), [(x, -y, -heading) for x, y, heading in stops],
                     sonar.replace(ring=mirrored_ring))  # fmt: skip
    for one, other in zip(here, there, strict=True):
        assert one == pytest.approx(other, abs=1e-9)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_turned_room_is_heard_alike(turns, rng):
    room = worlds.load("clutter")
    stops = poses(room, 10, rng)
    cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[turns]
    turned = [(cos * x - sin * y, sin * x + cos * y, h + turns * math.pi / 2) for x, y, h in stops]
    here, there = in_scans(room, stops, SONAR), in_scans(
        room.transformed(quarter_turns=turns), turned, SONAR
    )  # fmt: skip
    for one, other in zip(here, there, strict=True):
        assert one == pytest.approx(other, abs=1e-6)


# Odd rooms.


def test_no_face_is_silent():
    echoes = heard(world(), [(0, 0)], [0])
    assert echoes.range_m[0] == math.inf
    assert Cause(echoes.cause[0]) is Cause.OUT_OF_RANGE
    assert echoes.cone_range_m[0] == math.inf


def test_one_pillar_is_heard_at_its_foot():
    echoes = heard(world(pillar("post", 1.1, 0, 0.1, MIRROR)), [(0, 0)], [0.01])
    assert echoes.range_m[0] == pytest.approx(1.0, abs=0.02)
    assert (echoes.axis_range_m[0], echoes.cone_range_m[0]) == pytest.approx((1.0, 1.0), abs=1e-3)


def test_robot_inside_of_a_pillar_or_a_box_hears_nothing_of_it():
    for solid in (pillar("round", 0, 0, 0.5, MIRROR), box("box", -0.5, -0.5, 0.5, 0.5, MIRROR)):
        echoes = heard(world(solid), [(0.1, 0.05)], [0.3])
        assert echoes.range_m[0] == math.inf
        assert 0 < echoes.cone_range_m[0] < 1


def test_sonar_on_a_face_hears_what_is_before_it():
    room = world(box("at", -0.1, -1, 0.0, 1, MIRROR), box("wall", 2, -1, 2.1, 1, MIRROR))
    assert heard(room, [(0, 0)], [0]).range_m[0] == pytest.approx(2.0, abs=0.01)


def test_face_seen_edge_on_is_not_in_the_way():
    # The sonar looks along the side of a thin board, at a wall behind.
    room = world(box("board", 0.5, -0.02, 1.5, 0, MIRROR), box("wall", 2, -3, 2.1, 3, MIRROR))
    echoes = heard(room, [(0, 1e-7)], [0], sonar=SONAR.replace(edge_db=-200))
    assert echoes.range_m[0] == pytest.approx(2.0, abs=0.01)
    assert echoes.surface[0] == 1


@pytest.mark.parametrize("gap_m", [-0.1, 0.0, 5e-5])
def test_faces_that_cross_touch_or_nearly_touch_make_a_corner(gap_m):
    # Right-angled walls, each seen too obliquely to answer itself.
    room = world(
        box("a", 2, -3, 2.1, -gap_m, MIRROR, turned_deg=-45, about=(2, 0)),
        box("b", 2, gap_m, 2.1, 3, MIRROR, turned_deg=45, about=(2, 0)),
    )
    echoes = heard(room, [(0, 0)], [0])
    assert echoes.range_m[0] == pytest.approx(2.0, abs=1e-3)


def test_flush_and_coinciding_faces_are_one():
    whole = world(box("wall", 2, -1, 2.1, 1, BRICK))
    parts = world(
        box("left", 2, 0, 2.1, 1, BRICK),
        box("right", 2, -1, 2.1, 0, BRICK),
        box("again", 2, -0.5, 2.1, 0.5, BRICK),
    )
    axes = np.radians(np.arange(-60, 61, 3))
    places = np.zeros((len(axes), 2))
    one, many = heard(whole, places, axes), heard(parts, places, axes)
    assert one.range_m == pytest.approx(many.range_m, abs=1e-3)
    assert (one.cause == many.cause).all()


def test_closed_room_with_three_bounces():
    room = closed_room(1.5, MIRROR)
    echoes = heard(room, np.full((8, 2), 0.3), np.arange(8) * 0.7,
                   sonar=SONAR.replace(max_bounces=3))  # fmt: skip
    assert np.isfinite(echoes.range_m).all()


def test_ten_thousand_faces_are_heard():
    rng = np.random.default_rng(3)
    solids = [
        box(f"b{k}", x, y, x + 0.1, y + 0.1, BRICK, turned_deg=rng.uniform(0, 90), about=(x, y))
        for k, (x, y) in enumerate(rng.uniform(-20, 20, (2500, 2)))
        if math.hypot(x, y) > 0.5
    ]
    room = world(*solids)
    echoes = heard(room, np.zeros((4, 2)), np.arange(4) * 1.5)
    fine = SONAR.replace(search="rays", ray_step_rad=math.radians(0.1))
    assert echoes.range_m == pytest.approx(
        heard(room, np.zeros((4, 2)), np.arange(4) * 1.5, sonar=fine).range_m, abs=2e-3
    )


# Which search.


def test_images_are_used_where_the_faces_are_known():
    class Rays:
        cast = staticmethod(world(box("w", 1, -1, 1.1, 1)).faces.cast)

    room = world(box("w", 1, -1, 1.1, 1))
    rng = np.random.default_rng(0)
    auto = SONAR.replace(search="auto")
    with Segments(room, room.start) as engine:
        kinds = [type(auto.array(rays, room, rng)).__name__ for rays in (engine, room.faces, Rays)]
    assert kinds == ["ImageArray", "ImageArray", "PhysicalArray"]
    with pytest.raises(InputError, match="search 'images' needs an engine that knows"):
        SONAR.array(Rays, room, rng)
    with pytest.raises(InputError, match=r"search 'ray' is unknown; .*'rays'"):
        SONAR.replace(search="ray")


def test_truth_of_the_cone_is_exact(rng):
    room = random_room(rng)
    ring = SonarRing("one", [0], [0], [0], math.radians(15), 0.1, 5.0)
    sonar = PhysicalSonar("one", ring, AllAtOnce(0.1), receiver=EXACT, search="images")
    for x, y, axis in poses(room, 40, rng):
        echoes = heard(room, [(x, y)], [axis], sonar=sonar)
        angle = axis + np.radians(np.linspace(-15, 15, 3001))
        ways = np.column_stack([np.cos(angle), np.sin(angle)])
        nearest_m = room.faces.cast(np.tile((x, y), (3001, 1)), ways, 5.0).distance_m.min()
        assert echoes.cone_range_m[0] <= nearest_m + 1e-12
        assert echoes.cone_range_m[0] == pytest.approx(nearest_m, abs=1e-3)


def test_materials_may_differ_between_drives_in_one_room():
    room = closed_room(1.5, MIRROR)
    soft = room.with_materials([MATERIALS["foam"]] * 4)
    loud, faint = (heard(one, [(0, 0)], [0]).level_db[0] for one in (room, soft))
    assert loud - faint == pytest.approx(16, abs=0.1)
