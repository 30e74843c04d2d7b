"""The tables of a world file as pydantic models: which keys there are and what each may hold.

A model checks one table by itself. What holds between tables (names, materials, the start
among the solids) is checked by `worlds.World.of`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictStr,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from sonarmap.errors import InputError, did_you_mean
from worlds.readers.toml.formulas import evaluate

__all__ = [
    "BoxTable",
    "MaterialTable",
    "ParameterTable",
    "PillarTable",
    "StartTable",
    "WallTable",
    "WorldTable",
    "parse_world",
]


def _number(value: object, info: ValidationInfo) -> float:
    """Turn a TOML number, or a formula over the parameters in the context, into a float."""
    if isinstance(value, str) and value.startswith("="):
        return evaluate(value, (info.context or {}).get("parameters", {}))
    return _finite_number(value)


def _finite_number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"must be a number, got {value!r}")
    if not -math.inf < value < math.inf or abs(value) > sys.float_info.max:
        raise InputError(f"must be a finite number, got {value!r}")
    return float(value)


def _positive(value: float) -> float:
    if value <= 0:
        raise InputError(f"must be > 0, got {value:g}")
    return value


def _list_of(count: int, picture: str) -> BeforeValidator:
    def check(value: object) -> object:
        if not isinstance(value, list) or len(value) != count:
            raise InputError(f"must be {picture}, got {value!r}")
        return value

    return BeforeValidator(check)


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[Number, AfterValidator(_positive)]
Point = Annotated[tuple[Number, Number], _list_of(2, "[x, y]")]
Size = Annotated[tuple[Positive, Positive], _list_of(2, "[length, width]")]
Bounds = Annotated[tuple[Number, Number, Number, Number], _list_of(4, "[xmin, ymin, xmax, ymax]")]


class _Table(BaseModel):
    """A table of the file; `notes` says of its keys what is assumed or where it comes from."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    notes: dict[str, StrictStr] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _keys_are_known(cls, data: Any) -> Any:
        # Checked here and not by `extra` alone, so that a misspelt key is reported as such
        # and not as the absence of the key that was meant.
        for key in data if isinstance(data, dict) else ():
            if key not in cls.model_fields:
                raise _fault(key, f"unknown key{did_you_mean(key, cls.model_fields)}")
        return data

    @model_validator(mode="after")
    def _notes_have_keys(self) -> _Table:
        _check_notes(self.notes, self.model_fields_set - {"notes"})
        return self


class StartTable(_Table):
    """Where the robot stands when a drive begins."""

    x_m: Number
    y_m: Number
    heading_deg: Number


class MaterialTable(_Table):
    """A material of the room's own."""

    critical_incidence_deg: Number
    reflectivity: Number
    roughness_mm: Number
    diffuse_floor_db: Number = -60.0

    @model_validator(mode="after")
    def _values_are_physical(self) -> MaterialTable:
        if not 0 < self.critical_incidence_deg <= 90:
            raise _fault(
                "critical_incidence_deg",
                f"must be within (0, 90], got {self.critical_incidence_deg:g}",
            )
        if not 0 <= self.reflectivity <= 1:
            raise _fault("reflectivity", f"must be within [0, 1], got {self.reflectivity:g}")
        if self.roughness_mm < 0:
            raise _fault("roughness_mm", f"must be >= 0, got {self.roughness_mm:g}")
        if not -100 <= self.diffuse_floor_db <= 0:
            raise _fault(
                "diffuse_floor_db", f"must be within [-100, 0], got {self.diffuse_floor_db:g}"
            )
        return self


class _SolidTable(_Table):
    name: StrictStr
    height_m: Positive
    material: StrictStr


class WallTable(_SolidTable):
    """A polyline with a thickness, which lies on the named side of the line as it is drawn."""

    points_m: tuple[Point, ...]
    closed: StrictBool = False
    thickness_m: Positive
    side: Literal["centre", "left", "right"] = "centre"


class BoxTable(_SolidTable):
    """A rectangle, its length along the heading."""

    centre_m: Point
    size_m: Size
    heading_deg: Number = 0.0


class PillarTable(_SolidTable):
    """A round post."""

    centre_m: Point
    radius_m: Positive


