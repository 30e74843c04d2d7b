"""Each method three ways, by hand."""

from itertools import product

import pytest

from sonarbed.studies.arena.entries import Entry
from sonarbed.studies.arena.methods import COLUMNS, best_of_each, each_method, firsts, method_rows
from sonarbed.studies.arena.table import Table

GROUPS = {"x": "shipped", "y": "shipped", "z": "generated"}


def rows_of(entry, losses, *, sheet=100.0):
    """Return the rows of an entry in rooms x, y and z, the same with both sonars."""
    return [
        {
            "entry": entry.label, "method": entry.method, "filter": entry.filter,
            "variant": entry.variant, "room": room, "group": GROUPS[room], "sonar": sonar,
            "loss_bits": loss, "sheet_loss_bits": sheet, "skill": 1 - loss / sheet,
            "tolerant_average_precision": 0.5, "f1_10_cm": 0.25, "seconds": 0.125,
        }
        for sonar, (room, loss) in product(("physical", "thesis"), zip(GROUPS, losses, strict=True))
    ]  # fmt: skip


@pytest.fixture
def table():
    return Table(
        [
            *rows_of(Entry("himm"), (90, 90, 90)),
            *rows_of(Entry("himm", variant="tuned"), (40, 80, 60)),
            *rows_of(Entry("himm", variant="logistic"), (70, 70, 70)),
            *rows_of(Entry("bki"), (50, 50, 50)),
            *rows_of(Entry("bki", variant="logistic"), (60, 60, 60)),
            *rows_of(Entry("himm", "hsr"), (1, 1, 1)),
        ]
    )


def test_a_method_stands_by_its_best_way(table):
    rows = [dict(zip(COLUMNS, row, strict=True)) for row in method_rows(table)]
    assert [row["method"] for row in rows] == ["bki", "himm"]
    first, second = rows
    assert first["as published"] == "**0.50 (0.50 to 0.50)**"
    assert first["tuned"] == "as published"
    assert first["tuned, with a logistic"] == "0.40 (0.40 to 0.40)"
    assert second["as published"].startswith("0.10")
    assert second["tuned"].startswith("**0.40")
    assert second["worst room"] == "0.20"
    assert (second["AP, 1 cell"], second["F1, 10 cm"], second["seconds"]) == (
        "0.50",
        "0.25",
        "0.12",
    )


def test_who_is_first_where(table):
    assert firsts(table) == {
        ("physical", "shipped"): ({"bki": 1, "himm (tuned)": 1}, 2),
        ("physical", "generated"): ({"bki": 1}, 1),
        ("thesis", "shipped"): ({"bki": 1, "himm (tuned)": 1}, 2),
        ("thesis", "generated"): ({"bki": 1}, 1),
    }


def test_filtered_entries_do_not_count(table):
    assert all("hsr" not in row[0] for row in method_rows(table))


def test_a_room_without_walls_has_no_first(table):
    hidden = [{**row, "skill": None} if row["room"] == "z" else row for row in table.rows]
    assert firsts(Table(hidden))["physical", "generated"] == ({}, 0)


def test_without_a_method_of_its_own_there_is_no_table():
    filtered = Table(rows_of(Entry("himm", "hsr"), (1, 1, 1)))
    assert best_of_each(filtered) == []
    assert list(each_method(None, filtered)) == []
