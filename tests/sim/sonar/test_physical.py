"""The physical sonar against theory. Rays are cast at the world's own faces: no engine."""

import math

import numpy as np
import pytest
from rooms import MIRROR, box, closed_room, pillar, world

from sim import (
    AllAtOnce,
    Eeruf,
    Interferer,
    InTurn,
    PhysicalSonar,
    Piston,
    Receiver,
    TransducerSpread,
)
from sim.sonar import presets as sonars
from sim.sonar.air import Air
from sonarmap import AMIGOBOT, Cause, InputError, LogTruth, SonarRing
from worlds import Material

AHEAD = SonarRing("ahead", [0], [0], [0], math.radians(15), 0.1, 5.0)
# Exact in all that theory does not speak of: no noise, no steps, no late crossing.
PLAIN = Receiver(38.0, 1.0, 1e-9, 0.58e-3, noise_std_m=0, weak_noise_std_m=0, quantum_m=0)
ALIKE = TransducerSpread(0.0, 0.0)
SHARP = PhysicalSonar("sharp", AHEAD, AllAtOnce(0.1), receiver=PLAIN, spread=ALIKE)
LOUD = SHARP.replace(receiver=Receiver(56.0, 1.0, 1e-9, 0.58e-3, 0, 0, 0))
BRICK = Material("brick", math.radians(55), 1.0, 0.0, diffuse_floor_db=-20)


def wall(distance_m=2.0, tilt_deg=0.0, material=MIRROR, half_m=30.0):
    return box("wall", distance_m, -half_m, distance_m + 0.1, half_m, material, turned_deg=tilt_deg)


def listen(room, *, sonar=SHARP, at=(0.0, 0.0), axis_deg=0.0, rng=None):
    array = sonar.array(room.faces, room, np.random.default_rng(0) if rng is None else rng)
    array.fire(0.0, (0,), np.array([at], float), np.radians([axis_deg]))
    return array.detect()


def heard(room, **arguments):
    return listen(room, **arguments).range_m[0]


# 1. A plane.


@pytest.mark.parametrize("tilt_deg", [-10.5, -7, -0.3, 0, 2.2, 9.9, 17.2])
def test_tilted_plane_reads_its_perpendicular_distance(tilt_deg):
    sonar = SHARP.replace(receiver=Receiver(40.0, 1.0, 1e-9, 0, 0, 0, 0))
    echoes = listen(world(wall(2.0, tilt_deg)), sonar=sonar)
    assert echoes.range_m[0] == pytest.approx(2.0, abs=1e-6)
    assert echoes.incidence_rad[0] == pytest.approx(0, abs=1e-6)
    assert (echoes.bounces[0], echoes.source[0], echoes.surface[0]) == (0, 0, 0)
    # Two-way beam at the tilt, under the dynamic range; the mirror loses nothing.
    expected_db = 40.0 + 2 * Piston().level_db(math.radians(tilt_deg))
    assert echoes.level_db[0] == pytest.approx(expected_db, abs=0.1)


def test_lobes_and_dead_bands_of_a_plane_end_at_42_degrees():
    tilts = np.arange(0, 60, 0.25)
    room = world(wall(2.0, half_m=300))
    echo = np.array([np.isfinite(heard(room, sonar=LOUD, axis_deg=tilt)) for tilt in tilts])
    assert tilts[echo].max() == pytest.approx(42, abs=2)
    # Dead bands lie between the lobes, where the beam there and back falls below -56 dB.
    starts = tilts[1:][np.diff(echo.astype(int)) == -1]
    assert starts == pytest.approx([12.1, 22.3, 32.6, 42.4], abs=0.4)
    for null_deg in (12.7, 23.7, 36):
        assert not echo[np.argmin(np.abs(tilts - null_deg))]


@pytest.mark.parametrize("dynamic_range_db", [20, 30, 36, 48])
def test_arc_of_constant_depth_is_as_wide_as_the_level_allows(dynamic_range_db):
    sonar = SHARP.replace(receiver=Receiver(dynamic_range_db, 1.0, 1e-9, 0, 0, 0, 0))
    limit = {20: 9.0, 30: 10.4, 36: 18.3, 48: 29.7}[dynamic_range_db]
    room = world(wall(2.0, half_m=100))
    assert heard(room, sonar=sonar, axis_deg=limit - 0.4) == pytest.approx(2.0, abs=1e-6)
    assert heard(room, sonar=sonar, axis_deg=limit + 0.6) == math.inf


