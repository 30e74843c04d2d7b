"""`ImageLimits`: which image sources are looked for."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["ImageLimits"]


class ImageLimits(NamedTuple):
    """Which image sources are looked for.

    Parameters
    ----------
    reach_m : float
        Half of the longest path on which any sound is still detected.
    max_bounces : int
        Over how many mirrors.
    wide_rad : float
        Angle off the axis up to which sound that leaves a transducer is followed, < pi / 2.
    least_cross_path_m : float
        The shortest path on which a sonar that does not fire now may detect a sound.
    least_late_path_m : float
        The shortest path on which a sonar may detect its own sound at its next firing.
    is_late : bool
        Whether a sound lasts that long.
    cone_rad, range_max_m : float
        Nominal half-angle and range, for the truths only.
    spare_db : float
        How much louder than a nominal transducer's mirror echo the table of reaches takes sound to
        be: what focuses it, and the most sensitive transducers. What is scattered has no focus.
    edge_reach_m : float
        How far away an edge is detected at most.
    """

    reach_m: float
    max_bounces: int
    wide_rad: float
    least_cross_path_m: float
    least_late_path_m: float
    is_late: bool
    cone_rad: float
    range_max_m: float
    spare_db: float
    edge_reach_m: float
