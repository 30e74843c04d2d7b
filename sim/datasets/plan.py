"""`Plan`: which logs a spec asks for, checked before any of them is taken."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from sim.datasets.logs import LogJob, version_here
from sim.datasets.parts import (
    FIXED_PARTS,
    SONAR_FIELDS,
    make_driver,
    make_sonar,
    odometry_of,
    packets_of,
    settable,
)
from sim.datasets.rooms import RoomSource, check_style, room_count, room_sources
from sim.datasets.spec import PARTS, DatasetSpec, grid_of
from sim.datasets.values import Drawn, Fixed, Value, parse_value
from sim.engines.opening import ENGINES
from sim.robot import drivers
from sim.runs.jobs import digest_of
from sim.sonar import presets
from sim.sonar.carried import find_ring
from sim.sonar.firing import check_firing
from sonarmap import InputError, SonarRing
from sonarmap.errors import did_you_mean
from worlds import Solid, World

__all__ = ["Plan", "plan_of"]

FORMAT = 1
"""Raised when the files of a data set change their meaning: older folders are refused."""

# Where drivers and sonars are tried on: a box with a route.
_BOX = World.of(
    "box",
    [
        Solid.wall(
            "wall",
            [(0, 0), (4, 0), (4, 4), (0, 4)],
            closed=True,
            thickness_m=0.1,
            side="right",
            height_m=2.0,
            material="plaster",
        )
    ],
    bounds_m=(-0.2, -0.2, 4.2, 4.2),
    start=(2.0, 2.0, 0.0),
    route_m=[(1.0, 2.0)],
)


@dataclass(frozen=True, eq=False)
class Plan:
    """The logs of a data set, in an order that never changes.

    Parameters
    ----------
    spec : DatasetSpec
        What is asked for.
    folder : Path
        Where its paths begin.
    values : mapping of str to Value
        What each key of [logs] stands for; those of its tables as ``table.key``.
    rings : mapping of str to SonarRing
        By the names that the spec gives them.
    """

    spec: DatasetSpec
    folder: Path
    values: Mapping[str, Value]
    rings: Mapping[str, SonarRing]

    def rooms(self) -> Iterator[RoomSource]:
        """Yield the rooms; of generated ones there may be millions."""
        return room_sources(self.spec.rooms, self.folder)

    @cached_property
    def room_count(self) -> int:
        """How many rooms there are."""
        return room_count(self.spec.rooms, self.folder)

    @cached_property
    def logs_per_room(self) -> int:
        """How many logs are taken in a room."""
        return len(self.spec.logs.seeds) * math.prod(map(len, grid_of(self.values).values()))

    @property
    def log_count(self) -> int:
        """How many logs there are."""
        return self.room_count * self.logs_per_room

    def split_of(self, room: RoomSource) -> str:
        """Return the split of a room.

        It depends on the room and the seed alone: other rooms that are added do not change it, and
        a copy of the room by another name falls into the same one.
        """
        splits = self.spec.splits
        if room.name in splits.rooms:
            return splits.rooms[room.name]
        drawn = sha256(f"{self.spec.seed}:{room.key}".encode()).hexdigest()
        share = int(drawn[:13], 16) / 16**13
        if share < splits.test:
            return "test"
        return "validation" if share < splits.test + splits.validation else "train"

    def logs_of(self, room: RoomSource) -> Iterator[LogJob]:
        """Yield the logs of a room: every combination of the lists, with every seed."""
        split = self.split_of(room)
        grid = grid_of(self.values)
        drawn = {key: value for key, value in self.values.items() if isinstance(value, Drawn)}
        number = 0
        for combination in product(*grid.values()):
            chosen = dict(zip(grid, combination, strict=True))
            for seed in self.spec.logs.seeds:
                rng = self._rng(room, combination, seed)
                drive_seed = int(rng.integers(2**31))
                draws = {key: value.draw(rng) for key, value in drawn.items()}
                settings = {
                    key: value.value if isinstance(value, Fixed) else {**chosen, **draws}[key]
                    for key, value in self.values.items()
                }
                ring = self.rings.get(str(settings.pop("ring", None)))
                yield LogJob(room, split, number, drive_seed, tuple(settings.items()), ring)
                number += 1

    def _rng(
        self, room: RoomSource, combination: tuple[Any, ...], seed: int
    ) -> np.random.Generator:
        """Return the generator of one log, which does not depend on the others."""
        which = repr((self.spec.seed, room.key, combination, seed)).encode()
        return np.random.default_rng(int.from_bytes(sha256(which).digest()[:16], "little"))

    @cached_property
    def identity(self) -> Mapping[str, Any]:
        """All that decides the logs, as JSON-able values: a folder has one."""
        spec = self.spec
        table = spec.rooms.model_copy(update={"generate": ()})
        files = [(room.name, room.key) for room in room_sources(table, self.folder)]
        return {
            "format": FORMAT,
            "sonarbed": version_here(),
            "name": spec.name,
            "seed": spec.seed,
            "rooms": {
                "files": len(files),
                "sha256": digest_of({"files": files}),
                "generate": [
                    {"style": g.style, "seeds": _text(g.seeds), "parameters": g.parameters}
                    for g in spec.rooms.generate
                ],
            },
            "splits": spec.splits.model_dump(),
            "seeds": _text(spec.logs.seeds),
            "logs": {key: _plain(value) for key, value in self.values.items()},
            "rings": {name: ring.to_dict() for name, ring in self.rings.items()},
        }


def plan_of(spec: DatasetSpec, folder: Path) -> Plan:
    """Return the plan of a spec whose paths begin at `folder`.

    Raises
    ------
    InputError
        ``key: rule`` for whatever is unknown or could not be made: names, parameters that no part
        has, values that a part refuses, rooms that are not there, a ring larger than the robot.
    """
    values = dict(spec.logs.alone)
    _check_names(values)
    rings = _rings(values, folder)
    values |= _tables(spec, values, rings)
    _try_parts(values, rings)
    for i, entry in enumerate(spec.rooms.generate):
        _placed(f"rooms.generate[{i}]", lambda entry=entry: check_style(entry))
    plan = Plan(spec, folder, MappingProxyType(values), MappingProxyType(rings))
    names = set(spec.splits.rooms)
    if names or spec.rooms.names or spec.rooms.files:
        known = set()
        for room in plan.rooms():
            known.add(room.name)
            names.discard(room.name)
            if not names and len(known) > 10_000:
                break
        for name in sorted(names):
            raise InputError(f"splits.rooms.{name}: unknown room{did_you_mean(name, known)}")
    return plan


def _check_names(values: Mapping[str, Value]) -> None:
    for key, known in (
        ("driver", drivers.DRIVERS),
        ("sonar", presets.PRESETS),
        ("engine", ENGINES),
    ):
        for name in values[key].examples:
            _placed(f"logs.{key}", lambda name=name, known=known: known.find(str(name)))


def _rings(values: Mapping[str, Value], folder: Path) -> dict[str, SonarRing]:
    if "ring" not in values:
        return {}
    return {
        str(name): _placed("logs.ring", lambda name=name: _ring(str(name), folder))
        for name in values["ring"].examples
    }


def _ring(name: str, folder: Path) -> SonarRing:
    """Return the ring that a spec names; the path of a file begins at the spec's folder."""
    return find_ring(folder / name if name.lower().endswith(".toml") else name)


