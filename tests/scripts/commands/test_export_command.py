"""Logs for other programs."""

import json
from pathlib import Path

import pytest
from support import make_log

from sonarmap.catalogue import EXPORTERS


@pytest.fixture(autouse=True)
def log():
    make_log([1.0, 2.0, 3.0]).write("drive.parquet")


def test_a_log_becomes_a_table_and_what_it_lacks_is_said(run):
    before = Path("drive.parquet").read_bytes()
    assert run("export drive.parquet --to out/drive.csv") == (
        "out/drive.csv: 3 readings as csv (one row a reading, without the ring and the "
        "provenance)\n"
    )
    assert len(Path("out/drive.csv").read_text().splitlines()) == 4
    assert Path("drive.parquet").read_bytes() == before
    told = json.loads(run("export drive.parquet --to drive.txt --format csv --json"))
    assert told == {"file": "drive.txt", "format": "csv", "readings": 3}
    assert Path("drive.txt").read_bytes() == Path("out/drive.csv").read_bytes()


def test_ones_own_exporter_is_found_in_the_folder_of_the_command(run):
    Path("toy_bag.py").write_text("def write(log, path):\n    path.write_text(str(len(log)))\n")
    assert run("export drive.parquet --to drive.bag --format toy_bag:write") == (
        "drive.bag: 3 readings as toy_bag:write\n"
    )
    assert Path("drive.bag").read_text() == "3"


def test_help_lists_the_formats(run):
    text = " ".join(run("export --help").replace("│", " ").split())
    for name in EXPORTERS:
        assert f" {name} ({EXPORTERS[name].about})" in text


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("export gone.parquet --to a.csv", "gone.parquet: no such file"),
        ("export drive.parquet --to a.txt", "a.txt: no format for files that end in '.txt'"),
        ("export drive.parquet --to a.csv --format cvs", "format 'cvs' is unknown; did you mean"),
        ("export drive.parquet --to a.csv --format gone:x", "format 'gone:x' cannot be imported"),
        (
            "export drive.parquet --to drive.parquet --format csv",
            "--to must be another file than the log, got 'drive.parquet'",
        ),
        ("export drive.parquet --to drive.parquet/a.csv", "a file is in the way"),
        ("export drive.parquet", "Missing option '--to'"),
    ],
)
def test_bad_exports_are_one_line_and_change_nothing(refused, line, complaint):
    before = Path("drive.parquet").read_bytes()
    assert complaint in refused(line)
    assert [path.name for path in Path().iterdir()] == ["drive.parquet"]
    assert Path("drive.parquet").read_bytes() == before
