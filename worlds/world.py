"""`World`: a known room as a value, closed under rigid motions and mirroring."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from worlds.checks import check_free, check_inside, check_solids, checked_bounds, finite_numbers
from worlds.faces import Faces
from worlds.materials import Material
from worlds.solids import Solid

__all__ = ["Pose", "World"]

_QUARTER_TURN = ((0, -1), (1, 0))
_MIRROR = ((1, 0), (0, -1))


@dataclass(frozen=True, slots=True)
class Pose:
    """A place and a heading, counter-clockwise from the x axis."""

    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True)
class World:
    """A known room; readers make it by `of`, which checks it.

    Parameters
    ----------
    name, title, source : str
        Name of its file, a title for people, and where the room is described.
    bounds_m : tuple of float
        (x_min, y_min, x_max, y_max) of the part of the plane that matters.
    start : Pose
        Where the robot stands when a drive begins.
    route_m : tuple of (x, y)
        Way points that a driver may follow; may be empty.
    solids : tuple of Solid
        What stands in it; from a TOML file walls, then boxes, then pillars, each in the order of
        the file.
    notes : mapping of str to str
        What is assumed of a number or where it comes from, by the number's place in the file,
        such as ``wall[0].thickness_m``.
    parameters : mapping of str to float
        The values with which the room's formulas were computed.
    """

    name: str
    title: str
    source: str
    bounds_m: tuple[float, float, float, float]
    start: Pose
    route_m: tuple[tuple[float, float], ...]
    solids: tuple[Solid, ...]
    notes: Mapping[str, str] = field(hash=False)
    parameters: Mapping[str, float] = field(hash=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", MappingProxyType(dict(self.notes)))
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))

    @classmethod
    def of(
        cls,
        name: str,
        solids: Iterable[Solid],
        *,
        bounds_m: Sequence[float],
        start: Pose | Sequence[float],
        route_m: Iterable[Sequence[float]] = (),
        title: str | None = None,
        source: str = "",
        notes: Mapping[str, str] | None = None,
        parameters: Mapping[str, float] | None = None,
        places: Sequence[str] | None = None,
    ) -> World:
        """Return a world that keeps the rules of every room: what a world reader ends with.

        Parameters
        ----------
        name : str
            What it is called, as a rule the stem of its file.
        solids : iterable of Solid
            What stands in it, see `Solid.wall`, `Solid.box`, `Solid.pillar`, `Solid.polygon`.
        bounds_m : sequence of float
            (x_min, y_min, x_max, y_max) in metres.
        start : Pose or sequence of float
            Where the robot begins: (x, y, heading) in metres and radians.
        route_m : iterable of (x, y)
            Way points in metres.
        title, source : str
            A title for people, by default the name; where the room is described.
        notes : mapping of str to str, optional
            What is assumed of a number, by its place in the file.
        parameters : mapping of str to float, optional
            The values of the room's parameters.
        places : sequence of str, optional
            What messages call each solid, such as ``wall[0]``; by default ``solids[0]`` and on.

        Raises
        ------
        InputError
            If a number is not finite, the bounds are out of order, two solids have one name, one
            lies wholly outside of the bounds, or the start or a way point lies outside of them or
            inside of a solid; the message is ``place: rule``.

        Examples
        --------
        >>> box = Solid.box("desk", (2, 1), (1.6, 0.8), height_m=0.7, material="wood")
        >>> World.of("my room", [box], bounds_m=(0, 0, 4, 3), start=(1, 2, 0)).title
        'my room'
        """
        solids = tuple(solids)
        if places is None:
            places = [f"solids[{i}]" for i in range(len(solids))]
        bounds = checked_bounds(bounds_m)
        pose = _pose(start)
        route = tuple(_point(f"route_m[{i}]", point) for i, point in enumerate(route_m))
        check_solids(solids, places)
        check_inside(solids, places, bounds)
        check_free("start", (pose.x_m, pose.y_m), solids, bounds)
        for i, point in enumerate(route):
            check_free(f"route_m[{i}]", point, solids, bounds)
        title = name if title is None else title
        return cls(name, title, source, bounds, pose, route, solids, notes or {}, parameters or {})

    def __reduce__(self) -> tuple[Any, ...]:
        # A mapping proxy does not pickle, and a world must reach the processes of a parallel run.
        fields = (self.name, self.title, self.source, self.bounds_m, self.start, self.route_m)
        return World, (*fields, self.solids, dict(self.notes), dict(self.parameters))

    @cached_property
    def faces(self) -> Faces:
        """The surfaces that sound can meet, ready for casting rays."""
        return Faces.of((solid.outline, solid.circle, solid.name) for solid in self.solids)

    @cached_property
    def critical_incidence_rad(self) -> NDArray[np.float64]:
        """Critical incidence angle of each solid's material, radians, shape (solids,)."""
        return np.array([solid.material.critical_incidence_rad for solid in self.solids])

    @cached_property
    def reflectivity(self) -> NDArray[np.float64]:
        """Reflectivity of each solid's material, shape (solids,)."""
        return np.array([solid.material.reflectivity for solid in self.solids])

    @cached_property
    def roughness_m(self) -> NDArray[np.float64]:
        """Roughness of each solid's material, metres, shape (solids,)."""
        return np.array([solid.material.roughness_m for solid in self.solids])

    @cached_property
    def diffuse_floor_db(self) -> NDArray[np.float64]:
        """Diffuse floor of each solid's material, decibels, shape (solids,)."""
        return np.array([solid.material.diffuse_floor_db for solid in self.solids])

    @cached_property
    def radius_m(self) -> NDArray[np.float64]:
        """Radius of each pillar, 0 of a solid with flat faces, metres, shape (solids,)."""
        return np.array([solid.circle[2] if solid.circle else 0.0 for solid in self.solids])

    def has_room_at(self, x_m: float, y_m: float, *, radius_m: float) -> bool:
        """Return whether a disc of a radius fits at a place without meeting a solid."""
        from worlds.raycast import clearance  # numba is heavy: loaded when it is needed

        if clearance(self.faces.table, 0, x_m, y_m, radius_m)[0] < radius_m:
            return False
        # A place deep inside of a solid is far from every face, too.
        place = shapely.Point(x_m, y_m)
        return not any(solid.outline.contains(place) for solid in self.solids)

    def with_materials(self, materials: Sequence[Material]) -> World:
        """Return the world with other materials, one a solid; its faces stay the same value."""
        solids = tuple(
            replace(solid, material=material)
            for solid, material in zip(self.solids, materials, strict=True)
        )
        changed = replace(self, solids=solids)
        # What is computed from the shapes alone need not be computed again.
        changed.__dict__["faces"] = self.faces
        return changed

    def transformed(self, *, quarter_turns: int) -> World:
        """Return the world turned about the origin, counter-clockwise by right angles.

        Coordinates are only swapped and negated, so nothing is lost to rounding.
        """
        turns = quarter_turns % 4
        matrix = np.linalg.matrix_power(np.array(_QUARTER_TURN), turns)
        turned = math.remainder(self.start.heading_rad + turns * math.pi / 2, math.tau)
        return self._placed(matrix, heading_rad=turned)

    def placed(self, pose: Pose) -> World:
        """Return the world as it is seen from outside when its frame lies at a pose there.

        Its bounds become the smallest that hold the former ones.
        """
        cos, sin = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
        heading_rad = math.remainder(self.start.heading_rad + pose.heading_rad, math.tau)
        matrix = np.array([[cos, -sin], [sin, cos]])
        return self._placed(matrix, heading_rad=heading_rad, shift_m=(pose.x_m, pose.y_m))

    def mirrored(self) -> World:
        """Return the world mirrored at the x axis: y becomes -y, left becomes right."""
        return self._placed(np.array(_MIRROR), heading_rad=-self.start.heading_rad)

    def _placed(
        self,
        matrix: NDArray[Any],
        *,
        heading_rad: float,
        shift_m: tuple[float, float] = (0.0, 0.0),
    ) -> World:
        def moved(x_m: float, y_m: float) -> tuple[float, float]:
            x, y = (matrix @ (x_m, y_m) + shift_m).tolist()
            return x, y

        def moved_solid(solid: Solid) -> Solid:
            outline = shapely.transform(solid.outline, lambda xy: xy @ matrix.T + shift_m)
            circle = None
            if solid.circle is not None:
                circle = (*moved(*solid.circle[:2]), solid.circle[2])
            return replace(solid, outline=outline, circle=circle)

        left, bottom, right, top = self.bounds_m
        corners = np.array([moved(x_m, y_m) for x_m in (left, right) for y_m in (bottom, top)])
        x_min, y_min = corners.min(axis=0).tolist()
        x_max, y_max = corners.max(axis=0).tolist()
        return replace(
            self,
            bounds_m=(x_min, y_min, x_max, y_max),
            start=Pose(*moved(self.start.x_m, self.start.y_m), heading_rad),
            route_m=tuple(moved(*point) for point in self.route_m),
            solids=tuple(moved_solid(solid) for solid in self.solids),
        )


def _pose(start: Pose | Sequence[float]) -> Pose:
    values = (start.x_m, start.y_m, start.heading_rad) if isinstance(start, Pose) else start
    return Pose(*finite_numbers("start", values, "[x, y, heading]"))


def _point(place: str, values: Sequence[float]) -> tuple[float, float]:
    x_m, y_m = finite_numbers(place, values, "[x, y]")
    return x_m, y_m
