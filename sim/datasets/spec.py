"""`DatasetSpec`: what a data set is made of, as its TOML file says."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictInt,
    StrictStr,
    ValidationInfo,
    field_validator,
    model_validator,
)

from sim.datasets.values import Each, Fixed, Kind, Value, parse_value
from sonarmap.errors import InputError

__all__ = [
    "PARTS",
    "SPLITS",
    "DatasetSpec",
    "GeneratedRooms",
    "LogsTable",
    "RoomsTable",
    "SplitsTable",
    "grid_of",
]

SPLITS = ("train", "validation", "test")
# More is a slip of the pen.
_MOST_SEEDS = 10_000_000
_MOST_SCANS = 1_000_000

# Keys of [logs] that stand by themselves, and what their values are.
_ALONE: Mapping[str, str] = MappingProxyType(
    {
        "driver": "text",
        "sonar": "text",
        "ring": "text",
        "engine": "text",
        "start": "text",
        "scans": "whole",
        "packets": "flag",
    }
)
PARTS = (
    "driver_parameters",
    "sonar_parameters",
    "receiver",
    "transducer",
    "spread",
    "air",
    "odometry",
    "status_packets",
)
"""Tables of [logs] whose keys are parameters of a part of the simulator."""


def _seeds(given: Any) -> range:
    """Return seeds from a number of them, or from ``"FROM:TO"``, TO not included."""
    if isinstance(given, range):
        return given
    seeds = range(0)
    if isinstance(given, int) and not isinstance(given, bool):
        seeds = range(max(given, 0))
    elif isinstance(given, str):
        first, colon, last = given.partition(":")
        if colon and first.strip().isdecimal() and last.strip().isdecimal():
            seeds = range(int(first), int(last))
    if not seeds:
        raise InputError(f'must be how many, or "FROM:TO", at least one seed, got {given!r}')
    if len(seeds) > _MOST_SEEDS:
        raise InputError(f"must be at most {_MOST_SEEDS} seeds, got {given!r}")
    return seeds


Seeds = Annotated[range, BeforeValidator(_seeds)]
Share = Annotated[float, Field(ge=0, le=1, strict=True)]
Text = Annotated[StrictStr, Field(min_length=1)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class GeneratedRooms(_Table):
    """Rooms that ``worlds.generate`` makes: one a seed."""

    style: Text
    seeds: Seeds
    parameters: dict[str, Any] = Field(default_factory=dict)


class RoomsTable(_Table):
    """Which rooms: names and globs of shipped ones, files and globs of files, generated ones."""

    names: tuple[Text, ...] = ()
    files: tuple[Text, ...] = ()
    generate: tuple[GeneratedRooms, ...] = ()

    @model_validator(mode="after")
    def _some(self) -> Self:
        if not (self.names or self.files or self.generate):
            raise InputError("must have names, files or generate")
        return self


class SplitsTable(_Table):
    """Shares of the rooms that are kept for validation and test, and the place of single rooms."""

    validation: Share = 0.1
    test: Share = 0.1
    rooms: dict[str, Literal["train", "validation", "test"]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _at_most_all(self) -> Self:
        if self.validation + self.test > 1:
            raise InputError(
                f"validation and test must be at most 1 together, got {self.validation:g} "
                f"and {self.test:g}"
            )
        return self


class LogsTable(_Table):
    """Which logs are taken in every room."""

    seeds: Seeds = Field(default=range(1))
    driver: Any = Fixed("wander")
    sonar: Any = Fixed("physical")
    ring: Any = None
    engine: Any = Fixed("segments")
    start: Any = Fixed("room")
    scans: Any = Fixed(200)
    packets: Any = Fixed(value=False)
    driver_parameters: dict[str, Any] = Field(default_factory=dict)
    sonar_parameters: dict[str, Any] = Field(default_factory=dict)
    receiver: dict[str, Any] = Field(default_factory=dict)
    transducer: dict[str, Any] = Field(default_factory=dict)
    spread: dict[str, Any] = Field(default_factory=dict)
    air: dict[str, Any] = Field(default_factory=dict)
    odometry: dict[str, Any] = Field(default_factory=dict)
    status_packets: dict[str, Any] = Field(default_factory=dict)

    @field_validator(*_ALONE, mode="before")
    @classmethod
    def _parsed(cls, given: Any, info: ValidationInfo) -> Value:
        return parse_value(given, Kind(_ALONE[str(info.field_name)]))

    @field_validator("start")
    @classmethod
    def _known_start(cls, value: Value) -> Value:
        for each in value.examples:
            if each not in ("room", "anywhere"):
                raise InputError(f"must be 'room' or 'anywhere', got {each!r}")
        return value

    @field_validator("scans")
    @classmethod
    def _some_scans(cls, value: Value) -> Value:
        for each in value.examples:
            if not 1 <= int(each) <= _MOST_SCANS:
                raise InputError(f"must be 1 to {_MOST_SCANS}, got {each!r}")
        return value

    @property
    def alone(self) -> dict[str, Value]:
        """The keys that stand by themselves, those that are not given left out."""
        given = {name: getattr(self, name) for name in _ALONE}
        return {name: value for name, value in given.items() if value is not None}


class DatasetSpec(_Table):
    """A data set, checked key by key; `sim.datasets.read_spec` makes it from a file."""

    name: Annotated[StrictStr, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    description: StrictStr = ""
    license: StrictStr = ""
    creator: StrictStr = ""
    url: StrictStr = ""
    date: StrictStr = ""
    citation: StrictStr = ""
    seed: Annotated[StrictInt, Field(ge=0)] = 0
    pictures: StrictBool = True
    rooms: RoomsTable
    splits: SplitsTable = Field(default_factory=SplitsTable)
    logs: LogsTable = Field(default_factory=LogsTable)


def grid_of(values: Mapping[str, Value]) -> dict[str, tuple[Any, ...]]:
    """Return the keys of which every combination is taken, with their values."""
    return {key: value.values for key, value in values.items() if isinstance(value, Each)}
