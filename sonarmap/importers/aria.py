"""Tables of the kind that programs with ARIA write: one CSV row a scan, mm and degrees."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sonarmap.errors import InputError, did_you_mean, positive
from sonarmap.importers.protocol import FileImporter

if TYPE_CHECKING:
    from sonarmap.log import SonarLog
    from sonarmap.rings import SonarRing

__all__ = ["ARIA", "read_aria"]

# ARIA's ArSonarDevice reports its maximum range when it hears nothing.
NO_ECHO_MM = 5000
# A robot under ARIA reports once in this time (its server information packet).
PACKET_PERIOD_S = 0.1
_PER_SECOND = {"time_s": 1, "time_ms": 1000}
_POSE = ("x", "y", "heading")


def read_aria(
    path: str | Path, ring: SonarRing, *, scan_period_s: float = PACKET_PERIOD_S
) -> SonarLog:
    """Read a CSV table of scans with a header.

    Parameters
    ----------
    path : str or Path
        Columns in any order: ``x``, ``y`` (mm), ``heading`` (degrees, counter-clockwise), ``s0``,
        ``s1`` ... for each sonar of the ring (mm), and at most one of ``time_s``, ``time_ms``.
    ring : SonarRing
        The sonars. 5000 and readings that are not nearer than its maximum range become no echo,
        those nearer than its minimum too close.
    scan_period_s : float
        Time between two rows where the table has no column of times, > 0.

    Returns
    -------
    SonarLog
        Every reading has its row's time and pose. The heading is unwrapped: it runs on where the
        file jumps by a turn.

    Raises
    ------
    InputError
        If the file breaks a rule. Unknown columns do, as a misspelt one would be lost unnoticed.
    """
    import numpy as np

    from sonarmap.importers.table import Table, csv_rows, log_of, ranges_m, unwrapped_rad

    path = Path(path)
    period_s = positive("scan_period_s", scan_period_s)
    sonars = [f"s{i}" for i in range(len(ring))]
    (line, header), *rows = csv_rows(path)
    columns = [name.lower() for name in header]
    time = _check_header(f"{path}:{line}", columns, ring, sonars)
    table = Table.of(path, columns, rows)
    provenance: dict[str, object] = {"source": "aria", "files": [path.name]}
    if time is None:
        time_s = np.arange(len(rows), dtype=np.float64) * period_s
        provenance["scan_period_s"] = period_s
    else:
        time_s = table.times_s(time, _PER_SECOND[time])
    return log_of(
        ring,
        time_s,
        (table.column("x") / 1000, table.column("y") / 1000),
        unwrapped_rad(table.column("heading")),
        ranges_m(table, sonars, ring, NO_ECHO_MM),
        provenance,
    )


def _check_header(
    place: str, columns: Sequence[str], ring: SonarRing, sonars: Sequence[str]
) -> str | None:
    """Return the name of the column of times, None if there is none."""
    known = (*_PER_SECOND, *_POSE, *sonars)
    for name in columns:
        if name not in known:
            # Most often the ring is the wrong one.
            hint = (
                f": ring {ring.name!r} has s0 to {sonars[-1]}"
                if re.fullmatch(r"s\d+", name)
                else did_you_mean(name, known)
            )
            raise InputError(f"{place}: column {name!r} is unknown{hint}")
        if columns.count(name) > 1:
            raise InputError(f"{place}: column {name!r} must be there once")
    for name in (*_POSE, *sonars):
        if name not in columns:
            whose = f": ring {ring.name!r} has s0 to {sonars[-1]}" if name in sonars else ""
            raise InputError(f"{place}: column {name!r} is missing{whose}")
    times = [name for name in columns if name in _PER_SECOND]
    if len(times) > 1:
        raise InputError(f"{place}: must have one column of times, got {' and '.join(times)}")
    return times[0] if times else None


ARIA = FileImporter(
    "aria",
    ("a CSV table",),
    read_aria,
    about="of x, y, heading, s0, ...",
    ring_needed="amigobot-aria",
)
