"""Outlines of walls, boxes and pillars: from what is drawn in a file to exact polygons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import shapely
from shapely import LineString, Polygon

from sonarmap.errors import InputError

__all__ = ["Point", "box_outline", "pillar_outline", "polygon_outline", "wall_outline"]

Point = tuple[float, float]

# Segments of a quarter circle. The outline only serves drawing and distances to people's eyes:
# it stays within 0.02 % of the radius; casting and the truth use the exact circle.
_QUARTER_SEGMENTS = 32


def wall_outline(
    points_m: Sequence[Point], *, closed: bool, thickness_m: float, side: str
) -> Polygon:
    """Return the polygon of a wall: flat ends, corners drawn out to a point.

    Parameters
    ----------
    points_m : sequence of (x, y)
        The line as it is drawn; a closed one does not repeat its first point.
    closed : bool
        Whether the last point is joined to the first.
    thickness_m : float
        Thickness of the wall, > 0.
    side : {"centre", "left", "right"}
        Where the thickness lies, seen along the line as it is drawn. On the left or right the
        drawn line itself is one face of the wall, exactly.

    Raises
    ------
    InputError
        If the line has too few points, a part without length, crosses itself, or bends more
        sharply than its thickness allows.
    """
    _check_line(points_m, closed=closed)
    if closed:
        outline = _ring(Polygon(points_m), thickness_m=thickness_m, side=side)
    else:
        line = LineString(points_m)
        if side == "centre":
            outline = line.buffer(thickness_m / 2, cap_style="flat", join_style="mitre")
        else:
            offset_m = thickness_m if side == "left" else -thickness_m
            outline = line.buffer(offset_m, single_sided=True, join_style="mitre")
    if not (isinstance(outline, Polygon) and outline.is_valid and not outline.is_empty):
        raise InputError(f"a wall {thickness_m:g} m thick cannot follow this line")
    return outline


def box_outline(centre_m: Point, *, length_m: float, width_m: float, heading_rad: float) -> Polygon:
    """Return the rectangle of a box, its length along the heading."""
    # Right angles are exact, so that a box along the walls has faces along the walls.
    quarter = heading_rad / (math.pi / 2)
    if quarter == round(quarter):
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
    else:
        cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    corners = []
    for ahead, left in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
        dx, dy = ahead * length_m, left * width_m
        corners.append((centre_m[0] + cos * dx - sin * dy, centre_m[1] + sin * dx + cos * dy))
    return Polygon(corners)


def pillar_outline(centre_m: Point, *, radius_m: float) -> Polygon:
    """Return a polygon inscribed in the circle of a pillar."""
    outline: Polygon = shapely.Point(centre_m).buffer(radius_m, quad_segs=_QUARTER_SEGMENTS)
    return outline


def polygon_outline(points_m: Sequence[Point], holes_m: Sequence[Sequence[Point]]) -> Polygon:
    """Return the polygon of `points_m`, less those of `holes_m`.

    Raises
    ------
    InputError
        If a ring has too few points or crosses itself, or a hole is not wholly inside.
    """
    for points in (points_m, *holes_m):
        if len(points) < 3:
            raise InputError(f"points_m: a polygon needs at least 3 points, got {len(points)}")
    outline = Polygon(points_m, holes_m)
    if not outline.is_valid or outline.area == 0:
        raise InputError(f"points_m: no polygon: {shapely.is_valid_reason(outline)}")
    return outline


def _ring(area: Polygon, *, thickness_m: float, side: str) -> Polygon | None:
    outwards = "right" if area.exterior.is_ccw else "left"
    if side == "centre":
        outer, inner = _grown(area, thickness_m / 2), _grown(area, -thickness_m / 2)
    elif side == outwards:
        outer, inner = _grown(area, thickness_m), area
    else:
        outer, inner = area, _grown(area, -thickness_m)
    if outer is None or inner is None:
        return None
    # Growing a horseshoe may close its mouth: what it then holds is a hole as well.
    return Polygon(outer.exterior, [inner.exterior, *outer.interiors])


def _grown(area: Polygon, distance_m: float) -> Polygon | None:
    grown = area.buffer(distance_m, join_style="mitre")
    return grown if isinstance(grown, Polygon) and not grown.is_empty else None


def _check_line(points_m: Sequence[Point], *, closed: bool) -> None:
    fewest = 3 if closed else 2
    if len(points_m) < fewest:
        kind = "a closed wall" if closed else "a wall"
        raise InputError(f"{kind} needs at least {fewest} points, got {len(points_m)}")
    line = [*points_m, points_m[0]] if closed else list(points_m)
    for i, (here, there) in enumerate(pairwise(line)):
        if here == there:
            j = (i + 1) % len(points_m)
            raise InputError(f"zero length: points {i} and {j} are both [{here[0]:g}, {here[1]:g}]")
    if not LineString(line).is_simple:
        raise InputError(f"the wall crosses itself{_first_crossing(line)}")


def _first_crossing(line: Sequence[Point]) -> str:
    parts = [LineString(ends) for ends in pairwise(line)]
    for i, first in enumerate(parts):
        for j in range(i + 1, len(parts)):
            shared = first.intersection(parts[j])
            # Neighbours share a point; only a fold makes them share a length.
            neighbours = j == i + 1 or (line[0] == line[-1] and i == 0 and j == len(parts) - 1)
            if not shared.is_empty and not (neighbours and shared.length == 0):
                at = shared.representative_point()
                return f" at [{at.x:g}, {at.y:g}]"
    return ""
