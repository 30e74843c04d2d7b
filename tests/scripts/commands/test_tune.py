"""`sonarbed tune`: interrupted, resumed, judged by hand, and what it refuses."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing, suppress
from dataclasses import asdict
from pathlib import Path

import numpy as np
import optuna
import pytest
from PIL import Image
from searches import ignore, make_drives, path_of, search_in
from support import make_log

import sim
import sonarmap as sm
import worlds
from sonarbed.cli import main
from sonarbed.studies.tuning import search as searching
from sonarbed.studies.tuning import storage
from sonarbed.studies.tuning.scoring import score_candidate
from sonarbed.studies.tuning.search import find
from sonarmap.errors import InputError

pytestmark = pytest.mark.engine

OPTIONS = "--train thesis-exp1 --judge l-shape --seeds 2 --scans 6 --jobs 1"


@pytest.fixture(scope="module")
def drives(tmp_path_factory):
    """The folder of the drives of `SMALL`, simulated once."""
    return make_drives(tmp_path_factory.mktemp("drives"))


@pytest.fixture
def folder(drives, tmp_path):
    """A folder with the drives and no study."""
    shutil.copytree(drives, tmp_path / "out" / "logs")
    return tmp_path / "out"


def test_ctrl_c_in_a_trial_keeps_the_finished_ones(folder, capsys, monkeypatch):
    calls = []

    def interrupted(*arguments):
        calls.append(arguments)
        if len(calls) == 6:  # the second drive of the third trial
            raise KeyboardInterrupt
        return score_candidate(*arguments)

    line = f"tune --out {folder} {OPTIONS} --trials 5"
    monkeypatch.setattr(searching, "score_candidate", interrupted)
    assert main(line.split()) == 130
    assert capsys.readouterr().err == "sonarbed: interrupted; what was finished is kept\n"
    assert not (folder / "tune.json").exists()
    kept = optuna.load_study(study_name="tune", storage=search_in(folder).storage).trials
    states = [trial.state.name for trial in kept]
    assert states == ["COMPLETE", "COMPLETE", "FAIL"]

    monkeypatch.setattr(searching, "score_candidate", score_candidate)
    assert main(line.split()) == 0
    again = optuna.load_study(study_name="tune", storage=search_in(folder).storage).trials
    assert [trial.values for trial in again[:2]] == [trial.values for trial in kept[:2]]
    assert sum(trial.state.name == "COMPLETE" for trial in again) == 5
    assert json.loads((folder / "tune.json").read_text())["trials"] == 5


def test_ctrl_c_reaches_every_process(folder):
    line = f"tune --out {folder} {OPTIONS.replace('--jobs 1', '--jobs 2')} --trials 3000"
    command = subprocess.Popen(
        [sys.executable, "-m", "sonarbed", *line.split()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    search, database = search_in(folder), f"file:{folder}/study.db?mode=ro"

    def finished():
        # Without Optuna, which would make its tables at the same time as the command.
        with (
            suppress(sqlite3.OperationalError),
            closing(sqlite3.connect(database, uri=True)) as study,
        ):
            return study.execute("SELECT count(*) FROM trial_values").fetchone()[0]
        return 0

    deadline = time.monotonic() + 60
    while finished() < 3:
        assert command.poll() is None, command.stderr.read()
        assert time.monotonic() < deadline
        time.sleep(0.1)
    os.killpg(command.pid, signal.SIGINT)  # as a terminal does
    out, err = command.communicate(timeout=30)
    assert (command.returncode, out) == (130, "")
    assert err == "sonarbed: interrupted; what was finished is kept\n"
    # What was being made is finished or nothing, and the search goes on from there.
    trials = optuna.load_study(study_name="tune", storage=search.storage).trials
    kept = [trial for trial in trials if trial.state.name == "COMPLETE"]
    # A busy machine may not let a trial end in the second that it has: then it does not count.
    assert all(trial.values is None for trial in trials if trial not in kept)
    assert len(trials) - len(kept) <= 2
    assert len(find(search, trials=len(kept) + 1, on_progress=ignore).trials) == len(kept) + 1


@pytest.mark.parametrize("sampler", ["tpe", "grid"])
def test_processes_that_share_a_study_make_its_trials_together(folder, sampler):
    # They begin at once, and one of them makes the study.
    commands = [
        subprocess.Popen(
            [
                *(sys.executable, "-m", "sonarbed", "tune", "--out", str(folder)),
                *f"{OPTIONS} --sampler {sampler} --trials 12 --seed {seed}".split(),
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for seed in range(3)
    ]
    assert [(command.communicate()[1], command.returncode) for command in commands] == [("", 0)] * 3
    kept = optuna.load_study(study_name="tune", storage=search_in(folder).storage).trials
    assert 12 <= sum(trial.state.name == "COMPLETE" for trial in kept) < 12 + 3
    assert 12 <= json.loads((folder / "tune.json").read_text())["trials"] < 12 + 3


@pytest.mark.parametrize(("seeds", "title"), [(1, "1 seed, no interval"), (2, "95 % over 2 seeds")])
def test_a_search_says_over_what_its_numbers_are(folder, run, seeds, title):
    line = f"tune --out {folder} {OPTIONS.replace('--seeds 2', f'--seeds {seeds}')} --trials 1"
    shown, told = run(line), json.loads((folder / "tune.json").read_text())
    for part, room, words in (
        ("training", "thesis-exp1", "Tuned on"),
        ("judged", "l-shape", "Judged on"),
    ):
        assert f"{words}: skill ({title})" in shown
        readings = told["readings"][part]
        assert readings["drives"] == seeds
        assert readings["in_log"] == 8 * 6 * seeds
        assert readings["used"] + sum(readings["unused"].values()) == readings["in_log"]
        assert readings["collision_scans"] == 0
        used = f"{readings['used']} of {readings['in_log']} readings used"
        assert f"{words}: {seeds} drive{'s' if seeds > 1 else ''}, {used}" in shown
        assert told[part][room]["scores"]["best"]["low"] is None or seeds > 1


def test_judged_scores_equal_a_direct_computation(folder, run, tmp_path):
    line = f"tune --out {folder} {OPTIONS} --target hsr --max-range 2 --trials 3"
    told = json.loads(run(f"{line} --json"))
    assert json.loads((folder / "tune.json").read_text()) == told
    with Image.open(folder / "tune.png") as image:
        assert np.asarray(image.convert("L")).std() > 5

    best = told["parameters"]["best"]
    params = [best[f"{name}_m"] for name in ("min_wall", "max_wall", "threshold")]
    ways = {
        "best": sm.HsrParams(*params, best["target_distance_m"]),
        "thesis": sm.HsrParams(0.02, 0.15, 3.0, 0.06),
        "no HSR": None,
    }
    room = worlds.load("l-shape")
    truth = worlds.truth(room)
    model = sm.ParameterizedModel.thesis()
    direct = {}
    for name, hsr in ways.items():
        direct[name] = []
        for seed in (0, 1):
            log = sim.simulate(room, scans=6, seed=seed, driver="route", sonar="thesis")
            # Idle, not refused, where no reading is short enough to vouch.
            mended = log if hsr is None else sm.filter("hsr", **asdict(hsr)).apply(log).log
            built = sm.build_map(mended, model, truth.grid, max_range_m=2.0)
            score = sm.score_map(built, truth, observable=truth.observable(log))
            direct[name].append(score.skill)
    judged = told["judged"]["l-shape"]
    for name, scores in direct.items():
        assert judged["scores"][name]["by_seed"] == scores
        assert judged["scores"][name]["mean"] == pytest.approx(np.mean(scores))
    assert judged["best_minus"]["thesis"]["mean"] == pytest.approx(
        np.mean(direct["best"]) - np.mean(direct["thesis"])
    )
    assert set(told["judged"]) == {"l-shape"}

    table = run(line)
    assert f"{judged['scores']['best']['mean']:.3f}±" in table
    assert f"{judged['best_minus']['no HSR']['mean']:.3f}±" in table


# What is refused.


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ("--target hsr", "study 'tune' in sqlite:////.* was made with target 'model', asked for"),
        ("--score brier", "was made with score 'skill', asked for 'brier'"),
        ("--sampler nsga2", "was made with sampler 'tpe', asked for 'nsga2'"),
        ("--model standard", "was made with model 'parameterized', asked for 'standard'"),
        ("--train office", r"was made with train \['thesis-exp1'\], asked for \['office'\]"),
        ("--seeds 3", "was made with seeds 2, asked for 3"),
        ("--scans 7", "was made with scans 6, asked for 7"),
        ("--max-range 2", "was made with max_range_m None, asked for 2.0"),
    ],
)
def test_a_study_of_other_settings_is_refused(folder, options, complaint, refused):
    find(search_in(folder), trials=1, on_progress=ignore)
    logs = sorted((folder / "logs").iterdir())
    with pytest.raises(InputError, match=complaint):
        raise InputError(refused(f"tune --out {folder} {OPTIONS} {options} --trials 2"))
    assert sorted((folder / "logs").iterdir()) == logs
    assert len(find(search_in(folder), trials=1, on_progress=ignore).trials) == 1


def test_a_drive_without_truth_is_refused(folder, refused):
    path = path_of(folder, seed=0)
    sm.read_log(path).replace(truth=None).write(path)
    assert f"{path}: the log has no truth" in refused(f"tune --out {folder} {OPTIONS} --trials 1")


def test_another_drive_by_the_same_name_is_refused(folder, refused):
    other = path_of(folder, seed=1)
    shutil.copy(path_of(folder, seed=0), other)
    complaint = refused(f"tune --out {folder} {OPTIONS} --trials 1")
    assert f"{other}: must be the drive" in complaint
    assert complaint.endswith("remove it, and it is made again")


def test_a_full_disk_is_one_line_and_keeps_the_finished_trials(folder, refused, monkeypatch):
    find(search_in(folder), trials=2, on_progress=ignore)
    prepared = storage._write_ahead

    def small(connection, record):
        prepared(connection, record)
        connection.execute("PRAGMA max_page_count = 1")  # SQLite takes what there is

    monkeypatch.setattr(storage, "_write_ahead", small)
    complaint = refused(f"tune --out {folder} {OPTIONS} --trials 400")
    assert complaint.startswith("storage sqlite:////")
    assert complaint.endswith("cannot be used: database or disk is full")
    monkeypatch.setattr(storage, "_write_ahead", prepared)
    assert len(find(search_in(folder), trials=2, on_progress=ignore).trials) >= 2


@pytest.mark.parametrize("package", ["optuna", "cmaes"])
def test_a_missing_package_is_one_line(refused, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    assert refused("tune") == f"tune needs the package {package}: pip install 'sonarbed[tune]'"


# Command line, what its complaint must say.
REFUSED = [
    ("--target modle", "target 'modle' is unknown; did you mean 'model'?"),
    ("--sampler tpee", "sampler 'tpee' is unknown; did you mean 'tpe'?"),
    ("--score map_scor", "score 'map_scor' is unknown; did you mean 'map_score'?"),
    ("--model std", "model 'std' is unknown; known: parameterized, standard"),
    ("--train offise", "train: room 'offise' is unknown; did you mean 'office'?"),
    ("--judge cluter", "judge: room 'cluter' is unknown; did you mean 'clutter'?"),
    ("--train ,", "train must name at least one room"),
    ("--train office,office", "train must name no room twice, got office, office"),
    ("--train office --judge office", "judge must name other rooms than train, got office"),
    ("--seeds 0", "seeds must be >= 1, got 0"),
    ("--scans 0", "scans must be >= 1, got 0"),
    ("--trials 0", "trials must be >= 1, got 0"),
    ("--jobs 0", "jobs must be >= 1, got 0"),
    ("--seed=-1", "seed must be >= 0, got -1"),
    ("--max-range 0", "max_range_m must be > 0, got 0"),
    ("--sampler grid --trials 1441", "trials must be 1 to 1440, got 1441"),
    ("--sampler grid --target hsr", "sampler 'grid' is the thesis's search"),
    ("--sampler grid --model standard", "sampler 'grid' is the thesis's search"),
    ("--out file", "file: cannot be made a folder: a file is in the way"),
    ("--out in-the-way", "tune.json: is a folder, a file name is needed"),
    ("--out no-logs", "no-logs/logs: cannot be made a folder: a file is in the way"),
    ("--storage sqlite:///gone/study.db", "cannot be used: unable to open database file"),
    ("--storage sqlite:///file.txt", "file.txt cannot be used: file is not a database"),
    ("--storage sqlite://", "storage must be kept, got 'sqlite://', which is in memory"),
    ("--storage study", "storage study cannot be used: Could not parse SQLAlchemy URL"),
    ("--storage postgresql://me:secret@x/y", "storage postgresql://me:***@x/y cannot be used"),
]


@pytest.mark.parametrize(("options", "complaint"), REFUSED, ids=[line for line, _ in REFUSED])
def test_bad_input_is_refused_in_one_line(refused, tmp_path, options, complaint):
    Path("file").touch()
    Path("file.txt").write_text("no database " * 100)
    Path("in-the-way/tune.json").mkdir(parents=True)
    Path("no-logs").mkdir()
    Path("no-logs/logs").touch()
    make_log(1.0).write("real.parquet")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert complaint in refused(f"tune --trials 2 {options}")
    kept = {path: path.read_bytes() for path in before}
    assert kept == before
    assert not list(tmp_path.rglob("logs/*.parquet"))
