"""Remedies for repeated readings, which any method of evidence can take.

A standing robot's thousandth reading tells no more than its first, but sums of log-odds, products
of masses and counts take each for news. Four remedies, apart or together:

* **Pose buckets**: of all readings that see a cell from one bucket of direction and distance only
  the first counts (the idea of Konolige's MURIEL, 1997).
* **One vote a travel**: a sonar tells a cell something again only after 5 cm of travel.
* **Tempering**: the map's log-odds times a factor below 1, as if that share of the readings had
  been independent.
* **Clamping**: the map's log-odds are bounded.

The first two stand between a beam and the cells that it touches, and so are the same for all
methods; the last two need only a map.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sonarmap.errors import InputError, finite, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.bayes.updating import BayesUpdating, evidence_of, reading_limit_m
from sonarmap.methods.cones import Beams, Cells, beams_of, cone_cells
from sonarmap.methods.conversion import sigmoid
from sonarmap.methods.onepass import EvidenceMethod, Votes
from sonarmap.methods.protocol import MappingMethod
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space
from sonarmap.rings import SonarRing

__all__ = ["AllOf", "OncePerTravel", "PoseBuckets", "Remedied"]


class PoseBuckets:
    """Votes of which each cell takes the first from a bucket of direction and distance.

    Parameters
    ----------
    ring, grid : SonarRing, GridSpec
        Whose readings and which cells.
    bearing_rad : float
        Width of a bucket of directions from the cell to the sonar, rounded to a part of the
        quadrant, so that turns and mirror images keep the buckets.
    distance_m : float
        Width of a bucket of distances.
    longest_m : float, optional
        Longest distance; by default the ring's maximum range.
    """

    def __init__(
        self,
        ring: SonarRing,
        grid: GridSpec,
        bearing_rad: float,
        distance_m: float,
        longest_m: float | None = None,
    ) -> None:
        self._grid, self._distance_m = grid, distance_m
        in_quadrant = max(round(math.pi / 2 / bearing_rad), 1)
        borders_rad = np.arange(1, in_quadrant) * (math.pi / 2 / in_quadrant)
        self._edges = np.column_stack([np.cos(borders_rad), np.sin(borders_rad)])
        longest_m = ring.range_max_m if longest_m is None else longest_m
        distances = int(longest_m / distance_m) + 1
        self._voted = np.zeros((4 * in_quadrant, distances, grid.rows * grid.cols), bool)

    def admit(self, beams: Beams, cells: Cells) -> Cells:
        """Return the cells whose bucket has not voted."""
        from sonarmap.kernels.layers import admit_buckets  # numba: loaded when mapping

        return cells.keep(
            admit_buckets(
                self._voted,
                self._grid.cols,
                *self._grid.origin_xy_m,
                self._grid.resolution_m,
                beams.sensor_xy_m,
                cells.first,
                cells.cell,
                cells.range_m,
                self._edges,
                self._distance_m,
            )
        )


class OncePerTravel:
    """Votes of which each cell takes one from a sonar until the robot has travelled.

    Parameters
    ----------
    ring, grid : SonarRing, GridSpec
        Whose readings and which cells.
    travel_m : float
        Length of the robot's way by odometry after which a sonar may tell a cell something again.
        Turning in place is no travel.
    """

    def __init__(self, ring: SonarRing, grid: GridSpec, travel_m: float) -> None:
        self._travel_m = travel_m
        self._last = np.full((grid.rows * grid.cols, len(ring)), -np.inf)
        self._at: tuple[np.ndarray[Any, Any], float] | None = None

    def admit(self, beams: Beams, cells: Cells) -> Cells:
        """Return the cells that a beam's sonar may tell something again."""
        from sonarmap.kernels.layers import admit_travel  # numba: loaded when mapping

        if len(beams) == 0:
            return cells
        last_xy, so_far_m = (beams.robot_xy_m[0], 0.0) if self._at is None else self._at
        steps = np.diff(beams.robot_xy_m, axis=0, prepend=last_xy[None])
        way_m = so_far_m + np.hypot(steps[:, 0], steps[:, 1]).cumsum()
        self._at = beams.robot_xy_m[-1], float(way_m[-1])
        return cells.keep(
            admit_travel(self._last, beams.sonar, way_m, cells.first, cells.cell, self._travel_m)
        )


class AllOf:
    """Votes that several remedies admit, one after the other."""

    def __init__(self, *votes: Votes) -> None:
        self._votes = votes

    def admit(self, beams: Beams, cells: Cells) -> Cells:
        """Return the cells that all of them admit."""
        for each in self._votes:
            cells = each.admit(beams, cells)
        return cells


