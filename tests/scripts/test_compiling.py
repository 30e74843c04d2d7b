"""What people are told of compiling, and doing it beforehand."""

import json
import os
import subprocess
import sys
import time

import numba
import pytest

from sonarbed import compiling
from sonarbed.compiling import LINE, told_of_compiling
from sonarbed.warming import parts


def slow(depth):
    """Return a function that numba compiles for a while."""
    lines = [f"    x = x * {k}.5 + (x if x > {k} else {k}) ** 0.5" for k in range(depth)]
    scope = {}
    exec("def f(x):\n" + "\n".join(lines) + "\n    return x", scope)
    return numba.njit(scope["f"])


def test_a_line_tells_of_compiling_that_takes_long_and_no_line_of_other_work(capsys, monkeypatch):
    monkeypatch.setattr(compiling, "_EVERY_S", 0.05)
    with told_of_compiling(patience_s=0.1):
        time.sleep(0.5)
    assert capsys.readouterr().err == ""
    with told_of_compiling(patience_s=0.1):
        slow(150)(1.0)
        slow(151)(1.0)
    assert capsys.readouterr().err == f"sonarbed: {LINE}\n"


def test_warmup_names_what_it_compiled(run, monkeypatch):
    # The tests have compiled it all; a part is enough here.
    ran = []
    monkeypatch.setattr(
        "sonarbed.warming.parts",
        lambda *, environments: {"one": lambda: ran.append(environments)},
    )
    told = json.loads(run("warmup --no-environments --json"))
    assert ran == [False]
    assert list(told["seconds"]) == ["one"]
    assert told["kept"] is True
    assert "What is compiled is kept" in run("warmup")


@pytest.mark.engine
@pytest.mark.parametrize("name", sorted(parts(environments=False)))
def test_every_part_of_the_warmup_runs(name):
    parts(environments=False)[name]()


def test_processes_that_begin_at_once_share_a_cache(tmp_path):
    script = (
        "import numpy as np, worlds\n"
        "faces = worlds.load('l-shape').faces\n"
        "print(faces.cast([[1.0, 1.0]], [[1.0, 0.0]], 9.0).distance_m[0])\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    together = [
        subprocess.Popen(
            [sys.executable, "-c", script],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        for _ in range(3)
    ]
    told = [process.communicate() for process in together]
    assert [error for _, error in told] == [""] * 3
    assert len({answer for answer, _ in told}) == 1
    # What they left is whole: the next one reads it.
    assert any(tmp_path.rglob("*.nbi"))
    again = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env=environment
    )
    assert (again.stdout, again.stderr) == (told[0][0], "")
