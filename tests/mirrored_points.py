"""All sounds of a sonar by plain mirrored-point arithmetic: slow, for tests.

Nothing here is shared with the simulator but the levels' formulas and the rays that say whether a
path is free.
"""

import itertools
import math

import numpy as np
from scipy.special import fresnel

from sim.sonar.physical.levels import beam_db, mirror_echo_db, tvg_db

TOUCH_M = 1e-4
RIGHT = math.sin(math.radians(2))


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


class Room:
    """A world's faces as points, and the places where they end, meet or cross."""

    def __init__(self, world):
        faces = world.faces
        self.cast = faces.cast
        self.mirror_db = [20 * math.log10(s.material.reflectivity) for s in world.solids]
        self.floor_db = [s.material.diffuse_floor_db for s in world.solids]
        rows = zip(faces.segments_m, faces.segment_surface, strict=True)
        self.segments = [(row[:2], row[2:], int(k)) for row, k in rows]
        rows = zip(faces.circles_m, faces.circle_surface, strict=True)
        self.pillars = [(row[:2], row[2], int(k)) for row, k in rows]
        places = [end for a, b, _ in self.segments for end in (a, b)]
        for (a, b, _), (c, d, _) in itertools.combinations(self.segments, 2):
            across = cross(b - a, d - c)
            if abs(across) > 1e-12:
                one, other = cross(c - a, d - c) / across, cross(c - a, b - a) / across
                if 0 < one < 1 and 0 < other < 1:
                    places.append(a + one * (b - a))
        self.vertices = []
        for place in places:
            if all(np.abs(place - known).max() > TOUCH_M for known, _ in self.vertices):
                self.vertices.append((place, self._arms(place)))

    def _arms(self, place):
        arms = []
        for i, (a, b, _) in enumerate(self.segments):
            length = math.hypot(*(b - a))
            way = (b - a) / length
            along = (place - a) @ way
            if abs(cross(way, place - a)) > TOUCH_M or not -TOUCH_M <= along <= length + TOUCH_M:
                continue
            arms += [(way, i)] if along < length - TOUCH_M else []
            arms += [(-way, i)] if along > TOUCH_M else []
        return arms

    def extent(self, i, viewer, place):
        """Return how far a face goes on from a place of it, both ways, as the viewer sees it."""
        a, b, _ = self.segments[i]
        way = (b - a) / math.hypot(*(b - a))
        side = np.array([way[1], -way[0]])
        side = side * math.copysign(1, side @ (viewer - a))
        foot = a + way * (way @ (viewer - a))
        return [self._goes_on(place, way * sign, side, foot, viewer) for sign in (1, -1)]

    def _goes_on(self, place, way, side, foot, viewer):
        """Walk along a line until a face stands on it, or it goes on no more."""
        height = math.hypot(*(viewer - foot))
        gone = way @ (place - foot)
        for at, arms in sorted(
            (
                (way @ (v - foot), arms)
                for v, arms in self.vertices
                if abs(side @ (v - foot)) < 2e-4
            ),
            key=lambda one: one[0],
        ):
            if at < gone - 1e-7:
                continue
            standing = [arm for arm in arms if arm[0] @ side > 1e-3]
            if standing:
                # The first that is met: that which leans most over the way one came.
                arm = max(standing, key=lambda one: -(one[0] @ way))
                if arm[0] @ way > RIGHT or at <= 0:
                    return at - gone
                depth = self.reach(at * way + foot, arm[0], -way) * (arm[0] @ side)
                return at * height / (height - depth) - gone if depth < height else math.inf
            if not any(arm[0] @ way > 1 - 1e-6 for arm in arms):
                return at - gone
            if at - gone > 3:
                break
        return math.inf

    def reach(self, place, along, towards):
        """Return how far a face goes on from a corner until something stands on its inner side."""
        inner = towards - along * (along @ towards)
        inner /= math.hypot(*inner)
        for at, arms in sorted(
            (
                (along @ (v - place), arms)
                for v, arms in self.vertices
                if abs(cross(along, v - place)) < 2e-4
            ),
            key=lambda one: one[0],
        ):
            if at < 1e-3:
                continue
            if any(arm[0] @ inner > 1e-3 for arm in arms):
                return at
            if not any(arm[0] @ along > 1 - 1e-6 for arm in arms):
                return at
            if at > 3:
                break
        return math.inf

    def is_free(self, start, end):
        way = end - start
        length = math.hypot(*way)
        if length < 2e-4:
            return True
        return np.isinf(self.cast([start], [way / length], length - 2e-4).distance_m[0])


