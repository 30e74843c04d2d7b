"""HSR, "handling specular reflection": repair a log's readings by one another.

Rashid 2006, chapter 6 and appendix A. A short reading vouches for a piece of wall around its
data point, across its axis. A longer reading that would have to pass through such a wall is
taken for a specular one and cut to the wall. The steps carry the paper's names: processing
readings, estimating variant walls, updating; `hsr` is the paper's ``runHSR``.

Where the paper leaves a gap, these are the rules:

* A line is sampled at n + 1 points, n = ceil(max(abs(dx), abs(dy)) / 1 mm), ends included.
* A reading without echo is searched up to 5.000 m, the code that the AmigoBot itself gives for
  no echo, or up to the ring's maximum range when that is longer. It marks no cell. When it is
  not updated it stays +inf.
* A reading that is too close (-inf), stale or rejected takes no part: it vouches for nothing and is
  not updated. Its robot and sensor position do take part, for the robot was there.
* The length of an estimated wall follows the paper's line also for a reading below the ring's
  minimum range (a little less than `min_wall_m` there), but is never less than 0.
* The paper's ``(xr, yr)`` in the test of the target distance, and its ``(x, y)`` in the new
  reading, are both the sampled point, in metres: the same point decides and becomes the reading.
* ES is fixed during a pass, so that the paper's order (longest reading first) changes nothing.
* The second pass is compared with the first ("less than the pass before"), as section 6.4 says;
  the appendix starts that comparison at infinity and so lets the second pass be any number.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import IntEnum, StrEnum
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, non_negative, positive
from sonarmap.filters.protocol import Filtered
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.parameters import Real, Space
from sonarmap.rings import AMIGOBOT, SonarRing

__all__ = [
    "EstimatedWalls",
    "Hsr",
    "HsrParams",
    "HsrResult",
    "HsrStop",
    "Mark",
    "estimate_variant_walls",
    "hsr",
]

# ARIA's AmigoBot reports 5000 mm when it hears nothing.
NO_ECHO_M = 5.0
# A new pass must change more than this share of the first pass's count (Rashid 2006, p. 58).
LEAST_SHARE = 0.1
# A door of 0.8 m is sure to be seen from no farther (Rashid 2006, sections 6.2 and 6.4.2).
OPENINGS_THRESHOLD_M = 0.8


class Mark(IntEnum):
    """What a cell of ES holds, weakest first."""

    NOTHING = 0
    WALL = 1
    """Estimated wall."""
    READING = 2
    """Data point of a reading up to the threshold."""
    POSITION = 3
    """Robot or sensor; never ends a search."""


class HsrStop(StrEnum):
    """Why no further pass was made or kept."""

    NOTHING_CHANGED = "nothing changed"
    TOO_FEW = "not more than 10 % of the first pass"
    NOT_LESS = "not less than the pass before"
    MAX_PASSES = "max passes"


@dataclass(frozen=True, slots=True)
class HsrParams:
    """Parameters of HSR (Rashid 2006, section 6.2).

    Parameters
    ----------
    min_wall_m, max_wall_m : float
        Length of the estimated wall of a reading at the ring's minimum and maximum range,
        metres, 0 <= min <= max.
    threshold_m : float
        Rth: readings up to it are marked and vouch for a wall, metres, > 0 and at most the
        ring's maximum range.
    target_distance_m : float
        TDTh: a mark this near to the data point denotes the same thing and changes nothing,
        metres, >= 0.
    cell_m : float
        Side of a cell of ES, metres, > 0.
    max_passes : int
        Number of passes at most, >= 1.
    """

    min_wall_m: float
    max_wall_m: float
    threshold_m: float
    target_distance_m: float
    cell_m: float = 0.01
    max_passes: int = 20

    def __post_init__(self) -> None:
        checks = {
            "min_wall_m": non_negative,
            "max_wall_m": non_negative,
            "threshold_m": positive,
            "target_distance_m": non_negative,
            "cell_m": positive,
        }
        for name, check in checks.items():
            object.__setattr__(self, name, check(name, getattr(self, name)))
        if self.min_wall_m > self.max_wall_m:
            raise InputError(
                f"min_wall_m must be <= max_wall_m, got {self.min_wall_m!r} and {self.max_wall_m!r}"
            )
        passes = positive("max_passes", self.max_passes)
        if passes != int(passes):
            raise InputError(f"max_passes must be a whole number, got {self.max_passes!r}")
        object.__setattr__(self, "max_passes", int(passes))

    @classmethod
    def thesis(cls, ring: SonarRing = AMIGOBOT) -> HsrParams:
        """Return the thesis's setting for a ring: walls of 20 to 150 mm, no threshold, 60 mm.

        Table 6.1 gives 20 mm and 110 to 190 mm for the walls of experiment 1, where every reading
        up to the ring's maximum range may vouch; 60 mm is the target distance of section 6.3.
        """
        return cls(0.02, 0.15, ring.range_max_m, 0.06)

    @classmethod
    def thesis_openings(cls, ring: SonarRing = AMIGOBOT) -> HsrParams:
        """Return the thesis's setting for rooms with openings: walls of 10 to 80 mm, up to 0.8 m.

        Section 6.4.2 (experiment 2): longer walls close doors of 0.8 m, and only readings taken
        nearer than that to an opening are sure to see it.
        """
        return cls(0.01, 0.08, min(OPENINGS_THRESHOLD_M, ring.range_max_m), 0.06)


@dataclass(frozen=True, eq=False)
class HsrResult:
    """What HSR made of a log of n readings.

    Parameters
    ----------
    log : SonarLog
        The log with the updated readings, otherwise as it was; its provenance tells the
        parameters under ``hsr``, a list with one entry a run.
    updated : ndarray of bool, shape (n,)
        Which readings differ from the original.
    updates_per_pass : tuple of int
        Readings changed by each pass that was kept. The first is always kept.
    rejected_updates : int or None
        Readings that one more pass would have changed; that pass was not kept. None when no
        more pass was tried: the first one changed nothing, or there were `max_passes`.
    stopped : HsrStop
        Why the pass after the last kept one was not kept, or not made.
    """

    log: SonarLog
    updated: NDArray[np.bool_]
    updates_per_pass: tuple[int, ...]
    rejected_updates: int | None
    stopped: HsrStop


@dataclass(frozen=True)
class Hsr:
    """HSR as a reading filter; the defaults are those of `HsrParams.thesis_openings`.

    The thesis's setting of its closed room (`HsrParams.thesis`) spoils right readings and closes
    doors wherever there are openings.

    Parameters
    ----------
    min_wall_m, max_wall_m, threshold_m, target_distance_m, cell_m, max_passes
        See `HsrParams`. A `threshold_m` of None is 0.8 m, or the ring's maximum range if less.
    """

    name: ClassVar[str] = "hsr"
    source: ClassVar[str] = "Rashid 2006, chapter 6 and appendix A."

    min_wall_m: float = 0.01
    max_wall_m: float = 0.08
    threshold_m: float | None = None
    target_distance_m: float = 0.06
    cell_m: float = 0.01
    max_passes: int = 20

    def __post_init__(self) -> None:
        self.params(AMIGOBOT)  # its rules are the parameters'

    def params(self, ring: SonarRing) -> HsrParams:
        """Return the parameters for a ring."""
        chosen = asdict(self)
        if self.threshold_m is None:
            chosen["threshold_m"] = min(OPENINGS_THRESHOLD_M, ring.range_max_m)
        return HsrParams(**chosen)

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log as HSR mends it; the report is the `HsrResult`.

        A log in which no reading may vouch for a wall stays as it is, with no report.
        """
        params = self.params(log.ring)
        if not _vouching(_taking_part(log), params).any():
            return Filtered(log, np.zeros(len(log), bool))
        result = hsr(log, params)
        predicted_m = np.where(result.updated, result.log.range_m, np.nan)
        return Filtered(result.log, result.updated, predicted_m, None, result)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched; ``wall_growth_m`` is `max_wall_m` less `min_wall_m`."""
        return {
            "min_wall_m": Real(0.0, 0.2),
            "wall_growth_m": Real(0.0, 0.4),
            # Below 0.2 m no reading of a normal drive vouches for anything: HSR is off.
            "threshold_m": Real(0.2, AMIGOBOT.range_max_m),
            "target_distance_m": Real(0.0, 0.5),
        }

    @classmethod
    def at(cls, point: Mapping[str, float]) -> Hsr:
        """Return the filter that a point of `space` stands for."""
        others: dict[str, Any] = dict(point)
        if "wall_growth_m" in others:
            shortest_m = others.get("min_wall_m", cls.min_wall_m)
            others["max_wall_m"] = shortest_m + others.pop("wall_growth_m")
        return cls(**others)


@dataclass(frozen=True, eq=False)
class EstimatedWalls:
    """ES, the paper's map of positions, readings and estimated walls.

    Parameters
    ----------
    grid : GridSpec
        Where the cells are.
    marks : ndarray of uint8, shape (rows, cols)
        A `Mark` each.
    """

    grid: GridSpec
    marks: NDArray[np.uint8]


def hsr(log: SonarLog, params: HsrParams) -> HsrResult:
    """Run HSR pass by pass until a pass is not worth keeping: ``runHSR`` of the paper.

    Parameters
    ----------
    log : SonarLog
        The readings, at the poses of odometry; it stays as it is.
    params : HsrParams
        The parameters.

    Returns
    -------
    HsrResult

    Raises
    ------
    InputError
        If the threshold is above the ring's maximum range, no reading is within it, or ES would
        have too many cells.
    """
    _check(log, params)
    firings = _Firings.of(log)
    before_m = _taking_part(log)
    range_m = _one_pass(firings, before_m, params)
    kept = [_changes(before_m, range_m)]
    rejected: int | None = None
    stopped = HsrStop.MAX_PASSES if kept[0] else HsrStop.NOTHING_CHANGED
    while kept[-1] and len(kept) < params.max_passes:
        next_m = _one_pass(firings, range_m, params)
        changes = _changes(range_m, next_m)
        reason = _reason_to_stop(changes, kept)
        if reason is not None:
            rejected, stopped = changes, reason
            break
        kept.append(changes)
        range_m = next_m

    updated = range_m != before_m
    updated.flags.writeable = False
    range_m = np.where(updated, range_m, log.range_m)
    runs = [*log.provenance.get("hsr", []), {**asdict(params), "updates_per_pass": kept}]
    return HsrResult(
        log=log.replace(range_m=range_m, provenance={**log.provenance, "hsr": runs}),
        updated=updated,
        updates_per_pass=tuple(kept),
        rejected_updates=rejected,
        stopped=stopped,
    )


def estimate_variant_walls(log: SonarLog, params: HsrParams) -> EstimatedWalls:
    """Return ES as the first pass of `hsr` over a log sees it (steps 1 and 2, figure 6.6).

    Raises
    ------
    InputError
        As `hsr`.
    """
    _check(log, params)
    firings = _Firings.of(log)
    range_m = _taking_part(log)
    points_m = _process_readings(firings, range_m)
    return _estimate_variant_walls(firings, range_m, points_m, params)


@dataclass(frozen=True, eq=False)
class _Firings:
    """What no pass changes: positions (n, 2) and unit vectors of the axes (n, 2)."""

    ring: SonarRing
    robot_xy_m: NDArray[np.float64]
    sensor_xy_m: NDArray[np.float64]
    along: NDArray[np.float64]

    @classmethod
    def of(cls, log: SonarLog) -> _Firings:
        axis = log.axis_rad
        return cls(
            log.ring,
            np.column_stack([log.x_m, log.y_m]),
            log.sensor_xy_m,
            np.column_stack([np.cos(axis), np.sin(axis)]),
        )


def _one_pass(
    firings: _Firings, range_m: NDArray[np.float64], params: HsrParams
) -> NDArray[np.float64]:
    """Return the readings after one pass: ``HSR`` of the paper."""
    # Step 1: processing sensor readings.
    points_m = _process_readings(firings, range_m)
    # Step 2: estimating variant walls.
    es = _estimate_variant_walls(firings, range_m, points_m, params)
    # Step 3: finding and updating specularly reflected readings.
    return _update(firings, range_m, points_m, es, params)


def _process_readings(firings: _Firings, range_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the data points, metres, shape (n, 2); NaN for a reading that takes no part."""
    reach_m = np.where(range_m == np.inf, max(NO_ECHO_M, firings.ring.range_max_m), range_m)
    reach_m[range_m == -np.inf] = np.nan
    points_m: NDArray[np.float64] = firings.sensor_xy_m + reach_m[:, None] * firings.along
    return points_m