class ParameterTable(_Table):
    """A number that may be set when the room is loaded, with the limits it must keep."""

    default: Number
    minimum: Number = -math.inf
    maximum: Number = math.inf

    @model_validator(mode="after")
    def _default_keeps_limits(self) -> ParameterTable:
        self.kept(self.default)
        return self

    def kept(self, value: float) -> float:
        """Return `value` if it keeps the limits, else raise `InputError`."""
        if not self.minimum <= value <= self.maximum:
            raise InputError(f"must be within [{self.minimum:g}, {self.maximum:g}], got {value:g}")
        return value


def _default_alone(value: object) -> object:
    return value if isinstance(value, dict) else {"default": value}


class ParametersTable(BaseModel):
    """The room's parameters: any name, either a default number or a `ParameterTable`."""

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, Annotated[ParameterTable, BeforeValidator(_default_alone)]]

    notes: dict[str, StrictStr] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _names_and_notes(self) -> ParametersTable:
        for name in self.__pydantic_extra__:
            if not name.isidentifier():
                raise _fault(name, "a parameter's name is made of letters, digits and _")
        _check_notes(self.notes, self.__pydantic_extra__)
        return self

    @property
    def by_name(self) -> Mapping[str, ParameterTable]:
        """The parameters by their names."""
        return self.__pydantic_extra__


class WorldTable(_Table):
    """A whole world file."""

    title: StrictStr
    source: StrictStr
    bounds_m: Bounds
    start: StartTable
    route_m: tuple[Point, ...] = ()
    wall: tuple[WallTable, ...] = ()
    box: tuple[BoxTable, ...] = ()
    pillar: tuple[PillarTable, ...] = ()
    materials: dict[str, MaterialTable] = Field(default_factory=dict)
    parameters: ParametersTable = Field(default_factory=ParametersTable)


class _ParametersOnly(BaseModel):
    parameters: ParametersTable = Field(default_factory=ParametersTable)


def parse_world(
    data: Mapping[str, Any], overrides: Mapping[str, float]
) -> tuple[WorldTable, dict[str, float]]:
    """Return the checked tables of a world file, formulas computed, and the parameters' values.

    Parameters
    ----------
    data : mapping
        The file as TOML reads it.
    overrides : mapping of str to float
        Parameters to set in place of their defaults.

    Raises
    ------
    InputError
        For the first fault, as ``key: rule``.
    """
    try:
        # The parameters come first, for every other number may be a formula over them.
        parameters = _ParametersOnly.model_validate(data).parameters.by_name
        values = _parameter_values(parameters, overrides)
        return WorldTable.model_validate(data, context={"parameters": values}), values
    except ValidationError as error:
        raise InputError(_one_line(error.errors()[0])) from None


def _parameter_values(
    parameters: Mapping[str, ParameterTable], overrides: Mapping[str, float]
) -> dict[str, float]:
    for name in overrides:
        if name not in parameters:
            hint = did_you_mean(name, parameters) if parameters else "; this room has none"
            raise InputError(f"unknown parameter {name!r}{hint}")
    values = {name: parameter.default for name, parameter in parameters.items()}
    for name, value in overrides.items():
        try:
            values[name] = parameters[name].kept(_finite_number(value))
        except InputError as error:
            raise InputError(f"parameter {name} {error}") from None
    return values


def _check_notes(notes: Iterable[str], keys: Iterable[str]) -> None:
    known = set(keys)
    for key in notes:
        if key not in known:
            raise _fault(f"notes.{key}", f"no such key in this table{did_you_mean(key, known)}")


def _fault(key: str, rule: str) -> PydanticCustomError:
    """Return the fault of a `key` below the table that is being checked."""
    return PydanticCustomError("fault", "{rule}", {"key": key, "rule": rule})


# Pydantic's own words for the faults that its types find, in the words of this package.
_RULES: Mapping[str, str] = MappingProxyType(
    {
        "missing": "this key is missing",
        "string_type": "must be a text, got {input!r}",
        "bool_type": "must be true or false, got {input!r}",
        "literal_error": "must be {expected}, got {input!r}",
        "tuple_type": "must be a list, got {input!r}",
        "dict_type": "must be a table, got {input!r}",
        "model_type": "must be a table, got {input!r}",
    }
)


def _one_line(error: ErrorDetails) -> str:
    context = error.get("ctx", {})
    steps = [*error["loc"], *([context["key"]] if "key" in context else [])]
    place = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    if error["type"] == "value_error":
        rule = str(context["error"])
    elif error["type"] in _RULES:
        rule = _RULES[error["type"]].format(input=error["input"], **context)
    else:
        rule = error["msg"]
    return f"{place.removeprefix('.')}: {rule}"