def image(point, a, b):
    way = (b - a) / math.hypot(*(b - a))
    return a + 2 * ((point - a) @ way) * way - (point - a)


def meeting(start, end, a, b):
    """Return where a way from a place to another crosses a segment, None if nowhere."""
    across = cross(end - start, b - a)
    if abs(across) < 1e-15:
        return None
    one, other = cross(a - start, b - a) / across, cross(a - start, end - start) / across
    return start + one * (end - start) if 1e-12 < one < 1 and -1e-9 <= other <= 1 + 1e-9 else None


def chains(room, sensor, bounces):
    """Yield (mirrors, images) of each row of mirrors; the first image is the sensor itself."""
    longer = [([], [sensor])]
    for mirrors in range(bounces + 1):
        yield from longer
        if mirrors < bounces:
            longer = [
                ([*over, i], [*images, image(images[-1], a, b)])
                for over, images in longer
                for i, (a, b, _) in enumerate(room.segments)
                if (not over or over[-1] != i) and abs(cross(b - a, images[-1] - a)) > 1e-9
            ]


def way_to(room, over, images, target):
    """Return the corners of the way to a target over mirrors; None if there is none."""
    ways = [target]
    for k in range(len(over) - 1, -1, -1):
        a, b, _ = room.segments[over[k]]
        at = meeting(images[k + 1], ways[0], a, b)
        # What is seen in a mirror stands on the side of who looks.
        if at is None or cross(b - a, ways[0] - a) * cross(b - a, images[k] - a) <= 0:
            return None
        ways.insert(0, at)
    return [images[0], *ways]


def is_way_free(room, over, way):
    for k, (start, end) in enumerate(itertools.pairwise(way)):
        if k > 0:
            a, b, _ = room.segments[over[k - 1]]
            normal = np.array([b[1] - a[1], a[0] - b[0]]) / math.hypot(*(b - a))
            start = start + math.copysign(1e-6, normal @ (way[k - 1] - a)) * normal
        if not room.is_free(start, end):
            return False
    return True


def size_share(wavelength_m, cos, one_m, other_m, far_m):
    """Return the power of a face that goes on so far both ways against that of a large one."""
    per_m = cos * math.sqrt(2 * (one_m + other_m) / (wavelength_m * one_m * other_m))
    total = 0j
    for gap in far_m:
        u = gap * per_m
        # Beyond 8 the pulse is over; on the way there ripples fade.
        fade = min(max((8 - u) / 2, 0), 1)
        fade = fade * fade * (3 - 2 * fade)
        sine, cosine = fresnel(min(u, 8))
        total += 0.5 * (1 + 1j) + (complex(cosine, sine) - 0.5 * (1 + 1j)) * fade
    return abs(total) ** 2 / 2


def passed(room, sonar, over, images, way, path_m, there_and_back):
    """Return the power that small mirrors let pass."""
    power, gone = 1.0, 0.0
    for k, i in enumerate(over):
        gone += math.hypot(*(way[k + 1] - way[k]))
        a, b, _ = room.segments[i]
        normal = np.array([b[1] - a[1], a[0] - b[0]]) / math.hypot(*(b - a))
        cos = abs(normal @ (images[k] - a)) / gone
        far_m = room.extent(i, images[k], way[k + 1])
        one = size_share(sonar.acoustics.wavelength_m, cos, gone, path_m - gone, far_m)
        power *= min(one, 1.0) ** (2 if there_and_back else 1)
    return power