def _tables(
    spec: DatasetSpec, alone: Mapping[str, Value], rings: Mapping[str, SonarRing]
) -> dict[str, Value]:
    """Return what the keys of the tables of [logs] stand for."""
    ring = next(iter(rings.values()), None)
    made: dict[str, list[object]] = {
        "driver_parameters": [
            _placed("logs.driver", lambda n=name: make_driver({"driver": n}, _BOX))
            for name in alone["driver"].examples
        ],
        "sonar_parameters": [
            _placed("logs.sonar", lambda n=name: make_sonar({"sonar": n}, ring))
            for name in alone["sonar"].examples
        ],
        **{name: [part] for name, part in FIXED_PARTS.items()},
    }
    values: dict[str, Value] = {}
    for table in PARTS:
        given = getattr(spec.logs, table)
        known = {k: v for part in made[table] for k, v in settable(part).items()}
        for key, value in given.items():
            place = f"logs.{table}.{key}"
            if key not in known:
                hint = did_you_mean(key, known) if known else "; there are none to set"
                raise InputError(f"{place}: unknown key{hint}")
            values[f"{table}.{key}"] = _placed(
                place, lambda v=value, kind=known[key]: parse_value(v, kind)
            )
        if given and table in SONAR_FIELDS:
            sonars = made["sonar_parameters"]
            if not any(hasattr(sonar, SONAR_FIELDS[table]) for sonar in sonars):
                raise InputError(f"logs.{table}: none of the sonars has a {table}")
        if given and table == "status_packets" and True not in alone["packets"].examples:
            raise InputError("logs.status_packets: needs packets = true")
    return values


def _try_parts(values: Mapping[str, Value], rings: Mapping[str, SonarRing]) -> None:
    """Make every part with the extremes of every key, one after the other."""
    usual = {key: value.examples[0] for key, value in values.items()}

    def make(settings: Mapping[str, Any]) -> None:
        ring = rings.get(str(settings.get("ring")))
        for sonar in values["sonar"].examples:
            made = make_sonar({**settings, "sonar": sonar}, ring)
            check_firing(made.firing, len(made.ring))
        for driver in values["driver"].examples:
            make_driver({**settings, "driver": driver}, _BOX)
        odometry_of(settings)
        packets_of({**settings, "packets": True})

    # First what is fixed, so that its complaint names it and not another.
    base = {key: value for key, value in usual.items() if "." not in key}
    _placed("logs", lambda: make(base))
    for key, value in values.items():
        tried = value.examples if len(value.examples) <= 100 else value.examples[:100]
        for example in tried:
            _placed(f"logs.{key}", lambda k=key, e=example: make({**base, k: e}))
    _placed("logs", lambda: make(usual))


def _placed(place: str, make: Any) -> Any:
    """Return what `make` returns; its complaint begins with the place."""
    try:
        return make()
    except InputError as error:
        text = str(error)
        key = place.rpartition(".")[2]
        # "dynamic_range_db must be > 0" is said of the key itself.
        text = text.removeprefix(f"{key} ") if text.startswith(f"{key} must") else text
        raise InputError(f"{place}: {text}") from None
    except (TypeError, ValueError, ArithmeticError) as error:
        raise InputError(f"{place}: {' '.join(str(error).split())}") from None


def _text(seeds: range) -> str:
    return f"{seeds.start}:{seeds.stop}"


def _plain(value: Any) -> Any:
    return {"kind": type(value).__name__, **dataclasses.asdict(value)}
