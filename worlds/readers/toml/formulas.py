"""Formulas of world files: arithmetic over a room's parameters, and nothing else."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from types import MappingProxyType

from sonarmap.errors import InputError, did_you_mean

__all__ = ["evaluate"]

_OPERATIONS: Mapping[type[ast.operator], Callable[[float, float], float]] = MappingProxyType(
    {
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: operator.truediv,
    }
)


def evaluate(formula: str, parameters: Mapping[str, float]) -> float:
    """Return the value of a formula such as ``"= -gap_m / 2"``.

    Parameters
    ----------
    formula : str
        Text that starts with ``=``: numbers, parameters, ``+ - * /``, parentheses and minus
        signs.
    parameters : mapping of str to float
        The values that names stand for.

    Raises
    ------
    InputError
        If the text is anything else, names an unknown parameter, or has no finite value.
    """
    try:
        tree = ast.parse(formula.removeprefix("=").strip(), mode="eval")
        value = _value(tree.body, parameters)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        rule = error if isinstance(error, InputError) else "only numbers, parameters and + - * / ()"
        raise InputError(f"bad formula {formula!r}: {rule}") from None
    except (ZeroDivisionError, OverflowError):
        raise InputError(f"bad formula {formula!r}: it has no finite value") from None
    if not math.isfinite(value):
        raise InputError(f"bad formula {formula!r}: it has no finite value")
    return value


def _value(node: ast.expr, parameters: Mapping[str, float]) -> float:
    match node:
        # bool is an int to Python, but True is no number of a world file.
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return float(number)
        case ast.Name(id=name) if name in parameters:
            return parameters[name]
        case ast.Name(id=name):
            hint = did_you_mean(name, parameters) if parameters else "; the room has none"
            raise InputError(f"unknown parameter {name!r}{hint}")
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, parameters)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATIONS:
            return _OPERATIONS[type(op)](_value(left, parameters), _value(right, parameters))
    raise InputError("only numbers, parameters and + - * / ()")
