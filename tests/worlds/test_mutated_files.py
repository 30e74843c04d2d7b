"""Whatever stands in a world file: it is a room, or refused in one line."""

import numpy as np
import pytest

import worlds
from sonarmap import InputError

BITS = [
    *("[[", "]", "]]", "{", '"', "'", "=", ",", "\n", "#", "-", ".", "=", "= 1 / 0", "e9", "1e999"),
    *("nan", "inf", "true", '"= gap"', '"= 2 ** 99"', "1979-05-27", "0", "-1", "9" * 30),
    *("wall", "box", "points_m", "closed", "\x00", "ü", "\ud7ff"),
]


def mutated(rng, text):
    lines = text.split("\n")
    for _ in range(rng.integers(1, 4)):
        i = int(rng.integers(len(lines)))
        kind = rng.integers(5)
        if kind == 0:
            del lines[i]
        elif kind == 1:
            lines.insert(i, lines[rng.integers(len(lines))])
        elif kind == 2:
            line, at = lines[i], int(rng.integers(len(lines[i]) + 1))
            lines[i] = line[:at] + BITS[rng.integers(len(BITS))] + line[at:]
        elif kind == 3:
            key, equals, _ = lines[i].partition(" = ")
            lines[i] = key + equals + BITS[rng.integers(len(BITS))]
        else:
            line, at = lines[i], int(rng.integers(len(lines[i]) + 1))
            lines[i] = line[:at] + line[at + int(rng.integers(1, 6)) :]
        lines = lines or [""]
    return "\n".join(lines)


@pytest.mark.parametrize("source", ["office", "opening-rig", "generated"])
def test_mutated_files_are_rooms_or_refused(source, tmp_path):
    if source == "generated":
        text = worlds.plan("room", 4).to_toml()
    else:
        from worlds.rooms import place_of

        text = place_of(source).path.read_text(encoding="utf-8")
    rng = np.random.default_rng(12)
    path = tmp_path / "room.toml"
    refused = 0
    for _ in range(100):
        path.write_text(mutated(rng, text), encoding="utf-8")
        try:
            world = worlds.load(path)
        except InputError as error:
            refused += 1
            assert str(path) in str(error)  # noqa: PT017 - either is fine
        else:
            worlds.doubts(world)
    assert 20 < refused < 100


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\x00",
        f"bounds_m = [{'9' * 5000}]",
        "[" * 4000,
        "a = " + "[" * 4000,
        "a = " + "{a = " * 2000,
        "[a.b]\n" * 50,
    ],
)
def test_what_is_no_room_at_all_is_refused(text, tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"room\.toml: "):
        worlds.load(path)


def test_a_number_too_large_for_a_float_is_refused(tmp_path):
    path = tmp_path / "room.toml"
    text = worlds.plan("room", 4).to_toml()
    path.write_text(text.replace("height_m = 2.5", f"height_m = 1{'0' * 400}"), encoding="utf-8")
    with pytest.raises(InputError, match=r"wall\[0\]\.height_m: must be a finite number"):
        worlds.load(path)
