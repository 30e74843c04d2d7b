"""The log format of Udacity's occupancy grid course: two files of numbers, row by row in step."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sonarmap.errors import InputError
from sonarmap.importers.protocol import FileImporter

if TYPE_CHECKING:
    from sonarmap.importers.table import Table
    from sonarmap.log import SonarLog
    from sonarmap.rings import SonarRing

__all__ = ["UDACITY", "read_udacity"]

# In RoboND-OccupancyGridMappingAlgorithm's measurement.txt a third of the readings is this.
NO_ECHO_MM = 5110


def read_udacity(
    measurement_path: str | Path, poses_path: str | Path, ring: SonarRing | None = None
) -> SonarLog:
    """Read a log of RoboND-OccupancyGridMappingAlgorithm.

    Parameters
    ----------
    measurement_path : str or Path
        Rows of time in ms and one range in mm for each sonar. 5110 is no echo.
    poses_path : str or Path
        Rows of the same times in ms, x and y in mm, heading in 0.1 degree.
    ring : SonarRing, optional
        The sonars; the preset ``udacity8`` by default. Readings that are not nearer than its
        maximum range become no echo, those nearer than its minimum too close.

    Returns
    -------
    SonarLog
        Every reading has its row's time and pose. The heading is unwrapped: it runs on where the
        file jumps between 3600 and 0.

    Raises
    ------
    InputError
        If a file breaks a rule or the times of the two differ.

    Notes
    -----
    The original log's sonars fire one after another, and rows repeat what has not been measured
    again: see `sonarmap.mark_stale`.
    """
    from sonarmap.importers.table import Table, log_of, ranges_m, unwrapped_rad, word_rows
    from sonarmap.rings import ring as ring_called

    measurement_path, poses_path = Path(measurement_path), Path(poses_path)
    ring = ring_called("udacity8") if ring is None else ring
    sonars = [f"s{i}" for i in range(len(ring))]
    readings = Table.of(measurement_path, ["time_ms", *sonars], word_rows(measurement_path))
    poses = Table.of(poses_path, ["time_ms", "x", "y", "heading"], word_rows(poses_path))
    time_s = readings.times_s("time_ms", per_second=1000)
    range_m = ranges_m(readings, sonars, ring, NO_ECHO_MM)
    _check_in_step(readings, poses)
    return log_of(
        ring,
        time_s,
        (poses.column("x") / 1000, poses.column("y") / 1000),
        unwrapped_rad(poses.column("heading") / 10),
        range_m,
        {"source": "udacity", "files": [measurement_path.name, poses_path.name]},
    )


def _check_in_step(readings: Table, poses: Table) -> None:
    common = min(len(readings.lines), len(poses.lines))
    times, pose_times = readings.column("time_ms"), poses.column("time_ms")
    differ = times[:common] != pose_times[:common]
    if differ.any():
        row = int(differ.argmax())
        raise InputError(
            f"{poses.path}:{poses.lines[row]}: time_ms: must be that of "
            f"{readings.path}:{readings.lines[row]}, {times[row]:.15g}, "
            f"got {pose_times[row]:.15g}"
        )
    for longer, shorter in ((readings, poses), (poses, readings)):
        if len(longer.lines) > common:
            raise InputError(
                f"{longer.path}:{longer.lines[common]}: time_ms: must have its like in "
                f"{shorter.path}, which ends at line {shorter.lines[-1]}, "
                f"got {longer.column('time_ms')[common]:.15g}"
            )


UDACITY = FileImporter("udacity", ("measurement.txt", "poses.txt"), read_udacity)
