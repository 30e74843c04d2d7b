"""`sonarbed dataset`."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tiny_datasets import as_toml, tiny, tree

import sim.datasets.making
from sonarmap.errors import InputError

TESTS = Path(__file__).parents[2]
SONARBED = [sys.executable, "-m", "sonarbed"]


@pytest.fixture
def spec(tmp_path):
    """The spec of the small data set, as a file."""
    path = tmp_path / "spec.toml"
    path.write_text(as_toml(tiny(license="CC0-1.0", date="2026-01-01")))
    return path


def test_it_makes_a_data_set_with_a_card(run, spec, tmp_path):
    told = json.loads(run("dataset spec.toml --out data --json"))
    assert told["taken"] == 12
    assert told["failed"] == 0
    assert sum(split["rooms"] for split in told["splits"].values()) == 3
    assert sum(told["splits"]["train"]["causes"].values()) == told["splits"]["train"]["readings"]
    card = Path("data/README.md").read_text()
    for words in ("# tiny", "12 logs in 3 rooms", "| `driver` | each of wander, follow-left |"):
        assert words in card
    assert "- licence: CC0-1.0" in card
    for picture in ("rooms", "causes"):
        assert Path(f"data/card/{picture}.png").read_bytes().startswith(b"\x89PNG")
    before = tree(tmp_path / "data")
    assert "0 logs taken now, 12 were there." in run("dataset spec.toml --out data")
    assert tree(tmp_path / "data") == before


def test_failures_are_said_and_the_rest_is_made(run, spec):
    Path("broken.toml").write_text("title = 3")
    spec.write_text(as_toml(tiny(rooms__files=["broken.toml"], pictures=False)))
    out = run("dataset spec.toml --out data")
    assert "Failed: room broken: " in out
    assert "1 failed, 4 logs not taken for it: see data/failures.jsonl." in out
    assert "1 rooms or logs could not be made" in Path("data/README.md").read_text()
    assert not Path("data/card").exists()


def test_bad_input_is_one_line(refused, run, spec, monkeypatch):
    assert refused("dataset gone.toml --out data") == "gone.toml: no such file"
    assert refused("dataset spec.toml --out data --jobs 0") == "jobs must be >= 1, got 0"
    assert refused("dataset spec.toml --out data --jobs 2 --dask tcp://x").startswith("give --jobs")
    assert refused("dataset spec.toml --out spec.toml").startswith("spec.toml: must be a folder")
    assert "nothing://x: " in refused("dataset spec.toml --out nothing://x")
    spec.write_text(as_toml(tiny(logs__scnas=3)))
    assert refused("dataset spec.toml --out data") == (
        "spec.toml: logs.scnas: unknown key; did you mean 'scans'?"
    )
    assert not Path("data").exists()

    def full(*arguments, **options):
        raise InputError("data: No space left on device")

    spec.write_text(as_toml(tiny()))
    monkeypatch.setattr(sim.datasets.making, "run_jobs", full)
    assert refused("dataset spec.toml --out data") == "data: No space left on device"


def is_alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_interrupted_it_says_so_and_leaves_nothing_half_written(spec, tmp_path):
    spec.write_text(as_toml(tiny(logs__seeds=2000, logs__scans=30)))
    command = subprocess.Popen(
        [*SONARBED, "dataset", "spec.toml", "--out", "data", "--jobs", "2"],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    deadline = time.monotonic() + 120
    while not list(tmp_path.glob("data/logs/*/*/*")):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.killpg(command.pid, signal.SIGINT)
    _, err = command.communicate(timeout=60)
    assert (command.returncode, err) == (
        130,
        "sonarbed: interrupted; what was finished is kept\n",
    )
    while is_alive(command.pid):  # nobody is left behind
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert not [name for name in tree(tmp_path / "data") if "/." in name or name[0] == "."]


def begin(*words, environment):
    return subprocess.Popen(
        [sys.executable, "-m", *words],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def free_port():
    import socket

    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def test_a_dask_cluster_makes_the_same_files(run, spec, tmp_path):
    pytest.importorskip("distributed", reason="dask is not installed")
    run("dataset spec.toml --out one")
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    paths = [str(TESTS.parent), str(TESTS.parent / "scripts"), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    scheduler = ["distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port)]
    worker = ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]
    worker += ["--host", "127.0.0.1", "--local-directory", str(tmp_path / "dask")]
    cluster = [
        begin(*scheduler, "--no-dashboard", environment=environment),
        *(begin(*worker, environment=environment) for _ in range(2)),
    ]
    try:
        # In a process of its own, for what Dask warns of is not ours.
        done = subprocess.run(
            [*SONARBED, "dataset", "spec.toml", "--out", "two", "--dask", address, "--json"],
            env=environment,
            capture_output=True,
            text=True,
            timeout=240,
        )
    finally:
        for process in reversed(cluster):
            process.terminate()
        for process in cluster:
            process.wait(30)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["taken"] == 12
    assert tree(tmp_path / "two") == tree(tmp_path / "one")


def test_a_cluster_that_is_not_there_is_one_line(spec):
    pytest.importorskip("distributed", reason="dask is not installed")
    done = subprocess.run(
        [
            *SONARBED,
            "dataset",
            "spec.toml",
            "--out",
            "two",
            "--dask",
            f"tcp://127.0.0.1:{free_port()}",
        ],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("sonarbed: dask 'tcp://127.0.0.1:")
    assert "cannot be reached" in done.stderr