@dataclass(frozen=True, kw_only=True)
class Remedied:
    """A mapping method with remedies for repeated readings.

    Parameters
    ----------
    method : MappingMethod
        Buckets and travel need a method of evidence: Bayesian updating, or any `EvidenceMethod`.
    bucket_rad, bucket_m : float, optional
        Widths of the pose buckets, both > 0; given together. By default there are none.
    travel_m : float, optional
        Travel until a sonar may tell a cell something again, metres, > 0. By default none.
    temper : float
        What the map's log-odds are multiplied by, in (0, 1].
    clamp : float
        Bound on the map's absolute log-odds, > 0.
    """

    source: ClassVar[str] = "Ours: remedies that the literature names one by one, side by side."

    method: MappingMethod
    bucket_rad: float | None = None
    bucket_m: float | None = None
    travel_m: float | None = None
    temper: float = 1.0
    clamp: float = math.inf

    def __post_init__(self) -> None:
        for name in ("bucket_rad", "bucket_m", "travel_m"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        if (self.bucket_rad is None) != (self.bucket_m is None):
            raise InputError(
                f"bucket_rad and bucket_m must be given together, "
                f"got {self.bucket_rad!r} and {self.bucket_m!r}"
            )
        if not 0 < finite("temper", self.temper) <= 1:
            raise InputError(f"temper must be in (0, 1], got {self.temper!r}")
        if not self.clamp > 0:
            raise InputError(f"clamp must be > 0, got {self.clamp!r}")
        selects = self.bucket_rad is not None or self.travel_m is not None
        if selects and not isinstance(self.method, (BayesUpdating, EvidenceMethod)):
            raise InputError(
                f"buckets and travel need a method of evidence, got {self.method.name!r}"
            )

    @property
    def name(self) -> str:
        """The method's name and the remedies: "himm, travel 0.05 m"."""
        parts = [self.method.name]
        if self.bucket_rad is not None:
            parts.append(f"buckets {math.degrees(self.bucket_rad):g} deg {self.bucket_m:g} m")
        if self.travel_m is not None:
            parts.append(f"travel {self.travel_m:g} m")
        if self.temper != 1:
            parts.append(f"temper {self.temper:g}")
        if self.clamp < math.inf:
            parts.append(f"clamp {self.clamp:g}")
        return ", ".join(parts)

    def longest_reading_m(self, ring: SonarRing) -> float:
        """Return the range up to which the method uses readings, metres."""
        longest_m = getattr(self.method, "longest_reading_m", None)
        return ring.range_max_m if longest_m is None else float(longest_m(ring))

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid."""
        m = self._selected(log, grid)
        if self.temper == 1 and self.clamp == math.inf:
            return m
        log_odds = (self.temper * m.log_odds).clip(-self.clamp, self.clamp)
        return OccupancyMap.from_probability(
            grid,
            sigmoid(log_odds),
            m.observed,
            occupied_from=m.occupied_from,
            free_up_to=m.free_up_to,
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched of the remedies; the method's own space is apart."""
        return {"temper": Real(0.02, 1.0, log=True), "clamp": Real(0.5, 13.0)}

    def _selected(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        votes: list[Votes] = []
        if self.bucket_rad is not None and self.bucket_m is not None:
            longest_m = self.longest_reading_m(log.ring)
            votes.append(PoseBuckets(log.ring, grid, self.bucket_rad, self.bucket_m, longest_m))
        if self.travel_m is not None:
            votes.append(OncePerTravel(log.ring, grid, self.travel_m))
        if not votes:
            return self.method.map(log, grid)
        if isinstance(self.method, EvidenceMethod):
            return self.method.fuse(log, grid, AllOf(*votes))
        assert isinstance(self.method, BayesUpdating)  # by the rule in __post_init__
        return _updated(self.method, log, grid, AllOf(*votes))


def _updated(method: BayesUpdating, log: SonarLog, grid: GridSpec, votes: Votes) -> OccupancyMap:
    """Return the map of Bayesian updating by a sensor model, of the votes that count."""
    from sonarmap.kernels.fusion import add_listed  # numba: loaded when mapping

    model = method.sensor_model(log.ring)
    limit_m = reading_limit_m(log.ring, model, method.max_range_m)
    beams = beams_of(log, limit_m, method.no_echo)
    _, regions = evidence_of(log, model, limit_m, method.no_echo)
    log_odds, seen, mean, deviation = (np.zeros(grid.rows * grid.cols) for _ in range(4))
    for rows, listed in cone_cells(beams, grid, model.half_angle_rad, regions.reach_m):
        cells = votes.admit(beams.select(rows), listed)
        add_listed(
            log_odds,
            seen,
            mean,
            deviation,
            cells.first,
            cells.first,
            cells.cell,
            np.ones(cells.cell.size, np.int64),  # each cell is a run of its own
            cells.range_m,
            cells.share,
            regions.border_m[rows],
            regions.axis[rows],
            regions.edge[rows],
        )
    # Its bound is on the sum as it grows; of votes that do not repeat it is one on the whole.
    limit = method.log_odds_limit
    return OccupancyMap(grid, log_odds.clip(-limit, limit).reshape(grid.shape))