def test_useful_cone_narrows_with_range():
    sonar = SHARP.replace(receiver=Receiver(weak_noise_std_m=0))
    angles = np.arange(0, 13, 0.1)

    def width_deg(distance_m):
        room = world(wall(distance_m, half_m=100))
        lost = [heard(room, sonar=sonar, axis_deg=angle) == math.inf for angle in angles]
        return angles[np.argmax(lost)]

    widths = [width_deg(distance_m) for distance_m in (0.5, 1.5, 3.0, 4.5)]
    assert (np.diff(widths) < 0).all()


def test_weak_echoes_read_slightly_long():
    sonar = SHARP.replace(receiver=Receiver(38, 1.0, noise_std_m=0, weak_noise_std_m=0))
    room = world(wall(2.0))
    strong, weak = (heard(room, sonar=sonar, axis_deg=angle) for angle in (0, 10.5))
    level_db = listen(room, sonar=sonar, axis_deg=10.5).level_db[0]
    assert 2.0 <= strong < 2.002
    assert weak - 2.0 == pytest.approx(0.0556 * 10 ** (-level_db / 20), abs=1e-3)
    assert 0.005 < weak - 2.0 < 0.056


# 2. A corner.


@pytest.mark.parametrize("bearing_deg", [-9, -4.4, 0, 5, 9])
@pytest.mark.parametrize("turned_deg", [0, 20])
def test_corner_reads_the_distance_of_its_vertex_as_loud_as_a_plane(bearing_deg, turned_deg):
    vertex = 2.0
    room = world(
        box("a", vertex, -3, vertex + 0.1, 0, MIRROR, turned_deg=-45 + turned_deg, about=(2, 0)),
        box("b", vertex, 0, vertex + 0.1, 3, MIRROR, turned_deg=45 + turned_deg, about=(2, 0)),
    )
    # No side lobes: they would hear the faces beside.
    sonar = SHARP.replace(receiver=Receiver(34, 1.0, 1e-9, 0, 0, 0, 0))
    corner = listen(room, sonar=sonar, axis_deg=-bearing_deg)
    plane = listen(world(wall(vertex)), sonar=sonar, axis_deg=-bearing_deg)
    assert corner.range_m[0] == pytest.approx(vertex, abs=1e-6)
    assert corner.level_db[0] == pytest.approx(plane.level_db[0], abs=0.1)
    assert corner.bounces[0] == 0


# 3. Edges and pillars.


def edge(distance_m):
    corner = box("edge", distance_m, 0, distance_m + 2, 2, MIRROR, turned_deg=-45,
                 about=(distance_m, 0))  # fmt: skip
    return world(corner)


def test_edge_falls_with_the_square_of_the_distance():
    levels = []
    for distance_m in (0.5, 1.0, 2.0):
        sonar = SHARP.replace(
            receiver=Receiver(60, 0.0, 1e-9, 0, 0, 0, 0), air=Air(humidity_percent=0)
        )
        level_db = listen(edge(distance_m), sonar=sonar).level_db[0]
        levels.append(level_db + 2 * sonar.air.absorption_db_per_m(49_400) * distance_m)
        plane_db = listen(world(wall(distance_m)), sonar=sonar).level_db[0]
        assert level_db - plane_db == pytest.approx(-37 - 20 * math.log10(distance_m), abs=1e-4)
    assert np.diff(levels) == pytest.approx([-40 * math.log10(2)] * 2, abs=1e-4)


@pytest.mark.parametrize("radius_m", [0.02, 0.05, 0.10])
@pytest.mark.parametrize("distance_m", [0.5, 1.0, 2.0])
def test_level_of_a_pillar_is_that_of_theory(radius_m, distance_m):
    echoes = listen(world(pillar("post", distance_m + radius_m, 0, radius_m, MIRROR)))
    plane_db = listen(world(wall(distance_m))).level_db[0]
    expected_db = 20 * math.log10(math.sqrt(radius_m / (radius_m + distance_m)))
    assert echoes.level_db[0] - plane_db == pytest.approx(expected_db, abs=1.0)
    assert echoes.range_m[0] == pytest.approx(distance_m, abs=1e-6)


# 4. Ways over mirrors.


