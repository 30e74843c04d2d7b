"""The simple cone against arithmetic. Rays are cast at the world's own faces: no engine."""

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from rooms import MIRROR, ROUGH, SOFT, box, closed_room, pillar, world

from sim import ConeSonar
from sim.sonar import presets as sonars
from sonarmap import Cause, InputError, SonarRing
from worlds import Material, Solid

AHEAD = SonarRing("ahead", [0], [0], [0], math.radians(15), 0.165, 3.0)
SHARP = ConeSonar("sharp", AHEAD, scan_period_s=0.1, rays=None, noise_std_m=0, quantum_m=0)


def listen(room, *, sonar=SHARP, at=(0.0, 0.0), axis_rad=0.0, rng=None):
    rng = np.random.default_rng(0) if rng is None else rng
    place, axis = np.array([at], float), np.array([axis_rad])
    return sonar.listen(room.faces, room, place, axis, rng)


def heard(room, **arguments):
    echoes = listen(room, **arguments)
    return echoes.range_m[0], Cause(echoes.cause[0])


def test_wall_ahead_is_read_at_its_distance():
    echoes = listen(world(box("wall", 1.0, -2, 1.1, 2)))
    assert echoes.range_m[0] == pytest.approx(1.0, abs=1e-12)
    assert echoes.axis_range_m[0] == echoes.cone_range_m[0] == pytest.approx(1.0, abs=1e-12)
    assert Cause(echoes.cause[0]) is Cause.DIRECT
    assert echoes.surface[0] == 0
    assert echoes.incidence_rad[0] == pytest.approx(0, abs=1e-6)
    assert echoes.bounces[0] == 0


@pytest.mark.parametrize("tilt_deg", [-14, -8.3, 3, 10, 14.9])
@pytest.mark.parametrize("material", [ROUGH, MIRROR])
def test_wall_tilted_inside_the_cone_reads_its_perpendicular_distance(tilt_deg, material):
    room = world(box("wall", 2.0, -3, 2.1, 3, material, turned_deg=tilt_deg))
    echoes = listen(room)
    assert echoes.range_m[0] == pytest.approx(2.0, abs=1e-12)
    # The nearest of 31 rays is at most half a degree off the foot of the perpendicular.
    fan = listen(room, sonar=SHARP.replace(rays=31))
    assert fan.range_m[0] == pytest.approx(2.0, abs=2 * (1 / math.cos(math.radians(0.5)) - 1))
    assert echoes.axis_range_m[0] == pytest.approx(2.0 / math.cos(math.radians(tilt_deg)))
    assert Cause(echoes.cause[0]) is Cause.DIRECT or abs(tilt_deg) > 13


def test_wall_tilted_beyond_the_cone_is_foreshortened_to_its_edge():
    tilt = math.radians(40)
    room = world(box("wall", 1.0, -3, 1.1, 3, turned_deg=40))
    reading, cause = heard(room)
    assert reading == pytest.approx(1.0 / math.cos(tilt - AHEAD.half_angle_rad))
    assert cause is Cause.OFF_AXIS


def test_mirror_tilted_beyond_its_critical_angle_is_lost():
    # Even the ray at the cone's edge meets it at 40 - 15 > 10 degrees.
    room = world(box("mirror", 1.0, -3, 1.1, 3, MIRROR, turned_deg=40))
    echoes = listen(room)
    assert echoes.range_m[0] == math.inf
    assert Cause(echoes.cause[0]) is Cause.DROPOUT
    assert echoes.surface[0] == -1
    assert math.isnan(echoes.incidence_rad[0])
    assert echoes.cone_range_m[0] == pytest.approx(1.0 / math.cos(math.radians(25)))


def test_nothing_in_range_is_out_of_range():
    assert heard(world(box("wall", 3.01, -2, 3.1, 2))) == (math.inf, Cause.OUT_OF_RANGE)


def test_empty_world_is_out_of_range():
    assert heard(world()) == (math.inf, Cause.OUT_OF_RANGE)


def test_wall_at_exactly_the_maximum_range_is_heard():
    reading, cause = heard(world(box("wall", 3.0, -0.01, 3.1, 0.01)))
    assert reading == pytest.approx(3.0)
    assert cause is Cause.DIRECT


def test_pillar_is_read_at_its_nearest_point():
    reading, cause = heard(world(pillar("post", 1.5, 0.0, 0.2)))
    assert reading == pytest.approx(1.3, abs=1e-12)
    assert cause is Cause.DIRECT


