import math
from xml.etree import ElementTree

import pytest

from sim.robot import amigobot
from sim.robot.kinematics import limited_speeds


@pytest.fixture(scope="module")
def urdf():
    return ElementTree.parse(amigobot.urdf_path()).getroot()


def link(urdf, name):
    return urdf.find(f"link[@name='{name}']")


def numbers(text):
    return [float(number) for number in text.split()]


def test_body_collides_as_the_radius_that_aria_plans_with(urdf):
    cylinder = link(urdf, "body").find("collision/geometry/cylinder")
    assert float(cylinder.get("radius")) == amigobot.BODY_RADIUS_M
    middle = numbers(link(urdf, "body").find("collision/origin").get("xyz"))[2]
    half = float(cylinder.get("length")) / 2
    assert middle - half == pytest.approx(amigobot.GROUND_CLEARANCE_M)
    assert middle + half == pytest.approx(amigobot.BODY_HEIGHT_M)


def test_body_is_drawn_with_its_outer_dimensions(urdf):
    size = numbers(link(urdf, "body").find("visual/geometry/box").get("size"))
    assert size[:2] == [amigobot.BODY_LENGTH_M, amigobot.BODY_WIDTH_M]


@pytest.mark.parametrize(("side", "sign"), [("left", 1), ("right", -1)])
def test_wheels_stand_on_the_floor_one_track_apart(urdf, side, sign):
    origin = numbers(urdf.find(f"joint[@name='{side}_wheel_joint']/origin").get("xyz"))
    assert origin == [0, sign * amigobot.TRACK_M / 2, amigobot.WHEEL_RADIUS_M]
    shape = link(urdf, f"{side}_wheel").find("collision/geometry/sphere")
    assert float(shape.get("radius")) == amigobot.WHEEL_RADIUS_M


def test_caster_touches_the_floor_behind_the_axle(urdf):
    origin = numbers(urdf.find("joint[@name='caster_joint']/origin").get("xyz"))
    assert origin == [amigobot.CASTER_X_M, 0, amigobot.CASTER_RADIUS_M]
    shape = link(urdf, "caster").find("collision/geometry/sphere")
    assert float(shape.get("radius")) == amigobot.CASTER_RADIUS_M


def test_masses_add_up(urdf):
    total = sum(float(mass.get("value")) for mass in urdf.iter("mass"))
    assert total == pytest.approx(amigobot.MASS_KG)


@pytest.mark.parametrize(
    ("now", "wanted", "expected"),
    [
        # speeding up, forwards and backwards
        (0.0, 0.5, amigobot.ACCELERATION_MPS2 * 0.1),
        (0.0, -0.5, -amigobot.ACCELERATION_MPS2 * 0.1),
        # slowing down, and through zero, at the deceleration
        (0.5, 0.2, 0.5 - amigobot.DECELERATION_MPS2 * 0.1),
        (0.1, -0.5, 0.1 - amigobot.DECELERATION_MPS2 * 0.1),
        # the last step ends at the wanted speed
        (0.2, 0.201, 0.201),
    ],
)
def test_speed_changes_within_the_limits(now, wanted, expected):
    assert limited_speeds((now, now), (wanted, wanted), 0.1) == pytest.approx((expected, expected))


def test_too_fast_a_command_keeps_its_curve():
    left, right = limited_speeds((0.0, 0.0), (3.0, 2.9), 1e3)
    assert left == amigobot.SPEED_MAX_MPS
    assert left / right == pytest.approx(3 / 2.9)


def test_turns_are_limited_too():
    left, right = limited_speeds((0.0, 0.0), (-0.7, 0.7), 1e3)
    assert (right - left) / amigobot.TRACK_M == pytest.approx(amigobot.TURN_MAX_RADPS)
    assert left == -right


def test_scan_periods_are_whole_steps():
    for period_s in (0.175, 0.100, 0.040):
        steps = period_s / amigobot.PHYSICS_DT_S
        assert math.isclose(steps, round(steps))
