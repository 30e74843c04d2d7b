"""How good the network becomes with fewer rooms, and with fewer or more parameters."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from mapper_training.examples import Example
from mapper_training.fitting import Fitting, fit, mean_bits
from sonarmap.files import atomic_path

__all__ = ["ROOM_SHARES", "WIDTHS", "Point", "learning_curve"]

ROOM_SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1)
"""Of the rooms to train on; a drive each."""
WIDTHS = ((8, 12, 18, 26), (16, 24, 37, 53), (24, 36, 56, 80), (32, 48, 75, 107))
"""Of the levels of the U-Net: from a ninth of the parameters to nearly twice as many."""


@dataclass(frozen=True)
class Point:
    """A network of the curve, and how good it is in the rooms that were held out.

    Parameters
    ----------
    rooms : int
        It was fitted to.
    widths : tuple of int
        Of its levels.
    parameters : int
        Its numbers.
    held_out_bits : float
        Map score, bits a cell, mean of the drives.
    """

    rooms: int
    widths: tuple[int, ...]
    parameters: int
    held_out_bits: float


def learning_curve(
    train: Sequence[Example],
    held_out: Sequence[Example],
    fitting: Fitting,
    file: Path,
    *,
    room_shares: Sequence[float] = ROOM_SHARES,
    widths: Sequence[tuple[int, ...]] = WIDTHS,
    on_point: Callable[[Point], None] | None = None,
) -> list[Point]:
    """Return a point for each share of the rooms and each width; what is in the file is kept.

    Parameters
    ----------
    train, held_out : sequence of Example
        Drives of rooms to fit to and of others.
    fitting : Fitting
        How each network is fitted: as many steps, whatever it sees. Its widths are those of the
        points by rooms.
    file : Path
        JSON, a point a line, written after each point.
    room_shares : sequence of float
        Shares of the rooms, each spread over all groups of drives.
    widths : sequence of tuple of int
        Of the points by parameters, which see all rooms.
    on_point : callable, optional
        Called with each point.
    """
    wanted = [(_rooms(share, len(train)), fitting.widths) for share in room_shares]
    wanted += [(len(train), each) for each in widths]
    points = {(point.rooms, point.widths): point for point in _read(file)}
    for rooms, width in dict.fromkeys(wanted):
        if (rooms, width) not in points:
            # Drives lie group by group: every so manieth is of all of them.
            some = [train[k * len(train) // rooms] for k in range(rooms)]
            net = fit(some, [], replace(fitting, widths=width))
            count = sum(each.numel() for each in net.parameters())
            points[rooms, width] = Point(rooms, width, count, mean_bits(net, held_out))
            _write(file, list(points.values()))
        if on_point is not None:
            on_point(points[rooms, width])
    return [points[each] for each in dict.fromkeys(wanted)]


def _rooms(share: float, count: int) -> int:
    return max(round(share * count), 1)


def _read(file: Path) -> list[Point]:
    if not file.exists():
        return []
    told = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    return [Point(**{**each, "widths": tuple(each["widths"])}) for each in told]


def _write(file: Path, points: Sequence[Point]) -> None:
    with atomic_path(file) as beside:
        beside.write_text(
            "".join(json.dumps(asdict(point)) + "\n" for point in points), encoding="utf-8"
        )
