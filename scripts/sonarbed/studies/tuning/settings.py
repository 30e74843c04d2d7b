"""What a search is: its settings, checked where they enter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import worlds
from sim.runs.arguments import MOST_SCANS
from sonarbed.reporting.drives import DriveSpec
from sonarbed.studies.tuning.scoring import SCORES
from sonarbed.studies.tuning.space import MODELS, TARGETS
from sonarmap.errors import InputError, did_you_mean, positive, whole

__all__ = ["SAMPLERS", "TuneSettings", "check_rooms"]

SAMPLERS = ("grid", "nsga2", "tpe", "cmaes")
# Raised when the trials of a study change their meaning: older studies are refused, not mixed.
FORMAT_VERSION = 2


@dataclass(frozen=True)
class TuneSettings:
    """What is searched, how, and by which score of which drives. A study has one of them.

    Parameters
    ----------
    target : str
        "model", "hsr" or "both".
    model : str
        "parameterized" or "standard"; for the target "hsr" it is fixed at the thesis's setting.
    sampler : str
        "grid" (the thesis's 1440 sets), "nsga2", "tpe" or "cmaes".
    score : str
        A name of `SCORES`, over observable cells.
    train : tuple of str
        Rooms whose drives are scored.
    seeds : int
        Drives a room, >= 1.
    scans : int
        Length of a drive, >= 1.
    max_range_m : float or None
        Longer readings are taken as no echo; None for the ring's maximum range.
    """

    target: str
    model: str
    sampler: str
    score: str
    train: tuple[str, ...]
    seeds: int
    scans: int
    max_range_m: float | None = None

    def __post_init__(self) -> None:
        for name, known in (
            ("target", TARGETS),
            ("model", MODELS),
            ("sampler", SAMPLERS),
            ("score", tuple(SCORES)),
        ):
            value = getattr(self, name)
            if value not in known:
                raise InputError(f"{name} {value!r} is unknown{did_you_mean(value, known)}")
        check_rooms("train", self.train)
        for name in ("seeds", "scans"):
            whole(name, getattr(self, name), least=1)
        whole("scans", self.scans, most=MOST_SCANS)
        if self.max_range_m is not None:
            positive("max_range_m", self.max_range_m)
        if self.sampler == "grid" and (self.target, self.model) != ("model", "parameterized"):
            raise InputError(
                "sampler 'grid' is the thesis's search: it needs target 'model' and model "
                f"'parameterized', got {self.target!r} and {self.model!r}"
            )

    @property
    def higher_is_better(self) -> bool:
        """Which way the score runs."""
        return SCORES[self.score]

    def drives(self, rooms: Sequence[str]) -> tuple[DriveSpec, ...]:
        """Return drives of rooms, as long and as many as the search has, by the default driver."""
        return tuple(
            DriveSpec(room, scans=self.scans, seed=seed)
            for room in rooms
            for seed in range(self.seeds)
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what a study keeps of its settings, as JSON-able values."""
        return {
            "format": FORMAT_VERSION,
            "sonarbed": version("sonarbed"),
            **asdict(self),
            "train": list(self.train),
        }

    def difference(self, found: Mapping[str, Any]) -> str | None:
        """Return in words what settings that were found have else, None if they are these."""
        for name, mine in self.to_dict().items():
            if found.get(name) != mine:
                return f"{name} {found.get(name)!r}, asked for {mine!r}"
        return None


def check_rooms(name: str, rooms: Sequence[str]) -> None:
    """Raise `InputError` unless there are rooms, all known, none twice."""
    if not rooms:
        raise InputError(f"{name} must name at least one room")
    for room in rooms:
        if room not in worlds.names():
            raise InputError(
                f"{name}: room {room!r} is unknown{did_you_mean(room, worlds.names())}"
            )
    if len(set(rooms)) != len(rooms):
        raise InputError(f"{name} must name no room twice, got {', '.join(rooms)}")
