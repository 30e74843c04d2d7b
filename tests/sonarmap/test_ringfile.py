import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import sonarmap as sm

RING = """\
name = "two eyes"
source = "measured with a ruler"
half_angle_deg = 7.5
range_min_m = 0.02
range_max_m = 4

[[sonar]]
x_m = 0.1
y_m = 0.05
heading_deg = 45

[[sonar]]
x_m = 0.1
y_m = -0.05
heading_deg = -45.5
"""


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "mine.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return sm.ring(path)

    return read


def test_every_key_of_a_file_reaches_the_ring(read):
    ring = read(RING)
    assert ring.name == "two eyes"
    assert ring.x_m.tolist() == [0.1, 0.1]
    assert ring.y_m.tolist() == [0.05, -0.05]
    assert ring.heading_rad.tolist() == [math.radians(45), math.radians(-45.5)]
    assert ring.half_angle_rad == math.radians(7.5)
    assert (ring.range_min_m, ring.range_max_m) == (0.02, 4.0)


def test_a_ring_without_a_name_is_called_after_its_file(read):
    assert read(RING.replace('name = "two eyes"\n', "")).name == "mine"


def test_a_path_is_told_from_a_name(tmp_path, monkeypatch, read):
    ring = read(RING)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "no-suffix").write_text(RING, encoding="utf-8")
    (tmp_path / "amigobot").write_text(RING, encoding="utf-8")
    assert sm.ring("mine.toml") == sm.ring("./mine.toml") == sm.ring("./no-suffix") == ring
    assert sm.ring("amigobot") is sm.AMIGOBOT
    assert sm.ring("./amigobot") == ring
    with pytest.raises(sm.InputError, match=r"^gone\.toml: no such file$"):
        sm.ring("gone.toml")
    with pytest.raises(sm.InputError, match="ring must be a name, got 7"):
        sm.ring(7)


@pytest.mark.parametrize("name", sm.rings())
def test_every_preset_comes_back_from_its_file(name, tmp_path):
    sm.ring(name).write(tmp_path / "ring.toml", source='ARIA "params"')
    assert sm.ring(tmp_path / "ring.toml") == sm.ring(name)
    text = (tmp_path / "ring.toml").read_text(encoding="utf-8")
    assert tomllib.loads(text)["source"] == 'ARIA "params"'


def test_any_ring_comes_back_within_rounding(tmp_path):
    rng = np.random.default_rng(3)
    for n in (1, 2, 16, 60):
        ring = sm.SonarRing(
            'ein "Ring"\n\x7f ü', *rng.normal(size=(2, n)), rng.uniform(-np.pi, np.pi, n), 0.2, 0, 3
        )
        ring.write(tmp_path / "ring.toml")
        back = sm.ring(tmp_path / "ring.toml")
        assert back.name == ring.name
        assert (back.x_m.tolist(), back.y_m.tolist()) == (ring.x_m.tolist(), ring.y_m.tolist())
        np.testing.assert_allclose(back.heading_rad, ring.heading_rad, rtol=1e-15)


def test_a_log_imported_with_a_ring_of_ones_own_file_has_it(tmp_path, read):
    ring = read(RING)
    log = sm.SonarLog(ring, [0, 0], [0, 1], [0, 0], [0, 0], [0, 0], [0, 0], [1.0, np.inf])
    log.write(tmp_path / "log.parquet")
    assert sm.read_log(tmp_path / "log.parquet").ring == ring


def test_hc_sr04_arrays_have_the_data_sheets_numbers():
    for name, sonars in (("hc-sr04-3", 3), ("hc-sr04-8", 8)):
        ring = sm.ring(name)
        assert len(ring) == sonars
        assert 2 * ring.half_angle_rad == math.radians(15)
        assert (ring.range_min_m, ring.range_max_m) == (0.02, 4.0)
        # Each looks outwards.
        outwards = ring.x_m * np.cos(ring.heading_rad) + ring.y_m * np.sin(ring.heading_rad)
        assert (outwards > 0.09).all()


