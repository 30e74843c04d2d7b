"""The arena on a small plan: rows, resuming, failures, and nobody sees the truth."""

import csv
import dataclasses
import json
import math
import re
import sys
import time

import numpy as np
import pyarrow.parquet as pq
import pytest

import sonarmap as sm
import worlds
from sim.runs.jobs import Processes, open_store
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.arena.contrasts import contrasts, skill_by_scans
from sonarbed.studies.arena.entries import FILTERED_METHODS, Entry, all_entries, entries_of
from sonarbed.studies.arena.jobs import DriveJob, Room, seen_of
from sonarbed.studies.arena.plan import FIRST_SEED, ArenaPlan, full, quick
from sonarbed.studies.arena.report import write_arena_report
from sonarbed.studies.arena.running import FAILURES, ROWS, run_arena
from sonarbed.studies.arena.standing import standing_robot
from sonarbed.studies.arena.table import Table
from sonarmap import InputError

PLAN = ArenaPlan((Room("l-shape"), Room("office")), ("thesis",), seeds=1, scans=25)
ENTRIES = [Entry("sheet"), Entry("bayes-parameterized"), Entry("free-space")]

OWN = """
import time
import numpy as np

def fair(log, grid):
    return np.full(grid.shape, 0.08)

def curious(log, grid):
    assert log.truth is None and not log.provenance, "sees the truth"
    return np.full(grid.shape, 0.08)

def misshapen(log, grid):
    return np.full((3, 3), 0.5)

def undefined(log, grid):
    return np.full(grid.shape, np.nan)

def beyond(log, grid):
    return np.full(grid.shape, 1.5)

def raises(log, grid):
    raise ValueError("no idea")

def hangs(log, grid):
    time.sleep(30)

def changes(log, grid):
    ranges = log.range_m
    ranges.flags.writeable = True
    ranges[:] = 1.0
    return np.full(grid.shape, 0.08)
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A module with a person's own methods, good and bad."""
    (tmp_path / "own_arena.py").write_text(OWN)
    monkeypatch.syspath_prepend(tmp_path)
    yield "own_arena"
    sys.modules.pop("own_arena", None)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A folder in which the entries have run, and its result."""
    folder = tmp_path_factory.mktemp("arena") / "out"
    return folder, run_arena(PLAN, ENTRIES, folder)


def test_there_is_a_row_a_run(done):
    folder, result = done
    assert len(result.rows) == len(ENTRIES) * 2
    assert pq.read_table(folder / ROWS).num_rows == len(result.rows)
    for row in result.rows:
        score = 1 - row["loss_bits"] / row["sheet_loss_bits"]
        assert row["skill"] == pytest.approx(score)
        assert row["paths_pairs"] > 0
    sheet = [row for row in result.rows if row["entry"] == "sheet"]
    # A constant of its own, not the room's share: at most as good as the sheet.
    assert all(-0.1 < row["skill"] <= 1e-9 for row in sheet)


def test_a_row_is_what_the_core_says(done):
    folder, result = done
    drive = next(PLAN.drives())
    seen = seen_of(drive, folder)
    built = sm.method("bayes-parameterized").map(seen.blind, seen.truth.grid)
    score = sm.score_map(built, seen.truth, observable=seen.observable)
    (row,) = (
        r for r in result.rows
        if r["entry"] == "bayes-parameterized" and r["room"] == drive.room.name
    )  # fmt: skip
    assert row["skill"] == pytest.approx(score.skill)
    assert row["map_score"] == pytest.approx(score.map_score)


def test_what_is_there_is_not_run_again_and_new_entries_join(done, own):
    folder, result = done
    again = run_arena(PLAN, ENTRIES, folder)
    assert (again.runs.skipped, again.drives.skipped) == (len(result.rows), 2)
    assert again.rows == result.rows
    joined = run_arena(PLAN, [Entry(f"{own}:fair")], folder)
    assert joined.runs.skipped == 0
    assert len(joined.rows) == len(result.rows) + 2
    assert run_arena(PLAN, [Entry(f"{own}:fair")], folder).runs.skipped == 2


def test_processes_make_the_same_rows(done, tmp_path):
    def timeless(rows):
        return [{k: v for k, v in row.items() if k != "seconds"} for row in rows]

    two = run_arena(PLAN, ENTRIES, tmp_path / "out", workers=Processes(2))
    mine = [row for row in done[1].rows if ":" not in row["entry"]]
    assert timeless(two.rows) == timeless(mine)


def test_nobody_sees_the_truth_nor_the_walls_by_the_grid(done, own, tmp_path):
    result = run_arena(PLAN, [Entry(f"{own}:curious")], tmp_path / "out")
    assert result.runs.failed == 0
    edges = []
    for drive in PLAN.drives():
        seen = seen_of(drive, done[0])
        assert seen.blind.truth is None
        left, right, bottom, top = seen.truth.grid.extent_m
        x_min, y_min, x_max, y_max = drive.room.world().bounds_m
        reach = [x_min - left, y_min - bottom, right - x_max, top - y_max]
        assert min(reach) >= 1.5 - 1e-9
        edges += reach
    assert len({round(edge, 3) for edge in edges}) == len(edges)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("misshapen", "shape"),
        ("undefined", "nan|NaN|finite|number"),
        ("beyond", "1.5|within"),
        ("raises", "ValueError: no idea"),
        ("hangs", "took longer than the 0.2 s of --timeout"),
        ("changes", "read-only|cannot set|has changed the log"),
    ],
)
def test_a_bad_method_fails_alone(done, own, name, message, tmp_path):
    begin = time.monotonic()
    entries = [Entry(f"{own}:{name}"), Entry("sheet")]
    result = run_arena(PLAN, entries, tmp_path / "out", timeout_s=0.2 if name == "hangs" else 60)
    assert result.runs.failed == 2
    assert {row["entry"] for row in result.rows} == {"sheet"}
    lines = (tmp_path / "out" / FAILURES).read_text().splitlines()
    told = json.loads(lines[0])
    assert re.search(message, told["error"]), told["error"]
    assert "seed 0" in told["job"]
    assert time.monotonic() - begin < 25


def test_a_folder_of_another_plan_is_refused(done, tmp_path):
    other = ArenaPlan(PLAN.rooms, ("aria",), seeds=1, scans=25)
    with pytest.raises(InputError, match=r"is an arena with sonars \['thesis'\], asked for"):
        run_arena(other, ENTRIES, done[0])
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match=r"must be new or empty, but has 'letter.txt'"):
        run_arena(PLAN, ENTRIES, tmp_path / "full")


def test_the_report_has_every_section(done):
    folder, result = done
    html, markdown = write_arena_report(PLAN, result, folder / "report")
    text = markdown.read_text()
    for words in ("Leaderboards", "Does any method beat the blank sheet?", "Maps of l-shape"):
        assert words in text
    assert "data:image/png;base64," in html.read_text()


def test_a_filtered_method_alone_has_a_report(tmp_path):
    plan = ArenaPlan((Room("l-shape"),), ("thesis",), seeds=1, scans=25)
    result = run_arena(plan, [Entry("bayes-parameterized", "hsr")], tmp_path)
    _, markdown = write_arena_report(plan, result, tmp_path / "report")
    text = markdown.read_text()
    assert "First is hsr + bayes-parameterized" in text
    assert "Maps" not in text
    assert "Each method three ways" not in text


def test_a_choice_made_the_other_way_is_what_the_core_says(done):
    folder, result = done
    context = StudyContext(folder / "report", report="arena", sonar="thesis").on_study("questions")
    arc, no_echo = contrasts(context, Table(result.rows), PLAN)
    assert arc.number == "Arc or dot?"
    skills = []
    for room in PLAN.rooms:
        seen = seen_of(DriveJob(room, "thesis", 0, 25, 0.05), folder)
        narrow = dataclasses.replace(seen.blind.ring, half_angle_rad=math.radians(1))
        built = sm.method("bayes-parameterized").map(
            seen.blind.replace(ring=narrow), seen.truth.grid
        )
        skills.append(sm.score_map(built, seen.truth, observable=seen.observable).skill)
    lines = (context.folder / "questions" / "arc-dot.csv").read_text().splitlines()
    assert lines[0] == "method,arc,dot,gained by dot,decided"
    (told,) = csv.reader(lines[1:])
    assert told[0] == "bayes-parameterized"
    assert float(told[2]) == pytest.approx(np.mean(skills), abs=0.005)
    assert "1 methods" in no_echo.finding


def test_skill_by_scans_ends_with_the_whole_drive(done):
    folder, result = done
    context = StudyContext(folder / "report", report="arena", sonar="thesis").on_study("dependence")
    table = Table(result.rows)
    (item,) = skill_by_scans(context, table, PLAN)
    lines = (context.folder / "dependence" / "scans.csv").read_text().splitlines()
    told = list(csv.DictReader(lines))
    for row in told:
        whole = np.nanmean(table.room_skill(row["method"]))
        assert float(row["25"]) == pytest.approx(whole, abs=0.005)
    assert "25" in item.finding
    assert not list(skill_by_scans(context, Table([_own_row()]), PLAN))


def _own_row():
    return row("mine:points", "l-shape", 50.0)


# --- the table -----------------------------------------------------------------------------------


def row(entry, room, loss, sheet=100.0, **more):
    skill = 1 - loss / sheet if sheet else None
    return {
        "entry": entry, "room": room, "loss_bits": loss, "sheet_loss_bits": sheet, "skill": skill,
        "filter": "none", **more,
    }  # fmt: skip


def test_skills_by_hand():
    table = Table(
        [
            row("a", "x", 50.0),
            row("a", "y", 20.0, 40.0),
            row("b", "x", 80.0),
            row("b", "y", 50.0, 40.0),
        ]
    )
    first, second = table.standings()
    assert (first.entry, second.entry) == ("a", "b")
    assert first.skill.value == pytest.approx(0.5)
    assert first.pooled == pytest.approx(1 - 70 / 140)
    assert second.pooled == pytest.approx(1 - 130 / 140)
    assert second.worst == pytest.approx(-0.25)
    assert (first.rank, second.rank) == (1, 2)
    gained = table.paired("a", "b")
    assert gained.value == pytest.approx((0.3 + 0.75) / 2)
    assert gained.sign == 1
    assert table.paired("b", "a").value == pytest.approx(-gained.value)


def test_intervals_cover_and_shrink(rng):
    skills = rng.normal(0.3, 0.2, 40)
    few, many = (
        Table([row("a", f"r{k}", 100 * (1 - s)) for k, s in enumerate(skills[:n])])
        .standings()[0]
        .skill
        for n in (8, 40)
    )
    assert many.high - many.low < few.high - few.low
    assert many.low < skills.mean() < many.high
    half = 1.96 * skills.std() / math.sqrt(40)
    assert (many.high - many.low) / 2 == pytest.approx(half, rel=0.15)


def test_rooms_without_walls_do_not_count():
    table = Table([row("a", "x", 50.0), row("a", "y", 3.0, 0.0)])
    assert np.isnan(table.room_skill("a")).tolist() == [False, True]
    assert table.standings()[0].skill.value == pytest.approx(0.5)
    with pytest.raises(InputError, match="no row"):
        Table([])


# --- who and where -------------------------------------------------------------------------------


def test_entries():
    everybody = all_entries()
    assert len(set(everybody)) == len(everybody)
    assert {entry.method for entry in everybody} == set(sm.methods())
    assert {entry.filter for entry in everybody} == set(sm.filters())
    assert set(FILTERED_METHODS) <= set(sm.methods())
    assert [entry.label for entry in entries_of(["sheet"], ["hsr"])] == ["hsr + sheet"]
    with pytest.raises(InputError, match=r"'shet' is unknown.*did you mean 'sheet'"):
        entries_of(["shet"], [])
    with pytest.raises(InputError, match="sheet is entered twice"):
        entries_of(["sheet", "sheet"], [])


def test_plans_are_what_is_promised():
    plan = full()
    groups = [room.group for room in plan.rooms]
    assert (groups.count("shipped"), groups.count("generated")) == (8, 24)
    assert set(worlds.names()) == {room.key for room in plan.rooms if room.seed is None}
    assert all(room.seed >= FIRST_SEED for room in plan.rooms if room.seed is not None)
    assert (plan.sonars, plan.seeds) == (("physical", "thesis"), 3)
    assert len({drive.digest for drive in plan.drives()}) == 32 * 2 * 3
    assert len(list(quick().drives())) < 10
    with pytest.raises(InputError, match="seeds must be >= 1"):
        ArenaPlan(plan.rooms, ("thesis",), 0, 5)
    with pytest.raises(InputError, match="sonar 'thesi' is unknown"):
        ArenaPlan(plan.rooms, ("thesi",), 1, 5)


def test_a_drive_is_found_again(done):
    store = open_store(done[0])
    drive = DriveJob(Room("l-shape"), "thesis", 0, 25, 0.05)
    assert store.has(drive.outputs[0])


@pytest.mark.parametrize(
    ("method", "moved", "remedied"),
    [
        # Log-odds of one reading, added a thousand times: from 0.5 nearly to the end of the scale.
        ("bayes-parameterized", (0.4, 0.5), 0.0),
        ("himm", (0.5, 1.0), 0.0),
        ("thrun-forward", (0.0, 1e-6), None),
        ("konolige-style", (0.0, 1e-6), 0.0),
        ("sheet", (0.0, 0.0), None),
    ],
)
def test_a_standing_robot(method, moved, remedied):
    told = standing_robot(method)
    low, high = moved
    assert low <= told.moved <= high
    assert list(told.remedied.values()) == [remedied, remedied]
