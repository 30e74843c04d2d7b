"""The arena from the command line."""

import json

import pytest

from sonarbed.studies.arena import plan as planning
from sonarbed.studies.arena.jobs import Room

SMALL = planning.ArenaPlan((Room("l-shape"), Room("clutter")), ("thesis",), seeds=1, scans=15)


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """A table that takes seconds."""
    monkeypatch.setattr(planning, "quick", lambda: SMALL)


def test_ones_own_method_gets_its_row_and_its_differences(run, tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(
        "import numpy as np\ndef mapper(log, grid):\n    return np.full(grid.shape, 0.06)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    line = "arena --quick --out out --method mine:mapper --against sheet,bayes-standard"
    shown = run(line)
    assert "mine:mapper against sheet: skill" in shown
    assert "mine:mapper against bayes-standard: skill" in shown
    told = json.loads(run(f"{line} --json"))
    assert [pair["against"] for pair in told["paired"]] == ["sheet", "bayes-standard"]
    assert told["runs"] == 6
    assert {each["entry"] for each in told["leaderboard"]} == {
        "mine:mapper", "sheet", "bayes-standard",
    }  # fmt: skip
    assert (tmp_path / "out" / "report" / "report.html").is_file()


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("--method nop", "'nop' is unknown"),
        ("--method sheet --against shet", "did you mean 'sheet'"),
        ("--filter hsr", "--filter is for --method"),
        ("--method sheet --filter hs", "'hs' is unknown"),
        ("--timeout 0", "--timeout must be > 0"),
        ("--jobs 2 --dask tcp://127.0.0.1:1", "--jobs or --dask, not both"),
        ("--method gone:Mapper", "gone"),
    ],
)
def test_bad_input_is_one_line(refused, line, complaint):
    assert complaint in refused(f"arena --quick --out out {line}")


def test_a_full_folder_is_refused(refused, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "letter.txt").write_text("dear")
    assert "must be new or empty" in refused("arena --quick --out out --method sheet")
