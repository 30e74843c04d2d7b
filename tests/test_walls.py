"""The walls of the house: imports run one way, without circles, and one file knows the engine."""

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
# The folders of `sim`: each may import itself and those before it.
LAYERS = ["catalogue", "robot", "engines", "sonar", "runs", "datasets", "envs"]
ENGINES = {"pybullet", "pybullet_data", "pybullet_utils"}


def sources(folder):
    return [path for kind in ("*.py", "*.pyi") for path in folder.rglob(kind)]


def module_of(path, folder, package):
    """Return the dotted name of the module in a file below a package's folder."""
    parts = path.relative_to(folder).with_suffix("").parts
    parts = parts[:-1] if parts[-1] == "__init__" else parts
    return ".".join((package, *parts))


def imports(path, module=""):
    """Yield (module, name or None) of all that a file imports, wherever in it, lazily or not.

    A relative import is resolved if the file's own module is given, else left out.
    """
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                if not module:
                    continue
                up = node.level - (path.stem == "__init__")
                package = module.split(".")[: -up or None]
                base = ".".join([*package, *filter(None, [node.module])])
            yield from ((base, alias.name) for alias in node.names)
        elif (
            # importlib.import_module("name") and __import__("name")
            isinstance(node, ast.Call)
            and ast.unparse(node.func).split(".")[-1] in {"import_module", "__import__"}
            and node.args
            and isinstance(node.args[0], ast.Constant)
        ):
            yield str(node.args[0].value), None


def imported(path):
    """Return the top-level packages that a source file imports."""
    return {module.split(".")[0] for module, _ in imports(path)}


def importers_of(names, room):
    folder = ROOT / room
    return sorted(str(path.relative_to(ROOT)) for path in sources(folder) if imported(path) & names)


def graph(folder, package):
    """Return which modules of a package each of them imports, as a mapping of names to sets."""
    files = {path: module_of(path, folder, package) for path in sources(folder)}
    known = set(files.values())
    edges = {module: set() for module in known}
    for path, module in files.items():
        for base, name in imports(path, module):
            whole = f"{base}.{name}"
            target = whole if whole in known else base
            if target in known and target != module:
                edges[module].add(target)
    return edges


def circle(edges):
    """Return the modules of one circle, the first again at its end; empty if there is none."""
    done, path = set(), []

    def visit(module):
        if module in path:
            return [*path[path.index(module) :], module]
        if module in done:
            return []
        path.append(module)
        for target in sorted(edges[module]):
            if found := visit(target):
                return found
        path.pop()
        done.add(module)
        return []

    for module in sorted(edges):
        if found := visit(module):
            return found
    return []


def upward(edges, package, layers):
    """Return "importer -> imported" of all imports from a lower layer of a package to a higher."""

    def layer(module):
        folder = module.removeprefix(f"{package}.").split(".")[0]
        # The package itself, on top, may import all.
        return layers.index(folder) if folder in layers else len(layers)

    return [
        f"{module} -> {target}"
        for module, targets in sorted(edges.items())
        for target in sorted(targets)
        if layer(target) > layer(module)
    ]


def private_imports(folder, package, packages):
    """Return "file: import" of all that a package imports of others that is theirs alone."""
    found = []
    for path in sources(folder):
        for base, name in imports(path, module_of(path, folder, package)):
            parts = [*base.split("."), *([name] if name else [])]
            is_others = parts[0] in packages and parts[0] != package
            if is_others and any(part[0] == "_" and part[:2] != "__" for part in parts):
                found.append(f"{path.relative_to(folder)}: {'.'.join(parts)}")
    return sorted(found)


@pytest.mark.parametrize(("room", "package"), ROOMS.items())
def test_imports_run_one_way(room, package):
    forbidden = {*ORDER[: ORDER.index(package)], "scripts", "tests", "support", "conftest"}
    assert importers_of(forbidden, room) == []


@pytest.mark.parametrize(("room", "package"), ROOMS.items())
def test_imports_have_no_circle(room, package):
    assert " -> ".join(circle(graph(ROOT / room, package))) == ""


def test_layers_of_the_simulator_import_downwards():
    edges = graph(ROOT / "sim", "sim")
    folders = {module.split(".")[1] for module in edges if "." in module}
    assert folders == set(LAYERS)
    assert upward(edges, "sim", LAYERS) == []


