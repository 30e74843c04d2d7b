"""The thesis's two experiments with HSR: rooms, openings and parameters."""

from __future__ import annotations

from dataclasses import dataclass

import sonarmap as sm

__all__ = ["EXPERIMENTS", "TARGET_DISTANCE_M", "Experiment", "Opening", "WallPair"]

# Smallest and largest wall, millimetres: the thesis's own unit for them.
WallPair = tuple[int, int]

TARGET_DISTANCE_M = 0.06


@dataclass(frozen=True, slots=True)
class Opening:
    """A gap in a wall.

    Parameters
    ----------
    name : str
        Its name.
    box_m : tuple of float
        (x_min, y_min, x_max, y_max) of the strip in which it is looked for: 0.1 m on both sides
        of the line of the wall's inner face, as wide as the gap.
    runs_along_x : bool
        Whether its wall runs along x, else along y.
    """

    name: str
    box_m: tuple[float, float, float, float]
    runs_along_x: bool


@dataclass(frozen=True)
class Experiment:
    """One of the thesis's two experiments.

    Parameters
    ----------
    number : int
        1 or 2.
    room : str
        Our room for it.
    threshold_m : float or None
        Rth; None for the maximum range of the sonar.
    thesis : tuple of int
        The pair the thesis settles on.
    shown : tuple of Pair
        Other pairs of the thesis's figure.
    openings : tuple of Opening
        The gaps in its walls.
    glass : str or None
        Name of the wall that is of glass.
    """

    number: int
    room: str
    threshold_m: float | None
    thesis: WallPair
    shown: tuple[WallPair, ...]
    openings: tuple[Opening, ...] = ()
    glass: str | None = None

    def params(self, pair: WallPair, ring: sm.SonarRing) -> sm.HsrParams:
        """Return the parameters of HSR for a pair."""
        threshold_m = ring.range_max_m if self.threshold_m is None else self.threshold_m
        return sm.HsrParams(pair[0] / 1000, pair[1] / 1000, threshold_m, TARGET_DISTANCE_M)


EXPERIMENTS = (
    # Figure 6.15: (b) below, (c) within and (d) above table 6.1.
    Experiment(1, "thesis-exp1", None, (20, 120), ((10, 30), (30, 140))),
    # Figure 6.16: (e) is the thesis's best; 20-80 is its choice in section 6.2, and 20-200 is of
    # the sizes that "abolish the openings".
    Experiment(
        2,
        "thesis-exp2",
        0.8,
        (10, 80),
        ((20, 80), (20, 200)),
        (
            Opening("D1", (0.75, 2.1, 1.55, 2.3), runs_along_x=True),
            Opening("D2", (-0.1, 0.7, 0.1, 1.5), runs_along_x=False),
            Opening("third hole", (2.2, 0.6, 2.4, 1.6), runs_along_x=False),
        ),
        "glass",
    ),
)