@pytest.mark.parametrize("slant_deg", [40, 45, 52.5])
def test_ghost_over_a_mirror_is_as_long_as_the_image(slant_deg):
    # A mirror through (1, 0) sends the axis aside, to a wall perpendicular to what it sends.
    mirror = box("mirror", 1.0, -3, 1.1, 3, MIRROR, turned_deg=-slant_deg, about=(1.0, 0.0))
    aside = math.radians(180 - 2 * slant_deg)
    there = 1.0 + 1.5 * np.array([math.cos(aside), math.sin(aside)]) * [1, 1] - [0, 1.0]
    wall = box("wall", there[0], there[1] - 1, there[0] + 0.1, there[1] + 1, MIRROR,
               turned_deg=math.degrees(aside), about=tuple(there))  # fmt: skip
    echoes = listen(world(mirror, wall))
    # Unfolded: 1 m to the mirror and 1.5 m on.
    assert echoes.range_m[0] == pytest.approx(2.5, abs=1e-4)
    assert Cause(echoes.cause[0]) is Cause.BOUNCE
    assert (echoes.bounces[0], echoes.surface[0]) == (1, 1)
    assert heard(world(mirror, wall), sonar=SHARP.replace(max_bounces=0)) == math.inf


def test_way_that_comes_back_at_another_bearing_is_exact():
    # Two mirrors at 80 degrees: the image of the image lies 2 r sin(80) away from the sonar.
    room = world(
        box("a", 1.5, -1, 1.6, 0, MIRROR, turned_deg=-50, about=(1.5, 0)),
        box("b", 1.5, 0, 1.6, 1, MIRROR, turned_deg=50, about=(1.5, 0)),
    )
    echoes = listen(room, sonar=LOUD.replace(edge_db=-200))
    assert echoes.range_m[0] == pytest.approx(1.5 * math.sin(math.radians(80)), abs=1e-6)
    assert echoes.bounces[0] == 1
    assert Cause(echoes.cause[0]) is Cause.BOUNCE


def test_blocked_way_is_not_heard():
    mirror = box("mirror", 1.0, -3, 1.1, 3, MIRROR, turned_deg=-45, about=(1.0, 0.0))
    target = box("wall", 0.0, 1.5, 2.0, 1.6, MIRROR)
    free = world(mirror, target)
    screen = box("screen", 0.95, 0.7, 1.05, 0.75, MIRROR, turned_deg=30, about=(1.0, 0.7))
    assert heard(free) == pytest.approx(2.5, abs=1e-6)
    assert heard(world(mirror, target, screen)) != pytest.approx(2.5, abs=0.3)


# What scatters.


def test_rough_wall_is_heard_where_a_mirror_is_silent():
    room_of = lambda material: world(wall(1.5, 40, material))  # noqa: E731
    assert heard(room_of(MIRROR)) == math.inf
    echoes = listen(room_of(BRICK))
    # Heard within the main lobe's upper part: nearer than on the axis, not at the foot.
    assert (
        1.5 / math.cos(math.radians(40 - 9)) < echoes.range_m[0] < 1.5 / math.cos(math.radians(40))
    )
    assert math.degrees(echoes.incidence_rad[0]) == pytest.approx(35, abs=5)


@pytest.mark.parametrize("axis_deg", [0, 13, 31, 44, 62, 80, 100, 155])
def test_reading_does_not_depend_on_the_number_of_rays(axis_deg):
    room = world(
        box("brick", 2.9, -1.1, 3.0, 2.0, BRICK, turned_deg=10),
        box("mirror", -3.0, 2.4, 2.5, 2.5, MIRROR),
        box("carton", 1.0, 2.0, 1.5, 2.3, BRICK, turned_deg=25),
        pillar("post", 0.2, 2.0, 0.1, MIRROR),
        box("far", -2.5, 1.0, -2.4, 2.0, BRICK, turned_deg=15),
    )
    coarse, fine = (
        listen(
            room,
            axis_deg=axis_deg,
            sonar=SHARP.replace(
                receiver=Receiver(noise_std_m=0, weak_noise_std_m=0, quantum_m=0),
                search="rays",
                ray_step_rad=math.radians(step_deg),
            ),
        )
        for step_deg in (1.0, 0.1)
    )
    if np.isfinite(fine.range_m[0]):
        assert coarse.range_m[0] == pytest.approx(fine.range_m[0], abs=0.005)
    else:
        assert coarse.range_m[0] == fine.range_m[0]


# 5. Air.


def test_cold_air_makes_ranges_long():
    cold = heard(world(wall(3.0)), sonar=SHARP.replace(air=Air(10.0)))
    assert cold / 3.0 - 1 == pytest.approx(0.0175, abs=0.0005)