@pytest.mark.parametrize(("room", "package"), ROOMS.items())
def test_nothing_private_of_another_package_is_imported(room, package):
    assert private_imports(ROOT / room, package, ORDER) == []


@pytest.mark.parametrize("room", ["sonarmap", "worlds"])
def test_no_simulator_below_sim(room):
    assert importers_of({*ENGINES, "gymnasium"}, room) == []


def test_one_file_imports_the_engine():
    assert importers_of(ENGINES, "scripts") == []
    assert importers_of(ENGINES, "sim") == ["sim/engines/bullet.py"]


def test_the_mapping_core_never_prints_plots_or_exits():
    assert (
        importers_of({"matplotlib", "rich", "typer", "click", "tqdm", "argparse"}, "sonarmap") == []
    )
    for path in sources(ROOT / "sonarmap"):
        calls = {
            ast.unparse(node.func)
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call)
        }
        assert not calls & {"print", "exit", "quit", "sys.exit", "os._exit"}, path


# The checker itself, on small invented packages.


def test_this_test_looks_at_something(tmp_path):
    assert len(sources(ROOT / "sonarmap")) > 10
    assert len(graph(ROOT / "sim", "sim")["sim.runs.simulation"]) > 5
    example = tmp_path / "example.py"
    example.write_text(
        "import sim.engines.bullet as b\nfrom worlds import load\nfrom . import near\n"
        "def later():\n    import pybullet\n    importlib.import_module('gymnasium.envs')\n"
    )
    assert imported(example) == {"sim", "worlds", "pybullet", "gymnasium"}


def drawn(folder, files):
    """Write a small package; return the folder."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


@pytest.mark.parametrize(
    ("files", "found"),
    [
        # a   b -> c
        ({"a.py": "", "b.py": "from p.c import x", "c.py": "import q"}, []),
        # a -> b -> a
        ({"a.py": "import p.b", "b.py": "from p import a"}, ["p.a", "p.b", "p.a"]),
        # a -> d.b -> c -> a, one of them within a function, one for types only
        (
            {
                "a.py": "def f():\n    from p.d import b",
                "d/__init__.py": "",
                "d/b.py": "if TYPE_CHECKING:\n    from ..c import C",
                "c.py": "from .a import f",
            },
            ["p.a", "p.d.b", "p.c", "p.a"],
        ),
        # a package whose stub names a module that asks the package
        (
            {"__init__.pyi": "from .a import x", "__init__.py": "", "a.py": "from p import y"},
            ["p", "p.a", "p"],
        ),
        # a folder and what it holds
        ({"d/__init__.py": "from .b import x", "d/b.py": "import p.d"}, ["p.d", "p.d.b", "p.d"]),
    ],
)
def test_circles_are_found(tmp_path, files, found):
    assert circle(graph(drawn(tmp_path, files), "p")) == found


@pytest.mark.parametrize(
    ("files", "found"),
    [
        ({"low/a.py": "", "high/b.py": "from p.low import a", "__init__.py": "import p.low.a"}, []),
        ({"low/a.py": "from p.high.b import x", "high/b.py": ""}, ["p.low.a -> p.high.b"]),
        (
            {"low/a.py": "def f():\n    import p.high.b", "high/b.py": "import p.low.a"},
            ["p.low.a -> p.high.b"],
        ),
        ({"low/a.py": "from p import x", "__init__.py": ""}, ["p.low.a -> p"]),
    ],
)
def test_imports_upwards_are_found(tmp_path, files, found):
    assert upward(graph(drawn(tmp_path, files), "p"), "p", ["low", "high"]) == found


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("from q import x\nfrom p import _own\nfrom q import __version__", []),
        ("from q import _x", ["a.py: q._x"]),
        ("from q.b import _x as x", ["a.py: q.b._x"]),
        ("import q._b.c", ["a.py: q._b.c"]),
        ("def f():\n    from q._b import x", ["a.py: q._b.x"]),
        ("import numpy._core", []),
    ],
)
def test_private_imports_are_found(tmp_path, text, found):
    assert private_imports(drawn(tmp_path, {"a.py": text}), "p", ["p", "q"]) == found
