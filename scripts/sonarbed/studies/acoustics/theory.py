"""What theory says of single things in the beam: the distance read, and the arc it is read on.

Written anew from the formulas, without the simulator's steps: a range of constant depth is the
perpendicular distance of a plane, the distance of a corner's or an edge's vertex, and that of a
pillar's axis less its radius (Kuc and Siegel 1987; Leonard and Durrant-Whyte 1992).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim import PhysicalSonar
from sim.sonar import presets as sonars
from sonarmap import InputError
from worlds import MATERIALS

__all__ = [
    "GLASS",
    "LOSS_DB",
    "Locus",
    "as_deviation",
    "as_range",
    "heard_spans_rad",
    "main_half_width_rad",
    "physical",
    "pillar_db",
    "plane_over_db",
    "range_m",
    "sharp",
]


GLASS = replace(MATERIALS["glass"], name="smooth glass", roughness_m=0.0)
"""What things on the bench are made of: a mirror whose roughness adds no noise."""
LOSS_DB = 20 * math.log10(GLASS.reflectivity)
"""What is lost at each reflection by it, decibels, < 0."""


@dataclass(frozen=True)
class Locus:
    """A region of constant depth.

    Parameters
    ----------
    name : str
        What sends the sound back.
    range_m : float
        The distance that it is read at, metres.
    bearing_rad : float
        Where it stands, seen from the sonar, radians.
    level_db : float
        Its level against that of a perfect mirror at the same distance, decibels.
    """

    name: str
    range_m: float
    bearing_rad: float
    level_db: float = 0.0


def physical(name: str) -> PhysicalSonar:
    """Return the preset called `name`, which must have a beam."""
    sonar = sonars.preset(name)
    if not isinstance(sonar, PhysicalSonar):
        raise InputError(f"sonar {name!r} has no beam to compare with theory; take 'physical'")
    return sonar


def sharp(sonar: PhysicalSonar) -> PhysicalSonar:
    """Return a sonar without what theory is silent about: pulse length, noise, whole millimetres.

    What is left differs from theory by errors of the simulator only.
    """
    receiver = replace(
        sonar.receiver, pulse_s=1e-9, noise_std_m=0.0, weak_noise_std_m=0.0, quantum_m=0.0
    )
    return sonar.replace(receiver=receiver)


def plane_over_db(sonar: PhysicalSonar, distance_m: float) -> float:
    """Return how far a perfect mirror's echo, met head-on, stands above the threshold.

    The dynamic range holds at 1 m. Farther away the echo loses 20 log10(r) by spreading and
    twice the absorption on each further metre, of which the gain takes back its share.
    """
    absorption = sonar.air.absorption_db_per_m(sonar.piston.frequency_hz)
    loss_db = 20 * math.log10(distance_m) + 2 * absorption * (distance_m - 1)
    return sonar.receiver.dynamic_range_db - (1 - sonar.receiver.gain_share) * loss_db


def pillar_db(radius_m: float, distance_m: float) -> float:
    """Return the level of a pillar against a plane at the same distance, decibels."""
    return 20 * math.log10(math.sqrt(radius_m / (radius_m + distance_m)))


def heard_spans_rad(sonar: PhysicalSonar, over_db: float) -> list[tuple[float, float]]:
    """Return from where to where off the axis a thing is heard, lobe by lobe, radians.

    Parameters
    ----------
    sonar : PhysicalSonar
        Whose beam.
    over_db : float
        How far the thing's echo on the axis stands above the threshold, decibels.
    """
    angle = np.linspace(0, math.pi / 2, 18001)
    heard = np.concatenate([[False], over_db + 2 * sonar.piston.level_db(angle) > 0, [False]])
    begins, ends = (np.flatnonzero(np.diff(heard.astype(int)) == step) for step in (1, -1))
    return [(float(angle[b]), float(angle[e - 1])) for b, e in zip(begins, ends, strict=True)]


def main_half_width_rad(sonar: PhysicalSonar, locus: Locus) -> float:
    """Return how far off the axis a thing is heard in the main lobe, 0 if not at all."""
    spans = heard_spans_rad(sonar, plane_over_db(sonar, locus.range_m) + locus.level_db)
    return spans[0][1] if spans and spans[0][0] == 0 else 0.0


def as_range(range_m: float, digits: int = 3) -> str:
    """Return a range as tables show it."""
    return f"{range_m:.{digits}f}" if math.isfinite(range_m) else "no echo"


def as_deviation(largest_m: float) -> str:
    """Return a deviation as sentences give it, down to a micrometre."""
    return "below 0.001 mm" if largest_m < 1e-6 else f"{1000 * largest_m:.3f} mm"


def range_m(
    sonar: PhysicalSonar, loci: Sequence[Locus], axis_rad: ArrayLike
) -> NDArray[np.float64]:
    """Return what a sonar reads that turns on the spot: the nearest thing heard, +inf if none."""
    axis = np.asarray(axis_rad, float)
    nearest_m = np.full(axis.shape, np.inf)
    for locus in loci:
        off = np.remainder(axis - locus.bearing_rad + math.pi, 2 * math.pi) - math.pi
        over_db = plane_over_db(sonar, locus.range_m) + locus.level_db
        heard = over_db + 2 * sonar.piston.level_db(off) > 0
        nearest_m = np.where(heard, np.minimum(nearest_m, locus.range_m), nearest_m)
    return nearest_m
