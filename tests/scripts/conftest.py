import math

import pytest

from sonarbed.cli import main
from sonarbed.compiling import told_of_compiling


@pytest.fixture(autouse=True)
def in_no_haste(monkeypatch):
    """Say nothing of compiling, which takes long when a busy machine runs the tests first."""
    monkeypatch.setattr("sonarbed.cli.told_of_compiling", lambda: told_of_compiling(math.inf))


@pytest.fixture(autouse=True)
def in_tmp_path(tmp_path, monkeypatch):
    """Run every test of the command line in its own empty folder, as wide as a terminal."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")


@pytest.fixture
def run(capsys):
    """Return a function that runs a command line, checks its exit code, and returns its output."""

    def run(line, code=0):
        arguments = line.split() if isinstance(line, str) else [str(word) for word in line]
        got = main(arguments)
        out, err = capsys.readouterr()
        assert got == code, err
        return out if code == 0 else err

    return run


@pytest.fixture
def refused(run):
    """Return a function that runs a bad command line and returns its one line of complaint."""

    def refused(line):
        err = run(line, code=2)
        assert err.startswith("sonarbed: ")
        assert err.count("\n") == 1
        assert err.endswith("\n")
        return err.removeprefix("sonarbed: ").rstrip()

    return refused
