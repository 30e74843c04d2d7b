"""The physical sonar against a plain walk over all pairs of faces, by mirror images."""

import math

import numpy as np
import pytest
import shapely
from mirrored_points import Room, size_share
from rooms import world

from sim import AllAtOnce, PhysicalSonar, Piston, Receiver, TransducerSpread
from sim.sonar.air import Air
from sonarmap import SonarRing
from worlds import Material, Solid

# Mirrors and nothing else: no edges, nothing scattered, no late crossing.
GLASS = Material("glass", 0.2, 0.9, 0.0, diffuse_floor_db=-100)
RANGE_DB = 44.0
AHEAD = SonarRing("ahead", [0], [0], [0], math.radians(15), 0.1, 5.0)
SONAR = PhysicalSonar(
    "mirrors",
    AHEAD,
    AllAtOnce(0.1),
    receiver=Receiver(RANGE_DB, 1.0, 1e-9, 0, 0, 0, 0),
    edge_db=-200,
    spread=TransducerSpread(0.0, 0.0),
    max_bounces=1,
)


def mirrored(point, face):
    a, normal = face[0], face[2]
    return point - 2 * ((point - a) @ normal) * normal


def crossing(start, end, face):
    """Return where a straight way crosses a face from its front or back; None if it does not."""
    a, b, normal = face
    from_m, to_m = (start - a) @ normal, (end - a) @ normal
    if from_m * to_m >= 0:
        return None
    point = start + (end - start) * from_m / (from_m - to_m)
    share = (point - a) @ (b - a) / ((b - a) @ (b - a))
    return point if 0 <= share <= 1 else None


def is_free(room, start, end):
    way = end - start
    length = math.hypot(*way)
    hit = room.faces.cast([start + 1e-9 * way], [way / length], length)
    return hit.distance_m[0] > length - 1e-4


def level_db(power, bearings_rad, mirrors):
    # With the whole loss taken back by the gain, what is left is beam, mirrors and their sizes.
    losses = mirrors * 20 * math.log10(GLASS.reflectivity) + 10 * math.log10(power + 1e-12)
    return RANGE_DB + losses + sum(float(Piston().level_db(bearing)) for bearing in bearings_rad)


def ways(room, axis_rad):
    """Yield (length, level, bounces) of each way from the origin over faces and back."""
    plain = Room(room)
    faces = []
    for x0, y0, x1, y1 in room.faces.segments_m:
        a, b = np.array([x0, y0]), np.array([x1, y1])
        normal = np.array([y1 - y0, x0 - x1]) / math.hypot(x1 - x0, y1 - y0)
        faces.append((a, b, normal))
    sensor = np.zeros(2)

    def bearing(point):
        return math.remainder(math.atan2(point[1], point[0]) - axis_rad, math.tau)

    def power(k, viewer, at, path_m):
        """Return what the size of a face leaves, met at a place by who sees it."""
        one_m = math.hypot(*(at - viewer))
        cos = abs(faces[k][2] @ (at - viewer)) / one_m
        wavelength_m = SONAR.acoustics.wavelength_m
        return size_share(wavelength_m, cos, one_m, path_m - one_m, plain.extent(k, viewer, at))

    for k, face in enumerate(faces):
        image = mirrored(sensor, face)
        foot = crossing(sensor, image, face)
        if foot is not None and is_free(room, sensor, foot):
            length = 2 * math.hypot(*foot)
            turned = power(k, sensor, foot, length)
            yield length, level_db(turned, [bearing(foot)] * 2, 1), 0
        for m, other in enumerate(faces):
            if m == k:
                continue
            # There and back the same way: the foot on the other face, seen in the mirror.
            foot = crossing(image, mirrored(image, other), other)
            at = None if foot is None else crossing(image, foot, face)
            if at is not None and is_free(room, sensor, at) and is_free(room, at, foot):
                length = 2 * math.hypot(*(foot - image))
                turned = power(m, image, foot, length)
                turned *= min(power(k, sensor, at, length), 1) ** 2
                yield length, level_db(turned, [bearing(at)] * 2, 3), 1
            # Back another way: from the other face straight to the sonar.
            second = mirrored(image, other)
            last = crossing(sensor, second, other)
            at = None if last is None else crossing(image, last, face)
            square = abs(face[2] @ other[2]) < math.sin(math.radians(2))
            if (
                at is not None
                and not square
                and is_free(room, sensor, at)
                and is_free(room, at, last)
                and is_free(room, last, sensor)
            ):
                length = math.hypot(*second)
                turned = power(m, image, last, length) * min(power(k, sensor, at, length), 1)
                yield length, level_db(turned, [bearing(at), bearing(last)], 2), 1


def random_room(rng):
    solids = []
    for index in range(7):
        x, y = rng.uniform(-2.5, 2.5, 2)
        outline = shapely.affinity.rotate(
            shapely.box(x - 0.7, y - 0.2, x + 0.7, y + 0.2), rng.uniform(0, 360)
        )
        apart = all(outline.distance(solid.outline) > 0.05 for solid in solids)
        if apart and outline.distance(shapely.Point(0, 0)) > 0.3:
            solids.append(Solid(f"s{index}", GLASS, 1.0, outline))
    return world(*solids)


# Rays know the size of a face to the gap between them, and no more of it than they see.
@pytest.mark.parametrize(("search", "hair_db"), [("images", 0.3), ("rays", 5.0)])
def test_mirror_ways_equal_a_walk_over_all_pairs_of_faces(search, hair_db, rng):
    assert Air().absorption_db_per_m(49_400) > 1  # the gain takes this back as well
    seen = {0: 0, 1: 0}
    for _ in range(150):
        room, axis_rad = random_room(rng), rng.uniform(-math.pi, math.pi)
        array = SONAR.replace(search=search).array(room.faces, room, rng)
        array.fire(0.0, (0,), np.zeros((1, 2)), np.array([axis_rad]))
        echoes = array.detect()
        # What is louder than the threshold by a hair may be lost to the beam's table.
        audible = [way for way in ways(room, axis_rad) if way[1] > hair_db and way[0] < 10]
        nearly = {round(way[0] / 2, 6) for way in ways(room, axis_rad) if abs(way[1]) <= hair_db}
        expected = min(audible, default=(math.inf, 0, 0))
        if round(float(echoes.range_m[0]), 6) in nearly:
            continue
        assert echoes.range_m[0] == pytest.approx(expected[0] / 2, abs=1e-6)
        if math.isfinite(expected[0]):
            assert echoes.bounces[0] == expected[2]
            # A way over two faces and its reverse are as long, not always as loud.
            levels = [way[1] for way in audible if way[0] - expected[0] < 1e-6]
            assert min(abs(echoes.level_db[0] - level) for level in levels) < hair_db
            seen[expected[2]] += 1
    assert seen[0] > 10
    assert seen[1] > 3