def _estimate_variant_walls(
    firings: _Firings,
    range_m: NDArray[np.float64],
    points_m: NDArray[np.float64],
    params: HsrParams,
) -> EstimatedWalls:
    from sonarmap.kernels.hsr import mark_lines, mark_points  # numba: loaded when needed

    vouching = _vouching(range_m, params)
    points_m = points_m[vouching]
    half_m = _wall_length_m(range_m[vouching], firings.ring, params) / 2
    across = firings.along[vouching, ::-1] * [-1, 1]
    begins_m = points_m - half_m[:, None] * across
    ends_m = points_m + half_m[:, None] * across

    grid = _grid_over([firings.robot_xy_m, firings.sensor_xy_m, points_m, begins_m, ends_m], params)
    where = (*grid.origin_xy_m, grid.resolution_m)
    marks = np.zeros(grid.shape, np.uint8)
    mark_lines(marks, *where, begins_m, ends_m, Mark.WALL.value)
    mark_points(marks, *where, points_m, Mark.READING.value)
    mark_points(marks, *where, firings.robot_xy_m, Mark.POSITION.value)
    mark_points(marks, *where, firings.sensor_xy_m, Mark.POSITION.value)
    return EstimatedWalls(grid, marks)


def _update(
    firings: _Firings,
    range_m: NDArray[np.float64],
    points_m: NDArray[np.float64],
    es: EstimatedWalls,
    params: HsrParams,
) -> NDArray[np.float64]:
    """Return the readings, shortened where a mark stands in their way: ``upDate``."""
    from sonarmap.kernels.hsr import king_distance, search_readings

    updated_m = range_m.copy()
    search_readings(
        king_distance(es.marks, Mark.WALL.value, Mark.READING.value),
        *es.grid.origin_xy_m,
        es.grid.resolution_m,
        firings.sensor_xy_m,
        points_m,
        firings.ring.range_max_m,
        params.target_distance_m,
        updated_m,
    )
    return updated_m


