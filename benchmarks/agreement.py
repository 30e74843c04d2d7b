"""How far the physical sonar by image sources agrees with rays and with plain arithmetic.

    python benchmarks/agreement.py [ROOMS]

Prints the table of docs/acoustics.md: the eight rooms that ship, then ROOMS generated ones (100)
together. Readings are alike within 1 mm, with one cause, source and number of bounces; of plain
arithmetic, which the tests have as `mirrored_points`, with the range and the bounces. Materials are
smooth, so that no noise differs.
"""

import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import worlds
from benchmarks.images import QUIET, read, stops_in
from worlds import World

STEPS_DEG = (1.0, 0.1, 0.02)
STOPS, ARITHMETIC_STOPS = 40, 3


def main() -> None:
    rooms = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    print("| room | readings | " + " | ".join(f"rays {step:g}°" for step in STEPS_DEG), end="")
    print(" | readings | arithmetic |")
    print("|---" * (len(STEPS_DEG) + 4) + "|")
    for name in worlds.names():
        row(name, [worlds.load(name)], STOPS)
    row(f"{rooms} generated", list(generated(rooms)), 5)


def generated(rooms: int) -> Iterator[World]:
    """Yield rooms of all styles in turn."""
    styles = sorted(worlds.styles())
    for seed in range(rooms):
        yield worlds.generate(styles[seed % len(styles)], seed)


def row(name: str, rooms: list[World], stops: int) -> None:
    """Print the shares of the readings in some rooms that are alike."""
    smooth = [
        room.with_materials([replace(s.material, roughness_m=0.0) for s in room.solids])
        for room in rooms
    ]
    shares = []
    for step_deg in STEPS_DEG:
        alike = np.concatenate([by_rays(room, step_deg, stops) for room in smooth])
        shares.append(f"{alike.mean():.1%}")
    few = ARITHMETIC_STOPS if len(smooth) == 1 else 1
    exact = np.concatenate([by_arithmetic(room, few) for room in smooth])
    print(f"| {name} | {alike.size} | {' | '.join(shares)} | {exact.size} | {exact.mean():.1%} |")


def by_rays(room: World, step_deg: float, count: int) -> np.ndarray:
    """Return which readings are alike by images and by rays."""
    stops = stops_in(room, count)
    rays = QUIET.replace(search="rays", ray_step_rad=math.radians(step_deg))
    alike = []
    for one, other in zip(read(room, rays, stops)[0], read(room, QUIET, stops)[0], strict=True):
        same = np.isclose(one.range_m, other.range_m, rtol=0, atol=1e-3)
        for column in ("cause", "bounces", "source"):
            same &= getattr(one, column) == getattr(other, column)
        alike.append(same)
    return np.concatenate(alike)


def by_arithmetic(room: World, count: int) -> np.ndarray:
    """Return which readings are those of plain mirrored points, each sonar for itself."""
    from mirrored_points import Room, Sonar, first_echo

    plain, alike, ring = Room(room), [], QUIET.ring
    for stop in stops_in(room, count):
        places, axes = ring.sensor_xy_m(slice(None), *stop), stop[2] + ring.heading_rad
        echoes = QUIET.listen(room.faces, room, places, axes, np.random.default_rng(0))
        for k, (place, axis) in enumerate(zip(places, axes, strict=True)):
            sonar = Sonar(QUIET.acoustics, tuple(place), axis)
            range_m, bounces = first_echo(plain, sonar, QUIET.max_bounces)
            if range_m < ring.range_min_m:
                range_m = -math.inf
            same = bool(np.isclose(echoes.range_m[k], range_m, rtol=0, atol=1e-3))
            alike.append(same and (range_m == math.inf or echoes.bounces[k] == bounces))
    return np.array(alike)


if __name__ == "__main__":
    main()
