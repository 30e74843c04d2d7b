"""The command as a process of its own: pipes, full disks, Ctrl-C."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from support import make_log

import sonarmap as sm
from sim.runs.parallel import deaf_children
from sonarbed.interruption import Interruption
from sonarmap.interrupts import may_raise_in
from sonarmap.kernels.jit import njit

SONARBED = [sys.executable, "-m", "sonarbed"]
INTERRUPTED = "sonarbed: interrupted; what was finished is kept\n"


def test_json_goes_through_a_pipe():
    listed = subprocess.run([*SONARBED, "worlds", "--json"], capture_output=True, text=True)
    assert listed.returncode == 0
    assert listed.stderr == ""
    assert json.loads(listed.stdout)


def test_a_reader_that_goes_away_is_no_error():
    command = subprocess.Popen(
        [*SONARBED, "worlds", "office"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    command.stdout.close()  # before the command has printed anything
    assert command.stderr.read() == ""
    command.stderr.close()
    assert command.wait() == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_output_that_cannot_be_written_is_one_line():
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*SONARBED, "worlds", "office"], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.stderr == "sonarbed: output: No space left on device\n"
    assert done.returncode == 2


def is_alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def ctrl_c(command):
    """Interrupt a command and its group, as a terminal does."""
    os.killpg(command.pid, signal.SIGINT)


def terminate(command):
    """End a command by its number, as a supervisor does; its workers hear nothing."""
    os.kill(command.pid, signal.SIGTERM)


def interrupt(arguments, *, when, how=ctrl_c):
    """Interrupt a command once `when` is true, and wait until nobody of its group is left."""
    command = subprocess.Popen(
        [*SONARBED, *arguments.split()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # Whoever runs the tests in the background has Ctrl-C ignored, and children inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    deadline = time.monotonic() + 60
    try:
        while not when():
            assert command.poll() is None, command.stderr.read()
            assert time.monotonic() < deadline
            time.sleep(0.02)
        how(command)
        out, err = command.communicate(timeout=60)
        while is_alive(command.pid):  # nobody of the group is left behind
            assert time.monotonic() < deadline
            time.sleep(0.02)
    finally:
        if is_alive(command.pid):
            os.killpg(command.pid, signal.SIGKILL)
    return command.returncode, out, err


@pytest.mark.engine
def test_ctrl_c_in_a_drive_keeps_the_older_log(tmp_path):
    old = tmp_path / "drive.parquet"
    old.write_bytes(b"older")
    started = time.monotonic()
    code, out, err = interrupt(
        "simulate thesis-exp1 --scans 1000000 --out drive.parquet",
        when=lambda: time.monotonic() > started + 3,
    )
    assert (code, out, err) == (130, "", INTERRUPTED)
    assert list(tmp_path.iterdir()) == [old]
    assert old.read_bytes() == b"older"


@pytest.mark.engine
@pytest.mark.parametrize("how", [ctrl_c, terminate])
def test_interrupting_many_drives_keeps_what_is_finished(tmp_path, how):
    folder = tmp_path / "logs"
    code, out, err = interrupt(
        "simulate thesis-exp1 --scans 40 --seed 0:500 --jobs 2 --out logs",
        when=lambda: any(folder.glob("seed-*.parquet")),
        how=how,
    )
    assert (code, out, err) == (130, "", INTERRUPTED)
    told = json.loads((folder / "manifest.json").read_text())
    finished = {entry["file"]: entry["readings"] for entry in told["logs"]}
    assert 0 < len(finished) < 500
    # No half-written file, and the manifest tells of every log that is there.
    assert {path.name for path in folder.iterdir()} == {"manifest.json", *finished}
    for file, readings in finished.items():
        assert len(sm.read_log(folder / file)) == readings


@pytest.mark.engine
def test_ctrl_c_while_processes_begin_leaves_no_traceback(tmp_path):
    folder = tmp_path / "logs"
    code, out, err = interrupt(
        "simulate thesis-exp1 --scans 1000000 --seed 0:4 --jobs 2 --out logs", when=folder.exists
    )
    assert (code, out, err) == (130, "", INTERRUPTED)
    assert list(folder.iterdir()) == []


# Long commands, each interrupted where it is at work or still compiles.
LONG = {
    "one drive": "simulate office --engine segments --scans 1000000 --out a",
    "many drives": "simulate office --scans 1000000 --seed 0:4 --jobs 2 --out many",
    "demo": "demo --scans 1000000 --out demo",
    "tune": "tune --seeds 2 --scans 500 --jobs 2 --out tune",
    "thesis": "thesis --out thesis",
    "acoustics": "acoustics --out acoustics",
    "map": "map log.parquet --resolution 0.002 --out map",
    "hsr": "hsr log.parquet --cell 0.001 --out hsr",
}


@pytest.mark.engine
@pytest.mark.skipif(
    "SONARBED_TIMED" not in os.environ, reason="looks at the clock: set SONARBED_TIMED to run it"
)
@pytest.mark.parametrize("line", LONG.values(), ids=LONG)
def test_every_long_command_ends_soon_after_ctrl_c(tmp_path, line, rng):
    n = 800_000
    make_log(
        rng.uniform(0.2, 2.9, n),
        ring=sm.AMIGOBOT,
        scan=np.arange(n) // 8,
        sonar=np.arange(n) % 8,
        x_m=rng.uniform(0, 9, n),
        y_m=rng.uniform(0, 9, n),
    ).write("log.parquet")
    before, interrupted_s = {*tmp_path.iterdir()}, []
    started = time.monotonic()

    def how(command):
        interrupted_s.append(time.monotonic())
        ctrl_c(command)

    code, out, err = interrupt(line, when=lambda: time.monotonic() > started + 5, how=how)
    assert (code, out, err) == (130, "", INTERRUPTED)
    # Three seconds, and what a busy machine needs to begin and to look.
    assert time.monotonic() - interrupted_s[0] < 4
    new = {*tmp_path.rglob("*")} - before
    assert not [path for path in new if path.is_file() and path.name.startswith(".")]


def test_ctrl_c_waits_where_compiled_code_calls_python():
    # Numba crashes when an error comes there.
    class Pair(NamedTuple):
        one: int
        other: int

    waits = []

    def profile(frame, event, argument):
        if not may_raise_in(frame):
            waits.append(frame)

    @njit()
    def pair(one):
        return Pair(one, one)

    pair(1)
    sys.setprofile(profile)
    try:
        pair(2)
    finally:
        sys.setprofile(None)
    assert waits
    assert may_raise_in(sys._getframe())
    interruption, again = Interruption(ends_process=False), []
    interruption._again = lambda: again.append(True)
    interruption._interrupt(signal.SIGINT, waits[0])
    assert again == [True]
    with pytest.raises(KeyboardInterrupt):
        interruption._interrupt(signal.SIGINT, sys._getframe())


def test_ctrl_c_in_an_exec_ends_with_our_code(tmp_path):
    # CPython ends by the signal when it met the making of a dataclass, say, however it is caught.
    make_log([1.0, 2.0], ring=sm.AMIGOBOT).write("log.parquet")
    (tmp_path / "mine.py").write_text(
        'exec("import signal; signal.raise_signal(signal.SIGINT)\\nfor i in range(9): pass")\n'
    )
    done = subprocess.run(
        [*SONARBED, *["map", "log.parquet", "--method", "mine:Map", "--out", "map"]],
        capture_output=True,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert (done.returncode, done.stderr) == (130, INTERRUPTED)


def test_ctrl_c_while_processes_begin_waits_and_is_not_lost():
    children = []

    def begin():
        with deaf_children():
            child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1)"])
            child.send_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            children.append(child)

    with pytest.raises(KeyboardInterrupt):
        begin()
    assert [child.wait() for child in children] == [0]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