# What stands in the file, what stands there instead, and what is said about it.
FAULTS = [
    ("half_angle_deg", "half_angle_dg", "half_angle_dg: unknown key; did you mean"),
    ("half_angle_deg", "half_angle_rad", "half_angle_rad: unknown key"),
    ("y_m = -0.05", "y_mm = -50", "sonar[1].y_mm: unknown key; did you mean 'y_m'?"),
    ("y_m = -0.05\n", "", "sonar[1].y_m: this key is missing"),
    ("range_max_m = 4\n", "", "range_max_m: this key is missing"),
    ('"two eyes"', "7", "name: must be a text, got 7"),
    ("= 7.5", '= "7.5"', "half_angle_deg: must be a finite number, got '7.5'"),
    ("= 7.5", "= true", "half_angle_deg: must be a finite number, got True"),
    ("= 7.5", "= inf", "half_angle_deg: must be a finite number, got inf"),
    ("= 7.5", "= 90", "half_angle_deg: must be within (0, 90), got 90"),
    ("= 7.5", "= 0", "half_angle_deg: must be within (0, 90), got 0"),
    ("= 0.02", "= 4", "range_min_m: must be >= 0 and < range_max_m, got 4 and 4"),
    ("= 0.02", "= -1", "range_min_m: must be >= 0 and < range_max_m, got -1 and 4"),
    ("x_m = 0.1", "x_m = 100", "sonar[0].x_m: must be metres, at most 10, got 100"),
    ("= 45", "= 450", "sonar[0].heading_deg: must be within [-360, 360], got 450"),
    ("= 45", "= 1" + "0" * 400, "sonar[0].heading_deg: must be a finite number, got 1000"),
    ("[[sonar]]", "[[sonars]]", "sonars: unknown key; did you mean 'sonar'?"),
    (RING[RING.index("[[sonar]]") :], "", "sonar: this key is missing"),
    (RING[RING.index("[[sonar]]") :], "sonar = []", "sonar: must be one [[sonar]] table or more"),
    (RING[RING.index("[[sonar]]") :], "sonar = [3]", "sonar[0]: must be a table, got 3"),
    ("= 7.5", "7.5", "is not TOML: "),
]  # fmt: skip


@pytest.mark.parametrize(("part", "instead", "complaint"), FAULTS)
def test_a_fault_is_reported_with_file_place_and_rule(read, part, instead, complaint):
    with pytest.raises(sm.InputError, match=rf"mine\.toml: {re.escape(complaint)}"):
        read(RING.replace(part, instead))


def test_a_picture_is_no_ring(read):
    with pytest.raises(sm.InputError, match=r"mine\.toml: is not a text file"):
        read(b"\x89PNG\xff\xfe")
    with pytest.raises(sm.InputError, match=r"mine\.toml: is not TOML"):
        read("a = " + "[" * 5000)


def test_mutated_files_are_rings_or_refused(read):
    rng = np.random.default_rng(7)
    bits = [b"[[", b"]", b'"', b"=", b"\n", b"-", b"1e999", b"nan", b"{", b"\xff", b"sonar", b"0"]
    refused = 0
    for _ in range(300):
        text = bytearray(RING.encode())
        for _ in range(rng.integers(1, 5)):
            at = int(rng.integers(len(text)))
            end = at + int(rng.integers(0, 6))
            text[at:end] = bits[rng.integers(len(bits))] if rng.random() < 0.6 else b""
        try:
            assert isinstance(read(bytes(text)), sm.SonarRing)
        except sm.InputError:
            refused += 1
    assert 100 < refused < 300


def test_the_page_shows_every_ring_and_a_file_that_works(read):
    page = (Path(__file__).parents[2] / "docs" / "rings.md").read_text(encoding="utf-8")
    for name in sm.rings():
        assert f"`{name}`" in page
    (text,) = re.findall(r"^```toml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert len(read(text)) == 2
