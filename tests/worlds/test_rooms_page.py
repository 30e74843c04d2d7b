"""What docs/rooms.md shows is what there is."""

import dataclasses
import re
import tomllib
from pathlib import Path

import pytest

import worlds
from worlds.generation.base import Style
from worlds.readers.toml.schema import (
    BoxTable,
    MaterialTable,
    ParameterTable,
    PillarTable,
    StartTable,
    WallTable,
    WorldTable,
)

PAGE = (Path(__file__).parents[2] / "docs" / "rooms.md").read_text(encoding="utf-8")
WHOLE, MATERIAL, FORMULAS = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
(PYTHON,) = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def load(tmp_path, text, **parameters):
    (tmp_path / "room.toml").write_text(text, encoding="utf-8")
    return worlds.load(tmp_path / "room.toml", **parameters)


def test_the_room_of_the_page_is_a_room_beyond_doubt(tmp_path):
    world = load(tmp_path, WHOLE)
    assert [solid.name for solid in world.solids] == ["walls", "desk", "lamp"]
    assert world.notes == {"box[0].height_m": "assumed"}
    assert worlds.doubts(world) == ()


def test_materials_and_parameters_of_the_page_work(tmp_path):
    felt = load(tmp_path, WHOLE.replace('"drywall"', '"felt"') + MATERIAL).solids[0].material
    assert felt.reflectivity == 0.5
    rest = 'thickness_m = 0.02\nheight_m = 1\nmaterial = "wood"\n'
    head = 'title = ""\nsource = ""\nstart = { x_m = 0, y_m = 0, heading_deg = 0 }\n'
    board = load(tmp_path, head + FORMULAS + rest, gap_m=0.6).solids[0].outline
    assert board.bounds == pytest.approx((-1.5, 0.49, -0.3, 0.51))


@pytest.mark.parametrize(
    "table",
    [WorldTable, StartTable, WallTable, BoxTable, PillarTable, MaterialTable, ParameterTable],
)
def test_every_key_has_an_example(table):
    examples = "\n".join((WHOLE, MATERIAL, FORMULAS))
    for key in table.model_fields:
        assert re.search(rf"\b{key}\b( =|\]|\.)", examples), key


def test_every_style_and_parameter_is_on_the_page():
    shared = {each.name for each in dataclasses.fields(Style)}
    for name, style in worlds.styles().items():
        (row,) = re.findall(rf"^\| `{name}` \|.*$", PAGE, re.MULTILINE)
        own = {each.name for each in dataclasses.fields(style)} - shared
        if name != "clutter":  # whose are those of the room above it
            assert set(re.findall(r"`(\w+)`", row.split("|")[3])) == own
    for name in shared:
        assert f"`{name}`" in PAGE


def test_the_style_of_the_page_makes_rooms():
    names = {}
    exec(compile(PYTHON, "docs/rooms.md", "exec"), names)
    world = worlds.generate(names["Stairwell"](side_min_m=4.0), 3)
    assert world.name == "stairwell-0003"
    assert (
        tomllib.loads(worlds.plan(names["Stairwell"](), 1).to_toml())["wall"][1]["name"] == "core 1"
    )