def _wall_length_m(
    range_m: NDArray[np.float64], ring: SonarRing, params: HsrParams
) -> NDArray[np.float64]:
    """Return the length of the estimated wall of readings, metres (appendix A)."""
    share = (range_m - ring.range_min_m) / (ring.range_max_m - ring.range_min_m)
    length_m = params.min_wall_m + (params.max_wall_m - params.min_wall_m) * share
    return np.maximum(length_m, 0.0)


def _grid_over(places_m: list[NDArray[np.float64]], params: HsrParams) -> GridSpec:
    # A cell of margin keeps the places on the right and upper border inside.
    x_min, y_min = np.min([xy.min(axis=0) for xy in places_m], axis=0) - params.cell_m
    x_max, y_max = np.max([xy.max(axis=0) for xy in places_m], axis=0) + params.cell_m
    try:
        return GridSpec.covering(
            float(x_min), float(y_min), float(x_max), float(y_max), params.cell_m
        )
    except InputError as error:
        raise InputError(f"cell_m is too small for a log this wide: {error}") from None


def _taking_part(log: SonarLog) -> NDArray[np.float64]:
    """Return the readings, metres; those that take no part are taken for too close."""
    return np.where(log.usable, log.range_m, -np.inf)


def _vouching(range_m: NDArray[np.float64], params: HsrParams) -> NDArray[np.bool_]:
    """Return which readings are marked on ES with their walls."""
    vouching: NDArray[np.bool_] = (range_m >= 0) & (range_m <= params.threshold_m)
    return vouching


def _check(log: SonarLog, params: HsrParams) -> None:
    if params.threshold_m > log.ring.range_max_m:
        raise InputError(
            f"threshold_m must be <= the ring's range_max_m {log.ring.range_max_m:g}, "
            f"got {params.threshold_m!r}"
        )
    if params.cell_m >= log.ring.range_max_m:
        raise InputError(
            f"cell_m must be < the ring's range_max_m {log.ring.range_max_m:g}, "
            f"got {params.cell_m!r}"
        )
    if not _vouching(_taking_part(log), params).any():
        raise InputError(
            f"the log must have a reading up to threshold_m {params.threshold_m!r}, got none "
            f"in {len(log)} readings"
        )


def _reason_to_stop(changes: int, kept: list[int]) -> HsrStop | None:
    """Return why a pass with that many changes is not kept, None if it is."""
    if changes == 0:
        return HsrStop.NOTHING_CHANGED
    if changes <= LEAST_SHARE * kept[0]:
        return HsrStop.TOO_FEW
    if changes >= kept[-1]:
        return HsrStop.NOT_LESS
    return None


def _changes(before: NDArray[np.float64], after: NDArray[np.float64]) -> int:
    return int((before != after).sum())
