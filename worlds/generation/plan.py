"""`Plan`: a generated room as the tables of its file; the file and the world are made from it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from worlds.readers.toml.reader import world_of
from worlds.world import World

__all__ = ["Plan"]

# A list of points goes on lines of this length.
_LINE = 100


@dataclass(frozen=True, eq=False)
class Plan:
    """A room as it is drawn, before it is a world.

    Parameters
    ----------
    name : str
        Its name, that of its file.
    remarks : tuple of str
        Lines of comment at the head of the file.
    tables : mapping
        The tables of its file, as TOML reads them.
    """

    name: str
    remarks: tuple[str, ...]
    tables: Mapping[str, Any]

    def world(self) -> World:
        """Return the world, the same as of the file."""
        return world_of(self.name, self.tables)

    def to_toml(self) -> str:
        """Return the text of the file."""
        lines = [*_pairs({k: v for k, v in self.tables.items() if not _is_table(v)})]
        lines[:0] = [f"# {remark}".rstrip() for remark in self.remarks]
        for key, value in self.tables.items():
            if isinstance(value, Mapping) and key != "notes":
                lines += ["", f"[{key}]", *_pairs(value)]
        for key, value in self.tables.items():
            for entry in value if _is_table(value) and isinstance(value, list) else ():
                lines += ["", f"[[{key}]]", *_pairs(entry)]
        return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    if isinstance(value, Mapping):
        return "x_m" in value  # notes are written on one line
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def _pairs(table: Mapping[str, Any]) -> Iterator[str]:
    for key, value in table.items():
        yield from _pair(key, value)


def _pair(key: str, value: Any) -> Iterator[str]:
    line = f"{key} = {_text(value)}"
    if len(line) <= _LINE or not isinstance(value, list):
        yield line
        return
    yield f"{key} = ["
    row = " "
    for item in value:
        text = f" {_text(item)},"
        if len(row) + len(text) > _LINE:
            yield row
            row = " "
        row += text
    yield row
    yield "]"


def _text(value: Any) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            # A text of JSON is one of TOML, but for this one character.
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        case Mapping():
            return "{ " + ", ".join(f"{key} = {_text(each)}" for key, each in value.items()) + " }"
        case list() | tuple():
            return "[" + ", ".join(_text(each) for each in value) + "]"
        case int() | float() if math.isfinite(value):
            return repr(value)
    raise TypeError(f"no TOML for {value!r}")
