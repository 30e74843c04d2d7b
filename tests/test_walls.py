"""The walls of the house: imports run one way, and few files know the physics engine."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Each room may import itself and those after it: scripts, tests -> sim -> worlds -> sonarmap.
ROOMS = {
    "scripts/sonarbed": "sonarbed",
    "sim": "sim",
    "worlds": "worlds",
    "sonarmap": "sonarmap",
}
ORDER = list(ROOMS.values())
ENGINES = {"pybullet", "pybullet_data", "pybullet_utils"}


def imported(path):
    """Return the top-level packages that a source file imports, lazily or not."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module.split(".")[0])
        elif (
            # importlib.import_module("name") and __import__("name")
            isinstance(node, ast.Call)
            and ast.unparse(node.func).split(".")[-1] in {"import_module", "__import__"}
            and node.args
            and isinstance(node.args[0], ast.Constant)
        ):
            names.add(str(node.args[0].value).split(".")[0])
    return names


def sources(room):
    return [path for kind in ("*.py", "*.pyi") for path in (ROOT / room).rglob(kind)]


def importers_of(names, room):
    return sorted(str(path.relative_to(ROOT)) for path in sources(room) if imported(path) & names)


@pytest.mark.parametrize(("room", "package"), ROOMS.items())
def test_imports_run_one_way(room, package):
    forbidden = {*ORDER[: ORDER.index(package)], "scripts", "tests", "support", "conftest"}
    assert importers_of(forbidden, room) == []


@pytest.mark.parametrize("room", ["sonarmap", "worlds"])
def test_no_simulator_below_sim(room):
    assert importers_of({*ENGINES, "gymnasium"}, room) == []


def test_the_engine_has_one_door_of_at_most_two_files():
    assert importers_of(ENGINES, "scripts") == []
    doors = importers_of(ENGINES, "sim")
    assert len(doors) <= 2, doors


def test_the_mapping_core_never_prints_plots_or_exits():
    assert (
        importers_of({"matplotlib", "rich", "typer", "click", "tqdm", "argparse"}, "sonarmap") == []
    )
    for path in sources("sonarmap"):
        calls = {
            ast.unparse(node.func)
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call)
        }
        assert not calls & {"print", "exit", "quit", "sys.exit", "os._exit"}, path


def test_this_test_looks_at_something(tmp_path):
    assert len(sources("sonarmap")) > 10
    example = tmp_path / "example.py"
    example.write_text(
        "import sim.engines.bullet as b\nfrom worlds import load\nfrom . import near\n"
        "def later():\n    import pybullet\n    importlib.import_module('gymnasium.envs')\n"
    )
    assert imported(example) == {"sim", "worlds", "pybullet", "gymnasium"}
