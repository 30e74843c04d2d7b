"""Help: quick, complete, and its examples work."""

import subprocess
import sys

import pytest

import sim.engines.opening
import sim.robot.drivers
import sim.sonar.presets
import sonarmap as sm
from sonarbed.cli import app, main
from sonarbed.commands.map import P2, ModelName
from sonarmap.importers import FORMATS

COMMANDS = [
    command.name or command.callback.__name__.strip("_") for command in app.registered_commands
]
NARROW = 60


@pytest.fixture
def help_of(run):
    """Return a function that returns the help of a command as one line of words."""

    def words(command):
        text = run(f"{command} --help")
        return " ".join(text.replace("│", " ").split())

    return words


def examples(text):
    """Return the commands that a help text shows, continued lines joined."""
    lines = text.replace("\\\n", " ").splitlines()
    return [" ".join(line.split()) for line in lines if line.strip().startswith("sonarbed ")]


def test_the_commands_are_those_of_the_readme(run):
    listed = run("--help")
    assert {"demo", "worlds", "simulate", "import", "map", "score"} <= set(COMMANDS)
    for command in COMMANDS:
        assert f" {command} " in listed


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example(run, command, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(NARROW))
    text = run(f"{command} --help")
    assert f"Usage: sonarbed {command}" in text
    assert "Example" in text
    assert f"sonarbed {command} " in text


@pytest.mark.parametrize("command", ["demo", "worlds", "simulate", "import", "map", "score"])
def test_examples_stand_on_lines_of_their_own_in_a_narrow_terminal(run, command, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(NARROW))
    shown = [line for line in examples(run(f"{command} --help")) if "Usage" not in line]
    monkeypatch.setenv("COLUMNS", "200")
    assert shown == examples(run(f"{command} --help"))
    assert shown


@pytest.mark.engine
def test_examples_work_one_after_the_other(run, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(NARROW))
    shown = {command: examples(run(f"{command} --help")) for command in COMMANDS}
    chain = [*shown["worlds"], shown["simulate"][0], *shown["map"], *shown["score"]]
    for example in chain:
        words = example.split()[1:]
        run([*words, "--scans", 20] if words[0] == "simulate" else words)


def test_help_names_what_the_code_knows(help_of):
    simulate, import_, map_ = (help_of(command) for command in ("simulate", "import", "map"))
    *first, last = sim.robot.drivers.names()
    assert f"{', '.join(first)} or {last}." in simulate
    *sonars, last_sonar = sim.sonar.presets.PRESETS
    assert f"{', '.join(sonars)} or {last_sonar}. [default: physical]" in simulate
    assert f"{' or '.join(sim.engines.opening.ENGINES)}. [default: bullet]" in simulate
    *first, last = sm.rings()
    assert f"{', '.join(first)} or {last}, or a TOML file;" in import_
    for name in FORMATS:
        assert f" {name} (" in import_
    assert "<parameterized|standard>" in map_
    assert {model.value for model in ModelName} == {"parameterized", "standard"}
    assert f"default {P2}." in map_
    assert "ignore|clear" in map_
    assert "odometry|true" in map_


def test_no_command_shows_the_help_and_is_an_error(capsys):
    assert main([]) == 2
    out, err = capsys.readouterr()
    assert "Usage: sonarbed" in out
    assert err == ""


def test_help_loads_nothing_heavy():  # in a fresh process
    heavy = ["numpy", "scipy", "numba", "pyarrow", "pybullet", "matplotlib", "shapely", "PIL"]
    script = (
        "import sys\n"
        "from sonarbed.cli import app, main\n"
        "names = [c.name or c.callback.__name__.strip('_') for c in app.registered_commands]\n"
        "for name in names:\n"
        "    assert main([name, '--help']) == 0\n"
        f"loaded = [name for name in {heavy} if name in sys.modules]\n"
        "sys.exit(f'loaded: {loaded}' if loaded else 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
