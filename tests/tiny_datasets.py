"""A small data set that many tests make: tiny logs, the quick engine, a simple sonar."""

import copy

from sim.datasets import parse_spec

TINY = {
    "name": "tiny",
    "rooms": {"names": ["office", "thesis-exp1", "l-shape"]},
    "splits": {"rooms": {"office": "test"}},
    "logs": {
        "seeds": 2,
        "scans": {"uniform": [4, 6]},
        "sonar": "aria",
        "driver": ["wander", "follow-left"],
        "air": {"temperature_c": {"normal": [20, 3], "within": [10, 30]}},
    },
}


def tiny(**changes):
    """Return the tables of the small data set, ``logs__scans=3`` and so on in place."""
    tables = copy.deepcopy(TINY)
    for path, value in changes.items():
        *above, key = path.split("__")
        table = tables
        for part in above:
            table = table.setdefault(part, {})
        table[key] = value
    return tables


def tiny_spec(**changes):
    return parse_spec(tiny(**changes))


def tree(folder):
    """Return the bytes of every file below a folder by its name."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def as_toml(tables, place=""):
    """Return tables as the text of a TOML file; values are numbers, texts, lists and tables."""
    lines = [f"{k} = {_value(v)}" for k, v in tables.items() if not _is_table(v)]
    for key, value in tables.items():
        if _is_table(value):
            path = f"{place}.{key}" if place else key
            lines += ["", f"[{path}]", as_toml(value, path)]
    return "\n".join(lines)


def _is_table(value):
    drawn = {"uniform", "normal", "log_uniform", "choice"}
    return isinstance(value, dict) and not drawn & set(value)


def _value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(value)
