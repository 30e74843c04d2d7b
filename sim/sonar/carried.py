"""Another ring for a sonar: `with_ring`."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

import sonarmap as sm
from sim.robot.amigobot import BODY_RADIUS_M
from sim.sonar.firing import InTurn
from sim.sonar.protocol import Sonar
from sonarmap import InputError, SonarRing

__all__ = ["carrying", "find_ring", "with_ring"]


def find_ring(ring: str | Path | SonarRing) -> SonarRing:
    """Return a ring that the simulated robot can carry.

    Parameters
    ----------
    ring : str, Path or SonarRing
        A ring, or what `sonarmap.ring` takes for one: a name, a TOML file, ``module:Name``.

    Raises
    ------
    InputError
        If there is none, or a sonar would sit outside of the robot's body, where it would be in
        the wall before the robot touches it.
    """
    found = ring if isinstance(ring, SonarRing) else sm.ring(ring)
    out_m = np.hypot(found.x_m, found.y_m)
    if out_m.max() > BODY_RADIUS_M:
        sonar = int(out_m.argmax())
        raise InputError(
            f"ring {found.name!r} is larger than the robot: sonar {sonar} sits "
            f"{out_m[sonar]:.3g} m from its centre, its body has a radius of {BODY_RADIUS_M:g} m"
        )
    return found


def with_ring(sonar: Sonar, ring: str | Path | SonarRing | None) -> Sonar:
    """Return a sonar with another ring: its places, cones and ranges; the acoustics stay.

    Parameters
    ----------
    sonar : Sonar
        A frozen dataclass with a field ``ring``, as all that ship are.
    ring : str, Path, SonarRing or None
        See `find_ring`; with None the sonar keeps its own.

    Raises
    ------
    InputError
        If the ring is none, too large, or the sonar takes no other.
    """
    return sonar if ring is None else carrying(sonar, find_ring(ring))


def carrying(sonar: Sonar, ring: SonarRing) -> Sonar:
    """Return a sonar with another ring, of whatever size: a real robot may be larger than ours.

    Raises
    ------
    InputError
        If the sonar takes no other ring.
    """
    taken = set(getattr(sonar, "__dataclass_fields__", ()))
    if "ring" not in taken:
        raise InputError(f"sonar {sonar.name!r} has no field ring: it takes no other ring")
    changes: dict[str, Any] = {"ring": ring}
    firing = sonar.firing
    # One after the other, as many as there are.
    if "firing" in taken and isinstance(firing, InTurn) and len(ring) != len(sonar.ring):
        changes["firing"] = dataclasses.replace(firing, order=tuple(range(len(ring))))
    return dataclasses.replace(sonar, **changes)  # type: ignore[type-var]  # it is a dataclass
