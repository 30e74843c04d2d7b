"""Which rooms and logs the learned mapper is trained on: specs of `sonarbed dataset`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim.datasets import make_dataset, parse_spec
from sonarmap.errors import whole
from sonarmap.files import make_folder

__all__ = ["GROUPS", "STYLES", "make_logs"]

# Twice where the prototype was weak: round and slanted walls, crowded rooms, corridors.
STYLES = {
    "room": 1.0,
    "clutter": 1.5,
    "l-shape": 1.0,
    "polygon": 0.75,
    "round": 1.25,
    "slanted": 1.0,
    "office": 1.25,
    "corridor": 1.5,
    "hall": 0.75,
    "open": 1.0,
}
# What a robot of this project does differently from drive to drive. Ranges are assumed: they hold
# the defaults well inside.
_VARIED: dict[str, Any] = {
    "engine": "segments",
    "scans": {"uniform": [150, 500]},
    "start": {"choice": ["room", "anywhere"]},
    "driver": {
        "choice": ["auto", "route", "wander", "follow-left", "follow-right"],
        "weights": [1, 2, 3, 2, 2],
    },
    "driver_parameters": {"speed_mps": {"uniform": [0.12, 0.28]}},
    "odometry": {
        "slip_std_m": {"log_uniform": [0.0003, 0.003]},
        "turn_spread": {"log_uniform": [0.001, 0.02]},
        "scale_spread": {"log_uniform": [0.001, 0.02]},
    },
}
_IMAGES: dict[str, Any] = {"sonar": "physical", "sonar_parameters": {"search": "images"}}
_RINGS = 48

# Share of the rooms of each group, and what its logs are.
GROUPS: dict[str, tuple[float, dict[str, Any]]] = {
    # The robot of this project.
    "physical": (0.45, {**_IMAGES}),
    # Other gains, transducers and air.
    "gains": (
        0.15,
        {
            **_IMAGES,
            "receiver": {
                "dynamic_range_db": {"uniform": [36, 60]},
                "gain_share": {"uniform": [0.4, 1.0]},
                "noise_std_m": {"log_uniform": [0.0005, 0.01]},
            },
            "air": {"temperature_c": {"uniform": [5, 35]}},
        },
    ),
    # Other rings: any number and place of sonars, any half-angle and range.
    "other-rings": (
        0.15,
        {**_IMAGES, "ring": {"choice": [f"rings/ring-{i:02d}.toml" for i in range(_RINGS)]}},
    ),
    # Values of status packets, stale ones among them, by odometry of the packet.
    "packets": (0.08, {**_IMAGES, "packets": True}),
    # Simple cones: no bounces.
    "cones": (0.17, {"sonar": {"choice": ["thesis", "aria", "webots"]}}),
}


def make_logs(folder: Path, *, rooms: int, seed: int, workers: int) -> list[Path]:
    """Make the logs and return their folders; what is there already is kept.

    Parameters
    ----------
    folder : Path
        Where the data sets go, one a group.
    rooms : int
        How many rooms, about; one log each.
    seed : int
        Of rooms, drives and rings, 0 to 8: rooms from a million on are the arena's.
    workers : int
        Processes.
    """
    whole("seed", seed, least=0, most=8)
    _write_rings(make_folder(folder / "rings"), seed)
    made = []
    for number, (name, (share, logs)) in enumerate(GROUPS.items()):
        spec = parse_spec(
            {
                "name": f"mapper-{name}",
                "seed": seed,
                "pictures": False,
                "rooms": {"generate": list(_rooms(number, share * rooms, seed))},
                "splits": {"validation": 0.12, "test": 0.0},
                "logs": {"seeds": 1, **_VARIED, **logs},
            }
        )
        make_dataset(spec, folder / name, workers=workers, folder=folder)
        made.append(folder / name)
    return made


def _rooms(group: int, count: float, seed: int) -> Iterator[dict[str, Any]]:
    total = sum(STYLES.values())
    # No two groups share a room, and no two seeds of the training do.
    first = 100_000 * (seed + 1) + 10_000 * group
    for style, share in STYLES.items():
        number = max(math.ceil(count * share / total), 1)
        yield {"style": style, "seeds": f"{first}:{first + number}"}


def _write_rings(folder: Path, seed: int) -> None:
    """Write rings of 1 to 24 sonars, even, forward or as it comes, small enough for the robot."""
    rng = np.random.default_rng([seed, 77])
    for number in range(_RINGS):
        count = int(rng.choice([1, 2, 3, 4, 5, 6, 8, 8, 12, 16, 24]))
        kind = rng.integers(3)
        if kind == 0:
            heading = np.arange(count) * 360 / count - 180 + rng.uniform(0, 10)
        elif kind == 1:
            heading = np.linspace(-90, 90, count) if count > 1 else np.zeros(1)
        else:
            heading = rng.uniform(-180, 180, count)
        radius = rng.uniform(0, 0.14)
        lines = [
            f"half_angle_deg = {rng.uniform(6, 25):.2f}",
            f"range_min_m = {rng.uniform(0.02, 0.2):.3f}",
            f"range_max_m = {rng.uniform(2.0, 5.5):.2f}",
        ]
        for deg in heading:
            x, y = radius * math.cos(math.radians(deg)), radius * math.sin(math.radians(deg))
            lines += ["[[sonar]]", f"x_m = {x:.4f}", f"y_m = {y:.4f}", f"heading_deg = {deg:.3f}"]
        (folder / f"ring-{number:02d}.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