# Receiver.


def test_noise_is_that_of_a_real_robot_and_grows_as_the_level_falls(rng):
    sonar = SHARP.replace(receiver=Receiver(quantum_m=0))
    room = world(wall(2.0))
    strong, weak = (
        np.array([heard(room, sonar=sonar, axis_deg=angle, rng=rng) for _ in range(1500)])
        for angle in (0, 11)
    )
    assert strong.std() == pytest.approx(0.001, rel=0.08)
    assert weak.std() > 1.2 * strong.std()


def test_echo_that_is_over_before_the_receiver_opens_is_not_heard():
    sonar = SHARP.replace(receiver=Receiver(blanking_s=2.38e-3, noise_std_m=0, quantum_m=0))
    blind_m = 2.38e-3 * 343.2 / 2
    assert heard(world(wall(0.3)), sonar=sonar) == math.inf
    # Its end still sounds when the receiver opens.
    assert heard(world(wall(0.38)), sonar=sonar) == pytest.approx(blind_m, abs=2e-3)
    assert heard(world(wall(0.45)), sonar=sonar) == pytest.approx(0.45, abs=2e-3)


def test_too_close_is_minus_infinity():
    sonar = SHARP.replace(receiver=Receiver(blanking_s=0, noise_std_m=0))
    assert heard(world(wall(0.08)), sonar=sonar) == -math.inf


def test_silence_has_no_source_and_no_level():
    echoes = listen(world())
    assert echoes.range_m[0] == math.inf
    assert Cause(echoes.cause[0]) is Cause.OUT_OF_RANGE
    assert (echoes.source[0], echoes.surface[0]) == (LogTruth.NO_SOURCE, -1)
    assert math.isnan(echoes.level_db[0])


# 9. The sound of others.


def pair(*, firing, receiver=None, **changes):
    """Two sonars side by side that look the same way."""
    ring = SonarRing("pair", [0, 0], [0.05, -0.05], [0, 0], math.radians(15), 0.1, 5.0)
    receiver = Receiver(90, 1.0, 1e-9, 0, 0, 0, 0) if receiver is None else receiver
    return PhysicalSonar("pair", ring, firing, receiver=receiver, **changes)


def test_way_longer_than_a_slot_is_read_as_the_ghost_of_arithmetic():
    # The face is 7.5 m away: 15 m of way, heard in the next sonar's slot.
    sonar, room = pair(firing=InTurn(0.040, (0, 1))), world(wall(7.5, half_m=30))
    array = sonar.array(room.faces, room, np.random.default_rng(0))
    places = np.column_stack([sonar.ring.x_m, sonar.ring.y_m])
    for sonar_number in (0, 1):
        array.fire(0.040 * sonar_number, (sonar_number,), places, np.zeros(2))
    echoes = array.detect()
    ghost_m = (math.hypot(15.0, 0.1) - 343.2 * 0.040) / 2
    assert echoes.range_m[0] == math.inf
    assert echoes.range_m[1] == pytest.approx(ghost_m, abs=0.005)
    assert Cause(echoes.cause[1]) is Cause.CROSSTALK
    assert (echoes.source[1], echoes.surface[1]) == (0, 0)


def test_all_at_once_one_hears_the_others_sound():
    # Sonar 0 looks at the wall; sonar 1, turned away by 30 degrees, hears it in a side lobe.
    ring = SonarRing("two", [0, 0], [0, 0], np.radians([0, 29]), math.radians(15), 0.1, 5.0)
    sonar = PhysicalSonar("two", ring, AllAtOnce(0.1), receiver=Receiver(40, 1.0, quantum_m=0))
    room = world(wall(1.0))
    array = sonar.array(room.faces, room, np.random.default_rng(0))
    array.fire(0.0, (0, 1), np.zeros((2, 2)), ring.heading_rad)
    echoes = array.detect()
    assert [Cause(cause) for cause in echoes.cause] == [Cause.DIRECT, Cause.CROSSTALK]
    assert echoes.source.tolist() == [0, 0]
    assert echoes.range_m[1] == pytest.approx(1.0, abs=0.02)