class Sonar:
    """Where a sonar is, where it looks, and how loud and late what it hears is."""

    def __init__(self, acoustics, place, axis_rad):
        self.acoustics, self.place, self.axis_rad = acoustics, np.asarray(place, float), axis_rad

    def beam_db(self, towards):
        angle = math.atan2(*(towards - self.place)[::-1])
        return beam_db(self.acoustics, angle - self.axis_rad)

    def crossing_m(self, path_m, level_db):
        acoustics = self.acoustics
        arrival_s = path_m / acoustics.speed_mps
        if not 0 < arrival_s <= acoustics.window_s:
            return math.inf
        over_db = level_db + tvg_db(acoustics, arrival_s)
        if over_db <= 0:
            return math.inf
        crossing_s = arrival_s + acoustics.pulse_s * 10 ** (-over_db / 20)
        if arrival_s + acoustics.pulse_s < acoustics.blanking_s:
            return math.inf
        crossing_s = max(crossing_s, acoustics.blanking_s)
        return (
            crossing_s * acoustics.assumed_speed_mps / 2
            if crossing_s <= acoustics.window_s
            else math.inf
        )


def first_echo(room, sonar, bounces):
    """Return (range read, mirrors) of the first of a sonar's own sounds that it detects."""
    first = (math.inf, 0)
    found = []
    for over, images in chains(room, sonar.place, bounces):
        lost_db = sum(room.mirror_db[room.segments[i][2]] for i in over)
        for kind in (_feet, _corners, _pillars, _ways_back):
            found += kind(room, sonar, over, images, lost_db)
    for read_m, over, way, back in sorted(found, key=lambda one: one[0]):
        if (
            read_m < first[0]
            and is_way_free(room, over, way)
            and (back is None or room.is_free(sonar.place, back))
        ):
            first = (read_m, len(over))
    return min(first, _scattered(room, sonar, bounces, first))


def _echo(room, sonar, over, images, target, level_db, path_m, back=None, size=None):
    way = way_to(room, over, images, target)
    if way is None:
        return []
    if size is not None:
        level_db += 10 * math.log10(size() + 1e-12)
    let = passed(room, sonar, over, images, way, path_m, back is None)
    level_db += 10 * math.log10(let + 1e-12)
    sent_db = sonar.beam_db(way[1])
    level_db += 2 * sent_db if back is None else sent_db + sonar.beam_db(back)
    read_m = sonar.crossing_m(path_m, mirror_echo_db(sonar.acoustics, path_m) + level_db)
    return [(read_m, over, way, back)] if read_m < math.inf else []


def _feet(room, sonar, over, images, lost_db):
    for i, (a, b, k) in enumerate(room.segments):
        share = (images[-1] - a) @ (b - a) / ((b - a) @ (b - a))
        foot = a + share * (b - a)
        half_m = math.hypot(*(foot - images[-1]))
        if -1e-9 <= share <= 1 + 1e-9 and half_m > 1e-9 and (not over or over[-1] != i):
            level_db = 2 * lost_db + room.mirror_db[k]

            def size(i=i, k=k, foot=foot, half_m=half_m):
                far_m = room.extent(i, images[-1], foot)
                wavelength_m = sonar.acoustics.wavelength_m
                whole = size_share(wavelength_m, 1.0, half_m, half_m, far_m)
                return whole + 10 ** (room.floor_db[k] / 10)

            yield from _echo(room, sonar, over, images, foot, level_db, 2 * half_m, size=size)


def _ways_back(room, sonar, over, images, lost_db):
    for i, (a, b, k) in enumerate(room.segments):
        if not over or over[-1] == i:
            continue
        if cross(b - a, sonar.place - a) * cross(b - a, images[-1] - a) <= 0:
            continue
        c, d, _ = room.segments[over[-1]]
        if abs((d - c) @ (b - a)) < RIGHT * math.hypot(*(d - c)) * math.hypot(*(b - a)):
            continue  # all comes from the corner of the two
        beyond = image(images[-1], a, b)
        at = meeting(sonar.place, beyond, a, b)
        if at is not None:
            path_m = math.hypot(*(beyond - sonar.place))
            level_db = lost_db + room.mirror_db[k]
            back_m = math.hypot(*(at - sonar.place))
            normal = np.array([b[1] - a[1], a[0] - b[0]]) / math.hypot(*(b - a))
            cos = abs(normal @ (at - sonar.place)) / back_m

            def size(i=i, at=at, cos=cos, back_m=back_m, path_m=path_m):
                far_m = room.extent(i, images[-1], at)
                return size_share(sonar.acoustics.wavelength_m, cos, path_m - back_m, back_m, far_m)

            yield from _echo(room, sonar, over, images, at, level_db, path_m, back=at, size=size)


