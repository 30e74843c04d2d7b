import math

import numpy as np
import pytest

import sonarmap as sm

PRESETS = ["amigobot", "amigobot-aria", "amigobot-h8", "pioneer3dx", "udacity8"]


def test_presets_are_found_by_name():
    assert set(PRESETS) <= set(sm.rings())
    assert sm.ring("amigobot") is sm.AMIGOBOT is sm.rings()["amigobot"]
    assert all(ring.name == name for name, ring in sm.rings().items())


def test_the_amigobot_is_that_of_the_thesis():
    ring = sm.AMIGOBOT
    assert len(ring) == 8
    assert (ring.range_min_m, ring.range_max_m) == (0.165, 3.0)
    assert ring.half_angle_rad == math.radians(15)
    # ARIA's amigo-sh.p: unit 2 at (144, 30) mm looks 15 degrees to the left.
    assert (ring.x_m[2], ring.y_m[2]) == (0.144, 0.030)
    assert ring.heading_rad[2] == math.radians(15)


@pytest.mark.parametrize("name", [name for name in PRESETS if name != "amigobot-aria"])
def test_rings_are_their_own_mirror_image(name):
    ring = sm.ring(name)

    def places(sign):
        sonars = np.column_stack([ring.x_m, sign * ring.y_m, sign * ring.heading_rad])
        return sorted(sonars.round(12).tolist())

    assert places(1) == places(-1)


def test_the_aria_preset_keeps_arias_lopsided_number():
    assert sm.ring("amigobot-aria").x_m[1] == 0.125
    assert sm.ring("amigobot-aria").x_m[4] == 0.120


def test_sonar_0_of_the_udacity_ring_looks_to_the_right():
    assert np.rad2deg(sm.ring("udacity8").heading_rad).round(9).tolist() == [
        -90, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90,
    ]  # fmt: skip


@pytest.mark.parametrize("name", PRESETS)
def test_a_ring_comes_back_from_its_dictionary(name):
    ring = sm.ring(name)
    back = sm.SonarRing.from_dict(ring.to_dict())
    assert back == ring
    assert hash(back) == hash(ring)


def test_rings_that_differ_in_anything_are_not_equal():
    fields = sm.AMIGOBOT.to_dict()
    for change in ({"range_max_m": 5.0}, {"name": "x"}, {"x_m": [0.0] * 8}):
        assert sm.SonarRing.from_dict(fields | change) != sm.AMIGOBOT
    assert sm.AMIGOBOT != "amigobot"


def test_a_ring_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        sm.AMIGOBOT.x_m[0] = 1.0
    with pytest.raises(TypeError):
        sm.rings()["mine"] = sm.AMIGOBOT


def test_an_unknown_ring_gets_a_hint():
    with pytest.raises(sm.InputError, match="ring 'amigobott' is unknown; did you mean 'amigobot'"):
        sm.ring("amigobott")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x_m": []}, r"x_m must be a list of finite numbers, got \[\]"),
        ({"x_m": [[0.0]]}, "x_m must be a list of finite numbers"),
        ({"y_m": [math.nan]}, r"y_m must be a list of finite numbers, got \[nan\]"),
        ({"heading_rad": ["left"]}, r"heading_rad must be a list of finite numbers, got \['left"),
        ({"y_m": [0, 1]}, "must have one value a sonar, got 1, 2 and 1"),
        ({"half_angle_rad": 0}, "half_angle_rad must be > 0, got 0"),
        ({"half_angle_rad": math.pi / 2}, "half_angle_rad must be < pi/2, got 1.57"),
        ({"range_min_m": -1}, "range_min_m must be >= 0, got -1"),
        ({"range_max_m": math.inf}, "range_max_m must be > 0, got inf"),
        ({"range_min_m": 3.0}, r"range_min_m must be < range_max_m, got 3\.0 and 3\.0"),
        ({"colour": "red"}, "ring: .*colour"),
    ],
)
def test_bad_rings_are_refused(change, message):
    fields = {
        "name": "one",
        "x_m": [0],
        "y_m": [0],
        "heading_rad": [0],
        "half_angle_rad": 0.2,
        "range_min_m": 0.1,
        "range_max_m": 3,
    }
    with pytest.raises(sm.InputError, match=message):
        sm.SonarRing.from_dict(fields | change)
