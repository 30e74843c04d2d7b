"""The example of docs/arena.md runs as it stands."""

import re
from pathlib import Path

from sonarbed.studies.arena.entries import Entry
from sonarbed.studies.arena.jobs import Room
from sonarbed.studies.arena.plan import ArenaPlan
from sonarbed.studies.arena.running import run_arena
from sonarbed.studies.arena.table import Table

PAGE = Path(__file__).parents[1] / "docs" / "arena.md"


def test_the_example_of_the_page_gets_its_row(tmp_path, monkeypatch):
    (code,) = re.findall(r"```python\n# mine.py\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert len(code.strip().splitlines()) <= 15
    (tmp_path / "mine_of_page.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    plan = ArenaPlan((Room("l-shape"),), ("physical",), seeds=1, scans=40)
    entries = [Entry("mine_of_page:points"), Entry("bayes-standard")]
    result = run_arena(plan, entries, tmp_path / "out")
    assert result.runs.failed == 0
    assert Table(result.rows).paired("mine_of_page:points", "bayes-standard").value > 0