def _corners(room, sonar, over, images, lost_db):
    for place, arms in room.vertices:
        back = images[-1] - place
        half_m = math.hypot(*back)
        turns = [(math.atan2(cross(way, back), way @ back) % math.tau, way, i) for way, i in arms]
        right = min(turns, key=lambda turn: turn[0])
        left = min(turns, key=lambda turn: -turn[0] % math.tau)
        opening = right[0] + (-left[0] % math.tau)
        if right[1] @ left[1] < 0 and abs(cross(right[1], left[1])) < 1e-3:
            continue
        one, other = (room.mirror_db[room.segments[turn[2]][2]] for turn in (right, left))
        size = None
        if opening < math.pi:
            if abs(right[1] @ left[1]) >= RIGHT:
                continue
            level_db = one + other

            def size(right=right, left=left, place=place, back=back, half_m=half_m):
                wide_m = min(
                    room.reach(place, turn[1], other[1]) * abs(cross(turn[1], back / half_m))
                    for turn, other in ((right, left), (left, right))
                )
                return size_share(sonar.acoustics.wavelength_m, 1.0, half_m, half_m, [wide_m] * 2)
        else:
            # The face that is seen; of two that with the lower number.
            seen = [turn for turn in (right, left) if cross(turn[1], back) * (
                1 if turn is right else -1) > 0]  # fmt: skip
            face = min(turn[2] for turn in seen)
            level_db = room.mirror_db[room.segments[face][2]]
            level_db += sonar.acoustics.edge_db - 20 * math.log10(max(half_m, 0.01))
        level_db += 2 * lost_db
        yield from _echo(room, sonar, over, images, place, level_db, 2 * half_m, size=size)


def _pillars(room, sonar, over, images, lost_db):
    for centre, radius_m, k in room.pillars:
        way = centre - images[-1]
        half_m = math.hypot(*way) - radius_m
        if half_m <= 0:
            continue
        share_db = max(10 * math.log10(radius_m / (radius_m + half_m)), room.floor_db[k])
        level_db = 2 * lost_db + room.mirror_db[k] + share_db
        foot = images[-1] + way * half_m / (half_m + radius_m)
        yield from _echo(room, sonar, over, images, foot, level_db, 2 * half_m)


def _scattered(room, sonar, bounces, first):
    """Return the first of what is scattered: rays in steps of 0.02 degrees are mirrored on."""
    bearings = np.radians(np.arange(-40, 40.001, 0.02))
    angle = sonar.axis_rad + bearings
    places = np.tile(sonar.place, (len(angle), 1))
    ways = np.column_stack([np.cos(angle), np.sin(angle)])
    sent_db = np.array([beam_db(sonar.acoustics, bearing) for bearing in bearings])
    path_m, lost_db = np.zeros(len(angle)), np.zeros(len(angle))
    round_ = {k for _, _, k in room.pillars}
    for mirrors in range(bounces + 1):
        hits = room.cast(places, ways, 20.0)
        met = np.isfinite(hits.distance_m) & ~np.isin(hits.surface, list(round_))
        places, ways, sent_db = places[met], ways[met], sent_db[met]
        normal, surface = hits.normal_xy[met], hits.surface[met]
        path_m, lost_db = path_m[met] + hits.distance_m[met], lost_db[met]
        cos = -(ways * normal).sum(axis=1)
        own_db = np.array(room.mirror_db)[surface]
        floor_db = np.array(room.floor_db)[surface]
        for i in np.flatnonzero(path_m < first[0]):
            level_db = mirror_echo_db(sonar.acoustics, 2 * path_m[i]) + 2 * sent_db[i]
            level_db += 2 * lost_db[i] + own_db[i] + floor_db[i]
            level_db += 20 * math.log10(max(cos[i], 1e-3))
            first = min(first, (sonar.crossing_m(2 * path_m[i], level_db), mirrors))
        places = places + ways * hits.distance_m[met][:, None] + 1e-6 * normal
        ways = ways + 2 * cos[:, None] * normal
        lost_db = lost_db + own_db
    return first
