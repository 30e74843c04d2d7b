"""In the style of MURIEL: a range profile with detection, pose buckets, a specular hypothesis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, finite, non_negative, positive, within
from sonarmap.grid import GridSpec
from sonarmap.methods.cones import Beams, Cells, NoEcho
from sonarmap.methods.onepass import ConeMethod, Layers, OnePass, OnePassMap, Scene, Votes
from sonarmap.methods.remedies import PoseBuckets
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space
from sonarmap.rings import SonarRing

__all__ = ["KonoligeStyle"]

# Standard deviations before the echo up to which a believed cell may be what was heard.
_CLEAR_SIGMAS = 3.0
_TAIL_SIGMAS = 5.0


@dataclass(frozen=True, kw_only=True)
class KonoligeStyle(ConeMethod, OnePass):
    """Evidence that knows how probably a target is heard, counted once a pose.

    Parameters
    ----------
    detection : float
        Probability that a target right before the sonar is heard, alpha(0), in (0, 1).
    detection_reach_m : float
        Range at which that has fallen to 0, metres, > 0.
    sigma_m, sigma_slope : float
        Standard deviation of the range at 0, metres, > 0, and its growth per metre, >= 0.
    false_share : float
        Probability of a false return within the longest reading, F times it, > 0; with
        `detection` less than 1.
    bucket_rad, bucket_m : float
        Pose buckets: a cell takes only the first reading from each bucket of direction and
        distance, both > 0. `bucket_rad` of 0 is without.
    specular : float
        How far a reading is discounted that crosses what is believed occupied, in [0, 1].
    no_echo
        "clear" by default: detection makes what no echo frees little.
    max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    Read in a text that quotes the paper, with the numbers of its Polaroids::

        h(D | r) = alpha(r) N(D; r, delta(r)),  delta(r) = 0.01 + 0.015 r
        alpha(r) = 0.6 (1 - min(1, 0.25 r))
        p(D first | target at r) = (h(D | r) + F) (1 - integral from 0 to D of (h(x | r) + F))

    so that the log-odds which a reading D adds to a cell at range r are::

        ln((h(D | r) + F) (1 - integral of (h + F)) / (F (1 - F D)))

    and without an echo up to D, ln((1 - alpha(r) - F D) / (1 - F D)). Free evidence weakens with
    range because detection does.

    Ours: alpha falls off the axis by 1 - share^2; F is a share of the longest reading (0.3, which
    is F = 0.1 per metre at 3 m); buckets of 15 degrees and 0.25 m from the cell's side, of which
    the first reading counts; and the specular hypothesis: with q the largest of
    (2 P(occupied) - 1) (1 - share^2) over the cells that the beam crosses more than three sigma
    before D, all that the reading adds is multiplied by 1 - `specular` q.
    """

    name: ClassVar[str] = "konolige-style"
    source: ClassVar[str] = (
        "After Konolige, Improved Occupancy Grids for Map Building, Autonomous Robots 4, 1997, as "
        "quoted by others; buckets and specular hypothesis from its words alone."
    )

    detection: float = 0.6
    detection_reach_m: float = 4.0
    sigma_m: float = 0.01
    sigma_slope: float = 0.015
    false_share: float = 0.3
    bucket_rad: float = math.radians(15)
    bucket_m: float = 0.25
    specular: float = 1.0
    no_echo: NoEcho = "clear"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("detection_reach_m", "sigma_m", "bucket_m"):
            positive(name, getattr(self, name))
        for name in ("sigma_slope", "bucket_rad"):
            non_negative(name, getattr(self, name))
        within("specular", self.specular, 0, 1)
        if not 0 < finite("detection", self.detection) < 1:
            raise InputError(f"detection must be in (0, 1), got {self.detection!r}")
        if not 0 < finite("false_share", self.false_share) < 1 - self.detection:
            raise InputError(
                f"false_share must be in (0, 1 - detection {self.detection:g}), "
                f"got {self.false_share!r}"
            )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "detection": Real(0.05, 0.69),
            "detection_reach_m": Real(1.0, 10.0),
            "sigma_m": Real(0.005, 0.1, log=True),
            "bucket_rad": Real(0.05, 1.5, log=True),
            "specular": Real(0.0, 1.0),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def begin(self, ring: SonarRing, grid: GridSpec, votes: Votes | None = None) -> OnePassMap:
        """Return an empty map; its own pose buckets give way to another remedy."""
        if votes is None and self.bucket_rad > 0:
            longest_m = self.longest_reading_m(ring)
            votes = PoseBuckets(ring, grid, self.bucket_rad, self.bucket_m, longest_m)
        return super().begin(ring, grid, votes)

    def layers(self, scene: Scene) -> Layers:
        """Return log-odds of 0, and no cell seen."""
        return {"log_odds": np.zeros(scene.size), "seen": np.zeros(scene.size, bool)}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the end of the profile's tail; the limit without an echo."""
        sigma_m = self.sigma_m + self.sigma_slope * beams.range_m
        return beams.range_m + np.where(beams.echo, _TAIL_SIGMAS * sigma_m, 0.0)

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Add the log-odds of the profile."""
        from sonarmap.kernels.layers import add_profile  # numba: loaded when mapping

        add_profile(
            layers["log_odds"],
            layers["seen"],
            cells.first,
            cells.cell,
            cells.range_m,
            cells.share,
            beams.range_m,
            beams.echo,
            self.false_share / scene.limit_m,
            self.detection,
            self.detection_reach_m,
            self.sigma_m,
            self.sigma_slope,
            _CLEAR_SIGMAS,
            self.specular,
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map of the log-odds."""
        return self.from_log_odds(scene.grid, layers["log_odds"], layers["seen"])