def test_pillar_beside_the_axis_is_off_axis():
    bearing = math.radians(10)
    post = pillar("post", 1.5 * math.cos(bearing), 1.5 * math.sin(bearing), 0.05)
    reading, cause = heard(world(post, box("wall", 2.5, -3, 2.6, 3)))
    assert reading == pytest.approx(1.45, abs=1e-9)
    assert cause is Cause.OFF_AXIS


def test_ghost_is_as_long_as_the_image_of_the_wall_behind_the_mirror():
    # A long mirror at 45 degrees sends the axis to the left, to a rough wall there.
    mirror = box("mirror", 1.0, -3, 1.1, 3, MIRROR, turned_deg=-45, about=(1.0, 0.0))
    wall = box("wall", 0.0, 1.5, 2.0, 1.6)
    echoes = listen(world(mirror, wall))
    # The image of the wall y = 1.5 in the mirror through (1, 0): the plane x = 2.5.
    assert echoes.range_m[0] == pytest.approx(2.5, abs=1e-12)
    assert Cause(echoes.cause[0]) is Cause.BOUNCE
    assert echoes.bounces[0] == 1
    assert echoes.surface[0] == 1
    assert echoes.axis_range_m[0] == pytest.approx(1.0)


def test_sound_is_followed_over_so_many_mirrors_and_no_more():
    mirror = box("mirror", 1.0, -3, 1.1, 3, MIRROR, turned_deg=-45, about=(1.0, 0.0))
    room = world(mirror, box("wall", 0.0, 1.5, 2.0, 1.6))
    assert heard(room, sonar=SHARP.replace(max_bounces=0)) == (math.inf, Cause.DROPOUT)


def test_farther_surface_in_place_of_a_lost_one_is_a_dropout():
    # On the axis a mirror that is lost; beside it, farther, something that answers.
    mirror = box("mirror", 1.0, -0.2, 1.01, 0.2, MIRROR, turned_deg=30, about=(1.0, 0.0))
    wall = box("wall", 2.0, -3, 2.1, 3)
    reading, cause = heard(world(mirror, wall), sonar=SHARP.replace(max_bounces=0))
    assert reading > 1.9
    assert cause is Cause.DROPOUT


def test_soft_surface_is_not_heard():
    assert heard(world(box("foam", 1.0, -2, 1.1, 2, SOFT))) == (math.inf, Cause.DROPOUT)


def test_too_close_is_minus_infinity():
    reading, cause = heard(world(box("wall", 0.1, -2, 0.2, 2)))
    assert reading == -math.inf
    assert cause is Cause.DIRECT


def test_readings_are_whole_quanta(rng):
    sonar = SHARP.replace(noise_std_m=0.01, quantum_m=0.001)
    room = world(box("wall", 1.0, -2, 1.1, 2))
    readings = np.array([listen(room, sonar=sonar, rng=rng).range_m[0] for _ in range(50)])
    assert readings * 1000 == pytest.approx(np.round(readings * 1000), abs=1e-9)
    assert np.unique(readings).size > 10


def test_noise_has_its_standard_deviation_and_sensors_differ(rng):
    eight = sonars.preset("thesis").replace(quantum_m=0, noise_std_m=0.01)
    room = closed_room(1.0)
    places, axes = np.zeros((8, 2)), np.zeros(8)
    errors = np.array(
        [eight.listen(room.faces, room, places, axes, rng).range_m - 1.0 for _ in range(1000)]
    )
    assert errors.mean(axis=0) == pytest.approx(np.zeros(8), abs=0.0015)
    assert errors.std(axis=0) == pytest.approx(np.full(8, 0.01), rel=0.1)
    assert np.abs(np.corrcoef(errors.T) - np.eye(8)).max() < 0.12


def test_rough_surface_adds_its_roughness_to_the_noise(rng):
    coarse = Material("coarse", math.pi / 2, 1.0, 0.012)
    room = world(box("wall", 1.0, -2, 1.1, 2, coarse))
    sonar = SHARP.replace(noise_std_m=0.005)
    readings = np.array([listen(room, sonar=sonar, rng=rng).range_m[0] for _ in range(2000)])
    assert readings.std() == pytest.approx(0.013, rel=0.06)  # 5, 12, 13


def test_noise_drawn_does_not_depend_on_what_is_heard():
    one, other = np.random.default_rng(5), np.random.default_rng(5)
    listen(world(box("wall", 1.0, -2, 1.1, 2)), rng=one)
    listen(world(box("wall", 4.0, -2, 4.1, 2)), rng=other)
    assert one.random() == other.random()


