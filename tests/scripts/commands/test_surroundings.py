"""Commands in surroundings other than a terminal of one's own: threads, encodings, no home."""

import io
import os
import subprocess
import sys
import threading

import pytest
from support import make_log

import sonarmap as sm
from sonarbed.cli import main
from sonarbed.compiling import LINE
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


# What may be missing, as a change of the environment or words of the shell before and after.
SURROUNDINGS = {
    "no home": ("unset HOME;", ""),
    "a home that is not there": ("export HOME=/nonexistent;", ""),
    "a home that cannot be written": ("export HOME=/proc NUMBA_CACHE_DIR=/proc/numba;", ""),
    "the C locale": ("export LC_ALL=C LANG=C PYTHONUTF8=0 PYTHONCOERCECLOCALE=0;", ""),
    "no display": ("unset DISPLAY; export MPLBACKEND=TkAgg;", ""),
    "no temporary folder": ("export TMPDIR=/nonexistent;", ""),
    "one thread a library": ("export OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1;", ""),
    "standard input closed": ("", "<&-"),
    "standard output closed": ("", ">&-"),
    "standard error closed": ("", "2>&-"),
    "all streams closed": ("", "<&- >&- 2>&-"),
    "warnings are errors": ("export PYTHONWARNINGS=error;", ""),
    "colours forced": ("export FORCE_COLOR=1;", ""),
    "few open files": ("ulimit -n 64;", ""),
    "a folder that is gone": ("mkdir gone; cd gone; rmdir ../gone;", ""),
}


@pytest.mark.parametrize("name", SURROUNDINGS)
def test_commands_work_whatever_is_missing(name, tmp_path):
    before, after = SURROUNDINGS[name]
    make_log([0.5, 1.0, 2.0, 3.0], ring=sm.AMIGOBOT).write(tmp_path / "log.parquet")
    for command, files in (
        ("simulate thesis-exp1 --scans 2 --sonar aria --out {0}/a.parquet", ["a.parquet"]),
        ("map {0}/log.parquet --out {0}/map --png {0}/m.png", ["m.png", "map/map.npz"]),
    ):
        line = f"{sys.executable} -m sonarbed {command.format(tmp_path)}"
        done = subprocess.run(
            ["bash", "-c", f"{before} {line} {after}"], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")
        assert ("closed" in name) or done.stdout
        assert all((tmp_path / file).stat().st_size for file in files)


@pytest.mark.parametrize("after", ["", "2>&-", "<&- >&- 2>&-"])
def test_bad_input_has_its_code_though_nobody_hears(after):
    line = f"{sys.executable} -m sonarbed map gone.parquet --out map {after}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == ("" if after else "sonarbed: gone.parquet: no such file\n")


def test_a_folder_that_is_gone_is_named():
    line = (
        f"mkdir gone; cd gone; rmdir ../gone; {sys.executable} -m sonarbed simulate thesis-exp1 "
        "--scans 2 --engine segments --sonar aria --out a.parquet"
    )
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


SCRIPTS = {
    "without a main guard": """
import sim, worlds
sim.simulate_many(worlds.load("thesis-exp1"), "logs", seeds=range(2), jobs=2, scans=2,
                  sonar="webots", engine="segments")
""",
    "with one": """
import sim, worlds
if __name__ == "__main__":
    sim.simulate_many(worlds.load("thesis-exp1"), "logs", seeds=range(2), jobs=2, scans=2,
                      sonar="webots", engine="segments")
""",
    "in a worker of a pool": """
import multiprocessing, sim, worlds
def work(folder):
    sim.simulate_many(worlds.load("thesis-exp1"), folder, seeds=range(2), jobs=2, scans=2,
                      sonar="webots", engine="segments")
if __name__ == "__main__":
    with multiprocessing.get_context("CONTEXT").Pool(1) as pool:
        pool.map(work, ["logs"])
""",
}


@pytest.mark.parametrize(
    ("script", "by_pipe"),
    [
        (SCRIPTS["with one"], False),
        (SCRIPTS["with one"], True),
        (SCRIPTS["in a worker of a pool"].replace("CONTEXT", "spawn"), False),
        (SCRIPTS["in a worker of a pool"].replace("CONTEXT", "fork"), False),
    ],
    ids=["file", "pipe", "spawned pool", "forked pool"],
)
def test_scripts_that_start_processes_work(script, by_pipe, tmp_path):
    (tmp_path / "script.py").write_text(script)
    words = [sys.executable, "-" if by_pipe else "script.py"]
    done = subprocess.run(
        words, input=script if by_pipe else None, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert {path.name for path in (tmp_path / "logs").iterdir()} == {
        "manifest.json",
        "seed-0000.parquet",
        "seed-0001.parquet",
    }


def test_a_script_without_a_main_guard_is_told_of_it(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPTS["without a main guard"])
    done = subprocess.run(
        [sys.executable, "script.py"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    lines = done.stderr.splitlines()
    assert lines[-1].endswith('must do so below `if __name__ == "__main__":`')
    # Once, not once a process.
    assert sum(line.startswith("Traceback") for line in lines) == 1


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="others have no DISPLAY")
@pytest.mark.parametrize(
    ("display", "problem"),
    [(None, "DISPLAY is not set"), ("", "DISPLAY is not set"), (":4711", "DISPLAY=:4711")],
)
def test_a_window_without_a_display_is_refused_and_the_process_lives(
    display, problem, refused, monkeypatch
):
    pytest.importorskip("pybullet")
    if display is None:
        monkeypatch.delenv("DISPLAY", raising=False)
    else:
        monkeypatch.setenv("DISPLAY", display)
    complaint = refused("simulate thesis-exp1 --scans 2 --gui --out a.parquet")
    assert complaint.startswith("gui needs a display to show its window on, and there is none: ")
    if display != ":4711" or "libX11" not in complaint:
        assert problem in complaint


def test_many_processes_begin_at_once_with_an_empty_cache(tmp_path):
    make_log([0.5, 1.0, 2.0, 3.0], ring=sm.AMIGOBOT).write("log.parquet")
    commands = [
        subprocess.Popen(
            [sys.executable, "-m", "sonarbed", "map", "log.parquet", "--out", f"map-{number}"],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for number in range(4)
    ]
    # A busy machine may compile for so long that it is said.
    told = [(command.communicate()[1], command.returncode) for command in commands]
    said = f"sonarbed: {LINE}\n"
    assert [(error.replace(said, ""), code) for error, code in told] == [("", 0)] * 4
    maps = {(tmp_path / f"map-{number}" / "map.pgm").read_bytes() for number in range(4)}
    assert len(maps) == 1
