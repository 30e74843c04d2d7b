"""Exporters of logs: the CSV table, and formats from outside of the package."""

import csv
import importlib.metadata
import math

import numpy as np
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarmap.catalogue import EXPORTERS
from sonarmap.exporters import exporter_for


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def columns_of(log):
    """Return every column of a log by its name in files."""
    columns = {name: getattr(log, name) for name in sm.SonarLog.DTYPES}
    if log.truth is not None:
        columns |= {f"truth_{name}": getattr(log.truth, name) for name in sm.LogTruth.DTYPES}
    return columns


def typed(words, dtype):
    """Return the words of a column as what they were."""
    if np.dtype(dtype).kind == "b":
        return np.array([{"true": True, "false": False}[word] for word in words])
    return np.array(words, dtype=dtype)


@pytest.mark.parametrize("truth", [True, False])
def test_every_column_comes_back_bit_by_bit(rng, tmp_path, truth):
    log = random_log(rng, 200, truth=truth)
    doubt = np.where(rng.random(200) < 0.5, rng.random(200), math.nan)
    log = log.replace(rejected=rng.random(200) < 0.2, doubt=doubt)
    sm.export_log(log, tmp_path / "log.csv")
    rows = rows_of(tmp_path / "log.csv")
    columns = columns_of(log)
    assert list(rows[0]) == list(columns)
    assert len(rows) == 200
    for name, column in columns.items():
        back = typed([row[name] for row in rows], column.dtype)
        assert back.tobytes() == column.tobytes(), name


def test_the_table_reads_as_one_expects(tmp_path):
    log = make_log([math.inf, -math.inf, 0.1 + 0.2], stale=[False, True, False])
    sm.export_log(log, tmp_path / "log.csv")
    assert (tmp_path / "log.csv").read_bytes().decode() == (
        "scan,sonar,time_s,x_m,y_m,heading_rad,range_m,stale,rejected,doubt\n"
        "0,0,0.0,0.0,0.0,0.0,inf,false,false,nan\n"
        "1,0,1.0,0.0,0.0,0.0,-inf,true,false,nan\n"
        "2,0,2.0,0.0,0.0,0.0,0.30000000000000004,false,false,nan\n"
    )


def test_names_of_surfaces_may_hold_what_separates_columns(rng, tmp_path):
    log = random_log(rng, 3, truth=True)
    surface = np.array(['a, "b"', "Tür", ""])
    truth = sm.LogTruth(
        **{name: getattr(log.truth, name) for name in sm.LogTruth.DTYPES} | {"surface": surface}
    )
    sm.export_log(log.replace(truth=truth), tmp_path / "log.csv")
    rows = rows_of(tmp_path / "log.csv")
    assert [row["truth_surface"] for row in rows] == surface.tolist()


def test_the_suffix_or_the_name_picks_the_format(tmp_path):
    log = make_log([1.0])
    sm.export_log(log, tmp_path / "a.CSV")
    sm.export_log(log, tmp_path / "b.txt", "csv")
    sm.export_log(log, str(tmp_path / "c"), format="csv")
    texts = {path.read_text() for path in tmp_path.iterdir()}
    assert len(texts) == 1


def test_an_older_file_is_replaced_only_when_all_is_written(tmp_path, monkeypatch):
    path = tmp_path / "log.csv"
    path.write_text("old")
    monkeypatch.setattr("sonarmap.exporters.csv._fields", lambda column: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        sm.export_log(make_log([1.0]), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


# A whole exporter, as a person would write it.
TOY = """
def write_ranges(log, path):
    path.write_text(" ".join(f"{range_m:g}" for range_m in log.range_m))
"""


@pytest.fixture
def _toy(tmp_path, monkeypatch):
    (tmp_path / "toy_exporter.py").write_text(TOY, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.usefixtures("_toy")
def test_ones_own_exporter_is_a_callable_or_named_by_its_module(tmp_path):
    import toy_exporter

    for format_ in (toy_exporter.write_ranges, "toy_exporter:write_ranges"):
        sm.export_log(make_log([1.5, 2]), tmp_path / "log.txt", format_)
        assert (tmp_path / "log.txt").read_text() == "1.5 2"
        (tmp_path / "log.txt").unlink()


@pytest.mark.usefixtures("_toy")
def test_an_installed_package_adds_a_format_and_its_suffix(tmp_path, monkeypatch):
    point = importlib.metadata.EntryPoint(
        "ranges", "toy_exporter:write_ranges", "sonarbed.exporters"
    )
    monkeypatch.setattr(
        "sonarmap.registry.entry_points",
        lambda *, group: [point] if group == point.group else [],
    )
    assert list(EXPORTERS) == ["csv", "ranges"]
    sm.export_log(make_log([1.5]), str(tmp_path / "log.ranges"))
    assert (tmp_path / "log.ranges").read_text() == "1.5"


@pytest.mark.parametrize(
    ("path", "format_", "message"),
    [
        ("log.txt", None, "log.txt: no format for files that end in '.txt'; known: .csv"),
        ("log.cvs", None, "log.cvs: no format for files that end in '.cvs'; did you mean '.csv'?"),
        ("log", None, "log: no format for files that end in ''; known: .csv"),
        ("log.csv", "cvs", "format 'cvs' is unknown; did you mean 'csv'?"),
        ("log.csv", "math:pi", "format must be callable with (log, path), got 3.14"),
        ("log.csv", 3, "format must be callable with (log, path), got 3"),
    ],
)
def test_formats_that_are_none(path, format_, message):
    with pytest.raises(sm.InputError) as error:
        exporter_for(path, format_)
    assert str(error.value).startswith(message)