def test_beacon_is_heard_as_an_outside_source():
    interferer = Interferer(3.0, 0.0, period_s=1.0, first_s=0.010)
    sonar = SHARP.replace(interferers=(interferer,))
    echoes = listen(world(), sonar=sonar)
    assert echoes.range_m[0] == pytest.approx((3.0 + 0.010 * 343.2) / 2, abs=1e-3)
    assert Cause(echoes.cause[0]) is Cause.CROSSTALK
    assert echoes.source[0] == LogTruth.OUTSIDE_SOURCE
    assert heard(world(wall(2.5, material=MIRROR)), sonar=sonar) == pytest.approx(2.5, abs=1e-3)
    screen = box("screen", 2.0, -0.1, 2.1, 0.1, MIRROR, turned_deg=30, about=(2.05, 0))
    assert listen(world(screen), sonar=sonar).source[0] != LogTruth.OUTSIDE_SOURCE


# Bad input.


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SHARP.replace(max_bounces=-1), r"max_bounces must be >= 0, got -1"),
        (lambda: SHARP.replace(edge_db=3), r"edge_db must be <= 0, got 3"),
        (lambda: SHARP.replace(edge_db=math.nan), r"edge_db must be a finite number, got nan"),
        (lambda: SHARP.replace(ray_step_rad=0), r"ray_step_rad must be > 0, got 0"),
        (lambda: SHARP.replace(sound_life_s=-1), r"sound_life_s must be > 0, got -1"),
        (lambda: SHARP.replace(firing=InTurn(order=(0, 1))), r"order\[1\] must be 0 to 0, got 1"),
        (lambda: SHARP.replace(firing=Eeruf(order=(0, 3))), r"order\[1\] must be 0 to 0, got 3"),
        (lambda: Receiver(0), r"dynamic_range_db must be > 0, got 0"),
        (lambda: Receiver(gain_share=1.1), r"gain_share must be within \[0, 1\], got 1.1"),
        (lambda: Receiver(pulse_s=0), r"pulse_s must be > 0, got 0"),
        (lambda: Receiver(blanking_s=-1), r"blanking_s must be >= 0, got -1"),
        (lambda: Receiver(noise_std_m=-1), r"noise_std_m must be >= 0, got -1"),
        (lambda: Receiver(weak_noise_std_m=math.nan), r"weak_noise_std_m must be >= 0, got nan"),
        (lambda: Receiver(quantum_m=-1), r"quantum_m must be >= 0, got -1"),
        (lambda: Interferer(0, 0, 0), r"period_s must be > 0, got 0"),
        (lambda: Interferer(math.nan, 0, 1), r"x_m must be a finite number, got nan"),
        (lambda: Material("m", 1.0, 0.5, 0.0, 1.0), r"diffuse_floor_db must be within \[-100, 0\]"),
        (lambda: sonars.preset("fysical"), r"sonar 'fysical' is unknown; .* 'physical'\?"),
    ],
)
def test_impossible_settings_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_webots_reads_the_maximum_where_every_ray_grazes():
    sonar = sonars.preset("webots").replace(ring=AHEAD)
    rng = np.random.default_rng(0)

    def read(room):
        return sonar.listen(room.faces, room, np.zeros((1, 2)), np.zeros(1), rng)

    assert read(world(wall(1.0, 20))).range_m[0] == pytest.approx(1.0, rel=0.005)
    lost = read(world(wall(1.0, 40)))
    assert lost.range_m[0] == 5.0
    assert Cause(lost.cause[0]) is Cause.DROPOUT
    # 22.5 degrees between the cone's edge and the normal: the last tilt that is heard.
    assert read(world(wall(1.0, 37.4))).range_m[0] < 5.0


def test_closed_room_is_heard_by_all():
    eight = PhysicalSonar("eight", AMIGOBOT, AllAtOnce(0.1))
    room = closed_room(1.5, BRICK)
    array = eight.array(room.faces, room, np.random.default_rng(0))
    places = np.column_stack([AMIGOBOT.x_m, AMIGOBOT.y_m])
    array.fire(0.0, tuple(range(8)), places, AMIGOBOT.heading_rad)
    assert np.isfinite(array.detect().range_m).all()


def test_single_transducers_do_not_hear_each_other():
    room, rng = world(wall(1.0)), np.random.default_rng(0)
    places, axes = np.zeros((3, 2)), np.radians([0, 29, 5])
    together = SHARP.listen(room.faces, room, places, axes, rng)
    alone = [listen(room, axis_deg=angle).range_m[0] for angle in (0, 29, 5)]
    assert together.range_m.tolist() == alone
    assert Cause.CROSSTALK not in together.cause
