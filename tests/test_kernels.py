"""Rules of compiled code that the compiler does not check."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def functions():
    """Yield the functions of which the decorator says that they make no arrays."""
    for path in sorted(ROOT.glob("*/**/*.py")):
        if path.relative_to(ROOT).parts[0] not in ("sonarmap", "worlds", "sim"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and any(
                isinstance(part, ast.keyword) and part.arg == "makes_arrays"
                for decorator in node.decorator_list
                for part in ast.walk(decorator)
            ):
                yield pytest.param(node, id=f"{path.relative_to(ROOT)}:{node.name}")


@pytest.mark.parametrize("function", list(functions()))
def test_what_makes_no_arrays_makes_none(function):
    """Nobody counts references there: an array that is made, or cut out, would be freed or lost."""
    for node in ast.walk(function):
        assert not isinstance(node, ast.Slice), f"line {node.lineno} cuts an array"
        assert not isinstance(node, ast.ListComp | ast.List | ast.Dict | ast.Set)
        made = isinstance(node, ast.Attribute) and (
            (isinstance(node.value, ast.Name) and node.value.id == "np") or node.attr == "copy"
        )
        assert not made, f"line {node.lineno} makes an array"