def literal_fan(room, sonar, at, axis_rad):
    """Trace each ray by itself with plain shapely geometry; return the first return."""
    returns = []
    half = sonar.ring.half_angle_rad
    for bearing in np.linspace(-half, half, sonar.rays):
        angle = axis_rad + bearing
        found = follow(room, sonar, np.array(at), np.array([math.cos(angle), math.sin(angle)]))
        if found is not None:
            returns.append(found)
    return min(returns, default=(math.inf, 0), key=lambda path: path[0])


def follow(room, sonar, place, direction):
    travelled, strength = 0.0, 1.0
    for bounce in range(sonar.max_bounces + 1):
        met = first_surface(room, place, direction, sonar.ring.range_max_m - travelled)
        if met is None:
            return None
        distance, normal, solid = met
        travelled += distance
        strength *= solid.material.reflectivity
        if strength < sonar.threshold:
            return None
        incidence = math.acos(min(1.0, -float(direction @ normal)))
        if incidence <= solid.material.critical_incidence_rad:
            return travelled, bounce
        place = place + distance * direction + 1e-6 * normal
        direction = direction - 2 * (direction @ normal) * normal
    return None


def first_surface(room, place, direction, reach):
    best = None
    for solid in room.solids:
        corners = np.array(solid.outline.exterior.coords)
        for a, b in pairwise(corners):
            along = b - a
            determinant = direction[0] * -along[1] + along[0] * direction[1]
            if abs(determinant) < 1e-15:
                continue
            gap = a - place
            distance = (gap[0] * -along[1] + along[0] * gap[1]) / determinant
            share = (direction[0] * gap[1] - direction[1] * gap[0]) / determinant
            if distance > 1e-12 and 0 <= share <= 1 and distance <= reach:
                normal = np.array([along[1], -along[0]]) / math.hypot(*along)
                normal = -normal if normal @ direction > 0 else normal
                if best is None or distance < best[0]:
                    best = (distance, normal, solid)
    return best


def test_compiled_rays_equal_a_plain_walk_from_surface_to_surface(rng):
    materials = [MIRROR, ROUGH, SOFT, Material("half", math.radians(30), 0.6, 0.0)]
    fan, heard_bounce = SHARP.replace(rays=31), 0
    for _ in range(40):
        solids = []
        for index in range(8):
            x, y = rng.uniform(-2, 2, 2)
            if math.hypot(x, y) < 0.6:
                continue
            outline = shapely.affinity.rotate(
                shapely.box(x - 0.4, y - 0.1, x + 0.4, y + 0.1), rng.uniform(0, 360)
            )
            if outline.distance(shapely.Point(0, 0)) > 0.2:
                solids.append(Solid(f"s{index}", materials[index % 4], 1.0, outline))
        room = world(*solids)
        axis = rng.uniform(-math.pi, math.pi)
        echoes = listen(room, sonar=fan, axis_rad=axis)
        distance, bounce = literal_fan(room, fan, (0.0, 0.0), axis)
        assert echoes.range_m[0] == pytest.approx(distance, abs=1e-9)
        assert echoes.bounces[0] == bounce
        heard_bounce += bounce > 0
    assert heard_bounce > 0  # or the scenes have become too easy


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rays": 30}, r"rays must be odd and >= 3, got 30"),
        ({"rays": 1}, r"rays must be odd and >= 3, got 1"),
        ({"max_bounces": -1}, r"max_bounces must be >= 0, got -1"),
        ({"noise_std_m": -0.1}, r"noise_std_m must be >= 0, got -0.1"),
        ({"quantum_m": math.nan}, r"quantum_m must be >= 0, got nan"),
        ({"scan_period_s": 0}, r"scan_period_s must be > 0, got 0"),
        ({"threshold": -1}, r"threshold must be >= 0, got -1"),
    ],
)
def test_bad_settings_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        SHARP.replace(**changes)


def test_presets_are_those_of_the_robots():
    thesis, aria = sonars.preset("thesis"), sonars.preset("aria")
    assert (thesis.ring.range_min_m, thesis.ring.range_max_m) == (0.165, 3.0)
    assert (aria.ring.range_min_m, aria.ring.range_max_m) == (0.10, 5.0)
    assert math.degrees(2 * thesis.ring.half_angle_rad) == pytest.approx(30)
    with pytest.raises(InputError, match=r"sonar 'thesys' is unknown; did you mean 'thesis'\?"):
        sonars.preset("thesys")
