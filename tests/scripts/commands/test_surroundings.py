"""Commands in surroundings other than a terminal of one's own: threads, encodings, pipes."""

import io
import sys
import threading

import pytest
from support import make_log

import sonarmap as sm
from sonarbed.cli import main
from sonarbed.encoding import plain_where_needed


@pytest.fixture
def scored(run):
    """A map that can be scored, whose table speaks of square metres."""
    run("simulate l-shape --engine segments --sonar aria --scans 3 --out log.parquet")
    run("map log.parquet --out map")
    return "score map --world l-shape"


def test_a_command_runs_in_any_thread(capsys):
    codes = []
    thread = threading.Thread(target=lambda: codes.append(main(["worlds"])))
    thread.start()
    thread.join()
    assert codes == [0]
    assert "office" in capsys.readouterr().out


@pytest.mark.parametrize("encoding", ["cp932", "cp936", "cp1250", "ascii", "latin-1", "utf-8"])
def test_a_command_writes_in_any_encoding(encoding, scored, monkeypatch):
    bytes_written = io.BytesIO()
    out = io.TextIOWrapper(bytes_written, encoding=encoding)
    monkeypatch.setattr(sys, "stdout", out)
    assert main(scored.split()) == 0
    out.flush()
    text = bytes_written.getvalue().decode(encoding)
    try:
        "²".encode(encoding)
        unit = "m²"
    except UnicodeEncodeError:
        unit = "m2"
    assert "false-free area" in text
    assert unit in text


def test_an_error_is_told_in_any_encoding(monkeypatch):
    bytes_written = io.BytesIO()
    err = io.TextIOWrapper(bytes_written, encoding="ascii")
    monkeypatch.setattr(sys, "stderr", err)
    assert main(["map", "büro.parquet", "--out", "map"]) == 2
    err.flush()
    assert bytes_written.getvalue() == b"sonarbed: b?ro.parquet: no such file\n"


def test_characters_without_a_plain_form_become_question_marks():
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    plain_where_needed(stream)
    stream.write("0.74±0.02 m² at 90° × 日")
    stream.flush()
    assert stream.buffer.getvalue() == b"0.74+-0.02 m2 at 90 deg x ?"


def test_a_stream_of_another_make_is_left_alone(monkeypatch):
    class Notebook(io.StringIO):
        pass

    stream = Notebook()
    plain_where_needed(stream)
    monkeypatch.setattr(sys, "stdout", stream)
    assert main(["worlds"]) == 0
    assert "office" in stream.getvalue()


@pytest.mark.parametrize("term", ["dumb", "unknown", ""])
def test_no_progress_is_drawn_where_it_could_not_be_erased(term, run, monkeypatch):
    monkeypatch.setenv("TERM", term)
    make_log([1.0, 2.0], ring=sm.AMIGOBOT).write("log.parquet")

    class Terminal(io.StringIO):
        def isatty(self):
            return True

    err = Terminal()
    monkeypatch.setattr(sys, "stderr", err)
    assert main(["map", "log.parquet", "--out", "map"]) == 0
    if term in ("dumb", "unknown"):
        assert err.getvalue() == ""


@pytest.mark.parametrize(
    "line",
    [
        "simulate thesis-exp1 --scans 2 --engine segments --out {}",
        "hsr log.parquet --out {}",
        "filter log.parquet --method stale --out {}",
        "worlds office --png {}",
    ],
)
def test_an_output_that_is_no_regular_file_is_refused(line, refused, tmp_path):
    make_log([1.0, 2.0], ring=sm.AMIGOBOT).write("log.parquet")
    (tmp_path / "device.png").symlink_to("/dev/null")
    assert "device.png: is not a regular file" in refused(line.format("device.png"))
    assert (tmp_path / "device.png").is_char_device()
